"""Environment maps: where directions lie, what texels weigh, and their light gathered in cells."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.light.environment import (
    EnvironmentMap,
    all_lights,
    cells,
    direction_at,
    map_coordinates,
    solid_angles,
    texel_directions,
)


@pytest.mark.parametrize(
    ("direction", "u", "v"),
    [((0, 0, 1), 0.5, 0.5), ((1, 0, 0), 0.25, 0.5), ((-1, 0, 0), 0.75, 0.5), ((0, 0, -1), 0.0, 0.5)],
)
def test_layout_is_that_of_openexr(direction: Any, u: float, v: float) -> None:
    assert map_coordinates(np.array(direction, float)) == pytest.approx((u, v), abs=1e-15)


def test_row_zero_looks_up() -> None:
    assert texel_directions(64, 128)[0, :, 1].min() > 0.999


@given(st.floats(0, 0.999), st.floats(0.01, 0.99))
def test_coordinates_and_directions_are_inverse(u: Any, v: Any) -> None:
    assert map_coordinates(direction_at(np.array(u), np.array(v))) == pytest.approx((u, v), abs=1e-12)


@pytest.mark.parametrize("size", [(1, 1), (2, 1), (7, 3), (512, 1024)])
def test_solid_angles_sum_to_the_sphere(size: Any) -> None:
    assert solid_angles(*size).sum() * size[1] == pytest.approx(4 * np.pi, rel=1e-14)


def test_constant_light_gives_pi_on_a_diffuse_receiver() -> None:
    lights = all_lights(EnvironmentMap(np.ones((256, 512, 3), np.float32)))
    irradiance = np.maximum(lights.direction[:, 1:2], 0) * lights.irradiance
    np.testing.assert_allclose(irradiance.sum(axis=0), np.pi, rtol=1e-4)


@pytest.mark.parametrize("size", [(1, 1), (2, 1), (1, 2), (7, 3), (64, 128), (96, 192), (300, 500)])
def test_EN10_cells_hold_the_whole_light_of_any_map(size: Any) -> None:
    environment = EnvironmentMap(np.random.default_rng(0).uniform(0, 9, (*size, 3)).astype(np.float32))
    held = cells(environment, 64)
    assert held.flux.shape == held.moment.shape == (64, 128, 3)
    np.testing.assert_allclose(held.flux.sum(axis=(0, 1)), all_lights(environment).irradiance.sum(axis=0), rtol=1e-12)


def test_light_smaller_than_a_cell_stays_where_it_is() -> None:
    radiance = np.zeros((512, 1024, 3), np.float32)
    radiance[101, 333] = (1e6, 2e6, 3e6)
    (direction,) = all_lights(EnvironmentMap(radiance), 16).direction
    np.testing.assert_allclose(direction, texel_directions(512, 1024)[101, 333], atol=1e-12)


def test_EN9_cells_of_a_constant_are_constant() -> None:
    held = cells(EnvironmentMap(np.full((100, 200, 3), 0.7, np.float32)), 48)
    np.testing.assert_allclose(held.flux / solid_angles(48, 96)[..., None], 0.7, rtol=1e-6)


@pytest.mark.parametrize("value", [np.nan, np.inf, -1.0])
def test_radiance_that_is_none_is_refused(value: float) -> None:
    with pytest.raises(ValueError, match="finite"):
        EnvironmentMap(np.full((2, 4, 3), value, np.float32))
