"""The drawing surface: OpenGL or the CPU, refined while nothing moves."""
