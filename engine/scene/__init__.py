"""A material and a scene: all that a picture is computed from."""
