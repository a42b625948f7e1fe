"""Long work: one QThread drives one generator of steps and reports exactly one outcome.

A job is queued, runs, and then succeeds, fails or is cancelled; which of the three is decided once, when its thread
has ended, on the thread of the window. Its lane decides when it runs (`LANES`). Cancelling asks between two steps and
closes the generator, whose `finally` removes what is half-made. A paused job is not asked for its next step, and lets
others run meanwhile; a background job is paused and resumed in the same way when others need the CPUs.

No job waits for the result of another: a successor is submitted when its predecessor succeeds. A job that waits
therefore waits only for jobs that run, and the queue cannot deadlock.
"""

from __future__ import annotations

import ctypes
import os
import sys
import threading
import time
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from typing import Any, Literal

import psutil
from PySide6.QtCore import QObject, QThread, QTimer, Signal

from engine.core.errors import OutOfMemory
from engine.core.figure_text import size_text
from engine.core.steps import Step, Steps
from engine.core.stopwatch import notice_company
from engine.storage import guarded

Work = Callable[[], Steps[Any]]
State = Literal["queued", "running", "paused", "succeeded", "failed", "cancelled"]
Lane = Literal["save", "open", "compute", "background", "screen"]


@dataclass(frozen=True)
class LaneRule:
    """When jobs of a lane run, in words, and the niceness of their threads (Linux; their children inherit it)."""

    when: str
    niceness: int


#: The window's thread, of niceness 0, goes first where CPUs are short; processes that decode files have this one.
NICENESS = 5

LANES: Mapping[Lane, LaneRule] = {
    "save": LaneRule("Writes what the user confirmed: starts at once, and closing the window waits for it.", NICENESS),
    "open": LaneRule("Brings a file into the program: starts at once, `MAX_OPEN` side by side.", NICENESS),
    "compute": LaneRule(
        "A computation that the user asked for: `max_compute` side by side, first come first.", NICENESS
    ),
    "background": LaneRule(
        "Nobody waits for it: runs, step by step, while no job of the lanes above does.", 2 * NICENESS
    ),
    "screen": LaneRule("An image or a figure for the screen: starts at once, and is not listed.", NICENESS),
}

#: Files that are opened side by side.
MAX_OPEN = 4

#: Share of the memory that is free where a computation begins beside another.
MIN_FREE = 0.25

#: Milliseconds until a job that waits for memory is looked at again.
AGAIN_MS = 1000

#: Steps without a partial result are shown at most this often.
SHOW_EVERY_S = 0.04


def nothing() -> None:
    """Nothing is to be done before a job."""


def return_freed_memory() -> None:
    """Return what was freed to the system, where the C library keeps it for later (glibc); some 20 ms.

    Of a window with bakes and factors in it, that was a tenth to a seventh of its memory.
    """
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None) if sys.platform == "linux" else None
    if trim is not None:
        trim(0)


def max_compute() -> int:
    """Number of computations side by side: half the number of CPUs, from 2 to 4.

    Each takes all CPUs as far as it can. Side by side they share them, so that a short one never waits for a long one.
    """
    cpus = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return min(4, max(2, cpus // 2))


@dataclass(frozen=True, eq=False)
class Outcome:
    """The end of a job: its result, or the exception that it raised."""

    state: State
    result: Any = None
    error: BaseException | None = None


class Job(QObject):
    """One piece of long work. Emits `progressed` any number of times, then one of the other three.

    Attributes
    ----------
    again : how to go on with the work if the program is killed meanwhile, as JSON can say it; None where nothing can.
    refines : it only improves what is there already, and is shown nowhere.
    resource : jobs with the same resource, such as a file that they write, run one after the other; '' for none.
    alone : it measures times, so that no other computation runs beside it.
    on_stop : what becomes of its result where it is stopped, in a sentence for the user, who is asked before the window
        leaves its project; '' where nobody has to be asked.
    waits_for : the reason why it does not run, in words; empty while it runs.
    """

    progressed = Signal(object)
    succeeded = Signal(object)
    failed = Signal(object)
    cancelled = Signal()

    def __init__(self, title: str, work: Work, *, lane: Lane, again: Mapping[str, Any] | None = None) -> None:
        super().__init__()
        self.title, self.again = title, again
        self.lane: Lane = lane
        self.refines = self.alone = False
        self.resource = self.on_stop = ""
        self.is_dropped = False
        self.waits_for = ""
        self.state: State = "queued"
        self.step = Step(0.0, "")
        self.begun = False
        self.started_s = 0.0
        self.paused_s = 0.0
        self.time_s = 0.0
        self._thread = _Thread(work, lane)

    @property
    def is_asked_for(self) -> bool:
        """True if the user asked for it and sees it in the list of jobs."""
        return self.lane in ("save", "open", "compute")

    @property
    def over(self) -> bool:
        return self.state in ("succeeded", "failed", "cancelled")

    @property
    def stopping(self) -> bool:
        """A cancel was asked for and the work has not ended yet."""
        return self._thread.stop.is_set() and not self.over

    def let_go(self) -> None:
        """Free what work, outcome and listeners hold: whoever lists jobs keeps those that are over as well.

        Functions that are connected to a signal live as long as what emits it, and these hold the job itself.
        """
        self.step = Step(self.step.done, self.step.note)
        self._thread.let_go()
        for emitter in (self._thread, self):
            emitter.deleteLater()

    @property
    def left_s(self) -> float | None:
        """Estimated seconds to go, None while it is too early to say."""
        elapsed = time.monotonic() - self.started_s
        if self.state != "running" or elapsed < 1.0 or self.step.done < 0.02:
            return None
        return elapsed * (1.0 - self.step.done) / self.step.done


class Jobs(QObject):
    """The queue. `changed`: a job was added, began, paused, is to stop, or ended; `progressed`: it moved on.

    Each job that the user asked for runs within the context that `around` makes of it, which is entered and left on the
    job's thread. `before` is called there first, of every job.
    """

    changed = Signal(object)
    progressed = Signal(object)
    failed = Signal(object, object)

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._waiting: list[Job] = []
        self._running: list[Job] = []
        self._paused: list[Job] = []
        self.accepting = True
        self.max_compute = max_compute()
        self.around: Callable[[Job], AbstractContextManager[object]] = nullcontext
        self.before: Callable[[], object] = nothing
        self._again = QTimer(self)
        self._again.setSingleShot(True)
        self._again.setInterval(AGAIN_MS)
        self._again.timeout.connect(self._start_next)

    @property
    def active(self) -> tuple[Job, ...]:
        """Running jobs, then waiting ones, then paused ones."""
        return (*self._running, *self._waiting, *self._paused)

    def submit(
        self,
        title: str,
        work: Work,
        *,
        lane: Lane,
        again: Mapping[str, Any] | None = None,
        refines: bool = False,
        resource: str = "",
        on_stop: str = "",
        alone: bool = False,
        prepares: bool = True,
    ) -> Job:
        """Queue `work` in its `lane`; the other parameters are attributes of `Job`.

        `work` is called on the job's own thread, so it may import slow modules there. Without `prepares` it begins
        without what `before` loads, and must not import packages of it.
        """
        job = Job(title, work, lane=lane, again=again)
        job.refines, job.resource, job.on_stop, job.alone = refines, resource, on_stop, alone
        job._thread.before = self.before if prepares else nothing
        if job.is_asked_for:
            job._thread.around = self.around(job)
        job._thread.stepped.connect(lambda step: self._progress(job, step))
        job._thread.finished.connect(lambda: self._end(job, job._thread.outcome))
        if self.accepting:
            self._waiting.append(job)
            self.changed.emit(job)
            self._start_next()
        return job

    def cancel(self, job: Job) -> None:
        """Ask `job` to stop; a waiting one is cancelled at once. Asking twice, or too late, does nothing more."""
        if job.over:
            return
        job._thread.stop.set()
        if not job.begun:
            self._end(job, Outcome("cancelled"))
        else:
            job._thread.go.set()
            self.changed.emit(job)

    def drop(self, job: Job) -> None:
        """Cancel `job`, whose result nobody wants any more: not even where it has been found and not told yet."""
        job.is_dropped = True
        self.cancel(job)

    def pause(self, job: Job) -> None:
        """Ask `job` for no further step until `resume`; one that waits keeps waiting. Once over, nothing happens."""
        if job.state not in ("queued", "running") or job.stopping:
            return
        job._thread.go.clear()
        if job.state == "running":
            job.paused_s = time.monotonic()
        (self._waiting if job.state == "queued" else self._running).remove(job)
        self._paused.append(job)
        job.state, job.waits_for = "paused", ""
        self.changed.emit(job)
        self._start_next()

    def resume(self, job: Job) -> None:
        """Let a paused `job` go on: at once, or when its lane lets it."""
        if job.state != "paused" or job.stopping:
            return
        self._paused.remove(job)
        self._waiting.insert(0, job)
        job.state = "queued"
        self.changed.emit(job)
        self._start_next()

    def hurry(self, job: Job) -> None:
        """The user waits for a background `job` now: it is a computation from here on."""
        if job.lane == "background" and not job.over:
            job.lane = "compute"
            self._note_company()
            self.changed.emit(job)
            self._start_next()

    def close(self) -> None:
        """Cancel everything and wait for the threads; no job starts afterwards."""
        self.accepting = False
        for job in self.active:
            self.cancel(job)
        for job in self.active:
            job._thread.wait()
            self._end(job, job._thread.outcome)

    def _start_next(self) -> None:
        """Start what may run now, and pause background jobs where something else is to run."""
        for job in tuple(self._waiting):
            if job.lane != "background":
                self._start_or_say(job)
        for job in tuple(self._running):
            reason = self._why_not_in_background() if job.lane == "background" and not job.stopping else ""
            if reason and job in self._running:
                job._thread.go.clear()
                self._running.remove(job)
                self._waiting.append(job)
                job.state, job.paused_s, job.waits_for = "queued", time.monotonic(), reason
                self.changed.emit(job)
        for job in tuple(self._waiting):
            if job.lane == "background":
                self._start_or_say(job)

    def _start_or_say(self, job: Job) -> None:
        """Start a waiting job, or note why it waits."""
        if job not in self._waiting or job.stopping:
            return  # a listener of the one before has changed that
        reason = self._why_not(job)
        if not reason:
            self._start(job)
        elif reason != job.waits_for:
            job.waits_for = reason
            self.changed.emit(job)

    def _why_not(self, job: Job) -> str:
        """The reason why a waiting job does not run now, in words that follow 'waiting for'; empty where it may."""
        begun = (*self._running, *(other for other in (*self._waiting, *self._paused) if other.begun))
        for other in begun:
            if job.resource and other is not job and other.resource == job.resource:
                return f"{other.title} to end"
        if job.lane == "open":
            others = [other for other in self._running if other.lane == "open"]
            return f"{others[0].title} and {len(others) - 1} others to end" if len(others) >= MAX_OPEN else ""
        if job.lane == "compute":
            return self._why_not_compute(job)
        return self._why_not_in_background() if job.lane == "background" else ""

    def _why_not_compute(self, job: Job) -> str:
        others = [other for other in self._running if other.lane == "compute"]
        alone = next((other for other in others if other.alone), None)
        if not others:
            return ""
        if alone is not None:
            return f"{alone.title}, which measures times and runs alone"
        if job.alone:
            return f"{others[0].title} to end, because it measures times"
        if len(others) >= self.max_compute:
            rest = len(others) - 1
            return f"{others[0].title} or {'another' if rest == 1 else f'one of {rest} others'} to end"
        memory = psutil.virtual_memory()
        if memory.available < MIN_FREE * memory.total:
            self._again.start()
            return f"memory: {size_text(memory.available)} of {size_text(memory.total)} are free"
        return ""

    def _why_not_in_background(self) -> str:
        wanted = (job for job in (*self._running, *self._waiting) if job.is_asked_for and not job.stopping)
        first = next(wanted, None)
        return f"{first.title} to end" if first is not None else ""

    def _start(self, job: Job) -> None:
        self._waiting.remove(job)
        self._running.append(job)
        job.state, job.waits_for = "running", ""
        self._note_company()
        job._thread.go.set()
        if job.begun:
            job.started_s += time.monotonic() - job.paused_s
        else:
            job.begun, job.started_s = True, time.monotonic()
            job._thread.start()
        self.changed.emit(job)
        if not job._thread.isRunning() and not job._thread.isFinished():  # Qt says so only in its log
            lack = Outcome("failed", error=OutOfMemory("No further thread can be started"))
            QTimer.singleShot(0, self, lambda: self._end(job, lack))

    def _note_company(self) -> None:
        """Tell computations that run now that they did not run alone."""
        running = [job for job in self._running if job.lane == "compute"]
        for job in running if len(running) > 1 else ():
            job._thread.company.set()

    def _progress(self, job: Job, step: Step) -> None:
        if not job.over:
            job.step = step
            job.progressed.emit(step)
            self.progressed.emit(job)

    def _end(self, job: Job, outcome: Outcome) -> None:
        if job.over:
            return
        if job.is_dropped:
            outcome = Outcome("cancelled")
        for jobs in (self._running, self._waiting, self._paused):
            if job in jobs:
                jobs.remove(job)
        if job.begun:
            job.time_s = time.monotonic() - job.started_s
        job.state, job.waits_for = outcome.state, ""
        self.changed.emit(job)
        if outcome.state == "succeeded":
            job.succeeded.emit(outcome.result)
        elif outcome.state == "failed":
            job.failed.emit(outcome.error)
            self.failed.emit(job, outcome.error)
        else:
            job.cancelled.emit()
        job._thread.wait()
        job.let_go()
        self._start_next()


_turns = threading.Lock()


def _turn(lane: Lane) -> AbstractContextManager[object]:
    """Steps take turns where kernels on two threads must not run at once; a save runs none, and never waits.

    Until a job has loaded the kernels, none runs.
    """
    kernels: Any = sys.modules.get("engine.core.kernels")
    shared = getattr(kernels, "threads_are_shared", None)
    return _turns if lane != "save" and shared is not None and not shared() else nullcontext()


class _Thread(QThread):
    stepped = Signal(object)

    def __init__(self, work: Work, lane: Lane) -> None:
        super().__init__()
        self.setStackSize(16 * 2**20)
        self.work: Work | None = work
        self.lane: Lane = lane
        self.company = threading.Event()
        self.before: Callable[[], object] = nothing
        self.around: AbstractContextManager[object] = nullcontext()
        self.stop = threading.Event()
        self.go = threading.Event()
        self.outcome = Outcome("cancelled")
        self._shown_s = 0.0

    def let_go(self) -> None:
        """Keep neither work nor outcome."""
        self.work, self.outcome, self.around = None, Outcome("cancelled"), nullcontext()

    def run(self) -> None:
        if sys.platform == "linux":
            os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), LANES[self.lane].niceness)
        notice_company(self.company)
        try:
            self.before()
            with self.around:
                self.outcome = self._drive()
        except BaseException as error:  # the border of the thread: whatever was raised is the job's outcome
            self.outcome = Outcome("failed", error=error)
        if self.lane in ("open", "compute"):
            return_freed_memory()

    def _drive(self) -> Outcome:
        assert self.work is not None
        steps = self.work()
        try:
            while not self.stop.is_set():
                self.go.wait()
                if self.stop.is_set():
                    break
                try:
                    with _turn(self.lane):
                        step = next(steps)
                except StopIteration as finished:
                    guarded.check()
                    return Outcome("succeeded", result=finished.value)
                self._show(step)
            return Outcome("cancelled")
        finally:
            steps.close()

    def _show(self, step: Step) -> None:
        now = time.monotonic()
        if step.partial is not None or now - self._shown_s >= SHOW_EVERY_S:
            self._shown_s = now
            self.stepped.emit(step)
