"""Projects and files that were opened lately: shown with pictures, and marked where they are gone."""

from __future__ import annotations

import contextlib
import logging
from collections.abc import Callable
from functools import partial
from pathlib import Path

from PySide6.QtCore import QObject
from PySide6.QtGui import QIcon, QImageReader, QPixmap
from PySide6.QtWidgets import QMenu

from app.commands.workbench import Workbench
from app.project.places import is_untitled
from app.project.project_file import ENDING
from app.project.report import identity
from app.project.thumbnail import SIZE, keep_thumbnail, pictured, thumbnail_of
from app.widgets import theme
from app.window.projects import Projects
from engine.core.errors import FileError
from engine.core.steps import Steps

log = logging.getLogger(__name__)

#: Height of the pictures in the menu, in pixels.
HEIGHT = 36

#: Largest file of a picture that is read, in bytes.
MOST_BYTES = 1 << 20


def fill(menu: QMenu, recent: tuple[str, ...], open_path: Callable[[Path], None]) -> None:
    """An entry for each path: picture, name, and folder; one that is gone says so and cannot be chosen."""
    menu.clear()
    menu.setStyleSheet(f"QMenu {{ icon-size: {HEIGHT * SIZE[0] // SIZE[1]}px; }}")
    for text in recent:
        path = Path(text)
        is_there = path.exists()
        name = (_name(path) if is_there else f"{path.name} (missing)").replace("&", "&&")
        entry = menu.addAction(f"{name}\t{path.parent if not is_untitled(path) else path.stem}")
        entry.setIcon(QIcon(picture_of_file(path)))
        entry.setEnabled(is_there)
        entry.setToolTip(text)
        entry.triggered.connect(lambda _checked=False, path=path: open_path(path))
    if not recent:
        menu.addAction("Nothing yet").setEnabled(False)


def _name(path: Path) -> str:
    """The name of a file; of a project without a name of its own that of its material."""
    if is_untitled(path):
        with contextlib.suppress(FileError, KeyError):
            return str(identity(path)["name"])
    return path.name.removesuffix(ENDING)


def picture_of_file(path: Path) -> QPixmap:
    """The picture of a project, or an icon for what a path leads to."""
    beside = thumbnail_of(path)
    if path.name.endswith(ENDING) and beside.is_file() and beside.stat().st_size < MOST_BYTES:
        reader = QImageReader(str(beside))
        if reader.size().width() <= SIZE[0] and reader.size().height() <= SIZE[1]:
            found = QPixmap.fromImage(reader.read())
            if not found.isNull():
                return found
    name = "capture" if path.is_dir() else "material" if path.name.endswith(ENDING) else "bundle"
    return theme.pixmap(name, HEIGHT // 2, theme.current().secondary)


class Picturing(QObject):
    """Keeps the small picture of the open project up to date, in jobs."""

    def __init__(self, bench: Workbench, projects: Projects) -> None:
        super().__init__(projects)
        self.bench, self.projects = bench, projects
        self._last: tuple[object, ...] = ()
        projects.switched.connect(self._switched)
        projects.changed.connect(self._look)

    def _switched(self) -> None:
        is_pictured = thumbnail_of(self.projects.path).is_file()
        self._last = pictured(self.bench.document.project) if is_pictured else ()

    def _look(self) -> None:
        """Make a picture of what is on disk now, if it is another than the last."""
        project, path = self.bench.document.project, self.projects.path
        parts = pictured(project)
        is_same = len(parts) == len(self._last) and all(a is b for a, b in zip(parts, self._last, strict=True))
        if is_same or not self.projects.is_saved or all(part is None for part in parts):
            return
        self._last = parts
        work: Callable[[], Steps[None]] = partial(keep_thumbnail, path, project)
        self.bench.jobs.submit("Making a small picture", lambda: _quietly(work()), heavy=False)


def _quietly(work: Steps[None]) -> Steps[None]:
    """`work`, whose failure is only logged: the list has an icon then."""
    try:
        yield from work
    except FileError as error:
        log.info("no picture of the project is kept: %s", error)
