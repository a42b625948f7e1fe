"""The simulated schedule of a batch against schedules that can be counted by hand."""

from __future__ import annotations

import pytest

from app.batch.run import REPORT_SHARE
from benchmarks.batch import simulate_schedule


def test_processes_that_wait_for_nobody_share_the_work_evenly() -> None:
    assert simulate_schedule(6400, 64, 10.0, 0.0) == pytest.approx(100 * 10.0, rel=0.02)


def test_a_slow_scheduler_bounds_the_schedule() -> None:
    """Captures follow each other by what the scheduler takes for one; the last one ends after that."""
    taken_s = simulate_schedule(1000, 64, 1.0, 0.1)
    assert taken_s == pytest.approx(1000 * 0.1 * (1.0 + REPORT_SHARE) + 1.0, abs=0.4)


def test_one_process_takes_the_sum() -> None:
    assert simulate_schedule(200, 1, 3.0, 0.5) == pytest.approx(200 * (3.0 + 0.5 * (1.0 + REPORT_SHARE)), rel=0.02)
