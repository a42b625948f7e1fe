"""Time and memory that a setting costs on this machine."""
