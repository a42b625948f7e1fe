"""The mirror sphere against the law of reflection, read back by what reads photographed spheres."""

from __future__ import annotations

import math

import numpy as np
import pytest

from engine.capture.lights.mirror_sphere import Circle, find_highlight, light_direction
from engine.simulate import shading
from engine.simulate.rig import with_ball

BALL = Circle(70.3, 61.8, 40.0)


@pytest.mark.parametrize(("elevation_deg", "azimuth_deg"), [(10, 0), (35, 120), (60, 250), (90, 0)])
def test_highlight_tells_the_direction_of_the_lamp(elevation_deg: int, azimuth_deg: int) -> None:
    """Within what counting whole pixels of a clipped spot can tell: a fifth of a pixel."""
    lamp = shading.light_direction(math.radians(elevation_deg), math.radians(azimuth_deg))
    image = with_ball(np.full((128, 128, 3), 0.3, np.float32), BALL, lamp)
    found = light_direction(BALL, *find_highlight(np.minimum(image, 1).mean(axis=2), BALL))
    assert math.degrees(math.acos(min(1.0, float(found @ lamp)))) < math.degrees(2 * 0.2 / BALL.radius)


def test_only_the_disk_of_the_sphere_changes() -> None:
    before = np.random.default_rng(0).random((128, 128, 3), np.float32)
    after = with_ball(before, BALL, np.array([0.0, 0.0, 1.0]))
    row, column = np.mgrid[0:128, 0:128] + 0.5
    outside = np.hypot(column - BALL.column, row - BALL.row) > BALL.radius + 1
    assert np.array_equal(after[outside], before[outside])
    assert (after[~outside] != before[~outside]).any(axis=-1).mean() > 0.95


@pytest.mark.parametrize("size", [16, 18, 28])
def test_a_sphere_in_the_corner_of_a_small_image(size: int) -> None:
    """The square around it leaves the image."""
    ball = Circle(0.13 * size, 0.87 * size, 0.1 * size)
    after = with_ball(np.full((size, size, 3), 0.3, np.float32), ball, np.array([0.0, 0.0, 1.0]))
    row, column = np.mgrid[0:size, 0:size] + 0.5
    changed = (after != np.float32(0.3)).any(axis=-1)
    assert changed.any()
    assert not changed[np.hypot(column - ball.column, row - ball.row) > ball.radius + 1].any()
