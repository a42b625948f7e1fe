"""Built-in skies and studios: published formulas against their own statements, and maps that light can be."""

from __future__ import annotations

import math

import numpy as np
import pytest

from engine.core.colour import luminance, xyz_from_srgb
from engine.core.directions import normalize, world_angles, world_direction
from engine.core.errors import InputError
from engine.light.environment import EnvironmentMap, solid_angles, texel_directions
from engine.light.environment_file import open_environment
from engine.light.sky import SKIES, SUN_ABOVE_THE_AIR, clear_sky, make_built_in, overcast, preetham, sun_irradiance
from engine.light.sun_split import split_sun

UP = np.array([0.0, 1.0, 0.0])


def irradiance(environment: EnvironmentMap, normal: np.ndarray) -> np.ndarray:
    height, width = environment.radiance.shape[:2]
    cosine = np.maximum(texel_directions(height, width) @ normal, 0)[..., None]
    return (environment.radiance * solid_angles(height, width)[..., None] * cosine).sum(axis=(0, 1), dtype=np.float64)


@pytest.mark.parametrize("name", SKIES)
def test_every_built_in_map_is_light(name: str) -> None:
    environment = open_environment(name)
    height, width = environment.radiance.shape[:2]
    assert width == 2 * height >= 256
    assert environment.name == name
    assert SKIES[name].label[0].isupper()
    assert environment.radiance.min() >= 0.01  # no room is quite black
    assert 0.1 < luminance(irradiance(environment, normalize((0, 1, 1)))) < 30.0


@pytest.mark.parametrize(
    ("name", "lamps"),
    [
        ("studio", [(-0.6, 0.65, 0.55), (0.9, 0.2, 0.45), (0.35, 0.5, -0.85)]),
        ("softboxes", [(-0.75, 0.55, 0.75), (0.95, 0.15, 0.6), (0.6, 0.6, -0.9)]),
    ],
)
def test_lamps_of_rooms_stand_where_they_are_said_to(name: str, lamps: list[tuple[float, float, float]]) -> None:
    """The middle of all light above that of the room, near each lamp, is the direction of that lamp."""
    environment = open_environment(name)
    height, width = environment.radiance.shape[:2]
    directions, radiance = texel_directions(height, width), luminance(environment.radiance)
    bright = np.where(radiance > 3.0 * np.median(radiance), radiance, 0.0) * solid_angles(height, width)
    for towards in map(normalize, lamps):
        near = bright * (directions @ towards > math.cos(math.radians(40)))
        assert normalize((directions * near[..., None]).sum(axis=(0, 1))) @ towards > math.cos(math.radians(3))


def test_unknown_names_list_the_known_ones() -> None:
    with pytest.raises(InputError, match="overcast"):
        open_environment("midnight")
    with pytest.raises(KeyError):
        make_built_in("midnight")


@pytest.mark.parametrize(("elevation_deg", "turbidity"), [(60.0, 2.5), (30.0, 3.0), (10.0, 4.0), (2.0, 6.0)])
def test_the_zenith_of_a_clear_sky_is_preethams(elevation_deg: float, turbidity: float) -> None:
    """Perez's form is relative to the zenith, whose luminance the paper gives by itself."""
    angle = math.radians(90 - elevation_deg)
    chi = (4 / 9 - turbidity / 120) * (math.pi - 2 * angle)
    expected = (4.0453 * turbidity - 4.9710) * math.tan(chi) - 0.2155 * turbidity + 2.4192
    value = preetham(UP, world_direction(angle, 0.7), turbidity)
    assert luminance(value) == pytest.approx(expected, rel=1e-3)


def test_a_clear_sky_between_zenith_and_sun_is_preethams() -> None:
    """The paper's tables worked out by hand for turbidity 3; sun at 40°, view at 70° from the zenith, both at phi 0."""
    sun, view = math.radians(40), math.radians(70)
    tables = {
        "Y": (-0.9269, -0.6387, 5.2570, -2.2153, 0.1693),
        "x": (-0.3171, -0.1987, 0.2113, -1.0912, 0.0353),
        "y": (-0.3109, -0.2758, 0.1865, -1.7860, 0.0202),
    }
    ratio = {}
    for name, (a, b, c, d, e) in tables.items():
        gamma = view - sun
        here = (1 + a * math.exp(b / math.cos(view))) * (1 + c * math.exp(d * gamma) + e * math.cos(gamma) ** 2)
        ratio[name] = here / ((1 + a * math.exp(b)) * (1 + c * math.exp(d * sun) + e * math.cos(sun) ** 2))
    up, value = (preetham(direction, world_direction(sun, 0.0), 3.0) for direction in (UP, world_direction(view, 0.0)))
    (x0, y0), (x, y) = (xyz[:2] / xyz.sum() for xyz in (xyz_from_srgb(up), xyz_from_srgb(value)))
    assert luminance(value) / luminance(up) == pytest.approx(ratio["Y"], rel=1e-6)
    assert (x / x0, y / y0) == pytest.approx((ratio["x"], ratio["y"]), rel=1e-6)


def test_a_clear_sky_is_symmetric_about_the_sun_and_bluest_away_from_it() -> None:
    towards = world_direction(math.radians(60), 0.0)
    left, right = (preetham(world_direction(1.0, phi), towards, 2.5) for phi in (-1.2, 1.2))
    np.testing.assert_allclose(left, right, rtol=1e-12)
    opposite, near = (preetham(world_direction(math.radians(t), 0.0), towards, 2.5) for t in (-30, 55))
    assert opposite[2] / opposite[0] > 1.5 * near[2] / near[0]
    assert luminance(near) > 2 * luminance(opposite)


def test_the_sun_reddens_and_fades_as_it_sets() -> None:
    suns = np.array([sun_irradiance(elevation, 2.5) for elevation in (90.0, 60.0, 30.0, 10.0, 2.0)])
    assert (suns < SUN_ABOVE_THE_AIR).all()
    assert (np.diff(suns, axis=0) < 0).all()
    assert (np.diff(suns[:, 2] / suns[:, 0]) < 0).all()
    assert 80.0 < luminance(suns[0]) < 110.0


@pytest.mark.parametrize(("name", "elevation"), [("noon", 60.0), ("afternoon", 30.0), ("evening", 10.0)])
def test_the_sun_of_a_clear_sky_splits_off_as_the_lamp_it_is(name: str, elevation: float) -> None:
    rest, (sun,) = split_sun(make_built_in(name))
    theta, phi = world_angles(sun.direction)
    assert 90 - math.degrees(theta) == pytest.approx(elevation, abs=0.1)
    assert math.degrees(phi) == pytest.approx(40.0, abs=0.1)
    turbidity = 3.0 if name == "evening" else 2.5
    gain = luminance(rest.radiance[0, 0]) / luminance(preetham(UP, np.array(sun.direction), turbidity))
    np.testing.assert_allclose(sun.irradiance, gain * sun_irradiance(elevation, turbidity), rtol=0.03)
    assert luminance(rest.radiance).max() < luminance(sun.radiance) / 100


@pytest.mark.parametrize("name", ["noon", "afternoon", "evening", "sunset", "overcast"])
def test_a_level_white_card_is_one_under_every_sky(name: str) -> None:
    """By the sum over the map, which cuts the horizon and the low sun into texels."""
    environment = make_built_in(name)
    assert luminance(irradiance(environment, UP)) / math.pi == pytest.approx(1.0, rel=0.02)


def test_the_overcast_sky_falls_to_a_third_at_the_horizon() -> None:
    """The old CIE overcast sky is exactly 3 : 1; the standard one comes within a few percent of it."""
    zenith, middle, horizon = (luminance(overcast(world_direction(math.radians(t), 0.3))) for t in (0, 60, 89))
    assert zenith / horizon == pytest.approx(3.0, rel=0.05)
    assert middle / zenith == pytest.approx((1 + 2 * 0.5) / 3, rel=0.1)


@pytest.mark.parametrize("name", ["noon", "overcast"])
def test_the_ground_reflects_what_falls_on_it(name: str) -> None:
    environment = make_built_in(name)
    height = environment.radiance.shape[0]
    above = environment.radiance.copy()
    above[height // 2 :] = 0
    falling = irradiance(EnvironmentMap(above), UP)
    np.testing.assert_allclose(environment.radiance[-1, 0] * math.pi, falling * (0.20, 0.17, 0.12), rtol=0.02)


def test_a_sun_below_the_horizon_leaves_numbers_finite() -> None:
    values = clear_sky(0.0)(texel_directions(16, 32))
    assert np.isfinite(values).all()
    assert values.min() >= 0.0


def test_strip_lights_are_long_and_thin() -> None:
    bright = luminance(make_built_in("strip-lights").radiance) > 5.0
    tubes = [SKIES["strip-lights"].radiance(normalize((0.4, 1.0, z))) for z in (0.0, 0.8)]
    assert min(luminance(tube) for tube in tubes) > 5.0
    assert luminance(SKIES["strip-lights"].radiance(normalize((0.6, 1.0, 0.0)))) < 1.0
    assert 0.01 < bright.mean() < 0.1
