"""The simulated schedule of a batch against schedules that can be counted by hand, and a run in two parts."""

from __future__ import annotations

from pathlib import Path

import pytest

from app.batch.run import REPORT_SHARE
from benchmarks.batch import _captures, _kill, batch_captures, simulate_schedule
from engine.core.errors import UsageError
from engine.core.steps import drain


def test_processes_that_wait_for_nobody_share_the_work_evenly() -> None:
    assert simulate_schedule(6400, 64, 10.0, 0.0) == pytest.approx(100 * 10.0, rel=0.02)


def test_a_slow_scheduler_bounds_the_schedule() -> None:
    """Captures follow each other by what the scheduler takes for one; the last one ends after that."""
    taken_s = simulate_schedule(1000, 64, 1.0, 0.1)
    assert taken_s == pytest.approx(1000 * 0.1 * (1.0 + REPORT_SHARE) + 1.0, abs=0.4)


def test_one_process_takes_the_sum() -> None:
    assert simulate_schedule(200, 1, 3.0, 0.5) == pytest.approx(200 * (3.0 + 0.5 * (1.0 + REPORT_SHARE)), rel=0.02)


def test_a_run_that_was_ended_goes_on_and_counts_each_capture_once(tmp_path: Path) -> None:
    captures = _captures(tmp_path, 6)
    part = _kill(tmp_path, captures, 2, "wait", 1e9, 1)
    while "2 of 6" not in next(part).note:
        pass
    part.close()
    seen = drain(_kill(tmp_path, captures, 2, "wait", 1e9, 1))
    assert (seen.lost, seen.doubled, seen.killed) == (0, 0, 0)
    assert 3.0 <= seen.made_s < 6.0


def test_a_run_does_not_go_on_with_photographs_of_another_size(tmp_path: Path) -> None:
    (tmp_path / "photographs" / "truth").mkdir(parents=True)
    (tmp_path / "photographs" / "truth" / "truth.json").write_text('{"size_px": 224}')
    with pytest.raises(UsageError, match="have 224 px a side, and 1000 are asked for"):
        drain(batch_captures(tmp_path / "session", (1.0,), keep=tmp_path))
