"""The Factor workspace: runs, projections, textures, errors."""
