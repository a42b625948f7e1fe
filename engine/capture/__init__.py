"""From photographs to a linear, aligned stack, with a report of what is doubtful."""
