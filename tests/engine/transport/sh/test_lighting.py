"""Projection of maps and lamps: exact sums, one convention for maps, cubes and lamps, and linearity under any sun."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest

from engine.light.cube_map import CubeMap, cube_directions
from engine.light.environment import EnvironmentMap, solid_angles, texel_directions
from engine.light.environment_file import read_environment
from engine.light.lamps import Lamp, lights_of
from engine.light.sky import make_built_in
from engine.light.sun_split import split_sun
from engine.transport.sh.basis import cosine_zonal, evaluate, turn_zonal
from engine.transport.sh.lighting import lamp_coefficients, project, scene_coefficients, turn_about_y
from tests.engine.scenes import scene
from tests.engine.transport.sh.test_basis import random_directions
from tests.threads import threads


def noise(height: int, width: int, seed: int = 0) -> EnvironmentMap:
    return EnvironmentMap(np.random.default_rng(seed).uniform(0, 9, (height, width, 3)).astype(np.float32))


def lobes(direction: np.ndarray) -> np.ndarray:
    """A positive polynomial of degree 4 without symmetry."""
    x, y, z = np.moveaxis(direction, -1, 0)
    return np.stack([2 + x + 0.5 * y * z, 3 + y**3 - x * z, 2 + z + x**2 * y * z], axis=-1)


@pytest.mark.parametrize("size", [(1, 1), (1, 2), (2, 4), (7, 3), (64, 128)])
def test_H10_EN9_constant_light_has_one_coefficient(size: Any) -> None:
    coefficients = project(EnvironmentMap(np.ones((*size, 3), np.float32)), 15)
    np.testing.assert_allclose(coefficients[0], math.sqrt(4 * math.pi), rtol=1e-14)
    np.testing.assert_allclose(coefficients[1:], 0.0, atol=1e-13)
    radiance = turn_zonal(cosine_zonal(15), random_directions(20)) @ coefficients / math.pi
    np.testing.assert_allclose(radiance, 1.0, atol=1e-6)


@pytest.mark.parametrize(("size", "close"), [(1, 1e-13), (2, 1e-13), (16, 1e-10), (64, 2e-7)])
def test_H14_constant_cubes_have_one_coefficient(size: int, close: float) -> None:
    coefficients = project(CubeMap(np.ones((6, size, size, 3), np.float32)), 15)
    np.testing.assert_allclose(coefficients[0], math.sqrt(4 * math.pi), rtol=1e-14)
    np.testing.assert_allclose(coefficients[1:], 0.0, atol=close)


def test_maps_and_cubes_are_projected_in_the_world() -> None:
    """A polynomial is what its coefficients say, on fine maps of both kinds."""
    direction = random_directions(30)
    equirectangular = EnvironmentMap(lobes(texel_directions(256, 512)).astype(np.float32))
    cube = CubeMap(lobes(cube_directions(128)).astype(np.float32))
    for lighting in (equirectangular, cube):
        np.testing.assert_allclose(evaluate(5, direction) @ project(lighting, 5), lobes(direction), atol=1e-3)


def test_sums_are_those_of_a_slow_loop_over_finer_texels() -> None:
    """Each texel cut into 8 × 8, its value kept: the midpoint rule comes near the exact integral."""
    environment = noise(6, 9)
    fine = np.repeat(np.repeat(environment.radiance.astype(np.float64), 64, axis=0), 64, axis=1)
    height, width = fine.shape[:2]
    values = evaluate(6, texel_directions(height, width))
    expected = np.einsum("hwi,hwc->ic", values, fine * solid_angles(height, width)[..., None])
    np.testing.assert_allclose(project(environment, 6), expected, atol=2e-3)


@pytest.mark.parametrize("sun", [0.0, 1.0, 1e6])
def test_H13_projection_is_linear_under_any_sun(sun: float) -> None:
    """Both parts and their sum are exact in float32, so what is left is the rounding of the sums."""
    sky = np.random.default_rng(0).integers(1, 64, (128, 256, 3)).astype(np.float32) / 16
    bright = np.zeros_like(sky)
    bright[31, 77] = sun
    whole, first, second = (project(EnvironmentMap(cast(Any, part)), 15) for part in (sky + bright, sky, bright))
    assert np.abs(whole - first - second).max() <= 4 * 2.0**-53 * np.linalg.norm(whole)


def test_sums_do_not_depend_on_threads() -> None:
    environment, cube = noise(64, 128), CubeMap(np.random.default_rng(1).uniform(0, 9, (6, 8, 8, 3)).astype("f4"))
    with threads(2):
        many = project(environment, 6), project(cube, 6)
    with threads(1):
        one = project(environment, 6), project(cube, 6)
    for a, b in zip(many, one, strict=True):
        np.testing.assert_array_equal(a, b)


@pytest.mark.parametrize("columns", [0, 1, 7, 64])
def test_EN11_turned_light_is_the_light_of_the_turned_map(columns: int) -> None:
    """Turning by whole columns moves texels and nothing else; what came from +Z comes from +X after a quarter."""
    environment = noise(32, 64)
    rotated = EnvironmentMap(np.roll(environment.radiance, -columns, axis=1))
    expected = turn_about_y(project(environment, 7), 2 * math.pi * columns / 64)
    np.testing.assert_allclose(project(rotated, 7), expected, atol=1e-12)


def test_EN11_no_turn_is_the_same_to_the_bit() -> None:
    coefficients = project(noise(8, 16), 5)
    assert turn_about_y(coefficients, 0.0) is coefficients


@pytest.mark.parametrize("radius", [0.0, 0.3, 1.2])
def test_lamps_are_the_sum_of_their_directions(radius: float) -> None:
    lamp = Lamp((0.3, -0.5, 0.8), (1.0, 2.0, 0.5), radius)
    lights = lights_of(lamp, 20_000)
    expected = evaluate(8, lights.direction).T @ lights.irradiance
    np.testing.assert_allclose(lamp_coefficients(lamp, 8), expected, atol=2e-4)


def test_a_lamp_facing_a_surface_gives_its_irradiance() -> None:
    lamp = Lamp((0.0, 0.6, 0.8), (3.0, 2.0, 1.0), 0.2)
    irradiance = turn_zonal(cosine_zonal(40), lamp.direction) @ lamp_coefficients(lamp, 40)
    np.testing.assert_allclose(irradiance, lamp.irradiance, rtol=1e-3)


def test_all_light_of_a_scene() -> None:
    environment, lamp = noise(16, 32), Lamp((0.0, 1.0, 0.0), (1.0, 2.0, 3.0), 0.1)
    shown = scene(environment=environment, irradiance=2.0, environment_rotation=0.5, lamps=(lamp,))
    expected = 2.0 * turn_about_y(project(environment, 5), 0.5) + lamp_coefficients(lamp, 5)
    np.testing.assert_allclose(scene_coefficients(shown, 5), expected, rtol=1e-14)
    alone = scene(light=(0.0, 0.6, 0.8), irradiance=2.0)
    np.testing.assert_allclose(scene_coefficients(alone, 5), 2.0 * evaluate(5, [(0.0, 0.6, 0.8)]).T * np.ones(3))


@pytest.mark.parametrize("name", ["openexr/KernerEnvLatLong.exr", "studio_small_03_1k.hdr"])
def test_a_split_sun_lights_as_it_did_in_the_map(shared_data: Callable[[str], Path], name: str) -> None:
    """Independent paths to the same light: texels of the whole map, and what is left of it with closed-form discs."""
    environment = read_environment(shared_data(f"hdr/{name}"))
    rest, lamps = split_sun(environment)
    whole = project(environment, 8)
    both = project(rest, 8) + sum(lamp_coefficients(lamp, 8) for lamp in lamps)
    np.testing.assert_allclose(both[0], whole[0], rtol=1e-6)
    assert np.linalg.norm(both - whole) < 2e-3 * np.linalg.norm(whole)


def test_built_in_suns_light_as_they_did_in_the_map() -> None:
    environment = make_built_in("evening")
    rest, (sun,) = split_sun(environment)
    both = project(rest, 8) + lamp_coefficients(sun, 8)
    assert np.linalg.norm(both - project(environment, 8)) < 2e-3 * np.linalg.norm(both)
