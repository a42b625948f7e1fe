"""Crops keep every bit, tilted boards become straight, and smaller images keep their light."""

from typing import Any

import numpy as np
import pytest

from engine.capture.registration.framing import (
    Framing,
    crop,
    estimate_aspect,
    framing_matrix,
    homography,
    inside_all,
    rectify,
    samples_per_side,
)
from engine.capture.registration.warp import Region, warp

FIELDS, FIELD_PX = 8, 40


def board_photograph(corners: Any, height: int = 480, width: int = 640, fine: int = 6) -> Any:
    """A chequerboard between `corners`, as the mean of fine × fine samples per pixel."""
    side = float(FIELDS)
    to_board = np.linalg.inv(
        homography(np.array([[0, 0], [side, 0], [side, side], [0, side]]), np.array(corners, float))
    )
    row, column = (np.mgrid[: height * fine, : width * fine] + 0.5) / fine - 0.5
    there = np.stack([column, row, np.ones_like(row)], -1) @ to_board.T
    x, y = there[..., 0] / there[..., 2], there[..., 1] / there[..., 2]
    light = np.where((np.floor(x) + np.floor(y)) % 2 == 0, 0.9, 0.1)
    grey = light.reshape(height, fine, width, fine).mean(axis=(1, 3)).astype(np.float32)
    return np.repeat(grey[..., None], 3, axis=-1)


def frame(image: Any, framing: Any, first: int = 0, stop: Any = None) -> Any:
    matrix = framing_matrix(framing)
    samples = samples_per_side(matrix, framing.width_px, framing.height_px)
    region = Region(0, 0, framing.width_px, framing.height_px)
    return warp(image, np.zeros(image.shape[:2], bool), matrix, region, first, stop, samples)[0]


def edge_positions(profile: Any) -> Any:
    """The positions where the profile crosses its middle, in pixels."""
    over = profile - 0.5
    at = np.flatnonzero(over[:-1] * over[1:] < 0)
    return at + over[at] / (over[at] - over[at + 1])


TILTED = ((101.3, 60.2), (530.8, 95.7), (580.1, 430.4), (60.6, 402.9))


def test_a_tilted_chequerboard_is_rectified_to_a_tenth_of_a_pixel() -> None:
    size = FIELDS * FIELD_PX
    framed_image = frame(board_photograph(TILTED), Framing(TILTED, size, size))[..., 0]
    expected = np.arange(1, FIELDS) * FIELD_PX - 0.5
    for middle in range(FIELD_PX // 2, size, FIELD_PX):
        for profile in (framed_image[middle], framed_image[:, middle]):
            inner = edge_positions(profile[4:-4]) + 4
            assert np.abs(inner - expected).max() <= 0.1


def test_crop_alone_is_bit_exact() -> None:
    image = np.random.default_rng(0).gamma(0.5, 0.3, (61, 83, 3)).astype(np.float32)
    framed_image = frame(image, crop(Region(7, 11, 50, 40)))
    assert np.array_equal(framed_image, image[11:51, 7:57])


@pytest.mark.parametrize("size", [(50, 37), (17, 90), (200, 100), (7, 7)])
def test_shrinking_keeps_the_mean_and_does_not_alias(size: Any) -> None:
    image = np.random.default_rng(1).gamma(0.5, 0.3, (400, 500, 3)).astype(np.float32)
    fine = np.broadcast_to(np.where(np.arange(500) % 2 == 0, 0.2, 0.8)[None, :, None], (400, 500, 3))
    framing = crop(Region(0, 0, 500, 400), *size)
    for whole in (image, fine.astype(np.float32)):
        assert frame(whole, framing).mean(dtype=np.float64) == pytest.approx(whole.mean(dtype=np.float64), rel=1e-3)
    stripes = frame(fine.astype(np.float32), framing)
    assert np.abs(stripes - 0.5).max() < 0.35 / (500 / size[0])


def test_whole_reductions_are_means_of_blocks() -> None:
    image = np.random.default_rng(2).random((60, 90, 3)).astype(np.float32)
    framed_image = frame(image, crop(Region(0, 0, 90, 60), 30, 20))
    assert np.abs(framed_image - image.reshape(20, 3, 30, 3, 3).mean(axis=(1, 3))).max() < 1e-6


@pytest.mark.parametrize("rows", [1, 13])
def test_S10_bands_of_a_framed_image_are_bit_equal(rows: int) -> None:
    image = np.random.default_rng(3).random((300, 400, 3)).astype(np.float32)
    framing = Framing(((31.5, 20.1), (350.2, 44.4), (380.0, 280.3), (12.7, 260.8)), 130, 97)
    whole = frame(image, framing)
    bands = [frame(image, framing, first, min(first + rows, 97)) for first in range(0, 97, rows)]
    assert np.array_equal(np.concatenate(bands), whole)


def camera_view(aspect: Any, focal: float = 900.0) -> Any:
    """Corners of a rectangle of `aspect`, tilted about two axes, in a photograph of 640 × 480."""
    a, b = np.radians([28.0, 20.0])
    tilt = np.array([[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]])
    turn = np.array([[np.cos(b), 0, np.sin(b)], [0, 1, 0], [-np.sin(b), 0, np.cos(b)]])
    flat = np.array([[-aspect, -1, 0], [aspect, -1, 0], [aspect, 1, 0], [-aspect, 1, 0]]) / 2
    there = flat @ (turn @ tilt).T + [0.05, -0.03, 4.0]
    return tuple(map(tuple, there[:, :2] / there[:, 2:] * focal + [319.5, 239.5]))


@pytest.mark.parametrize("aspect", [0.6, 1.0, 1.7])
def test_the_aspect_is_estimated_from_perspective(aspect: float) -> None:
    corners = camera_view(aspect)
    assert estimate_aspect(corners, (480, 640)) == pytest.approx(aspect, rel=1e-6)
    framing = rectify(corners, None, (480, 640))
    assert framing.width_px / framing.height_px == pytest.approx(aspect, rel=0.01)
    assert rectify(corners, 2.0, (480, 640), width_px=500).height_px == 250


def test_the_aspect_of_an_upright_rectangle_is_that_of_its_sides() -> None:
    assert estimate_aspect(((10, 10), (310, 10), (310, 110), (10, 110)), (480, 640)) == pytest.approx(3.0)


def test_inside_all_sees_a_photograph_that_ends_too_soon() -> None:
    framing = crop(Region(5, 5, 50, 40))
    moved = np.array([[1, 0, -8.0], [0, 1, 0], [0, 0, 1]])
    assert inside_all(framing, [np.eye(3)], 60, 80)
    assert not inside_all(framing, [np.eye(3), moved], 60, 80)
    assert inside_all(crop(Region(0, 0, 80, 60)), [np.eye(3)], 60, 80)


@pytest.mark.parametrize(
    "corners",
    [
        ((0, 0), (0, 10), (10, 10), (10, 0)),
        ((0, 0), (10, 0), (2, 2), (0, 10)),
        ((0, 0), (10, 0), (20, 0), (0, 10)),
        ((0, 0), (10, 0), (float("nan"), 10), (0, 10)),
    ],
)
def test_impossible_corners_are_refused(corners: Any) -> None:
    with pytest.raises(ValueError, match=r"corners"):
        Framing(corners, 10, 10)


def test_impossible_sizes_are_refused() -> None:
    with pytest.raises(ValueError, match="outside"):
        crop(Region(0, 0, 5, 5), 100000, 5)
