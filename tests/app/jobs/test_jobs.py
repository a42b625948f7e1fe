from __future__ import annotations

import functools
import platform
import random
import subprocess
import sys
import threading
import time
import weakref
from collections.abc import Callable, Iterator
from typing import Any

import psutil
import pytest

from app.jobs.jobs import Job, Jobs, Lane, return_freed_memory
from engine.core.steps import Step, Steps
from engine.core.stopwatch import had_company

OUTCOMES = ("succeeded", "failed", "cancelled")


def watch(jobs: Jobs, work: Callable[[], Steps[Any]], **options: Any) -> tuple[Job, list[str]]:
    """A submitted job and the outcomes it reports."""
    job = jobs.submit("Work", work, **{"lane": "compute", **options})
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

    job, reported = watch(jobs, work)
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
    job, reported = watch(jobs, lambda: raising(error))
    qtbot.waitUntil(lambda: job.over)
    qtbot.wait(20)
    assert reported == ["failed"]
    assert len(failures) == 1
    assert failures[0] is error or failures[0].__cause__ is error


def test_work_that_cannot_even_begin_fails(qtbot: Any) -> None:
    def work() -> Steps[None]:
        raise ImportError("no such module")

    job, reported = watch(Jobs(), work)
    qtbot.waitUntil(lambda: job.over)
    assert reported == ["failed"]


def test_fault_17_cancel_at_random_times_reports_one_outcome_and_closes_the_generator(qtbot: Any) -> None:
    chance = random.Random(17)
    jobs = Jobs()
    for _ in range(60):
        life: list[str] = []
        job, reported = watch(jobs, functools.partial(counting, 10, life))
        qtbot.wait(chance.randrange(0, 26))
        for _again in range(chance.choice([1, 2, 3])):
            jobs.cancel(job)
        qtbot.waitUntil(lambda job=job: job.over, timeout=60_000)
        assert reported in (["cancelled"], ["succeeded"])
        assert life in (["begun", "closed"], [])
    assert jobs.active == ()


def test_fault_17_cancel_and_close_leave_no_thread(qtbot: Any) -> None:
    jobs, before = Jobs(), threading.active_count()
    made = [watch(jobs, lambda: counting(10_000)) for _ in range(3)]
    qtbot.waitUntil(lambda: made[0][0].state == "running")
    jobs.cancel(made[0][0])
    jobs.close()
    assert [reported for _, reported in made] == [["cancelled"]] * 3
    assert not any(job._thread.isRunning() for job, _ in made)
    assert threading.active_count() <= before
    late, _ = watch(jobs, lambda: counting(1))
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

    job = jobs.submit("Work", work, lane="compute")
    for name in OUTCOMES:
        getattr(job, name).connect(lambda *_args, _job=job, _listener=made["listener"]: None)
    job.progressed.connect(lambda _step: jobs.cancel(job) if outcome == "cancelled" else None)
    del made, work
    qtbot.waitUntil(lambda: job.over and not any(each() for each in kept))
    assert (job.state, job.step.note) == (outcome, "half"), "what a list of jobs shows is still there"


def test_a_job_that_is_over_is_gone_when_nobody_lists_it(qtbot: Any) -> None:
    jobs = Jobs()
    alive = [weakref.ref(watch(jobs, lambda: counting(2))[0]) for _ in range(3)]
    qtbot.waitUntil(lambda: not any(each() for each in alive))


class _Kept:
    """Something that can be seen to be freed."""


def test_a_waiting_job_is_cancelled_without_running(qtbot: Any) -> None:
    jobs, ran = Jobs(), []
    jobs.max_compute = 1
    first, _ = watch(jobs, lambda: counting(50))
    second, reported = watch(jobs, lambda: ran.append(1) or counting(1))  # type: ignore[func-returns-value]
    jobs.cancel(second)
    assert reported == ["cancelled"]
    qtbot.waitUntil(lambda: first.over)
    assert not ran


def test_a_dropped_job_keeps_its_result_to_itself_also_where_it_has_one() -> None:
    """Its thread has ended with a result, and the window does not know that yet."""
    jobs = Jobs()
    job, reported = watch(jobs, lambda: counting(1))
    job._thread.wait()
    jobs.drop(job)
    job._thread.finished.emit()
    assert reported == ["cancelled"]


def waiting_for(go: threading.Event, life: list[str] | None = None, name: str = "") -> Steps[str]:
    """Steps until `go` is set; each is noted in `life`."""
    while not go.is_set():
        if life is not None:
            life.append(name)
        time.sleep(0.002)
        yield Step(0.5, "working")
    return name


@pytest.fixture
def go() -> Iterator[threading.Event]:
    """Set where a job of `waiting_for` shall end; set at the end of the test as well."""
    event = threading.Event()
    yield event
    event.set()


@pytest.mark.parametrize("lane", ["save", "open", "screen"])
def test_saves_opens_and_images_start_at_once_whatever_runs(qtbot: Any, go: threading.Event, lane: Lane) -> None:
    jobs = Jobs()
    computing = [watch(jobs, lambda: waiting_for(go))[0] for _ in range(5)]
    computing.append(watch(jobs, lambda: waiting_for(go), alone=True)[0])
    others = [watch(jobs, lambda: waiting_for(go), lane=lane)[0] for _ in range(3)]
    assert [job.state for job in others] == ["running"] * 3
    ends, _ = watch(jobs, lambda: counting(2), lane=lane)
    qtbot.waitUntil(lambda: ends.state == "succeeded")
    assert not any(job.over for job in computing)
    go.set()
    qtbot.waitUntil(lambda: all(job.over for job in (*computing, *others)))


def test_computations_run_side_by_side_up_to_the_number_that_fits_and_the_others_say_why_they_wait(
    qtbot: Any, go: threading.Event
) -> None:
    jobs = Jobs()
    jobs.max_compute = 2
    first, second, third = (watch(jobs, lambda: waiting_for(go))[0] for _ in range(3))
    short, _ = watch(jobs, lambda: counting(1), lane="open")
    assert [job.state for job in (first, second, third)] == ["running", "running", "queued"]
    assert third.waits_for == "Work or another to end"
    qtbot.waitUntil(lambda: short.over)
    jobs.cancel(second)
    qtbot.waitUntil(lambda: third.state == "running")
    assert third.waits_for == ""


def test_a_computation_waits_for_memory_beside_another_and_never_alone(
    qtbot: Any, go: threading.Event, monkeypatch: pytest.MonkeyPatch
) -> None:
    jobs, memory = Jobs(), psutil.virtual_memory()
    few = memory._replace(total=16_000_000_000, available=1_200_000_000)
    monkeypatch.setattr("app.jobs.jobs.psutil.virtual_memory", lambda: few)
    jobs._again.setInterval(1)
    first, _ = watch(jobs, lambda: waiting_for(go))
    second, _ = watch(jobs, lambda: waiting_for(go))
    assert (first.state, second.state) == ("running", "queued")
    assert second.waits_for == "memory: 1.2 GB of 16 GB are free"
    monkeypatch.setattr("app.jobs.jobs.psutil.virtual_memory", lambda: few._replace(available=8_000_000_000))
    qtbot.waitUntil(lambda: second.state == "running")


def test_a_measurement_of_times_runs_alone_and_what_ran_beside_another_knows(qtbot: Any, go: threading.Event) -> None:
    jobs, alone = Jobs(), list[bool]()

    def telling() -> Steps[None]:
        yield from waiting_for(go)
        alone.append(not had_company())

    first, _ = watch(jobs, telling)
    measuring, _ = watch(jobs, telling, alone=True)
    later, _ = watch(jobs, telling)
    assert [job.state for job in (first, measuring, later)] == ["running", "queued", "running"]
    assert measuring.waits_for == "Work to end, because it measures times"
    go.set()
    qtbot.waitUntil(lambda: len(alone) == 3)
    assert alone == [False, False, True]
    assert not had_company(), "a thread of no job has none"


def test_jobs_of_one_resource_run_one_after_the_other_also_while_one_is_being_cancelled(
    qtbot: Any, go: threading.Event
) -> None:
    jobs, held = Jobs(), threading.Event()

    def stubborn() -> Steps[None]:
        try:
            yield from waiting_for(go)
        finally:
            held.wait(30)

    first, _ = watch(jobs, stubborn, resource="a file")
    second, _ = watch(jobs, lambda: counting(1), resource="a file")
    qtbot.waitUntil(lambda: first.step.note != "")
    jobs.cancel(first)
    other, _ = watch(jobs, lambda: counting(1), lane="save", resource="another file")
    qtbot.waitUntil(lambda: other.over)
    assert (first.stopping, second.state) == (True, "queued")
    held.set()
    qtbot.waitUntil(lambda: second.state == "succeeded")


@pytest.mark.parametrize("lane", ["save", "open", "compute"])
def test_background_work_stops_at_its_next_step_and_goes_on_where_it_was(
    qtbot: Any, go: threading.Event, lane: Lane
) -> None:
    jobs, life = Jobs(), list[str]()
    background, reported = watch(jobs, lambda: counting_up(life), lane="background")
    qtbot.waitUntil(lambda: len(life) > 3)
    asked, _ = watch(jobs, lambda: waiting_for(go), lane=lane)
    assert (asked.state, background.state, background.waits_for) == ("running", "queued", "Work to end")
    later, _ = watch(jobs, lambda: counting(1), lane="background")
    so_far = []
    for _ in range(2):
        on_screen, _ = watch(jobs, lambda: counting(20), lane="screen")
        qtbot.waitUntil(lambda on_screen=on_screen: on_screen.over)
        so_far.append(len(life))
    assert so_far[0] == so_far[1] < 200
    assert later.state == "queued"
    jobs.cancel(asked)
    qtbot.waitUntil(lambda: background.over and later.over)
    assert (reported, life) == (["succeeded"], [f"{at}" for at in range(200)])


def counting_up(life: list[str]) -> Steps[None]:
    for at in range(200):
        life.append(f"{at}")
        time.sleep(0.001)
        yield Step(at / 200, "counting")


def test_background_work_that_waits_can_be_cancelled_paused_and_hurried(qtbot: Any, go: threading.Event) -> None:
    jobs = Jobs()
    computing, _ = watch(jobs, lambda: waiting_for(go))
    jobs.max_compute = 2
    begun: list[list[str]] = [[], []]
    cancelled, hurried = (watch(jobs, functools.partial(counting, 30, life), lane="background")[0] for life in begun)
    jobs.pause(hurried)
    assert (hurried.state, hurried.waits_for) == ("paused", "")
    jobs.resume(hurried)
    jobs.cancel(cancelled)
    assert (cancelled.state, hurried.state) == ("cancelled", "queued")
    jobs.hurry(hurried)
    qtbot.waitUntil(lambda: hurried.over)
    assert (hurried.state, computing.state) == ("succeeded", "running")
    jobs.close()
    assert not jobs.active


def test_background_work_that_was_preempted_can_be_cancelled(qtbot: Any, go: threading.Event) -> None:
    jobs, life = Jobs(), list[str]()
    background, reported = watch(jobs, functools.partial(counting, 10_000, life), lane="background")
    qtbot.waitUntil(lambda: background.step.note != "")
    watch(jobs, lambda: waiting_for(go))
    jobs.cancel(background)
    qtbot.waitUntil(lambda: background.over)
    assert (reported, life) == (["cancelled"], ["begun", "closed"])


def test_steps_take_turns_where_kernels_of_two_threads_must_not_run_at_once(
    qtbot: Any, go: threading.Event, monkeypatch: pytest.MonkeyPatch
) -> None:
    from engine.core import kernels

    monkeypatch.setattr(kernels, "threads_are_shared", lambda: False)
    jobs, inside, most = Jobs(), list[int](), list[int]()

    def work() -> Steps[None]:
        for _ in range(40):
            inside.append(1)
            most.append(len(inside))
            time.sleep(0.001)
            inside.pop()
            yield Step(0.5, "")

    made = [watch(jobs, work, lane=lane)[0] for lane in ("compute", "compute", "open", "screen")]
    qtbot.waitUntil(lambda: all(job.over for job in made), timeout=30_000)
    assert max(most) == 1
    assert len(most) == 160


@pytest.mark.skipif(
    sys.platform != "linux" or platform.libc_ver()[0] != "glibc", reason="glibc alone keeps what is freed"
)
def test_what_a_job_freed_goes_back_to_the_system(qtbot: Any) -> None:
    """Pieces that stay lie between those that go, as arrays of a scene do. Some fill gaps that earlier tests left."""
    jobs, kept, process = Jobs(), list[bytearray](), psutil.Process()
    return_freed_memory()  # else the job may take what earlier work has freed
    before = process.memory_info().rss

    def hoarding() -> Steps[int]:
        hoard = [bytearray(16_000) for _ in range(24_000)]
        kept.extend(hoard[::50])
        yield Step(0.5, "hoarding")
        return process.memory_info().rss

    job, reported = watch(jobs, hoarding)
    most: list[int] = []
    job.succeeded.connect(most.append)
    qtbot.waitUntil(lambda: reported == ["succeeded"])
    assert most[0] - before > 150e6
    assert process.memory_info().rss - before < 60e6
    assert len(kept) == 480


def test_partial_results_are_never_left_out(qtbot: Any) -> None:
    def work() -> Steps[None]:
        for index in range(200):
            yield Step(index / 200, "", index)

    seen: list[int] = []
    job, _ = watch(Jobs(), work)
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
    jobs.max_compute = 1

    def work() -> Steps[int]:
        for index in range(200):
            taken.append(index)
            time.sleep(0.002)
            yield Step(index / 200, "")
        return len(taken)

    job, reported = watch(jobs, work)
    qtbot.waitUntil(lambda: len(taken) > 3)
    jobs.pause(job)
    other, other_reported = watch(jobs, lambda: counting(3))
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
    jobs.max_compute = 1
    life: list[Any] = []
    first, _ = watch(jobs, lambda: counting(400))
    job, reported = (first, _) if begun else watch(jobs, lambda: counting(400, life))
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
    job, reported = watch(jobs, lambda: counting(400, life))
    qtbot.waitUntil(lambda: bool(life))
    jobs.pause(job)
    jobs.close()
    assert (reported, life, job.state) == (["cancelled"], ["begun", "closed"], "cancelled")
