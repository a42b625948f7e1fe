"""The light that, seen from above, shows a texel as it is seen from anywhere: how directional maps are looked up.

Kautz2004 lets a texel know the light by r = sigma f(l, v) cos(theta) alone (Kautz2004 Eq. 2). The photographs are
taken from above, v = n, so that a lamp at elevation theta' has r' = sigma f(l', n) cos(theta'). A texel under a light l
that is seen from v looks as in the image of the lamp of equal r and, as shadows tell the side that light comes from,
of equal azimuth:

    f(l', n) cos(theta') = f(l, v) cos(theta),    phi' = phi.

Seen from above this is l' = l for every BRDF whose product falls with theta: photographs come back as they were taken.
For a Lambertian surface it is l' = l from every view. Where the product does not fall everywhere, its running maximum
from the horizon upwards takes its place, and l' is the lowest light of equal r. The image holds its cosine, so that
radiance is image(l') times irradiance; r and sigma cancel, but for a sigma that a user sets. The image of l
itself, whatever the view, would lose the highlights of a BRDF; times f(l, v) / f(l, n) it grows without bound where a
highlight is absent from above.

Two tables serve it: the cosine of theta' over r for a BRDF, and the weights of planes over directions for a map.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.brdf.brdf import Brdf
from engine.core.cached import remember
from engine.core.colour import luminance
from engine.core.directions import Vectors, surface_direction

Array = NDArray[np.float64]

#: Directions of a table of weights: angles from the normal, the last at the horizon, and azimuths, which repeat.
TILTS, TURNS = 48, 96

#: Entries of a table of cosines, angles where the BRDF is evaluated for it, and azimuths of an anisotropic one.
ENTRIES, SAMPLES, SIDES = 1024, 2048, 64

#: The least cosine of a table, and the least share, as powers of 2: what is below is black.
MIN_COSINE, MIN_SHARE = -12.0, -100.0


@dataclass(frozen=True, eq=False)
class EffectiveCosine:
    """The cosine of theta' over the share of r in its largest value from above, for one BRDF.

    Attributes
    ----------
    largest : of f cos(theta) seen from above at azimuth 0, in 1/sr; 0 where the BRDF reflects nothing.
    lowest : the power of 2 of the least share in the table, negative; smaller shares are black.
    power : (P, ENTRIES) float32, cosines as powers of 2 at even steps of the power of the share, from `lowest` to 0;
        rows are azimuths, one alone for isotropic BRDFs. Straight lines for power laws such as Lambert's.
    """

    largest: float
    lowest: float
    power: NDArray[np.float32]

    def __call__(self, share: ArrayLike, azimuth: ArrayLike) -> Array:
        """cos(theta') in [0, 1] for shares of r (more than 1 counts as 1) and azimuths in radians."""
        share = np.minimum(np.asarray(share, np.float64), 1.0)
        lit = share > 2.0**self.lowest
        place = (1.0 - np.log2(np.where(lit, share, 1.0)) / self.lowest) * (ENTRIES - 1)
        rows = len(self.power)
        turn = np.mod(np.asarray(azimuth, np.float64) / (2.0 * np.pi), 1.0) * rows
        found = bilinear(self.power[..., None], turn, place, wrap_first=True)[..., 0]
        return np.asarray(np.where(lit, np.exp2(found), 0.0))


@remember(4)
def effective_cosine(brdf: Brdf) -> EffectiveCosine:
    """The table of `brdf`; the last ones are kept. Cost: `SAMPLES` evaluations, times `SIDES` where anisotropic."""
    cosine = np.cos(np.linspace(0.5 * np.pi, 0.0, SAMPLES))
    cosine[0] = 2.0**MIN_COSINE
    azimuth = np.arange(1 if brdf.isotropic else SIDES) * (2.0 * np.pi / SIDES)
    wi = surface_direction(np.arccos(cosine)[None], azimuth[:, None])
    wo = np.broadcast_to((0.0, 0.0, 1.0), wi.shape)
    f = np.asarray(brdf.f(wi.reshape(-1, 3), wo.reshape(-1, 3))).reshape(*wi.shape)
    product = np.nan_to_num(luminance(f) * cosine, nan=0.0, posinf=0.0, neginf=0.0)
    hull = np.maximum.accumulate(np.maximum(product, 0.0), axis=1)
    largest = float(hull[0, -1])
    if largest <= 0.0:
        return EffectiveCosine(0.0, MIN_SHARE, np.zeros((1, ENTRIES), np.float32))
    power = np.log2(np.maximum(hull / largest, 2.0**MIN_SHARE))
    lowest = float(np.clip(power[:, 0].min(), MIN_SHARE, -1e-3))
    wanted = np.linspace(lowest, 0.0, ENTRIES)
    found = np.stack([_first_reach(wanted, each, np.log2(cosine)) for each in power])
    return EffectiveCosine(largest, lowest, found.astype(np.float32))


def _first_reach(wanted: Array, rising: Array, at: Array) -> Array:
    """`at` where `rising`, which never falls, first reaches each of `wanted`."""
    first = np.concatenate([[True], np.diff(rising) > 0.0])
    return np.interp(wanted, rising[first], at[first])


def table_directions() -> Vectors:
    """(TILTS, TURNS, 3) unit vectors of a table of weights."""
    tilt = np.linspace(0.0, 0.5 * np.pi, TILTS)
    return surface_direction(tilt[:, None], (np.arange(TURNS) * (2.0 * np.pi / TURNS))[None])


def weights_at(table: NDArray[np.float32], cosine: Array, azimuth: Array) -> Array:
    """(M, 3, 1 + K) of a `table` (TILTS, TURNS, 3, 1 + K), bilinear, at cosines and azimuths (M,) of lights."""
    down = np.arccos(np.clip(cosine, 0.0, 1.0)) / (0.5 * np.pi) * (TILTS - 1)
    turn = np.mod(azimuth / (2.0 * np.pi), 1.0) * TURNS
    return bilinear(table, down, turn, wrap_second=True)


def bilinear(
    table: NDArray[np.float32], first: Array, second: Array, *, wrap_first: bool = False, wrap_second: bool = False
) -> Array:
    """`table` (A, B, …) at places (M,) in units of entries along its first two axes, clamped or repeating."""
    value: Array | float = 0.0
    for row, row_share in _beside(first, table.shape[0], wrap_first):
        for column, column_share in _beside(second, table.shape[1], wrap_second):
            share = row_share * column_share
            value = value + share.reshape(share.shape + (1,) * (table.ndim - 2)) * table[row, column]
    return np.asarray(value)


def _beside(place: Array, size: int, wrap: bool) -> tuple[tuple[NDArray[np.int64], Array], ...]:
    if not wrap:
        place = np.clip(place, 0.0, size - 1.0)
    lower = np.floor(place).astype(np.int64)
    beyond = place - lower
    upper = (lower + 1) % size if wrap else np.minimum(lower + 1, size - 1)
    return (lower % size, 1.0 - beyond), (upper, beyond)
