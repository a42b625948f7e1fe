"""Projects and photographs that users move, copy, collect and remove at random, from wherever a process stands.

What still exists somewhere is found, and a collected project needs nothing but itself. After each step all projects are
looked at: photographs that are where they were, or that moved as the project did, are there without a word; those that
moved otherwise are found in one look through the world, by content, beside others of the same names.
"""

from __future__ import annotations

import os
import random
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from app.document.document import Look, Project, Step
from app.project.copying import OutsideFiles, collect, copy
from app.project.photographs import Checked, files_of, find_moved, keep, photographs, relocate, take_marks
from app.project.project_file import History, Writer, data_folder, read
from app.project.report import problems_of
from app.window.whereabouts import look_for as looked_for
from engine.capture.lights.sources import find
from engine.core.steps import drain
from engine.images.encode import encode_png

STEPS = 25

FOLDERS = ("a", "a/deep er", "b", "ü & co", "c/d/e", "-x", "%20", "it's")
NAMES = ("Felt.lap", "felt 2.lap", "ﬀ.lap", "100%.lap")


@pytest.mark.campaign(rounds=200)
def test_photographs_are_found_wherever_folders_went(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, seed: int
) -> None:
    world = World(tmp_path / "world", random.Random(seed))
    for at in range(STEPS):
        monkeypatch.chdir(world.somewhere())
        world.step()
        monkeypatch.chdir(world.somewhere())
        world.check(f"seed {seed}, step {at}: {world.told}")


class World:
    """Folders with projects of three photographs, and what a user does to them."""

    def __init__(self, root: Path, chance: random.Random) -> None:
        self.root, self.chance, self.told = root, chance, list[str]()
        for name in FOLDERS:
            (root / name).mkdir(parents=True, exist_ok=True)
        self.images = [encode_png(np.full((4, 4, 3), 9000 * at + 4000, np.uint16)) for at in range(3)]
        self.folder = self.written(self.somewhere() / "photographs", self.images)
        self.written(root / "decoy" / "photographs", self.images[::-1])
        self.projects: dict[Path, bool] = {}  # each with True if it was collected
        self.projects[self.begun(self.somewhere() / NAMES[0])] = False

    def written(self, folder: Path, images: list[bytes]) -> Path:
        folder.mkdir(parents=True)
        for angle, image in zip((10, 50, 90), images, strict=True):
            (folder / f"felt_{angle}deg.png").write_bytes(image)
        return folder

    def begun(self, path: Path) -> Path:
        """A project of the photographs, with a step of history."""
        first = Project(sources=find([self.folder]), name="Felt")
        second = Project(sources=first.sources, look=Look(gain=1.5), name="Felt")
        writer = Writer(self.said(path))
        writer.write(History(second, (Step("Open", "", Project(), first), Step("Gain", "", first, second)), 2))
        writer.close()
        keep(path, drain(take_marks(photographs(second))))
        return path

    def somewhere(self) -> Path:
        return self.root / self.chance.choice(FOLDERS)

    def said(self, path: Path) -> Path:
        """`path` in full, or as seen from where the process stands."""
        return self.chance.choice((path, Path(os.path.relpath(path)), Path(os.path.relpath(path)).absolute()))

    def step(self) -> None:
        what: Callable[[Path], str] = self.chance.choice(
            (
                self.moved,
                self.photographs_moved,
                self.move_together,
                self.copy,
                self.collect,
                self.removed,
                self.turn,
            )
        )
        self.told.append(what(self.chance.choice(sorted(self.projects))))

    def free(self) -> Path:
        while True:
            path = self.somewhere() / self.chance.choice(NAMES)
            if not path.exists():
                return path

    def moved(self, project: Path) -> str:
        target = self.free()
        project.rename(target)
        data_folder(project).rename(data_folder(target))
        self.projects[target] = self.projects.pop(project)
        return f"{project} moved to {target}"

    def photographs_moved(self, _: Path) -> str:
        target = self.somewhere() / f"photographs {self.chance.randrange(1000)}"
        old, self.folder = self.folder, self.folder.rename(target)
        return f"{old} moved to {target}"

    def move_together(self, project: Path) -> str:
        """The folder of a project and its photographs is moved: they are there without being looked for."""
        if self.projects[project]:
            return self.turn(project)
        number = self.chance.randrange(10**6)
        home = self.root / f"home {number}"
        home.mkdir()
        self.folder = self.folder.rename(home / "photographs")
        target = home / project.name
        project.rename(target)
        data_folder(project).rename(data_folder(target))
        self.turn(target)
        away = home.rename(self.somewhere() / f"away {number}")
        self.folder, now = away / "photographs", away / project.name
        self.projects[now] = self.projects.pop(project)
        assert not self.opened(now).missing, f"{self.told}; {now}"
        return f"{project} moved to {now} with its photographs"

    def copy(self, project: Path) -> str:
        target = self.free()
        drain(copy(self.said(project), self.said(target)))
        self.projects[target] = self.projects[project]
        return f"{project} copied to {target}"

    def collect(self, project: Path) -> str:
        target = self.free()
        self.look_for(project)
        outside = [path for path in self.list_sorted_files(project) if not path.is_relative_to(project.parent)]
        if outside:  # these are copied only after they were shown
            with pytest.raises(OutsideFiles) as refused:
                drain(collect(self.said(project), self.said(target)))
            assert sorted(refused.value.files) == sorted(outside)
            assert not target.exists()
        drain(collect(self.said(project), self.said(target), include_outside=bool(outside)))
        self.projects[target] = True
        return f"{project} collected to {target}"

    def removed(self, project: Path) -> str:
        if len(self.projects) == 1:
            return self.turn(project)
        project.unlink()
        shutil.rmtree(data_folder(project))
        del self.projects[project]
        return f"{project} removed"

    def turn(self, project: Path) -> str:
        """Opened, and a parameter turned: the history is written again."""
        self.look_for(project)
        opened = read(self.said(project))
        now = Project(sources=opened.current.sources, look=Look(gain=self.chance.uniform(1.0, 2.0)), name="Felt")
        writer = Writer(self.said(project))
        writer.write(History(now, (*opened.steps, Step("Gain", "", opened.current, now)), len(opened.steps) + 1))
        writer.close()
        return f"a parameter of {project} turned"

    def opened(self, project: Path) -> Checked:
        """Photographs as the window finds them where it opens a project."""
        return drain(looked_for(self.said(project), read(self.said(project)).current, False))

    def look_for(self, project: Path) -> None:
        """Find what is missing in the whole world, as a user would who points at it."""
        about = self.opened(project)
        if about.missing:
            relocate(self.said(project), drain(find_moved(self.said(project), about.missing, self.said(self.root))))

    def check(self, told: str) -> None:
        for project, is_collected in self.projects.items():
            if not is_collected:
                self.look_for(project)
            for image, path in zip(self.images, self.list_sorted_files(project), strict=True):
                assert path.is_file(), f"{told}; {project}, {path}"
                assert path.read_bytes() == image, (told, project, path)
            assert drain(problems_of(self.said(project))) == [], (told, project)

    def list_sorted_files(self, project: Path) -> Iterator[Path]:
        return iter(sorted(files_of(read(self.said(project)).current), key=lambda path: path.name))
