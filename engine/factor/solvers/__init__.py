"""Least squares, singular values, direct search and rotations, which know nothing of a BRDF."""
