"""Long work: one QThread drives one generator of steps and reports exactly one outcome.

A job is queued, runs, and then succeeds, fails or is cancelled; which of the three is decided once, when its thread
has ended, on the thread of the window. Heavy jobs run one after the other; light ones (a picture for the screen)
start at once. Cancelling asks between two steps and closes the generator, whose `finally` removes what is half-made.
A paused job is not asked for its next step, and lets the next heavy one run meanwhile.
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

from PySide6.QtCore import QObject, QThread, QTimer, Signal

from engine.core.errors import OutOfMemory
from engine.core.steps import Step, Steps

Work = Callable[[], Steps[Any]]
State = Literal["queued", "running", "paused", "succeeded", "failed", "cancelled"]

#: The window's thread goes first where processors are short (Linux; a thread's children inherit it).
NICENESS = 5

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


@dataclass(frozen=True, eq=False)
class Outcome:
    """The end of a job: its result, or the exception that it raised."""

    state: State
    result: Any = None
    error: BaseException | None = None


class Job(QObject):
    """One piece of long work. Emits `progressed` any number of times, then one of the other three.

    `again` says, as JSON can, how to go on with the work if the program is killed meanwhile; None where nothing can.
    `refines`: nobody waits for it, because it makes better what is there already. `waits_for`: title of the heavy job
    that keeps this one waiting.
    """

    progressed = Signal(object)
    succeeded = Signal(object)
    failed = Signal(object)
    cancelled = Signal()

    def __init__(self, title: str, work: Work, *, heavy: bool, again: Mapping[str, Any] | None = None) -> None:
        super().__init__()
        self.title, self.again = title, again
        self.heavy = heavy
        self.refines = False
        self.is_dropped = False
        self.waits_for = ""
        self.state: State = "queued"
        self.step = Step(0.0, "")
        self.begun = False
        self.started_s = 0.0
        self.paused_s = 0.0
        self.time_s = 0.0
        self._thread = _Thread(work, heavy)

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

    Each heavy job runs within the context that `around` makes of it, which is entered and left on the job's thread.
    `before` is called there first, of every job.
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
        self.around: Callable[[Job], AbstractContextManager[object]] = nullcontext
        self.before: Callable[[], object] = nothing

    @property
    def active(self) -> tuple[Job, ...]:
        """Running jobs, then waiting ones, then paused ones."""
        return (*self._running, *self._waiting, *self._paused)

    def submit(
        self,
        title: str,
        work: Work,
        *,
        heavy: bool = True,
        again: Mapping[str, Any] | None = None,
        refines: bool = False,
    ) -> Job:
        """Queue `work`; it is called on the job's own thread, so it may import slow modules there."""
        job = Job(title, work, heavy=heavy, again=again)
        job.refines = refines
        job._thread.before = self.before
        if heavy:
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
        (self._waiting if job.state == "queued" else self._running).remove(job)
        self._paused.append(job)
        job.state, job.paused_s = "paused", time.monotonic()
        self.changed.emit(job)
        self._start_next()

    def resume(self, job: Job) -> None:
        """Let a paused `job` go on: at once, or after the heavy one that runs now."""
        if job.state != "paused" or job.stopping:
            return
        self._paused.remove(job)
        self._waiting.insert(0, job)
        job.state = "queued"
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
        for job in tuple(self._waiting):
            job.waits_for = next((running.title for running in self._running if running.heavy), "") if job.heavy else ""
            if job.waits_for:
                continue
            self._waiting.remove(job)
            self._running.append(job)
            job.state = "running"
            job._thread.go.set()
            if job.begun:
                job.started_s += time.monotonic() - job.paused_s
            else:
                job.begun, job.started_s = True, time.monotonic()
                job._thread.start()
            self.changed.emit(job)
            if not job._thread.isRunning() and not job._thread.isFinished():  # Qt says so only in its log
                lack = Outcome("failed", error=OutOfMemory("No further thread can be started"))
                QTimer.singleShot(0, self, lambda job=job, lack=lack: self._end(job, lack))

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
        job.state = outcome.state
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


class _Thread(QThread):
    stepped = Signal(object)

    def __init__(self, work: Work, heavy: bool) -> None:
        super().__init__()
        self.setStackSize(16 * 2**20)
        self.work: Work | None = work
        self.heavy = heavy
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
            os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), NICENESS)
        try:
            self.before()
            with self.around:
                self.outcome = self._drive()
        except BaseException as error:  # the border of the thread: whatever was raised is the job's outcome
            self.outcome = Outcome("failed", error=error)
        if self.heavy:
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
                    step = next(steps)
                except StopIteration as finished:
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
