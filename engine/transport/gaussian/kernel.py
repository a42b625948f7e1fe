"""Compiled loops over lobes: what three views make of one, and what a lamp sends through it.

Both are bound by arithmetic: three logarithms and square roots for each lobe, some twenty exponentials for a disc.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from engine.core.kernels import parallel, prange, scalar

Integers = NDArray[np.integer]
Floats = NDArray[np.floating]

#: Squared length of a mean of means below which it points nowhere.
NOWHERE = 1e-12

#: Half width, in sigma, of the strip that a disc is summed over, and Gauss's points across it.
REACH = 6.0
NODES, SHARES = np.polynomial.legendre.leggauss(14)


@scalar
def integral(sigma: float) -> float:
    """∫ exp((w·mu − 1) / sigma²) dw, as `engine.light.gaussian_prefilter.gaussian_integral`."""
    square = sigma * sigma
    return -2.0 * math.pi * square * math.expm1(-2.0 / square)


@parallel
def towards(
    weight: Floats,
    mean: Floats,
    sigma: Floats,
    vertices: Integers,
    index: Integers,
    share: Floats,
    counts: Floats,
    first: int,
    energy_out: Floats,
    mean_out: Floats,
    sigma_out: Floats,
) -> None:
    """The lobes of `vertices` (n,) between three views `index` (n, 3) with `share` (n, 3), from column `first` on.

    `counts` (n, 3) holds the shares that energies are mixed with. Means are mixed as directions, widths by their
    logarithms.
    """
    lobes = weight.shape[2]
    for k in prange(len(vertices)):
        vertex = vertices[k]
        nearest = 0
        for j in range(1, 3):
            if share[k, j] > share[k, nearest]:
                nearest = j
        for lobe in range(lobes):
            red = green = blue = x = y = z = logarithm = 0.0
            for j in range(3):
                view, part, counted = index[k, j], share[k, j], counts[k, j]
                width = sigma[vertex, view, lobe]
                if counted > 0.0:
                    whole = counted * integral(width)
                    red += whole * weight[vertex, view, lobe, 0]
                    green += whole * weight[vertex, view, lobe, 1]
                    blue += whole * weight[vertex, view, lobe, 2]
                if part > 0.0:
                    x += part * mean[vertex, view, lobe, 0]
                    y += part * mean[vertex, view, lobe, 1]
                    z += part * mean[vertex, view, lobe, 2]
                    logarithm += part * math.log(width)
            square = x * x + y * y + z * z
            if not square > NOWHERE:
                view = index[k, nearest]
                x, y, z = mean[vertex, view, lobe, 0], mean[vertex, view, lobe, 1], mean[vertex, view, lobe, 2]
                square = x * x + y * y + z * z
            scale = 1.0 / math.sqrt(square)
            at = first + lobe
            energy_out[k, at, 0], energy_out[k, at, 1], energy_out[k, at, 2] = red, green, blue
            mean_out[k, at, 0], mean_out[k, at, 1], mean_out[k, at, 2] = x * scale, y * scale, z * scale
            sigma_out[k, at] = math.exp(logarithm)


@scalar
def _disc(distance: float, radius: float, sigma: float) -> float:
    """∫ exp(−r² / 2 sigma²) over a disc in the plane whose middle is `distance` from that of the Gaussian.

    Strips across the line between both middles are integrated in closed form, erf, and summed by Gauss's rule.
    """
    low, high = max(distance - radius, -REACH * sigma), min(distance + radius, REACH * sigma)
    if not low < high:
        return 0.0
    half, middle = 0.5 * (high - low), 0.5 * (high + low)
    inverse = 1.0 / (math.sqrt(2.0) * sigma)
    total = 0.0
    for n in range(len(NODES)):
        x = middle + half * NODES[n]
        chord = math.sqrt(max(radius * radius - (x - distance) ** 2, 0.0))
        total += SHARES[n] * math.exp(-((x * inverse) ** 2)) * math.erf(chord * inverse)
    return total * half * sigma * math.sqrt(2.0 * math.pi)


@parallel
def add_lamp(
    energy: Floats, mean: Floats, sigma: Floats, direction: Floats, radius: float, light: Floats, values: Floats
) -> None:
    """Add to `values` (n, 3) what a lamp of chord radius `radius` brings through lobes (n, K).

    `light` (3,) is its radiance, or with radius 0 its irradiance.
    """
    for k in prange(len(sigma)):
        for lobe in range(sigma.shape[1]):
            square = 0.0
            for c in range(3):
                square += (mean[k, lobe, c] - direction[c]) ** 2
            width = sigma[k, lobe]
            share = (
                _disc(math.sqrt(square), radius, width) if radius > 0.0 else math.exp(-0.5 * square / (width * width))
            )
            share /= integral(width)
            for c in range(3):
                values[k, c] += energy[k, lobe, c] * light[c] * share
