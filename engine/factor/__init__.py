"""A BRDF as products of textures: separable and homomorphic factorisation, with their errors."""
