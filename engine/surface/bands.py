"""Filters of maps in bands of rows, with as many rows around them as can reach a texel.

scipy filters the columns of a map a few at a time, and each of them lies in all pages of the map. A map that is larger
than the memory left would be read from the disk for each few columns again. Bands stay in the cache of the CPU, and
texels are the same bits.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

#: Rows of a band.
BAND = 64


def smooth(values: NDArray[Any], deviation: float) -> NDArray[np.floating]:
    """(H, W) filtered by a Gaussian of `deviation` in texels, which ends at four of them; the border is repeated."""
    return np.asarray(ndimage.gaussian_filter(values, deviation, mode="nearest"))


def filter_in_bands(
    work: Callable[..., NDArray[np.floating]], around: int, *maps: NDArray[np.generic]
) -> NDArray[np.floating]:
    """`work` of `maps` (H, …) band by band: a map (H, …) each row of which depends on rows at most `around` away."""
    height = len(maps[0])
    found = None
    for band, rows, inner in list_bands(height, around):
        of_band = work(*(each[rows] for each in maps))
        found = np.empty((height, *of_band.shape[1:]), of_band.dtype) if found is None else found
        found[band] = of_band[inner]
    assert found is not None
    return found


def list_bands(height: int, around: int) -> Iterator[tuple[slice, slice, slice]]:
    """Rows of each band, those at most `around` away from it, and the place of the first in the second."""
    for first in range(0, height, BAND):
        last, top = min(first + BAND, height), max(first - around, 0)
        yield slice(first, last), slice(top, min(last + around, height)), slice(first - top, last - top)
