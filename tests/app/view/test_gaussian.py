"""Gaussian transport in the View workspace, and what can be chosen of each bake."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

from app.document.bake_request import choices_for
from app.view.bake_panel import choices_of
from app.window.main_window import MainWindow
from engine.geometry.mesh import Mesh
from engine.light.environment_file import open_environment
from engine.transport.method import METHODS
from engine.transport.relight import RelightGaussians
from tests.app.view.test_baking import GLOSSY, bake, change, draw, set_brdf, wait
from tests.engine.gl.relit_scenes import sphere


@pytest.fixture
def view(window: MainWindow, qtbot: Any) -> MainWindow:
    """A coarse ball with a glossy BRDF under the studio, in the View workspace."""
    window.resize(1120, 700)
    document = window.bench.document
    material = dataclasses.replace(document.project.material, brdf=GLOSSY)
    mesh: Mesh = sphere(1)
    document.change("Ball", mesh=mesh, environment=open_environment("studio"), material=material)
    window.show_workspace("view")
    return window


def choose(window: MainWindow, method: str, name: str, value: Any) -> None:
    """Choose as a hand does."""
    choice = window.view.bake_panels[method].choices[name]
    choice.setCurrentIndex(choice.findData(value))
    choice.activated.emit(choice.currentIndex())


def test_gaussians_are_baked_drawn_and_turned_without_a_bake(view: MainWindow, qtbot: Any) -> None:
    baking = bake(view, qtbot, "gaussian")
    panel = view.view.bake_panels["gaussian"]
    first = draw(view)
    assert isinstance(first, RelightGaussians)
    assert panel.words.text().startswith("Baked in ")
    change(view, rotation_deg=90.0)
    wait(qtbot, lambda: draw(view) is not None and draw(view) is not first)
    turned = draw(view)
    assert turned.light.environment is first.light.environment, "turning the light filters nothing"
    assert turned.light.rotation == pytest.approx(np.pi / 2)
    wait(qtbot, lambda: view.view.viewport.surface.is_finished)
    set_brdf(view, "ggx:kd=0.1,alpha=0.6,f0=0.5")
    assert baking.why_stale == "The bake is of another BRDF; Gaussians are baked for one."
    assert draw(view) is None
    set_brdf(view, GLOSSY)
    assert baking.is_made


def test_a_diffuse_brdf_says_why_it_has_no_gaussians(view: MainWindow, qtbot: Any) -> None:
    set_brdf(view, "lambert:albedo=0.5")
    view.view.choose_mode("gaussian")
    baking, panel = view.view.bakings["gaussian"], view.view.bake_panels["gaussian"]
    wait(qtbot, lambda: baking.estimate is not None)
    assert "his BRDF has no glossy part" in panel.words.text()
    assert not panel.go.isEnabled()
    assert "glossy" in panel.go.toolTip()
    set_brdf(view, GLOSSY)
    wait(qtbot, panel.go.isEnabled)


def test_gaussians_take_lamps_without_an_environment(view: MainWindow, qtbot: Any) -> None:
    bake(view, qtbot, "gaussian")
    view.bench.document.change("Dark", environment=None)
    wait(qtbot, lambda: draw(view) is not None and draw(view).light.environment is None)
    assert len(draw(view).light.lamps) == 1
    wait(qtbot, lambda: view.view.viewport.surface.is_finished)


def test_a_window_against_ringing_asks_for_no_bake(view: MainWindow, qtbot: Any) -> None:
    baking = bake(view, qtbot, "sh")
    before = draw(view)
    choose(view, "sh", "window", "hanning")
    assert baking.is_made
    wait(qtbot, lambda: draw(view) is not None and draw(view) is not before)
    assert not np.array_equal(draw(view).rows, before.rows)
    choose(view, "sh", "interreflection", True)
    assert not baking.is_made
    assert draw(view) is not None, "the bake before is shown until there is another"


def test_bounced_light_fixes_the_brdf(view: MainWindow, qtbot: Any) -> None:
    choose(view, "sh", "interreflection", True)
    baking = bake(view, qtbot, "sh")
    assert baking.made is not None
    assert baking.made.transport.interreflection
    set_brdf(view, "ggx:kd=0.1,alpha=0.6,f0=0.5")
    assert baking.why_stale == "The bake is of another BRDF; interreflection is baked for one."


def test_parameters_of_wavelets_reach_the_bake(view: MainWindow, qtbot: Any) -> None:
    choose(view, "wavelet", "coefficients", 32)
    choose(view, "wavelet", "occluder_cells", 32)
    baking = bake(view, qtbot, "wavelet")
    assert baking.made is not None
    assert baking.made.wanted.choices == choices_for(
        "wavelet", terms=2, coefficients=32, interreflection=False, cube=16, occluder_cells=32
    )
    assert baking.made.transport.vectors.counts.max() <= 32


def test_every_choice_is_a_field_with_its_default_among_the_values() -> None:
    for method in METHODS:
        for parameter in choices_of(method):
            assert parameter.default in dict(parameter.offered)
            assert parameter.doc
