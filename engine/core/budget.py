"""The threads and the memory that this process may take: those of the machine, or fewer where a user asks for it.

Every pool of threads, and every decision by the memory that is free, asks here. Threads of compiled kernels and of
linear algebra follow variables that their libraries read when they are loaded, so `limit_threads` comes before;
where they are loaded already they are told as well.

What `limit_memory` bounds on Linux is the private memory of this process that can be written to (RLIMIT_DATA):
arrays, libraries and stacks. What of it is reserved and was not touched, some 400 MB of libraries and stacks, takes no
memory and does not count; there is more with each thread and library, so `follow_untouched` is called now and then.
Beyond the limit an allocation fails, before which `engine.storage.spilling` puts large arrays into files. Decoder
processes may take as much each. On other systems there is no such limit, and only decisions follow.
"""

from __future__ import annotations

import mmap
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import psutil

from engine.core.errors import UsageError
from engine.core.figure_text import size_text

#: Variables by which libraries learn of their number of threads: OpenMP, algebra, kernels, and Mesa's CPU renderer.
_KERNELS = "NUMBA_NUM_THREADS"
VARIABLES = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", _KERNELS, "LP_NUM_THREADS")

#: Memory beyond that of libraries without which no work gets far.
ROOM_BYTES = 256 << 20

#: Part of the memory that a user allows which a block of work may take.
BLOCK_PART = 1 / 8

_threads: int | None = None
_memory_bytes: int | None = None
_untouched_bytes = 0


def thread_count() -> int:
    """Threads that a pool may have."""
    return _threads or os.cpu_count() or 1


@contextmanager
def limit_threads(count: int) -> Iterator[None]:
    """Within the block this process, and those that it starts, compute on `count` threads, and no more than CPUs."""
    global _threads
    count = min(count, os.cpu_count() or 1)
    before, variables = _threads, {name: os.environ.get(name) for name in _list_free_variables()}
    _threads = count
    os.environ.update(dict.fromkeys(variables, str(count)))
    try:
        with _limit_libraries(count):
            yield
    finally:
        _threads = before
        for name in variables.keys() & _list_free_variables():
            os.environ.pop(name)
            os.environ.update({} if (value := variables[name]) is None else {name: value})


def _list_free_variables() -> set[str]:
    """The variables that may change: numba reads its own whenever it compiles, and fails where it is not as before."""
    return set(VARIABLES) - ({_KERNELS} if "numba" in sys.modules else set())


@contextmanager
def _limit_libraries(count: int) -> Iterator[None]:
    """Tell those libraries that are loaded already."""
    if "numpy" not in sys.modules:
        yield
        return
    from threadpoolctl import threadpool_limits  # it looks through all libraries that are loaded

    numba = sys.modules.get("numba")
    kernels = numba.get_num_threads() if numba is not None else 0
    with threadpool_limits(count):
        if numba is not None:
            numba.set_num_threads(min(count, numba.config.NUMBA_NUM_THREADS))
        yield
        if numba is not None:
            numba.set_num_threads(kernels)


def free_bytes() -> int:
    """Bytes of memory that this process may still take."""
    free = int(psutil.virtual_memory().available)
    return free if _memory_bytes is None else max(0, min(free, _memory_bytes - count_bytes()))


def has_memory_limit() -> bool:
    """True within `limit_memory`."""
    return _memory_bytes is not None


def lift_memory_limit() -> None:
    """End the limit of this process for good: of a copy that computes for the one whose memory is limited."""
    global _memory_bytes
    _memory_bytes = None
    if sys.platform == "linux":
        import resource  # of Unix alone

        hard = resource.getrlimit(resource.RLIMIT_DATA)[1]
        resource.setrlimit(resource.RLIMIT_DATA, (hard, hard))


def block_values(most: int, value_bytes: int) -> int:
    """Values of a block of work of which each takes `value_bytes`: `most`, or what fills a part of the memory that a
    user allows."""
    return most if _memory_bytes is None else max(1, min(most, int(BLOCK_PART * _memory_bytes / value_bytes)))


@contextmanager
def limit_memory(memory_bytes: int) -> Iterator[None]:
    """Within the block this process has at most `memory_bytes`; UsageError where it has little less already."""
    global _memory_bytes, _untouched_bytes
    before, untouched = _memory_bytes, _untouched_bytes
    _untouched_bytes = _count_untouched()
    least = count_bytes() + ROOM_BYTES
    if memory_bytes < least:
        _untouched_bytes = untouched
        raise UsageError(f"{size_text(memory_bytes)} of memory are too little; {size_text(least)} are the least")
    _memory_bytes = memory_bytes
    try:
        if sys.platform != "linux":
            yield
            return
        import resource  # of Unix alone

        soft, hard = resource.getrlimit(resource.RLIMIT_DATA)
        follow_untouched()
        try:
            yield
        finally:
            resource.setrlimit(resource.RLIMIT_DATA, (soft, hard))
    finally:
        _memory_bytes, _untouched_bytes = before, untouched


def follow_untouched() -> None:
    """Count memory that is reserved and was not touched anew, within `limit_memory` on Linux."""
    global _untouched_bytes
    if _memory_bytes is None or sys.platform != "linux":
        return
    import resource  # of Unix alone

    _untouched_bytes = _count_untouched()
    hard = resource.getrlimit(resource.RLIMIT_DATA)[1]
    resource.setrlimit(resource.RLIMIT_DATA, (_lower_to(_memory_bytes + _untouched_bytes, hard), hard))


def _count_untouched() -> int:
    if sys.platform != "linux":
        return 0
    resident, of_files, data = _read_sizes()
    return max(0, data - (resident - of_files))


def count_bytes() -> int:
    """Memory of this process as the limit counts it on Linux, and resident memory elsewhere."""
    if sys.platform != "linux":
        return int(psutil.Process().memory_info().rss)
    return _read_sizes()[2] - _untouched_bytes


def _read_sizes() -> tuple[int, int, int]:
    """Bytes of this process in memory, those of files among them, and private ones that can be written to.

    They are asked for fifty times a second, and psutil reads more than they need (proc_pid_statm(5)).
    """
    fields = Path("/proc/self/statm").read_bytes().split()
    resident, of_files, data = (mmap.PAGESIZE * int(fields[place]) for place in (1, 2, 5))
    return resident, of_files, data


def _lower_to(size_bytes: int, hard: int) -> int:
    """A soft limit that the system takes: no more than the `hard` one, which is negative where there is none."""
    return size_bytes if hard < 0 else min(size_bytes, hard)
