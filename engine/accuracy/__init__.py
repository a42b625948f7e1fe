"""The error of one picture against another, and how certain it is."""
