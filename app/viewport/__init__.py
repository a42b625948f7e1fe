"""The drawing surface: OpenGL or the processor, refined while nothing moves."""
