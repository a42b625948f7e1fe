"""Hard cases that check a user's machine."""
