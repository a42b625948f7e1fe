"""A sentence for C++ libraries that run out of memory or threads outside the reach of Python's exceptions.

Their exceptions (`std::bad_alloc`, `std::system_error`) end the process through `std::terminate`, without a word that a
user understands. On Linux most of them share one libstdc++, which lets a program say something first. It runs in the
thread that failed, in which nothing can be cleaned up: what was half-written is removed by the next write.
"""

from __future__ import annotations

import ctypes
import os
import sys
from typing import Any, NoReturn

_kept: list[Any] = []


def leave_last_words(sentence: str, exit_code: int) -> None:
    """From now on print `sentence` and end with `exit_code` where C++ would abort; elsewhere than on Linux nothing."""
    if sys.platform != "linux" or _kept:
        return
    try:
        set_terminate = ctypes.CDLL("libstdc++.so.6")["_ZSt13set_terminatePFvvE"]
    except (OSError, AttributeError):
        return

    def end() -> NoReturn:
        os.write(2, f"{sentence}\n".encode())
        os._exit(exit_code)

    _kept.append(ctypes.CFUNCTYPE(None)(end))
    set_terminate.argtypes, set_terminate.restype = [ctypes.c_void_p], ctypes.c_void_p
    set_terminate(ctypes.cast(_kept[0], ctypes.c_void_p))
