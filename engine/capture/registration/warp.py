"""Moves a photograph by its alignment, without making light: bilinear weights, cut to where all photographs have data.

Bilinear weights are never negative and sum to one, so radiance stays non-negative, a constant stays constant, and
the mean moves only by what crosses the border. Positions are computed in float64 from the pixel's own row and column,
so an image warped in bands of any height has the same bits as one warped whole. An image that becomes smaller is
sampled several times in each pixel's area, evenly, and averaged.
Cost: bound by memory: about 10 ns per sample and thread.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.core.kernels import parallel, prange, scalar

#: A photograph may end this much before the edge of the region: what rounding and a perfect tripod leave.
_TOLERANCE_PX = 0.01


@dataclass(frozen=True)
class Region:
    """A rectangle of whole pixels of the reference photograph."""

    left: int
    top: int
    width: int
    height: int

    def intersected(self, other: Region) -> Region:
        """Intersection of both; width or height ≤ 0 if it is empty."""
        left, top = max(self.left, other.left), max(self.top, other.top)
        right = min(self.left + self.width, other.left + other.width)
        bottom = min(self.top + self.height, other.top + other.height)
        return Region(left, top, right - left, bottom - top)


def valid_region(matrices: Iterable[NDArray[np.float64]], height: int, width: int) -> Region:
    """The largest upright rectangle between the edges of all photographs, seen from the reference."""
    corners = np.array([[0, 0, 1], [width - 1, 0, 1], [width - 1, height - 1, 1], [0, height - 1, 1.0]])
    seen = [corners @ np.linalg.inv(matrix).T for matrix in matrices]
    x, y = (np.array([corner[:, axis] / corner[:, 2] for corner in seen]) for axis in (0, 1))
    left = max(0, math.ceil(float(x[:, [0, 3]].max()) - _TOLERANCE_PX))
    top = max(0, math.ceil(float(y[:, [0, 1]].max()) - _TOLERANCE_PX))
    right = min(width - 1, math.floor(float(x[:, [1, 2]].min()) + _TOLERANCE_PX))
    bottom = min(height - 1, math.floor(float(y[:, [2, 3]].min()) + _TOLERANCE_PX))
    return Region(left, top, right - left + 1, bottom - top + 1)


def warp(
    image: NDArray[np.float32],
    saturated: NDArray[np.bool_],
    matrix: NDArray[np.float64],
    region: Region,
    first: int = 0,
    stop: int | None = None,
    samples: int = 1,
    part: tuple[int, int] | None = None,
) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
    """Rows [first, stop) of `region` of the aligned photograph, (rows, region.width, 3), and of its saturation mask.

    `image` is (H, W, 3), `saturated` (H, W), `matrix` takes pixels of the region's frame to pixels of the image. Each
    pixel is the mean of samples × samples places in its area (`framing.samples_per_side`). A result is saturated where
    any pixel that it is made from is. Of a `part` of the image, its first row and the height of the whole, no other
    rows than those of `find_needed_rows` have to be there.
    """
    rows = (region.height if stop is None else stop) - first
    if part is None and samples == 1 and np.array_equal(matrix, np.eye(3)):
        band = np.s_[region.top + first : region.top + first + rows, region.left : region.left + region.width]
        return np.ascontiguousarray(image[band]), np.ascontiguousarray(saturated[band])
    moved = np.empty((rows, region.width, 3), np.float32)
    mask = np.empty((rows, region.width), np.bool_)
    begin, height = part if part is not None else (0, len(image))
    place = np.array([region.left, region.top + first, begin, height])
    _warp(np.ascontiguousarray(image), saturated, matrix, place, samples, moved, mask)
    return moved, mask


def find_needed_rows(
    matrix: NDArray[np.float64], region: Region, first: int, stop: int, height: int
) -> tuple[int, int]:
    """The first row of a photograph of `height`, and the one after the last, that `warp` makes of it rows [first, stop)
    of `region` by its `matrix`."""
    x = np.array([region.left - 0.5, region.left + region.width - 0.5] * 2)
    y = np.repeat([region.top + first - 0.5, region.top + stop - 0.5], 2)
    scale = matrix[2] @ np.stack([x, y, np.ones(4)])
    if scale.min() * scale.max() <= 0.0:  # the horizon runs through the rows
        return 0, height
    _, down = move_points(x, y, matrix)  # extremes of a quotient of linear functions are at corners
    low, high = math.floor(float(down.min())) - 1, math.floor(float(down.max())) + 3
    low = min(max(low, 0), height - 1)
    return low, min(max(high, low + 2), height)


def move_points(
    x: NDArray[np.number], y: NDArray[np.number], matrix: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The points (T,) of the reference in a photograph, by its `matrix` (3, 3)."""
    across, down, scale = matrix @ np.stack([x, y, np.ones(len(x))])
    return across / scale, down / scale


def sample_points(image: NDArray[np.float32], x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float32]:
    """(T, C) values of an image (H, W, C) at points, by cubic convolution, which softens less than `warp`."""
    height, width = image.shape[:2]
    column, row = np.floor(x).astype(np.int64), np.floor(y).astype(np.int64)
    found = np.zeros((len(x), image.shape[2]))
    weights = [_cubic(each - whole) for each, whole in ((y, row), (x, column))]
    for i in range(4):
        for j in range(4):
            taken = image[np.clip(row + i - 1, 0, height - 1), np.clip(column + j - 1, 0, width - 1)]
            found += (weights[0][i] * weights[1][j])[:, None] * taken
    return found.astype(np.float32)


def _cubic(t: NDArray[np.float64]) -> tuple[NDArray[np.float64], ...]:
    """Weights of the four neighbours at -1, 0, 1 and 2 of a point at t in [0, 1) (Keys1981 with a = -1/2)."""
    return (
        ((-0.5 * t + 1.0) * t - 0.5) * t,
        (1.5 * t - 2.5) * t * t + 1.0,
        ((-1.5 * t + 2.0) * t + 0.5) * t,
        (0.5 * t - 0.5) * t * t,
    )


@parallel
def _warp(
    image: np.ndarray,
    saturated: np.ndarray,
    matrix: np.ndarray,
    place: np.ndarray,
    samples: int,
    moved: np.ndarray,
    mask: np.ndarray,
) -> None:
    """Bound by the reads of four neighbours per sample.

    `place` is the first column and row of what is made, the first row of the image that is there, and its height.
    """
    left, top, begin, height = place
    width = saturated.shape[1]
    share = np.float32(1.0 / (samples * samples))
    for row in prange(moved.shape[0]):
        total = np.empty(3, np.float32)
        for column in range(moved.shape[1]):
            total[:] = 0.0
            clipped: bool | np.bool_ = False
            for sample in range(samples * samples):
                x = left + column + ((sample % samples) + 0.5) / samples - 0.5
                y = top + row + ((sample // samples) + 0.5) / samples - 0.5
                scale = 1.0 / (matrix[2, 0] * x + matrix[2, 1] * y + matrix[2, 2])
                there_x = (matrix[0, 0] * x + matrix[0, 1] * y + matrix[0, 2]) * scale
                there_y = (matrix[1, 0] * x + matrix[1, 1] * y + matrix[1, 2]) * scale
                i, j, down, across = _cell(there_y, there_x, height, width)
                i, below, beside = i - begin, min(i + 1, height - 1) - begin, min(j + 1, width - 1)
                for channel in range(3):
                    upper = _between(image[i, j, channel], image[i, beside, channel], across)
                    lower = _between(image[below, j, channel], image[below, beside, channel], across)
                    total[channel] += _between(upper, lower, down)
                clipped = (
                    clipped
                    or saturated[i, j]
                    or (across > 0 and saturated[i, beside])
                    or (down > 0 and saturated[below, j])
                    or (across > 0 and down > 0 and saturated[below, beside])
                )
            for channel in range(3):
                moved[row, column, channel] = total[channel] * share if samples > 1 else total[channel]
            mask[row, column] = clipped


@scalar
def _cell(y: float, x: float, height: int, width: int) -> tuple[int, int, np.float32, np.float32]:
    """Upper left neighbour and the fractions to the lower right one, inside the image."""
    y = min(max(y, 0.0), height - 1.0)
    x = min(max(x, 0.0), width - 1.0)
    i, j = int(y), int(x)
    return i, j, np.float32(y - i), np.float32(x - j)


@scalar
def _between(one: np.float32, other: np.float32, fraction: np.float32) -> np.float32:
    return one + fraction * (other - one)
