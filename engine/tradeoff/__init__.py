"""What accuracy costs: settings measured on one scene, which of them are worth their price, and which fits a budget."""
