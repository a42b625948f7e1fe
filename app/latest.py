"""Light jobs of which only the newest matters, as when a slider is dragged: at most one runs and one waits."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from app.jobs import Job, Jobs, Work
from engine.steps import Step


class Latest:
    """Runs the newest work that was asked for and drops what it overtakes."""

    def __init__(self, jobs: Jobs, title: str, told: Callable[[Step], None] | None = None) -> None:
        """`told` hears how far the work is that runs."""
        self.jobs, self.title, self.told = jobs, title, told
        self._running: Job | None = None
        self._next: tuple[Work, Callable[[Any], None], Callable[[BaseException], None] | None] | None = None

    @property
    def busy(self) -> bool:
        """Whether something was asked for and has not ended."""
        return self._running is not None

    def ask(
        self, work: Work, done: Callable[[Any], None], failed: Callable[[BaseException], None] | None = None
    ) -> None:
        """Run `work` and hand its result to `done`, or what it raised to `failed`, unless something newer comes."""
        self._next = (work, done, failed)
        if self._running is None:
            self._start()

    def drop(self) -> None:
        """Forget what was asked for; a result that is under way is not shown."""
        self._next = None
        if self._running is not None:
            self.jobs.cancel(self._running)

    def _start(self) -> None:
        if self._next is None:
            return
        (work, done, failed), self._next = self._next, None
        job = self.jobs.submit(self.title, work, heavy=False)
        self._running = job
        if self.told is not None:
            job.progressed.connect(self.told)
        job.succeeded.connect(lambda result: self._ended(lambda: done(result)))
        job.failed.connect(lambda error: self._ended(partial(failed, error) if failed is not None else None))
        job.cancelled.connect(lambda: self._ended(None))

    def _ended(self, show: Callable[[], None] | None) -> None:
        self._running = None
        if show is not None:
            show()
        self._start()
