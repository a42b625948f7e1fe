"""Warping makes no light, and has the same bits in any bands."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.capture.registration.warp import Region, find_needed_rows, valid_region, warp

U32 = 2.0**-24
TURN = np.array([[0.9998, -0.0175, 2.37], [0.0175, 0.9998, -1.81], [1e-6, -2e-6, 1.0]])


def make_image(seed: int = 0, height: int = 301, width: int = 257) -> NDArray[np.float32]:
    return np.random.default_rng(seed).gamma(0.5, 0.3, (height, width, 3)).astype(np.float32)


def warp_image(image: Any, matrix: Any, mask: Any = None) -> Any:
    region = valid_region([np.eye(3), matrix], *image.shape[:2])
    return warp(image, np.zeros(image.shape[:2], bool) if mask is None else mask, matrix, region)


@pytest.mark.parametrize("matrix", [TURN, np.array([[1, 0, 0.37], [0, 1, -0.81], [0, 0, 1.0]])])
def test_AL8_no_negative_radiance_and_mean_and_constant_kept(matrix: Any) -> None:
    image = make_image()
    image[::3] = 0.0
    moved, _ = warp_image(image, matrix)
    assert moved.min() >= 0.0
    smooth = np.ones_like(image) * np.linspace(0.2, 0.8, image.shape[1], dtype=np.float32)[None, :, None]
    region = valid_region([np.eye(3), matrix], *image.shape[:2])
    kept = smooth[region.top : region.top + region.height, region.left : region.left + region.width]
    centred = warp_image(smooth, matrix)[0].mean(dtype=np.float64)
    shift = (matrix @ [region.left + (region.width - 1) / 2, region.top + (region.height - 1) / 2, 1])[0]
    drift = (shift - region.left - (region.width - 1) / 2) * 0.6 / (image.shape[1] - 1)
    assert centred == pytest.approx(kept.mean(dtype=np.float64) + drift, rel=1e-3)
    constant, _ = warp_image(np.full_like(image, 0.1), matrix)
    assert np.abs(constant / np.float32(0.1) - 1).max() <= 2 * U32


def test_AL8_mean_of_noise_changes_by_less_than_a_thousandth() -> None:
    image = make_image(1, 1201, 1203)
    moved, _ = warp_image(image, np.array([[1, 0, 0.5], [0, 1, 0.5], [0, 0, 1.0]]))
    whole = image.mean(dtype=np.float64)
    assert abs(moved.mean(dtype=np.float64) / whole - 1) <= 1e-3


def test_against_plain_bilinear_interpolation() -> None:
    from scipy.ndimage import map_coordinates

    image = make_image(2)
    region = valid_region([np.eye(3), TURN], *image.shape[:2])
    moved, _ = warp(image, np.zeros(image.shape[:2], bool), TURN, region)
    row, column = np.mgrid[: region.height, : region.width]
    there = np.stack([column + region.left, row + region.top, np.ones_like(row)], -1) @ TURN.T
    x, y = there[..., 0] / there[..., 2], there[..., 1] / there[..., 2]
    expected = np.stack([map_coordinates(image[..., c].astype(float), [y, x], order=1) for c in range(3)], -1)
    assert np.abs(moved - expected).max() < 1e-5


@pytest.mark.parametrize("rows", [1, 7, 64])
def test_S10_bands_of_any_height_are_bit_equal(rows: int) -> None:
    image, mask = make_image(3), make_image(4)[..., 0] > 0.8
    region = valid_region([TURN], *image.shape[:2])
    whole, whole_mask = warp(image, mask, TURN, region)
    bands = [
        warp(image, mask, TURN, region, first, min(first + rows, region.height))
        for first in range(0, region.height, rows)
    ]
    assert np.array_equal(np.concatenate([band for band, _ in bands]), whole)
    assert np.array_equal(np.concatenate([band for _, band in bands]), whole_mask)


TURNS = {
    "shift": np.array([[1, 0, 0.37], [0, 1, -0.81], [0, 0, 1.0]]),
    "turn": TURN,
    "upside down": np.array([[-1.0, 0.02, 250.3], [0.01, -1.0, 290.6], [0, 0, 1]]),
    "beyond": np.array([[1.0, 0, 3.2], [0, 1, -70.4], [0, 0, 1]]),
    "horizon": np.array([[1.0, 0, 0], [0, 1, 0], [0.01, 0.01, -1]]),
}


@pytest.mark.parametrize("samples", [1, 3])
@pytest.mark.parametrize("matrix", TURNS.values(), ids=TURNS)
def test_the_needed_rows_are_enough(matrix: Any, samples: int) -> None:
    """All others are NaN and saturated, so that each that is taken shows."""
    image, mask = make_image(3), make_image(4)[..., 0] > 0.8
    height, region, rows = len(image), Region(2, 1, 240, 290), 29
    whole, whole_mask = warp(image, mask, matrix, region, samples=samples)
    for first in range(0, region.height, rows):
        begin, end = find_needed_rows(matrix, region, first, first + rows, height)
        others, saturated = np.full_like(image, np.nan), np.ones_like(mask)
        others[begin:end], saturated[begin:end] = image[begin:end], mask[begin:end]
        taken = others[begin:end], saturated[begin:end]
        band, clipped = warp(*taken, matrix, region, first, first + rows, samples, (begin, height))
        inside = warp(others, saturated, matrix, region, first, first + rows, samples)[0]
        assert np.array_equal(band, whole[first : first + rows])
        assert np.array_equal(inside, band)
        assert np.array_equal(clipped, whole_mask[first : first + rows])


def test_a_band_needs_few_rows_more_than_it_has() -> None:
    region = Region(0, 0, 257, 301)
    assert find_needed_rows(TURNS["shift"], region, 100, 120, 301) == (97, 121)
    assert find_needed_rows(TURNS["horizon"], region, 90, 110, 301) == (0, 301)


def test_saturation_spreads_to_all_that_a_clipped_pixel_enters() -> None:
    mask = np.zeros((9, 9), bool)
    mask[4, 4] = True
    half = np.array([[1, 0, 0.5], [0, 1, 0.5], [0, 0, 1.0]])
    _, moved = warp(np.zeros((9, 9, 3), np.float32), mask, half, Region(0, 0, 8, 8))
    assert np.argwhere(moved).tolist() == [[3, 3], [3, 4], [4, 3], [4, 4]]
    whole = np.array([[1, 0, 1.0], [0, 1, 0], [0, 0, 1.0]])
    _, moved = warp(np.zeros((9, 9, 3), np.float32), mask, whole, Region(0, 0, 8, 9))
    assert np.argwhere(moved).tolist() == [[4, 3]]


def test_valid_region_is_what_all_show() -> None:
    assert valid_region([np.eye(3)], 10, 20) == Region(0, 0, 20, 10)
    shift = np.array([[1, 0, 2.3], [0, 1, -1.2], [0, 0, 1.0]])
    region = valid_region([np.eye(3), shift], 10, 20)
    assert region == Region(0, 2, 17, 8)
    assert region.intersected(Region(15, 0, 10, 10)) == Region(15, 2, 2, 8)
