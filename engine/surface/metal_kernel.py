"""Kernel that finds the metallic-roughness of each texel which is nearest to its coefficients ρ and F.

    ρ = base (1 − metallic) (1 − F),   F = f0 (1 − metallic) + base metallic

Without the base colour, the squares of a channel are κ (metallic ρ − d (F − (1 − metallic) f0))², with κ the
determinant of the precision over that of the base colour. Channels err alike, by their shared lobe and slopes, and
count as one for f0; where they are ambiguous, f0 has the prior `F0_SPREAD`. The variance of the base colour is that for
a known f0 and that of what it follows f0 by: little tells a broad lobe from a diffuse part.
Bound by arithmetic, 24 values of metallic that are tried: 2 µs a texel on one core.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from engine.core.kernels import parallel, prange, scalar
from engine.surface.pbr_maps import DIELECTRIC_F0

Array = NDArray[np.float64]

#: Deviation of a dielectric's f0 from that of index 1.5: two of them are indices of 1 to 1.8. Squared deviations by
#: which a metal must explain more.
F0_SPREAD, METAL_EVIDENCE = 0.02, 9.0

#: Largest f0 of a dielectric, of index 2.6.
BRIGHTEST_F0 = 0.2

#: Steps of metallic from 0 to 1 that are tried.
STEPS = 20

#: Columns of what is given: ρ, F, the variances of both and their covariance; and of what is found: base colour,
#: metallic and f0, the standard deviation of each, and by how many squared deviations a metal explains them better.
RHO, F, VARIANCE, GIVEN = 0, 3, 6, 9
BASE, METALLIC, F0, BASE_SIGMA, METALLIC_SIGMA, F0_SIGMA, EVIDENCE, FOUND = 0, 3, 4, 5, 8, 9, 10, 11

#: Texels that a thread takes at a time.
_PART = 256


@parallel
def convert_texels(given: Array, evidence: Array, metallic: Array, found: Array) -> None:
    """Fill `found` (T, FOUND) from `given` (T, GIVEN), of `metallic` (STEPS + 1,) from 0 to 1.

    A texel is a dielectric unless a metal explains it better by its `evidence` (T,), in squared deviations.
    """
    last, step = len(metallic) - 1, metallic[1]
    for part in prange((len(given) + _PART - 1) // _PART):
        cost, precision = np.empty(len(metallic)), np.empty(3)
        base, variance, low_base, high_base = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
        for texel in range(part * _PART, min(len(given), (part + 1) * _PART)):
            row = given[texel]
            _invert(row, precision)
            for index in range(len(metallic)):
                cost[index] = _evaluate(metallic[index], row, precision, True, base, variance)[1]
            metal = 1 + int(cost[1:].argmin())
            least = cost[metal]
            if cost[last] < least + METAL_EVIDENCE:
                metal = last
            best = metal if cost[metal] + evidence[texel] < cost[0] else 0
            inside = min(max(best, 1), last - 1)
            bend = max(cost[inside - 1] - 2.0 * cost[inside] + cost[inside + 1], 1e-12)
            shift = 0.0
            if best == inside:
                shift = _clip(0.5 * (cost[inside - 1] - cost[inside + 1]) / bend, -0.5, 0.5)
            value = _clip(metallic[best] + step * shift, 0.0, 1.0)
            sigma = _clip(step * math.sqrt(2.0 / bend), 0.0, 0.5)
            # colour goes from the diffuse part to the specular one as metallic moves
            _evaluate(_clip(value - sigma, 0.0, 1.0), row, precision, True, low_base, variance)
            _evaluate(_clip(value + sigma, 0.0, 1.0), row, precision, True, high_base, variance)
            # the reflectance of a dielectric has heard a prior in the fit
            f0, _, f0_variance = _evaluate(value, row, precision, value > 0.0, base, variance)
            for channel in range(3):
                moved = high_base[channel] - low_base[channel]
                more = (0.25 if value > 0.0 else 0.0) * (moved * moved)
                found[texel, BASE + channel] = base[channel]
                found[texel, BASE_SIGMA + channel] = min(math.sqrt(variance[channel] + more), 1.0)
            found[texel, METALLIC], found[texel, METALLIC_SIGMA] = value, sigma
            found[texel, F0], found[texel, F0_SIGMA] = f0, math.sqrt(f0_variance)
            found[texel, EVIDENCE] = cost[0] - least


@scalar
def _clip(value: float, low: float, high: float) -> float:
    """The value between both, NaN for NaN."""
    return low if value < low else high if value > high else value


@scalar
def _invert(row: Array, precision: Array) -> None:
    """Fill `precision` (3,) with the inverse of the covariance of ρ and F; what is not known has the variance 1."""
    a, b, c = row[VARIANCE], row[VARIANCE + 1], row[VARIANCE + 2]
    a = 1e-10 if math.isnan(a) else _clip(a, 1e-10, 1.0)
    b = 1e-10 if math.isnan(b) else _clip(b, 1e-10, 1.0)
    limit = 0.999 * math.sqrt(a * b)
    c = 0.0 if math.isnan(c) or c == np.inf else _clip(c, -limit, limit)
    determinant = a * b - c * c
    precision[0], precision[1], precision[2] = b / determinant, -c / determinant, a / determinant


@scalar
def _evaluate(
    m: float, row: Array, precision: Array, ambiguous: bool, base: Array, variance: Array
) -> tuple[float, float, float]:
    """f0, squared deviations and variance of f0 where metallic is `m`; fills `base` (3,) and its `variance` (3,)."""
    p, q, r = precision[0], precision[1], precision[2]
    rest = 1.0 - m
    known, toward = 0.0, 0.0
    for channel in range(3):
        d = rest * (1.0 - _clip(row[F + channel], 0.0, 0.95))
        within = p * d * d + 2.0 * q * d * m + r * m * m
        weight = (p * r - q * q) / within * d * rest
        known += weight * d * rest
        toward += weight * (d * row[F + channel] - m * row[RHO + channel])
    own = 1.0 / F0_SPREAD**2 if ambiguous else 0.0
    known, toward = known / 3.0 + own, toward / 3.0 + own * DIELECTRIC_F0
    f0 = _clip(toward / max(known, 1e-12), 0.0, BRIGHTEST_F0) if known > 0.0 else DIELECTRIC_F0
    f0_variance, cost = 1.0 / max(known, 1.0 / 0.5**2), 0.0
    for channel in range(3):
        rho, specular = row[RHO + channel], row[F + channel]
        d = rest * (1.0 - _clip(specular, 0.0, 0.95))
        within = p * d * d + 2.0 * q * d * m + r * m * m
        of_base, of_specular = p * d + q * m, q * d + r * m
        found = _clip((of_base * rho + of_specular * (specular - rest * f0)) / within, 0.0, 1.0)
        by_f0 = rest * (rest * found * of_base - q * d - r * m) / within
        base[channel], variance[channel] = found, 1.0 / within + by_f0 * by_f0 * f0_variance
        off_d, off_s = rho - d * found, specular - m * found - rest * f0
        cost += p * (off_d * off_d) + 2.0 * q * off_d * off_s + r * (off_s * off_s)
    prior = (f0 - DIELECTRIC_F0) / F0_SPREAD
    return f0, cost + prior * prior, f0_variance
