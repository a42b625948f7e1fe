"""A name for work that is worth keeping and has none: a banner proposes one, once for each project of a session."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from PySide6.QtCore import QObject

from app.project.places import is_untitled
from app.project.recording import is_worth_keeping
from app.window.banner import Banners
from app.window.dialogs import propose_name
from app.window.projects import Projects

CAUSE = "name"


class Naming(QObject):
    """Watches over the projects of one window."""

    def __init__(self, projects: Projects, banners: Banners, save_as: Callable[[], object]) -> None:
        """`save_as` asks for a place."""
        super().__init__(banners)
        self.projects, self.banners, self.save_as = projects, banners, save_as
        self._is_later: set[Path] = set()
        projects.changed.connect(self._look)

    def _look(self) -> None:
        """Propose a name as soon as the work is on disk; nothing where the project has one, or where that can wait."""
        path, project = self.projects.path, self.projects.bench.document.project
        projects = self.projects
        is_wanted = is_untitled(path) and not (projects.is_read_only or projects.is_unchanged_example)
        if path in self._is_later or not (is_wanted and is_worth_keeping(project)):
            self.banners.say(CAUSE, "")
        elif projects.is_saved:
            words = "This project has no name yet. Save it to choose where it lives."
            self.banners.say(CAUSE, words, (f"Save as {propose_name(project)}…", self.save_as), ("Later", self.later))

    def later(self) -> None:
        """The user does not want to be asked about this project again."""
        self._is_later.add(self.projects.path)
        self._look()
