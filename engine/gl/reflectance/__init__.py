"""Reflectance that a user writes in GLSL, evaluated in a confined process of its own."""
