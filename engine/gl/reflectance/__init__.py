"""Reflectance that a person writes in GLSL, evaluated in a confined process of its own."""
