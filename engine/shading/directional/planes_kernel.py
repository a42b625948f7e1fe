"""Kernels that round the values of planes, to sixteen bits until their ranges are known and then to eight, and that
show planes under lights.

Pieces are worked through on several threads side by side.
"""

from __future__ import annotations

import numpy as np

from engine.core.kernels import scalar

#: Sums that are taken side by side, as one alone would wait for each addition.
_LANES = 8


@scalar
def shorten_values(
    values: np.ndarray, inside: np.ndarray, low: np.ndarray, step: np.ndarray, codes: np.ndarray
) -> None:
    """Write `values` (K, rows, W) float32 into `codes` (K, rows, W) uint16, as the nearest code of low + step · code.

    `low` and `step` (K, rows, 2) float32 are those of the texels `inside` (rows, W) of a row, and of the others; all
    values lie within the codes. Bound by memory.
    """
    bright = np.float32(65535.0)
    for plane in range(values.shape[0]):
        for row in range(values.shape[1]):
            line, into, counts = values[plane, row], codes[plane, row], inside[row]
            least, by = low[plane, row], step[plane, row]
            for at in range(values.shape[2]):
                kind = 0 if counts[at] else 1
                into[at] = np.uint16(min(np.rint((line[at] - least[kind]) / by[kind]), bright))


@scalar
def round_values(
    codes: np.ndarray,
    low_of_row: np.ndarray,
    step_of_row: np.ndarray,
    first: int,
    low: np.ndarray,
    step: np.ndarray,
    inside: np.ndarray,
    planes: np.ndarray,
    squares: np.ndarray,
) -> None:
    """Write values, which `shorten_values` has made `codes` (K, rows, W), into the rows from `first` on of `planes`
    (K, H, W) uint8, as the nearest code of low + step · code, from 0 to 255; `low` and `step` (K,) are float32.

    `squares` (K,) float64 is filled with the sums over texels `inside` (H, W) of the squares of what that changes, in
    steps, and of what codes change on average, a twelfth of the square of their step. Bound by memory: 1 ns for each
    value on one core.
    """
    count, rows, width = codes.shape
    dark, bright, lanes = np.float32(0.0), np.float32(255.0), np.empty(_LANES)
    apart = np.empty(width, np.float32)
    for plane in range(count):
        lanes[:] = 0.0
        for row in range(rows):
            line, into, counts = codes[plane, row], planes[plane, first + row], inside[first + row]
            least, by, number = low_of_row[plane, row], step_of_row[plane, row], 0
            for at in range(width):
                kind = 0 if counts[at] else 1
                number += counts[at]
                value = (least[kind] + by[kind] * np.float32(line[at]) - low[plane]) / step[plane]
                code = min(max(np.rint(value), dark), bright)
                into[at] = np.uint8(code)
                apart[at] = code - value if counts[at] else dark
            whole = width - width % _LANES
            for at in range(0, whole, _LANES):
                for lane in range(_LANES):
                    lanes[lane] += np.float64(apart[at + lane]) ** 2
            for at in range(whole, width):
                lanes[0] += np.float64(apart[at]) ** 2
            lanes[0] += number * np.float64(by[0] / step[plane]) ** 2 / 12.0
        squares[plane] = lanes.sum()


@scalar
def add_planes(planes: np.ndarray, functions: np.ndarray, shares: np.ndarray, values: np.ndarray) -> None:
    """Write what `planes` (K, T) show under the lights of `functions` (L, 3, 1 + K), coded as sRGB: its `shares`
    (L, T, 3) of white, and `values`, whose powers of 2.4 are linear where a share is not too dark.

    All are float64. Bound by arithmetic: K products a value.
    """
    count, texels = planes.shape
    codes = np.empty(texels)
    for light in range(len(functions)):
        for channel in range(3):
            weights = functions[light, channel]
            codes[:] = 0.0
            for plane in range(count):
                weight = weights[1 + plane]
                for texel in range(texels):
                    codes[texel] += weight * planes[plane, texel]
            for texel in range(texels):
                share = max(weights[0] + codes[texel], 0.0) / 255.0
                shares[light, texel, channel] = share
                values[light, texel, channel] = (max(share, 0.04045) + 0.055) / 1.055


@scalar
def choose_branches(shares: np.ndarray, strength: np.ndarray, values: np.ndarray) -> None:
    """Make the powers `values` (L, T, 3) radiance under lights of a `strength` (L,) each: that of dark `shares` is in
    proportion to them (`engine.core.colour.srgb_decode`).

    Bound by memory.
    """
    for light in range(len(values)):
        for texel in range(values.shape[1]):
            for channel in range(3):
                share = shares[light, texel, channel]
                value = share / 12.92 if share <= 0.04045 else values[light, texel, channel]
                values[light, texel, channel] = strength[light] * value
