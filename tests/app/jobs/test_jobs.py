from __future__ import annotations

import functools
import platform
import random
import subprocess
import sys
import threading
import time
import weakref
from collections.abc import Callable
from typing import Any

import psutil
import pytest

from app.jobs.jobs import Job, Jobs
from engine.core.steps import Step, Steps

OUTCOMES = ("succeeded", "failed", "cancelled")


def watched(jobs: Jobs, work: Callable[[], Steps[Any]], **options: Any) -> tuple[Job, list[str]]:
    """A submitted job and the outcomes it reports."""
    job = jobs.submit("Work", work, **options)
    reported: list[str] = []
    for name in OUTCOMES:
        getattr(job, name).connect(lambda *_args, name=name: reported.append(name))
    return job, reported


def counting(count: int, life: list[str] | None = None) -> Steps[int]:
    if life is not None:
        life.append("begun")
    try:
        for index in range(count):
            time.sleep(0.002)
            yield Step(index / count, f"step {index}")
    finally:
        if life is not None:
            life.append("closed")
    return count


def raising(error: BaseException) -> Steps[None]:
    yield Step(0.5, "about to fail")
    raise error


def test_a_job_succeeds_once_with_its_result_off_the_window_thread(qtbot: Any) -> None:
    jobs = Jobs()
    threads: list[Any] = []
    results: list[Any] = []

    def work() -> Steps[int]:
        threads.append(threading.current_thread())
        return (yield from counting(5))

    job, reported = watched(jobs, work)
    job.succeeded.connect(results.append)
    qtbot.waitUntil(lambda: job.over)
    assert (results, reported, job.state) == ([5], ["succeeded"], "succeeded")
    assert threads[0] is not threading.main_thread()


@pytest.mark.parametrize(
    "error", [RuntimeError("ARPACK"), MemoryError(), KeyError("x"), StopIteration(3), SystemExit(2)]
)
def test_whatever_a_generator_raises_is_reported_as_failed_exactly_once(qtbot: Any, error: BaseException) -> None:
    jobs = Jobs()
    failures: list[BaseException] = []
    jobs.failed.connect(lambda _job, reason: failures.append(reason))
    job, reported = watched(jobs, lambda: raising(error))
    qtbot.waitUntil(lambda: job.over)
    qtbot.wait(20)
    assert reported == ["failed"]
    assert len(failures) == 1
    assert failures[0] is error or failures[0].__cause__ is error


def test_work_that_cannot_even_begin_fails(qtbot: Any) -> None:
    def work() -> Steps[None]:
        raise ImportError("no such module")

    job, reported = watched(Jobs(), work)
    qtbot.waitUntil(lambda: job.over)
    assert reported == ["failed"]


def test_fault_17_cancel_at_random_times_reports_one_outcome_and_closes_the_generator(qtbot: Any) -> None:
    chance = random.Random(17)
    jobs = Jobs()
    for _ in range(60):
        life: list[str] = []
        job, reported = watched(jobs, functools.partial(counting, 10, life))
        qtbot.wait(chance.randrange(0, 26))
        for _again in range(chance.choice([1, 2, 3])):
            jobs.cancel(job)
        qtbot.waitUntil(lambda job=job: job.over, timeout=60_000)
        assert reported in (["cancelled"], ["succeeded"])
        assert life in (["begun", "closed"], [])
    assert jobs.active == ()


def test_fault_17_cancel_and_close_leave_no_thread(qtbot: Any) -> None:
    jobs, before = Jobs(), threading.active_count()
    made = [watched(jobs, lambda: counting(10_000)) for _ in range(3)]
    qtbot.waitUntil(lambda: made[0][0].state == "running")
    jobs.cancel(made[0][0])
    jobs.close()
    assert [reported for _, reported in made] == [["cancelled"]] * 3
    assert not any(job._thread.isRunning() for job, _ in made)
    assert threading.active_count() <= before
    late, _ = watched(jobs, lambda: counting(1))
    qtbot.wait(30)
    assert late.state == "queued"


@pytest.mark.parametrize("outcome", OUTCOMES)
def test_a_job_that_is_over_keeps_nothing_of_its_work_its_result_and_its_listeners(qtbot: Any, outcome: str) -> None:
    jobs, names = Jobs(), ("work", "partial", "result", "listener")
    made = {name: _Kept() for name in names}
    kept = [weakref.ref(each) for each in made.values()]

    def work(made: dict[str, _Kept] = made) -> Steps[_Kept]:
        yield Step(0.5, "half", made["partial"])
        while outcome == "cancelled":
            yield Step(0.5, "half")
        if outcome == "failed":
            raise RuntimeError
        return made["result"]

    job = jobs.submit("Work", work)
    for name in OUTCOMES:
        getattr(job, name).connect(lambda *_args, _job=job, _listener=made["listener"]: None)
    job.progressed.connect(lambda _step: jobs.cancel(job) if outcome == "cancelled" else None)
    del made, work
    qtbot.waitUntil(lambda: job.over and not any(each() for each in kept))
    assert (job.state, job.step.note) == (outcome, "half"), "what a list of jobs shows is still there"


def test_a_job_that_is_over_is_gone_when_nobody_lists_it(qtbot: Any) -> None:
    jobs = Jobs()
    alive = [weakref.ref(watched(jobs, lambda: counting(2))[0]) for _ in range(3)]
    qtbot.waitUntil(lambda: not any(each() for each in alive))


class _Kept:
    """Something that can be seen to be freed."""


def test_a_waiting_job_is_cancelled_without_running(qtbot: Any) -> None:
    jobs, ran = Jobs(), []
    first, _ = watched(jobs, lambda: counting(50))
    second, reported = watched(jobs, lambda: ran.append(1) or counting(1))  # type: ignore[func-returns-value]
    jobs.cancel(second)
    assert reported == ["cancelled"]
    qtbot.waitUntil(lambda: first.over)
    assert not ran


def test_a_dropped_job_keeps_its_result_to_itself_also_where_it_has_one() -> None:
    """Its thread has ended with a result, and the window does not know that yet."""
    jobs = Jobs()
    job, reported = watched(jobs, lambda: counting(1))
    job._thread.wait()
    jobs.drop(job)
    job._thread.finished.emit()
    assert reported == ["cancelled"]


def test_heavy_jobs_run_one_after_the_other_and_light_ones_at_once(qtbot: Any) -> None:
    jobs = Jobs()
    first, _ = watched(jobs, lambda: counting(60))
    second, _ = watched(jobs, lambda: counting(2))
    light, _ = watched(jobs, lambda: counting(2), heavy=False)
    qtbot.waitUntil(lambda: light.over)
    assert (first.state, second.state) == ("running", "queued")
    qtbot.waitUntil(lambda: second.over)
    assert first.state == "succeeded"


@pytest.mark.skipif(
    sys.platform != "linux" or platform.libc_ver()[0] != "glibc", reason="glibc alone keeps what is freed"
)
def test_what_a_heavy_job_freed_goes_back_to_the_system(qtbot: Any) -> None:
    """Pieces that stay lie between those that go, as arrays of a scene do."""
    jobs, kept, process = Jobs(), list[bytearray](), psutil.Process()
    before = process.memory_info().rss

    def hoarding() -> Steps[int]:
        hoard = [bytearray(16_000) for _ in range(12_000)]
        kept.extend(hoard[::50])
        yield Step(0.5, "hoarding")
        return process.memory_info().rss

    job, reported = watched(jobs, hoarding)
    most: list[int] = []
    job.succeeded.connect(most.append)
    qtbot.waitUntil(lambda: reported == ["succeeded"])
    assert most[0] - before > 150e6
    assert process.memory_info().rss - before < 60e6
    assert len(kept) == 240


def test_partial_results_are_never_left_out(qtbot: Any) -> None:
    def work() -> Steps[None]:
        for index in range(200):
            yield Step(index / 200, "", index)

    seen: list[int] = []
    job, _ = watched(Jobs(), work)
    job.progressed.connect(lambda step: seen.append(step.partial))
    qtbot.waitUntil(lambda: job.over)
    assert seen == list(range(200))


def test_ten_thousand_emits_do_not_end_the_program() -> None:
    """PySide6 6.12.0 on Python 3.11 drops a reference to True at each emit and aborts after some 570 of them."""
    program = (
        "from PySide6.QtCore import QCoreApplication, QObject, Signal\n"
        "class Sender(QObject):\n    sent = Signal(bool, object)\n"
        "application, sender, seen = QCoreApplication([]), Sender(), []\n"
        "sender.sent.connect(lambda yes, what: seen.append(yes))\n"
        "for index in range(10_000): sender.sent.emit(True, None)\n"
        "print(len(seen))\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60, check=False)
    assert (done.returncode, done.stdout.strip()) == (0, "10000"), done.stderr


def test_a_paused_job_takes_no_step_lets_the_next_one_run_and_goes_on_where_it_was(qtbot: Any) -> None:
    jobs, taken = Jobs(), []

    def work() -> Steps[int]:
        for index in range(200):
            taken.append(index)
            time.sleep(0.002)
            yield Step(index / 200, "")
        return len(taken)

    job, reported = watched(jobs, work)
    qtbot.waitUntil(lambda: len(taken) > 3)
    jobs.pause(job)
    other, other_reported = watched(jobs, lambda: counting(3))
    qtbot.waitUntil(lambda: other.over)
    so_far = len(taken)
    qtbot.wait(40)
    assert (job.state, len(taken), other_reported) == ("paused", so_far, ["succeeded"])
    jobs.resume(job)
    qtbot.waitUntil(lambda: job.over)
    assert (reported, taken) == (["succeeded"], list(range(200)))


@pytest.mark.parametrize("begun", [True, False])
def test_a_paused_job_can_be_cancelled(qtbot: Any, begun: bool) -> None:
    jobs = Jobs()
    life: list[Any] = []
    first, _ = watched(jobs, lambda: counting(400))
    job, reported = (first, _) if begun else watched(jobs, lambda: counting(400, life))
    qtbot.waitUntil(lambda: first.step.done > 0.0)
    jobs.pause(job)
    jobs.cancel(job)
    qtbot.waitUntil(lambda: job.over)
    assert (reported, life) == (["cancelled"], [])
    jobs.close()
    assert not jobs.active


def test_closing_ends_a_paused_job(qtbot: Any) -> None:
    jobs = Jobs()
    life: list[Any] = []
    job, reported = watched(jobs, lambda: counting(400, life))
    qtbot.waitUntil(lambda: bool(life))
    jobs.pause(job)
    jobs.close()
    assert (reported, life, job.state) == (["cancelled"], ["begun", "closed"], "cancelled")
