"""How far pictures are from each other, and what that costs."""
