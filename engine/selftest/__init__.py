"""Hard cases that check a person's machine."""
