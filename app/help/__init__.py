"""Help beside the work: the manual, keys, the first hints, and which mode when."""
