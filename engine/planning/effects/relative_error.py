"""Relative error of a sample of an image, raised by what so few pairs of point and view leave unknown."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: Standard errors that are added to an estimate, and the least and the most that they raise it by.
MARGIN, MINIMUM, MAXIMUM = 1.0, 1.2, 1.6

#: An error of less than this is rounding.
ROUNDING = 1e-9


def relative_error(
    values: Array,
    wanted: Array,
    shares: Sequence[Array],
    *,
    difference: Array | None = None,
    margin: bool = True,
    least: float = MINIMUM,
) -> float:
    """The root mean square of `values` − `wanted` (N, K, 3) over that of `wanted`, with its margin, `least` or more.

    Pairs count for `shares` (N, K), of which the one with the largest error is reported.

    `difference` (N, K) may hold the squares of the differences instead, where their noise has been taken off.
    """
    apart = ((values - wanted) ** 2).sum(axis=-1) if difference is None else difference
    whole = (wanted**2).sum(axis=-1)
    return max(with_margin((apart * w).sum(axis=1), (whole * w).sum(axis=1), margin, least) for w in shares)


def with_margin(apart: Array, whole: Array, margin: bool, least: float = MINIMUM) -> float:
    """The root of Σ apart / Σ whole over points, raised by the standard error of that ratio."""
    total, count = float(whole.sum()), len(whole)
    if total <= 0.0:
        return 0.0
    ratio = max(float(apart.sum()), 0.0) / total
    if ratio < ROUNDING**2:
        return 0.0
    if not margin:
        return math.sqrt(ratio)
    spread = math.sqrt(count / max(count - 1, 1) * float(((apart - ratio * whole) ** 2).sum())) / total
    raised = math.sqrt(ratio + MARGIN * spread) / math.sqrt(ratio)
    return math.sqrt(ratio) * min(max(raised, least), MAXIMUM)
