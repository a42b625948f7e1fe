"""Triangle meshes: reading, repair, texture coordinates, built-in shapes, the camera and rays."""
