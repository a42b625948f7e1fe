"""The error of the image on screen in the status bar: found in the background, refined, expected, and left out."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from app.document.measured import MAX_PIXELS, size_of
from app.jobs.jobs import Jobs
from app.session import settings
from app.view.image_error import Comparing, ImageError, Side
from app.view.images import Progressive, reference_size
from app.window.main_window import MainWindow
from engine.geometry.shapes import shape
from engine.light.environment_file import open_environment
from tests.engine.scenes import scene, weave
from tests.present import present

LONG = 90_000


@pytest.fixture
def view(window: MainWindow, qtbot: Any) -> MainWindow:
    """A torus knot, which shades itself, in the View workspace under one light, drawn with its shadows."""
    window.resize(1120, 700)
    document = window.bench.document
    look = dataclasses.replace(document.project.look, mode="direct")
    material = dataclasses.replace(document.project.material, brdf="lambert:albedo=0.5")
    document.change("Knot", mesh=shape("torus-knot"), look=look, material=material)
    window.view.images.measure(True)
    window.show_workspace("view")
    return window


def wait(qtbot: Any, done: Callable[[], bool]) -> None:
    qtbot.waitUntil(done, timeout=LONG)


def change(window: MainWindow, **parts: Any) -> None:
    document = window.bench.document
    document.change("Look", look=dataclasses.replace(document.project.look, **parts))


def test_the_error_of_what_is_shown_is_found_while_nobody_does_anything(view: MainWindow, qtbot: Any) -> None:
    images, status = view.view.images, view.status.error
    view.bench.document.change("Sky", environment=open_environment("overcast"))
    assert status.text() == "error being measured"
    wait(qtbot, lambda: images.error is not None)
    assert images.error is not None
    assert 0.1 < images.error.rmse_rel < 1.0, "a knot without the shadows of a sky is far off"
    assert "±" in status.text()
    assert "Direct against the reference" in status.toolTip()
    assert f"{images.error.samples} sample" in status.toolTip()
    assert view.view.compare.error.text() == "–", "nothing is compared that a user chose"
    wait(qtbot, lambda: images.reference.held)
    assert images.error.is_certain
    assert cast(Any, present(view.view.viewport.surface._over[0])).pixels is None, "the reference is not shown"
    assert all(job.state == "paused" for job in view.bench.jobs.active if images.reference.is_run_by(job))


def test_turning_begins_anew_and_another_mode_goes_on(view: MainWindow, qtbot: Any) -> None:
    images = view.view.images
    wait(qtbot, lambda: images.reference.held)
    found = images.reference.found
    change(view, mode="sh")
    assert images.error is None
    assert images.reference.found is found, "the reference is of the scene, not of how it is drawn"
    wait(qtbot, lambda: images.error is not None)
    view.view.viewport.turn(0.2, 0.0)
    assert (images.error, images.reference.found, images.reference.running) == (None, None, False)
    assert view.status.error.text() == "error being measured"
    wait(qtbot, lambda: images.error is not None)


def test_a_reference_that_is_shown_has_all_pixels_and_tells_its_noise(view: MainWindow, qtbot: Any) -> None:
    images, surface = view.view.images, view.view.viewport.surface
    wait(qtbot, lambda: images.error is not None)
    change(view, mode="reference", against="direct")
    assert cast(Any, present(surface._over[0])).pixels is None
    wait(qtbot, lambda: cast(Any, present(surface._over[0])).pixels is not None)
    height, width = present(cast(Any, present(surface._over[0])).pixels).shape[:2]
    assert (width, height) == reference_size(view.view.viewport.screen_px())
    wait(qtbot, lambda: images.error is not None)
    assert "noise of the reference" in view.status.error.toolTip()
    assert not images.reference.held


def test_it_can_be_left_out_and_that_is_remembered(view: MainWindow, qtbot: Any, tmp_path: Path) -> None:
    images = view.view.images
    view.settings.folder = tmp_path
    wait(qtbot, lambda: images.error is not None)
    view.menus.measure.trigger()
    assert images.error is None
    assert not images.reference.running
    assert view.status.error.text() == ""
    qtbot.wait(100)
    assert not images.reference.running
    view._keep_settings()
    view.settings.wait()
    assert not settings.load(tmp_path).measure_error
    view.menus.measure.trigger()
    wait(qtbot, lambda: images.error is not None)


def test_before_it_is_known_the_plan_tells_what_to_expect(view: MainWindow) -> None:
    view.view.planning.plan = SimpleNamespace(  # type: ignore[assignment]
        setting=view.view.setting,
        predicted_error_rel=0.082,
        error_interval_rel=(0.04, 0.16),
        predicted_frame_s=0.01,
        satisfied=True,
        probability=None,
        beyond=None,
        reference=None,
        decision=lambda _effect: "skipped",
        effects=(),
    )
    view.error_line.refresh()
    assert view.status.error.text() == "error ≈ 8.2 % predicted"
    change(view, mode="sh")
    assert "predicted" not in view.status.error.text()


def test_without_a_reference_it_says_why(view: MainWindow) -> None:
    view.bench.document.change("Weave", material=weave(16))
    change(view, mode="shading-map", lookup="outgoing")
    assert view.status.error.text() == "error –"
    assert "choose another under Sampling" in view.status.error.toolTip()


def test_other_workspaces_tell_the_error_of_the_material(view: MainWindow, qtbot: Any) -> None:
    wait(qtbot, lambda: view.view.images.error is not None)
    view.show_workspace("capture")
    assert not view.view.images.reference.running
    assert view.status.error.text() == ""


def test_a_reference_that_is_held_rests_and_goes_on_where_it_was(qapp: Any, qtbot: Any) -> None:
    jobs = Jobs()
    refined = Progressive(jobs)
    refined.want(scene("torus-knot", environment=open_environment("studio")), (64, 48), 0)
    wait(qtbot, lambda: refined.found is not None and refined.found.samples >= 2)
    refined.hold(True)
    assert [job.state for job in jobs.active] == ["paused"]
    qtbot.wait(50)
    assert refined.found is not None
    rested = refined.found.samples
    qtbot.wait(100)
    assert refined.found.samples == rested
    refined.hold(False)
    wait(qtbot, lambda: refined.found is not None and refined.found.samples > rested)
    refined.drop()
    wait(qtbot, lambda: not jobs.active)
    jobs.close()


def test_T8_the_noise_of_a_image_is_estimated_from_its_variance(qapp: Any, qtbot: Any) -> None:
    """Of ones with normal noise of 0.1 it is 0.1, and images made so are as far from the truth as it says."""
    rng = np.random.default_rng(1)
    found: list[Any] = []
    comparing = Comparing(Jobs())
    comparing.found.connect(found.append)
    image = np.ones((60, 80, 4), np.float32)
    comparing.weigh(Side(image, np.full((60, 80, 3), 0.01), 4))
    wait(qtbot, lambda: bool(found))
    error: ImageError = found[0]
    assert (error.samples, error.pixels) == (4, 4800)
    grey = rng.normal(0.0, 0.1, (400, 4800))  # the three channels rise and fall together
    off = np.sqrt(np.mean(grey**2, axis=1))
    inside = np.mean(np.abs(off - error.rmse_rel) <= error.uncertainty)
    assert inside >= 0.92
    assert error.uncertainty < 0.004


@pytest.mark.parametrize("screen", [(613, 367), (1200, 900), (2560, 1300), (80, 60), (1, 1)])
def test_images_that_are_measured_have_the_shape_of_the_screen(screen: tuple[int, int]) -> None:
    width, height = size_of(screen)
    assert width * height <= max(1.02 * MAX_PIXELS, 32 * 32)
    if min(screen) > 32:
        assert width / height == pytest.approx(screen[0] / screen[1], rel=2e-3)
