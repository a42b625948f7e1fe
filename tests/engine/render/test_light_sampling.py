"""Directions towards light: their density is a density and theirs, and the light that they bring is all of it."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from engine.core.colour import luminance
from engine.core.directions import normalize
from engine.light.environment import DistantLights, EnvironmentMap, all_lights, solid_angles, texel_directions
from engine.light.lamps import Lamp
from engine.render.light_sampling import (
    EnvironmentSampler,
    disc_density,
    draw_in_disc,
    environment_sampler,
    in_disc,
)

NORMALS = normalize([(0.0, 1.0, 0.0), (0.0, -1.0, 0.0), (0.3, 0.2, -0.9), (-0.6, 0.1, 0.2)])


def room(height: int, width: int, seed: int = 0) -> EnvironmentMap:
    """Coloured texels of very different radiance, every fourth of them black."""
    random = np.random.default_rng(seed)
    radiance = random.random((height, width, 3)) ** 8 * (random.random((height, width, 1)) > 0.25)
    radiance[height // 2, width // 3] = (300.0, 20.0, 0.0)
    return EnvironmentMap(radiance.astype(np.float32))


def sampler(environment: EnvironmentMap, gain: float = 1.0, rotation: float = 0.0) -> EnvironmentSampler:
    made = environment_sampler(environment, gain, rotation)
    assert made is not None
    return made


def repeat(vector: np.ndarray, count: int) -> np.ndarray:
    return np.tile(vector, (count, 1))


@pytest.mark.parametrize("size", [(1, 1), (2, 1), (1, 7), (33, 65), (70, 31), (64, 128), (128, 300)])
def test_EN10_density_times_solid_angle_is_1(size: tuple[int, int]) -> None:
    made = sampler(room(*size))
    parts = made.tables.radiance.shape[:2]  # small maps are cut into parts of texels
    directions = texel_directions(*parts).reshape(-1, 3)
    areas = np.broadcast_to(solid_angles(*parts), parts).ravel()
    for normal in NORMALS:
        radiance, density = made.look_up(directions, repeat(normal, len(directions)))
        assert np.sum(density * areas) == pytest.approx(1.0, abs=1e-12)
        assert ((density > 0.0) == radiance.any(axis=1)).all()


def test_directions_come_as_often_as_their_density_says() -> None:
    """χ² over texels at the level 0.01, Šidák-corrected for the normals."""
    environment, count = room(32, 70), 400_000
    for number, normal in enumerate(NORMALS):
        u = np.random.default_rng(number).random((count, 2))
        direction, _, _ = sampler(environment).draw(u, repeat(normal, count))
        row = (np.arccos(direction[:, 1]) / np.pi * 32).astype(int)
        column = (np.arctan2(direction[:, 0], -direction[:, 2]) / (2 * np.pi) % 1.0 * 70).astype(int)
        found = np.bincount(row * 70 + column, minlength=32 * 70)
        middles = texel_directions(32, 70).reshape(-1, 3)
        _, density = sampler(environment).look_up(middles, repeat(normal, len(middles)))
        expected = count * density * np.repeat(solid_angles(32, 70).ravel(), 70)
        assert not found[expected == 0.0].any()
        rare = expected < 5.0
        pooled = [np.append(counts[~rare], counts[rare].sum()) for counts in (found, expected)]
        pooled = [counts[pooled[1] > 0.0] for counts in pooled]
        assert stats.chisquare(pooled[0], pooled[1] * count / pooled[1].sum()).pvalue > 1 - 0.99 ** (1 / len(NORMALS))


@pytest.mark.parametrize("normal", NORMALS)
def test_one_texel_is_filled_evenly_once_densities_are_divided_by(normal: np.ndarray) -> None:
    environment, u = EnvironmentMap(np.ones((1, 1, 3), np.float32)), np.random.default_rng(0).random((400_000, 2))
    direction, radiance, density = sampler(environment).draw(u, repeat(normal, len(u)))
    np.testing.assert_allclose(radiance, 1.0)
    moments = np.column_stack([np.ones(len(u)), direction, direction**2]) / density[:, None]
    truth = 4.0 * np.pi * np.array([1.0, 0.0, 0.0, 0.0, 1 / 3, 1 / 3, 1 / 3])
    assert (np.abs(moments.mean(axis=0) - truth) < 4.5 * moments.std(axis=0) / np.sqrt(len(u))).all()


@pytest.mark.parametrize("rotation", [0.0, 0.7, -2.5])
def test_EN11_what_is_drawn_is_the_irradiance_of_the_turned_map(rotation: float) -> None:
    environment, count = room(64, 128), 200_000
    lights = all_lights(environment)
    lights = DistantLights(lights.direction, 2.5 * lights.irradiance).rotate(rotation)
    for normal in NORMALS:
        u = np.random.default_rng(1).random((count, 2))
        drawn = sampler(environment, 2.5, rotation)
        direction, radiance, density = drawn.draw(u, repeat(normal, count))
        found = radiance * (np.maximum(direction @ normal, 0.0) / density)[:, None]
        truth = np.sum(lights.irradiance * np.maximum(lights.direction @ normal, 0.0)[:, None], axis=0)
        deviation = found.std(axis=0) / np.sqrt(count)
        assert (np.abs(found.mean(axis=0) - truth) < 4.5 * deviation + 5e-3 * truth).all()  # cosines at middles
        # diffuse surfaces are what the cells are made for: drawn by radiance alone, this is 0.8 to 1.6
        assert luminance(found).std() < 0.4 * luminance(truth)


def test_looking_up_gives_what_drawing_gave() -> None:
    environment, u = room(50, 90), np.random.default_rng(2).random((20_000, 2))
    normal = normalize(np.random.default_rng(3).normal(size=(len(u), 3)))
    made = sampler(environment, 3.0, 0.4)
    direction, radiance, density = made.draw(u, normal)
    again, density_again = made.look_up(direction, normal)
    same = density == density_again  # on the edge of a texel rounding may take the next
    assert same.mean() > 0.999
    np.testing.assert_array_equal(radiance[same], again[same])
    assert (density > 0.0).all()
    np.testing.assert_allclose(np.linalg.norm(direction, axis=1), 1.0, atol=1e-14)


def test_EN6_one_texel_of_a_million_gets_all_directions() -> None:
    radiance = np.zeros((64, 128, 3), np.float32)
    radiance[20, 31] = 1e6
    u = np.random.default_rng(0).random((5000, 2))
    _, light, density = sampler(EnvironmentMap(radiance)).draw(u, repeat(NORMALS[1], len(u)))
    np.testing.assert_allclose(light, 1e6)
    np.testing.assert_allclose(density, 1.0 / solid_angles(64, 128)[20, 0])


def test_without_light_there_is_no_sampler() -> None:
    assert environment_sampler(EnvironmentMap(np.zeros((4, 8, 3), np.float32)), 1.0, 0.0) is None
    assert environment_sampler(room(4, 8), 0.0, 0.0) is None


@pytest.mark.parametrize("radius", [1e-7, 0.004, 0.3, np.pi / 2])
@pytest.mark.parametrize("axis", [(0.0, 0.0, -1.0), (0.0, 0.0, 1.0), (0.6, -0.64, 0.48)])
def test_discs_are_filled_evenly(radius: float, axis: tuple[float, ...]) -> None:
    u, centre = np.random.default_rng(4).random((100_000, 2)), normalize(axis)
    direction = draw_in_disc(u, centre, radius)
    np.testing.assert_allclose(np.linalg.norm(direction, axis=1), 1.0, atol=1e-14)
    assert in_disc(direction, centre, radius * (1 + 1e-6) + 1e-15).all()
    assert disc_density(radius) * Lamp(axis, (1, 1, 1), radius).solid_angle == pytest.approx(1.0, rel=1e-12)  # type: ignore[arg-type]
    across = direction - centre
    inside = np.mean(np.sum(across**2, axis=1) < 2.0 * np.sin(radius / 2.0) ** 2)  # half the solid angle
    assert inside == pytest.approx(0.5, abs=0.01)
    np.testing.assert_allclose(
        (across - np.outer(across @ centre, centre)).mean(axis=0), 0.0, atol=5 * radius / np.sqrt(len(u))
    )
