"""The Export workspace: the bundle and its preview."""
