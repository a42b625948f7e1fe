"""The lens: exact shifts, kept means, no negative radiance."""

from __future__ import annotations

import numpy as np
import pytest

from engine.render.lens import blurred


def waves(right=0.0, down=0.0):
    row, column = np.mgrid[0:48, 0:64]
    phase = 2 * np.pi * (3 * (column - right) / 64 + 2 * (row - down) / 48)
    return np.repeat((0.5 + 0.4 * np.sin(phase))[..., None], 3, axis=2).astype(np.float32)


@pytest.mark.parametrize(("right", "down"), [(0.37, -0.81), (5.0, 0.0), (-0.5, 13.25)])
def test_shift_of_a_wave_is_exact(right, down):
    np.testing.assert_allclose(blurred(waves(), 0.0, right, down), waves(right, down), atol=2e-6)


def test_blur_attenuates_a_wave_as_a_gaussian_does():
    frequency_squared = (3 / 64) ** 2 + (2 / 48) ** 2
    expected = 0.5 + (waves() - 0.5) * np.exp(-2 * np.pi**2 * 2.0**2 * frequency_squared)
    np.testing.assert_allclose(blurred(waves(), 2.0), expected, atol=2e-6)


def test_mean_is_kept_and_nothing_is_negative():
    image = (np.random.default_rng(0).random((64, 64, 3)) > 0.9).astype(np.float32)
    moved = blurred(image, 1.0, 0.3, -0.6)
    assert moved.min() >= 0
    assert moved.mean(dtype=float) == pytest.approx(image.mean(dtype=float), rel=2e-4)
