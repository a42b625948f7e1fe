"""The built-in capture, ready made: made once, opened from then on, made again where it is damaged."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app.commands.sample import Sample, ready_sample, samples_folder
from app.document.document import Project
from app.window.main_window import MainWindow
from engine.core.steps import drain
from engine.figures import demo
from engine.simulate.arc import LightArc
from tests.present import present


@pytest.fixture
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    """A capture small enough for a test."""
    arc = LightArc(size=48, elevation=tuple(math.radians(angle) for angle in (10, 40, 90)))
    monkeypatch.setattr(demo, "LightArc", lambda: arc)


def opened(folder: Path, name: str) -> tuple[Sample, list[str]]:
    """The sample with its stack under `name`, and what was done for it."""
    notes: list[str] = []
    return drain(ready_sample(folder / "samples", folder / name), lambda step: notes.append(step.note)), notes


def test_the_sample_is_made_once_and_again_where_it_is_damaged(small: None, tmp_path: Path) -> None:
    first, notes = opened(tmp_path, "one")
    assert any("power law" in note for note in notes)
    second, notes = opened(tmp_path, "two")
    assert not any("power law" in note for note in notes)
    assert second.stack.folder == tmp_path / "two"
    assert np.array_equal(second.stack.radiance[:], first.stack.radiance[:])
    slices = present(first.material.shading_map).slices
    assert np.array_equal(present(second.material.shading_map).slices, slices)
    assert Project(**second.parts).recipe == second.parts["built_from"]
    (bundle,) = (tmp_path / "samples").glob("*.lightarc")
    bundle.write_bytes(bundle.read_bytes()[:-100])
    third, notes = opened(tmp_path, "three")
    assert any("power law" in note for note in notes)
    assert np.array_equal(present(third.material.shading_map).slices, slices)


def test_the_window_opens_it_in_one_step_and_shows_how_it_is_made(small: None, window: MainWindow, qtbot: Any) -> None:
    bench, document = window.bench, window.bench.document
    drain(ready_sample(samples_folder(), bench.folder / "unused"))
    bench.open_sample()
    qtbot.waitUntil(lambda: document.project.has_map, timeout=60_000)
    assert document.undo_stack.count() == 1
    assert not window.capture.panel.build.isEnabled()
    assert window.capture.panel.build.toolTip() == "The material is up to date"
    window.undo.trigger()
    assert document.project.sources is None
    bench.make_sample_anew()
    qtbot.waitUntil(lambda: bench.importing is not None, timeout=60_000)
    qtbot.waitUntil(lambda: document.project.has_map, timeout=60_000)
