"""The price of a bake on a cluster, in schedules that can be counted by hand."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from engine.core.cluster import Link
from engine.planning.costs import spread
from engine.planning.costs.spread import READY_S, Stage, price, schedule_s

FREE = Link(math.inf, 0.0)
TEN = Stage(10.0, np.full(10, 4), 0.0, 0.0)


@pytest.fixture(autouse=True)
def even(monkeypatch: pytest.MonkeyPatch) -> None:
    """All tasks take what they should."""
    monkeypatch.setattr(spread, "VARIES", 0.0)


@pytest.mark.parametrize(("speeds", "seconds"), [([1.0], 10.0), ([1.0] * 2, 5.0), ([1.0] * 4, 3.0), ([0.5], 20.0)])
def test_equal_tasks_are_shared_and_the_last_ones_are_waited_for(speeds: list[float], seconds: float) -> None:
    assert schedule_s(TEN, speeds, FREE, 0.0, 0) == pytest.approx(seconds)


def test_a_worker_handles_each_of_its_tasks_beside_computing_it() -> None:
    assert schedule_s(TEN, [1.0, 1.0], FREE, 0.0, 0, 0.5) == pytest.approx(5.0 + 5 * 0.5)


def test_a_chain_is_as_long_on_any_number_of_workers() -> None:
    chain = replace(TEN, before=np.arange(9), after=np.arange(1, 10))
    assert schedule_s(chain, [1.0] * 8, FREE, 0.0, 0) == pytest.approx(10.0)
    ladder = replace(TEN, before=np.arange(8), after=np.arange(2, 10))  # two chains of five
    assert schedule_s(ladder, [1.0] * 8, FREE, 0.0, 0) == pytest.approx(5.0)


def test_what_travels_goes_through_one_link_and_hides_behind_what_is_computed() -> None:
    heavy = replace(TEN, back_bytes=100.0)  # 400 bytes a task
    assert schedule_s(heavy, [1.0] * 5, Link(100.0, 0.0), 0.0, 0) == pytest.approx(1.0 + 10 * 4.0)
    assert schedule_s(heavy, [1.0], Link(1000.0, 0.0), 0.0, 0) == pytest.approx(10.0 + 0.4)


def test_parts_of_a_price_add_up() -> None:
    found = price((TEN, replace(TEN, shared_bytes=10.0)), 3.0, 50.0, [1.0] * 4, Link(100.0, 0.0))
    assert (found.workers, found.compute_s, found.rest_s, found.bytes) == (4, 5.0, 3.0, 240.0)
    assert found.waiting_s == pytest.approx(1.0 + READY_S)
    assert found.transfer_s >= 2.0, "the model goes to each of four"
    assert found.bake_s == pytest.approx(found.compute_s + found.waiting_s + found.transfer_s + found.rest_s)


def test_stragglers_cost_more_the_more_workers_there_are(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(spread, "VARIES", 0.5)
    many = replace(TEN, vertices=np.full(64, 4))
    lost = [price((many,), 0.0, 0.0, [1.0] * count, FREE).waiting_s / (10.0 / count) for count in (1, 4, 16, 64)]
    assert lost[1] < lost[2] < lost[3]
