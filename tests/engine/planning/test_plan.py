"""Plans: what they decide just above and just below a threshold, that they never get costlier with a larger budget, and
that a bake does what its plan says."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any, cast

import numpy as np
import psutil
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from engine.brdf.brdf import brdf_from_text
from engine.brdf.models.diffuse import Lambert
from engine.core.steps import drain
from engine.factor.hemisphere_map import HemisphereMap
from engine.factor.separable_factors import SeparableFactors
from engine.geometry.ground import Ground
from engine.light.environment import EnvironmentMap
from engine.planning import bake as bake_plan
from engine.planning.ceilings import BAKE_S, FRAME_S, NONE, Ceilings, usual
from engine.planning.choices import BYTE_S, FRAMES, LIGHTS, SHARE
from engine.planning.costs.cost_model import CostModel, Load
from engine.planning.costs.setting import Setting
from engine.planning.effects.estimates import EFFECTS, Scenery, estimates, scenery
from engine.planning.effects.simplified import Brushed, GlossyLambert, Unbrushed, WithoutRetro, WithoutRise
from engine.planning.methods.sh import SPREAD
from engine.planning.plan import NOTHING, EffectsPlan, brdf_of, plan, plan_of
from engine.planning.predicted_error import BETWEEN, FEW, PredictedErrors
from engine.transport.baking import visibility
from engine.transport.sh.lighting import project
from engine.transport.sh.transfer import transfer
from engine.transport.wavelet.transfer import MAX_TERMS
from tests.engine.planning.brute_force import bowl, gradient_sky, lamp_sky, sphere, spheres, sunny_sky
from tests.engine.planning.conftest import every_rate


@cache
def look_at() -> Scenery:
    return scenery(bowl(), brdf_from_text("phong:kd=0.4,ks=0.02,exponent=10"), lamp_sky())


#: Plans with these costs are made often in one test.
COSTS = every_rate()


def price(found: EffectsPlan) -> float:
    cost = found.cost
    return cost.frame_s + cost.relight_s / LIGHTS + cost.bake_s / FRAMES + BYTE_S * cost.memory_bytes


@settings(max_examples=5)
@given(st.floats(1e-3, 1.0), st.floats(1.0, 10.0))
def test_T7_a_larger_budget_of_error_never_costs_more(error: float, factor: float) -> None:
    scene = look_at()
    one, other = plan_of(scene, COSTS, error, None), plan_of(scene, COSTS, error * factor, None)
    if one.satisfied:
        assert other.satisfied
        assert price(other) <= price(one) * (1.0 + 1e-12)
        assert one.predicted_error_rel <= error
    else:
        assert one.predicted_error_rel > error


def test_a_plan_tells_the_interval_of_its_error() -> None:
    found = plan_of(look_at(), COSTS, 0.02, None, modes=("sh",))
    low, high = found.error_interval_rel
    assert 0.0 < low < found.predicted_error_rel < high
    # without anything left out it is that of the method alone
    errors = PredictedErrors(look_at(), estimates(look_at()), None)
    setting = Setting("sh", {"order": 5, "interreflection": 1})
    own, (least, most) = errors.of(setting, frozenset()), SPREAD.around
    shown = own - errors.left_out(setting, frozenset())
    assert errors.left_out(setting, frozenset()) == 0.0
    between = BETWEEN * (FEW / len(bowl().positions)) ** 0.25
    largest = math.hypot(most * shown, between)
    assert errors.interval(setting, frozenset()) == pytest.approx((least * shown, largest))
    # what is left out may lie where the view does not look at best, and adds by itself at worst
    missing = estimates(look_at())["self-shadowing"].error_rel
    low, high = errors.interval(setting, frozenset({"self-shadowing"}))
    assert low == pytest.approx(max(least * shown, 0.05 * missing))
    assert high == pytest.approx(largest + missing / 0.83)
    # what is not baked is worked out at every pixel
    assert errors.between(Setting("direct", {"directions": 16})) == 0.0


@settings(max_examples=8)
@given(st.floats(0.1, 1e4), st.floats(1.0, 10.0))
def test_T7_more_time_never_ends_in_a_larger_error(time_ms: float, factor: float) -> None:
    scene = look_at()
    one, other = plan_of(scene, COSTS, None, time_ms), plan_of(scene, COSTS, None, time_ms * factor)
    if one.satisfied:
        assert other.predicted_error_rel <= one.predicted_error_rel
        assert one.cost.frame_s <= 1e-3 * time_ms


@pytest.mark.parametrize(
    ("effect", "place", "sky", "text"),
    [
        ("interreflection", lambda: bowl(0.25), gradient_sky, "lambert:albedo={}"),
        ("glossy", sphere, gradient_sky, "phong:kd=0.5,ks={},exponent=20"),
    ],
)
def test_T6_a_gate_lies_between_scenes_just_above_and_below(
    costs: CostModel, effect: str, place: Callable[[], Any], sky: Callable[[], Any], text: str
) -> None:
    """Two BRDFs nearly alike, and a budget between them: one has the effect, the other goes without."""
    mesh, light = place(), sky()
    low, high = (scenery(mesh, brdf_from_text(text.format(value)), light) for value in ("0.1", "0.11"))
    below, above = (estimates(each)[effect].error_rel for each in (low, high))
    assert 0.0 < below < above < 1.3 * below
    budget = 0.5 * (below + above) / SHARE
    without, with_it = (plan_of(each, costs, budget, None, modes=("sh",)) for each in (low, high))
    assert (without.decision(effect), with_it.decision(effect)) == ("skipped", "needed")
    assert without.predicted_error_rel <= budget


def test_T6_all_frequency_light_is_needed_beyond_few_harmonics(costs: CostModel) -> None:
    scene = look_at()
    error = estimates(scene)["all-frequency-light"].error_rel
    loose, tight = (plan_of(scene, costs, error * factor, None, modes=("sh",)) for factor in (2.5, 0.95))
    assert loose.decision("all-frequency-light") == "skipped"
    assert tight.decision("all-frequency-light") == "needed"
    assert tight.setting["order"] > 5 >= loose.setting["order"]


def test_what_a_user_asks_for_is_obeyed(costs: CostModel) -> None:
    scene = look_at()
    every = frozenset(EFFECTS)
    for name in EFFECTS:
        forced = plan_of(scene, costs, 0.5, None, frozenset({name}))
        assert forced.decision(name) == "forced on"
        left_out = plan_of(scene, costs, 0.5, None, skip=frozenset({name}))
        assert left_out.decision(name) == "forced off"
        assert left_out.predicted_error_rel >= plan_of(scene, costs, 1e-9, None).predicted_error_rel
    nothing = plan_of(scene, costs, 1e-9, None, skip=every)
    assert not nothing.satisfied
    assert not any(effect.on for effect in nothing.effects)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"error": 0.0}, "not above 0"),
        ({"error": float("nan")}, "not above 0"),
        ({"time_ms": -1.0}, "not above 0"),
        ({"error": 0.1, "time_ms": 1.0}, "one budget"),
        ({"force": ["shine"]}, "unknown effect"),
        ({"force": ["glossy"], "skip": ["glossy"]}, "at once"),
    ],
)
def test_what_is_no_plan_is_refused(costs: CostModel, options: dict[str, Any], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        plan(sphere(), brdf_from_text("lambert"), gradient_sky(), cost=costs, **options)


def test_T2_a_diffuse_model_is_baked_as_vectors_without_a_ray(
    costs: CostModel, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    mesh, brdf = sphere(), brdf_from_text("lambert:albedo=0.5")
    found = plan(mesh, brdf, gradient_sky(), cost=costs, error=0.05, modes=("sh",))
    calls: list[str] = []
    count(monkeypatch, calls)
    ready = drain(bake_plan.prepare(found, mesh, brdf))
    baked = drain(ready.start(tmp_path / "ball.transport"))
    assert calls == []
    assert baked.transport.rows.shape == (len(mesh.positions), 1, found.setting["order"] ** 2)
    assert baked.bounce_s == 0.0


def count(monkeypatch: pytest.MonkeyPatch, calls: list[str]) -> None:
    """Note every ray that is cast and every search for free vertices from here on."""
    from engine.geometry.ray_caster import RayCaster

    for owner, name in (
        (RayCaster, "occluded"),
        (RayCaster, "intersect"),
        (visibility, "sees_hemisphere"),
    ):
        was = getattr(owner, name)

        def note(*arguments: Any, _was: Any = was, _name: str = name, **more: Any) -> Any:
            calls.append(_name)
            return _was(*arguments, **more)

        monkeypatch.setattr(owner, name, note)


def test_T1_forced_effects_of_a_convex_model_change_nothing(
    costs: CostModel, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """All rays and bounces are done, and the result is the same to the last bit."""
    mesh, brdf = sphere(10), brdf_from_text("lambert:albedo=0.5")
    options: dict[str, Any] = {"cost": costs, "error": 0.05, "modes": ("sh",)}
    lean = plan(mesh, brdf, gradient_sky(), **options)
    full = plan(mesh, brdf, gradient_sky(), force=("self-shadowing", "interreflection"), **options)
    one = drain(drain(bake_plan.prepare(lean, mesh, brdf)).start(tmp_path / "lean.transport"))
    calls: list[str] = []
    count(monkeypatch, calls)
    other = drain(drain(bake_plan.prepare(full, mesh, brdf)).start(tmp_path / "full.transport"))
    assert {"occluded", "intersect"} <= set(calls)
    assert full.setting["order"] == lean.setting["order"]
    light = project(gradient_sky(), lean.setting["order"])
    np.testing.assert_allclose(transfer(other.transport, light), transfer(one.transport, light), atol=1e-12)


def test_T1_forced_gloss_of_a_diffuse_model_changes_rounding_only(costs: CostModel, tmp_path: Path) -> None:
    mesh, brdf = sphere(8), brdf_from_text("lambert:albedo=0.5")
    forced = plan(mesh, brdf, gradient_sky(), cost=costs, error=0.05, modes=("sh",), force=("glossy",))
    baked = drain(drain(bake_plan.prepare(forced, mesh, brdf)).start(tmp_path / "glossy.transport"))
    assert baked.transport.rows.shape[0] == len(mesh.positions) * forced.setting["order"] ** 2
    from engine.transport.sh.transfer import local_views, sum_signed_radiance

    light = project(gradient_sky(), forced.setting["order"])
    rows = transfer(baked.transport, light)
    local = local_views(baked.transport, (0.0, 0.0, 50.0))
    value = sum_signed_radiance(baked.transport, rows, local, np.arange(len(mesh.positions)))
    seen = local[:, 2] > 0.1
    wanted = 0.5 * (1.0 + 0.6 * 2.0 / 3.0 * mesh.normals[:, 1:2])
    np.testing.assert_allclose(value[seen], np.broadcast_to(wanted, value.shape)[seen], rtol=5e-3)


def test_T5_what_is_skipped_takes_no_bytes() -> None:
    found, mesh = look_at(), bowl()
    both = frozenset({"glossy", "interreflection"})
    lean = plan_of(found, COSTS, 0.5, None, skip=both, modes=("sh",))
    full = plan_of(found, COSTS, 0.5, None, force=both, modes=("sh",))
    sizes = [drain(bake_plan.prepare(each, mesh, found.brdf)).work.size_bytes for each in (lean, full)]
    matrices = 4 * len(mesh.positions) * (full.setting["order"] ** 4 - lean.setting["order"] ** 2)
    assert sizes[1] - sizes[0] > 0.9 * matrices


def test_T5_skipped_shadows_cast_no_ray_and_need_no_tree(
    costs: CostModel, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    mesh, brdf = spheres(2.2), brdf_from_text("lambert:albedo=0.5")
    skip = ("self-shadowing", "interreflection")
    found = plan(mesh, brdf, gradient_sky(), cost=costs, error=0.5, modes=("sh",), skip=skip)
    calls: list[str] = []
    count(monkeypatch, calls)
    ready = drain(bake_plan.prepare(found, mesh, brdf))
    baked = drain(ready.start(tmp_path / "balls.transport"))
    assert calls == []
    assert len(ready.work.caster.faces) == 0
    rows = transfer(baked.transport, project(gradient_sky(0.0), found.setting["order"]))
    np.testing.assert_allclose(rows, 1.0, rtol=1e-5)


def test_brdfs_lose_what_a_plan_leaves_out() -> None:
    whole = plan_of(look_at(), COSTS, 0.5, None)

    def draw(text: str, effect: str, decision: str) -> Any:
        rows = (replace(row, decision=decision if row.effect == effect else "needed") for row in whole.effects)
        return brdf_of(replace(whole, effects=tuple(rows)), brdf_from_text(text))

    dust, brushed = "oren-nayar", "ward:alpha_x=0.1,alpha_y=0.4"
    assert draw(dust, "glossy", "needed") == brdf_from_text(dust)
    assert isinstance(draw(dust, "glossy", "forced off"), Lambert)
    assert isinstance(draw(dust, "retro-reflection", "forced off"), WithoutRetro)
    assert isinstance(draw(dust, "fresnel", "forced off"), WithoutRise)
    assert isinstance(draw(brushed, "anisotropy", "skipped"), Unbrushed)
    assert isinstance(draw("lambert", "glossy", "forced on"), GlossyLambert)
    assert isinstance(draw(dust, "anisotropy", "forced on"), Brushed)


def test_a_ground_shades_a_model_that_is_convex(costs: CostModel) -> None:
    mesh, brdf = sphere(), brdf_from_text("lambert:albedo=0.5")
    found = plan(mesh, brdf, lamp_sky(), cost=costs, error=0.02, modes=("sh",), ground=Ground(albedo=0.8, cells=16))
    assert found.unoccluded_fraction < 1.0
    assert found.shows("self-shadowing")
    assert found.shows("interreflection")


def test_T3_suns_are_split_only_where_there_are_any(costs: CostModel) -> None:
    mesh, brdf = sphere(8), brdf_from_text("ggx:kd=0.1,alpha=0.1,f0=0.5")
    for light, count in ((sunny_sky(1.0), 0), (sunny_sky(1e5), 1)):
        found = scenery(mesh, brdf, light)
        assert bool(len(found.sample.lamp_direction)) == bool(count)
        assert (estimates(found)["sun-split"].error_rel > 0.0) == bool(count)
        assert plan_of(found, costs, 0.005, None, modes=("sh",)).shows("sun-split") == bool(count)


def test_a_budget_that_no_frame_meets_names_the_reference_that_does() -> None:
    """Many frames: the best mode and the reference beside it. A single one: the reference itself, however long."""
    scene, options = look_at(), {"noise": lambda depth: 0.25}
    often, once = (plan_of(scene, COSTS, 1e-3, None, frames=frames, **cast(Any, options)) for frames in (FRAMES, 1))
    assert not often.satisfied
    assert often.mode != "reference"
    assert often.predicted_error_rel > 1e-3
    assert often.beyond is not None
    assert often.beyond.setting.mode == "reference"
    assert often.beyond.exceeded == ("frame_s",)
    assert often.beyond.error_rel <= 1e-3
    assert (once.mode, once.satisfied, once.beyond) == ("reference", True, None)
    assert once.setting == often.beyond.setting
    assert (once.max_depth, once.cost) == (often.beyond.max_depth, often.beyond.cost)
    only = plan_of(scene, COSTS, 1e-3, None, modes=("reference",), **cast(Any, options))
    assert (only.mode, only.satisfied, only.exceeded) == ("reference", True, ("frame_s",))
    assert plan_of(scene, COSTS, 1e-9, None, **cast(Any, options)).beyond is None  # so many samples are not possible


def test_a_budget_that_nothing_meets_weighs_error_against_cost() -> None:
    """A least error that costs too much is not chosen for being the least."""
    scene = look_at()
    found = plan_of(scene, COSTS, 1e-9, None, ceilings=NONE)
    best = plan_of(scene, COSTS, None, 1e9, ceilings=NONE)
    assert not found.satisfied
    assert best.predicted_error_rel < found.predicted_error_rel
    assert found.predicted_error_rel**2 * price(found) < best.predicted_error_rel**2 * price(best)


@pytest.mark.parametrize("name", ["memory_bytes", "bake_s", "frame_s"])
def test_nothing_beyond_a_ceiling_is_chosen_but_what_meets_the_budget_there_is_named(name: str) -> None:
    scene = look_at()
    exact = plan_of(scene, COSTS, None, 1e9, ceilings=NONE)
    budget = 1.01 * exact.predicted_error_rel
    free = plan_of(scene, COSTS, budget, None, ceilings=NONE)
    assert free.satisfied
    room = replace(NONE, **{name: 0.99 * getattr(free.cost, name)})
    held = plan_of(scene, COSTS, budget, None, ceilings=room)
    assert getattr(held.cost, name) <= getattr(room, name)
    assert held.exceeded == ()
    if not held.satisfied:
        assert held.beyond is not None
        assert held.beyond.error_rel <= budget
        assert held.beyond.exceeded == (name,)


def test_the_usual_ceilings_are_a_quarter_of_memory_ten_minutes_and_a_tenth_of_a_second() -> None:
    memory = psutil.virtual_memory()
    found = usual()
    assert (found.bake_s, found.frame_s) == (BAKE_S, FRAME_S) == (600.0, 0.1)
    assert 0.2 * memory.available < found.memory_bytes < 0.3 * memory.total
    assert usual(bake_s=2.0, frame_s=3.0, memory_bytes=4.0) == Ceilings(4.0, 2.0, 3.0)
    with pytest.raises(ValueError, match="not above 0"):
        Ceilings(0.0)


def test_where_everything_is_beyond_a_ceiling_the_quick_ones_are_offered_and_the_plan_says_so() -> None:
    """A reference of minutes is no way out of frames that take a little too long."""
    quickest = plan_of(look_at(), COSTS, None, 1e-9, ceilings=NONE).cost.frame_s
    options: dict[str, Any] = {"ceilings": replace(NONE, frame_s=0.5 * quickest), "noise": lambda depth: 0.25}
    held = plan_of(look_at(), COSTS, 1e-3, None, **options)
    assert held.exceeded == ("frame_s",)
    assert held.cost.frame_s <= 2.0 * quickest


@pytest.mark.parametrize(("parametrisation", "terms"), [("half-diff", 1), ("in-out", MAX_TERMS + 1)])
def test_factors_that_wavelets_refuse_are_planned_without_them(parametrisation: Any, terms: int) -> None:
    hemisphere_map = HemisphereMap("orthographic", 8)
    texture = np.full((terms, *hemisphere_map.shape, 3), 0.3 / np.sqrt(terms), np.float32)
    factors = SeparableFactors(hemisphere_map, parametrisation, texture, texture, True, True)
    scene = scenery(sphere(), factors, gradient_sky())
    assert plan_of(scene, COSTS, 1e-9, None).mode != "wavelet"
    with pytest.raises(ValueError, match="no mode is left"):
        plan_of(scene, COSTS, 0.5, None, modes=("wavelet",))


def test_a_choice_near_a_ceiling_names_the_other_choice() -> None:
    """A ceiling just above the bake of the choice: where bakes take a little longer another setting is chosen."""
    scene = look_at()
    free = plan_of(scene, COSTS, 0.02, None, modes=("sh", "direct"), ceilings=NONE)
    assert free.satisfied
    assert free.cost.bake_s > 0.0
    assert free.alternatives == ()
    for factor, slower in ((1.1, True), (0.9, False)):
        room = replace(NONE, bake_s=factor * free.cost.bake_s)
        near = plan_of(scene, COSTS, 0.02, None, modes=("sh", "direct"), ceilings=room)
        found = [each for each in near.alternatives if each.slower == slower]
        assert [each.ceilings for each in found] == [("bake_s",)]
        assert (near.setting == free.setting) == slower
        assert (found[0].setting == free.setting) != slower
    far = replace(NONE, bake_s=10.0 * COSTS.within * free.cost.bake_s)
    assert plan_of(scene, COSTS, 0.02, None, modes=("sh", "direct"), ceilings=far).alternatives == ()


def test_an_effect_that_a_ceiling_keeps_out_is_named() -> None:
    """Shadows are worth more than the budget, and no bake fits: the plan says which ceiling keeps them out."""
    scene = look_at()
    shadows = estimates(scene)["self-shadowing"].error_rel
    budget = 0.5 * shadows
    free = plan_of(scene, COSTS, budget, None, ceilings=NONE, modes=("sh", "direct"))
    assert free.shows("self-shadowing")
    assert not free.excluded
    held = plan_of(scene, COSTS, budget, None, ceilings=replace(NONE, bake_s=1e-9), modes=("sh", "direct"))
    assert held.decision("self-shadowing") == "skipped"
    assert held.excluded["self-shadowing"] == ("bake_s",)


def test_no_effect_is_needed_that_is_worth_nothing() -> None:
    for error in (1e-3, 0.02, 0.3):
        for effect in plan_of(look_at(), COSTS, error, None).effects:
            assert effect.decision != "needed" or effect.estimated_error_rel >= NOTHING


def two_suns(rest: float) -> EnvironmentMap:
    """Two suns of a texel, 24° above the horizon, over an even rest."""
    radiance = np.full((32, 64, 3), rest, np.float32)
    radiance[11, 40] = radiance[11, 20] = 300.0
    return EnvironmentMap(radiance)


def errors_of_bowl(brdf: str, rest: float) -> PredictedErrors:
    """Of a bowl, which shades itself, under two suns."""
    looked = scenery(bowl(), brdf_from_text(brdf), two_suns(rest))
    return PredictedErrors(looked, estimates(looked), None)


def test_few_sharp_lights_are_summed_with_their_shadows() -> None:
    """Direct light shows highlights and shadows of two suns exactly: what it lacks is what comes between the parts."""
    errors = errors_of_bowl("ward:kd=0.2,ks=0.4,alpha_x=0.02,alpha_y=0.2", 1e-5)
    setting, lacking = Setting("direct", {"directions": 4}), errors.found["interreflection"].error_rel
    assert errors.shows_shadows(setting, frozenset())
    assert errors.predict(setting, frozenset()) == pytest.approx(lacking, abs=1e-3)
    assert errors.predict(setting, frozenset({"self-shadowing"})) > lacking + errors.found["self-shadowing"].error_rel
    found = plan_of(errors.scene, replace(COSTS, renderer="a device"), lacking + 0.01, None)
    assert found.mode == "direct"
    assert found.satisfied
    assert found.casts_shadows
    assert found.decision("self-shadowing") == "needed"


def test_shadows_that_a_sky_lacks_are_part_of_the_error_of_direct_light() -> None:
    errors = errors_of_bowl("ggx:kd=0.3,alpha=0.4", 0.3)
    assert not errors.scene.sample.light.is_sharp
    setting = Setting("direct", {"directions": 256})
    assert errors.casts(setting, frozenset())
    assert not errors.shows_shadows(setting, frozenset())
    own = errors.predict(setting, frozenset()) - errors.found["interreflection"].error_rel
    assert 0.02 < own < errors.found["self-shadowing"].error_rel


def test_without_suns_direct_light_has_no_shadows() -> None:
    looked = scenery(bowl(), brdf_from_text("ggx"), gradient_sky())
    errors = PredictedErrors(looked, estimates(looked), None)
    assert not errors.casts(Setting("direct"), frozenset())


@pytest.mark.parametrize("renderer", ["processor", "llvmpipe"])
def test_shadows_of_direct_light_are_priced_by_counted_rays(renderer: str) -> None:
    model = replace(COSTS, renderer=renderer)
    load = Load(1000, 5000, 2000, covered=0.5)
    few = model.predict(Setting("direct", {"directions": 4}), 1000, 5000, load=load)
    lit = model.predict(Setting("direct", {"directions": 4}), 1000, 5000, load=replace(load, shadows=3))
    more = model.predict(Setting("direct", {"directions": 7}), 1000, 5000, load=load)
    rays_s = 3 * 2500 * model.rate("ray") * load.ray_scale
    assert few.frame_s < more.frame_s
    assert lit.frame_s == pytest.approx(more.frame_s + (rays_s if renderer == "processor" else 0.0))
    assert (lit.relight_s > 0.0) == (renderer != "processor")
