"""The command line, a file per verb: `add_arguments(parser)` declares it, `run(arguments)` does it."""
