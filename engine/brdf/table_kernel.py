"""Compiled look-ups in tables of BRDF, and the filling of their holes.

`look_up_half` is bound by arithmetic (three arc tangents and eight corners of three values), `look_up_directions` by
the sixteen corners it fetches: some 0.3 and 0.5 µs on a core. Neither depends on the order of the pairs.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from engine.brdf.half_difference import OPPOSITE
from engine.core.kernels import parallel, prange, scalar

Bools = NDArray[np.bool_]
Floats = NDArray[np.floating]

_QUARTER = 0.5 * math.pi


@scalar
def _half_of(wi: Floats, wo: Floats) -> tuple[float, float, float]:
    """(theta_h, theta_d, phi_d) in the classical frame with phi_d folded to [0, π]; equal for (wo, wi), bit for bit."""
    ax, ay, az = wi[0] + wo[0], wi[1] + wo[1], wi[2] + wo[2]
    dx, dy, dz = wi[0] - wo[0], wi[1] - wo[1], wi[2] - wo[2]
    both = ax * ax + ay * ay + az * az
    between = dx * dx + dy * dy + dz * dz
    hx, hy, hz = 0.0, 0.0, 1.0
    if both > OPPOSITE:
        length = math.sqrt(both)
        hx, hy, hz = ax / length, ay / length, az / length
    across = math.sqrt(hx * hx + hy * hy)
    cosine, sine = 1.0, 0.0
    if across > 0.0:
        cosine, sine = hx / across, hy / across
    x = hz * (cosine * dx + sine * dy) - across * dz
    y = cosine * dy - sine * dx
    if y < 0.0 or (y == 0.0 and x < 0.0):
        x, y = -x, -y
    phi_d = math.atan2(y, x) if x != 0.0 or y != 0.0 else 0.0
    return math.atan2(across, hz), math.atan2(math.sqrt(between), math.sqrt(both)), phi_d


@scalar
def _between_nodes(position: float, bins: int) -> tuple[int, float]:
    """Lower node and weight of the upper one, for nodes at 0, ½, 1½ … bins − ½; constant beyond the last."""
    if position < 0.5:
        return 0, 2.0 * position
    low = min(int(position + 0.5), bins - 1)
    return low, min(position + 0.5 - low, 1.0)


@scalar
def _blend_half(lattice: Floats, theta_h: float, theta_d: float, phi_d: float, value: Floats) -> None:
    heights, depths, turns = lattice.shape[0] - 1, lattice.shape[1] - 1, lattice.shape[2]
    h, wh = _between_nodes(math.sqrt(theta_h / _QUARTER) * heights, heights)
    d, wd = _between_nodes(theta_d / _QUARTER * depths, depths)
    turn = phi_d / math.pi * turns - 0.5
    low = math.floor(turn)
    wp = turn - low
    first = int(low) % turns
    second = (first + 1) % turns
    for c in range(3):
        lower = (1.0 - wd) * ((1.0 - wp) * lattice[h, d, first, c] + wp * lattice[h, d, second, c]) + wd * (
            (1.0 - wp) * lattice[h, d + 1, first, c] + wp * lattice[h, d + 1, second, c]
        )
        upper = (1.0 - wd) * ((1.0 - wp) * lattice[h + 1, d, first, c] + wp * lattice[h + 1, d, second, c]) + wd * (
            (1.0 - wp) * lattice[h + 1, d + 1, first, c] + wp * lattice[h + 1, d + 1, second, c]
        )
        value[c] = (1.0 - wh) * lower + wh * upper


def _look_up_half(lattice: Floats, wi: Floats, wo: Floats, values: Floats) -> None:
    for n in prange(len(wi)):
        total = 0.0
        for c in range(3):
            total += abs(wi[n, c]) + abs(wo[n, c])
            values[n, c] = 0.0
        if wi[n, 2] > 0.0 and wo[n, 2] > 0.0 and total < math.inf:
            theta_h, theta_d, phi_d = _half_of(wi[n], wo[n])
            _blend_half(lattice, theta_h, theta_d, phi_d, values[n])


def _look_up_angles(lattice: Floats, theta_h: Floats, theta_d: Floats, phi_d: Floats, values: Floats) -> None:
    for n in prange(len(theta_h)):
        _blend_half(lattice, theta_h[n], theta_d[n], phi_d[n], values[n])


@scalar
def _between_angles(theta: float, grid: Floats) -> tuple[int, float]:
    """Lower row and weight of the upper one on a rising grid; a line through the last two rows goes on beyond them."""
    last = len(grid) - 1
    if last == 0:
        return 0, 0.0
    above = int(np.searchsorted(grid, theta, side="right"))
    low = min(max(above - 1, 0), last - 1)
    return low, max((theta - grid[low]) / (grid[low + 1] - grid[low]), 0.0)


@scalar
def _between_turns(phi: float, grid: Floats) -> tuple[int, int, float]:
    """Both columns and the weight of the second on a rising grid in [0, 2π) that closes on itself."""
    count = len(grid)
    phi -= 2.0 * math.pi * math.floor(phi / (2.0 * math.pi))
    low = int(np.searchsorted(grid, phi, side="right")) - 1
    high = (low + 1) % count
    start = grid[low] if low >= 0 else grid[count - 1] - 2.0 * math.pi
    step = (grid[high] - grid[low % count]) % (2.0 * math.pi)
    if step == 0.0:
        return low % count, high, 0.0
    return low % count, high, min((phi - start) / step, 1.0)


def _look_up_directions(
    theta_i: Floats,
    phi_i: Floats,
    theta_o: Floats,
    phi_o: Floats,
    table: Floats,
    wi: Floats,
    wo: Floats,
    values: Floats,
) -> None:
    for n in prange(len(wi)):
        total = 0.0
        for c in range(3):
            total += abs(wi[n, c]) + abs(wo[n, c])
            values[n, c] = 0.0
        if not (wi[n, 2] > 0.0 and wo[n, 2] > 0.0 and total < math.inf):
            continue
        azimuth_i = math.atan2(wi[n, 1], wi[n, 0]) if wi[n, 0] != 0.0 or wi[n, 1] != 0.0 else 0.0
        azimuth_o = math.atan2(wo[n, 1], wo[n, 0]) if wo[n, 0] != 0.0 or wo[n, 1] != 0.0 else 0.0
        if len(phi_i) == 1:
            azimuth_o -= azimuth_i
        a, wa = _between_angles(math.atan2(math.hypot(wi[n, 0], wi[n, 1]), wi[n, 2]), theta_i)
        c_row, wc = _between_angles(math.atan2(math.hypot(wo[n, 0], wo[n, 1]), wo[n, 2]), theta_o)
        b, b_next, wb = _between_turns(azimuth_i, phi_i)
        e, e_next, we = _between_turns(azimuth_o, phi_o)
        for corner in range(16):
            row_i = min(a + (corner & 1), len(theta_i) - 1)
            row_o = min(c_row + ((corner >> 1) & 1), len(theta_o) - 1)
            weight = (wa if corner & 1 else 1.0 - wa) * (wc if corner & 2 else 1.0 - wc)
            weight *= (wb if corner & 4 else 1.0 - wb) * (we if corner & 8 else 1.0 - we)
            if weight != 0.0:
                column_i = b_next if corner & 4 else b
                column_o = e_next if corner & 8 else e
                for c in range(3):
                    values[n, c] += weight * table[row_i, column_i, row_o, column_o, c]
        for c in range(3):
            values[n, c] = max(values[n, c], 0.0)


@parallel
def fill_along_turns(values: Floats, missing: Bools) -> None:
    """Fill each row (R, P, 3) of a closed turn in place: a line between the nearest measured ones on both sides."""
    for row in prange(len(values)):
        count = missing.shape[1]
        start = -1
        for p in range(count):
            if not missing[row, p]:
                start = p
                break
        if start < 0:
            continue
        at = start
        for step in range(1, count + 1):
            p = (start + step) % count
            if missing[row, p]:
                continue
            gap = (p - at) % count if p != at else count
            for k in range(1, gap):
                weight = k / gap
                for c in range(3):
                    start_value = values[row, at, c]
                    values[row, (at + k) % count, c] = start_value + weight * (values[row, p, c] - start_value)
            at = p


#: Pairs from which on a second thread is worth its start; each look-up is compiled for fewer and for more.
MANY = 512

_HALF = scalar(_look_up_half), parallel(_look_up_half)
_ANGLES = scalar(_look_up_angles), parallel(_look_up_angles)
_DIRECTIONS = scalar(_look_up_directions), parallel(_look_up_directions)


def look_up_half(lattice: Floats, wi: Floats, wo: Floats, values: Floats) -> None:
    """Fill `values` (N, 3) for directions (N, 3) each; 0 at and below the horizon and for what is not a number."""
    _HALF[len(wi) >= MANY](lattice, wi, wo, values)


def look_up_angles(lattice: Floats, theta_h: Floats, theta_d: Floats, phi_d: Floats, values: Floats) -> None:
    """Fill `values` (N, 3) for angles (N,) with theta in [0, π/2] and any finite phi_d."""
    _ANGLES[len(theta_h) >= MANY](lattice, theta_h, theta_d, phi_d, values)


def look_up_directions(
    theta_i: Floats,
    phi_i: Floats,
    theta_o: Floats,
    phi_o: Floats,
    table: Floats,
    wi: Floats,
    wo: Floats,
    values: Floats,
) -> None:
    """Fill `values` (N, 3) from a four-dimensional table; with one phi_i, phi_o counts from the light's azimuth."""
    _DIRECTIONS[len(wi) >= MANY](theta_i, phi_i, theta_o, phi_o, table, wi, wo, values)
