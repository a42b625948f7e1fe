"""The shading map, the power law fitted to it, their lookup and error, and tileable materials."""
