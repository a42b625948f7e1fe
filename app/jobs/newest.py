"""Jobs of which only the newest matters, as when a slider is dragged: at most one runs and one waits."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from app.jobs.jobs import Job, Jobs, Lane, Work
from engine.core.steps import Step


class Latest:
    """Runs the newest requested work and drops older requests."""

    def __init__(
        self,
        jobs: Jobs,
        title: str,
        progressed: Callable[[Step], None] | None = None,
        stopped: Callable[[], None] | None = None,
        *,
        lane: Lane = "screen",
        refines: bool = False,
    ) -> None:
        """`progressed` receives the steps of the running work; `stopped` follows where the user cancels it.

        `lane` and `refines` are those of the jobs (`app.jobs.jobs.Job`).
        """
        self.jobs, self.title, self.progressed, self.stopped = jobs, title, progressed, stopped
        self.lane: Lane = lane
        self.refines = refines
        self._is_dropped = False
        self._running: Job | None = None
        self._next: tuple[Work, Callable[[Any], None], Callable[[BaseException], None] | None] | None = None

    @property
    def busy(self) -> bool:
        """True if a request has not ended yet."""
        return self._running is not None

    @property
    def waits_for(self) -> str:
        """The reason why the request does not run, in words that follow 'waiting for'; empty while it does."""
        return self._running.waits_for if self._running is not None else ""

    def hurry(self) -> None:
        """The user waits for the request now: it is no longer work in the background."""
        if self._running is not None:
            self.jobs.hurry(self._running)

    def ask(
        self, work: Work, done: Callable[[Any], None], failed: Callable[[BaseException], None] | None = None
    ) -> None:
        """Run `work` and hand its result to `done`, or what it raised to `failed`, unless something newer comes."""
        self._next = (work, done, failed)
        if self._running is None:
            self._start()

    def drop(self) -> None:
        """Forget all requests; a coming result is not shown."""
        self._next = None
        if self._running is not None:
            self._is_dropped = True
            self.jobs.cancel(self._running)

    def _start(self) -> None:
        if self._next is None:
            return
        (work, done, failed), self._next = self._next, None
        job = self.jobs.submit(self.title, work, lane=self.lane, refines=self.refines)
        self._running, self._is_dropped = job, False
        if self.progressed is not None:
            job.progressed.connect(self.progressed)
        job.succeeded.connect(lambda result: self._on_ended(lambda: done(result)))
        job.failed.connect(lambda error: self._on_ended(partial(failed, error) if failed is not None else None))
        job.cancelled.connect(lambda: self._on_ended(None if self._is_dropped else self.stopped))

    def _on_ended(self, show: Callable[[], None] | None) -> None:
        self._running = None
        if show is not None:
            show()
        self._start()
