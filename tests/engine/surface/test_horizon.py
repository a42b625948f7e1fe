"""Occlusion of a lamp and of the sky by relief, against closed forms."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad

from engine.core.steps import drain
from engine.simulate.shading import light_direction
from engine.surface import horizon as shadows


def wall(size: int = 200, height: float = 10.0, column: int = 100) -> Any:
    field = np.zeros((size, size), np.float32)
    field[:, column] = height
    return field


@pytest.mark.parametrize("elevation_deg", [10, 20, 44])
@pytest.mark.parametrize(("azimuth", "away"), [(0.0, -1), (math.pi, +1)])
def test_shadow_of_a_wall_is_its_height_over_the_tangent(elevation_deg: int, azimuth: float, away: int) -> None:
    tangent = math.tan(math.radians(elevation_deg))
    horizon = shadows.horizon_slope(wall(), azimuth, math.radians(5))
    dark = shadows.visibility(horizon, math.radians(elevation_deg), 0.0)[50] == 0
    columns = 100 + away * np.arange(1, 60)
    assert np.array_equal(dark[columns], 10.0 / np.arange(1, 60) > tangent)
    assert not dark[100 - away * np.arange(60)].any()


@pytest.mark.parametrize("azimuth_deg", [90, 270])
def test_rows_and_columns_cast_alike(azimuth_deg: int) -> None:
    sideways = shadows.horizon_slope(wall(), math.radians(azimuth_deg - 90), 0.1)
    upwards = shadows.horizon_slope(np.ascontiguousarray(np.rot90(wall())), math.radians(azimuth_deg), 0.1)
    np.testing.assert_allclose(upwards, np.rot90(sideways), atol=1e-6)


@pytest.mark.parametrize("azimuth_deg", [0, 20, 45, 77, 130, 290])
def test_horizon_of_a_sine_is_what_a_brute_force_search_finds(azimuth_deg: int) -> None:
    """A ridge seen at an angle is further away by 1/cos: the horizon's slope is that of the profile along the ray."""
    azimuth, period, amplitude = math.radians(azimuth_deg), 64, 6.0
    column = np.arange(128)
    height = np.tile(amplitude * np.cos(2 * np.pi * column / period), (128, 1)).astype(np.float32)
    found = shadows.horizon_slope(height, azimuth, 0.05)[40]
    distance = np.linspace(0.5, 400, 8000)
    ray = amplitude * np.cos(2 * np.pi * (column[:, None] + distance * math.cos(azimuth)) / period)
    true = np.maximum(((ray - height[40][:, None]) / distance).max(axis=1), 0)
    np.testing.assert_allclose(found, true, atol=0.015)


def test_horizon_reaches_through_the_border_of_the_tile() -> None:
    field = wall(column=2)
    horizon = shadows.horizon_slope(field, 0.0, 0.02)
    assert horizon[0, 150] == pytest.approx(10 / 52)


def test_lamp_disc_fades_as_the_area_of_a_circle_above_a_chord() -> None:
    radius, elevation = math.radians(2), math.radians(30)
    for above in (-1.0, -0.6, 0.0, 0.25, 1.0):
        horizon = np.full((1, 1), math.tan(elevation - above * radius), np.float32)
        area = quad(lambda u: 2 * math.sqrt(1 - u * u), -above, 1)[0] / math.pi
        assert shadows.visibility(horizon, elevation, radius)[0, 0] == pytest.approx(area, abs=2e-5)


def test_openness_of_a_trench_is_that_of_its_walls() -> None:
    """Bottom centre of a long trench: the configuration factor of the sky is sin of the wall's complement angle.

    Along the azimuth a the walls stand at w / |cos a|, so the mean of cos^2 over azimuths is what is compared.
    """
    height = np.zeros((64, 64), np.float32)
    height[:, 20:44] = -12.0
    angles = 2 * np.pi * np.arange(16) / 16
    slope = np.abs(np.cos(angles)) * 12 / 12.0
    expected = np.mean(1 / (1 + slope**2))
    found = drain(shadows.openness(height, azimuths=16, lowest=0.02))[30, 31:33].mean()
    assert found == pytest.approx(expected, rel=0.06)


def test_lowest_elevation_must_be_above_the_horizon() -> None:
    with pytest.raises(ValueError, match="lowest elevation"):
        shadows.horizon_slope(wall(), 0.0, 0.0)


def test_openness_of_a_flat_field_is_one() -> None:
    assert (drain(shadows.openness(np.full((32, 32), 3.0, np.float32))) == 1).all()


@pytest.mark.parametrize("azimuth_deg", [0, 90, 180, 250])
def test_lamp_very_far_away_is_a_distant_lamp(azimuth_deg: int) -> None:
    """Smooth relief, because the sweep joins lines and the walk reads between texels: they differ by O(1 / size)."""
    azimuth, elevation, radius = math.radians(azimuth_deg), math.radians(25), math.radians(5)
    row, column = np.mgrid[0:160, 0:160] * 2 * np.pi / 160
    relief = (20 * np.sin(column) * np.cos(row)).astype(np.float32)
    lamp = 1e6 * light_direction(elevation, azimuth)
    near = shadows.near_visibility(relief, lamp, radius, slice(None))
    far = shadows.visibility(shadows.horizon_slope(relief, azimuth, elevation - radius), elevation, radius)
    assert near.min() < 0.1 < 0.9 < near.max()
    np.testing.assert_allclose(near, far, atol=0.035)


def test_near_lamp_casts_the_shadow_of_a_wall_to_where_the_line_over_its_crest_ends() -> None:
    """The lamp stands 40 texels to the right of the wall, 30 high: the crest at 10 hides the 20 texels behind it."""
    relief = wall()
    visible = shadows.near_visibility(relief, np.array([40.5, 0.0, 30.0]), 0.0, slice(100, 101))[0]
    behind = 100 - np.arange(1, 60)
    assert np.array_equal(visible[behind] == 0, 10.0 / np.arange(1, 60) > 30.0 / (40 + np.arange(1, 60)))
    assert (visible[101:140] == 1).all()


def test_rows_of_a_near_lamp_can_be_asked_for_in_parts() -> None:
    relief = np.random.default_rng(2).random((40, 40), np.float32)
    lamp = np.array([30.0, 20.0, 9.0])
    whole = shadows.near_visibility(relief, lamp, 0.1, slice(None))
    parts = [shadows.near_visibility(relief, lamp, 0.1, slice(first, first + 17)) for first in (0, 17, 34)]
    assert np.array_equal(np.concatenate(parts), whole)
