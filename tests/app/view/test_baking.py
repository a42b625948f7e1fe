"""Baked light in the View workspace: what a bake would take, baking, new light, and when it has to be baked again."""

from __future__ import annotations

import dataclasses
import json
import time
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
import trimesh

from app.commands.images import Saving
from app.view.baking import Baking
from app.window.main_window import MainWindow
from engine.accuracy import bake_check
from engine.core.figure_text import percent, size_text, time_text
from engine.core.steps import Step, Steps
from engine.geometry.camera import Camera
from engine.geometry.mesh import Mesh
from engine.images.decode import read_image
from engine.light.environment_file import open_environment
from engine.light.near_lamps import NearLampSettings
from engine.transport.baking.file import open_transport
from tests.app.command import Command
from tests.engine.domes import dome_material

LONG = 90_000
GLOSSY = "ggx:kd=0.5,alpha=0.4,f0=0.04"


def sphere() -> Mesh:
    made = trimesh.creation.icosphere(subdivisions=2)
    positions = np.asarray(made.vertices, np.float64)
    uv = np.zeros((len(positions), 2), np.float32)
    return Mesh(positions, positions.astype(np.float32), uv, np.asarray(made.faces, np.int32), "ball")


#: The sphere and the built-in environments as the same objects in all tests: the program remembers what it found of a
#: scene.
ball, built_in = cache(sphere), cache(open_environment)


@pytest.fixture
def view(window: MainWindow, qtbot: Any) -> MainWindow:
    """A ball with a glossy BRDF under the studio, in the View workspace."""
    window.resize(1120, 700)
    document = window.bench.document
    material = dataclasses.replace(document.project.material, brdf=GLOSSY)
    document.change("Ball", mesh=ball(), environment=built_in("studio"), material=material)
    window.show_workspace("view")
    return window


def wait(qtbot: Any, done: Callable[[], bool]) -> None:
    qtbot.waitUntil(done, timeout=LONG)


def change(window: MainWindow, **parts: Any) -> None:
    document = window.bench.document
    document.change("Look", look=dataclasses.replace(document.project.look, **parts))


def set_brdf(window: MainWindow, text: str) -> None:
    document = window.bench.document
    document.change("Brdf", material=dataclasses.replace(document.project.material, brdf=text))


def draw(window: MainWindow) -> Any:
    """The baked light that is on screen."""
    scene = cast(Any, window.view.viewport.surface).scene
    return scene.relit if scene is not None else None


def bake(window: MainWindow, qtbot: Any, method: str) -> Baking:
    """Show a mode and bake it with the button, as quickly as it goes."""
    baking, panel = window.view.bakings[method], window.view.bake_panels[method]
    for name, value in (("order", 3), ("terms", 2), ("cube", 16)):
        if name in panel.choices:
            panel.choices[name].setCurrentIndex(max(0, panel.choices[name].findData(value)))
            panel.choices[name].activated.emit(0)
    window.view.choose_mode(method)
    wait(qtbot, lambda: "Baking takes about" in panel.words.text())
    assert draw(window) is None
    panel.go.click()
    wait(qtbot, lambda: baking.made is not None and draw(window) is not None)
    return baking


@pytest.mark.checked_bakes
def test_a_bake_in_the_window_ends_with_its_check(
    view: MainWindow, qtbot: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(bake_check, "EDGE", 16)
    monkeypatch.setattr(bake_check, "SAMPLES", 8)
    made = bake(view, qtbot, "sh").made
    assert made is not None
    assert made.check is not None
    assert [each.light for each in made.check.lights] == list(bake_check.check_lights([built_in("studio")]))
    (place,) = view.bench.folder.glob("bake-*.transport")
    assert open_transport(place).check == made.check


@pytest.mark.parametrize("method", ["sh", "wavelet"])
def test_a_bake_is_offered_made_and_lit_anew(view: MainWindow, qtbot: Any, method: str) -> None:
    panel = view.view.bake_panels[method]
    assert not panel.isVisible()
    baking = bake(view, qtbot, method)
    assert panel.isVisible()
    assert not panel.go.isVisible()
    assert panel.words.text().startswith("Baked in ")
    assert baking.made is not None
    (place,) = view.bench.folder.glob("bake-*.transport")
    assert baking.made.size_bytes == place.stat().st_size
    before = draw(view)
    change(view, rotation_deg=90.0)
    wait(qtbot, lambda: draw(view) is not None and draw(view) is not before)
    assert not np.allclose(before.rows, draw(view).rows)
    turned = draw(view)
    view.view.viewport.turn(0.3, 0.1)
    wait(qtbot, lambda: view.view.viewport.surface.is_finished)
    assert draw(view) is turned
    view.view.choose_mode("direct")
    assert not panel.isVisible()
    assert draw(view) is None
    view.view.choose_mode(method)
    assert draw(view) is turned


def test_harmonics_take_another_brdf_without_a_bake(view: MainWindow, qtbot: Any) -> None:
    baking = bake(view, qtbot, "sh")
    before = draw(view)
    set_brdf(view, "ggx:kd=0.1,alpha=0.6,f0=0.5")
    assert baking.why_stale == ""
    wait(qtbot, lambda: draw(view) is not None and draw(view).table is not before.table)
    assert np.array_equal(draw(view).rows, before.rows)
    change(view, has_ground=True)
    assert baking.why_stale == "The bake is of another ground."
    assert draw(view) is None
    wait(qtbot, view.view.bake_panels["sh"].go.isEnabled)


def test_a_near_lamp_inside_the_model_is_said_and_the_image_stays(view: MainWindow, qtbot: Any) -> None:
    """A user drags it there: that is no failure, and the next place is shown again."""
    bake(view, qtbot, "sh")
    before, failed = draw(view), []
    view.bench.jobs.failed.connect(lambda job, error: failed.append(job.title))
    with qtbot.waitSignal(view.bench.said, timeout=LONG, check_params_cb=lambda words: "touches the model" in words):
        change(view, near_lamps=(NearLampSettings(radius=2.0),))
    assert failed == []
    assert draw(view) is before
    change(view, near_lamps=(NearLampSettings(x=3.0, power=40.0),))
    wait(qtbot, lambda: draw(view) is not before)


def test_wavelets_say_that_another_brdf_has_to_be_baked(view: MainWindow, qtbot: Any) -> None:
    baking, panel = bake(view, qtbot, "wavelet"), view.view.bake_panels["wavelet"]
    set_brdf(view, "ggx:kd=0.1,alpha=0.6,f0=0.5")
    assert panel.words.text().startswith("The bake is of another BRDF; wavelets are baked for one.")
    assert panel.go.isVisible()
    assert draw(view) is None
    set_brdf(view, GLOSSY)
    assert baking.is_made
    wait(qtbot, lambda: draw(view) is not None)


def test_another_brdf_is_shown_with_its_shadows_before_it_is_baked(
    view: MainWindow, qtbot: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In spherical harmonics from kept visibility, with their error, and under the light of the moment."""
    baking, panel = bake(view, qtbot, "wavelet"), view.view.bake_panels["wavelet"]
    monkeypatch.setattr(Baking, "_follow", lambda *_words: None)
    set_brdf(view, "ggx:kd=0.1,alpha=0.6,f0=0.5")
    wait(qtbot, lambda: draw(view) is not None)
    first = draw(view)
    assert first.method == "sh"
    assert not baking.is_drawn
    wait(qtbot, lambda: "a first image in spherical harmonics (error " in panel.words.text())
    change(view, rotation_deg=90.0)
    wait(qtbot, lambda: draw(view) is not first)
    turned = draw(view)
    assert turned.transport.rows is first.transport.rows, "matrices are made once"
    set_brdf(view, "ggx:kd=0.1,alpha=0.5,f0=0.5")
    wait(qtbot, lambda: draw(view) not in (None, turned))
    assert draw(view).transport.rows is first.transport.rows
    set_brdf(view, GLOSSY)
    wait(qtbot, lambda: draw(view) is not None and draw(view).method == "wavelet")


def endless() -> Steps[None]:
    while True:
        time.sleep(0.01)
        yield Step(0.0, "")


@pytest.mark.parametrize("method", ["wavelet", pytest.param("gaussian", marks=pytest.mark.long)])
def test_another_brdf_is_baked_unasked_and_without_rays(view: MainWindow, qtbot: Any, method: str) -> None:
    """The last of several that a user goes through; no computation of a user waits for it, and one click stops it."""
    baking, panel = bake(view, qtbot, method), view.view.bake_panels[method]
    assert "Another BRDF takes about" in panel.words.text()
    for text in ("ggx:kd=0.1,alpha=0.6,f0=0.5", "ggx:kd=0.1,alpha=0.5,f0=0.5"):
        set_brdf(view, text)
    wait(qtbot, lambda: baking.job is not None)
    assert cast(Any, baking.job).lane == "background"
    wait(qtbot, lambda: baking.is_made and draw(view) is not None)
    made = cast(Any, baking.made)
    assert made.wanted.brdf.alpha == 0.5
    assert f"Error {percent(made.error['error_rmse_rel'])} in the studio" in panel.words.text()
    other = view.bench.jobs.submit("Searching for factors", endless, lane="compute")
    set_brdf(view, "ggx:kd=0.1,alpha=0.3,f0=0.5")
    wait(qtbot, lambda: baking.job is not None)
    qtbot.wait(200)
    assert cast(Any, baking.job).state in ("queued", "paused")
    panel.go.click()
    wait(qtbot, lambda: baking.job is None and baking.ready is not None)
    assert not baking.is_made
    assert panel.go.text() == "Bake"
    view.bench.jobs.cancel(other)


def test_a_bake_that_is_stopped_can_be_begun_again(view: MainWindow, qtbot: Any) -> None:
    baking, panel = view.view.bakings["wavelet"], view.view.bake_panels["wavelet"]
    view.view.choose_mode("wavelet")
    wait(qtbot, panel.go.isEnabled)
    panel.go.click()
    assert panel.go.text() == "Stop baking"
    assert not panel.choices["terms"].isEnabled()
    panel.go.click()
    wait(qtbot, lambda: baking.job is None)
    assert baking.made is None
    assert panel.go.text() == "Bake"
    wait(qtbot, panel.go.isEnabled)


def test_baked_light_is_measured_against_the_reference(view: MainWindow, qtbot: Any) -> None:
    bake(view, qtbot, "sh")
    change(view, comparing="wipe", against="reference", mode="sh")
    view.view.at_rest.stop()
    wait(qtbot, lambda: view.view.images.error is not None)
    assert view.view.images.error is not None
    assert view.view.images.error.rmse_rel < 0.2


def test_times_and_sizes_are_reported_in_few_digits() -> None:
    assert [time_text(seconds) for seconds in (0.2, 12.4, 130.0)] == ["200 ms", "12 s", "2.2 min"]
    assert [size_text(size) for size in (84_123_456, 3_100_000, 2_100_000_000)] == ["84.1 MB", "3.1 MB", "2.1 GB"]


def test_texels_are_shown_in_baked_light_as_the_command_line_draws_them(
    view: MainWindow, qtbot: Any, lightarc: Command, tmp_path: Path
) -> None:
    bake(view, qtbot, "sh")
    document, surface = view.bench.document, cast(Any, view.view.viewport.surface)
    document.look_from(Camera((0.0, 0.5, 4.0), (0.0, 0.0, 0.0), fov_deg=40.0))

    def image(name: str) -> Any:
        view.view.save(Saving(tmp_path / name, (48, 36)))
        wait(qtbot, lambda: (tmp_path / name).exists())
        return read_image(tmp_path / name).pixels

    before = image("before.exr")
    material = dataclasses.replace(document.project.material, directional=dome_material().directional)
    document.change("Texels", material=material)
    wait(qtbot, lambda: draw(view) is not None and surface.scene.has_texels)
    window = image("window.exr")
    wait(qtbot, lambda: view.projects.is_saved)
    size = ("--width", "48", "--height", "36", "--json")
    arguments = ("--mode", "sh", "--renderer", "gl", "-o", tmp_path / "said.exr")  # as the window draws
    said = lightarc("render", view.projects.path, *arguments, *size)
    assert said.code == 0, said.err
    assert "texels_renderer" in json.loads(said.out)
    assert np.abs(window - read_image(tmp_path / "said.exr").pixels).max() < 2e-3 * window.max()
    assert np.abs(window - before).max() > 0.05 * window.max()
