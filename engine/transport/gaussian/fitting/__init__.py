"""Spherical Gaussian lobes fitted to the transfer of each vertex and view."""
