"""Arguments of the command line: files to read and to write, and exit codes."""
