"""Lamps: what they bring to a surface, and the directions that stand for a disc."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.core.directions import world_direction
from engine.light.lamps import (
    MAX_OF_ALL,
    Lamp,
    LampSettings,
    directions_for,
    lamp_from_text,
    lights_of,
    lights_of_all,
)

radii = st.floats(1e-6, math.pi / 2)
counts = st.integers(2, 300)


def test_radiance_times_the_projected_disc_is_the_irradiance() -> None:
    """An independent sum over rings of the disc, as fine as it needs to be."""
    lamp = Lamp((0.0, 1.0, 0.0), (1.0, 2.0, 3.0), 0.7)
    theta = (np.arange(100_000) + 0.5) * 0.7 / 100_000
    rings = 2 * np.pi * np.sin(theta) * 0.7 / 100_000
    np.testing.assert_allclose(np.array(lamp.radiance) * (rings * np.cos(theta)).sum(), lamp.irradiance, rtol=1e-9)
    np.testing.assert_allclose(np.array(lamp.radiance) * rings.sum(), lamp.flux, rtol=1e-9)
    assert lamp.solid_angle == pytest.approx(rings.sum(), rel=1e-9)


@given(radii, counts, st.floats(0, math.pi), st.floats(-math.pi, math.pi))
def test_directions_of_a_disc_keep_its_irradiance_and_lie_inside_it(
    radius: float, count: int, theta: Any, phi: Any
) -> None:
    direction = world_direction(theta, phi)
    lamp = Lamp(tuple(direction), (1.0, 2.0, 0.0), radius)
    lights = lights_of(lamp, count)
    cosine = lights.direction @ direction
    np.testing.assert_allclose((lights.irradiance * cosine[:, None]).sum(axis=0), lamp.irradiance, rtol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(lights.direction, axis=1), 1.0, atol=1e-14)
    assert (np.linalg.norm(lights.direction - direction, axis=1) <= 2 * math.sin(radius / 2) + 1e-12).all()


@given(radii)
def test_directions_of_a_disc_are_about_its_centre(radius: float) -> None:
    lights = lights_of(Lamp((1.0, 0.0, 0.0), (1.0, 1.0, 1.0), radius), 256)
    assert np.abs(lights.direction.mean(axis=0)[1:]).max() < 0.01 * radius


def test_neighbours_on_a_disc_keep_their_distance() -> None:
    """Vogel's spiral: the nearest neighbour is never much nearer than on a square grid of as many."""
    lamp = Lamp((0.0, 0.0, 1.0), (1.0, 1.0, 1.0), 0.3)
    direction = lights_of(lamp, 200).direction
    apart = np.linalg.norm(direction[:, None] - direction, axis=-1) + 9 * np.eye(200)
    assert apart.min() > 0.6 * math.sqrt(lamp.solid_angle / 200)


def test_a_directional_lamp_is_one_direction_whatever_is_asked_for() -> None:
    lights = lights_of(Lamp((0.0, 3.0, 4.0), (1.0, 2.0, 3.0)), 50)
    np.testing.assert_allclose(lights.direction, [(0.0, 0.6, 0.8)], rtol=1e-15)
    np.testing.assert_array_equal(lights.irradiance, [(1.0, 2.0, 3.0)])


def test_irradiance_stays_as_the_disc_shrinks() -> None:
    lamp = Lamp((0.0, 1.0, 0.0), (1.0, 1.0, 1.0), 1e-7)
    np.testing.assert_allclose(lamp.flux, 1.0, rtol=1e-13)
    np.testing.assert_allclose(np.array(lamp.radiance) * lamp.solid_angle, 1.0, rtol=1e-13)


@pytest.mark.parametrize(("radius_deg", "count"), [(0.0, 1), (0.27, 1), (5.0, 35), (20.0, 256), (90.0, 256)])
def test_larger_discs_get_more_directions(radius_deg: float, count: int) -> None:
    assert directions_for([Lamp((0.0, 1.0, 0.0), (1.0, 1.0, 1.0), math.radians(radius_deg))]) == [count]


def test_many_lamps_share_their_directions() -> None:
    lamps = [Lamp((0.0, 1.0, 0.0), (1.0, 1.0, 1.0), 1.0)] * 20 + [Lamp((1.0, 1.0, 0.0), (1.0, 0.0, 0.0))]
    lights = lights_of_all(lamps)
    assert MAX_OF_ALL * 0.9 < len(lights.direction) <= MAX_OF_ALL + 1
    facing = (lights.irradiance[:-1] * lights.direction[:-1, 1:2]).sum(axis=0)
    np.testing.assert_allclose(facing, 20.0, rtol=1e-12)
    assert len(lights_of_all([]).direction) == 0


def test_a_turned_lamp_comes_from_where_turned_lights_come_from() -> None:
    lamp = Lamp((0.0, 0.6, 0.8), (1.0, 2.0, 3.0), 0.1).rotate(math.pi / 2)
    np.testing.assert_allclose(lamp.direction, (0.8, 0.6, 0.0), atol=1e-15)
    assert lamp.radius == 0.1


@pytest.mark.parametrize(
    "wrong",
    [
        {"direction": (0.0, 0.0, 0.0)},
        {"direction": (math.nan, 0.0, 0.0)},
        {"direction": (1.0, 0.0)},
        {"irradiance": (-1.0, 0.0, 0.0)},
        {"irradiance": (math.inf, 0.0, 0.0)},
        {"radius": math.nan},
        {"radius": -0.1},
        {"radius": 1.6},
    ],
)
def test_impossible_lamps_are_refused(wrong: Any) -> None:
    with pytest.raises(ValueError, match="lamp"):
        Lamp(**{"direction": (0.0, 1.0, 0.0), "irradiance": (1.0, 1.0, 1.0), **wrong})


def test_extreme_lengths_of_the_direction_do_not_matter() -> None:
    for length in (1e-300, 1e300):
        np.testing.assert_allclose(Lamp((length, length, 0.0), (1.0, 1.0, 1.0)).direction, (0.5**0.5, 0.5**0.5, 0.0))


def test_a_lamp_is_read_from_text() -> None:
    lamp = lamp_from_text("theta_deg=40, phi_deg=20,irradiance=2,radius_deg=5,colour=1:0.8:0.6")
    np.testing.assert_allclose(lamp.direction, world_direction(math.radians(40), math.radians(20)), rtol=1e-12)
    np.testing.assert_allclose(lamp.irradiance, (2.0, 1.6, 1.2), rtol=1e-15)
    assert lamp.radius == math.radians(5)
    assert lamp_from_text("") == LampSettings().lamp


@pytest.mark.parametrize("text", ["power=3", "irradiance=-1", "radius_deg=91", "theta_deg=nan", "colour=1:2", "40,20"])
def test_impossible_texts_are_refused_with_words(text: str) -> None:
    with pytest.raises(ValueError, match=r"choose from|outside|needs"):
        lamp_from_text(text)


def test_settings_of_a_lamp_give_it_back() -> None:
    lamp = Lamp((0.3, -0.5, 0.7), (0.2, 4.0, 0.0), 0.2)
    again = LampSettings.of(lamp).lamp
    np.testing.assert_allclose(again.direction, lamp.direction, atol=1e-14)
    np.testing.assert_allclose(again.irradiance, lamp.irradiance, rtol=1e-14)
    assert again.radius == pytest.approx(0.2)
    assert LampSettings.of(Lamp((0.0, 1.0, 0.0), (0.0, 0.0, 0.0))).irradiance == 0.0
