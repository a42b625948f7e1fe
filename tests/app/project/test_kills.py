"""Processes are killed while they bake, export, write bundles, collect and save: old or new is there, and whole.

A kill is a SIGKILL, at a random operation on the disk or after a random time, of the command line or of a window. After
each the target is read in another process; after the last the work is done once more, and nothing else may be left.
"""

from __future__ import annotations

import hashlib
import os
import random
import signal
import sys
import time
from collections.abc import Callable, Hashable
from contextlib import closing
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest

from app.document.document import Project
from app.project.project_file import ENDING, History, Writer
from engine.geometry.shapes import SHAPES
from engine.images.encode import encode_png
from engine.transport.baking.file_header import PAGE
from tests.app.conftest import NO_DISPLAY
from tests.app.project.conftest import folder_in_memory
from tests.app.project.sequences import NAMES, Action, Link, Play, read_project

pytestmark = [
    pytest.mark.skipif(sys.platform != "linux", reason="needs fork"),
    pytest.mark.skipif(NO_DISPLAY, reason="DISPLAY is not set: window tests need an X display (Xvfb)"),
]

#: Kills of a seed under --long, and in the suite.
KILLS, FEW = 8, 3

#: Seconds after which a bake or a save of a window is killed, at most.
LONGEST_S = 1.5

#: Kinds of work, one for each seed in turn.
KINDS = ("bake", "bundle", "export", "collect", "window bakes", "window saves")


@dataclass
class Work:
    """Verbs of the command line that replace one target by each other's result, and the results that they give."""

    server: Path
    home: Path
    verbs: tuple[list[str], list[str]]
    target: Path
    read: Callable[[Path], Hashable]
    whole: list[Hashable] = field(default_factory=list)
    operations: int = 0
    time_s: float = 0.0

    def run(self, at: int, dies_at: int = 0, after_s: float = 0.0) -> bool:
        """Run a verb, which dies at an operation or after a time unless that is 0; True if it came to its end."""
        begun = time.monotonic()
        first = {"folder": str(self.home), "verb": self.verbs[at], "dies_at": dies_at}
        with closing(Link(self.server, first)) as link:
            pid = link.hear()["pid"]
            if after_s and not link.has_line_within(after_s):
                os.kill(pid, signal.SIGKILL)
            event = link.hear()
            if event["event"] == "operations":
                self.operations, self.time_s = event["count"], time.monotonic() - begun
                event = link.hear()
        assert event["code"] in (0, -signal.SIGKILL), (self.home / "log.txt").read_text(errors="replace")[-2000:]
        return event["code"] == 0

    def content(self) -> Hashable:
        return self.read(self.target) if self.target.exists() else None


def killed(work: Work, kills: int, chance: random.Random) -> list[str]:
    """Faults found in `kills` deaths of `work`, each while the result that is not there replaces the one that is."""
    faults, names = [], []
    for at in (0, 1):
        assert work.run(at)
        work.whole.append(work.content())
        names.append(_names(work.target.parent))
    assert len(set(work.whole)) == 2, "the results differ"
    done, now = 0, 1
    while done < kills:
        by_operation = chance.random() < 0.5
        dies_at = chance.randint(1, work.operations) if by_operation else 0
        after_s = 0.0 if by_operation else chance.uniform(0.0, work.time_s)
        done += not work.run(1 - now, dies_at, after_s)
        found = work.content()
        if found not in work.whole:
            faults.append(f"after {dies_at or f'{after_s:.2f} s'}: {found} in place of {work.whole}")
        else:
            now = work.whole.index(found)
    for at in (1 - now, now):
        assert work.run(at)
        if work.content() != work.whole[at]:
            faults.append("the work does not go on to the same result")
    left = _names(work.target.parent) - names[now]
    return [*faults, *(f"{name} is left" for name in sorted(left))]


def _names(folder: Path) -> set[str]:
    return {str(path.relative_to(folder)) for path in folder.rglob("*")}


def _digest(path: Path) -> str:
    """The content of a file, or of all files of a folder with their names."""
    files = [path] if path.is_file() else sorted(each for each in path.rglob("*") if each.is_file())
    said = [str(each.relative_to(path)).encode() + each.read_bytes() for each in files]
    return hashlib.blake2b(b"\0".join(said)).hexdigest()[:16]


def _digest_unchecked(path: Path) -> str:
    """The content of a bake without the page of its check, which is written when the bake is there."""
    return hashlib.blake2b(path.read_bytes()[:-PAGE]).hexdigest()[:16]


def make(kind: str, server: Path, folder: Path) -> Work:
    """Small work of a kind, in `folder`."""
    given, out, home = (folder / name for name in ("given", "out", "home"))
    for each in (given, out, home):
        each.mkdir()
    names = ("old", "new")
    if kind == "bake":
        target = out / "plane.transport"
        common = ["bake", "plane", "--brdf", "lambert", "--mode", "sh", "-o", str(target)]
        return Work(server, home, ([*common, "--order", "3"], [*common, "--order", "4"]), target, _digest_unchecked)
    if kind == "collect":
        target = out / f"all{ENDING}"
        for name in names:
            writer = Writer(given / f"{name}{ENDING}")
            writer.write(History(Project(notes=name, mesh=SHAPES["plane"]())))
            writer.close()
        verbs = tuple(
            ["project", "collect", str(given / f"{name}{ENDING}"), "-o", str(target), "--overwrite"] for name in names
        )
        return Work(server, home, (verbs[0], verbs[1]), target, lambda path: _marks(server, path))
    for at, name in enumerate(names):
        (given / name).mkdir()
        for role, value in (("basecolor", 90 + 60 * at), ("roughness", 120)):
            image = np.full((8, 8, 3), value, np.uint8)
            (given / name / f"felt_{role}.png").write_bytes(encode_png(image))
    target = out / ("felt.lightarc" if kind == "bundle" else "felt")
    before, after = (["bundle", "make"], []) if kind == "bundle" else (["export"], ["--to", "materialx"])
    verbs = tuple([*before, str(given / name), *after, "-o", str(target)] for name in names)
    return Work(server, home, (verbs[0], verbs[1]), target, _digest)


def _marks(server: Path, path: Path) -> str:
    held = read_project(server, path)
    assert not held.get("problems"), held
    return str(held.get("marks", held))


def window_killed(kind: str, server: Path, folder: Path, kills: int, chance: random.Random) -> list[str]:
    """Faults found in windows that are killed while they bake or save; a last one ends the work."""
    play = Play(server, folder, folder)
    saved: Action = {"do": "wait_until_saved"}
    bake: list[Action] = [{"do": "bake", "method": "sh"}, {"do": "wait_until_baking"}]
    actions: list[Action] = [{"do": "model", "name": "sphere"}, {"do": "wait_for_model"}, saved, {"do": "kill"}]
    for at in range(kills):
        save: Action = {"do": "save_as", "target": chance.choice(NAMES)}
        actions += [{"do": "notes", "text": f"kill {at}"}, saved, *(bake if kind == "window bakes" else [save])]
        actions += [{"do": "kill", "pause_s": chance.uniform(0.0, LONGEST_S)}]
    if kind == "window bakes":
        actions += [*bake, {"do": "wait_for_bake"}, {"do": "quit"}]
    else:
        for name in NAMES:
            actions += [{"do": "save_as", "target": name}, {"do": "wait"}]
        actions += [{"do": "quit"}]
    faults = play.run(actions)
    assert len(play.killed) == kills + 1
    return [*faults, *play.left_behind(also_of_killed=True)]


@pytest.mark.campaign(rounds=24)
def test_whatever_is_killed_old_or_new_is_there(windows: Path, seed: int) -> None:
    kind, chance, kills = KINDS[seed % len(KINDS)], random.Random(seed), KILLS if seed else FEW
    with folder_in_memory() as folder:
        if kind.startswith("window"):
            assert window_killed(kind, windows, folder, kills, chance) == []
        else:
            assert killed(make(kind, windows, folder), kills, chance) == []
