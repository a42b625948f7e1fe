"""Kept views belong to the project and lead back; the environment stands behind the model as it is chosen."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from app.window.main_window import MainWindow
from engine.light.environment import EnvironmentMap
from tests.app.view.test_baking import sphere


def trigger(menu: Any, words: str) -> None:
    menu.fill()
    next(action for action in menu.actions() if action.text() == words).trigger()


def test_a_view_is_kept_found_again_and_forgotten(window: MainWindow, qtbot: Any) -> None:
    document, viewport, menu = window.bench.document, window.view.viewport, window.view.views
    document.change("Ball", mesh=sphere())
    window.show_workspace("view")
    qtbot.waitUntil(lambda: viewport.camera is not None, timeout=60_000)
    viewport.turn(0.4, 0.2)
    kept = viewport.camera
    trigger(menu, "Keep this view")
    assert document.project.views == {"View 1": kept}
    viewport.turn(1.0, 0.0)
    trigger(menu, "View 1")
    assert viewport.camera == kept
    menu.forget("View 1")
    assert document.project.views == {}
    window.undo.trigger()
    assert document.project.views == {"View 1": kept}


def test_the_environment_stands_behind_the_model(window: MainWindow, qtbot: Any) -> None:
    document, view = window.bench.document, window.view
    studio = EnvironmentMap(np.random.default_rng(1).uniform(0.1, 2.0, (16, 32, 3)).astype(np.float32), "studio")
    document.change("Ball", mesh=sphere(), environment=studio)
    window.show_workspace("view")
    qtbot.waitUntil(lambda: view.viewport.scene is not None, timeout=60_000)
    assert view.viewport.surface.behind is None
    box = view.lights.behind
    box.setCurrentIndex(box.findData("sharp"))
    box.activated.emit(0)
    assert view.viewport.surface.behind is not None
    assert view.viewport.surface.behind.environment is studio
    document.change("Soft", look=dataclasses.replace(document.project.look, behind="blurred"))
    qtbot.waitUntil(lambda: view.viewport.surface.behind.environment is not studio, timeout=60_000)
    document.change("Lamp", environment=None)
    assert view.viewport.surface.behind is None
