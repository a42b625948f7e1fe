"""Shading maps and their power-law compression (Kautz et al. 2004)."""
