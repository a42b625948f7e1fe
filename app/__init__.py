"""Lightarc's window and command line. `engine` computes."""
