"""Linear algebra is held to one thread while somebody asks for it, and let go after the last."""

from __future__ import annotations

import numpy as np
import threadpoolctl

from engine.core.one_thread import one_thread


def threads() -> set[int]:
    return {pool["num_threads"] for pool in threadpoolctl.threadpool_info() if pool["user_api"] == "blas"}


def test_the_limit_holds_until_the_last_has_left() -> None:
    np.linalg.inv(np.eye(3))
    with threadpoolctl.threadpool_limits(2, user_api="blas"):
        before = threads()
        first, second = one_thread(), one_thread()
        with first:
            second.__enter__()
            assert threads() == {1}
        assert threads() == {1}
        second.__exit__(None, None, None)
        assert threads() == before
