"""Compiled loops that put numbers together from the bytes of a packed block, in one pass over memory each.

Bytes are grouped: the lower bytes of all 16-bit numbers, then the higher ones; the lowest bit of a number is its sign.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from engine.core.kernels import scalar

Bytes = NDArray[np.uint8]


@scalar
def number_at(content: Bytes, index: int, count: int) -> np.int64:
    """Number `index` of `count` in `content` (2 count,)."""
    value = np.int64(content[index]) | np.int64(content[count + index]) << 8
    return (value >> 1) ^ -(value & 1)


@scalar
def add_differences(content: Bytes, target: NDArray[np.uint16]) -> None:
    """Fill `target` (N,) with the running sums, modulo 2^16, of the numbers in `content` (2 N,)."""
    total = np.int64(0)
    for n in range(len(target)):
        total += number_at(content, n, len(target))
        target[n] = np.uint16(total & 0xFFFF)


@scalar
def join_fields(content: Bytes, first: int, second: int, third: int, target: NDArray[np.uint32]) -> None:
    """Fill `target` (N,) with words of fields, of which `content` (6 N,) holds three numbers each.

    They are shifted to the left by `first`, `second` and `third` bits, from 0 to 15: the field in bits 0–10, the one in
    11–21 less that, and the one in 22–31 less half of it, rounded down.
    """
    size = len(target)
    for n in range(size):
        red = number_at(content, n, 3 * size) << first
        green = (number_at(content, size + n, 3 * size) << second) + red
        blue = (number_at(content, 2 * size + n, 3 * size) << third) + (red >> 1)
        target[n] = np.uint32((red & 0x7FF) | (green & 0x7FF) << 11 | (blue & 0x3FF) << 22)


@scalar
def scale(content: Bytes, factor: float, target: NDArray[np.float32]) -> None:
    """Fill `target` (N,) with the numbers in `content` (2 N,) times `factor`, a power of two."""
    for n in range(len(target)):
        target[n] = np.float32(number_at(content, n, len(target)) * factor)
