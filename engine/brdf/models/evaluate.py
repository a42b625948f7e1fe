"""One way to evaluate a formula at many pairs of directions: in blocks that stay in the cache, on all threads.

A model states its formula for arrays of components, (3, n) for each side; this file broadcasts, cuts, sets what is
at or below the horizon to 0 and puts the blocks together. Each block is one pass over a few hundred kilobytes, so a
formula costs its arithmetic and not the memory's; numpy releases the interpreter lock inside a block. The result does
not depend on the number of threads, because no block knows of another.

Terms shared by several models: a power of a cosine near 1, a stable half vector, Schlick's Fresnel term.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.core.budget import thread_count
from engine.core.directions import Vectors
from engine.core.params import Colour

Floats = NDArray[np.float64]

#: Pairs of directions per block.
BLOCK = 8192

#: Blocks from which on it pays to start threads.
MANY = 4

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
    if len(starts) < MANY:
        for start in starts:
            fill(start)
    else:
        with ThreadPoolExecutor(min(len(starts), thread_count())) as pool:
            list(pool.map(fill, starts))
    return result.reshape(shape)


def channels(colour: tuple[float, float, float]) -> Floats:
    """A colour as a column (3, 1), to be multiplied with rows of n values."""
    return np.array(colour)[:, None]


def diffuse_and_highlight(kd: Colour, ks: Colour, highlight: Floats) -> Floats:
    """kd/π + ks · highlight, (3, n) for (n,)."""
    return channels(kd) / np.pi + channels(ks) * highlight


def reflects_no_more_than_it_receives(kd: Colour, ks: Colour) -> bool:
    """True if a diffuse part of albedo kd and a highlight of albedo up to ks stay within 1 in every channel."""
    return all(diffuse + specular <= 1.0 for diffuse, specular in zip(kd, ks, strict=True))


def power_of_one_minus(deficit: Floats, exponent: float | Floats) -> Floats:
    """max(0, 1 − deficit)^exponent for deficit >= 0, with 0⁰ = 1; `exponent` is a number or broadcasts.

    The cosine c near 1 is what matters at high exponents, and there 1 − c is known far better than c where it comes
    from differences of components; so the power is exp(n log1p(−(1 − c))), whose relative error stays near
    (2 + n |ln c|) u. Below c = 1/2, where a high power is next to nothing, n u/c is added.
    """
    positive = deficit < 1.0
    power = np.exp(exponent * np.log1p(-np.where(positive, deficit, 0.0)))
    return np.where(positive | (np.asarray(exponent) == 0.0), power, 0.0)


def sum_of_directions(wi: Floats, wo: Floats) -> tuple[Floats, Floats, Floats]:
    """H = wi + wo (3, n), its length, and 1 − n·h, which is across²/(|H| (|H| + H_z)) without cancellation."""
    both = wi + wo
    across = both[0] ** 2 + both[1] ** 2
    length = np.sqrt(across + both[2] ** 2)
    return both, length, across / (length * (length + both[2]))


def schlick(wi: Floats, wo: Floats, length: Floats) -> Floats:
    """(1 − h·wi)⁵ for |wi + wo| = length.

    h·wi is |wi + wo|/2 for unit vectors, which does not change when they are exchanged, and 1 − h·wi is
    |wi − wo|²/(2 (2 + |wi + wo|)), which is exact at both ends.
    """
    difference = wi - wo
    squared = difference[0] ** 2 + difference[1] ** 2 + difference[2] ** 2
    grazing = np.minimum(squared / (2.0 * (2.0 + length)), 1.0)
    return (grazing * grazing) ** 2 * grazing
