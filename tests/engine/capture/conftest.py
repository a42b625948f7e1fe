"""A small DNG writer, independent of the program's own."""

import io
from collections.abc import Callable

import numpy as np
import pytest
import tifffile

XYZ_FROM_SRGB = np.array(
    [[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750], [0.0193339, 0.119192, 0.9503041]]
)


def _dng(
    mosaic: np.ndarray,
    *,
    black: tuple[int, int, int, int] = (64, 64, 64, 64),
    white: int = 4095,
    colours: tuple[int, int, int, int] = (0, 1, 1, 2),
    neutral: tuple[tuple[int, int], ...] = ((1, 1), (1, 1), (1, 1)),
    camera_from_xyz: np.ndarray | None = None,
    orientation: int = 1,
    exposure: tuple[int, int] | None = None,
    compression: str | None = None,
) -> bytes:
    """A DNG 1.4 of a 2×2 mosaic (uint16), in strips of 16 rows."""
    matrix = np.linalg.inv(XYZ_FROM_SRGB) if camera_from_xyz is None else camera_from_xyz
    tags = [
        (271, "s", 0, "Test"),
        (272, "s", 0, "Test Camera"),
        (274, "H", 1, orientation),
        (33421, "H", 2, (2, 2)),
        (33422, "B", 4, colours),
        (50706, "B", 4, (1, 4, 0, 0)),
        (50708, "s", 0, "Test Camera"),
        (50713, "H", 2, (2, 2)),
        (50714, "I", 4, black),
        (50717, "I", 1, white),
        (50721, "2i", 9, tuple(value for entry in matrix.ravel() for value in (round(entry * 10000), 10000))),
        (50728, "2I", 3, tuple(value for pair in neutral for value in pair)),
        (50778, "H", 1, 21),
    ]
    if exposure is not None:
        tags.append((33434, "2I", 1, exposure))
    stream = io.BytesIO()
    tifffile.imwrite(
        stream, mosaic, photometric=32803, extratags=tags, metadata=None, rowsperstrip=16, compression=compression
    )
    return stream.getvalue()


@pytest.fixture(scope="session")
def dng() -> Callable[..., bytes]:
    return _dng
