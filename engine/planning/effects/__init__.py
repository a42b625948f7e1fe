"""The contribution of each effect of light to a scene, and the error of each method without a bake."""
