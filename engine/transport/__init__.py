"""Precomputed radiance transfer, per vertex: every method, and a bake relit by one light."""
