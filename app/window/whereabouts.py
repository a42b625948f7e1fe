"""Photographs of the open project that moved or changed: looked for in a job, named in a banner, found on request."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from functools import partial
from pathlib import Path

from PySide6.QtCore import QObject
from PySide6.QtWidgets import QFileDialog, QWidget

from app.commands.workbench import Workbench
from app.document.document import Project
from app.document.variation import images_of
from app.project.budget import secure_arrays
from app.project.photographs import (
    Checked,
    check,
    describe_changed,
    files_of,
    find_moved,
    keep,
    marks_of,
    name_files,
    photographs,
    relocate,
    take_marks,
)
from app.project.pixels import secure_pixels
from app.project.project_file import data_folder
from app.window.banner import Banners
from app.window.projects import Projects
from engine.capture.lights.sources import unpack_again
from engine.core.errors import FileError, UsageError
from engine.core.steps import Step, Steps

log = logging.getLogger(__name__)


class Whereabouts(QObject):
    """Watches over the photographs of one window's project. Nothing is imported anew by itself."""

    def __init__(self, bench: Workbench, projects: Projects, banners: Banners) -> None:
        super().__init__(banners)
        self.bench, self.projects, self.banners = bench, projects, banners
        self.missing: tuple[Path, ...] = ()
        projects.switched.connect(self.look)
        bench.document.changed.connect(self._changed)

    def look(self) -> None:
        """Look for the photographs of the project that is open now, and for changes in them."""
        self._say(Checked())
        self._say_lost()
        path, project, read_only = self.projects.path, self.bench.document.project, self.projects.is_read_only
        if not files_of(project):
            return
        job = self.bench.jobs.submit(
            "Looking for the photographs", lambda: look_for(path, project, read_only), lane="open"
        )
        job.succeeded.connect(lambda about: self._on_looked(path, about))

    def _on_looked(self, path: Path, about: Checked) -> None:
        if path == self.projects.path:
            self._say(about)

    def _changed(self, old: Project, new: Project) -> None:
        """Photographs that were just imported are as they are; others are there, or not.

        Images that the user just chose are marked, as photographs are by their import.
        """
        added = tuple(path for path in images_of(new.variations) if path not in images_of(old.variations))
        if added and not self.bench.document.undo_stack.canRedo() and not self.projects.is_read_only:
            path = self.projects.path
            self.bench.jobs.submit("Looking at the images", lambda: mark(path, added), lane="background")
        if new.stack is not old.stack:
            self.banners.say("changed", "")
            self._say_lost()
        if self.missing and (new.sources is not old.sources or new.variations != old.variations):
            self.look()

    def _say(self, about: Checked) -> None:
        self.missing = about.missing
        words = ""
        if about.missing:
            made = describe_contents(self.bench.document.project, len(about.missing))
            words = f"{name_files(about.missing)} missing{made}."
        self.banners.say("missing", words, ("Find…", self.choose))
        words = ""
        if about.changed:
            words = f"{describe_changed(about.changed)}. Nothing was made again."
        hide = partial(self.banners.say, "changed", "")
        self.banners.say("changed", words, ("Import again", self._import), ("Hide", hide))

    def _say_lost(self) -> None:
        """Offer to make again what the photographs led to, where it is gone from the data folder."""
        project = self.bench.document.project
        is_lost = project.sources is not None and project.stack is None and project.imported_with is not None
        words = f"{self.projects.lost}." if is_lost and self.projects.lost else ""
        hide = partial(self.banners.say, "lost", "")
        self.banners.say("lost", words, ("Import again", self._import), ("Hide", hide))

    def _import(self) -> None:
        project = self.bench.document.project
        if project.sources is not None:
            self.bench.import_photographs(project.sources, name=project.name)

    def choose(self) -> None:
        """Ask for the folder that the photographs moved to, and find them there."""
        window = self.banners.window()
        assert isinstance(window, QWidget)
        chosen = QFileDialog.getExistingDirectory(window, "Folder that the photographs moved to")
        if chosen:
            self.find(Path(chosen))

    def find(self, folder: Path) -> None:
        """Find the missing photographs within `folder`, all at once, for every step of the history."""
        path, missing, read_only = self.projects.path, self.missing, self.projects.is_read_only
        job = self.bench.jobs.submit(
            "Finding the photographs", lambda: find_again(path, missing, folder, read_only), lane="open"
        )
        job.succeeded.connect(lambda places: self._found(path, places))

    def _found(self, path: Path, places: dict[Path, Path]) -> None:
        if path != self.projects.path:
            return
        if places:
            self.projects.read_again(self.look)
        left = len(self.missing) - len(places)
        words = f"{len(places)} of {len(self.missing)} photographs found" if left else "All photographs found"
        self.bench.said.emit(words)


def describe_contents(project: Project, count: int) -> str:
    """The end of a sentence about `count` photographs that are missing: what is there of all that was made of them."""
    them = "it" if count == 1 else "them"
    if project.stack is not None:
        return f". What was made of {them} is here"
    return f". The material made of {them} is here" if project.has_map else f", and what was made of {them} as well"


def mark(path: Path, files: Sequence[Path]) -> Steps[None]:
    """Let the project know these files again."""
    marks = yield from take_marks(files)
    try:
        keep(path, marks)
    except FileError as error:
        log.info("images could not be marked: %s", error)


def look_for(path: Path, project: Project, read_only: bool) -> Steps[Checked]:
    """Compare the photographs of `project` with their marks, and note where those with marks are now.

    Those that came from an archive and went with the data folder are unpacked again, unless this is `read_only`.
    """
    files = files_of(project)
    about = yield from check(path, files)
    unpacked = project.sources.unpacked if project.sources is not None else None
    places = {each.parent for each in about.missing if each.is_relative_to(data_folder(path))}
    if unpacked is not None and unpacked.archive.is_file() and len(places) == 1 and not read_only:
        yield from unpack_again(unpacked, places.pop())
        about = yield from check(path, files)
    if about.new and not read_only:
        try:
            keep(path, about.new)
        except FileError as error:
            log.info("photographs could not be marked: %s", error)
    if project.stack is not None and project.stack.folder is not None and not read_only:
        own = photographs(project)
        are_gone = not {*about.missing, *about.changed}.isdisjoint(own)
        if project.stack.folder.parent == data_folder(path):
            yield from secure_pixels(project.stack, path, own, are_gone=are_gone)
            yield from secure_arrays(path, data_folder(path), own, are_gone=are_gone)
    return about


def find_again(path: Path, missing: Sequence[Path], folder: Path, read_only: bool) -> Steps[dict[Path, Path]]:
    """Note where within `folder` photographs are that are missing. UsageError where the project is `read_only`."""
    yield Step(0.0, "looking through the folder")
    if read_only:
        raise UsageError("This project is read-only; save it under another name first")
    unmarked = set(missing) - set(marks_of(path))
    places = yield from find_moved(path, missing, folder)
    relocate(path, places)
    yield from mark(path, [new for old, new in places.items() if old in unmarked])
    return places
