"""The shading map, the power law fitted to it, their lookup, and tileable materials."""
