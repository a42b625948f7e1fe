"""Materials as other programs take them, each with the error of leaving the shading map."""
