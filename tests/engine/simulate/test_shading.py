"""The virtual light arc against closed forms."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from engine.simulate import shading
from engine.simulate.height_fields import Sample, sample
from engine.surface import horizon as shadows
from tests.threads import threads


def surface(height: Any, albedo: float = 0.5, specular: float = 0.0, roughness: float = 1.0) -> Sample:
    height = np.asarray(height, np.float32)
    colour = np.ones((*height.shape, 3), np.float32)
    return Sample(height, colour * np.float32(albedo), colour * np.float32(specular), np.full_like(height, roughness))


def light_up(field: Any, elevation: Any, azimuth: float = 0.0, radius: float = 0.0) -> Any:
    horizon = shadows.horizon_slope(field.height, azimuth, 0.5 * elevation)
    visible = shadows.visibility(horizon, elevation, radius)
    slope = shading.surface_slope(field.height)
    return shading.radiance(field, slope, visible, shading.light_direction(elevation, azimuth))


@pytest.mark.parametrize("elevation_deg", [1, 5, 30, 45, 89, 90])
@pytest.mark.parametrize("azimuth_deg", [0, 33, 90, 200])
def test_flat_diffuse_sample_is_proportional_to_the_sine_of_elevation(elevation_deg: int, azimuth_deg: int) -> None:
    elevation = math.radians(elevation_deg)
    image = light_up(sample("plain", 16), elevation, math.radians(azimuth_deg))
    np.testing.assert_allclose(image, 0.5 * math.sin(elevation) / math.pi, rtol=2e-7)


@pytest.mark.parametrize("tilt_deg", [-20, 5, 25])
def test_mean_over_a_tilted_plane(tilt_deg: int) -> None:
    """A facet tilted by t towards the lamp is lit as a flat one whose lamp is t higher, and 1/cos is not seen."""
    tilt, elevation = math.radians(tilt_deg), math.radians(50)
    height = np.tile(-np.tan(tilt) * np.arange(64), (64, 1))
    field = surface(height)
    slope = shading.surface_slope(field.height)[:, 1:-1]
    maps = (field.height, field.albedo, field.specular, field.roughness)
    inner = Sample(*(np.ascontiguousarray(one[:, 1:-1]) for one in maps))
    open_ = np.ones(inner.height.shape, np.float32)
    image = shading.radiance(inner, np.ascontiguousarray(slope), open_, shading.light_direction(elevation, 0.0))
    assert image.mean(dtype=float) == pytest.approx(0.5 / math.pi * math.sin(elevation + tilt), rel=1e-5)


def test_light_from_behind_leaves_a_slope_black() -> None:
    """Row 0 is on top and azimuth 90 degrees is up the image: a slope that falls upwards looks at that lamp."""
    height = np.tile(np.arange(32.0)[:, None], (1, 32))
    slope = shading.surface_slope(height.astype(np.float32))
    assert (slope[1:-1, :, 1] == -1).all()
    ones = np.ones((32, 32), np.float32)
    towards, behind = (
        shading.radiance(surface(height), slope, ones, shading.light_direction(math.radians(30), azimuth))
        for azimuth in (math.pi / 2, -math.pi / 2)
    )
    assert (towards[1:-1] > 0).all()
    assert (behind[1:-1] == 0).all()


@pytest.mark.parametrize(("roughness", "share"), [(0.1, 0.99), (1.0, 1 - math.log(2))])
def test_lobe_reflects_what_a_white_furnace_allows(roughness: float, share: Any) -> None:
    """By reciprocity all light from a full sky of one: nearly all for a mirror, 1 - ln 2 for alpha = 1, never more."""
    field = surface(np.zeros((1, 1)), 0.0, 1.0, roughness)
    slope, ones = shading.surface_slope(field.height), np.ones((1, 1), np.float32)
    elevation = (np.arange(2000) + 0.5) / 2000 * np.pi / 2
    ring = [
        math.cos(e) * shading.radiance(field, slope, ones, shading.light_direction(e, 0.0))[0, 0, 0] for e in elevation
    ]
    assert 2 * np.pi * math.fsum(ring) * (np.pi / 2 / 2000) == pytest.approx(share, abs=0.006)


def test_lobe_peaks_where_the_mirror_sees_the_lamp() -> None:
    """A facet tilted by 20 degrees mirrors a lamp 40 degrees off the zenith into the camera."""
    tilts = np.radians(np.arange(-60, 61))
    slope = np.zeros((1, len(tilts), 2), np.float32)
    slope[0, :, 0] = -np.tan(tilts)
    field = surface(np.zeros((1, len(tilts))), 0.0, 0.5, 0.1)
    ones = np.ones(field.height.shape, np.float32)
    image = shading.radiance(field, slope, ones, shading.light_direction(math.radians(50), 0.0))
    assert np.degrees(tilts[image[0, :, 0].argmax()]) == pytest.approx(20, abs=2)


def bounce(direct: Any, albedo: Any, open_part: Any) -> Any:
    shape = (24, 24)
    light, colour = (np.full((*shape, 3), value, np.float32) for value in (direct, albedo))
    return shading.add_interreflection(light, colour, np.full(shape, open_part, np.float32), 3.0)


def test_nothing_bounces_off_a_flat_field() -> None:
    assert (bounce(0.3, 0.9, 1.0) == np.float32(0.3)).all()


@pytest.mark.parametrize(("albedo", "open_part"), [(0.8, 0.6), (0.3, 0.9), (1.0, 0.5)])
def test_bounces_in_an_even_light_are_a_geometric_series(albedo: float, open_part: float) -> None:
    """The hidden part of the hemisphere shines like its surroundings: g = rho (1 - open) of the light comes back."""
    returned = albedo * (1 - open_part)
    series = sum(returned**bounce for bounce in range(shading.BOUNCES + 1))
    light = bounce(0.3, albedo, open_part)
    np.testing.assert_allclose(light, 0.3 * series, rtol=1e-5)
    assert light.max() < 0.3 / (1 - returned) * (1 + 1e-6)


def test_light_bounces_into_a_dark_texel_from_its_neighbours() -> None:
    direct = np.full((32, 32, 3), 0.3, np.float32)
    direct[16, 16] = 0.0
    ones = np.ones((32, 32), np.float32)
    light = shading.add_interreflection(
        direct, ones[..., None] * np.array([0.5, 0.5, 0.5], np.float32), 0.8 * ones, 8.0
    )
    assert light[16, 16, 0] == pytest.approx(0.3 * 0.1 / 0.9, rel=0.02)


@pytest.mark.parametrize(("elevation_deg", "azimuth_deg"), [(90, 0), (40, 0), (10, 70)])
def test_near_lamp_lights_a_card_by_its_distance_and_its_angle(elevation_deg: int, azimuth_deg: int) -> None:
    """Irradiance of a plane by a point: cos(theta) / |v|^2 = z / |v|^3, one on what faces it in the middle."""
    elevation, azimuth, distance = math.radians(elevation_deg), math.radians(azimuth_deg), 60.0
    field = sample("plain", 40)
    slope, ones = shading.surface_slope(field.height), np.ones((40, 40), np.float32)
    direction = shading.light_direction(elevation, azimuth)
    image = shading.radiance(field, slope, ones, direction, 1 / distance)
    column, row = np.meshgrid(np.arange(40) + 0.5, np.arange(40) + 0.5)
    x, y, z = (distance * axis for axis in direction)
    squared = (x - (column - 20)) ** 2 + (y - (20 - row)) ** 2 + z * z
    expected = 0.5 / math.pi * z / squared**1.5 * distance**2
    np.testing.assert_allclose(image[..., 1], expected, rtol=1e-6)


def test_result_does_not_depend_on_the_number_of_threads() -> None:
    field = sample("woven", 96)
    images = []
    for count in (1, 2):
        with threads(count):
            images.append(light_up(field, math.radians(20), 0.4, 0.02))
    assert np.array_equal(*images)
