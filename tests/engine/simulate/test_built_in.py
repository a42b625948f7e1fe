"""The built-in capture is kept, and made again where it is damaged."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from engine.core.steps import drain
from engine.simulate import built_in
from engine.simulate.arc import LightArc
from engine.simulate.built_in import make_built_in_sample


@pytest.fixture
def sample_arc(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(built_in, "LightArc", lambda: LightArc(size=32, elevation=(0.5, 1.5)))


def test_built_in_sample_is_made_once(tmp_path: Path, sample_arc: None) -> None:
    folder = drain(make_built_in_sample(tmp_path / "cache"))
    photograph = next(folder.glob("*.tif"))
    written = photograph.stat().st_mtime_ns
    assert drain(make_built_in_sample(tmp_path / "cache")) == folder
    assert photograph.stat().st_mtime_ns == written


@pytest.mark.parametrize(
    "damage",
    [
        lambda folder: next(folder.glob("*.tif")).write_bytes(b"II*"),
        lambda folder: next(folder.glob("*.tif")).unlink(),
        lambda folder: (folder / "capture.toml").write_text("notes = ''"),
        lambda folder: (folder / "truth" / "truth.json").write_text("[1, 2"),
        lambda folder: (folder / "truth" / "truth.json").write_text("[1, 2]"),
        lambda folder: (folder / "truth" / "truth.json").unlink(),
    ],
)
def test_fault_26_damaged_built_in_sample_is_made_again(tmp_path: Path, sample_arc: None, damage: Any) -> None:
    folder = drain(make_built_in_sample(tmp_path))
    good = {path.name: path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    damage(folder)
    assert drain(make_built_in_sample(tmp_path)) == folder
    assert {path.name: path.read_bytes() for path in folder.rglob("*") if path.is_file()} == good


def test_looking_for_it_loads_nothing_that_makes_it() -> None:
    """A user waits for every module that is loaded before the sample is seen."""
    words = "import sys, engine.simulate.built_in; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", words], capture_output=True, text=True, check=True)
    assert {"scipy", "numba", "cv2", "matplotlib"} & set(done.stdout.split()) == set()
