"""The error of one image against another, and how certain it is."""
