"""Gaussians in plans: when they are chosen; noise of the reference. Their error: `test_mode_error`."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any, cast

import pytest

from benchmarks.transport import predictions
from engine.brdf.brdf import brdf_from_text
from engine.core.steps import drain
from engine.geometry.camera import frame
from engine.planning import bake as bake_plan
from engine.planning.ceilings import BAKE_S, FRAME_S, NONE
from engine.planning.choices import MARGIN, probe
from engine.planning.costs.setting import Setting
from engine.planning.effects.estimates import Scenery, scenery
from engine.planning.effects.lobe_error import lobe_error
from engine.planning.effects.mode_error import mode_errors
from engine.planning.plan import plan_of
from engine.render.reference import reference
from engine.scene.scene import Scene
from engine.tradeoff.draw import Drawer
from engine.transport.method import method_of
from tests.engine.planning.brute_force import bowl, gradient_sky, lamp_sky, sphere
from tests.engine.planning.conftest import every_rate

COSTS, SHARP, GLOSSY = every_rate(), "ggx:kd=0,alpha=0.1,f0=1", "ggx:kd=0.2,alpha=0.15,f0=0.04"


@cache
def shiny() -> Scenery:
    return scenery(sphere(), brdf_from_text(SHARP), lamp_sky())


def test_a_diffuse_brdf_has_no_lobes() -> None:
    found = scenery(sphere(8), brdf_from_text("lambert:albedo=0.5"), gradient_sky())
    assert lobe_error(found, 1) is None
    assert not mode_errors(found).knows("gaussian")


@cache
def sunlit(rows: int) -> Scene:
    """A ball of so few vertices that highlights of a sun wander on its faces."""
    mesh = sphere(rows)
    return Scene(mesh, frame(mesh.positions), brdf_from_text(GLOSSY), environment=lamp_sky(0.05, 400.0))


def predict(scene: Scene) -> float:
    assert scene.environment is not None
    found = lobe_error(scenery(scene.mesh, scene.brdf, scene.environment, camera=scene.camera), 1)
    assert found is not None
    return found


def test_lobes_that_are_mixed_across_coarse_faces_are_in_the_error(monkeypatch: pytest.MonkeyPatch) -> None:
    """Against a bake, drawn beside a reference: without mixing, a quarter of it is predicted."""
    monkeypatch.setattr(predictions, "MAX_S", 0.8)
    scene, one = sunlit(4), Setting("gaussian", {"lobes": 1, "interreflection": 0})
    wanted = predictions.measure(scene, [one], Drawer((48, 48)))[one].rmse_rel
    assert wanted > 0.2
    assert 0.7 < predict(scene) / wanted < 1.4


def test_lobes_that_are_mixed_across_finer_faces_are_nearer() -> None:
    coarse, fine = predict(sunlit(4)), predict(sunlit(16))
    assert fine < 0.5 * coarse


def test_sharp_highlights_take_gaussians_and_not_matrices_of_high_order() -> None:
    scene = shiny()
    low, high = (mode_errors(scene).of(Setting("sh", {"order": order})) for order in (8, 15))
    gaussians = mode_errors(scene).of(Setting("gaussian", {"lobes": 3}))
    assert max(high, gaussians) < low
    chosen = plan_of(scene, COSTS, 1.01 * max(high, gaussians), None, modes=("sh", "gaussian"))
    assert chosen.mode == "gaussian"
    assert chosen.satisfied


def test_what_does_not_fit_into_memory_is_never_chosen() -> None:
    scene = shiny()
    free = plan_of(scene, COSTS, 0.001, None, modes=("sh", "gaussian"), ceilings=NONE)
    room = free.cost.memory_bytes - 1
    chosen = plan_of(scene, COSTS, 0.001, None, modes=("sh", "gaussian"), ceilings=replace(NONE, memory_bytes=room))
    assert chosen.cost.memory_bytes <= room
    with pytest.raises(ValueError, match="of memory"):
        plan_of(scene, COSTS, 0.001, None, modes=("sh", "gaussian"), ceilings=replace(NONE, memory_bytes=1000))


def test_a_long_bake_is_named_and_not_chosen() -> None:
    """Gaussians draw for nothing here, and take an hour."""
    scene = shiny()
    vertices = len(scene.sample.surface.positions)
    tables = {**COSTS.tables, "gaussian-fit": ((1.0, 2.0 * BAKE_S / vertices),)}
    tables |= {f"gaussian-{share}": ((1.0, 0.0),) for share in ("base", "vertex", "pixel")}
    costs = replace(COSTS, tables=tables)
    errors = mode_errors(scene)
    held = replace(NONE, bake_s=BAKE_S)
    budget = 1.01 * max(errors.of(Setting("sh", {"order": 15})), errors.of(Setting("gaussian", {"lobes": 3})))
    free, alone = (plan_of(scene, costs, budget, None, modes=("gaussian",), ceilings=each) for each in (NONE, held))
    assert free.satisfied
    assert (free.exceeded, alone.exceeded) == ((), ("bake_s",))
    assert plan_of(scene, costs, budget, None, modes=("sh", "gaussian"), ceilings=held).mode == "sh"


def test_the_reference_is_taken_where_nothing_else_meets_the_budget() -> None:
    scene = shiny()
    quick = replace(COSTS, tables={**COSTS.tables, **dict.fromkeys(COSTS.tables, ((1.0, 1e-09),))})
    found = plan_of(scene, quick, 1e-3, None, pixels=10, noise=lambda depth: 0.25)
    assert found.cost.frame_s <= FRAME_S
    assert found.mode == "reference"
    assert found.satisfied
    assert 0 <= found.setting["samples"] - math.ceil((0.25 / 1e-3) ** 2) <= 1
    assert found.predicted_error_rel <= 1e-3
    easy = plan_of(scene, COSTS, 0.5, None, noise=lambda depth: 1e-9)
    assert easy.mode != "reference"


def test_a_single_image_is_not_baked_for() -> None:
    found = scenery(bowl(), brdf_from_text("lambert:albedo=0.5"), lamp_sky())
    quick = {name: ((1.0, 1e-9),) for name in COSTS.tables if name.startswith("reference-")}
    costs = replace(COSTS, tables={**COSTS.tables, **quick})
    often, once = (
        plan_of(found, costs, 0.05, None, modes=("sh", "reference"), frames=frames, noise=lambda depth: 0.1)
        for frames in (20_000, 1)
    )
    assert (often.mode, once.mode) == ("sh", "reference")
    assert once.shows("self-shadowing")
    assert once.max_depth > 1 or not once.shows("interreflection")
    with pytest.raises(ValueError, match="too few"):
        plan_of(found, costs, 0.05, None, frames=0)


def test_the_noise_of_a_small_image_tells_that_of_a_large_one() -> None:
    mesh, brdf, sky = bowl(), brdf_from_text("ggx:kd=0.5,alpha=0.3,f0=0.04"), lamp_sky()
    predicted = probe(mesh, cast(Any, brdf), 1, environment=sky) / MARGIN
    whole = drain(reference(Scene(mesh, frame(mesh.positions), brdf, environment=sky), (96, 96), samples=64, seed=3))
    assert whole.uncertainty_rmse_rel is not None
    assert 0.6 < predicted / 8.0 / whole.uncertainty_rmse_rel < 1.7


def test_a_plan_of_gaussians_is_baked_at_the_predicted_size(tmp_path: Path) -> None:
    mesh, brdf = sphere(3), brdf_from_text(SHARP)
    found = plan_of(scenery(mesh, brdf, lamp_sky()), COSTS, 0.5, None, modes=("gaussian",))
    ready = drain(bake_plan.prepare(found, mesh, brdf))
    baked = drain(ready.start(tmp_path / "ball.transport"))
    assert baked.file.size_bytes < ready.work.size_bytes
    predicted = method_of("gaussian").estimate_file_bytes(ready.work.size_bytes)
    assert 0 <= predicted - found.cost.size_bytes < 40_000  # its beginning, and gaps between its arrays
