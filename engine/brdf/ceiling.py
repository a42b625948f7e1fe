"""The largest value that a factored or fitted BRDF may have near what was measured: three times that within 12°.

Textures of projections are solved where samples read them, and the product of two such textures is a guess wherever no
sample reads both: its logarithm has no bound, and a colour may appear that no sample has. So what factors give is cut
at a ceiling that the samples give, and a fit is held under it. The distance of pairs of directions is

    d(p, q)² = |wi − wi'|² + |wo − wo'|², least over turns about the normal, the mirror and, where the BRDF is
               reciprocal, the exchange of light and viewer,

and the limit at a pair q is M(q) = 3 max f(s) over the samples s with d(q, s) ≤ 2 sin 6°; where there is none, over
those up to 3° farther than the nearest. The ceiling is a table of nodes over (θi, θo, |φi − φo|), linear in between,
and the value of a node is the least M of the cells around it: so the table is nowhere above M, as far as M is known on
a grid of half its steps.

Of a brushed measurement the turns make M the largest over all azimuths: a bound of the colours, and a wide one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.core.directions import Vectors
from engine.core.kernels import parallel, prange

Floats = NDArray[np.float64]

#: How often the largest value of the neighbours a value may be, and how far neighbours are.
TIMES, NEAR = 3.0, math.radians(12.0)

#: Nodes along each of the three angles, grid points of M on each step between them, and how much farther than the
#: nearest sample those count that stand in for neighbours, in radians.
NODES, FINER, FARTHER = 19, 2, math.radians(3.0)


@dataclass(frozen=True, eq=False)
class Ceiling:
    """A table (NODES, NODES, NODES, 3) float32 ≥ 0 in 1/sr over |φi − φo| in [0, π], θo and θi in [0, π/2]."""

    table: NDArray[np.float32]

    def __post_init__(self) -> None:
        table = np.array(self.table, np.float32)
        if table.shape != (NODES, NODES, NODES, 3):
            raise ValueError(f"a ceiling must have the shape {(NODES, NODES, NODES, 3)}, not {table.shape}")
        if not (np.isfinite(table).all() and table.min() >= 0.0):
            raise ValueError("a ceiling must be finite and not negative")
        table.flags.writeable = False
        object.__setattr__(self, "table", table)

    def look_up(self, wi: ArrayLike, wo: ArrayLike) -> Vectors:
        """Largest values (..., 3) in 1/sr for unit directions (..., 3) above the horizon that broadcast."""
        wi, wo = np.broadcast_arrays(np.asarray(wi, np.float64), np.asarray(wo, np.float64))
        values = np.empty(wi.shape)
        incident, outgoing = (np.ascontiguousarray(each).reshape(-1, 3) for each in (wi, wo))
        _look_up(self.table, incident, outgoing, values.reshape(-1, 3))
        return values


def ceiling_of(wi: Floats, wo: Floats, value: Floats, *, reciprocal: bool) -> Ceiling:
    """The ceiling of samples (N, 3), N > 0; with `reciprocal` they count for light and viewer exchanged, too."""
    steps = FINER * (NODES - 1) + 1
    theta, phi = np.linspace(0.0, 0.5 * np.pi, steps), np.linspace(0.0, np.pi, steps)
    grid = np.stack(np.meshgrid(phi, theta, theta, indexing="ij"), axis=-1).reshape(-1, 3)
    limit = limits(wi, wo, value, grid[:, 2], grid[:, 1], grid[:, 0], reciprocal)
    fine = limit.reshape(steps, steps, steps, 3)
    for axis in range(3):
        fine = _least_around(fine, axis)
    table = fine[::FINER, ::FINER, ::FINER].copy()
    # at the normal the azimuth means nothing
    table[:, 0], table[:, :, 0] = table[:, 0].min(axis=0), table[:, :, 0].min(axis=0)
    return Ceiling(np.nextafter(table.astype(np.float32), np.float32(0.0)))


def _least_around(values: Floats, axis: int) -> Floats:
    """The least of each entry and of `FINER` on both sides along an axis."""
    padded = np.pad(values, [(FINER, FINER) if k == axis else (0, 0) for k in range(values.ndim)], mode="edge")
    windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * FINER + 1, axis=axis)
    return np.asarray(windows.min(axis=-1))


def limits(
    wi: Floats, wo: Floats, value: Floats, theta_i: Floats, theta_o: Floats, phi: Floats, reciprocal: bool
) -> Floats:
    """M (Q, 3) at pairs of the angles (Q,) from samples (N, 3), of which there must be some."""
    if reciprocal:
        wi, wo, value = np.concatenate([wi, wo]), np.concatenate([wo, wi]), np.concatenate([value, value])
    order = np.argsort(-wi[:, 2], kind="stable")
    wi, wo, value = wi[order], wo[order], value[order]
    sines = np.hypot(wi[:, 0], wi[:, 1]), np.hypot(wo[:, 0], wo[:, 1])
    across = sines[0] * sines[1]
    safe = np.where(across > 0.0, across, 1.0)
    along = np.clip((wi[:, :2] * wo[:, :2]).sum(axis=1) / safe, -1.0, 1.0)
    cosine = np.where(across > 0.0, along, 1.0)
    samples = np.column_stack([wi[:, 2], wo[:, 2], *sines, cosine, np.sqrt(1.0 - cosine**2)])
    asked = np.column_stack(
        [np.cos(theta_i), np.cos(theta_o), np.sin(theta_i), np.sin(theta_o), np.cos(phi), np.sin(phi)]
    )
    found = np.empty((len(asked), 3))
    _limits(samples, np.ascontiguousarray(value), asked, (2.0 * math.sin(0.5 * NEAR)) ** 2, FARTHER, found)
    return TIMES * found


@parallel
def _limits(
    samples: NDArray[np.floating],
    value: NDArray[np.floating],
    asked: NDArray[np.floating],
    near: float,
    farther: float,
    found: NDArray[np.floating],
) -> None:
    """`found` (Q, 3) the largest values near each pair; bound by the distances of all samples of like elevation."""
    count = len(samples)
    for q in prange(len(asked)):
        a = asked[q]
        square, nearest = near, 8.0
        for c in range(3):
            found[q, c] = 0.0
        for attempt in range(2):
            some = False
            for n in range(count):
                s = samples[n]
                # the least distance that the angles of the lights from the normal alone leave
                apart = 2.0 - 2.0 * (a[0] * s[0] + a[2] * s[2])
                if apart > square and (attempt == 1 or apart > nearest):
                    continue
                one, other = a[2] * s[2], a[3] * s[3]
                turned = math.sqrt(
                    max(one * one + other * other + 2.0 * one * other * (a[4] * s[4] + a[5] * s[5]), 0.0)
                )
                distance = 4.0 - 2.0 * (a[0] * s[0] + a[1] * s[1] + turned)
                nearest = min(nearest, distance)
                if distance <= square:
                    some = True
                    for c in range(3):
                        found[q, c] = max(found[q, c], value[n, c])
            if some:
                break
            square = (math.sqrt(max(nearest, 0.0)) + farther) ** 2


@parallel
def _look_up(
    table: NDArray[np.floating], wi: NDArray[np.floating], wo: NDArray[np.floating], values: NDArray[np.floating]
) -> None:
    """`values` (P, 3) of the table; bound by fetching eight nodes for each pair."""
    last = len(table) - 1
    for p in prange(len(wi)):
        sine_i = math.sqrt(wi[p, 0] ** 2 + wi[p, 1] ** 2)
        sine_o = math.sqrt(wo[p, 0] ** 2 + wo[p, 1] ** 2)
        along = wi[p, 0] * wo[p, 0] + wi[p, 1] * wo[p, 1]
        beside = abs(wi[p, 0] * wo[p, 1] - wi[p, 1] * wo[p, 0])
        phi = math.atan2(beside, along) if sine_i > 0.0 and sine_o > 0.0 else 0.0
        x = min(max(math.atan2(sine_i, wi[p, 2]) * 2.0 / math.pi, 0.0), 1.0) * last
        y = min(max(math.atan2(sine_o, wo[p, 2]) * 2.0 / math.pi, 0.0), 1.0) * last
        z = min(phi / math.pi, 1.0) * last
        i, j, k = min(int(x), last - 1), min(int(y), last - 1), min(int(z), last - 1)
        u, v, w = x - i, y - j, z - k
        for c in range(3):
            low = (1.0 - v) * ((1.0 - u) * table[k, j, i, c] + u * table[k, j, i + 1, c]) + v * (
                (1.0 - u) * table[k, j + 1, i, c] + u * table[k, j + 1, i + 1, c]
            )
            high = (1.0 - v) * ((1.0 - u) * table[k + 1, j, i, c] + u * table[k + 1, j, i + 1, c]) + v * (
                (1.0 - u) * table[k + 1, j + 1, i, c] + u * table[k + 1, j + 1, i + 1, c]
            )
            values[p, c] = (1.0 - w) * low + w * high
