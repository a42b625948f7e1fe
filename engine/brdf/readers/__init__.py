"""Measured BRDFs from files: MERL, UTIA, RGL, CUReT, Cornell, ALTA and CSV."""
