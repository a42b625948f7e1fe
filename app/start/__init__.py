"""The start page: the projects of a user, examples that open at once, and starting points."""
