"""A material as other programs draw it, beside our own picture: the proof that an export arrives."""
