"""Images with OpenGL, on the screen and off it."""
