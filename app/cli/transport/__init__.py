"""The verbs that bake, draw, plan and measure transport."""
