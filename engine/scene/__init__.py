"""A material and a scene: all that an image is computed from."""
