"""A virtual light arc that photographs a known material."""
