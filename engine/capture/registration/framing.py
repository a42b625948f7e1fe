"""Framing of the image within the reference photograph: crop, rectification from four corners, and size.

A framing is four corners in pixels of the reference and a size. It gives a homography from pixels of the image to
pixels of the reference (direct linear transform for four points, Hartley2004 Sec. 4.1), which is
multiplied with a photograph's alignment, so that each photograph is resampled exactly once. Where the image is
coarser than the photograph, a pixel is the mean of samples spread evenly over its area, so nothing aliases.

Conventions: pixel centres at integers, so the whole image reaches from -1/2 to width - 1/2. Corners run clockwise
from the top left as seen, and are corners of the image's outline, not centres of its outermost pixels.
Cost: with `warp`, 10 ns per sample and thread; ceil(reduction)^2 samples per pixel, at most `MAX_SAMPLES` squared.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.capture.registration.warp import Region
from engine.core.errors import UsageError

Matrix = NDArray[np.float64]
Corners = tuple[tuple[float, float], tuple[float, float], tuple[float, float], tuple[float, float]]

#: No image is wider or higher.
LARGEST_PX = 32768
#: No pixel is the mean of more than the square of so many samples.
MAX_SAMPLES = 1024


@dataclass(frozen=True)
class Framing:
    """Four `corners` (x, y) in pixels of the reference, clockwise from the top left, and the size of the image.

    Raises UsageError for corners that are not those of a convex figure in this order, and for impossible sizes.
    """

    corners: Corners
    width_px: int
    height_px: int

    def __post_init__(self) -> None:
        if not (1 <= self.width_px <= LARGEST_PX and 1 <= self.height_px <= LARGEST_PX):
            raise UsageError(f"{self.width_px} × {self.height_px} px is outside [1, {LARGEST_PX}] px")
        corners = np.asarray(self.corners, np.float64)
        if corners.shape != (4, 2) or not np.isfinite(corners).all():
            raise UsageError("a framing needs four corners of two finite numbers each")
        to_next = np.roll(corners, -1, axis=0) - corners
        after = np.roll(to_next, -1, axis=0)
        turn = to_next[:, 0] * after[:, 1] - to_next[:, 1] * after[:, 0]
        if (turn <= 1e-6 * float((to_next**2).sum(axis=1).max())).any():
            raise UsageError("the corners must run clockwise from the top left around a figure without dents")


def crop(region: Region, width_px: int | None = None, height_px: int | None = None) -> Framing:
    """Whole pixels of the reference, at their own size or at another one."""
    left, top = region.left - 0.5, region.top - 0.5
    right, bottom = left + region.width, top + region.height
    corners = ((left, top), (right, top), (right, bottom), (left, bottom))
    return Framing(corners, width_px or region.width, height_px or region.height)


def rectify(corners: Corners, aspect: float | None, size: tuple[int, int], width_px: int | None = None) -> Framing:
    """The figure between `corners` as a rectangle of `aspect` (width / height), as large as its longest sides.

    Without `aspect` it is estimated for a photograph of `size` (height, width). `width_px` sets another width.
    """
    places = np.asarray(corners, np.float64)
    sides = np.hypot(*(np.roll(places, -1, axis=0) - places).T)
    width, height = max(sides[0], sides[2]), max(sides[1], sides[3])
    shape = estimate_aspect(corners, size) if aspect is None else aspect
    across = width_px or max(1, round(max(width, height * shape)))
    return Framing(corners, across, max(1, round(across / shape)))


def estimate_aspect(corners: Corners, size: tuple[int, int]) -> float:
    """Width / height of the rectangle that a camera with square pixels, centred on (height, width) `size`, sees so.

    The homography's columns h1, h2 are images of two perpendicular directions: h1' w h2 = 0 gives the focal length, and
    |K^-1 h1| / |K^-1 h2| the aspect (Zhang2007 Sec. 3). Where the perspective is too weak to show the focal
    length, the mean lengths of opposite sides are compared.
    """
    height, width = size
    places = np.asarray(corners, np.float64)
    sides = np.hypot(*(np.roll(places, -1, axis=0) - places).T)
    plain = float((sides[0] + sides[2]) / (sides[1] + sides[3]))
    unit = homography(np.array([[0, 0], [1, 0], [1, 1], [0, 1.0]]), places - [(width - 1) / 2, (height - 1) / 2])
    one, other = unit[:, 0] / width, unit[:, 1] / width
    depth = one[2] * other[2] * width * width
    if abs(depth) < 1e-3 * (np.hypot(*one[:2]) * np.hypot(*other[:2])):
        return plain
    focal_squared = -(one[0] * other[0] + one[1] * other[1]) / (one[2] * other[2])
    if not (0.25 * width) ** 2 < focal_squared < (50.0 * width) ** 2:
        return plain
    lengths = [math.sqrt((c[0] ** 2 + c[1] ** 2) / focal_squared + c[2] ** 2) for c in (one, other)]
    return float(lengths[0] / lengths[1])


def framing_matrix(framing: Framing) -> Matrix:
    """(3, 3) from pixels (x, y, 1) of the image to pixels of the reference.

    Exactly a shift by whole pixels for a framing that only crops.
    """
    right, bottom = framing.width_px - 0.5, framing.height_px - 0.5
    outline = np.array([[-0.5, -0.5], [right, -0.5], [right, bottom], [-0.5, bottom]])
    corners = np.asarray(framing.corners, np.float64)
    shift = corners - outline
    if (shift == shift[0]).all():
        return np.array([[1, 0, shift[0, 0]], [0, 1, shift[0, 1]], [0, 0, 1.0]])
    return homography(outline, corners)


def homography(here: NDArray[np.float64], there: NDArray[np.float64]) -> Matrix:
    """The homography that takes four points (4, 2) `here` to `there`; raises UsageError where there is none."""
    rows = []
    for (x, y), (u, v) in zip(here, there, strict=True):
        rows += [[x, y, 1, 0, 0, 0, -u * x, -u * y], [0, 0, 0, x, y, 1, -v * x, -v * y]]
    try:
        solution = np.linalg.solve(np.array(rows), there.ravel())
    except np.linalg.LinAlgError:
        raise UsageError("three of four points lie on one line") from None
    return np.append(solution, 1.0).reshape(3, 3)


def samples_per_side(matrix: Matrix, width: int, height: int) -> int:
    """Samples along each side of a pixel of the image, so that none of the photograph is skipped."""
    corners = np.array([[0, 0], [width - 1, 0], [width - 1, height - 1], [0, height - 1.0]])
    largest = max(float(np.linalg.norm(_jacobian(matrix, x, y), axis=0).max()) for x, y in corners)
    return min(MAX_SAMPLES, max(1, math.ceil(largest - 1e-6)))


def _jacobian(matrix: Matrix, x: float, y: float) -> Matrix:
    """(2, 2) how far the place in the photograph moves for one pixel of the image, at (x, y)."""
    u, v, w = matrix @ np.array([x, y, 1.0])
    return (matrix[:2, :2] - np.outer((u / w, v / w), matrix[2, :2])) / w


def inside_all(
    framing: Framing, matrices: Sequence[Matrix], height: int, width: int, tolerance_px: float = 0.51
) -> bool:
    """True if every photograph shows all of the image, up to `tolerance_px` beyond its outermost pixel centres."""
    corners = np.hstack([np.asarray(framing.corners, np.float64), np.ones((4, 1))])
    limits = np.array([width - 1, height - 1]) + tolerance_px
    for matrix in matrices:
        there = corners @ matrix.T
        places = there[:, :2] / there[:, 2:]
        if (there[:, 2] <= 0).any() or (places < -tolerance_px).any() or (places > limits).any():
            return False
    return True
