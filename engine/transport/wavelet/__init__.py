"""Precomputed radiance transfer in Haar wavelets on cube maps."""
