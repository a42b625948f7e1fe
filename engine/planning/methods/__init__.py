"""The part of a plan that each transport method gives: its costs and its error."""
