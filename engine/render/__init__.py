"""Images on the CPU: direct light, transported light and the path-traced reference."""
