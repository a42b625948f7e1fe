"""The virtual light arc against closed forms."""

from __future__ import annotations

import math

import numba
import numpy as np
import pytest
from scipy.integrate import quad

from engine.render import light_arc
from engine.render.height_fields import Sample, sample


def surface(height, albedo=0.5, specular=0.0, roughness=1.0):
    height = np.asarray(height, np.float32)
    colour = np.ones((*height.shape, 3), np.float32)
    return Sample(height, colour * np.float32(albedo), colour * np.float32(specular), np.full_like(height, roughness))


def lit(field, elevation, azimuth=0.0, radius=0.0):
    horizon = light_arc.horizon_slope(field.height, azimuth, 0.5 * elevation)
    visible = light_arc.visibility(horizon, elevation, radius)
    slope = light_arc.surface_slope(field.height)
    return light_arc.radiance(field, slope, visible, light_arc.light_direction(elevation, azimuth))


def wall(size=200, height=10.0, column=100):
    field = np.zeros((size, size), np.float32)
    field[:, column] = height
    return field


@pytest.mark.parametrize("elevation_deg", [1, 5, 30, 45, 89, 90])
@pytest.mark.parametrize("azimuth_deg", [0, 33, 90, 200])
def test_flat_diffuse_sample_is_proportional_to_the_sine_of_elevation(elevation_deg, azimuth_deg):
    elevation = math.radians(elevation_deg)
    image = lit(sample("plain", 16), elevation, math.radians(azimuth_deg))
    np.testing.assert_allclose(image, 0.5 * math.sin(elevation) / math.pi, rtol=2e-7)


@pytest.mark.parametrize("elevation_deg", [10, 20, 44])
@pytest.mark.parametrize(("azimuth", "away"), [(0.0, -1), (math.pi, +1)])
def test_shadow_of_a_wall_is_its_height_over_the_tangent(elevation_deg, azimuth, away):
    tangent = math.tan(math.radians(elevation_deg))
    horizon = light_arc.horizon_slope(wall(), azimuth, math.radians(5))
    dark = light_arc.visibility(horizon, math.radians(elevation_deg), 0.0)[50] == 0
    columns = 100 + away * np.arange(1, 60)
    assert np.array_equal(dark[columns], 10.0 / np.arange(1, 60) > tangent)
    assert not dark[100 - away * np.arange(60)].any()


@pytest.mark.parametrize("azimuth_deg", [90, 270])
def test_rows_and_columns_cast_alike(azimuth_deg):
    sideways = light_arc.horizon_slope(wall(), math.radians(azimuth_deg - 90), 0.1)
    upwards = light_arc.horizon_slope(np.ascontiguousarray(np.rot90(wall())), math.radians(azimuth_deg), 0.1)
    np.testing.assert_allclose(upwards, np.rot90(sideways), atol=1e-6)


@pytest.mark.parametrize("azimuth_deg", [0, 20, 45, 77, 130, 290])
def test_horizon_of_a_sine_is_what_a_brute_force_search_finds(azimuth_deg):
    """A ridge seen at an angle is further away by 1/cos: the horizon's slope is that of the profile along the ray."""
    azimuth, period, amplitude = math.radians(azimuth_deg), 64, 6.0
    column = np.arange(128)
    height = np.tile(amplitude * np.cos(2 * np.pi * column / period), (128, 1)).astype(np.float32)
    found = light_arc.horizon_slope(height, azimuth, 0.05)[40]
    distance = np.linspace(0.5, 400, 8000)
    ray = amplitude * np.cos(2 * np.pi * (column[:, None] + distance * math.cos(azimuth)) / period)
    true = np.maximum(((ray - height[40][:, None]) / distance).max(axis=1), 0)
    np.testing.assert_allclose(found, true, atol=0.015)


def test_horizon_reaches_through_the_border_of_the_tile():
    field = wall(column=2)
    horizon = light_arc.horizon_slope(field, 0.0, 0.02)
    assert horizon[0, 150] == pytest.approx(10 / 52)


def test_lamp_disc_fades_as_the_area_of_a_circle_above_a_chord():
    radius, elevation = math.radians(2), math.radians(30)
    for above in (-1.0, -0.6, 0.0, 0.25, 1.0):
        horizon = np.full((1, 1), math.tan(elevation - above * radius), np.float32)
        area = quad(lambda u: 2 * math.sqrt(1 - u * u), -above, 1)[0] / math.pi
        assert light_arc.visibility(horizon, elevation, radius)[0, 0] == pytest.approx(area, abs=2e-5)


@pytest.mark.parametrize("tilt_deg", [-20, 5, 25])
def test_mean_over_a_tilted_plane(tilt_deg):
    """A facet tilted by t towards the lamp is lit as a flat one whose lamp is t higher, and 1/cos is not seen."""
    tilt, elevation = math.radians(tilt_deg), math.radians(50)
    height = np.tile(-np.tan(tilt) * np.arange(64), (64, 1))
    field = surface(height)
    slope = light_arc.surface_slope(field.height)[:, 1:-1]
    inner = Sample(
        *(np.ascontiguousarray(m[:, 1:-1]) for m in (field.height, field.albedo, field.specular)),
        np.ascontiguousarray(field.roughness[:, 1:-1]),
    )
    open_ = np.ones(inner.height.shape, np.float32)
    image = light_arc.radiance(inner, np.ascontiguousarray(slope), open_, light_arc.light_direction(elevation, 0.0))
    assert image.mean(dtype=float) == pytest.approx(0.5 / math.pi * math.sin(elevation + tilt), rel=1e-5)


def test_light_from_behind_leaves_a_slope_black():
    """Row 0 is on top and azimuth 90 degrees is up the image: a slope that falls upwards looks at that lamp."""
    height = np.tile(np.arange(32.0)[:, None], (1, 32))
    slope = light_arc.surface_slope(height.astype(np.float32))
    assert (slope[1:-1, :, 1] == -1).all()
    ones = np.ones((32, 32), np.float32)
    towards, behind = (
        light_arc.radiance(surface(height), slope, ones, light_arc.light_direction(math.radians(30), azimuth))
        for azimuth in (math.pi / 2, -math.pi / 2)
    )
    assert (towards[1:-1] > 0).all()
    assert (behind[1:-1] == 0).all()


@pytest.mark.parametrize(("roughness", "share"), [(0.1, 0.99), (1.0, 1 - math.log(2))])
def test_lobe_reflects_what_a_white_furnace_allows(roughness, share):
    """By reciprocity all light from a full sky of one: nearly all for a mirror, 1 - ln 2 for alpha = 1, never more."""
    field = surface(np.zeros((1, 1)), 0.0, 1.0, roughness)
    slope, ones = light_arc.surface_slope(field.height), np.ones((1, 1), np.float32)
    elevation = (np.arange(2000) + 0.5) / 2000 * np.pi / 2
    ring = [
        math.cos(e) * light_arc.radiance(field, slope, ones, light_arc.light_direction(e, 0.0))[0, 0, 0]
        for e in elevation
    ]
    assert 2 * np.pi * math.fsum(ring) * (np.pi / 2 / 2000) == pytest.approx(share, abs=0.006)


def test_lobe_peaks_where_the_mirror_sees_the_lamp():
    """A facet tilted by 20 degrees mirrors a lamp 40 degrees off the zenith into the camera."""
    tilts = np.radians(np.arange(-60, 61))
    slope = np.zeros((1, len(tilts), 2), np.float32)
    slope[0, :, 0] = -np.tan(tilts)
    field = surface(np.zeros((1, len(tilts))), 0.0, 0.5, 0.1)
    ones = np.ones(field.height.shape, np.float32)
    image = light_arc.radiance(field, slope, ones, light_arc.light_direction(math.radians(50), 0.0))
    assert np.degrees(tilts[image[0, :, 0].argmax()]) == pytest.approx(20, abs=2)


def test_openness_of_a_flat_field_is_one_and_nothing_bounces():
    field = sample("plain", 32)
    open_part = light_arc.openness(field.height)
    assert (open_part == 1).all()
    direct = np.full((32, 32, 3), 0.3, np.float32)
    assert (light_arc.bounce(direct, field.albedo, open_part, 2.0) == 0).all()


def test_hidden_part_of_the_sky_shines_like_its_surroundings():
    """An evenly lit neighbourhood of radiance L fills the hidden part of the hemisphere: rho (1 - open) L."""
    direct = np.full((24, 24, 3), 0.3, np.float32)
    albedo = np.full((24, 24, 3), 0.8, np.float32)
    open_part = np.full((24, 24), 0.6, np.float32)
    np.testing.assert_allclose(light_arc.bounce(direct, albedo, open_part, 3.0), 0.8 * 0.4 * 0.3, rtol=1e-5)


def test_openness_of_a_trench_is_that_of_its_walls():
    """Bottom centre of a long trench: the configuration factor of the sky is sin of the wall's complement angle.

    Along the azimuth a the walls stand at w / |cos a|, so the mean of cos^2 over azimuths is what is compared.
    """
    height = np.zeros((64, 64), np.float32)
    height[:, 20:44] = -12.0
    angles = 2 * np.pi * np.arange(16) / 16
    slope = np.abs(np.cos(angles)) * 12 / 12.0
    expected = np.mean(1 / (1 + slope**2))
    found = light_arc.openness(height, azimuths=16, lowest=0.02)[30, 31:33].mean()
    assert found == pytest.approx(expected, rel=0.06)


def test_result_does_not_depend_on_the_number_of_threads():
    field = sample("woven", 96)
    threads = numba.get_num_threads()
    images = []
    try:
        for count in {1, threads}:
            numba.set_num_threads(count)
            images.append(lit(field, math.radians(20), 0.4, 0.02))
    finally:
        numba.set_num_threads(threads)
    assert np.array_equal(images[0], images[-1])


def test_lowest_elevation_must_be_above_the_horizon():
    with pytest.raises(ValueError, match="lowest elevation"):
        light_arc.horizon_slope(wall(), 0.0, 0.0)
