"""Weights of photographs for light from any direction, and their error where each photograph is left out in turn.

Kriging: a linear trend in the direction of the light, and what is left is taken for a Gaussian process whose kernel is
Matérn's of order 3/2 over the plane of (l_x, l_y), where the azimuth counts most near the horizon (Rasmussen2006
sections 2.7 and 4.2). Length and noise are those with the least error of leaving one out. The rivals are fits of a few
functions by least squares.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from engine.core.directions import Vectors

Array = NDArray[np.float64]

#: Lengths in the plane of (l_x, l_y), and variances of noise over that of the process, which are tried.
LENGTHS, NOISES = (0.1, 0.15, 0.2, 0.3, 0.4, 0.6, 0.9, 1.4, 2.0), (0.003, 0.01, 0.03, 0.1, 0.3, 1.0)

#: Directions of the trend that lamps hardly tell apart are left out: singular values over the largest.
FLAT = 0.02

#: The least share of a photograph that its own weight may leave, so that a division by it is safe.
MIN_LEFT = 1e-9


@dataclass(frozen=True)
class Kernel:
    """Matérn's kernel of order 3/2: `length` in the plane of (l_x, l_y), `noise` as a variance over the process's."""

    length: float
    noise: float

    def __call__(self, one: Vectors, other: Vectors) -> Array:
        """(M, N) covariance of the process between directions (M, 3) and (N, 3), without noise."""
        apart = one[:, None, :2] - other[None, :, :2]
        r = np.sqrt(3.0 * (apart**2).sum(axis=-1)) / self.length
        return np.asarray((1.0 + r) * np.exp(-r))


def weights(lights: Vectors, wanted: Vectors, kernel: Kernel) -> Array:
    """(M, N) of the photographs of `lights` (N, 3), unit vectors, for light from `wanted` (M, 3); rows sum to 1."""
    count = len(lights)
    trend = _trend(lights)
    terms = trend.shape[1]
    system = np.zeros((count + terms, count + terms))
    system[:count, :count] = kernel(lights, lights) + kernel.noise * np.eye(count)
    system[:count, count:], system[count:, :count] = trend, trend.T
    known = np.vstack([kernel(lights, wanted), _trend_at(wanted, lights).T])
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
    trend = _trend(lights)
    towards = inverse @ trend
    inverse -= towards @ np.linalg.solve(trend.T @ towards, towards.T)
    return np.asarray(inverse)


def best_kernel(lights: Vectors, second: Array) -> Kernel:
    """The kernel with the least error of leaving one out; `second` (N, N) are moments of the photographs."""
    tried = [Kernel(length, noise) for length, noise in product(LENGTHS, NOISES)]
    return min(tried, key=lambda kernel: rms(list_left_out(lights, kernel), second))


def leave_out_of_fit(functions: Array) -> Array:
    """The same of a least-squares fit of `functions` (N, P) at the lights.

    The residual of a photograph that is left out is its residual within the fit, over one minus its own weight.
    """
    smooth = functions @ np.linalg.lstsq(functions.T @ functions, functions.T, rcond=None)[0]
    own = np.maximum(1.0 - np.diag(smooth), MIN_LEFT)
    return np.asarray((smooth - np.eye(len(smooth))) / own[:, None])


def rms(apart: Array, second: Array) -> float:
    """The root mean square of the differences `apart` (M, N) · photographs, over rows, texels and channels."""
    return float(np.sqrt(max(np.einsum("ij,ij->", apart @ second, apart) / len(apart), 0.0)))


def polynomial(lights: Vectors) -> Array:
    """(N, 6) the functions of polynomial texture maps (Malzbender2001)."""
    x, y = lights[:, 0], lights[:, 1]
    return np.stack([x * x, y * y, x * y, x, y, np.ones_like(x)], axis=1)


def hsh(lights: Vectors) -> Array:
    """(N, 9) hemispherical harmonics of orders 0 to 2 (Gautron2004), but for their factors."""
    cosine = np.clip(lights[:, 2], 0.0, 1.0)
    phi = np.arctan2(lights[:, 1], lights[:, 0])
    z = 2.0 * cosine - 1.0
    rise = np.sqrt(np.maximum(1.0 - z**2, 0.0))
    return np.stack(
        [
            *(np.ones_like(z), rise * np.cos(phi), z, rise * np.sin(phi)),
            *(rise**2 * np.cos(2.0 * phi), z * rise * np.cos(phi), 3.0 * z**2 - 1.0),
            *(z * rise * np.sin(phi), rise**2 * np.sin(2.0 * phi)),
        ],
        axis=1,
    )


def _trend(lights: Vectors) -> Array:
    """(N, P) functions of the trend at the lights: a constant, and directions as far as the lamps lie apart in them."""
    return _trend_at(lights, lights)


def _trend_at(wanted: Vectors, lights: Vectors) -> Array:
    """The same functions at other directions (M, P)."""
    centre = lights.mean(axis=0)
    _, values, axes = np.linalg.svd(lights - centre, full_matrices=False)
    is_enough = len(lights) > 2 * (1 + len(values))
    kept = axes[values > FLAT * max(values[0], FLAT)] if is_enough else axes[:0]
    return np.hstack([np.ones((len(wanted), 1)), (wanted - centre) @ kept.T])
