"""A colour chart in a photograph: its patches, the correction of colours by them, and its quality."""
