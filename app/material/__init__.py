"""The Material workspace: the shading map and its texels."""
