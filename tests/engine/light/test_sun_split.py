"""Suns split out of environment maps: found where they are, light kept, nothing else touched."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import pywt
from hypothesis import given, settings
from hypothesis import strategies as st

from engine.core.directions import dot, normalize
from engine.light.cube_map import cube_of, cube_solid_angles
from engine.light.environment import EnvironmentMap, solid_angles, texel_directions
from engine.light.environment_file import open_environment, read_environment
from engine.light.lamps import Lamp
from engine.light.sun_split import LARGEST, MAX_SUNS, split_sun


def sky(height: int = 64, width: int = 128) -> np.ndarray:
    """A sky of mean 1.1, brighter above, with some texture."""
    y = texel_directions(height, width)[..., 1:2]
    grain = np.random.default_rng(0).uniform(0.9, 1.1, (height, width, 1))
    return ((1.1 + 0.5 * y) * grain * (0.9, 1.0, 1.2)).astype(np.float32)


def light(environment: EnvironmentMap) -> np.ndarray:
    area = solid_angles(*environment.radiance.shape[:2])[..., None]
    return (environment.radiance.astype(np.float64) * area).sum(axis=(0, 1))


def light_of_both(environment: EnvironmentMap, lamps: tuple[Lamp, ...]) -> np.ndarray:
    return light(environment) + sum((np.array(lamp.flux) for lamp in lamps), np.zeros(3))


@settings(max_examples=20)
@given(st.integers(0, 63), st.integers(0, 127), st.floats(2e3, 1e6))
def test_a_sun_of_one_texel_becomes_a_lamp_where_it_was(row: Any, column: Any, sun: Any) -> None:
    radiance = sky()
    before = radiance[row, column].copy()
    area = solid_angles(64, 128)[row, 0]
    radiance[row, column] = sun / area * 0.005 * np.array((1.0, 0.9, 0.7))  # as bright at the poles as elsewhere
    rest, lamps = split_sun(EnvironmentMap(radiance))
    (lamp,) = lamps
    assert dot(lamp.direction, texel_directions(64, 128)[row, column]) == pytest.approx(1.0, abs=1e-12)
    assert lamp.solid_angle == pytest.approx(area, rel=1e-6)
    np.testing.assert_allclose(rest.radiance[row, column], before, rtol=0.5)
    np.testing.assert_allclose(light_of_both(rest, lamps), light(EnvironmentMap(radiance)), rtol=1e-6)
    others = np.ones((64, 128), bool)
    others[row, column] = False
    np.testing.assert_array_equal(rest.radiance[others], radiance[others])


def test_a_disc_with_a_glow_keeps_its_size_and_place() -> None:
    towards = normalize((0.4, 0.5, -0.7))
    angle = np.arccos(np.clip(dot(texel_directions(512, 1024), towards), -1, 1))[..., None]
    radiance = sky(512, 1024) + 2e4 * (angle < math.radians(1.0)) + 60.0 * np.exp(-((angle / 0.03) ** 2))
    rest, (lamp,) = split_sun(EnvironmentMap(radiance.astype(np.float32)))
    assert math.degrees(lamp.radius) == pytest.approx(1.0, abs=0.05)
    assert math.degrees(math.acos(dot(lamp.direction, towards))) < 0.1
    assert rest.radiance.max() < 70.0
    np.testing.assert_allclose(light_of_both(rest, (lamp,)), light(EnvironmentMap(radiance.astype("f4"))), rtol=1e-6)


def test_a_sun_on_the_seam_is_one_sun() -> None:
    radiance = sky()
    radiance[20, [127, 0]] = 1e5
    _, (lamp,) = split_sun(EnvironmentMap(radiance))
    polar = math.pi * 20.5 / 64
    np.testing.assert_allclose(lamp.direction, (0.0, math.cos(polar), -math.sin(polar)), atol=1e-3)


def test_two_suns_are_two_lamps_brightest_first() -> None:
    radiance = sky()
    radiance[10, 10], radiance[40, 90] = 2e4, 9e4
    _, lamps = split_sun(EnvironmentMap(radiance))
    assert [lamp.direction[1] > 0 for lamp in lamps] == [False, True]


def test_T3_without_a_sun_nothing_is_split() -> None:
    area = sky()
    area[20:40, 30:60] = 500.0  # a softbox
    ramp = sky() * np.linspace(1.0, 300.0, 128)[None, :, None].astype(np.float32)
    for radiance in (sky(), area, ramp, np.zeros((4, 8, 3), np.float32), np.ones((1, 1, 3), np.float32)):
        environment = EnvironmentMap(radiance)
        rest, lamps = split_sun(environment)
        assert rest is environment
        assert lamps == ()


def test_T3_strip_lights_stay_however_narrow() -> None:
    radiance = sky(256, 512)
    radiance[100, 100:160] = 4e4
    assert split_sun(EnvironmentMap(radiance))[1] == ()


@pytest.mark.parametrize("width", [0.06, 0.2])
def test_T3_the_middle_of_a_soft_lamp_is_no_sun(width: float) -> None:
    """Half the light of the narrower one is within 3 degrees, but what is around it is not much darker."""
    angle = np.arccos(np.clip(dot(texel_directions(256, 512), normalize((1, 1, 0))), -1, 1))[..., None]
    radiance = (0.1 + 1e4 * np.exp(-((angle / width) ** 2)) + np.zeros(3)).astype(np.float32)
    assert split_sun(EnvironmentMap(radiance))[1] == ()


def test_T3_built_in_studios_have_no_sun() -> None:
    assert split_sun(open_environment("studio"))[1] == ()


@pytest.mark.parametrize("sun", [0.0, 1.0, 1e2, 1e3, 1e4, 1e5, 1e6])
def test_X6_Z14_the_sky_survives_quantisation_under_any_sun(sun: float) -> None:
    """Haar wavelets, one scale for all in 16 bits, what is below 1024 dropped; the mean of a face is always kept."""
    radiance = np.full((128, 256, 3), 1.1, np.float32)
    plain = cube_of(EnvironmentMap(radiance.copy()), 64).radiance[..., 1]
    radiance[37, 101] += sun
    rest, lamps = split_sun(EnvironmentMap(radiance))
    assert len(lamps) == (sun > 1e3)
    faces = cube_of(rest, 64).radiance[..., 1].astype(np.float64)
    coefficients = [pywt.coeffs_to_array(pywt.wavedec2(face, "haar")) for face in faces]
    scale = 32767 / max(np.abs(array).max() for array, _ in coefficients)
    area = cube_solid_angles(64)
    sunny = np.abs(faces - plain) > 0.5  # where a sun is left
    kept = 0.0
    for face, (array, slices) in enumerate(coefficients):
        codes = np.rint(array * scale)
        quantised = np.where(np.abs(codes) >= 1024, codes / scale, 0.0)
        quantised[0, 0] = array[0, 0]
        pieces = pywt.array_to_coeffs(quantised, slices, output_format="wavedec2")
        kept += ((pywt.waverec2(pieces, "haar") - np.where(sunny[face], faces[face] - plain[face], 0.0)) * area).sum()
    assert kept == pytest.approx((plain * area).sum(), rel=0.01)


def test_most_lamps_are_bounded() -> None:
    radiance = sky()
    radiance[10:60:5, 0:120:10] = 1e3
    radiance[5:60:25, 3:120:30] = 2e5
    rest, lamps = split_sun(EnvironmentMap(radiance))
    assert len(lamps) <= MAX_SUNS
    np.testing.assert_allclose(light_of_both(rest, lamps), light(EnvironmentMap(radiance)), rtol=1e-6)


def test_suns_of_coarse_maps_are_found() -> None:
    radiance = np.ones((16, 32, 3), np.float32)
    radiance[4, 9] = 1e4
    _, (lamp,) = split_sun(EnvironmentMap(radiance))
    assert lamp.radius > LARGEST  # one texel of the map is so large


@pytest.mark.parametrize(
    ("name", "suns"),
    [
        ("openexr/KernerEnvLatLong.exr", 1),
        ("debevec/stpeters_probe_latlong.hdr", 1),
        ("debevec/grace_probe_latlong.hdr", 0),
        ("studio_small_03_1k.hdr", 1),  # a round spotlight of 2.2 degrees with 46 % of all light
        ("pmndrs_cc0/studio.exr", 1),  # the same, smaller
        ("pmndrs_cc0/city.exr", 0),
        ("pmndrs_cc0/forest.exr", 0),
    ],
)
def test_suns_of_real_maps(shared_data: Callable[[str], Path], name: str, suns: int) -> None:
    environment = read_environment(shared_data(f"hdr/{name}"))
    rest, lamps = split_sun(environment)
    assert len(lamps) == suns
    np.testing.assert_allclose(light_of_both(rest, lamps), light(environment), rtol=1e-6)
