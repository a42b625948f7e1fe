"""Measurements of speed and error, each beside the limit that bounds it."""
