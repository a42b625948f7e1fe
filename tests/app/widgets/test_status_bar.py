"""The line of a job that runs: its step, and its time to go in the unit that a user would take."""

from __future__ import annotations

import time
from types import SimpleNamespace
from typing import Any

import pytest
from PySide6.QtWidgets import QApplication

from app.jobs.jobs import Job, Jobs
from app.widgets.status_bar import StatusBar, describe
from engine.core.steps import Step, Steps


def nothing() -> Steps[None]:
    yield Step(1.0, "")


@pytest.mark.parametrize(("elapsed_s", "words"), [(10.0, "10 s left"), (1047.0, "17 min left")])
def test_a_job_says_its_time_to_go(qapp: Any, monkeypatch: pytest.MonkeyPatch, elapsed_s: float, words: str) -> None:
    monkeypatch.setattr("app.jobs.jobs.time", SimpleNamespace(monotonic=lambda: 5_000.0))
    job = Job("Making surface maps", nothing, lane="compute")
    job.state, job.begun, job.step = "running", True, Step(0.5, "finding slopes")
    job.started_s = 5_000.0 - elapsed_s
    assert describe(job) == f"Finding slopes · {words}"
    job.step = Step(0.5, "3 of 9 captures, 40 s left")
    assert describe(job) == "3 of 9 captures, 40 s left", "work that knows its time to go says it alone"


def _show(qtbot: Any, width: int) -> tuple[Jobs, StatusBar]:
    """A status bar of so many pixels on the screen, and its jobs, to be closed."""
    jobs = Jobs()
    status = StatusBar(jobs)
    qtbot.addWidget(status)
    status.resize(width, 30)
    status.show()
    return jobs, status


def test_the_button_that_cancels_stays_where_it_is_while_texts_change(qapp: Any, qtbot: Any) -> None:
    jobs, status = _show(qtbot, 700)
    job = Job("Making surface maps", nothing, lane="compute")
    job.state, job.begun, job.started_s = "running", True, time.monotonic()
    status._current = lambda: job  # type: ignore[method-assign]
    positions, lengths = set(), set()
    for note in ("finding slopes", "solving", "integrating the height of a very long name " * 9):
        job.step = Step(0.5, note)
        status.show_frame_time(0.001 * len(note))
        status.show_image_error(f"{len(note)} %")
        status._show_job()
        QApplication.processEvents()
        positions.add(status.cancel.geometry().getRect())
        lengths.add(len(status.words.text()))
        assert status.words.geometry().right() < status.error.geometry().left(), "a long text leaves figures readable"
    assert (len(positions), len(lengths)) == (1, 3)
    assert status.cancel.isVisible()
    jobs.close()


def test_the_error_of_a_comparison_is_not_cut_even_before_the_event_loop_goes_on(qapp: Any, qtbot: Any) -> None:
    jobs, status = _show(qtbot, 1280)
    status.show_image_error("being measured")
    QApplication.processEvents()
    status.show_image_error("11.4 % ± 0.2 (Material against Reference)")
    assert status.error.width() >= status.error.sizeHint().width()
    jobs.close()
