"""BRDFs as sums and products of textures: separable and homomorphic factorisation, and how far each is off."""
