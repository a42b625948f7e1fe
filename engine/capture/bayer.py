"""Bayer mosaics to linear colour in one pass: levels, saturation, interpolation and colour matrix.

Malvar, He and Cutler 2004, "High-quality linear interpolation for demosaicing of Bayer-patterned color images", figure
2. The filters are linear and samples keep their sign, so noise that averages to black still does after them. Beyond
the edges the mosaic is mirrored about its outermost rows and columns, which keeps the pattern.

Cost: bound by arithmetic, 10 ns per pixel on one thread; besides its result it needs memory for five rows only.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from engine.kernels import scalar

_HALF, _TWO, _FOUR, _FIVE, _SIX = (np.float32(value) for value in (0.5, 2, 4, 5, 6))
_SIDE, _EIGHTH = np.float32(1.5), np.float32(0.125)


def is_bayer(colours: NDArray[np.integer]) -> bool:
    """True for a 2×2 array of 0, 1, 2 (red, green, blue) with two greens on a diagonal."""
    if colours.shape != (2, 2) or sorted(colours.ravel()) != [0, 1, 1, 2]:
        return False
    return bool(colours[0, 0] == colours[1, 1] == 1 or colours[0, 1] == colours[1, 0] == 1)


@scalar
def develop(samples, black, scale, white, colours, matrix, radiance, saturated):  # type: ignore[no-untyped-def]
    """Fill `radiance` (H, W, 3) and `saturated` (H, W) from `samples` (H, W), integers or floats, H and W ≥ 3.

    A sample s of the site (i, j) stands for (s - black[i, j]) scale[i, j] of the colour colours[i, j]; it is saturated
    from white[i, j] on, and so is every pixel within two steps of it, which it enters. `matrix` (3, 3) float32 takes
    the camera's colours to those of the result. Tables are (2, 2) and repeat from row 0, column 0.
    """
    height, width = samples.shape
    lines = np.empty((5, width + 4), np.float32)
    clipped = np.empty((5, width + 4), np.bool_)
    any_clipped = np.zeros(5, np.bool_)
    for row in range(-2, height + 2):
        slot = (row + 2) % 5
        any_clipped[slot] = _read(samples, _mirrored(row, height), black, scale, white, lines[slot], clipped[slot])
        if row >= 2:
            at = row - 2
            a, b, c, d, e = at % 5, (at + 1) % 5, (at + 2) % 5, (at + 3) % 5, (at + 4) % 5
            _interpolate(lines[a], lines[b], lines[c], lines[d], lines[e], colours[at % 2], colours[1 - at % 2],
                         matrix, radiance[at])  # fmt: skip
            if any_clipped.any():
                _spread(clipped[a], clipped[b], clipped[c], clipped[d], clipped[e], saturated[at])
            else:
                saturated[at, :] = False


@scalar
def _mirrored(place, size):  # type: ignore[no-untyped-def]
    return abs(place) if place < size else 2 * (size - 1) - place


@scalar
def _read(samples, row, black, scale, white, line, clipped):  # type: ignore[no-untyped-def]
    """Linear values of one row with two mirrored ones at either end, and whether any is saturated."""
    width = samples.shape[1]
    some = False
    for parity in range(2):
        dark, gain, full = black[row % 2, parity], scale[row % 2, parity], white[row % 2, parity]
        for column in range(parity, width, 2):
            sample = samples[row, column]
            line[column + 2] = np.float32((sample - dark) * gain)
            clipped[column + 2] = sample >= full
            some = some or clipped[column + 2]
    for beyond in range(1, 3):
        line[2 - beyond], line[width + 1 + beyond] = line[2 + beyond], line[width + 1 - beyond]
        clipped[2 - beyond], clipped[width + 1 + beyond] = clipped[2 + beyond], clipped[width + 1 - beyond]
    return some


@scalar
def _interpolate(a, b, c, d, e, own, other, matrix, result):  # type: ignore[no-untyped-def]
    """One row of the result from its own row `c` and the two above and below; `own`, `other`: colours of the rows."""
    width = result.shape[0]
    for parity in range(2):
        colour, beside, across = own[parity], own[1 - parity], other[parity]
        red, green, blue = (beside, colour, across) if colour == 1 else (colour, 1, 2 - colour)
        m = matrix
        for column in range(parity, width, 2):
            x = column + 2
            middle = c[x]
            near_row, near_column = c[x - 1] + c[x + 1], b[x] + d[x]
            far_row, far_column = c[x - 2] + c[x + 2], a[x] + e[x]
            diagonal = b[x - 1] + b[x + 1] + d[x - 1] + d[x + 1]
            if colour == 1:
                first = (_FIVE * middle + _FOUR * near_row - diagonal - far_row + _HALF * far_column) * _EIGHTH
                second = middle
                third = (_FIVE * middle + _FOUR * near_column - diagonal - far_column + _HALF * far_row) * _EIGHTH
            else:
                first = middle
                second = (_FOUR * middle + _TWO * (near_row + near_column) - far_row - far_column) * _EIGHTH
                third = (_SIX * middle + _TWO * diagonal - _SIDE * (far_row + far_column)) * _EIGHTH
            for channel in range(3):
                result[column, channel] = (
                    m[channel, red] * first + m[channel, green] * second + m[channel, blue] * third
                )


@scalar
def _spread(a, b, c, d, e, result):  # type: ignore[no-untyped-def]
    for column in range(result.shape[0]):
        x = column + 2
        near = b[x - 1] or b[x] or b[x + 1] or d[x - 1] or d[x] or d[x + 1] or c[x - 1] or c[x] or c[x + 1]
        result[column] = near or c[x - 2] or c[x + 2] or a[x] or e[x]
