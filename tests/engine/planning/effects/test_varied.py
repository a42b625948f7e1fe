"""BRDFs that vary over a model: what their mean costs, which modes show them, and what is baked."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from engine.brdf.brdf import brdf_from_text
from engine.core.steps import drain
from engine.geometry.mesh import Mesh
from engine.light.environment import EnvironmentMap
from engine.planning import bake as bake_plan
from engine.planning.choices import SHARE
from engine.planning.costs.cost_model import CostModel
from engine.planning.effects.estimates import Scenery, estimates, measure_received, scenery, vary
from engine.planning.plan import brdf_of, plan, plan_of
from engine.transport.baking.spatially_varying import variation_from_text, with_parameters
from engine.transport.sh.brdf_table import BrdfTable
from engine.transport.sh.brdf_table_varying import VariedTable
from tests.engine.planning.brute_force import bowl, brute_force, even_sphere, gradient_sky, lamp_sky, sphere
from tests.engine.planning.conftest import threshold

NAME = "spatially-varying-gloss"
BRDF = "ggx:kd=0.3,alpha=0.3,f0=0.2"


@lru_cache(maxsize=4)
def look_at(mesh: Mesh, sky: EnvironmentMap, *texts: str, brdf: str = BRDF) -> Scenery:
    return scenery(mesh, brdf_from_text(brdf), sky, variations=[variation_from_text(text) for text in texts])


@pytest.mark.parametrize(
    ("place", "sky", "text"),
    [
        (even_sphere, lamp_sky, "alpha=0.1:0.6:y"),
        pytest.param(even_sphere, gradient_sky, "kd=0.1:0.8:x", marks=pytest.mark.long),
        pytest.param(bowl, lamp_sky, "f0=0.02:0.9:z", marks=pytest.mark.long),
        (bowl, gradient_sky, "kd=0.28:0.32:y"),
    ],
)
def test_T6_the_mean_of_what_varies_costs_what_was_predicted(
    place: Callable[[], Mesh], sky: Callable[[], EnvironmentMap], text: str
) -> None:
    mesh, light, brdf = place(), sky(), brdf_from_text(BRDF)
    found = look_at(mesh, light, text)
    predicted = estimates(found)[NAME]
    real, own = brute_force(mesh, light), vary(mesh, brdf, [variation_from_text(text)])
    full = real.radiance([each.f for each in own.at(real.vertices)])
    measured = real.error(real.radiance(with_parameters(brdf, dict(found.mean)).f), full)[0]
    assert 0.83 <= predicted.error_rel / measured <= 3.0
    assert any(letter.isdigit() for letter in predicted.text)


def test_what_is_in_the_dark_counts_for_nothing_in_the_mean() -> None:
    """Light comes from above alone: the lower half, which is diffuse, sees none of it."""
    light = gradient_sky()
    upper = np.where(np.arange(32)[:, None, None] < 16, light.radiance, np.float32(0.0))
    scene = look_at(even_sphere(), EnvironmentMap(upper, "above"), "alpha=0.1:0.9:y")
    weight, height = measure_received(scene.sample), scene.sample.of.origin[scene.sample.vertices, 1]
    assert weight[height < -0.95].max() < 0.05 * weight.max()
    by_hand = weight @ (0.5 + 0.4 * height) / weight.sum()
    assert scene.mean["alpha"] == pytest.approx(by_hand, abs=2e-3)
    assert scene.mean["alpha"] > 0.6


def test_a_parameter_that_does_not_change_is_no_effect() -> None:
    scene = look_at(sphere(8), lamp_sky(), "alpha=0.3:0.3:y")
    assert estimates(scene)[NAME].error_rel == 0.0
    assert scene.mean["alpha"] == pytest.approx(0.3)


def test_T6_the_gate_lies_between_variations_just_above_and_below(costs: CostModel, tmp_path: Path) -> None:
    """The one is baked with tables for its vertices, the other as its mean, with a single table."""
    mesh, light, brdf = bowl(), gradient_sky(), brdf_from_text(BRDF)
    texts = ("kd=0.25:0.35:x", "kd=0.245:0.355:x")
    low, high = (look_at(mesh, light, text) for text in texts)
    below, above = (estimates(each)[NAME].error_rel for each in (low, high))
    assert 0.0 < below < above < 1.3 * below
    budget = 0.5 * (threshold(low, NAME) + threshold(high, NAME))
    plans = [plan_of(each, costs, budget, None, modes=("sh",)) for each in (low, high)]
    assert [each.decision(NAME) for each in plans] == ["skipped", "needed"]
    assert plans[0].predicted_error_rel <= budget
    tables = []
    for chosen, text in zip(plans, texts, strict=True):
        ready = drain(bake_plan.prepare(chosen, mesh, brdf, variations=[variation_from_text(text)]))
        tables.append(ready.work.table)
    assert isinstance(tables[0], BrdfTable)
    assert isinstance(tables[1], VariedTable)
    assert brdf_of(plans[0], brdf) == with_parameters(brdf, dict(low.mean))
    real, own = brute_force(mesh, light), vary(mesh, brdf, [variation_from_text(texts[0])])
    full = real.radiance([each.f for each in own.at(real.vertices)])
    assert real.error(real.radiance(brdf_of(plans[0], brdf).f), full)[0] <= SHARE * budget


def test_modes_that_cannot_vary_are_offered_only_where_the_mean_will_do(costs: CostModel) -> None:
    scene = look_at(bowl(), lamp_sky(), "alpha=0.1:0.6:y")
    every: dict[str, Any] = {"noise": lambda depth: 1e-9}
    assert plan_of(scene, costs, 1e-3, None, **every).mode in ("sh", "gaussian")
    for mode in ("wavelet", "direct", "reference"):
        with pytest.raises(ValueError, match="no mode is left"):
            plan_of(scene, costs, 1e-3, None, modes=(mode,), **every)
        left_out = plan_of(scene, costs, 1e-3, None, frozenset(), frozenset({NAME}), modes=(mode,), **every)
        assert left_out.decision(NAME) == "forced off"
        assert left_out.predicted_error_rel >= estimates(scene)[NAME].error_rel
    three = look_at(bowl(), lamp_sky(), "alpha=0.1:0.6:y", "kd=0.1:0.3:x", "f0=0.1:0.3:z")
    with pytest.raises(ValueError, match="no mode is left"):
        plan_of(three, costs, 1e-3, None, modes=("sh",))
    assert plan_of(three, costs, 1e-3, None, modes=("gaussian",)).mode == "gaussian"


@pytest.mark.parametrize("effect", ["glossy", pytest.param("fresnel", marks=pytest.mark.long)])
def test_what_a_user_leaves_out_takes_the_variation_along(costs: CostModel, effect: str) -> None:
    scene = look_at(bowl(), lamp_sky(), "alpha=0.1:0.6:y")
    found = plan_of(scene, costs, 1e-3, None, skip=frozenset({effect}))
    assert (found.decision(effect), found.decision(NAME)) == ("forced off", "skipped")
    errors = [estimates(scene)[name].error_rel for name in (effect, NAME)]
    assert found.predicted_error_rel >= sum(errors)


@pytest.mark.parametrize(
    ("brdf", "text", "force", "words"),
    [
        ("ggx:alpha=0.3", "shine=0:1:y", (), "no parameter"),
        ("ggx:alpha=0.3", "alpha=0.1:7:y", (), "outside"),
        ("lambert:albedo=0.5", "albedo=0.1:0.5:y", ("glossy",), "cannot be forced"),
        ("ggx:alpha=0.3", "alpha=0.1:0.5:y", ("anisotropy",), "cannot be forced"),
    ],
)
def test_what_cannot_vary_is_refused(
    costs: CostModel, brdf: str, text: str, force: tuple[str, ...], words: str
) -> None:
    options: dict[str, Any] = {"cost": costs, "variations": [variation_from_text(text)], "force": force}
    with pytest.raises(ValueError, match=words):
        plan(sphere(8), brdf_from_text(brdf), gradient_sky(), **options)
