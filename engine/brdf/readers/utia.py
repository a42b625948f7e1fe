"""UTIA BRDF files (Filip and Vávra 2014), the binary form `.bin`: anisotropic, every 15° and 7.5°.

3 planes R, G, B of 288 × 288 little-endian float64 without a header: a row for each direction of the light, a column
for each direction of view, both counted with theta (0, 15 … 75°) outermost and phi (0, 7.5 … 352.5°) innermost.
Values are in sr⁻¹ without the cosine, RGB is taken as linear sRGB. A direction pair where any channel is negative is
missing: counted, and filled by the rule of `engine.brdf.table`. Beyond 75° `DirectionTable` goes on along a line.
"""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from engine.brdf.table import LARGEST, DirectionTable, fill_holes, missing_health
from engine.core.errors import InputError
from engine.storage.untrusted import AGAIN, read_bytes, read_head

THETA = np.radians(15.0 * np.arange(6))
PHI = np.radians(7.5 * np.arange(48))

_SHAPE = (len(THETA), len(PHI), len(THETA), len(PHI))
_DIRECTIONS = len(THETA) * len(PHI)
SIZE_BYTES = 3 * 8 * _DIRECTIONS**2

#: Bytes swapped turn numbers near 1 into ones near 1e-300, or beyond any reflectance.
_SWAPPED_BELOW = 1e-30


def looks_like_utia(head: bytes, size_bytes: int, name: str) -> bool:
    """The exact size, as there is no header; a `.bin` of another size is refused by the reader with the reason."""
    return size_bytes == SIZE_BYTES or (name.lower().endswith(".bin") and not head.isascii())


def read_utia(path: str | os.PathLike[str]) -> DirectionTable:
    """The table in a UTIA file; InputError for another size, bytes swapped, NaN, or nothing measured."""
    _check_size(path, read_head(path, 1)[1])
    content = read_bytes(path, SIZE_BYTES)
    _check_size(path, len(content))
    planes = np.frombuffer(content, "<f8")
    if not _plausible(planes):
        if _plausible(planes.byteswap()):
            raise InputError(path, "looks big-endian: its bytes are swapped", "Convert it to little-endian float64")
        raise InputError(path, "holds values that are not numbers, or absurdly large", AGAIN)
    planes = planes.reshape(3, *_SHAPE)
    missing = np.any(planes < 0.0, axis=0)
    if missing.all():
        raise InputError(path, "holds only negative entries, so that nothing was measured", AGAIN)
    values = np.ascontiguousarray(np.moveaxis(planes, 0, -1))
    rows = (_DIRECTIONS, len(THETA), len(PHI))
    fill_holes(values.reshape(*rows, 3), missing.reshape(rows))
    health = missing_health(missing)
    return DirectionTable(THETA, PHI, THETA, PHI, values, missing, Path(path).stem, "UTIA table", health)


def _check_size(path: str | os.PathLike[str], size_bytes: int) -> None:
    if size_bytes != SIZE_BYTES:
        problem = f"has {size_bytes:,} bytes where a UTIA table has {SIZE_BYTES:,}"
        raise InputError(path, problem, "Give a binary UTIA file of 288 × 288 directions as published")


def _plausible(numbers: np.ndarray) -> bool:
    """True if all are finite, none is absurd, and they are not all next to nothing."""
    largest = np.abs(numbers).max()
    return bool(largest <= LARGEST and (largest >= _SWAPPED_BELOW or not numbers.any()))
