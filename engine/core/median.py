"""The median of several arrays together, without one array that holds them all.

Of arrays that are read once, all but the numbers near the median are only counted: those between two quantiles of a
grid of samples are sorted. Where the median lies beyond these, or something is not a number, all are sorted.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.core.side_by_side import list_side_by_side

#: Every so many rows and columns there is a sample, and the quantiles between which numbers are sorted.
STEP, QUANTILES = 8, (0.49, 0.51)


def find_median(arrays: Sequence[NDArray[np.floating[Any]]]) -> float:
    """The median of all numbers of `arrays`, the bits of `np.median` of them in one array."""
    grid = np.concatenate([each[tuple([slice(None, None, STEP)] * each.ndim)].ravel() for each in arrays])
    low, high = (np.quantile(grid, at, method="nearest") for at in QUANTILES)

    def count(array: NDArray[np.floating[Any]]) -> tuple[int, NDArray[np.floating[Any]], int]:
        near = array[(array >= low) & (array <= high)]
        return int(np.count_nonzero(array < low)), near, int(np.count_nonzero(array > high))

    counts = list_side_by_side(count, arrays)
    below, above = sum(each[0] for each in counts), sum(each[2] for each in counts)
    near, total = np.concatenate([each[1] for each in counts]), sum(each.size for each in arrays)
    middle = (total - 1) // 2 - below, total // 2 - below
    if below + len(near) + above != total or middle[0] < 0 or middle[1] >= len(near):
        return float(np.median(np.concatenate([each.ravel() for each in arrays])))
    return float(np.mean(np.partition(near, middle)[list(middle)]))
