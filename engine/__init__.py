"""Lightarc's numerical engine: photographs in, materials and images out. Knows nothing of Qt or of `app`."""

__version__ = "0.1.0"
