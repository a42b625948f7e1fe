"""The camera is the project's: neither a model that arrives late nor a movement of another project takes it away."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace
from typing import Any, cast

import pytest

from app.commands.bundle_view import OpenedBundle, Referred
from app.document.document import Project
from app.window.main_window import MainWindow
from engine.geometry.camera import Camera
from tests.app.opening import open_project
from tests.app.view.test_baking import sphere
from tests.engine.scenes import weave

CAMERA = Camera((0.0, 0.5, 4.0), (0.0, 0.1, 0.0), fov_deg=30.0)
OTHER = Camera((3.0, 0.5, 0.0), (0.0, 0.1, 0.0), fov_deg=20.0)


@pytest.fixture
def in_view(window: MainWindow, monkeypatch: pytest.MonkeyPatch) -> MainWindow:
    """The View workspace without the model of a new project, which a test lets arrive."""
    monkeypatch.setattr(window.view, "want_model", lambda: None)
    window.show_workspace("view")
    assert window.view.viewport.camera is None
    return window


def at_rest(window: MainWindow) -> None:
    """The camera has come to rest, as after a quarter of a second."""
    window.view.camera_at_rest.timeout.emit()


def test_a_default_model_that_arrives_late_leaves_the_camera_of_the_project(in_view: MainWindow) -> None:
    """Once, and a second time as another object: whoever asks twice gets two."""
    document, view = in_view.bench.document, in_view.view
    document.restore(Project(camera=CAMERA))
    for mesh in (sphere(), sphere()):
        view._default_ready(mesh)
        assert view.viewport.camera == CAMERA
        at_rest(in_view)
        assert document.project.camera == CAMERA


def test_a_model_of_a_bundle_that_was_opened_is_not_replaced_by_one_that_still_loads(in_view: MainWindow) -> None:
    """Not even where the loading has ended, and only its result has not arrived."""
    bench = in_view.bench
    bench.load_model("sphere")
    loading = bench.loading
    assert loading is not None
    loading._thread.wait()
    parts = {"mesh": sphere(), "camera": CAMERA}
    bench._bundle_opened(OpenedBundle("felt", weave(16), {}, Referred(parts)))
    loading._thread.finished.emit()
    assert loading.state == "cancelled"
    assert bench.document.project.mesh is parts["mesh"]
    assert in_view.view.viewport.camera == CAMERA


def test_the_camera_of_one_project_does_not_come_to_rest_in_another(in_view: MainWindow) -> None:
    document, view = in_view.bench.document, in_view.view
    document.restore(Project(mesh=sphere(), camera=CAMERA))
    view.viewport.look_from(OTHER)
    document.restore(Project(camera=CAMERA))
    assert not view.camera_at_rest.isActive(), "nothing of this project is on screen"
    view._default_ready(sphere())
    assert view.viewport.camera == CAMERA


def test_a_camera_that_still_moves_belongs_to_the_project_that_is_left(in_view: MainWindow, qtbot: Any) -> None:
    projects, document = in_view.projects, in_view.bench.document
    document.change("Ball", mesh=sphere())
    in_view.view.viewport.look_from(OTHER)
    left = projects.path
    projects.begin()
    assert document.project.camera is None
    open_project(in_view, qtbot, left)
    assert document.project.camera == OTHER
    assert in_view.view.viewport.camera == OTHER


def test_a_flipped_model_is_seen_from_the_same_side(in_view: MainWindow) -> None:
    document, view = in_view.bench.document, in_view.view
    mesh = sphere()
    document.change("Ball", mesh=mesh)
    view.viewport.look_from(OTHER)
    at_rest(in_view)
    document.change("Flip the model", mesh=mesh.flipped())
    assert view.viewport.camera == OTHER


def test_the_model_of_a_new_project_is_loaded_once_and_again_where_that_was_cancelled(
    window: MainWindow, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[Any] = []
    view = window.view

    def submit(_title: str, _work: object, **_options: object) -> Any:
        signal = SimpleNamespace(connect=lambda run: asked[-1].listeners.append(run))
        asked.append(SimpleNamespace(over=False, listeners=[], succeeded=signal, cancelled=signal))
        return asked[-1]

    monkeypatch.setattr(window.bench.jobs, "submit", submit)
    view.want_model()
    view.want_model()
    assert len(asked) == 1
    monkeypatch.setattr(view, "isVisible", lambda: True)
    asked[0].over = True
    cast(Any, asked[0].listeners[1])()
    assert len(asked) == 2


def test_undo_leads_back_to_the_model_and_keeps_where_it_was_seen_from(in_view: MainWindow) -> None:
    document, view = in_view.bench.document, in_view.view
    document.change("Ball", mesh=sphere())
    view.viewport.look_from(OTHER)
    at_rest(in_view)
    document.change("Light", look=dataclasses.replace(document.project.look, irradiance=1.0))
    document.undo_stack.undo()
    assert view.viewport.camera == OTHER
