"""Settings of all methods measured on one scene: the front, budgets, and when a bake has paid off."""
