"""The lens: exact shifts, kept means, no negative radiance."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.simulate.camera import blur, falloff, rotate


def waves(right: float = 0.0, down: float = 0.0) -> NDArray[np.float32]:
    row, column = np.mgrid[0:48, 0:64]
    phase = 2 * np.pi * (3 * (column - right) / 64 + 2 * (row - down) / 48)
    return np.repeat((0.5 + 0.4 * np.sin(phase))[..., None], 3, axis=2).astype(np.float32)


@pytest.mark.parametrize(("right", "down"), [(0.37, -0.81), (5.0, 0.0), (-0.5, 13.25)])
def test_shift_of_a_wave_is_exact(right: float, down: float) -> None:
    np.testing.assert_allclose(blur(waves(), 0.0, right, down), waves(right, down), atol=2e-6)


def test_blur_attenuates_a_wave_as_a_gaussian_does() -> None:
    frequency_squared = (3 / 64) ** 2 + (2 / 48) ** 2
    expected = 0.5 + (waves() - 0.5) * np.exp(-2 * np.pi**2 * 2.0**2 * frequency_squared)
    np.testing.assert_allclose(blur(waves(), 2.0), expected, atol=2e-6)


def test_mean_is_kept_and_nothing_is_negative() -> None:
    image = (np.random.default_rng(0).random((64, 64, 3)) > 0.9).astype(np.float32)
    moved = blur(image, 1.0, 0.3, -0.6)
    assert moved.min() >= 0
    assert moved.mean(dtype=float) == pytest.approx(image.mean(dtype=float), rel=2e-4)


def test_quarter_turn_is_counter_clockwise() -> None:
    image = np.random.default_rng(1).random((32, 32, 3), np.float32)
    np.testing.assert_allclose(rotate(image, math.pi / 2, 0.0, 0.0), np.rot90(image), atol=2e-5)


def test_turn_and_shift_of_a_wave_are_where_they_should_be() -> None:
    """Away from the border, where a rotated tile no longer fits itself; a point p is seen at R p + shift."""
    angle, right, down, size = math.radians(3), 0.7, -1.2, 96
    column, row = np.meshgrid(np.arange(size) + 0.5 - size / 2, np.arange(size) + 0.5 - size / 2)

    def wave(x: Any, y: Any) -> Any:
        return 0.5 + 0.4 * np.sin(2 * np.pi * (5 * x + 3 * y) / size)

    image = np.repeat(wave(column, row)[..., None], 3, axis=2).astype(np.float32)
    x, y = column - right, row - down
    cosine, sine = math.cos(angle), math.sin(angle)
    expected = wave(cosine * x - sine * y, sine * x + cosine * y)
    moved = rotate(image, angle, right, down)[..., 0]
    np.testing.assert_allclose(moved[16:-16, 16:-16], expected[16:-16, 16:-16], atol=1e-4)
    halves = rotate(image, angle, right, down, 2)[..., 0]
    assert halves.shape == (48, 48)
    means = expected.reshape(48, 2, 48, 2).mean(axis=(1, 3))
    np.testing.assert_allclose(halves[8:-8, 8:-8], means[8:-8, 8:-8], atol=0.02)


def test_falloff_is_the_fourth_power_of_the_cosine_off_the_axis() -> None:
    loss = 1 - math.cos(math.radians(25)) ** 4
    share = falloff(101, 151, loss)
    tangent = np.hypot(*np.meshgrid(np.arange(151) - 75, np.arange(101) - 50)) / math.hypot(75.5, 50.5)
    angle = np.arctan(tangent * math.tan(math.radians(25)))
    np.testing.assert_allclose(share, np.cos(angle) ** 4, rtol=1e-6)
    assert share[50, 75] == 1
    assert (falloff(8, 8, 0.0) == 1).all()
    with pytest.raises(ValueError, match="cannot lose"):
        falloff(8, 8, 1.0)
