"""Environment maps: where directions lie, what texels weigh, and lights chosen by importance."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.environment import (
    EnvironmentMap,
    all_lights,
    direction_at,
    important_lights,
    map_coordinates,
    solid_angles,
    texel_directions,
)


@pytest.mark.parametrize(
    ("direction", "u", "v"),
    [((0, 0, 1), 0.5, 0.5), ((1, 0, 0), 0.25, 0.5), ((-1, 0, 0), 0.75, 0.5), ((0, 0, -1), 0.0, 0.5)],
)
def test_layout_is_that_of_openexr(direction, u, v):
    assert map_coordinates(np.array(direction, float)) == pytest.approx((u, v), abs=1e-15)


def test_row_zero_looks_up():
    assert texel_directions(64, 128)[0, :, 1].min() > 0.999


@given(st.floats(0, 0.999), st.floats(0.01, 0.99))
def test_coordinates_and_directions_are_inverse(u, v):
    assert map_coordinates(direction_at(np.array(u), np.array(v))) == pytest.approx((u, v), abs=1e-12)


@pytest.mark.parametrize("size", [(1, 1), (2, 1), (7, 3), (512, 1024)])
def test_solid_angles_sum_to_the_sphere(size):
    assert solid_angles(*size).sum() * size[1] == pytest.approx(4 * np.pi, rel=1e-14)


def test_constant_light_gives_pi_on_a_diffuse_receiver():
    lights = all_lights(EnvironmentMap(np.ones((256, 512, 3), np.float32)))
    irradiance = np.maximum(lights.direction[:, 1:2], 0) * lights.irradiance
    np.testing.assert_allclose(irradiance.sum(axis=0), np.pi, rtol=1e-4)


@pytest.fixture(scope="module")
def sky():
    y = texel_directions(64, 128)
    sun = np.exp(400 * (y @ np.array([0.6, 0.64, 0.48]) - 1))
    return EnvironmentMap(
        np.float32((0.2 + 0.8 * np.clip(y[..., 1:2], 0, 1)) * [0.3, 0.5, 1.0] + 50 * sun[..., None] * [1.0, 0.9, 0.7])
    )


def irradiance(lights, normal):
    return (np.maximum(lights.direction @ normal, 0)[:, None] * lights.irradiance).sum(axis=0)


def test_chosen_lights_carry_the_whole_flux(sky):
    dense = all_lights(sky).irradiance @ [0.2126, 0.7152, 0.0722]
    chosen = important_lights(sky, 64).irradiance @ [0.2126, 0.7152, 0.0722]
    assert chosen.sum() == pytest.approx(dense.sum(), rel=1e-6)


def test_error_falls_with_the_number_of_directions(sky):
    normals = np.array([[0, 1, 0], [0.6, 0.8, 0], [0, 0.28, 0.96], [-0.48, 0.6, 0.64]])
    truth = np.array([irradiance(all_lights(sky), normal) for normal in normals])

    def error(count):
        estimates = [[irradiance(important_lights(sky, count, seed), n) for n in normals] for seed in range(8)]
        return np.sqrt(np.mean((np.array(estimates) / truth - 1) ** 2))

    errors = [error(count) for count in (16, 64, 256, 1024)]
    assert errors[0] > errors[1] > errors[2] > errors[3]
    assert errors[3] < 0.01


def test_the_average_over_seeds_is_the_dense_sum(sky):
    normal = np.array([0.6, 0.8, 0.0])
    estimates = np.array([irradiance(important_lights(sky, 32, seed), normal) for seed in range(200)])
    deviation = estimates.std(axis=0) / np.sqrt(len(estimates))
    assert (np.abs(estimates.mean(axis=0) - irradiance(all_lights(sky), normal)) < 4 * deviation).all()


def test_equal_seeds_give_equal_lights(sky):
    first, second = important_lights(sky, 50, 3), important_lights(sky, 50, 3)
    np.testing.assert_array_equal(first.direction, second.direction)


def test_darkness_gives_dark_lights():
    lights = important_lights(EnvironmentMap(np.zeros((4, 8, 3), np.float32)), 5)
    assert lights.irradiance.sum() == 0
    assert np.isfinite(lights.direction).all()


def test_a_single_bright_texel_is_always_chosen():
    radiance = np.zeros((16, 32, 3), np.float32)
    radiance[5, 7] = 3
    lights = important_lights(EnvironmentMap(radiance), 9)
    u, v = map_coordinates(lights.direction)
    assert ((u * 32).astype(int) == 7).all()
    assert ((v * 16).astype(int) == 5).all()


@pytest.mark.parametrize("value", [np.nan, np.inf, -1.0])
def test_radiance_that_is_none_is_refused(value):
    with pytest.raises(ValueError, match="finite"):
        EnvironmentMap(np.full((2, 4, 3), value, np.float32))
