"""Weights of photographs for light from any direction, and their error where each photograph is left out in turn.

Kriging: a constant that is not known, coefficients of a few functions of light with a prior, and what is left is taken
for a Gaussian process (Rasmussen2006 sections 2.7 and 4.2). Its kernel is Matérn's of order 3/2 over the plane of
(l_x, l_y), where the azimuth counts most near the horizon; the radius in this plane is bent by a power and l_z added as
a third axis, as shadows change with elevation and highlights overhead with azimuth. Where the noise is large beside
the process this is a ridge fit of the functions, so that the fits of the field are among the kernels.

All numbers of a kernel are those of the least error of leaving one photograph out, which a pattern search finds
(Hooke1961). The rivals are ridge fits of a few functions, each with the strength of the least such error.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from engine.core.directions import Vectors
from engine.shading.directional.functions import hemispherical, hsh, polynomial, spherical

Array = NDArray[np.float64]

#: Functions whose coefficients have a prior; "free" are directions without one.
Fitted = Literal["free", "linear", "polynomial", "harmonic"]

#: Interpolations that files of other programs state, without a process.
Stated = Literal["ptm", "hsh", "sh", "gauss", "octahedron"]

Basis = Fitted | Stated

#: Kernels from which the search starts: numbers that are tried of each, and the bases.
LENGTHS, NOISES, POWERS, UPWARDS = (0.15, 0.3, 0.6, 1.2), (0.01, 0.1), (1.0, 0.5), (0.0, 1.5)
BASES: tuple[Fitted, ...] = ("linear", "polynomial", "harmonic")

#: A kernel that is a ridge fit: the noise over the process, and variances of coefficients over the noise.
RIDGE_NOISE, RIDGE_TRENDS = 100.0, (0.01, 0.1, 1.0, 10.0)

#: Variance of coefficients over that of the process from which the search starts.
START_TREND = 1.0

#: Bounds of the numbers of a kernel; an upward of 0 is tried too.
BOUNDS = {
    "length": (0.03, 10.0),
    "noise": (1e-3, 1e3),
    "power": (0.3, 2.0),
    "upward": (0.05, 20.0),
    "trend": (1e-4, 1e5),
}

#: Factors by which the search changes a number, the share of an error by which a step must lessen it, and rounds.
FACTORS, WORTH, ROUNDS = (2.0, 1.4, 1.2), 5e-4, 4

#: Photographs that the search looks at, evenly over the list; the last steps look at all.
SEARCHED = 192

#: Strengths of a ridge, over the mean power of the functions.
RIDGES = (0.0, *np.geomspace(1e-5, 10.0, 25))

#: Directions of the trend that lamps hardly tell apart are left out: singular values over the largest.
FLAT = 0.02

#: The least share of a photograph that its own weight may leave, so that a division by it is safe.
MIN_LEFT = 1e-9


@dataclass(frozen=True)
class Kernel:
    """Covariance of radiance between two directions of light, over the variance of the process.

    Attributes
    ----------
    length : of Matérn's kernel of order 3/2.
    noise : variance of a photograph about the process.
    power, upward : the kernel's plane is (l_x, l_y) r^(power - 1), r their length, and `upward` times l_z a third axis.
    basis, trend : functions whose coefficients have the variance `trend`; "free" are directions without a prior. One
        of `STATED` has no process, and of the numbers above "gauss" alone has one, its `length`.
    """

    length: float
    noise: float
    power: float = 1.0
    upward: float = 0.0
    basis: Basis = "free"
    trend: float = 0.0

    def __call__(self, one: Vectors, other: Vectors) -> Array:
        """(M, N) covariance between directions (M, 3) and (N, 3), without noise."""
        first, second = self._place(one), self._place(other)
        squares = (first**2).sum(axis=1)[:, None] + (second**2).sum(axis=1) - 2.0 * first @ second.T
        r = np.sqrt(np.maximum(3.0 * squares, 0.0)) / self.length
        found = (1.0 + r) * np.exp(-r)
        if self.basis != "free":
            found += self.trend * FUNCTIONS[self.basis](one) @ FUNCTIONS[self.basis](other).T
        return np.asarray(found)

    def _place(self, directions: Vectors) -> Array:
        """(M, 3) where directions lie in the space of the kernel."""
        r = np.maximum(np.hypot(directions[:, 0], directions[:, 1]), 1e-12)
        return directions * np.column_stack([r ** (self.power - 1.0)] * 2 + [np.full_like(r, self.upward)])


def weights(lights: Vectors, wanted: Vectors, kernel: Kernel) -> Array:
    """(M, N) of the photographs of `lights` (N, 3), unit vectors, for light from `wanted` (M, 3).

    Rows sum to 1, but for functions of light that are stated and do not hold a constant.
    """
    if kernel.basis in STATED:
        return STATED[kernel.basis](lights, wanted, kernel)
    count = len(lights)
    trend = _trend_at(lights, lights, kernel)
    terms = trend.shape[1]
    system = np.zeros((count + terms, count + terms))
    system[:count, :count] = kernel(lights, lights) + kernel.noise * np.eye(count)
    system[:count, count:], system[count:, :count] = trend, trend.T
    known = np.vstack([kernel(lights, wanted), _trend_at(wanted, lights, kernel).T])
    return np.asarray(np.linalg.solve(system, known)[:count].T)


def list_left_out(lights: Vectors, kernel: Kernel) -> Array:
    """(N, N) each photograph as the others predict it, minus itself: rows of −1 at their own place."""
    precision = precision_of(lights, kernel)
    return np.asarray(-precision / np.maximum(np.diag(precision), MIN_LEFT)[:, None])


def precision_of(lights: Vectors, kernel: Kernel) -> Array:
    """(N, N) the inverse covariance of the photographs where the trend is unknown.

    Its diagonal holds one over the variance that the process leaves to a photograph when all others are known.
    """
    inverse = np.linalg.inv(kernel(lights, lights) + kernel.noise * np.eye(len(lights)))
    trend = _trend_at(lights, lights, kernel)
    towards = inverse @ trend
    inverse -= towards @ np.linalg.solve(trend.T @ towards, towards.T)
    return np.asarray(inverse)


def best_kernel(lights: Vectors, second: Array) -> Kernel:
    """The kernel with the least error of leaving one out; `second` (N, N) are moments of the photographs.

    The best start of each basis, the best ridge fit of each and the best without a prior are improved one number after
    the other. Cost: some 400 inverses of a matrix of at most `SEARCHED` rows, and 10 of one of N.
    """
    some = np.unique(np.linspace(0, len(lights) - 1, min(len(lights), SEARCHED)).round().astype(np.int64))
    few = lights[some], second[np.ix_(some, some)]

    def error(kernel: Kernel) -> float:
        return rms(list_left_out(few[0], kernel), few[1])

    shapes = [Kernel(*numbers) for numbers in product(LENGTHS, NOISES, POWERS, UPWARDS)]
    linear = min((replace(shape, basis="linear", trend=START_TREND) for shape in shapes), key=error)
    starts = [min((shape for shape in shapes if shape.upward == 0.0), key=error), linear]
    for basis in BASES:
        ridges = [Kernel(0.3, RIDGE_NOISE, basis=basis, trend=variance * RIDGE_NOISE) for variance in RIDGE_TRENDS]
        starts += [min(ridges, key=error), *([] if basis == "linear" else [replace(linear, basis=basis)])]
    found = min((_improve(start, error, FACTORS) for start in starts), key=lambda each: each[1])[0]
    if len(some) == len(lights):
        return found
    return _improve(found, lambda kernel: rms(list_left_out(lights, kernel), second), FACTORS[-1:])[0]


def _improve(kernel: Kernel, error: Callable[[Kernel], float], factors: Sequence[float]) -> tuple[Kernel, float]:
    """The kernel after changes of one number at a time, by smaller and smaller factors, and its error."""
    least = error(kernel)
    names = list(BOUNDS) if kernel.basis != "free" else [name for name in BOUNDS if name != "trend"]
    for factor in factors:
        for _ in range(ROUNDS):
            before = least
            for name in names:
                for by in (factor, 1.0 / factor):
                    while (changed := _change(kernel, name, by)) != kernel and (now := error(changed)) < least:
                        kernel, least, enough = changed, now, now > (1.0 - WORTH) * least
                        if enough:
                            break
            if least > (1.0 - WORTH) * before:
                break
    return kernel, least


def _change(kernel: Kernel, name: str, factor: float) -> Kernel:
    """The kernel with one number changed within its bounds; an upward of 0 becomes the least."""
    low, high = BOUNDS[name]
    value = float(np.clip(getattr(kernel, name) * factor, low, high))
    if name == "upward" and kernel.upward == 0.0:
        value = 0.5 if factor > 1.0 else 0.0
    changed: dict[str, Any] = {name: value}
    return replace(kernel, **changed)


def leave_out_of_fit(functions: Array, ridge: float = 0.0) -> Array:
    """(N, N) differences as of `list_left_out`, of a fit of `functions` (N, P) at the lights.

    The residual of a photograph that is left out is its residual within the fit, over one minus its own weight.
    """
    smooth = smoother(functions, ridge)
    own = np.maximum(1.0 - np.diag(smooth), MIN_LEFT)
    return np.asarray((smooth - np.eye(len(smooth))) / own[:, None])


def smoother(functions: Array, ridge: float = 0.0) -> Array:
    """(N, N) photographs as a ridge fit of `functions` (N, P) at the lights shows them."""
    return np.asarray(functions @ ridge_inverse(functions, ridge))


def ridge_inverse(functions: Array, ridge: float = 0.0) -> Array:
    """(P, N) coefficients of `functions` (N, P) at the lights for each photograph.

    `ridge` is the penalty of a squared coefficient, over the mean power of the functions.
    """
    power = functions.T @ functions
    penalty = ridge * np.trace(power) / len(power) * np.eye(len(power))
    return np.asarray(np.linalg.lstsq(power + penalty, functions.T, rcond=None)[0])


def best_ridge(functions: Array, second: Array) -> float:
    """The ridge of least error of leaving one out."""
    return min(RIDGES, key=lambda ridge: rms(leave_out_of_fit(functions, ridge), second))


def rms(apart: Array, second: Array) -> float:
    """The root mean square of the differences `apart` (M, N) · photographs, over rows, texels and channels."""
    return float(np.sqrt(max(np.einsum("ij,ij->", apart @ second, apart) / len(apart), 0.0)))


def _trend_at(wanted: Vectors, lights: Vectors, kernel: Kernel) -> Array:
    """(M, P) functions without a prior at directions (M, 3): a constant, and of a free trend directions as far as
    the lamps lie apart in them."""
    constant = np.ones((len(wanted), 1))
    if kernel.basis != "free":
        return constant
    centre = lights.mean(axis=0)
    _, values, axes = np.linalg.svd(lights - centre, full_matrices=False)
    is_enough = len(lights) > 2 * (1 + len(values))
    kept = axes[values > FLAT * max(values[0], FLAT)] if is_enough else axes[:0]
    return np.hstack([constant, (wanted - centre) @ kept.T])


#: The functions of each basis that has a prior, without a constant.
FUNCTIONS: dict[str, Callable[[Vectors], Array]] = {
    "linear": lambda lights: np.asarray(lights, np.float64),
    "polynomial": lambda lights: polynomial(lights)[:, :-1],
    "harmonic": lambda lights: hsh(lights)[:, 1:],
}


def _through(functions: Callable[[Vectors], Array]) -> Callable[[Vectors, Vectors, Kernel], Array]:
    """Weights of photographs that are combinations of `functions`, of which they are as many or more."""
    return lambda lights, wanted, _: np.asarray(functions(wanted) @ np.linalg.pinv(functions(lights)))


def _gauss(lights: Vectors, wanted: Vectors, kernel: Kernel) -> Array:
    """Shares of exp(−d² / length²), d the distance of two directions; those of `LEAST` and less count as none."""
    squares = np.maximum(2.0 - 2.0 * wanted @ lights.T, 0.0) / kernel.length**2
    found = np.exp(squares.min(axis=1, keepdims=True) - squares)
    found /= found.sum(axis=1, keepdims=True)
    found[found <= LEAST] = 0.0
    return np.asarray(found / found.sum(axis=1, keepdims=True))


def _octahedron(lights: Vectors, wanted: Vectors, _: Kernel) -> Array:
    """Bilinear weights of a square of directions as `octahedral` gives them."""
    side = round(len(lights) ** 0.5)
    x, y, _z = (wanted / np.abs(wanted).sum(axis=1, keepdims=True)).T
    found = np.zeros((len(wanted), side, side))
    column, row = ((0.5 * each + 0.5) * (side - 1) for each in (x + y, y - x))
    left, above = (np.clip(np.floor(each).astype(np.int64), 0, side - 2) for each in (column, row))
    at = np.arange(len(wanted))
    for down, right in product((0, 1), (0, 1)):
        share = np.abs(1 - right - (column - left)) * np.abs(1 - down - (row - above))
        found[at, above + down, left + right] = share
    return found.reshape(len(wanted), -1)


def octahedral(side: int) -> Array:
    """(side², 3) unit vectors of the upper half of an octahedron, row by row, its diagonals along x and y.

    Those of the horizon lie a little above it.
    """
    steps = np.linspace(-1.0, 1.0, side)
    across, down = np.meshgrid(steps, steps)
    x, y = 0.5 * (across - down), 0.5 * (across + down)
    z = np.maximum(1.0 - np.abs(x) - np.abs(y), 1e-6)
    directions = np.stack([x, y, z], axis=-1).reshape(-1, 3)
    return np.asarray(directions / np.linalg.norm(directions, axis=1, keepdims=True))


#: The share below which a photograph counts as none between those of `_gauss`.
LEAST = 1e-3

#: Weights of photographs by the interpolations that files of other programs state.
STATED: dict[str, Callable[[Vectors, Vectors, Kernel], Array]] = {
    "ptm": _through(polynomial),
    "hsh": _through(hemispherical),
    "sh": _through(spherical),
    "gauss": _gauss,
    "octahedron": _octahedron,
}
