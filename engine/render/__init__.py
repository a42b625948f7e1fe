"""Rendering on the processor: the virtual light arc and the fallback for machines without OpenGL."""
