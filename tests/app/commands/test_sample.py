"""The sample: File > Sample capture opens the shipped one, File > Rebuild sample simulates it at full size."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest

from app.project.project_file import read
from app.window.main_window import MainWindow
from engine.simulate import built_in
from engine.simulate.arc import LightArc


@pytest.fixture
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    """A capture small enough for a test."""
    arc = LightArc(size=48, elevation=tuple(math.radians(angle) for angle in (10, 40, 90)))
    monkeypatch.setattr(built_in, "LightArc", lambda: arc)


def test_the_sample_opens_ready_made_beside_the_project_and_can_be_rebuilt(
    small: None, window: MainWindow, qtbot: Any, tmp_path: Path
) -> None:
    bench, document = window.bench, window.bench.document
    document.change("Name it", name="Kept")
    window.projects.copy_to(tmp_path / "kept.lap")
    qtbot.waitUntil(lambda: window.projects.path.name == "kept.lap", timeout=60_000)
    window.menus.sample_wanted.emit()
    qtbot.waitUntil(lambda: document.project.has_map, timeout=60_000)
    assert document.project.name == "Woven cloth"
    assert document.undo_stack.count() == 0
    qtbot.waitUntil(lambda: window.stack.currentWidget() is window.view, timeout=60_000)
    assert read(tmp_path / "kept.lap").current.name == "Kept"
    window.new()
    bench.rebuild_sample()
    qtbot.waitUntil(lambda: bench.importing is not None, timeout=60_000)
    qtbot.waitUntil(lambda: document.project.has_map, timeout=60_000)
    assert document.project.name == "Woven sample"
    assert document.project.stack is not None
    assert window.stack.currentWidget() is window.capture
