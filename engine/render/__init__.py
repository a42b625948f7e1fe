"""Pictures on the processor: direct light, transported light and the path-traced reference."""
