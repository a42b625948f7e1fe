"""A material as other programs draw it, beside our own image: the proof that an export arrives."""
