"""Projects and files that were opened lately: shown with images, and marked where they are gone."""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from PySide6.QtCore import QByteArray, QObject
from PySide6.QtGui import QIcon, QImage, QImageReader, QPixmap
from PySide6.QtWidgets import QMenu

from app.commands.workbench import Workbench
from app.project.places import is_untitled
from app.project.project_file import ENDING
from app.project.thumbnail import SIZE, keep_thumbnail, list_image_parts, thumbnail_of, title_of
from app.widgets import theme
from app.window.projects import Projects
from engine.core.errors import FileError
from engine.core.escape import escape_controls
from engine.core.steps import Steps

log = logging.getLogger(__name__)

#: Height of the images in the menu, in pixels.
HEIGHT = 36

#: Entries of the menu for projects, and for files.
MAX_ENTRIES = 8

#: Largest file of an image that is read, in bytes.
MAX_BYTES = 1 << 20


def fill(menu: QMenu, projects: Sequence[str], files: Sequence[str], open_path: Callable[[Path], None]) -> None:
    """Entries for the latest projects, then for files: image, name, and folder; one that is gone cannot be chosen."""
    menu.clear()
    menu.setStyleSheet(f"QMenu {{ icon-size: {HEIGHT * SIZE[0] // SIZE[1]}px; }}")
    for paths in (projects[:MAX_ENTRIES], files[:MAX_ENTRIES]):
        for text in paths:
            path = Path(text)
            is_there = path.exists()
            name = escape_controls(name_of_file(path) if is_there else f"{path.name} (missing)").replace("&", "&&")
            folder = escape_controls(str(path.parent if not is_untitled(path) else path.stem))
            entry = menu.addAction(f"{name}\t{folder}")
            entry.setIcon(QIcon(image_of_file(path)))
            entry.setEnabled(is_there)
            entry.setToolTip(escape_controls(text))
            entry.triggered.connect(lambda _checked=False, path=path: open_path(path))
        if paths is not files and projects and files:
            menu.addSeparator()
    if not projects and not files:
        menu.addAction("Nothing yet").setEnabled(False)


def name_of_file(path: Path) -> str:
    """The name of a file; of a project without a name of its own that of its material."""
    return (title_of(path) if is_untitled(path) else "") or path.name.removesuffix(ENDING)


def image_of_file(path: Path) -> QPixmap:
    """The image of a project, or an icon for what a path leads to."""
    found = thumbnail(path)
    if not found.isNull():
        return QPixmap.fromImage(found)
    name = "capture" if path.is_dir() else "material" if path.name.endswith(ENDING) else "bundle"
    return theme.pixmap(name, HEIGHT // 2, theme.current().secondary)


def thumbnail(path: Path) -> QImage:
    """The small image of the project at `path`, on any thread; a null image where it has none that can be read.

    The file is not trusted: it is read as PNG alone, and its size is looked at before its pixels are decoded.
    """
    beside = thumbnail_of(path)
    try:
        is_read = path.name.endswith(ENDING) and beside.is_file() and beside.stat().st_size < MAX_BYTES
    except OSError:
        is_read = False
    if is_read:
        reader = QImageReader(str(beside), QByteArray(b"png"))
        if reader.size().isValid() and reader.size().width() <= SIZE[0] and reader.size().height() <= SIZE[1]:
            return reader.read()
    return QImage()


class Picturing(QObject):
    """Keeps the small image of the open project up to date, in jobs."""

    def __init__(self, bench: Workbench, projects: Projects) -> None:
        super().__init__(projects)
        self.bench, self.projects = bench, projects
        self._last: tuple[object, ...] = ()
        projects.switched.connect(self._on_switched)
        projects.changed.connect(self._look)

    def _on_switched(self) -> None:
        is_imaged = thumbnail_of(self.projects.path).is_file()
        self._last = list_image_parts(self.bench.document.project) if is_imaged else ()

    def _look(self) -> None:
        """Make an image of what is on disk now, if it is another than the last."""
        project, path = self.bench.document.project, self.projects.path
        parts = list_image_parts(project)
        is_same = len(parts) == len(self._last) and all(a is b for a, b in zip(parts, self._last, strict=True))
        if is_same or not self.projects.is_saved or all(part is None for part in parts):
            return
        self._last = parts
        work: Callable[[], Steps[None]] = partial(keep_thumbnail, path, project)
        self.bench.jobs.submit("Making a small image", lambda: _quietly(work()), lane="background", refines=True)


def _quietly(work: Steps[None]) -> Steps[None]:
    """`work`, whose failure is only logged: the list has an icon then."""
    try:
        yield from work
    except FileError as error:
        log.info("no image of the project is kept: %s", error)
