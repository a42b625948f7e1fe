"""Linear algebra on one thread: sums are taken in one order on any machine, and no thread waits for another.

The threads of BLAS wait actively. On CPUs that are busy otherwise, many small systems then take ten times as long
as on one thread. The limit belongs to the whole process: whoever comes first sets it and whoever leaves last lifts it.
"""

from __future__ import annotations

import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache
from typing import Any

from threadpoolctl import ThreadpoolController

_lock = threading.Lock()
_users = 0
_limit: Any = None


@lru_cache(maxsize=1)
def _libraries(modules: int) -> ThreadpoolController:
    """The loaded libraries, which take some milliseconds to find: looked for anew when a module has come."""
    return ThreadpoolController()


@contextmanager
def one_thread() -> Iterator[None]:
    """While the block runs, BLAS and LAPACK take one thread each time they are called; calls may run side by side."""
    global _users, _limit
    with _lock:
        if _users == 0:
            _limit = _libraries(len(sys.modules)).limit(limits=1, user_api="blas")
        _users += 1
    try:
        yield
    finally:
        with _lock:
            _users -= 1
            if _users == 0:
                _limit.restore_original_limits()
