"""Numbers of samples: stratified in every way, independent of each other, and always the same."""

from __future__ import annotations

import numpy as np
import pytest

from engine.render.sobol import SOBOL, pairs, seed_state


def numbers(count: int, *, start: int = 0, pixel: int = 0, dimension: int = 0, seed: int = 0) -> np.ndarray:
    pixels = np.full(count, pixel, np.int64)
    drawn: np.ndarray = pairs(seed_state(seed, 0), pixels, dimension, np.arange(start, start + count), SOBOL)
    return drawn


@pytest.mark.parametrize(("pixel", "dimension", "start"), [(0, 0, 0), (7, 3, 64), (123456789, 40, 192)])
def test_a_power_of_two_of_samples_has_one_in_each_box_of_every_shape(pixel: int, dimension: int, start: int) -> None:
    u = numbers(64, start=start, pixel=pixel, dimension=dimension, seed=5)
    for rows in (1, 2, 4, 8, 16, 32, 64):
        box = (u[:, 0] * rows).astype(int) * (64 // rows) + (u[:, 1] * (64 // rows)).astype(int)
        assert sorted(box) == list(range(64))


def test_numbers_are_uniform_and_those_of_other_pixels_dimensions_and_seeds_are_unrelated() -> None:
    pixels = np.arange(1 << 16)
    columns = [
        pairs(seed_state(seed, stream), pixels, dimension, np.full(len(pixels), sample), SOBOL)
        for seed, stream, dimension, sample in [(0, 0, 0, 0), (0, 0, 0, 1), (0, 0, 1, 0), (0, 1, 0, 0), (1, 0, 0, 0)]
    ]
    u = np.concatenate(columns, axis=1)
    assert u.min() >= 0.0
    assert u.max() < 1.0
    np.testing.assert_allclose(u.mean(axis=0), 0.5, atol=4.5 / np.sqrt(12 * len(u)))
    related = np.corrcoef(u.T) - np.eye(u.shape[1])
    # consecutive samples of one pixel lie apart on purpose, in the same dimension
    for apart in ((0, 2), (1, 3)):
        related[apart] = related[apart[::-1]] = 0.0
    assert np.abs(related).max() < 4.5 / np.sqrt(len(u))


def test_dimensions_of_one_pixel_are_unrelated_over_its_samples() -> None:
    u = np.concatenate([numbers(4096, dimension=dimension) for dimension in range(4)], axis=1)
    assert np.abs(np.corrcoef(u.T) - np.eye(8)).max() < 4.5 / np.sqrt(4096)


def test_a_seed_of_any_size_is_one_number_and_a_negative_one_is_refused() -> None:
    assert seed_state(10**40, 3) != seed_state(10**40 + 1, 3)
    with pytest.raises(ValueError, match="negative"):
        seed_state(-1, 0)
