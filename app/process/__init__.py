"""The end of the process: on a signal, by a fault, and where a library finds no memory."""
