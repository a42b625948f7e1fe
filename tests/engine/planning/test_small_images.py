"""Small images that a plan measures: on a part of a model as on the whole, and in what a plan tells."""

from __future__ import annotations

from dataclasses import replace

import pytest

from engine.brdf.brdf import brdf_from_text
from engine.core.steps import Steps, drain
from engine.geometry.camera import Camera, frame
from engine.light.lamps import Lamp
from engine.planning import plan as planning
from engine.planning import small_images
from engine.planning.costs.cost_model import CostModel
from engine.planning.costs.setting import Setting, parameters_of
from engine.planning.plan import EffectsPlan, plan
from engine.planning.prior import SURE
from engine.planning.small_images import Measured, measure_small
from engine.scene.scene import Scene
from tests.engine.planning.brute_force import bowl, lamp_sky

ORDER = Setting("sh", {"order": 3})


@pytest.fixture
def scene(monkeypatch: pytest.MonkeyPatch) -> Scene:
    """A bowl under a lamp, in images of few pixels."""
    for name, value in {"SIZE": (24, 18), "MAX_VERTICES": 40, "RESAMPLES": 16}.items():
        monkeypatch.setattr(small_images, name, value)
    mesh = bowl()
    return Scene(
        mesh, frame(mesh.positions), brdf_from_text("phong:kd=0.4,ks=0.02,exponent=10"), environment=lamp_sky()
    )


def test_T1_a_part_of_a_model_has_the_errors_of_the_whole(scene: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    """Some vertices are baked, and the faces around them drawn alone: shadows are those of the whole model."""
    whole = drain(measure_small(scene, [ORDER]))[ORDER]
    monkeypatch.setattr(small_images, "LARGE", 0)
    part = drain(measure_small(scene, [ORDER]))[ORDER]
    assert part.error_rel == pytest.approx(whole.error_rel, rel=0.01)


def test_nothing_is_measured_where_nothing_is_asked_or_seen(scene: Scene) -> None:
    assert drain(measure_small(scene, [])) == {}
    away = replace(scene.camera, eye=(0.0, 0.0, 1e4), target=(0.0, 0.0, 2e4))
    assert drain(measure_small(replace(scene, camera=away), [ORDER])) == {}


def test_the_reference_of_a_scene_is_that_of_its_own_lamps(scene: Scene) -> None:
    """Two scenes that differ in a lamp alone: what is remembered of one is not the truth of the other."""
    direct = Setting("direct", {"directions": 16})
    assert drain(measure_small(scene, [direct]))[direct].error_rel < 0.3
    lit = replace(scene, lamps=(Lamp((0.0, 0.0, 1.0), (9.0, 9.0, 9.0)),))
    assert drain(measure_small(lit, [direct]))[direct].error_rel < 0.3


def give(small: dict[Setting, Measured]) -> Steps[dict[Setting, Measured]]:
    yield from ()
    return small


def test_errors_of_small_images_are_measured_once_for_a_view(
    scene: Scene, costs: CostModel, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[tuple[Camera, Setting]] = []

    def count(scene: Scene, settings: list[Setting]) -> Steps[dict[Setting, Measured]]:
        asked.extend((scene.camera, each) for each in settings)
        return give({setting: Measured(0.1, 0.02) for setting in settings})

    monkeypatch.setattr(planning, "measure_small", count)
    place, other = lamp_sky(), replace(scene.camera, fov_deg=20.0)
    for camera, error in ((scene.camera, 0.5), (scene.camera, 0.4), (other, 0.5)):
        plan(scene.mesh, scene.brdf, place, cost=costs, error=error, modes=("sh",), camera=camera)
    assert {camera for camera, _ in asked} == {scene.camera, other}
    assert len(asked) == len(set(asked))


def test_a_plan_can_be_left_while_small_images_are_measured(scene: Scene, costs: CostModel) -> None:
    camera = replace(scene.camera, fov_deg=33.0)  # which nothing is remembered of
    steps = planning.plan_in_steps(scene.mesh, scene.brdf, lamp_sky(), cost=costs, modes=("sh",), camera=camera)
    notes = [next(steps).note]
    while notes[-1] != small_images.NOTE:
        notes.append(next(steps).note)
    steps.close()
    assert notes[0] == planning.ANALYSING


def test_a_small_image_moves_what_a_plan_tells(scene: Scene, costs: CostModel, monkeypatch: pytest.MonkeyPatch) -> None:
    """A setting whose error was measured far beyond the budget is not chosen."""
    found: list[EffectsPlan] = []
    for _ in range(2):
        small = {each.setting: Measured(0.9, 0.02) for each in found}
        monkeypatch.setattr(planning, "small_errors", lambda _scene, _settings, small=small: give(small))
        found.append(
            plan(
                scene.mesh,
                scene.brdf,
                lamp_sky(),
                cost=costs,
                error=0.5,
                modes=("sh",),
                skip=("interreflection",),
                camera=scene.camera,
            )
        )
    alone, moved = found
    assert alone.probability is not None
    assert moved.probability is not None
    assert moved.setting != alone.setting
    assert all(each.satisfied == ((each.probability or 0.0) >= SURE) for each in found)


def test_the_chosen_setting_and_cheaper_ones_are_measured_where_they_were_not() -> None:
    def direct(*counts: int) -> tuple[Setting, ...]:
        return tuple(Setting("direct", {"directions": count}) for count in counts)

    small = dict.fromkeys((*direct(4, 16, 64), ORDER), Measured(0.1, 0.02))
    assert planning.select_doubtful(direct(64)[0], small) == direct(23, 32, 45)
    assert planning.select_doubtful(direct(256)[0], small) == direct(91, 128)
    assert planning.select_doubtful(direct(4)[0], small) == ()
    assert planning.select_doubtful(ORDER, small) == ()
    order = parameters_of("sh")["order"].sweep[1]
    asked = planning.select_doubtful(ORDER.replace(order=order), small)
    assert asked == (ORDER.replace(order=order),), "the one below was measured"
    assert planning.select_doubtful(ORDER.replace(order=order), {}) == (ORDER, *asked)
