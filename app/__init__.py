"""Lightarc's window and command line. They show and ask; `engine` computes."""
