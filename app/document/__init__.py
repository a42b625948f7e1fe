"""The project that a person works on, as one immutable value, and its undo."""
