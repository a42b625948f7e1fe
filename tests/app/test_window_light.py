"""Light from all around in the View workspace: chosen, dropped, turned, and told what its directions cost."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QWidget

from app.main_window import MainWindow
from engine.images.encode import rgb_channels, write_exr
from engine.shapes import shape

Drop = Callable[[QWidget, list[Path]], None]


@pytest.fixture
def lit(window: MainWindow, qtbot: Any) -> MainWindow:
    """The View workspace with a sphere under the studio."""
    window.bench.document.change("Sphere", mesh=shape("sphere"))
    window.show_workspace("view")
    choose(window, "studio")
    qtbot.waitUntil(lambda: window.bench.document.project.environment is not None, timeout=60_000)
    return window


def choose(window: MainWindow, name: str) -> None:
    box = window.view.lighting
    box.setCurrentIndex(box.findData(name))
    box.activated.emit(box.currentIndex())


def test_an_environment_takes_the_place_of_the_light_and_gives_it_back(lit: MainWindow) -> None:
    view = lit.view
    assert view.viewport.scene.environment is lit.bench.document.project.environment
    assert view.surround.isVisible()
    assert not view.light.isVisible()
    assert view.viewport.overlay.handle() is None
    choose(lit, "")
    assert view.viewport.scene.environment is None
    assert view.viewport.overlay.handle() is not None
    lit.undo.trigger()
    assert view.viewport.scene.environment.name == "studio"


def test_control_drag_turns_the_environment_in_one_step(lit: MainWindow) -> None:
    viewport, steps = lit.view.viewport, lit.bench.document.undo_stack.count()
    start, keys = QPoint(200, 200), Qt.KeyboardModifier.ControlModifier
    QTest.mousePress(viewport, Qt.MouseButton.LeftButton, keys, start)
    for step in range(1, 7):
        QTest.mouseMove(viewport, start + QPoint(10 * step, step))
    QTest.mouseRelease(viewport, Qt.MouseButton.LeftButton, keys, start + QPoint(60, 6))
    turned_deg = lit.bench.document.project.look.rotation_deg
    assert turned_deg == pytest.approx(180.0 * 60 / viewport.height(), abs=0.5)
    assert viewport.scene.environment_rotation == pytest.approx(np.radians(turned_deg))
    assert lit.bench.document.undo_stack.count() == steps + 1


def test_more_directions_are_used_and_their_error_is_measured(lit: MainWindow, qtbot: Any) -> None:
    box = lit.view.directions
    assert [box.itemData(place) for place in range(box.count())] == [16, 32, 64, 128, 256, 512]
    box.setCurrentIndex(box.findData(256))
    box.activated.emit(box.currentIndex())
    assert len(lit.view.viewport.scene.lights.direction) == 256
    qtbot.waitUntil(lambda: lit.view.light_error.text() != "–", timeout=120_000)
    assert 0.0 < float(lit.view.light_error.text().removesuffix(" %")) < 20.0


@pytest.fixture
def panorama(tmp_path: Path) -> Path:
    radiance = np.full((32, 64, 3), 0.5, np.float32)
    write_exr(tmp_path / "court.exr", rgb_channels(radiance), half=False)
    return tmp_path / "court.exr"


def test_a_dropped_panorama_lights_the_model_in_view(lit: MainWindow, qtbot: Any, drop: Drop, panorama: Path) -> None:
    drop(lit, [panorama])
    qtbot.waitUntil(lambda: lit.bench.document.project.environment.name == "court.exr", timeout=60_000)
    assert lit.view.lighting.currentText() == "court.exr"
    choose(lit, "")
    choose(lit, "court.exr")
    assert lit.bench.document.project.environment.name == "court.exr"


@pytest.mark.parametrize("workspace", ["capture", "view"])
def test_what_cannot_light_a_model_is_explained(
    window: MainWindow, qtbot: Any, drop: Drop, tmp_path: Path, workspace: str
) -> None:
    write_exr(tmp_path / "square.exr", rgb_channels(np.ones((16, 16, 3), np.float32)), half=False)
    window.show_workspace(workspace)
    drop(window, [tmp_path / "square.exr"])
    qtbot.waitUntil(lambda: len(window.failures.open_dialogs) == 1, timeout=60_000)
    (box,) = window.failures.open_dialogs.values()
    words = f"{box.text()} {box.informativeText()}"
    assert "square.exr" in words
    assert ("equirectangular" if workspace == "view" else "View workspace") in words
    assert window.bench.document.project.environment is None
