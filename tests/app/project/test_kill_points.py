"""A project is killed at its I/O operations, and at random moments in the window: nothing that was saved is lost."""

from __future__ import annotations

import json
import os
import random
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from app.document.document import Project
from app.project.project_file import History, Writer, read
from app.project.report import problems_of
from engine.core.steps import drain
from tests.app.conftest import NO_DISPLAY

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="needs fork and /proc")

#: Operations at which the suite kills; under --long every operation of six sessions more, 20,000 together.
POINTS = 150

#: Seconds until a kill in the window, at most, from the first gesture that was saved.
MOST_S = 2.0


@pytest.fixture
def quick() -> Iterator[Path]:
    """A folder in memory where there is one: SQLite synchronises, and that is none of the matter here."""
    memory = Path("/dev/shm")
    folder = Path(tempfile.mkdtemp(prefix="lightarc-", dir=memory if memory.is_dir() else None))
    yield folder
    shutil.rmtree(folder, ignore_errors=True)


@pytest.mark.campaign(rounds=7)
def test_every_acknowledged_gesture_is_there_whatever_operation_was_the_last(quick: Path, seed: int) -> None:
    points = POINTS if seed == 0 else 0
    command = [sys.executable, "-m", "tests.app.project.kill_points", str(quick / "a"), str(seed), str(points)]
    done = subprocess.run(command, capture_output=True, text=True, cwd=Path(__file__).parents[3])
    if "does not let its writes be watched" in done.stderr:
        pytest.skip("SQLite is built without a table of system calls")
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert found["failures"] == []
    assert found["operations"] > 40 * 40, "the operations of SQLite are among them"
    assert found["points"] >= 0.98 * (points or found["operations"])


@pytest.mark.skipif(NO_DISPLAY, reason="DISPLAY is not set: window tests need an X display (Xvfb)")
@pytest.mark.campaign(rounds=40)
def test_what_the_window_called_saved_is_there_after_a_kill_at_any_moment(quick: Path, seed: int) -> None:
    """The session goes on in the project that the kill before left; in the suite it is killed once."""
    path = quick / "a.lap"
    writer = Writer(path)
    writer.write(History(Project()))
    writer.close()
    chance = random.Random(seed)
    for kill in range(1 if seed == 0 else 5):
        killed_at_a_moment(path, quick, 100 * seed + kill, chance.uniform(0.0, MOST_S))


def killed_at_a_moment(path: Path, folder: Path, seed: int, wait_s: float) -> None:
    """Let the window work on the project, kill it, and look for what it said was saved."""
    places = {f"XDG_{name}_HOME": str(folder / name) for name in ("CACHE", "CONFIG", "DATA")}
    command = [sys.executable, "-m", "tests.app.project.window_session", str(path), str(seed)]
    said, errors, root = folder / f"said-{seed}.txt", folder / f"errors-{seed}.txt", Path(__file__).parents[3]
    states = {0: marks_of(path)}
    with said.open("w") as output, errors.open("w") as log:
        session = subprocess.Popen(command, env={**os.environ, **places}, cwd=root, stdout=output, stderr=log)
        while session.poll() is None and "saved" not in said.read_text():
            time.sleep(0.01)
        time.sleep(wait_s)
        session.kill()
        session.wait()
    lines = [line.split(" ", 2) for line in said.read_text().splitlines(keepends=True) if line.endswith("\n")]
    saved = [int(line[1]) for line in lines if line[0] == "saved"]
    assert saved, errors.read_text()
    states |= {int(line[1]): line[2].strip() for line in lines if line[0] == "did"}
    kept = [state for number, state in states.items() if number >= saved[-1]]
    assert marks_of(path) in kept, (marks_of(path), lines[-20:])
    assert not drain(problems_of(path))


def marks_of(path: Path) -> str:
    """The marks that `window_session` prints of a document."""
    opened = read(path)
    project = opened.current
    mesh = project.mesh.name if project.mesh is not None else ""
    light = project.environment.name if project.environment is not None else ""
    marks = (project.look.gain, project.look.mode, mesh, light, project.material.brdf, project.slices)
    return str((len(opened.steps), opened.position, *marks))
