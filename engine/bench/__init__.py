"""Benchmarks: each measures its own limit in the same run, so that results are ratios."""
