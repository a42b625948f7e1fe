"""Hard cases that are drawn by seed: laws of every part, and the smallest case that breaks one."""
