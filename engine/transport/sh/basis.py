"""Real spherical harmonics: the basis, functions that are round about an axis, and windows against ringing.

Orthonormal, without Condon–Shortley phase, index i = l (l + 1) + m; order n means the bands l < n, n^2 coefficients.
With N_lm the norm and P_lm without phase,

    y_lm = sqrt(2) N_lm P_lm(z) cos(m phi), m > 0;   N_l0 P_l(z);   sqrt(2) N_l|m| P_l|m|(z) sin(|m| phi), m < 0

so y_1 = sqrt(3 / 4 pi) (y, z, x). Directions are in whatever frame the function is in; theta is the angle from its z
axis. Coefficients of lighting hold nothing but radiance: no cosine, no 1 / pi. In memory they are (order^2, 3) float64.
Orders up to 64 keep the basis orthonormal to 2e-14 times the order.
"""

from __future__ import annotations

import math
from fractions import Fraction
from functools import lru_cache
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.core.directions import dot
from engine.transport.sh import kernel as sh_kernel

#: The highest order that the tests reach.
MAX_ORDER = 64

Window = Literal["none", "hanning", "lanczos"]
WINDOWS: tuple[Window, ...] = ("none", "hanning", "lanczos")

Array = NDArray[np.float64]


def check_order(order: int) -> int:
    """`order`, or ValueError where it is not 1 … `MAX_ORDER`."""
    if not 1 <= order <= MAX_ORDER:
        raise ValueError(f"an order of {order} is outside 1 … {MAX_ORDER}")
    return int(order)


def order_of(count: int) -> int:
    """The order that has `count` coefficients; ValueError where none has."""
    order = math.isqrt(max(count, 0))
    if order * order != count or count == 0:
        raise ValueError(f"{count} coefficients are of no order: 1, 4, 9, 16, 25 … are")
    return check_order(order)


def bands(order: int) -> NDArray[np.int64]:
    """(order^2,) the band l of each coefficient."""
    return np.repeat(np.arange(order), 2 * np.arange(order) + 1)


def evaluate(order: int, directions: ArrayLike) -> Array:
    """The basis (..., order^2) float64 at `directions` (..., 3), which are made unit vectors.

    Raises ValueError for a direction that is 0 or not finite. About 10 ns for each value on two cores.
    """
    return band_values(order, 0, directions)


def band_values(order: int, first: int, directions: ArrayLike) -> Array:
    """Only the bands `first` <= l < `order`: (..., order^2 - first^2)."""
    unit = _unit(directions)
    values = np.empty((math.prod(unit.shape[:-1]), check_order(order) ** 2 - first**2))
    sh_kernel.basis_of_all(order, first, unit.reshape(-1, 3), recurrence(order), values)
    return values.reshape(*unit.shape[:-1], values.shape[1])


def _unit(directions: ArrayLike) -> Array:
    vectors = np.asarray(directions, np.float64)
    if vectors.shape[-1:] != (3,):
        raise ValueError(f"directions have shape (..., 3), not {vectors.shape}")
    largest = np.abs(vectors).max(axis=-1, initial=0.0, keepdims=True)
    if not (np.isfinite(largest) & (largest > 0.0)).all():
        raise ValueError("a direction is zero or not finite")
    scaled = vectors / largest  # so that squares neither overflow nor vanish
    return np.ascontiguousarray(scaled / np.sqrt(dot(scaled, scaled))[..., None])


@lru_cache(maxsize=8)
def recurrence(order: int) -> Array:
    """(3, order, order) factors a_lm, b_lm of p_lm = a_lm (z p_{l-1,m} - b_lm p_{l-2,m}), and on its diagonal p_mm.

    p_lm is the normalised Legendre function over sin^m(theta), with the sqrt(2) of m > 0. No factorials occur.
    """
    table = np.zeros((3, order, order))
    square_of_first = Fraction(1)  # exact, so that rounding does not grow with m
    for m in range(order):
        square_of_first *= Fraction(2 * m + 1, 2 * m) if m else 1
        table[2, m, m] = math.sqrt(float(square_of_first * (2 if m else 1)) / (4.0 * math.pi))
        degree = np.arange(m + 1, order, dtype=np.float64)
        square = degree * degree
        table[0, m + 1 :, m] = np.sqrt((4.0 * square - 1.0) / (square - m * m))
        lower = (degree - 1.0) ** 2
        table[1, m + 1 :, m] = np.sqrt(np.maximum(lower - m * m, 0.0) / (4.0 * lower - 1.0))
    table.flags.writeable = False
    return table


def integral(a: ArrayLike, b: ArrayLike) -> Array:
    """The integral of the product of two functions: sum of `a` (order^2, ...) times `b` (order^2, ...) over i.

    Raises ValueError where their orders differ: of which coefficients are missing nothing is known.
    """
    first, second = np.asarray(a, np.float64), np.asarray(b, np.float64)
    one, other = order_of(len(first)), order_of(len(second))
    if one != other:
        raise ValueError(f"coefficients of order {one} and {other} do not belong together")
    return np.tensordot(first, second, axes=(0, 0))


def window(order: int, kind: Window) -> Array:
    """(order^2,) weights that damp high bands against ringing; exactly 1 for l = 0.

    Hanning (1 + cos(pi l / order)) / 2, Lanczos sin(x) / x with x = pi l / order. Narrow functions ring less, but
    become lower and wider: their peak is 0.41 and 0.53 of what it was at order 5.
    """
    if kind not in WINDOWS:
        raise ValueError(f"unknown window {kind!r}; choose from {', '.join(WINDOWS)}")
    band = np.arange(check_order(order)) / order
    weights = {"none": np.ones(order), "hanning": 0.5 + 0.5 * np.cos(np.pi * band), "lanczos": np.sinc(band)}[kind]
    weights[0] = 1.0
    return weights[bands(order)]


def apply_window(coefficients: ArrayLike, kind: Window) -> Array:
    """`coefficients` (order^2, ...) with `window` applied."""
    values = np.asarray(coefficients, np.float64)
    return values * window(order_of(len(values)), kind).reshape(-1, *[1] * (values.ndim - 1))


def disc_zonal(order: int, radius: ArrayLike) -> Array:
    """(..., order) coefficients y_l0 of even discs about +z that bring irradiance 1; `radius` (...) to pi/2 rad.

    The integral of P_l over the cap is (1 - c^2) P_l'(c) / (l (l + 1)) with c = cos(radius), and the radiance is
    1 / (pi (1 - c^2)): the factor that vanishes cancels, and radius 0 is the directional light.
    """
    angle = np.asarray(radius, np.float64)
    wrong = angle[~((angle >= 0.0) & (angle <= np.pi / 2))]
    if wrong.size:
        raise ValueError(f"a disc of radius {math.degrees(wrong[0]):g}° is not between 0 and 90°")
    degree = np.arange(check_order(order))
    share = np.empty((*angle.shape, order))
    share[..., 0] = 1.0 / np.cos(angle / 2.0) ** 2
    share[..., 1:] = 2.0 * _legendre_slopes(order, np.cos(angle))[..., 1:] / (degree[1:] * (degree[1:] + 1.0))
    return np.sqrt((2.0 * degree + 1.0) / (4.0 * np.pi)) * share


def _legendre_slopes(order: int, c: Array) -> Array:
    """(..., order) P_l'(c), by P_{l+1}' = P_{l-1}' + (2 l + 1) P_l."""
    value, slope = np.zeros((*c.shape, order + 1)), np.zeros((*c.shape, order + 1))
    value[..., 0], value[..., 1], slope[..., 1] = 1.0, c, 1.0
    for degree in range(1, order):
        higher = (2 * degree + 1) * c * value[..., degree] - degree * value[..., degree - 1]
        value[..., degree + 1] = higher / (degree + 1)
        slope[..., degree + 1] = slope[..., degree - 1] + (2 * degree + 1) * value[..., degree]
    return slope[..., :order]


def cosine_zonal(order: int) -> Array:
    """(order,) coefficients y_l0 of max(0, cos(theta)): what turns lighting into irradiance (Ramamoorthi2001)."""
    moment = np.zeros(check_order(order))  # of P_l over z = 0 … 1 with weight z
    moment[0] = 0.5
    if order > 1:
        moment[1] = 1.0 / 3.0
    middle = 1.0  # l! / (2^l (l/2)!^2)
    for degree in range(2, order, 2):
        middle *= (degree - 1.0) / degree
        moment[degree] = (-1.0) ** (degree // 2 + 1) * middle / ((degree + 2.0) * (degree - 1.0))
    return 2.0 * np.pi * np.sqrt((2.0 * np.arange(order) + 1.0) / (4.0 * np.pi)) * moment


def turn_zonal(zonal: ArrayLike, directions: ArrayLike) -> Array:
    """(..., order^2) coefficients of the functions of `zonal` about `directions` (..., 3) instead of +z.

    `zonal` is (order,) of one function for all directions, or (..., order) of one each.
    """
    return evaluate(np.asarray(zonal).shape[-1], directions) * _per_coefficient(zonal)


def _per_coefficient(zonal: ArrayLike) -> Array:
    values = np.asarray(zonal, np.float64)
    band = bands(values.shape[-1])
    return np.asarray(np.sqrt(4.0 * np.pi / (2.0 * band + 1.0)) * values[..., band])
