"""The open project after a crash: a banner says that it is whole, and names the jobs that were cut off.

The project is shown by its image, and jobs that can go on do so at a button.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

from PySide6.QtCore import QObject

from app.project.interrupted import Interrupted as Job
from app.project.interrupted import forget, interrupt_in
from app.project.project_file import data_folder
from app.window.banner import Banners
from app.window.projects import Projects
from app.window.recent import image_of_file

CAUSE = "interrupted"

#: Kinds that ask where to write, and wait for the answer: they come after all others.
ASKING = ("bundle", "exports")


class Interrupted(QObject):
    """Watches over the projects that one window opens."""

    def __init__(
        self, projects: Projects, banners: Banners, ways: Mapping[str, Callable[[Mapping[str, Any]], object]]
    ) -> None:
        """`ways` go on with a job, by the kind that it says (`app.jobs.jobs.Job.again`)."""
        super().__init__(banners)
        self.projects, self.banners, self.ways = projects, banners, ways
        self.jobs: tuple[Job, ...] = ()
        self.is_recovered = False
        projects.switched.connect(self.look)

    def look(self) -> None:
        """Say what the project that is open now was left with; jobs of a second window are not its own."""
        self.is_recovered = self.projects.is_recovered
        self.jobs = () if self.projects.is_read_only else interrupt_in(data_folder(self.projects.path))
        self._say()

    def _say(self) -> None:
        names = ", ".join(lower(job.title) for job in self.jobs)
        words = f"Lightarc ended unexpectedly in the middle of this work: {names}." if self.jobs else ""
        if self.is_recovered:
            words = (
                f"{words or 'Lightarc ended unexpectedly.'} {self.projects.shown_name} is as you left it{self._last()}."
            )
        able = [job for job in self.jobs if str(job.again.get("kind")) in self.ways]
        offers = [("Resume" if len(able) == 1 else "Resume all", partial(self.go_on, able))] if able else []
        image = image_of_file(self.projects.path) if words else None
        self.banners.say(CAUSE, words, *offers, ("Hide", self.hide), image=image)

    def _last(self) -> str:
        """The last step of the history, within a sentence."""
        step = self.projects.bench.document.undo_stack.undoText()
        return f", after “{step}”" if step else ""

    def go_on(self, jobs: Sequence[Job]) -> None:
        """Go on with jobs where they were, or begin anew those that kept nothing."""
        self.jobs = tuple(each for each in self.jobs if each not in jobs)
        self._say()
        for job in sorted(jobs, key=lambda job: job.again["kind"] in ASKING):
            forget(job)
            self.ways[str(job.again["kind"])](job.again)

    def hide(self) -> None:
        """Forget them all."""
        for job in self.jobs:
            forget(job)
        self.jobs, self.is_recovered = (), False
        self._say()


def lower(title: str) -> str:
    """'baking wavelets', within a sentence."""
    return title[:1].lower() + title[1:]
