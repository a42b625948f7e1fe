"""Light transport: what of the distant light arrives at each vertex, and how it leaves again."""
