"""Environments in the View workspace: chosen, dropped, rotated, and the error of their directions."""

from __future__ import annotations

import dataclasses
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtGui import QImage
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QWidget

from app.document.document import Look
from app.viewport.gl_surface import GlSurface
from app.viewport.refining import MANY_LIGHTS, Cost, Refining
from app.window.main_window import MainWindow
from engine.core.steps import Step, Steps
from engine.geometry.shapes import SHAPES, frame_mesh, shape
from engine.gl.context import create_context
from engine.gl.direct import DirectRenderer
from engine.images.encode import rgb_channels, write_exr
from engine.scene.scene import Scene
from tests.present import present

Drop = Callable[[QWidget, list[Path]], None]


@pytest.fixture
def lit(window: MainWindow, qtbot: Any) -> MainWindow:
    """The View workspace with a sphere under the studio."""
    window.resize(1024, 660)
    window.bench.document.change("Sphere", mesh=shape("sphere"))
    window.show_workspace("view")
    choose(window, "studio")
    qtbot.waitUntil(lambda: window.bench.document.project.environment is not None, timeout=60_000)
    return window


def choose(window: MainWindow, name: str) -> None:
    box = window.view.lights.lighting
    box.setCurrentIndex(box.findData(name))
    box.activated.emit(box.currentIndex())


def test_an_environment_takes_the_place_of_the_light_and_gives_it_back(lit: MainWindow) -> None:
    view = lit.view
    assert view.viewport.scene is not None
    assert view.viewport.scene.environment is lit.bench.document.project.environment
    assert view.lights.surround.isVisible()
    assert not view.lights.light.isVisible()
    assert view.viewport.overlay.handle() is None
    choose(lit, "")
    assert view.viewport.scene.environment is None
    assert view.viewport.overlay.handle() is not None
    lit.undo.trigger()
    assert view.viewport.scene.environment is not None
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
    assert viewport.scene is not None
    assert viewport.scene.environment_rotation == pytest.approx(np.radians(turned_deg))
    assert lit.bench.document.undo_stack.count() == steps + 1


def test_more_directions_are_used_and_their_error_is_measured(lit: MainWindow, qtbot: Any) -> None:
    box = lit.view.lights.directions
    assert [box.itemData(place) for place in range(box.count())] == [16, 32, 64, 128, 256, 512]
    choose_directions(lit, 256)
    assert lit.view.viewport.scene is not None
    assert len(lit.view.viewport.scene.lights.direction) == 256
    qtbot.waitUntil(lambda: lit.view.lights.error.text() != "–", timeout=120_000)
    assert 0.0 < percent(lit) < 1.0
    choose_directions(lit, 16)
    assert lit.view.lights.error.text() == "–"
    qtbot.waitUntil(lambda: lit.view.lights.error.text() != "–", timeout=120_000)
    assert 1.0 < percent(lit) < 30.0


def test_an_orbit_makes_the_measured_error_stale_until_it_is_measured_again(lit: MainWindow, qtbot: Any) -> None:
    qtbot.waitUntil(lambda: lit.view.lights.error.text() != "–", timeout=120_000)
    QTest.mousePress(lit.view.viewport, Qt.MouseButton.LeftButton, pos=QPoint(200, 300))
    QTest.mouseMove(lit.view.viewport, QPoint(230, 310))
    assert lit.view.lights.error.text() == "–"
    QTest.mouseRelease(lit.view.viewport, Qt.MouseButton.LeftButton, pos=QPoint(230, 310))
    qtbot.waitUntil(lambda: lit.view.lights.error.text() != "–", timeout=120_000)


def test_the_error_is_shown_also_where_the_project_keeps_the_camera_while_it_is_measured(
    lit: MainWindow, qtbot: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    kept = threading.Event()

    def measure_late(_scene: Scene) -> Steps[float]:
        yield Step(0.0, "waiting")
        return 0.0123 if kept.wait(60) else 0.5

    qtbot.waitUntil(lambda: lit.view.lights.error.text() != "–", timeout=120_000)
    monkeypatch.setattr("app.view.tab._directions_error", measure_late)
    choose_directions(lit, 256)
    qtbot.waitUntil(lambda: lit.view.latest.busy, timeout=60_000)
    camera = lit.view.viewport.camera
    assert camera is not None
    lit.bench.document.look_from(camera)
    kept.set()
    qtbot.waitUntil(lambda: lit.view.lights.error.text() != "–", timeout=60_000)
    assert percent(lit) == pytest.approx(1.23)


def percent(window: MainWindow) -> float:
    return float(window.view.lights.error.text().strip("< %"))


def choose_directions(window: MainWindow, count: int) -> None:
    box = window.view.lights.directions
    box.setCurrentIndex(box.findData(count))
    box.activated.emit(box.currentIndex())


def test_the_image_comes_coarse_at_once_and_ends_as_the_one_that_is_drawn_in_one_go(
    lit: MainWindow, qtbot: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    surface = lit.view.viewport.surface
    assert isinstance(surface, GlSurface)
    monkeypatch.setattr("app.viewport.refining.next_rows", lambda rows, _seconds, _first: max(1, min(rows, 40)))
    qtbot.waitUntil(lambda: surface.is_finished, timeout=120_000)
    seen: list[Any] = []
    complete = Refining._complete
    monkeypatch.setattr(
        Refining, "_complete", lambda self, at: (cast(Any, seen).append(at.level), complete(self, at))[1]
    )
    surface._sides[0].cost = Cost()
    lit.view.viewport.redraw()
    assert surface.scene is not None
    surface.show_scene(
        dataclasses.replace(surface.scene, environment_rotation=0.5, directions=16), surface.display, 60.0
    )
    qtbot.waitUntil(lambda: surface.is_finished, timeout=120_000)
    assert seen[0] == MANY_LIGHTS[-1]
    assert seen[-1] == MANY_LIGHTS[0]
    assert [MANY_LIGHTS.index(level) for level in seen] == sorted((MANY_LIGHTS.index(at) for at in seen), reverse=True)
    refined = pixels_of(surface.grabFramebuffer())
    context = create_context()
    with context:
        renderer = DirectRenderer(context)
        size = (refined.shape[1], refined.shape[0])
        target = context.simple_framebuffer(size, 3)
        renderer.draw(surface.scene, target, size, samples=2, display=surface.display)
        whole = np.frombuffer(target.read(alignment=1), np.uint8).reshape(refined.shape)[::-1]
        renderer.release()
    context.release()
    assert np.array_equal(refined, whole)


def pixels_of(image: QImage) -> np.ndarray:
    image = image.convertToFormat(QImage.Format.Format_RGB888)
    rows = np.frombuffer(image.constBits(), np.uint8).reshape(image.height(), image.bytesPerLine())
    return rows[:, : 3 * image.width()].reshape(image.height(), image.width(), 3).copy()


def test_moving_gives_up_the_finer_image_and_rest_takes_it_up_again(lit: MainWindow, qtbot: Any) -> None:
    viewport, surface = lit.view.viewport, lit.view.viewport.surface
    assert isinstance(surface, GlSurface)
    qtbot.waitUntil(lambda: surface._sides[0].under_way or surface.is_finished, timeout=120_000)
    for step in range(5):
        QTest.mousePress(viewport, Qt.MouseButton.LeftButton, pos=QPoint(200, 300))
        QTest.mouseMove(viewport, QPoint(210 + step, 300))
        assert not surface.is_finished
        QTest.mouseRelease(viewport, Qt.MouseButton.LeftButton, pos=QPoint(210 + step, 300))
        qtbot.wait(20)
    qtbot.waitUntil(lambda: surface.is_finished, timeout=120_000)


@pytest.fixture
def panorama(tmp_path: Path) -> Path:
    radiance = np.full((32, 64, 3), 0.5, np.float32)
    write_exr(tmp_path / "court.exr", rgb_channels(radiance), half=False)
    return tmp_path / "court.exr"


def test_a_dropped_panorama_lights_the_model_in_view(lit: MainWindow, qtbot: Any, drop: Drop, panorama: Path) -> None:
    drop(lit, [panorama])
    qtbot.waitUntil(lambda: present(lit.bench.document.project.environment).name == "court.exr", timeout=60_000)
    assert lit.view.lights.lighting.currentText() == "court.exr"
    choose(lit, "")
    choose(lit, "court.exr")
    assert lit.bench.document.project.environment is not None
    assert lit.bench.document.project.environment.name == "court.exr"


@pytest.mark.parametrize("workspace", ["capture", "view"])  # files open in their own place, wherever they are dropped
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
    assert "equirectangular" in words
    assert window.bench.document.project.environment is None


def test_new_near_lamps_stand_in_the_image(window: MainWindow) -> None:
    """However wide the image of a built-in model is: a lamp outside of it cannot be dragged."""
    panel, document = window.view.lights, window.bench.document
    for name in SHAPES:
        mesh = shape(name)
        document.change("Model", mesh=mesh, look=Look())
        panel.show_size(mesh)
        for _ in range(3):
            panel.add_near_lamp()
        places = np.array([(each.x, each.y, each.z) for each in document.project.look.near_lamps])
        assert len(places) == 3
        for aspect in (1.0, 1.8, 2.5):
            camera = frame_mesh(mesh, aspect)
            right, up, back = camera.camera_from_world @ (places - camera.eye).T
            reach = -back * np.tan(np.radians(camera.fov_deg) / 2.0)
            assert np.abs(up / reach).max() < 1.0, name
            assert np.abs(right / reach).max() < aspect, name
