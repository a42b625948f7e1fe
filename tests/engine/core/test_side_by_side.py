"""Pieces of work on all cores: in order, a few ahead, and ended where nobody asks for more."""

from __future__ import annotations

import threading
from collections.abc import Iterator

import numba
import numpy as np
import pytest
import threadpoolctl

from engine.core.side_by_side import list_side_by_side, side_by_side
from tests.processes import alone


def blas_threads() -> set[int]:
    return {pool["num_threads"] for pool in threadpoolctl.threadpool_info() if pool["user_api"] == "blas"}


def threads_while_the_work_runs_and_after() -> list[set[int]]:
    np.linalg.inv(np.eye(3))
    with threadpoolctl.threadpool_limits(2, user_api="blas"):
        results = side_by_side(lambda _: blas_threads(), range(50), threads=1)
        during = next(results)
        results.close()
        return [during, blas_threads()]


def test_results_come_in_the_order_of_the_pieces_also_where_the_first_ends_last() -> None:
    second_has_ended = threading.Event()

    def work(piece: int) -> int:
        if piece == 0:
            assert second_has_ended.wait(60.0)
        if piece == 1:
            second_has_ended.set()
        return piece * piece

    assert list(side_by_side(work, range(9), threads=2)) == [piece * piece for piece in range(9)]


@pytest.mark.parametrize("shared", [True, False])
def test_parallel_kernels_of_pieces_take_one_thread(shared: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """And pieces come one after the other where threads must not share them."""
    monkeypatch.setattr("engine.core.side_by_side.threads_are_shared", lambda: shared)
    monkeypatch.setattr("engine.core.side_by_side.thread_count", lambda: 2)
    both = threading.Barrier(2 if shared else 1)

    def work(piece: int) -> tuple[int, int]:
        both.wait(60.0)
        return piece, numba.get_num_threads()

    assert list_side_by_side(work, range(4)) == [(piece, 1) for piece in range(4)]


def test_no_more_than_twice_as_many_pieces_as_threads_are_begun_ahead() -> None:
    begun: list[int] = []

    def pieces() -> Iterator[int]:
        for piece in range(50):
            begun.append(piece)
            yield piece

    for result in side_by_side(lambda piece: piece, pieces(), threads=2):
        assert len(begun) <= result + 4


def test_an_error_is_raised_in_the_place_of_its_piece() -> None:
    results = side_by_side(lambda piece: 1 // (piece - 2), range(5), threads=2)
    assert [next(results), next(results)] == [-1, -1]
    with pytest.raises(ZeroDivisionError):
        next(results)


def test_linear_algebra_has_one_thread_until_the_work_is_closed() -> None:
    assert alone(threads_while_the_work_runs_and_after) == [{1}, {2}]
