"""The line of a job that runs: its step, and its time to go in the unit that a person would take."""

from __future__ import annotations

import time
from typing import Any

import pytest

from app.jobs.jobs import Job
from app.widgets.status_bar import describe
from engine.core.steps import Step, Steps


def nothing() -> Steps[None]:
    yield Step(1.0, "")


@pytest.mark.parametrize(("elapsed_s", "words"), [(10.0, "10 s left"), (1047.0, "17 min left")])
def test_a_job_says_its_time_to_go(qapp: Any, elapsed_s: float, words: str) -> None:
    job = Job("Making surface maps", nothing, lane="compute")
    job.state, job.begun, job.step = "running", True, Step(0.5, "finding slopes")
    job.started_s = time.monotonic() - elapsed_s
    assert describe(job) == f"Finding slopes · {words}"
