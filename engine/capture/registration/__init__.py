"""The photographs of a capture laid on each other to a fraction of a pixel, and warped."""
