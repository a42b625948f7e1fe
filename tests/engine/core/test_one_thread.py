"""Linear algebra is held to one thread while somebody asks for it, and let go after the last."""

from __future__ import annotations

import numpy as np
import threadpoolctl

from engine.core.one_thread import one_thread
from tests.processes import alone


def blas_threads() -> set[int]:
    return {pool["num_threads"] for pool in threadpoolctl.threadpool_info() if pool["user_api"] == "blas"}


def threads_while_two_overlap() -> list[set[int]]:
    np.linalg.inv(np.eye(3))
    found = []
    with threadpoolctl.threadpool_limits(2, user_api="blas"):
        first, second = one_thread(), one_thread()
        with first:
            second.__enter__()
            found.append(blas_threads())
        found.append(blas_threads())
        second.__exit__(None, None, None)
        found.append(blas_threads())
    return found


def test_the_limit_holds_until_the_last_has_left() -> None:
    assert alone(threads_while_two_overlap) == [{1}, {1}, {2}]
