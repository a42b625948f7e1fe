"""The View workspace: the scene under light, drawn by each method beside its reference."""
