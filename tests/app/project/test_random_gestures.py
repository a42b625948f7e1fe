"""Random gestures through the window, twenty kinds of them: after each the project on disk is the one that is shown.

A run mixes what a user does (light, model, undo, import, build, save as, collect, open another project) with what
happens to files meanwhile: the data folder or the whole project is deleted, photographs move, the clock jumps. Names
are hostile. Every problem that the window reports has to be one that a user can mend.
"""

from __future__ import annotations

import dataclasses
import random
import shutil
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from app.document.document import Project
from app.project.project_file import data_folder, read, state_name
from app.window.main_window import MainWindow
from app.window.top_bar import WORKSPACES
from engine.core.errors import FileError, LightarcError
from tests.app.opening import open_project

GESTURES = 30
FAR_MS = 240_000

#: Names of folders and projects, of which the first six are those of folders.
NAMES = (
    'it\'s "quoted"',
    "new\nline",
    "🧵 felt",
    " leading and trailing ",
    "a%20b?#c",
    "semi;'--",
    "ﬀ\u202erev",
    "-o",
    ".hidden",
    "tab\there",
    "e\u0301",
    "x" * 200,
    "y" * 238,
)

#: Weights of gestures, where they are not 1.
OFTEN = {
    "light": 3.0,
    "workspace": 1.5,
    "capture": 0.8,
    "anew": 0.7,
    "collect": 0.5,
    "move_photographs": 0.5,
    "lose_data": 0.5,
    "lose_all": 0.5,
    "turn_the_clock": 0.3,
}

#: Parts of a document that lie in the project file itself, whatever becomes of the data beside it.
PLAIN = ("name", "notes", "look", "excluded", "slices", "mixed", "import_choices", "bakes")


class Hand:
    """The hand of a user in `window`, and the fate of the files in `folder`."""

    def __init__(self, window: MainWindow, qtbot: Any, folder: Path, photographs: Path, seed: int) -> None:
        self.window, self.qtbot, self.folder = window, qtbot, folder
        self.document = window.bench.document
        self.chance = random.Random(seed)
        self.capture_folder = folder / self.chance.choice(NAMES[:6]) / "capture"
        shutil.copytree(photographs, self.capture_folder)
        self.written: set[Path] = set()
        self.left: dict[Path, dict[str, Any]] = {}
        self.done: list[str] = []
        self.clock_s = 0.0

    @property
    def gestures(self) -> tuple[Callable[[], object], ...]:
        return (
            self.light,
            self.model,
            self.undo,
            self.redo,
            self.notes,
            self.name,
            self.capture,
            self.exclude,
            self.build,
            self.anew,
            self.open,
            self.save_as,
            self.collect,
            self.workspace,
            self.camera,
            self.slices,
            self.move_photographs,
            self.lose_data,
            self.lose_all,
            self.turn_the_clock,
        )

    def go(self) -> None:
        """Do some gestures, and look at the disk after many of them."""
        weights = [OFTEN.get(gesture.__name__, 1.0) for gesture in self.gestures]
        for _ in range(GESTURES):
            (gesture,) = self.chance.choices(self.gestures, weights)
            self.done.append(gesture.__name__)
            gesture()
            if self.chance.random() < 0.6:
                self.rest()
                if self.chance.random() < 0.5:
                    self.look_at_disk()
        self.rest()
        self.look_at_disk()

    def rest(self) -> None:
        """Wait until nothing runs, and everything is on disk."""
        projects = self.window.projects
        self.window.view.come_to_rest()
        self.qtbot.waitUntil(lambda: not self.window.bench.jobs.active, timeout=FAR_MS)
        self.qtbot.waitUntil(lambda: projects.is_saved or projects.is_read_only, timeout=FAR_MS)

    def look_at_disk(self) -> None:
        """Compare the project file with what the window shows."""
        projects, document = self.window.projects, self.document
        if projects.is_read_only:
            return
        self.qtbot.waitUntil(projects.path.is_file, timeout=FAR_MS)
        self.rest()
        found, folder = read(projects.path), data_folder(projects.path)
        assert (found.position, len(found.steps)) == (document.undo_stack.index(), document.undo_stack.count())
        assert plain(found.current) == plain(document.project)
        assert found.missing or state_name(found.current, folder) == state_name(document.project, folder)
        self.written.add(projects.path)

    def light(self) -> None:
        look = dataclasses.replace(self.document.project.look, light_theta_deg=self.chance.uniform(0.0, 90.0))
        self.document.change("Light", gesture=self.chance.choice(["", "light"]), look=look)

    def model(self) -> None:
        self.window.bench.load_model(self.chance.choice(["sphere", "plane", "torus-knot"]))

    def undo(self) -> None:
        for _ in range(self.chance.randint(1, 4)):
            self.window.undo.trigger()

    def redo(self) -> None:
        for _ in range(self.chance.randint(1, 4)):
            self.window.redo.trigger()

    def notes(self) -> None:
        self.document.change("Notes", notes=self.chance.choice(NAMES) * self.chance.randint(1, 50))

    def name(self) -> None:
        self.document.change("Name", name=self.chance.choice(NAMES))

    def slices(self) -> None:
        self.document.change("Slices", slices=self.chance.randrange(2, 16))

    def capture(self) -> None:
        self.window.bench.open_photographs([self.capture_folder])

    def exclude(self) -> None:
        stack = self.document.project.stack
        if stack is not None:
            self.window.bench.set_excluded([self.chance.choice(list(stack.sources))], self.chance.random() < 0.7)

    def build(self) -> None:
        self.window.bench.build_material()

    def leave(self) -> None:
        """Remember how the project is left that is open now."""
        self.window.view.come_to_rest()
        self.left[self.window.projects.path] = plain(self.document.project)

    def anew(self) -> None:
        self.leave()
        self.window.new()

    def open(self) -> None:
        """Open a project that was open before: it is as it was left."""
        if not self.written:
            return
        path = self.chance.choice(sorted(self.written))
        projects = self.window.projects
        projects.leaving.connect(self.leave)  # jobs may end while the project is read
        open_project(self.window, self.qtbot, path)
        projects.leaving.disconnect(self.leave)
        if self.window.projects.path == path and path in self.left:
            assert plain(self.document.project) == self.left[path]

    def save_as(self) -> None:
        target = self.folder / self.chance.choice(NAMES[:6]) / f"{self.chance.choice(NAMES)}.lap"
        target.parent.mkdir(exist_ok=True)
        self._write(self.window.projects.copy_to, target)

    def collect(self) -> None:
        target = self.folder / f"collected {self.chance.choice(NAMES)}.lap"
        with_derived = self.chance.random() < 0.5
        self._write(lambda path: self.window.projects.collect_to(path, with_derived=with_derived), target)

    def _write(self, write: Callable[[Path], None], target: Path) -> None:
        """Write where that can be; a place that cannot be is refused in a sentence."""
        for path in (target, self.window.projects.path):
            self.left.pop(path, None)
        try:
            write(target)
        except FileError as error:
            self.done.append(f"refused: {error}")

    def workspace(self) -> None:
        self.window.show_workspace(self.chance.choice(list(WORKSPACES)))

    def camera(self) -> None:
        if self.window.view.viewport.camera is not None:
            self.window.view.viewport.turn(self.chance.uniform(-1.0, 1.0), 0.1)

    def move_photographs(self) -> None:
        place = self.capture_folder.with_name(self.chance.choice(["capture", "moved", "moved again"]))
        if not place.exists():
            self.capture_folder = self.capture_folder.rename(place)

    def lose_data(self) -> None:
        shutil.rmtree(data_folder(self.window.projects.path), ignore_errors=True)

    def lose_all(self) -> None:
        self.lose_data()
        self.window.projects.path.unlink(missing_ok=True)

    def turn_the_clock(self) -> None:
        self.clock_s = self.chance.choice([-1e9, 0.0, 1e8])


def plain(project: Project) -> dict[str, Any]:
    """The parts that the project file holds itself, by name."""
    return {name: getattr(project, name) for name in PLAIN}


@pytest.mark.long
@pytest.mark.campaign(rounds=25)
def test_the_project_on_disk_is_the_one_that_is_shown_after_any_gestures(
    window: MainWindow, qtbot: Any, tmp_path: Path, photographs: Path, seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    reports: list[tuple[str, BaseException]] = []
    monkeypatch.setattr(window.failures, "report", lambda words, error: reports.append((words, error)))
    hand = Hand(window, qtbot, tmp_path, photographs, seed)
    monkeypatch.setattr("time.time", lambda: max(0.0, time.time_ns() / 1e9 + hand.clock_s))
    try:
        hand.go()
    finally:
        print(seed, " ".join(hand.done), *reports, sep="\n")
    assert [each for each in reports if not isinstance(each[1], LightarcError)] == []
