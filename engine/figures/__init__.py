"""The papers' figures as pictures, each panel with its error against the reference."""
