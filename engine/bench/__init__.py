"""Measurements of capture, BRDFs, factorisation and light, each beside the limit that bounds it."""
