"""One way to evaluate a formula at many pairs of directions: in blocks that stay in the cache, on all threads.

A model states its formula for arrays of components, (3, n) for each side; this file broadcasts, cuts, sets what is
at or below the horizon to 0 and puts the blocks together. Each block is one pass over a few hundred kilobytes, so a
formula costs its arithmetic and not the memory's; numpy releases the interpreter lock inside a block. The result does
not depend on the number of threads, because no block knows of another.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.directions import Vectors

Floats = NDArray[np.float64]

#: Pairs of directions per block.
BLOCK = 8192

#: A cosine up to this counts as the horizon: below it the squares and fourth powers of cosines leave float64.
HORIZON = 1e-30

_NORMAL = np.array([[0.0], [0.0], [1.0]])


def evaluate(formula: Callable[[Floats, Floats], Floats], wi: ArrayLike, wo: ArrayLike) -> Vectors:
    """Values (..., 3) of `formula` for directions (..., 3) that broadcast, 0 where either is not above the horizon.

    `formula(wi, wo)` gets components (3, n), float64, all above the horizon, and returns something that broadcasts to
    (3, n), a row per channel.
    """
    wi, wo = np.broadcast_arrays(np.asarray(wi, np.float64), np.asarray(wo, np.float64))
    shape = wi.shape
    wi, wo = wi.reshape(-1, 3), wo.reshape(-1, 3)
    result = np.empty((len(wi), 3))

    def fill(start: int) -> None:
        block = slice(start, start + BLOCK)
        incident, outgoing = wi[block].T.copy(), wo[block].T.copy()
        visible = (incident[2] > HORIZON) & (outgoing[2] > HORIZON)
        if visible.all():
            result[block] = np.broadcast_to(formula(incident, outgoing), incident.shape).T
            return
        incident, outgoing = np.where(visible, incident, _NORMAL), np.where(visible, outgoing, _NORMAL)
        result[block] = np.where(visible, formula(incident, outgoing), 0.0).T

    starts = range(0, len(wi), BLOCK)
    if len(starts) < 2:
        for start in starts:
            fill(start)
    else:
        with ThreadPoolExecutor(min(len(starts), os.cpu_count() or 1)) as pool:
            list(pool.map(fill, starts))
    return result.reshape(shape)


def channels(colour: tuple[float, float, float]) -> Floats:
    """A colour as a column (3, 1), to be multiplied with rows of n values."""
    return np.array(colour)[:, None]
