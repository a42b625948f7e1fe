"""MERL BRDF files (Matusik2003): 90 × 90 × 180 bins of half and difference angles, read and written.

Files of other numbers of bins, on the same scales, are read too. Three little-endian int32 (90, 90, 180), then the
planes R, G, B as float64, theta_h outermost, phi_d innermost. An entry times 1/1500, 1.15/1500, 1.66/1500 is in sr⁻¹.
theta_h lies on a square-root scale, phi_d in [0, π). A bin where any channel is negative is missing: it is counted and
filled (`engine.brdf.table`), and never used as a number. RGB is taken as linear sRGB. What was read is written again
byte for byte; values of other origin come back from the file within one unit in the last place of float64 (the scales
have no exact inverse), and missing bins are written as −1.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from engine.brdf.brdf import Brdf
from engine.brdf.resample import table_from
from engine.brdf.table import LARGEST, HalfDifferenceTable, fill_holes, missing_health
from engine.core.errors import InputError
from engine.storage.atomic import atomic_file
from engine.storage.untrusted import AGAIN, FILE_LIMIT_BYTES, read_bytes, read_head

SHAPE = (90, 90, 180)
SCALE = (1.0 / 1500.0, 1.15 / 1500.0, 1.66 / 1500.0)

_HEADER = np.array(SHAPE, "<i4").tobytes()
SIZE_BYTES = len(_HEADER) + 3 * 8 * int(np.prod(SHAPE))

#: Fewest and most bins of an angle.
_FEWEST, _MOST = 4, 2048


def looks_like_merl(head: bytes, size_bytes: int, name: str) -> bool:
    """Its header, also with bytes swapped, its exact size, or its customary name where the content is not text."""
    swapped = np.array(SHAPE, ">i4").tobytes()
    return (
        head[:12] in (_HEADER, swapped)
        or size_bytes in (SIZE_BYTES, _size_bytes(_dimensions(head)))
        or (name.lower().endswith(".binary") and (b"\0" in head or not head.isascii()))
    )


def _dimensions(head: bytes) -> tuple[int, ...]:
    return tuple(int(number) for number in np.frombuffer(head[: len(head) // 4 * 4][:12], "<i4"))


def _size_bytes(dimensions: tuple[int, ...]) -> int:
    """Bytes of a file of so many bins; −1 for numbers that no file has."""
    if len(dimensions) < 3 or not all(_FEWEST <= each <= _MOST for each in dimensions):
        return -1
    return len(_HEADER) + 3 * 8 * int(np.prod(dimensions))


def read_merl(path: str | os.PathLike[str]) -> HalfDifferenceTable:
    """The table in a MERL file; InputError for any other header or size, bytes swapped, NaN, or nothing measured."""
    _check_header(path, *read_head(path, 12))
    content = read_bytes(path, FILE_LIMIT_BYTES)
    _check_header(path, content[:12], len(content))
    shape = _dimensions(content)
    planes = np.frombuffer(content, "<f8", offset=12).reshape(3, *shape)
    values = np.empty((*shape, 3))
    with np.errstate(all="ignore"):
        for c in range(3):
            np.multiply(planes[c], SCALE[c], out=values[..., c])
    if not (values.max() <= LARGEST and values.min() >= -LARGEST):
        raise InputError(path, "holds values that are not numbers, or absurdly large", AGAIN)
    missing = np.any(planes < 0.0, axis=0)
    if missing.all():
        raise InputError(path, "holds only negative entries, which mean that nothing was measured", AGAIN)
    fill_holes(values, missing)
    return HalfDifferenceTable(values, missing, Path(path).stem, "MERL table", missing_health(missing), planes)


def _check_header(path: str | os.PathLike[str], head: bytes, size_bytes: int) -> None:
    if len(head) < 12:
        raise InputError(path, f"has only {len(head)} bytes, too few for a MERL table", AGAIN)
    dimensions = _dimensions(head)
    if tuple(int(n) for n in np.frombuffer(head, ">i4", 3)) == SHAPE:
        raise InputError(path, "looks big-endian: its bytes are swapped", "Convert it to little-endian MERL data")
    shown = " × ".join(map(str, dimensions))
    wanted = _size_bytes(dimensions)
    if wanted < 0:
        raise InputError(
            path, f"states {shown} bins where a MERL table has 90 × 90 × 180", "Give a MERL file as published"
        )
    if size_bytes != wanted:
        raise InputError(path, f"has {size_bytes:,} bytes where a MERL table has {wanted:,}", AGAIN)


def write_merl(path: str | os.PathLike[str], brdf: Brdf) -> HalfDifferenceTable:
    """Write `brdf` as a MERL file and return the table that stands in it.

    A table of MERL's shape is written as it is; everything else is sampled at the centres of MERL's bins by
    `table_from`, whose health tells the error, and the average where the BRDF is anisotropic or not reciprocal.

    Raises OutputError where the file cannot be written.
    """
    table = brdf if isinstance(brdf, HalfDifferenceTable) and brdf.missing.shape == SHAPE else table_from(brdf, SHAPE)
    planes = _planes(table)
    with atomic_file(path, SIZE_BYTES) as output:
        for content in _contents(planes):
            output.write(content)
    return replace(table, planes=planes)


def encode_merl(table: HalfDifferenceTable) -> bytes:
    """The content of the file that `write_merl` writes of a table of MERL's shape; ValueError for any other."""
    if table.missing.shape != SHAPE:
        raise ValueError(f"a table of {table.missing.shape} is not MERL's {SHAPE}")
    return b"".join(_contents(_planes(table)))


def _contents(planes: NDArray[np.float64]) -> Iterator[bytes]:
    """The header, and one plane after the other."""
    yield _HEADER
    for plane in planes:
        yield plane.astype("<f8", copy=False).tobytes()


def _planes(table: HalfDifferenceTable) -> NDArray[np.float64]:
    """(3, 90, 90, 180): those that the table was read from, if they are still its values; else the nearest."""
    if table.planes is not None and _says(table.planes, table):
        return table.planes
    planes = np.empty((3, *SHAPE))
    for c, scale in enumerate(SCALE):
        wanted = table.values[..., c].astype(np.float64)
        found = wanted / scale
        for towards in (np.inf, 0.0):
            neighbour = np.nextafter(found, towards)
            better = np.abs(neighbour * scale - wanted) < np.abs(found * scale - wanted)
            found = np.where(better, neighbour, found)
        planes[c] = np.where(table.missing, -1.0, found)
    return planes


def _says(planes: NDArray[np.float64], table: HalfDifferenceTable) -> bool:
    """True if `planes` hold the same as `table`: the same bins missing, and the same values in all others."""
    return np.array_equal(np.any(planes < 0.0, axis=0), table.missing) and all(
        np.all((planes[c] * SCALE[c] == table.values[..., c]) | table.missing) for c in range(3)
    )
