"""A power law in fewer bits: exponents as codes of 8 or 16 bits, scales as half floats, with a bound on the error.

Replacing K by K' changes r^K by at most |K - K'| / (e min(K, K')), because |d r^K / dK| = r^K |ln r| has its largest
value 1 / (e K). A few texels of very large K (light in the last slice alone) would make the steps of 8 bits coarse for
all others, so exponents may be held at a lower largest value, where the sum of squared bounds is least.
Cost: some 100 ns per texel and channel.
"""

from __future__ import annotations

import dataclasses
import math
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.core.steps import Step, Steps
from engine.shading.power_law import PowerLawMap, Storage, power
from engine.shading.power_law_error import bands, measure
from engine.shading.shading_map import ShadingMap

#: Texels and channels on which the largest stored exponent is chosen.
SAMPLE = 100_000

HALF_MAX = 65504.0


def quantise(power_law: PowerLawMap, shading_map: ShadingMap, bits: Literal[8, 16]) -> Steps[PowerLawMap]:
    """`power_law` with exponents rounded to codes of `bits` and scales to half floats, and its errors measured anew.

    It holds the rounded values; `storage` says how they are coded, and how much the rounding changes at most.
    """
    yield Step(0.0, "quantising")
    step = _best_step(power_law, bits)
    exponent, scale = np.empty_like(power_law.exponent), np.empty_like(power_law.scale)
    height, width = power_law.error_map.shape
    shares = np.linspace(0.0, 1.0, len(shading_map.slices))[1:]
    bound = change = 0.0
    for rows in bands(height, width):
        k, at = power_law.scale[rows], power_law.exponent[rows]
        codes, _ = quantise_exponent(at, bits, step)
        exponent[rows] = restore_exponent(codes, step)
        scale[rows] = np.minimum(k, HALF_MAX).astype(np.float16)
        k_stored, stored = scale[rows], exponent[rows]
        bounds = np.abs(k_stored.astype(np.float64) - k) + quantisation_bound(k_stored, at, stored)
        bound = max(bound, float(bounds.max()))
        for share in shares:
            change = max(change, float(np.abs(power(k_stored, stored, share) - power(k, at, share)).max()))
        yield Step(0.5 * rows.stop / height, "quantising")
    storage = Storage(bits, 16, step, bound, change)
    stored_law = dataclasses.replace(power_law, scale=scale, exponent=exponent, storage=storage)
    return (yield from measure(stored_law, shading_map))


def quantise_exponent(
    exponent: ArrayLike, bits: int, step: float | None = None
) -> tuple[NDArray[np.unsignedinteger], float]:
    """K as codes of 8 or 16 bits, K = code * step: (codes, step). Without a `step` it covers the largest K."""
    if bits not in (8, 16):
        raise ValueError(f"exponents are stored in 8 or 16 bits, not {bits}")
    values, last = np.asarray(exponent, dtype=np.float64), 2**bits - 1
    step = step or float(values.max()) / last or 1.0
    return np.minimum(np.rint(values / step), last).astype(np.uint8 if bits == 8 else np.uint16), step


def restore_exponent(codes: NDArray[np.unsignedinteger], step: float) -> NDArray[np.float32]:
    """K of codes, rounded once."""
    return (codes.astype(np.float64) * step).astype(np.float32)


def quantisation_bound(scale: ArrayLike, exponent: ArrayLike, stored: ArrayLike) -> NDArray[np.float64]:
    """Largest |f| change for any r when K is replaced by a stored K: k_s |dK| / (e K), at most k_s.

    K is the smaller of the two, because r^K |ln r| has its maximum 1 / (e K) and falls with K (mean value theorem).
    """
    scale, exponent, stored = (np.asarray(values, dtype=np.float64) for values in (scale, exponent, stored))
    smaller = np.minimum(exponent, stored)
    change = np.abs(exponent - stored) / (math.e * np.where(smaller > 0, smaller, 1.0))
    return scale * np.where(smaller > 0, np.minimum(change, 1.0), exponent != stored)


def _best_step(power_law: PowerLawMap, bits: int) -> float:
    """The step of the codes for which the sum of squared bounds is least, among the largest K and its halves."""
    stride = max(1, power_law.scale.size // SAMPLE)
    scale, exponent = power_law.scale.ravel()[::stride], power_law.exponent.ravel()[::stride]
    largest = float(power_law.exponent.max()) or 1.0

    def cost(step: float) -> float:
        codes, _ = quantise_exponent(exponent, bits, step)
        return float(np.square(quantisation_bound(scale, exponent, codes * step)).sum())

    return min((largest / 2**halvings / (2**bits - 1) for halvings in range(10)), key=cost)
