"""Images of the View workspace: one mode or two, the reference over its stand-in, and their error.

While anything moves, OpenGL draws. When the image has come to rest the reference begins, is laid over as it becomes
better, and what is on screen is compared with it. Where one mode is shown alone, a small reference that nobody sees
measures its error: it begins when nothing else is to be done, and rests as soon as more samples would change
nothing that is read.

The reference of the image on screen: it starts when the image rests, and stops at once on any change.

It is a job in the background, which pauses while others run, and also where who asked for it knows enough (`hold`). It
ends where its noise is below `FINE_ENOUGH` or it has `MAX_SAMPLES`.
"""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QObject, QTimer, Signal

from app.document.document import Project
from app.document.measured import size_of
from app.document.modes import Mode, mode_of, modes, scene_of, shows_near_lamps, why_not
from app.document.variation import list_left_out_by
from app.jobs.jobs import Job, Jobs
from app.view.image_error import Comparing, ImageError, Pixels, Side
from app.viewport.gl_surface import Split
from app.viewport.overlay import Handle
from app.viewport.refining import same
from app.viewport.viewport import Viewport
from engine.core.figure_text import percent
from engine.core.steps import Step, Steps
from engine.render.reference import reference
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

    def _take(self, job: Job, found: ReferenceImage | None) -> None:
        if job is self._job and found is not None:
            self.found = found
            self.improved.emit()

    def _end(self, job: Job, found: ReferenceImage | None) -> None:
        if job is self._job:
            self._job = None
            self.found = found or self.found
            self.improved.emit()


def _reference(wanted: _Wanted) -> Steps[Any]:
    """Images that become better until they are good enough; the last one is the result."""
    yield Step(0.0, "compiling (first use only)")
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


#: Most pixels of a reference; larger screens show it enlarged.
MAX_PIXELS = 1_000_000

#: Samples from which the reference is shown over what stands for it.
SHOWN_FROM = 2

#: Full colour of a difference before anything is known of it.
FIRST_SCALE = 0.1

#: Pause after the image is complete before the reference begins that nobody sees, and its samples at most.
SETTLED_MS = 400
MAX_UNSEEN = 256


class ViewImages(QObject):
    """`error_found(ImageError or None)` and `progressed` follow; `error` and `progress` hold what is known.

    `measuring` says whether the error of a mode that is shown alone is asked for.
    """

    error_found = Signal(object)
    progressed = Signal()

    def __init__(self, viewport: Viewport, jobs: Jobs) -> None:
        super().__init__(viewport)
        self.viewport = viewport
        self.wipe = 0.5
        self.measuring = True
        self.scale = FIRST_SCALE
        self.error: ImageError | None = None
        self.modes: tuple[Mode, ...] = ()
        self.relit_of: Callable[[str, Scene], Any] = lambda _mode, _scene: None
        self.reference = Progressive(jobs)
        self.comparing = Comparing(jobs)
        self._project: Project | None = None
        self._scene: Scene | None = None
        self._drawn: dict[int, Pixels] = {}
        self._flip_at = 0
        self._judged: NDArray[np.float32] | None = None
        self._is_small = False
        self._settled = QTimer(self)
        self._settled.setSingleShot(True)
        self._settled.setInterval(SETTLED_MS)
        self._settled.timeout.connect(self._begin_unseen)
        self.reference.improved.connect(self._on_improved)
        self.comparing.found.connect(self._found)
        viewport.camera_moved.connect(self._on_moved)
        viewport.rested.connect(self._on_rested)
        viewport.drawn.connect(lambda _seconds: self._collect())
        viewport.wipe_moved.connect(self._on_wiped)

    def show(self, project: Project, scene: Scene, handles: tuple[Handle, ...]) -> None:
        """Show `scene`, which is that of `project`, as its look says."""
        look = project.look
        modes: tuple[Mode, ...] = (mode_of(look.mode, project), mode_of(look.against, project))
        if not look.comparing or modes[0] == modes[1]:
            modes = modes[:1]
        before = self._project.look.bounces if self._project is not None else None
        is_new = self._scene is None or not same(dataclasses.replace(self._scene, camera=scene.camera), scene)
        if is_new or modes != self.modes or before != look.bounces:
            self._forget(keep_reference=not is_new and before == look.bounces)
        self._project, self._scene, self.modes = project, scene, modes
        self._split()
        light_deg = (look.light_theta_deg, look.light_phi_deg)
        shown = scene_of(modes[0], scene, self.relit_of(modes[0].value, scene))
        self.viewport.show_scene(shown, look.exposure_ev, look.tone_map, light_deg, handles)
        self._lay_over()
        self.progressed.emit()

    def relit(self) -> None:
        """Baked light is another one: what was read of the images is out of date, and the reference is not."""
        self._forget(keep_reference=True)

    def _split(self) -> None:
        """Tell the viewport what is beside the first image, and how."""
        if len(self.modes) < 2 or self._scene is None or self._project is None:
            self.viewport.show_beside(None, Split())
            return
        is_difference = self._project.look.comparing == "difference"
        split = Split(None, self.scale) if is_difference else Split(self.wipe)
        names = (self.modes[0].label, self.modes[1].label)
        relit = self.relit_of(self.modes[1].value, self._scene)
        self.viewport.show_beside(scene_of(self.modes[1], self._scene, relit), split, names)

    def _on_wiped(self, share: float) -> None:
        self.wipe = share
        self._split()
        self.viewport.redraw()

    def _on_moved(self) -> None:
        """The camera is another one: what was found is of another image."""
        self._forget(keep_reference=False)

    def _forget(self, *, keep_reference: bool) -> None:
        self._drawn.clear()
        self.comparing.drop()
        self._settled.stop()
        self._flip_at = 0
        self._judged = None
        self.viewport.overlay.show_preparing(True)
        if not keep_reference:
            self.reference.drop()
        if self.error is not None:
            self.error = None
            self.error_found.emit(None)
        self.progressed.emit()

    @property
    def progressive(self) -> int | None:
        """The index of the image that is the reference."""
        return next((at for at, mode in enumerate(self.modes) if mode.progressive), None)

    @property
    def progress(self) -> str:
        """The progress of the reference, in a few words; empty if it is not shown."""
        if self.progressive is None:
            return ""
        words = f"reference {progress_text(self.reference.found)}"
        return f"{words}, stopped" if self.reference.stopped else words

    @property
    def is_unseen(self) -> bool:
        """True if the image is compared with a reference that is not shown."""
        is_alone = len(self.modes) == 1 and self.progressive is None
        return self.measuring and is_alone and not self.why_no_error

    @property
    def why_no_error(self) -> str:
        """The reason why there is nothing to compare the image with; empty where there is."""
        if self._project is None:
            return ""
        without = [mode.label for mode in self.modes if not shows_near_lamps(mode)]
        if self._project.look.near_lamps and without:
            return f"{without[0]} does not show the near lights, which the reference shows"
        if self._project.variations and any(self._shows_variations(mode) for mode in self.modes):
            return "The reference does not show spatial variation of the BRDF"
        return next((why_not(mode, self._project) for mode in modes() if mode.progressive), "")

    def _shows_variations(self, mode: Mode) -> bool:
        project, scene = self._project, self._scene
        if project is None or scene is None or not mode.baked:
            return False
        return len(list_left_out_by(mode.value, scene.brdf, project.variations)) < len(project.variations)

    def measure(self, measuring: bool) -> None:
        """Ask for the error of a mode that is shown alone, or no longer."""
        if measuring == self.measuring:
            return
        self.measuring = measuring
        if len(self.modes) < 2:
            self._forget(keep_reference=self.progressive is not None)
            self._collect()

    def _on_rested(self) -> None:
        scene, project = self._seen(), self._project
        if self.progressive is not None and scene is not None and project is not None and self.viewport.isVisible():
            self._is_small = False
            self.reference.want(scene, reference_size(self.viewport.screen_px()), project.look.bounces)
            self.reference.hold(False)
            self._lay_over()
        self._collect()

    def _seen(self) -> Scene | None:
        """The scene with the camera that it is seen with."""
        camera = self.viewport.camera
        return dataclasses.replace(self._scene, camera=camera) if self._scene is not None and camera else None

    def _begin_unseen(self) -> None:
        """Measure the error of the image, once nothing else is to be done."""
        scene, project = self._seen(), self._project
        if scene is None or project is None or not self.is_unseen or not self.viewport.isVisible():
            return
        if any(job.state != "paused" and not self.reference.is_run_by(job) for job in self.reference.jobs.active):
            self._settled.start()
            return
        if not self.reference.serves(scene, project.look.bounces):
            self._is_small = True
            self.reference.want(scene, size_of(self.viewport.screen_px()), project.look.bounces)
        self.reference.hold(False)
        self._compare()

    def give_up(self) -> None:
        """Nobody looks any more."""
        self._forget(keep_reference=False)

    def _on_improved(self) -> None:
        self._lay_over()
        self._collect()  # the last image that was awaited may be the one that the reference covers now
        self.progressed.emit()
        self._compare()

    def _lay_over(self) -> None:
        """Lay the reference over the image that stands for it, and over no other."""
        found, side = self.reference.found, self.progressive
        is_shown = found is not None and found.samples >= SHOWN_FROM and not self._is_small
        image = found.image if found is not None and is_shown else None
        for at in range(2):
            self.viewport.show_over(at, image if at == side else None)

    def _collect(self) -> None:
        """Read back the image that OpenGL has finished, once."""
        side = next((at for at, mode in enumerate(self.modes) if not mode.progressive and at not in self._drawn), None)
        surface = self.viewport.surface
        is_compared = len(self.modes) == 2 or self.is_unseen
        if not is_compared or side is None or self.comparing.reading or not surface.is_finished:
            return

        def keep(pixels: Pixels) -> None:
            self._drawn[side] = pixels
            self._collect()
            if self.is_unseen:
                self._settled.start()
            self._compare()

        self.comparing.read(surface.strips(side), keep)

    def _compare(self) -> None:
        """Ask for the error of the first image against the second, if both are there."""
        sides: list[Side] = []
        found, is_new = self.reference.found, True
        exact = found if found is not None and found.parts is not None else None
        for at, mode in enumerate(self.modes):
            if not mode.progressive and at in self._drawn:
                sides.append(Side(self._drawn[at]))
            if (mode.progressive or self.is_unseen) and exact is not None:
                sides.append(
                    Side(exact.image, 0.0 if exact.variance is None else exact.variance, exact.samples, exact.parts)
                )
                is_new = exact.samples >= 2 * self._flip_at or not self.reference.running
        with_flip = is_new and len(sides) == len(self.modes) == 2
        if exact is not None and exact.parts is self._judged and not with_flip:
            return  # nothing else would be found
        if len(sides) == 2:
            self._judged = exact.parts if exact is not None else None
            if with_flip and found is not None:
                self._flip_at = found.samples
            self.comparing.compare(*sides, with_flip=with_flip)
        elif len(sides) == 1 and len(self.modes) == 1 and self.progressive is not None:
            self._judged = exact.parts if exact is not None else None
            self.comparing.weigh(sides[0])

    def _found(self, error: ImageError) -> None:
        if error.flip is None and self.error is not None:
            error = dataclasses.replace(error, flip=self.error.flip)
        self.error = error
        if self.is_unseen:
            self.reference.hold(error.is_certain or error.samples >= MAX_UNSEEN)
        self.viewport.overlay.show_preparing(False)
        self.error_found.emit(error)
        is_difference = self._project is not None and self._project.look.comparing == "difference"
        if error.scale not in (0.0, self.scale):
            self.scale = error.scale
            if is_difference:
                self._split()
                self.viewport.redraw()


def reference_size(screen: tuple[int, int]) -> tuple[int, int]:
    """Width and height of the reference for a screen of so many pixels."""
    share: Any = min(1.0, (MAX_PIXELS / (screen[0] * screen[1])) ** 0.5)
    return max(1, round(screen[0] * share)), max(1, round(screen[1] * share))
