"""Lights in place of an environment: whole flux, choices that refine each other, and the maps that are hard."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from engine.light.environment import EnvironmentMap, all_lights, cells, map_coordinates, texel_directions
from engine.light.light_tree import choose_lights, light_tree


def irradiance(lights: Any, normal: Any) -> Any:
    return (np.maximum(lights.direction @ normal, 0)[:, None] * lights.irradiance).sum(axis=0)


@pytest.fixture(scope="module")
def sky() -> EnvironmentMap:
    y = texel_directions(64, 128)
    sun = np.exp(400 * (y @ np.array([0.6, 0.64, 0.48]) - 1))
    return EnvironmentMap(
        np.array(
            (0.2 + 0.8 * np.clip(y[..., 1:2], 0, 1)) * [0.3, 0.5, 1.0] + 50 * sun[..., None] * [1.0, 0.9, 0.7],
            np.float32,
        )
    )


@settings(max_examples=30)
@given(st.integers(1, 9), st.integers(1, 12), st.integers(1, 200), st.integers(0, 2**32 - 1))
def test_the_lights_carry_the_whole_flux_in_every_channel(height: int, width: int, count: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    radiance = (rng.random((height, width, 3)) ** 8 * 10.0 ** rng.integers(-6, 7)).astype(np.float32)
    radiance[rng.random((height, width)) < 0.3] = 0
    environment = EnvironmentMap(radiance)
    tree = light_tree(cells(environment, 32), 200)
    lights = tree.choice(count)
    assert len(lights.direction) <= count
    np.testing.assert_allclose(lights.irradiance.sum(0), all_lights(environment).irradiance.sum(0), rtol=1e-11)
    np.testing.assert_allclose(np.linalg.norm(lights.direction, axis=1), 1.0, rtol=1e-12)


def test_each_choice_cuts_one_light_of_the_one_before(sky: EnvironmentMap) -> None:
    tree = light_tree(cells(sky, 64), 100)
    for count in range(1, 100):
        choices = (tree.choice(n) for n in (count, count + 1))
        before, after = ({tuple(row) for row in np.hstack([c.irradiance, c.direction])} for c in choices)
        (parent,), halves = before - after, after - before
        assert len(halves) == 2
        np.testing.assert_allclose(np.sum(list(halves), axis=0)[:3], parent[:3], rtol=1e-12)


@pytest.mark.parametrize("count", [1, 2, 3, 50, 64, 512])
def test_as_many_lights_as_asked_for(sky: EnvironmentMap, count: int) -> None:
    assert len(choose_lights(sky, count).direction) == count


def test_more_lights_than_the_tree_was_grown_for_refine_the_same_choices(sky: EnvironmentMap) -> None:
    few, many = choose_lights(sky, 512), choose_lights(sky, 1000)
    assert len(many.direction) == 1000
    np.testing.assert_allclose(irradiance(few, [0, 1, 0]), irradiance(many, [0, 1, 0]), rtol=2e-3)
    held = cells(sky, 256)
    np.testing.assert_array_equal(light_tree(held, 20).choice(8).direction, light_tree(held, 40).choice(8).direction)


@pytest.mark.parametrize(
    "side", [(0, 1, 0), (0.6, 0.8, 0), (0, 0.28, 0.96), (-0.48, 0.6, 0.64), (0, 0, -1), (0, -1, 0)]
)
def test_error_falls_with_the_number_of_lights(sky: EnvironmentMap, side: Any) -> None:
    truth = irradiance(all_lights(sky), np.array(side))
    error = {n: np.abs(irradiance(choose_lights(sky, n), np.array(side)) / truth - 1).max() for n in (4, 32, 512)}
    assert error[4] > error[32] > error[512]
    assert error[32] < 0.04
    assert error[512] < 3e-3


@pytest.mark.parametrize("size", [(1, 1), (2, 1), (1, 2), (6, 12)])
def test_EN1_EN10_constant_light_gives_pi_from_every_side(size: Any) -> None:
    lights = choose_lights(EnvironmentMap(np.ones((*size, 3), np.float32)), 256)
    for normal in (*np.eye(3), *-np.eye(3)):
        np.testing.assert_allclose(irradiance(lights, normal), np.pi, rtol=0.02)


def test_EN6_the_sun_in_one_texel_gets_a_light_of_its_own_and_the_sky_keeps_its_colour() -> None:
    radiance = np.full((128, 256, 3), (0.2, 0.4, 0.9), np.float32)
    radiance[30, 200] = 1e6
    environment = EnvironmentMap(radiance)
    lights = choose_lights(environment, 16)
    sun = texel_directions(128, 256)[30, 200]
    towards = lights.direction @ sun
    assert np.arccos(np.clip(towards.max(), -1, 1)) < np.radians(0.5)
    sky = lights.irradiance[towards < np.cos(np.radians(2.0))]
    assert len(sky) >= 10
    np.testing.assert_allclose(sky / sky[:, 2:], [[0.2 / 0.9, 0.4 / 0.9, 1.0]] * len(sky), rtol=1e-5)
    assert (lights.irradiance > 0).all()


def test_EN4_one_lit_texel_is_one_direction_at_its_centre() -> None:
    radiance = np.zeros((16, 32, 3), np.float32)
    radiance[5, 7] = 3
    lights = choose_lights(EnvironmentMap(radiance), 9)
    u, v = map_coordinates(lights.direction)
    assert ((u * 32).astype(int) == 7).all()
    assert ((v * 16).astype(int) == 5).all()
    (one,) = choose_lights(EnvironmentMap(radiance), 1).direction
    assert np.arccos(one @ texel_directions(16, 32)[5, 7]) < np.radians(0.5)


def test_fewer_lit_cells_give_fewer_lights() -> None:
    radiance = np.zeros((256, 512, 3), np.float32)
    radiance[[3, 99, 200], [0, 50, 511]] = 1.0
    lights = choose_lights(EnvironmentMap(radiance), 64)
    expected = texel_directions(256, 512)[[3, 99, 200], [0, 50, 511]]
    assert len(lights.direction) == 3
    np.testing.assert_allclose(np.sort(lights.direction, axis=0), np.sort(expected, axis=0), atol=1e-12)


def test_EN9_a_lamp_at_the_pole_or_across_the_seam_is_one_light() -> None:
    for towards in ((0.0, 1.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, -1.0)):
        lamp = texel_directions(64, 128) @ np.array(towards) > np.cos(0.2)
        environment = EnvironmentMap((lamp[..., None] * np.ones(3)).astype(np.float32))
        np.testing.assert_allclose(choose_lights(environment, 1).direction[0], towards, atol=1e-9)
        sixteen = choose_lights(environment, 16)
        np.testing.assert_allclose(
            irradiance(sixteen, np.array(towards)), irradiance(all_lights(environment), towards), rtol=2e-3
        )


def test_darkness_is_one_dark_light() -> None:
    lights = choose_lights(EnvironmentMap(np.zeros((4, 8, 3), np.float32)), 5)
    assert lights.irradiance.tolist() == [[0.0, 0.0, 0.0]]
    assert np.isfinite(lights.direction).all()


@pytest.mark.parametrize("value", [1e-38, 3e38])
def test_light_at_the_ends_of_float32_stays_finite(value: float) -> None:
    lights = choose_lights(EnvironmentMap(np.full((4, 8, 3), value, np.float32)), 32)
    np.testing.assert_allclose(lights.irradiance.sum(axis=0), 4 * np.pi * value, rtol=1e-6)
    np.testing.assert_allclose(np.linalg.norm(lights.direction, axis=1), 1.0)


def test_no_lights_are_too_few(sky: EnvironmentMap) -> None:
    with pytest.raises(ValueError, match="too few"):
        choose_lights(sky, 0)
