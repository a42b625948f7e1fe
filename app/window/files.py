"""Commands of the File menu: projects and files that are opened, saved elsewhere, collected, and remembered."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from urllib.parse import unquote_to_bytes

from PySide6.QtCore import QObject, QUrl, Signal
from PySide6.QtWidgets import QFileDialog, QWidget

from app.commands.workbench import Arrival, Workbench
from app.jobs.jobs import Job
from app.project.database import Damaged
from app.project.photographs import files_of, outside_of
from app.project.project_file import ENDING
from app.session.settings import Remembered
from app.start.page import begin_clean_up
from app.window.arriving import ask_where
from app.window.dialogs import (
    ask_for_place,
    ask_to_open,
    ask_to_recover,
    ask_what_to_collect,
    propose_name,
    show_notes,
)
from app.window.failures import Failures, FilesExcluded
from app.window.leaving import Leaving
from app.window.projects import Projects, nothing
from engine.capture.doubts import Doubtful
from engine.core.errors import FileError, InputError


def local_path(url: QUrl) -> Path:
    """The path of a file that is dropped, byte by byte; Qt replaces what is not UTF-8 in its text."""
    if os.name != "posix":
        return Path(url.toLocalFile())
    return Path(os.fsdecode(unquote_to_bytes(url.path(QUrl.ComponentFormattingOption.FullyEncoded))))


def path_of(chosen: str) -> Path:
    """The file or folder that a dialog named.

    Qt replaces bytes that are not UTF-8 by U+FFFD, so that the one entry that reads like the name is meant. Raises
    InputError where several do, or none.
    """
    path = Path(chosen)
    if REPLACED not in chosen or path.exists():
        return path
    found = Path(path.anchor)
    for part in path.relative_to(path.anchor).parts:
        alike = [part]
        if REPLACED in part:
            try:
                alike = [name for name in os.listdir(found) if _as_qt_shows(name) == _as_qt_shows(part)]  # noqa: PTH208
            except OSError:
                alike = []
        if len(alike) != 1:
            raise InputError(path, "has a name that is not UTF-8", "Rename it, or drop it on the window")
        found /= alike[0]
    return found


#: What Qt shows in place of bytes that are not UTF-8.
REPLACED = "\ufffd"


def _as_qt_shows(name: str) -> str:
    """A name with one mark for bytes that are not UTF-8, however many there are."""
    return re.sub(f"{REPLACED}{{1,4096}}+", REPLACED, os.fsencode(name).decode("utf-8", "replace"))


class Files(QObject):
    """Runs them for `window`, and says in words where one fails. `choosing`: a dialog that chooses files opens."""

    choosing = Signal()

    def __init__(
        self,
        window: QWidget,
        bench: Workbench,
        projects: Projects,
        settings: Remembered,
        failures: Failures,
    ) -> None:
        super().__init__(window)
        self.window, self.bench, self.projects = window, bench, projects
        self.settings, self.failures = settings, failures
        self.leaving = Leaving(window, bench.jobs, projects)
        projects.changed.connect(self._remember_work)
        projects.moved.connect(settings.forget)
        projects.broken.connect(partial(failures.report, "The saved project cannot be opened"))
        projects.refused.connect(self._report_refused)
        projects.opened.connect(self._remember)
        bench.jobs.failed.connect(lambda _job, error: self._forget_failed(error))
        bench.arrived.connect(self._ask_where)
        bench.excluded.connect(self._report_excluded)

    def new(self) -> None:
        """Begin a new project; the one that was open stays on disk."""
        self.begin_anew(lambda: None)

    def clean_up(self, begun: Callable[[Job], object] = lambda _job: None) -> None:
        """Close the project, and remove from it what its photographs can give again; `begun` is called with the job.

        What an open project lacks is made again at once, so that it would stay as large as it is.
        """
        projects = self.projects
        path, name = projects.path, projects.shown_name
        if projects.is_read_only or projects.problem:
            self.bench.said.emit(f"{path.name} is not cleaned up: it {projects.why_read_only or 'cannot be written'}")
        elif projects.is_worth_keeping():
            self.begin_anew(lambda: begun(begin_clean_up(self.bench, path, name)))
        else:
            self.bench.said.emit("There is nothing to clean up in this project yet")

    def begin_anew(self, then: Callable[[], object]) -> None:
        """Begin a new project, once nothing holds this one any more, and call `then`."""

        def begin() -> None:
            self.projects.begin()
            self.bench.wanted.emit("capture")
            then()

        self.leaving.then("Leave", begin)

    def open(self, paths: Sequence[Path]) -> None:
        """Open `paths` by their content, and remember them."""
        try:
            paths = [path_of(str(path.absolute())) for path in paths]
        except InputError as error:
            self._report_refused(error)
            return
        if any(path.suffix.lower() == ENDING for path in paths):
            self.leaving.then("Leave", lambda: self._open(paths))
        else:
            self._open(paths)

    def _open(self, paths: Sequence[Path]) -> None:
        projects = [path for path in paths if path.suffix.lower() == ENDING]
        others = [path for path in paths if path not in projects]

        def open_others() -> None:
            if others:
                self.bench.open(others)
                self._remember(others[0] if len(others) == 1 else others[0].parent, others[0].parent)

        if not projects:
            open_others()
            return
        self.projects.open(projects[0], then=open_others)
        several = f"One project is open in a window, here {projects[0].name}. Open this one in another window"
        excluded = [InputError(path, "is a second project", several) for path in projects[1:]]
        if excluded:
            self._report_excluded(excluded, len(paths))

    def _ask_where(self, arrival: Arrival) -> None:
        ask_where(self.window, self.bench, self.begin_anew, arrival)

    def _report_excluded(self, errors: Sequence[InputError], count: int) -> None:
        """Say in a sentence for each which of `count` files were not opened, and why."""
        for error in errors if len(errors) == count else ():
            self._forget_failed(error)
        if len(errors) == 1:
            self.failures.report(f'Couldn\'t open "{Path(errors[0].path).name}"', errors[0])
        else:
            self.failures.report(f"Couldn't open {len(errors)} of {count} files", FilesExcluded(errors))

    def open_project(self, path: Path, then: Callable[[], object] = nothing) -> None:
        """Open a project in place of this one, which stays on disk, then call `then`."""
        self.leaving.then("Leave", lambda: self.projects.open(path, then=then))

    def _report_refused(self, error: FileError) -> None:
        path = Path(error.path)
        if isinstance(error, Damaged):
            ask_to_recover(self.window, error, partial(self._recover, path))
        else:
            self.failures.report(f'Couldn\'t open "{path.name}"', error)

    def _recover(self, damaged: Path) -> None:
        """Ask for a place, save there what is sound in a damaged project, and open it."""
        path = ask_for_place(self.window, "Recover", damaged.with_name(f"{damaged.stem} recovered{ENDING}"))
        if path is not None:
            self.projects.recover_to(damaged, path)

    def choose_project(self) -> None:
        """Ask for a project and open it."""
        self.choosing.emit()
        folder = self.settings.now.last_folder or str(self.projects.folder)
        ask_to_open(self.window, lambda path: self.open_project(path_of(str(path))), folder)

    def choose_files(self) -> None:
        """Ask for photographs, a mesh, measured BRDFs or a bundle, and open them."""
        self.choosing.emit()
        chosen, _ = QFileDialog.getOpenFileNames(self.window, "Open", self.settings.now.last_folder)
        self.open([Path(path) for path in chosen])

    def choose_folder(self) -> None:
        """Ask for a folder of photographs and open it."""
        self.choosing.emit()
        folder = self.settings.now.last_folder
        chosen = QFileDialog.getExistingDirectory(self.window, "Folder of photographs", folder)
        self.open([Path(chosen)] if chosen else [])

    def save(self) -> None:
        """Confirm that everything is on disk; of a project without a place of its own, ask for one."""
        if self.projects.is_untitled or self.projects.is_read_only:
            self.save_as()
        else:
            self.projects.confirm()

    def save_as(self) -> None:
        """Ask for a place, and go on in a copy of the project there."""
        self._on_written_to("Save as", self.projects.copy_to)

    def collect(self) -> None:
        """Ask for a place, and write a copy there with its photographs and, where wanted, what was made of them."""

        def to_place(with_derived: bool) -> None:
            self._on_written_to("Collect", partial(self.projects.collect_to, with_derived=with_derived))

        path = self.projects.path
        ask_what_to_collect(self.window, path, outside_of(path, files_of(self.bench.document.project)), to_place)

    def notes(self) -> None:
        """Show the user's own words about the project."""
        show_notes(self.window, self.bench)

    def _on_written_to(self, title: str, write: Callable[[Path], None]) -> None:
        folder = Path(self.settings.now.last_folder or Path.home())
        path = ask_for_place(self.window, title, folder / f"{propose_name(self.bench.document.project)}{ENDING}")
        if path is not None:
            try:
                write(path)
            except FileError as error:
                self.failures.report("The project cannot be written", error)

    def _remember(self, path: Path, folder: Path | None = None) -> None:
        """Remember a file, and the folder in which dialogs begin: not that of projects without a name."""
        if folder is None and path.parent == self.projects.folder:
            folder = Path(self.settings.now.last_folder or Path.home())
        self.settings.opened(path, folder or path.parent)

    def _forget_failed(self, error: BaseException) -> None:
        """Forget a file that could not be opened, and a folder where that is so of a file in it."""
        if not isinstance(error, InputError) or isinstance(error, Doubtful):
            return
        failed = Path(error.path)
        for text in self.settings.now.recent_files:
            if Path(text) in (failed, *failed.parents):
                self.settings.forget(Path(text))

    def _remember_work(self) -> None:
        """Remember the open project as soon as there is work in it."""
        path, now = self.projects.path, self.settings.now
        if now.recent_projects[:1] != (str(path),) and self.projects.is_saved and self.projects.is_worth_keeping():
            self._remember(path, Path(now.last_folder) if now.last_folder else None)
