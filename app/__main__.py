"""`lightarc` and `python -m app`."""

from __future__ import annotations

import os
import sys


def main() -> int:
    from app.cli import main as run

    try:
        try:
            return run()
        finally:
            sys.stdout.flush()
    except BrokenPipeError:
        # The reader has gone (`lightarc … | head`); what Python flushes at exit must not fail again.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0


if __name__ == "__main__":
    sys.exit(main())
