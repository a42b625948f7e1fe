"""The lobe inspector: a vertex is chosen by a click, and its images come from the background."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest

from app.view.lobe_inspector import ASK, DIFFUSE, LobeInspector
from app.window.main_window import MainWindow
from tests.app.view.test_baking import GLOSSY, set_brdf, wait
from tests.engine.gl.relit_scenes import sphere


@pytest.fixture
def inspector(window: MainWindow, qtbot: Any) -> LobeInspector:
    """The open dock beside a glossy ball."""
    window.resize(1120, 800)
    document = window.bench.document
    document.change("Ball", mesh=sphere(2), material=dataclasses.replace(document.project.material, brdf=GLOSSY))
    window.show_workspace("view")
    dock = next(iter(window.findChildren(LobeInspector)), None) or LobeInspector(window.bench, window.view, window)
    window.addDockWidget(Qt.DockWidgetArea.BottomDockWidgetArea, dock)
    dock.show()
    wait(qtbot, lambda: window.view.viewport.surface.is_finished)
    return dock


def click(dock: LobeInspector, x: float, y: float) -> None:
    viewport = dock.view.viewport
    QTest.mouseClick(
        viewport, Qt.MouseButton.LeftButton, pos=QPoint(round(x * viewport.width()), round(y * viewport.height()))
    )


def test_a_click_chooses_a_vertex_and_shows_what_is_kept_of_it(inspector: LobeInspector, qtbot: Any) -> None:
    assert inspector.words.forms[0] == ASK
    click(inspector, 0.5, 0.5)
    wait(qtbot, lambda: inspector.answer is not None)
    answer = inspector.answer
    assert answer is not None
    assert answer.found is not None
    scene = inspector.view.viewport.scene
    assert scene is not None
    camera = inspector.view.viewport.camera
    assert camera is not None
    towards = np.asarray(camera.eye) - scene.mesh.positions[answer.vertex]
    assert towards @ scene.mesh.normals[answer.vertex] > 0.0
    assert all(image.image is not None for image in inspector.images)
    assert inspector.images[1].title == "Gaussian, 7 numbers"
    assert inspector.images[3].title == "SH, 9 numbers"
    assert inspector.view.viewport.overlay.mark is not None
    inspector.hide()
    assert inspector.view.viewport.overlay.mark is None


def test_another_view_or_brdf_is_looked_at_anew(inspector: LobeInspector, qtbot: Any) -> None:
    click(inspector, 0.5, 0.5)
    wait(qtbot, lambda: inspector.answer is not None)
    first = inspector.answer
    inspector.towards.setCurrentIndex(5)
    inspector.towards.activated.emit(5)
    wait(qtbot, lambda: inspector.answer is not first)
    second = inspector.answer
    assert second is not None
    assert second.question.view == 4
    set_brdf(inspector.view.window(), "lambert:albedo=0.5")  # type: ignore[arg-type]
    wait(qtbot, lambda: inspector.words.forms[0] == DIFFUSE)
    assert all(image.image is None for image in inspector.images)


def test_a_drag_or_a_click_beside_the_model_chooses_nothing(inspector: LobeInspector, qtbot: Any) -> None:
    viewport = inspector.view.viewport
    start, stop = QPoint(viewport.width() // 2, viewport.height() // 2), QPoint(viewport.width() // 2 + 40, 200)
    QTest.mousePress(viewport, Qt.MouseButton.LeftButton, pos=start)
    QTest.mouseMove(viewport, stop)
    QTest.mouseRelease(viewport, Qt.MouseButton.LeftButton, pos=stop)
    click(inspector, 0.02, 0.5)
    wait(qtbot, lambda: not inspector._asking.busy)
    assert inspector.vertex is None
