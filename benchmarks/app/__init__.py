"""The program measured from outside, in a process of its own."""
