"""Least squares, singular values, direct search, rotations and regions of directions, which know nothing of a BRDF."""
