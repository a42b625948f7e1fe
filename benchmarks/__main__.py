"""Run the benchmarks of a checkout: `python -m benchmarks [--only NAME …] [--large] [--json]`."""

from __future__ import annotations

import sys

from app.command_line import main

if __name__ == "__main__":
    sys.exit(main(["bench", *sys.argv[1:]]))
