"""Precomputed radiance transfer in spherical Gaussians, for views around each vertex."""
