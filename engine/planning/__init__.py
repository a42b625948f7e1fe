"""The plan of a scene: which method and setting meets the error and the budget that a user asks for."""
