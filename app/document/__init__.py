"""The project that a user works on, as one immutable value, and its undo."""
