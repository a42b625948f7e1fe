"""`lightarc` and `python -m app`."""

from __future__ import annotations

import os
import signal
import sys
from typing import NoReturn

if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
    # Until `ending.watch` an interrupt ends the process as SIGTERM does, without a traceback of an import.
    signal.signal(signal.SIGINT, signal.SIG_DFL)

from app.process import ending


def main() -> NoReturn:
    ending.watch()
    from app.command_line import main as run

    try:
        try:
            code = run()
        finally:
            sys.stdout.flush()
    except BrokenPipeError:
        # The reader has gone (`lightarc … | head`); what Python flushes at exit must not fail again.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        code = 0
    ending.finish(code)


if __name__ == "__main__":
    main()
