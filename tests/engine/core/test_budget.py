"""Threads and memory that a user allows."""

from __future__ import annotations

import mmap
import os
import subprocess
import sys

import numba
import numpy as np
import psutil
import pytest
from threadpoolctl import threadpool_info

from engine.core import budget
from engine.core.errors import UsageError


def test_threads_of_pools_and_libraries_are_limited_within_the_block(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "cpu_count", lambda: 6)
    before = dict(os.environ), budget.thread_count(), numba.get_num_threads()
    with budget.limit_threads(1):
        assert budget.thread_count() == numba.get_num_threads() == 1
        assert {each["num_threads"] for each in threadpool_info()} == {1}
        assert {os.environ[name] for name in budget.VARIABLES if name != "NUMBA_NUM_THREADS"} == {"1"}
    assert (dict(os.environ), budget.thread_count(), numba.get_num_threads()) == before
    with budget.limit_threads(64):
        assert budget.thread_count() == 6


@pytest.mark.skipif((os.cpu_count() or 1) < 2, reason="one processor has no number of threads to change")
@pytest.mark.parametrize("loaded", ["before", "within"])
def test_kernels_compile_within_and_after_a_limit_of_threads(loaded: str) -> None:
    """numba reads its variable whenever it compiles, and refuses another value than that of its threads."""
    code = """
import sys
from engine.core import budget

def run():
    import numba

    def add(count):
        total = 0
        for place in numba.prange(count):
            total += place
        return total

    assert numba.njit(add, parallel=True)(9) == 36

if sys.argv[1] == "before":
    run()
with budget.limit_threads(1):
    run()
run()
"""
    subprocess.run([sys.executable, "-c", code, loaded], check=True, timeout=300)


@pytest.mark.skipif(sys.platform != "linux", reason="other systems have no such limit")
def test_memory_beyond_the_limit_is_not_given() -> None:
    about = psutil.Process().memory_info()
    limit = about.rss - about.shared + (400 << 20)
    with budget.limit_memory(limit):
        assert budget.free_bytes() <= 400 << 20
        with pytest.raises(MemoryError):
            np.ones(1 << 27)
    assert budget.free_bytes() > 400 << 20 or psutil.virtual_memory().available < 500 << 20
    with budget.limit_memory(limit):
        before = budget.count_bytes()
        reserved = mmap.mmap(-1, 300 << 20, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS)
        assert budget.count_bytes() >= before + len(reserved)
        budget.follow_untouched()
        assert budget.count_bytes() < before + len(reserved) // 2, "nothing of it was touched"
        more = mmap.mmap(-1, 300 << 20, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS)
        more.close()
        reserved.close()
    with pytest.raises(UsageError, match="are the least"), budget.limit_memory(1 << 20):
        pass
