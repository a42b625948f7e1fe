"""Everything that touches OpenGL. Renderers take a context and a target, never a window."""
