"""`lightarc` and `python -m app`."""

from __future__ import annotations

import os
import signal
import sys

if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
    # Until `ending.watch` an interrupt ends the process as SIGTERM does, without a traceback of an import.
    signal.signal(signal.SIGINT, signal.SIG_DFL)

from app import ending


def main() -> int:
    ending.watch()
    from app.cli import main as run

    try:
        try:
            code = run()
        finally:
            sys.stdout.flush()
    except BrokenPipeError:
        # The reader has gone (`lightarc … | head`); what Python flushes at exit must not fail again.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    if ending.wished():
        ending.leave(code)
    return code


if __name__ == "__main__":
    sys.exit(main())
