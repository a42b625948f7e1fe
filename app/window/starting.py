"""The start page in the window: what its examples, starting points and projects open."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path

from PySide6.QtCore import QObject
from PySide6.QtWidgets import QFileDialog

from app.commands.workbench import Workbench
from app.start.examples import Example, unpack
from app.start.page import StartPage
from app.window.files import Files
from app.window.projects import Projects
from app.window.recent import thumbnail

#: Names of the files that each starting point offers, and the workspace that it begins in.
FILES = {
    "brdf": ("BRDF or material", "brdf"),
    "model": ("Model and environment", "view"),
}


class Starting(QObject):
    """Owns the page and does what it asks for; a project that is open stays on disk."""

    def __init__(
        self, bench: Workbench, projects: Projects, files: Files, show_workspace: Callable[[str], object]
    ) -> None:
        super().__init__(projects)
        self.bench, self.projects, self.files, self.show_workspace = bench, projects, files, show_workspace
        settings = files.settings
        self.page = StartPage(
            bench,
            projects.folder,
            lambda: map(Path, settings.now.recent_projects),
            lambda: projects.path,
            projects.is_worth_keeping,
            thumbnail,
        )
        self.page.open_wanted.connect(self._open)
        self.page.example_wanted.connect(self.open_example)
        self.page.start_wanted.connect(self.start)
        self.page.renamed.connect(lambda old, new: settings.forget(old, instead=new))
        self.page.gone.connect(settings.forget)

    def _open(self, path: Path) -> None:
        self.files.open_project(path, lambda: self.show_workspace(workspace_of(self.bench)))

    def open_example(self, example: Example, workspace: str = "") -> None:
        """Open `example` as a new untitled project, in its own workspace or in another one."""
        folder = self.projects.folder
        job = self.bench.jobs.submit(f"Opening {example.title}", lambda: unpack(example, folder), lane="open")
        self.page.show_opening(example)
        job.succeeded.connect(partial(self._unpack, workspace or example.workspace))
        for ended in (job.failed, job.cancelled):
            ended.connect(lambda *_: self.page.show_opening(None))

    def _unpack(self, workspace: str, path: Path) -> None:
        self.page.show_opening(None)
        show = partial(self.show_workspace, workspace)
        self.files.leaving.then("Leave", lambda: self.projects.open(path, as_example=True, then=show))

    def start(self, name: str) -> None:
        """Ask for the files of a starting point and open them in a project of their own."""
        window, folder = self.files.window, self.files.settings.now.last_folder
        if name in FILES:
            title, workspace = FILES[name]
            chosen, _ = QFileDialog.getOpenFileNames(window, title, folder)
        else:
            workspace = "capture"
            found = QFileDialog.getExistingDirectory(window, "Folder of photographs", folder)
            chosen = [found] if found else []
        if not chosen:
            return

        def open_chosen() -> None:
            self.show_workspace(workspace)
            self.files.open([Path(path) for path in chosen])

        if self.projects.is_worth_keeping():
            self.files.begin_anew(open_chosen)
        else:
            open_chosen()


def workspace_of(bench: Workbench) -> str:
    """The workspace that shows the project which is open: the material on a model, else where its work stands."""
    project = bench.document.project
    if project.has_map or project.mesh is not None:
        return "view"
    return "brdf" if project.comparison.entries else "capture"
