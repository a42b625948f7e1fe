"""Results that the open project had and that are gone from its data: made again in the background, without a step.

After a clean-up, or where the cache was emptied, the document opens with what is there; the material comes first, then
the maps of the surface. Pixels of photographs are read once the user looks at photographs: commands that compute with
them read them for themselves. Where photographs are missing nothing begins: the banner about them says so.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import QObject, QTimer, Signal

from app.commands.making import can_be_read, pixels_made
from app.commands.rebuilding import lacks_material, lacks_surface, material_again, surface_again
from app.commands.workbench import Workbench
from app.document.document import Project
from app.jobs.jobs import Job
from app.project.photographs import photographs
from app.project.pixels import are_there
from app.window.projects import Projects
from engine.capture.stack import ImageStack
from engine.core.errors import FileError
from engine.core.steps import Step, Steps

if TYPE_CHECKING:
    from engine.scene.material import Material
    from engine.surface.recover import Surface

log = logging.getLogger(__name__)


class Restoring(QObject):
    """Watches over the results of one window's project.

    Signals
    -------
    restored : the pixels of the stack had been gone, and are there again.
    """

    restored = Signal()

    def __init__(self, bench: Workbench, projects: Projects, shows_photographs: Callable[[], bool]) -> None:
        super().__init__(bench)
        self.bench, self.shows_photographs = bench, shows_photographs
        self._job: Job | None = None
        self._with_pixels: ImageStack | None = None
        self._tried: list[tuple[Any, ...]] = []
        self._found: dict[str, tuple[tuple[Any, ...], Any]] = {}
        self._soon = QTimer(self)  # all others have heard of a change when the next one follows
        self._soon.setSingleShot(True)
        self._soon.timeout.connect(self._look)
        projects.leaving.connect(self._forget)
        projects.switched.connect(self._change)
        bench.document.changed.connect(self._change)

    def _forget(self) -> None:
        """What was given up in one project may work in the next."""
        if self._job is not None:
            self.bench.jobs.drop(self._job)
        self._job = self._with_pixels = None
        self._tried.clear()
        self._found.clear()

    def look_again(self) -> None:
        """Look for the pixels of the stack: photographs came into view, or their pixels were found damaged."""
        self._with_pixels = None
        self._change()

    def _change(self, *_: object) -> None:
        self._soon.start(0)

    def _look(self) -> None:
        project = self.bench.document.project
        if self._job is not None and not self._job.over:
            return
        if lacks_material(project):
            self._begin("Rebuilding the material", project, project.built_from, material_again, self._take_material)
        elif self.shows_photographs() and not self._has_pixels(project):
            self._begin("Reading the photographs again", project, (project.stack,), _pixels_again, _take_nothing)
        elif lacks_surface(project):
            origin = project.surface_from or ()
            self._begin("Rebuilding surface maps", project, origin, surface_again, self._take_surface)

    def _has_pixels(self, project: Project) -> bool:
        """True if the pixels of a stack that was imported here can be read; the disk is asked once for each stack."""
        stack = project.stack
        if stack is not self._with_pixels and stack is not None and project.imported_with is not None:
            if not are_there(stack):
                return False
            self._with_pixels = stack
        return True

    def _begin(
        self,
        title: str,
        project: Project,
        recipe: tuple[Any, ...],
        make: Callable[[Project], Steps[Any]],
        take: Callable[[Project, Any], None],
    ) -> None:
        known, found = self._found.get(title, ((), None))
        if known == recipe and known:
            take(project, found)
            return
        if (title, *recipe) in self._tried:
            return
        self._tried.append((title, *recipe))
        self._job = self.bench.jobs.submit(title, lambda: _make(project, make), lane="background")
        self._job.progressed.connect(self._show_partial)
        self._job.succeeded.connect(lambda found: self._made(title, project, recipe, found, take))

    def _show_partial(self, step: Step) -> None:
        """Photographs that were read show as while they are imported."""
        if hasattr(step.partial, "thumbnail"):  # a material that is being built has other partial results
            self.bench.partial.emit(step.partial)

    def _made(
        self,
        title: str,
        project: Project,
        recipe: tuple[Any, ...],
        found: Any,
        take: Callable[[Project, Any], None],
    ) -> None:
        self._job = None
        if found is not None:
            self._found[title] = recipe, found
            take(project, found)
            self.restored.emit()
        self._soon.start(0)

    def _take_material(self, project: Project, material: Material) -> None:
        now = self.bench.document.project
        if lacks_material(now) and now.built_from == project.built_from:
            self.bench.document.complete(material=material.looking_like(now.material))

    def _take_surface(self, project: Project, surface: Surface) -> None:
        now = self.bench.document.project
        if lacks_surface(now) and now.surface_from == project.surface_from:
            self.bench.document.complete(surface=surface)


def _pixels_again(project: Project) -> Steps[bool]:
    assert project.stack is not None
    yield from pixels_made(project.stack, project.sources, project.imported_with)
    return True


def _take_nothing(_project: Project, _found: object) -> None:
    """Pixels are read where they lie."""


def _make(project: Project, make: Callable[[Project], Steps[Any]]) -> Steps[Any]:
    """The result; None where it cannot be made again, with a line in the log."""
    yield Step(0.0, "looking for the photographs")
    gone = [file for file in photographs(project) if not file.is_file()]
    if gone and not can_be_read(project):
        log.info("%s is missing (%d of the photographs): what was made of them stays gone", gone[0], len(gone))
        return None
    try:
        return (yield from make(project))
    except FileError as error:
        log.warning("%s", error)
        return None
