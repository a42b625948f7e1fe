"""A project is killed at its I/O operations: nothing that was saved is lost. `test_sequences` kills the window."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="needs fork and /proc")

#: Operations at which the suite kills; under --long every operation of six sessions more, 20,000 together.
POINTS = 12


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
