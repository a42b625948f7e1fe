"""The number of threads on which kernels run, which the suite holds at one: its processes share the CPUs."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import numba
import pytest
from numba.np.ufunc import parallel


@contextmanager
def threads(count: int) -> Iterator[None]:
    """Kernels that this thread calls run on `count` threads, also on more than `NUMBA_NUM_THREADS`."""
    before = numba.get_num_threads()
    if count > numba.config.NUMBA_NUM_THREADS and numba.threading_layer() == "workqueue":
        pytest.skip(f"numba's pool has no {count} threads, and no OpenMP to start them")
    parallel._set_num_threads(count)
    try:
        yield
    finally:
        parallel._set_num_threads(before)
