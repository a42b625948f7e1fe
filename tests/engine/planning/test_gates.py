"""Scenes just above and just below the threshold of each effect: what is decided, and what leaving it out then costs.

Self-shadowing, anisotropy, the split of suns and mesostructure have a threshold in the budget; the rise towards grazing
views and what is sent back to the light cost nothing to keep, and are left out only where they are not there, which is
a threshold too. Interreflection and gloss: `test_plan`; what varies over a surface: `test_varied`.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest

from engine.brdf.brdf import brdf_from_text
from engine.core.steps import drain
from engine.geometry.camera import frame
from engine.geometry.mesh import Mesh
from engine.light.environment import EnvironmentMap
from engine.planning.choices import SHARE
from engine.planning.costs.cost_model import CostModel
from engine.planning.effects.estimates import NOISE, Scenery, mesostructure, scenery
from engine.planning.effects.simplified import Unbrushed, WithoutRetro, WithoutRise
from engine.planning.plan import plan_of
from engine.render.direct import radiance
from engine.scene.material import Material
from engine.scene.scene import Scene
from engine.shading.shading_map import ShadingMap
from engine.transport.wavelet.quantise import encode_light
from tests.engine.planning.brute_force import bowl, brute_force, even_sphere, gradient_sky, lamp_sky, sphere, sunny_sky
from tests.engine.planning.conftest import threshold

PAINT = "ggx:kd=0.4,alpha=0.4,f0=0.04"


def woven(contrast: float) -> Material:
    """Bright and dark threads on a diffuse cloth: at every r the texels have that mean."""
    rng = np.random.default_rng(3)
    thread = 1.0 + contrast * rng.choice([-1.0, 1.0], (24, 24, 1)) * np.array([1.0, 0.9, 0.8])
    mean = np.linspace(0.0, 0.3, 5)
    slices = (mean[:, None, None, None] * thread).astype(np.float32)
    return Material(ShadingMap(slices, 0.3, mean), None, "lambert:albedo=0.5", sigma=1.0)


def make_bowl(depth: float) -> Scenery:
    return scenery(bowl(depth), brdf_from_text("lambert:albedo=0.1"), gradient_sky())


def make_brushing(apart: float) -> Scenery:
    return scenery(sphere(), brdf_from_text(f"ward:alpha_x={0.3 - apart},alpha_y={0.3 + apart}"), gradient_sky())


def make_sun(level: float) -> Scenery:
    return scenery(even_sphere(), brdf_from_text("lambert:albedo=0.5"), sunny_sky(level))


def make_threads(contrast: float) -> Scenery:
    return scenery(sphere(), brdf_from_text("lambert:albedo=0.5"), gradient_sky(), material=woven(contrast))


def without_shadows(scene: Scenery, below: float) -> float:
    real, brdf = brute_force(bowl(below), gradient_sky()), scene.brdf
    return real.error(real.radiance(brdf.f, shadows=False), real.radiance(brdf.f))[0]


def without_brushing(scene: Scenery, below: float) -> float:
    real, brdf = brute_force(sphere(), gradient_sky()), scene.brdf
    return real.error(real.radiance(Unbrushed(brdf).f), real.radiance(brdf.f))[0]


def without_split(scene: Scenery, below: float) -> float:
    """The sun stays in the map, and quantised wavelets keep the map: on a convex diffuse model irradiance is all."""
    from engine.light.cube_map import cube_directions, cube_of, cube_solid_angles
    from engine.transport.wavelet.haar import cube_of_coefficients

    sky, normal = sunny_sky(below), even_sphere().normals.astype(np.float64)
    exact = cube_of(sky, 64).radiance
    kept = cube_of_coefficients(encode_light(cube_of(sky, 16).radiance).coefficients)

    def irradiance(radiance: Any) -> Any:
        edge = radiance.shape[1]
        weight = radiance.reshape(-1, 3) * np.tile(cube_solid_angles(edge).reshape(-1), 6)[:, None]
        return np.maximum(normal @ cube_directions(edge).reshape(-1, 3).T, 0.0) @ weight

    one, other = irradiance(exact), irradiance(kept)
    return float(np.sqrt(((one - other) ** 2).sum() / (one**2).sum()))


def apart_by_threads(contrast: float, sky: EnvironmentMap, text: str) -> float:
    """Of images of a ball with threads and with their mean."""
    mesh, brdf = make_textured_sphere(), brdf_from_text(text)
    one, other = (
        drain(
            radiance(Scene(mesh, frame(mesh.positions), brdf, environment=sky, material=each, directions=32), (64, 64))
        )
        for each in (woven(contrast), woven(0.0))
    )
    inside = one[..., 3] > 0.99
    apart, whole = (one - other)[inside][:, :3].astype(float), one[inside][:, :3].astype(float)
    return float(np.sqrt((apart**2).sum() / (whole**2).sum()))


def without_threads(_scene: Scenery, below: float) -> float:
    return apart_by_threads(below, gradient_sky(), "lambert:albedo=0.5")


@cache
def make_textured_sphere() -> Mesh:
    from engine.geometry.shapes import shape

    return shape("sphere")


#: Effect, scene by its parameter, values just below and just above the threshold, mode, and what leaving out costs.
GATES: tuple[tuple[str, Callable[[float], Scenery], float, float, tuple[str, ...], Any], ...] = (
    ("self-shadowing", make_bowl, 0.06, 0.065, ("sh",), without_shadows),
    ("anisotropy", make_brushing, 0.1, 0.11, ("sh",), without_brushing),
    ("sun-split", make_sun, 1.35e4, 1.3e4, ("wavelet",), without_split),
    ("mesostructure", make_threads, 0.05, 0.055, ("sh",), without_threads),
)


@pytest.mark.parametrize(("effect", "place", "below", "above", "modes", "cost_of"), GATES, ids=[g[0] for g in GATES])
def test_T6_scenes_just_above_and_below_a_threshold(
    costs: CostModel,
    effect: str,
    place: Callable[[float], Scenery],
    below: float,
    above: float,
    modes: tuple[str, ...],
    cost_of: Callable[[Scenery, float], float],
) -> None:
    scenes = [place(value) for value in (below, above)]
    low, high = (threshold(scene, effect) for scene in scenes)
    assert 0.0 < low < high < 1.3 * low
    budget = 0.5 * (low + high)
    plans = [plan_of(scene, costs, budget, None, modes=modes) for scene in scenes]
    assert [each.decision(effect) for each in plans] == ["skipped", "needed"]
    assert plans[0].predicted_error_rel <= budget
    assert cost_of(scenes[0], below) <= SHARE * budget


@pytest.mark.parametrize(
    ("effect", "below", "above", "simplified"),
    [
        ("fresnel", "oren-nayar:sigma_deg=1", "oren-nayar:sigma_deg=2", WithoutRise),
        ("retro-reflection", "oren-nayar:sigma_deg=1", "oren-nayar:sigma_deg=1.3", WithoutRetro),
    ],
)
def test_T6_what_costs_nothing_is_left_out_only_where_it_is_hardly_there(
    costs: CostModel, effect: str, below: str, above: str, simplified: Callable[[Any], Any]
) -> None:
    scenes = [scenery(sphere(8), brdf_from_text(text), gradient_sky()) for text in (below, above)]
    without, with_it = (plan_of(scene, costs, 1e-2, None, modes=("sh",)) for scene in scenes)
    assert (without.decision(effect), with_it.decision(effect)) == ("skipped", "needed")
    real, brdf = brute_force(sphere(8), gradient_sky()), scenes[0].brdf
    assert real.error(real.radiance(simplified(brdf).f), real.radiance(brdf.f))[0] <= NOISE


#: Contrast, light and BRDF.
THREADS = tuple(itertools.product((0.05, 0.6), (gradient_sky, lamp_sky), ("lambert:albedo=0.5", PAINT)))


@pytest.mark.parametrize(
    ("contrast", "sky", "text"),
    [THREADS[-1], *(pytest.param(*row, marks=pytest.mark.long) for row in THREADS[:-1])],
)
def test_T6_mesostructure_is_what_images_without_it_lose(
    contrast: float, sky: Callable[[], EnvironmentMap], text: str
) -> None:
    predicted = mesostructure(scenery(make_textured_sphere(), brdf_from_text(text), sky(), material=woven(contrast)))
    assert 0.83 <= predicted.error_rel / apart_by_threads(contrast, sky(), text) <= 3.0
