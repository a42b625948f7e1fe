"""The reference of the image on screen: it starts when the image rests, and stops at once on any change.

It is a job in the background, which pauses while others run, and also where who asked for it knows enough (`hold`). It
ends where its noise is below `FINE_ENOUGH` or it has `MAX_SAMPLES`.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import QObject, Signal

from app.jobs.jobs import Job, Jobs
from app.viewport.refining import same
from engine.core.figure_text import percent
from engine.core.steps import Step, Steps
from engine.scene.scene import Scene

if TYPE_CHECKING:
    from engine.render.reference import ReferenceImage

#: Standard error of the whole image, relative, below which nobody sees a difference any more.
FINE_ENOUGH = 0.002

MAX_SAMPLES = 4096


@dataclass(frozen=True, eq=False)
class _Wanted:
    scene: Scene
    size: tuple[int, int]
    bounces: int

    def is_as(self, other: _Wanted | None) -> bool:
        alike = other is not None and (self.size, self.bounces) == (other.size, other.bounces)
        return alike and other is not None and same(self.scene, other.scene)


class Progressive(QObject):
    """Runs one reference at a time. `improved` follows each image that is there to be shown, as `found`."""

    improved = Signal()

    def __init__(self, jobs: Jobs) -> None:
        super().__init__()
        self.jobs = jobs
        self.found: ReferenceImage | None = None
        self.stopped = self.held = False
        self._wanted: _Wanted | None = None
        self._job: Job | None = None

    @property
    def running(self) -> bool:
        return self._job is not None

    def is_run_by(self, job: Job) -> bool:
        """True if `job` is the one that refines."""
        return job is self._job

    def want(self, scene: Scene, size: tuple[int, int], bounces: int) -> None:
        """Work on the reference of `scene` with `size` (width, height); an equal one that was begun continues."""
        wanted = _Wanted(scene, size, bounces)
        if wanted.is_as(self._wanted):
            return
        self.drop()
        self._wanted = wanted
        self._start()

    def serves(self, scene: Scene, bounces: int) -> bool:
        """True if the present or coming image is of `scene`, in any size."""
        wanted = self._wanted
        return wanted is not None and wanted.bounces == bounces and same(wanted.scene, scene)

    def drop(self) -> None:
        """Stop, and forget the result: the image is another one."""
        if self._job is not None:
            job, self._job = self._job, None
            self.jobs.cancel(job)
        self.found = self._wanted = None
        self.stopped = self.held = False

    def hold(self, held: bool) -> None:
        """Pause while the result is good enough; it can continue from there."""
        if held != self.held:
            self.held = held
            if self._job is not None:
                (self.jobs.pause if held else self.jobs.resume)(self._job)

    def stop(self) -> None:
        """Stop, and keep the result."""
        if self._job is not None:
            job, self._job = self._job, None
            self.stopped = True
            self.jobs.cancel(job)
            self.improved.emit()

    def again(self) -> None:
        """Begin anew after `stop`."""
        wanted = self._wanted
        if wanted is not None and self._job is None:
            self.stopped = False
            self._start()

    def _start(self) -> None:
        wanted = self._wanted
        assert wanted is not None
        job = self.jobs.submit("Rendering the reference", lambda: _reference(wanted), lane="background", refines=True)
        self._job = job
        job.progressed.connect(lambda step: self._take(job, step.partial))
        job.succeeded.connect(lambda found: self._end(job, found))
        job.failed.connect(lambda _error: self._end(job, None))
        job.cancelled.connect(lambda: self._end(job, None))
        if self.held:
            self.jobs.pause(job)

    def _take(self, job: Job, found: Any) -> None:
        if job is self._job and found is not None:
            self.found = found
            self.improved.emit()

    def _end(self, job: Job, found: Any) -> None:
        if job is self._job:
            self._job = None
            self.found = found or self.found
            self.improved.emit()


def _reference(wanted: _Wanted) -> Steps[Any]:
    """Images that become better until they are good enough; the last one is the result."""
    yield Step(0.0, "compiling (first use only)")
    from engine.render.reference import reference

    threads = max(1, (os.cpu_count() or 1) - 1)  # one CPU is left to the window
    depth = wanted.bounces + 1
    steps = reference(wanted.scene, wanted.size, samples=None, max_depth=depth, threads=threads)
    last = None
    try:
        for step in steps:
            last = step.partial or last
            yield step
            if step.partial is not None and _is_fine(step.partial):
                break
    finally:
        steps.close()
    return last


def _is_fine(found: ReferenceImage) -> bool:
    noise = found.uncertainty_rmse_rel
    return found.samples >= MAX_SAMPLES or (noise is not None and found.samples >= 16 and noise <= FINE_ENOUGH)


def progress_text(found: ReferenceImage | None) -> str:
    """'64 samples, ± 0.8 %'."""
    if found is None or found.samples < 1:
        return "preparing…"
    noise = found.uncertainty_rmse_rel
    words = f"{found.samples} sample{'s' * (found.samples != 1)}"
    return words if noise is None else f"{words}, ± {percent(noise)}"
