"""A relit image of thumbnails: known polynomials come back, and too few photographs give none."""

from __future__ import annotations

import numpy as np

from engine.core.directions import normalize, surface_direction
from engine.shading.directional.functions import polynomial
from engine.shading.directional.relit_small import FEWEST, relight_small


def test_codes_that_are_polynomials_of_the_light_come_back() -> None:
    rng = np.random.default_rng(3)
    lights = surface_direction(np.radians(rng.uniform(10.0, 70.0, 24)), rng.uniform(0.0, 2.0 * np.pi, 24))
    wanted = np.concatenate([rng.uniform(-30.0, 30.0, (5, 4, 5, 3)), rng.uniform(100.0, 140.0, (1, 4, 5, 3))])
    images = np.rint(np.tensordot(polynomial(lights), wanted, axes=1)).astype(np.uint8)
    found = relight_small(list(images), lights)
    assert found is not None
    new = surface_direction(np.radians(40.0), 1.0)
    truth = np.tensordot(polynomial(new[None])[0], wanted, axes=1)
    assert np.abs(found.image(new).astype(np.float64) - truth).max() <= 2.0


def test_lamps_on_an_arc_brighten_as_their_photographs_do() -> None:
    lights = surface_direction(np.radians([75.0, 50.0, 25.0, 0.0]), 0.0)
    images = [np.full((2, 2, 3), round(200.0 * light[2]), np.uint8) for light in lights]
    found = relight_small(images, lights)
    assert found is not None
    shown = [found.image(surface_direction(np.radians(angle), 0.0))[0, 0, 0] for angle in (60.0, 40.0, 10.0)]
    assert np.allclose(shown, 200.0 * np.cos(np.radians([60.0, 40.0, 10.0])), atol=12.0)


def test_too_few_photographs_of_a_size_give_no_image() -> None:
    images = [np.zeros((2, 3, 3), np.uint8)] * (FEWEST - 1) + [np.zeros((3, 2, 3), np.uint8)]
    assert relight_small(images, normalize(np.ones((FEWEST, 3)))) is None
