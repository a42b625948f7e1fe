"""Reflectance models; one file per family, one GLSL twin per model in resources/shaders/brdf."""
