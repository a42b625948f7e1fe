"""Rotations of four dimensions as pairs of unit quaternions (Cole2002 Sec. 2.3.1), and their powers.

A quaternion is an array (4,): w, x, y, z. The pair (S, T) turns v into S v T, and

    R1 R2 = (S1 S2, T2 T1),      R^t = (S^t, T^t),      (S, T) = (−S, −T),      (−S, T) = −(S, T).

So the signs of a pair are only ever changed together. A power goes by q = (cos θ, a sin θ) ↦ (cos tθ, a sin tθ) with
θ = atan2(|v|, w), which keeps its digits near q = 1 and q = −1, where acos has none. At −1 every axis would do, and x
is taken; `polar` says so.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Quaternion = NDArray[np.float64]

ONE = np.array([1.0, 0.0, 0.0, 0.0])


class Pair(NamedTuple):
    """The rotation v ↦ S v T by two unit quaternions (4,)."""

    s: Quaternion
    t: Quaternion


IDENTITY = Pair(ONE, ONE)

#: The six directions of movement that the search starts with: the three turns of either side.
BASIS = (
    *(Pair(np.eye(4)[axis], ONE) for axis in (1, 2, 3)),
    *(Pair(ONE, np.eye(4)[axis]) for axis in (1, 2, 3)),
)


class Polar(NamedTuple):
    """Angle in [0, π] and unit axis (3,) of q = (cos θ, a sin θ); `conventional` where q = ±1 has no axis."""

    angle: float
    axis: NDArray[np.float64]
    conventional: bool


def polar(q: ArrayLike) -> Polar:
    """The angle and axis of a unit quaternion, exact for the smallest turns."""
    q = np.asarray(q, np.float64)
    largest = float(np.abs(q[1:]).max())
    if largest == 0.0:
        return Polar(0.0 if q[0] > 0.0 else float(np.pi), np.array([1.0, 0.0, 0.0]), True)
    scaled = q[1:] / largest
    length = float(np.sqrt(scaled @ scaled))
    return Polar(float(np.arctan2(largest * length, q[0])), scaled / length, False)


def multiply(a: ArrayLike, b: ArrayLike) -> Quaternion:
    """The product a b."""
    (aw, ax, ay, az), (bw, bx, by, bz) = np.asarray(a, np.float64), np.asarray(b, np.float64)
    return np.array(
        [
            aw * bw - ax * bx - ay * by - az * bz,
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
        ]
    )


def conjugate(q: ArrayLike) -> Quaternion:
    """The inverse of a unit quaternion."""
    return np.asarray(q, np.float64) * (1.0, -1.0, -1.0, -1.0)


def unit(q: ArrayLike) -> Quaternion:
    """q / |q|; ValueError where q is 0 or not finite."""
    q = np.asarray(q, np.float64)
    length = float(np.sqrt(q @ q))
    if not (np.isfinite(length) and length > 0.0):
        raise ValueError(f"{q} is not a direction")
    return q / length


def power(q: ArrayLike, exponent: float) -> Quaternion:
    """q to a real power, along the shortest arc from 1."""
    angle, axis, _ = polar(q)
    return np.concatenate([[np.cos(exponent * angle)], np.sin(exponent * angle) * axis])


def compose(first: Pair, second: Pair) -> Pair:
    """`second` and then `first`, made unit again so that no drift adds up."""
    return Pair(unit(multiply(first.s, second.s)), unit(multiply(second.t, first.t)))


def inverse(pair: Pair) -> Pair:
    return Pair(conjugate(pair.s), conjugate(pair.t))


def raise_error(pair: Pair, exponent: float) -> Pair:
    """The rotation to a real power; use `canonical` first where the shorter way round is meant."""
    return Pair(power(pair.s, exponent), power(pair.t, exponent))


def canonical(pair: Pair) -> Pair:
    """The one of (S, T) and (−S, −T) whose two turns are smaller together; at a tie, that with S's first part > 0."""
    for decisive in (pair.s[0] + pair.t[0], *pair.s):
        if decisive != 0.0:
            return pair if decisive > 0.0 else Pair(-pair.s, -pair.t)
    return pair


def matrix(pair: Pair) -> NDArray[np.float64]:
    """The rotation (4, 4) that multiplies column vectors (w, x, y, z); its determinant is +1."""
    return np.column_stack([multiply(multiply(pair.s, column), pair.t) for column in np.eye(4)])


def pair_of_rows(rows: ArrayLike) -> Pair:
    """A rotation that takes the first two axes to two orthonormal `rows` (2, 4).

    S T = x and S i T = y, hence S i S⁻¹ = y x̄ = n, a unit vector: S is the shortest turn from i to n.
    """
    x, y = np.asarray(rows, np.float64)
    axis = multiply(y, conjugate(x))
    halfway = multiply(axis, (0.0, -1.0, 0.0, 0.0)) + ONE
    opposite = float(halfway @ halfway) < 1e-20
    s = np.array([0.0, 0.0, 1.0, 0.0]) if opposite else unit(halfway)
    return canonical(Pair(s, unit(multiply(conjugate(s), x))))


def random_pair(rng: np.random.Generator) -> Pair:
    """A rotation drawn uniformly."""
    return canonical(Pair(unit(rng.normal(size=4)), unit(rng.normal(size=4))))


def tangent(pair: Pair) -> NDArray[np.float64]:
    """The direction of movement (6,) as angle times axis of both sides, of length 1; 0 for the identity."""
    vector = np.concatenate([side.angle * side.axis for side in (polar(pair.s), polar(pair.t))])
    length = float(np.sqrt(vector @ vector))
    return vector / length if length > 0.0 else vector
