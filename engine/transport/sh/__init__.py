"""Precomputed radiance transfer in spherical harmonics."""
