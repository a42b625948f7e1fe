"""The figures of the papers, computed anew with their errors."""
