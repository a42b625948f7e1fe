"""Non-negative terms of a matrix, M ≈ Σ left_k value_k right_kᵀ with left, right > 0: no entry is negative.

Hierarchical alternating least squares (Cichocki2009): column by column each side is the least-squares solution, raised
to zero where it is below. Every step lowers the error, and the work is two products with M an iteration. The minimum is
a local one, so several starts are tried, the positive parts of singular vectors (Boutsidis2008) and random ones of
`seed`, and the best after a few iterations goes on. The terms of fewer are not the first of more. Bound by the products
of M with K vectors, which are taken in single precision: they are twice as quick, and the error falls by parts of a
thousand when it rests.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from engine.factor.solvers.svd import svd

Floats = NDArray[np.float64]

#: Random starts, iterations of each before one is chosen, and at most.
STARTS, TRIED, MAX_ITERATIONS = 3, 20, 400

#: The relative fall of the error over `TRIED` iterations at which it rests.
RESTS = 1e-3

#: Least value of a factor over its mean: a texel that is 0 in all terms would be black, and never leave 0.
FLOOR = 1e-9


class Nonnegative(NamedTuple):
    """Terms of falling size: `left` (m, K), `right` (n, K) with columns of unit length, `value` (K,) > 0.

    `error` is the norm of what they leave, `optimum` that of the best terms of any sign.
    """

    left: Floats
    right: Floats
    value: Floats
    error: float
    optimum: float
    iterations: int
    converged: bool


def nonnegative(matrix: Floats, terms: int, seed: int) -> Nonnegative:
    """Factor `matrix` (m, n), of which what is below 0 is taken as 0, into `terms` positive terms."""
    scale = float(np.abs(matrix).max())
    scaled = np.maximum(matrix, 0.0) / (scale or 1.0)
    squared = float((scaled**2).sum())
    signed = svd(scaled, terms, seed)
    optimum = float(np.sqrt(max(squared - float((signed.value**2).sum()), 0.0)))
    random = np.random.default_rng(seed)
    starts = [_positive_parts(signed.left, signed.value, signed.right, float(scaled.mean()))]
    size = np.sqrt(max(float(scaled.mean()), 1e-300) / terms)
    starts += [
        (
            size * random.uniform(0.5, 1.5, (len(matrix), terms)),
            size * random.uniform(0.5, 1.5, (matrix.shape[1], terms)),
        )
        for _ in range(STARTS)
    ]
    tried = _iterate(scaled, starts, TRIED)
    left, right = min(tried, key=lambda sides: _squared_error(scaled, squared, *sides))
    error, iterations, converged = _squared_error(scaled, squared, left, right), TRIED, False
    while iterations < MAX_ITERATIONS and not converged:
        [(left, right)] = _iterate(scaled, [(left, right)], TRIED)
        before, error = error, _squared_error(scaled, squared, left, right)
        iterations += TRIED
        converged = before - error <= RESTS * max(before, 1e-14 * squared)
    lengths = np.linalg.norm(left, axis=0), np.linalg.norm(right, axis=0)
    value = lengths[0] * lengths[1]
    order = np.argsort(-value, kind="stable")
    return Nonnegative(
        (left / lengths[0])[:, order],
        (right / lengths[1])[:, order],
        scale * value[order],
        scale * float(np.sqrt(max(error, 0.0))),
        scale * optimum,
        iterations,
        converged,
    )


def _positive_parts(left: Floats, value: Floats, right: Floats, mean: float) -> tuple[Floats, Floats]:
    """Of each singular pair the positive or the negative parts, whichever are larger, and a little everywhere."""
    sides = np.empty_like(left), np.empty_like(right)
    for k in range(len(value)):
        parts = [(np.maximum(sign * left[:, k], 0.0), np.maximum(sign * right[:, k], 0.0)) for sign in (1.0, -1.0)]
        one, other = max(parts, key=lambda pair: float(np.linalg.norm(pair[0]) * np.linalg.norm(pair[1])))
        sides[0][:, k], sides[1][:, k] = np.sqrt(value[k]) * one, np.sqrt(value[k]) * other
    little = 1e-3 * np.sqrt(max(mean, 1e-300))
    return sides[0] + little, sides[1] + little


#: Both sides of some terms, (m, K) and (n, K).
Sides = tuple[Floats, Floats]


def _iterate(matrix: Floats, starts: Sequence[Sides], iterations: int) -> list[Sides]:
    """Iterate from each of `starts`; products with `matrix`, which is read from memory, are those of all at once."""
    lefts, rights = ([side.copy() for side in sides] for sides in zip(*starts, strict=True))
    single = matrix.astype(np.float32)
    for _ in range(iterations):
        for sides, others, whole in ((lefts, rights, single), (rights, lefts, single.T)):
            products = np.split(whole @ np.hstack(others).astype(np.float32), len(others), axis=1)
            for side, other, along in zip(sides, others, products, strict=True):
                gram = other.T @ other
                for k in range(side.shape[1]):
                    found = side[:, k] + (along[:, k] - side @ gram[:, k]) / max(gram[k, k], 1e-300)
                    side[:, k] = np.maximum(found, FLOOR * max(float(np.abs(found).mean()), 1e-300))
    return list(zip(lefts, rights, strict=True))


def _squared_error(matrix: Floats, squared: float, left: Floats, right: Floats) -> float:
    along = float(((matrix @ right) * left).sum())
    return max(squared - 2.0 * along + float(((left.T @ left) * (right.T @ right)).sum()), 0.0)
