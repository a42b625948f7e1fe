"""Compiled loops of spherical harmonics: the basis, sums over maps, and rotations of many vectors.

All are bound by arithmetic: some 2 order^2 operations for a direction's basis, 2 order for a texel's share in the sums
along its row, and for a rotation about 2 order^3 for each column of coefficients.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from engine.core.kernels import parallel, prange, scalar

#: Texels whose terms are added up before they join the sum of a row, so that rounding does not grow with the width.
_TEXELS = 32

#: Vectors that are rotated side by side.
_TOGETHER = 32

Array = Any


@scalar
def basis(order: int, first: int, x: float, y: float, z: float, table: Array, out: Array) -> None:
    """Write the values of bands `first` <= l < `order` at the unit vector (x, y, z) to `out`, from index `first`^2.

    Polynomials in z times the real and imaginary parts of (x + i y)^m, so nothing is divided by sin(theta). `table`
    (3, order, order) is `recurrence`.
    """
    start = first * first
    cosine, sine = 1.0, 0.0  # sin^m(theta) times cos and sin of m phi
    for m in range(order):
        before, value = 0.0, table[2, m, m]
        for degree in range(m, order):
            if degree > m:
                before, value = value, table[0, degree, m] * (z * value - table[1, degree, m] * before)
            if degree >= first:
                at = degree * (degree + 1) - start
                out[at + m] = value * cosine
                if m > 0:
                    out[at - m] = value * sine
        cosine, sine = cosine * x - sine * y, cosine * y + sine * x


@parallel
def basis_of_all(order: int, first: int, direction: Array, table: Array, out: Array) -> None:
    """`basis` of each of `direction` (N, 3) into `out` (N, order^2 - first^2)."""
    for n in prange(direction.shape[0]):
        basis(order, first, direction[n, 0], direction[n, 1], direction[n, 2], table, out[n])


@parallel
def row_sums(radiance: Array, waves: Array, out: Array) -> None:
    """Sums of `radiance` (H, W, 3) times `waves` (W, K) along each row, into `out` (H, 3, K) float64."""
    height, width = radiance.shape[:2]
    count = waves.shape[1]
    for row in prange(height):
        part = np.zeros((3, count))
        out[row] = 0.0
        for start in range(0, width, _TEXELS):
            part[:] = 0.0
            for column in range(start, min(start + _TEXELS, width)):
                red, green, blue = radiance[row, column]
                for k in range(count):
                    wave = waves[column, k]
                    part[0, k] += red * wave
                    part[1, k] += green * wave
                    part[2, k] += blue * wave
            out[row] += part


@parallel
def face_sums(radiance: Array, order: int, points: Array, weights: Array, table: Array, out: Array) -> None:
    """Sums over each row of texels of all six faces at once, into `out` (N, order^2, 18) float64.

    `radiance` (N, N, 18); `points` (N, N, Q, 3) are directions in the texels of the face +Z and `weights` (N, N, Q)
    their solid angles.
    """
    size, nodes = points.shape[0], points.shape[2]
    count = order * order
    for row in prange(size):
        values = np.empty(count)
        texel = np.empty(count)
        part = np.zeros((count, 18))
        out[row] = 0.0
        for column in range(size):
            texel[:] = 0.0
            for q in range(nodes):
                x, y, z = points[row, column, q]
                basis(order, 0, x, y, z, table, values)
                for i in range(count):
                    texel[i] += weights[row, column, q] * values[i]
            for i in range(count):
                for k in range(18):
                    part[i, k] += texel[i] * radiance[row, column, k]
            if column % _TEXELS == _TEXELS - 1 or column == size - 1:
                out[row] += part
                part[:] = 0.0


@scalar
def euler_pairs(rotation: Array, out: Array) -> None:
    """Cosines and sines (3, 2) of alpha, beta, gamma with `rotation` = Rz(alpha) Ry(beta) Rz(gamma), to rounding.

    alpha is found first, from the column that holds it, and gamma from what is left: so the product is the rotation
    also where beta is next to 0 or pi and neither angle by itself means anything (Kautz2002 appendix; X10).
    """
    across = math.hypot(rotation[0, 2], rotation[1, 2])
    out[0, 0], out[0, 1] = 1.0, 0.0
    if across > 1e-150:
        out[0, 0], out[0, 1] = rotation[0, 2] / across, rotation[1, 2] / across
    length = math.hypot(rotation[2, 2], across)
    out[1, 0], out[1, 1] = rotation[2, 2] / length, across / length
    sine = out[0, 0] * rotation[1, 0] - out[0, 1] * rotation[0, 0]
    cosine = out[0, 0] * rotation[1, 1] - out[0, 1] * rotation[0, 1]
    length = math.hypot(cosine, sine)
    out[2, 0], out[2, 1] = cosine / length, sine / length


@scalar
def _about_z(order: int, columns: int, cosine: Array, sine: Array, values: Array) -> None:
    """Rotate the `values` (order^2, columns _TOGETHER) of vectors side by side about z, each by its own angle."""
    count = cosine.shape[0]
    c, s = np.ones_like(cosine), np.zeros_like(sine)  # of m times the angle
    for m in range(1, order):
        for b in range(count):
            c[b], s[b] = c[b] * cosine[b] - s[b] * sine[b], c[b] * sine[b] + s[b] * cosine[b]
        for degree in range(m, order):
            plus, minus = values[degree * (degree + 1) + m], values[degree * (degree + 1) - m]
            for column in range(columns):
                start = column * count
                for b in range(count):
                    even, odd = plus[start + b], minus[start + b]
                    plus[start + b] = even * c[b] - odd * s[b]
                    minus[start + b] = even * s[b] + odd * c[b]


@scalar
def _swap(start: Array, index: Array, weight: Array, values: Array, out: Array) -> None:
    """`out` = swap of y and z times `values`; the swap is given by its rows' entries that are not 0."""
    for i in range(values.shape[0]):
        row = out[i]
        row[:] = 0.0
        for entry in range(start[i], start[i + 1]):
            factor, other = weight[entry], values[index[entry]]
            for k in range(row.shape[0]):
                row[k] += factor * other[k]


@parallel
def rotate_many(
    coefficients: Array, frames: Array, into: bool, order: int, start: Array, index: Array, weight: Array, out: Array
) -> None:
    """Rotate vectors of `coefficients` (V or 1, order^2, C) by `frames` (V, 3, 3), or `into` them by their inverse.

    `start`, `index`, `weight` are the rows of the swap of y and z; `out` (V, order^2, C) has the type of the sums.
    """
    vectors, count, columns = out.shape
    blocks = (vectors + _TOGETHER - 1) // _TOGETHER
    for block in prange(blocks):
        lowest = block * _TOGETHER
        here = min(_TOGETHER, vectors - lowest)
        angle = np.zeros((3, 2, _TOGETHER), out.dtype)
        angle[:, 0] = 1.0
        pairs = np.empty((3, 2))
        values = np.zeros((count, columns * _TOGETHER), out.dtype)
        other = np.empty_like(values)
        for b in range(here):
            euler_pairs(frames[lowest + b], pairs)
            for step in range(3):
                taken = step if into else 2 - step
                turned = -1.0 if (step != 1) == into else 1.0  # the middle turn is seen in the mirror
                angle[step, 0, b] = pairs[taken, 0]
                angle[step, 1, b] = turned * pairs[taken, 1]
            source = coefficients[(lowest + b) if coefficients.shape[0] > 1 else 0]
            for i in range(count):
                for column in range(columns):
                    values[i, column * _TOGETHER + b] = source[i, column]
        _about_z(order, columns, angle[0, 0], angle[0, 1], values)
        _swap(start, index, weight, values, other)
        _about_z(order, columns, angle[1, 0], angle[1, 1], other)
        _swap(start, index, weight, other, values)
        _about_z(order, columns, angle[2, 0], angle[2, 1], values)
        for b in range(here):
            for i in range(count):
                for column in range(columns):
                    out[lowest + b, i, column] = values[i, column * _TOGETHER + b]


@parallel
def lobe_sums(order: int, direction: Array, weight: Array, table: Array, out: Array) -> None:
    """Sums (N, 3, order^2) of the basis at `direction` (N, S, 3) times `weight` (N, S, 3)."""
    count = order * order
    for n in prange(direction.shape[0]):
        values = np.empty(count)
        out[n] = 0.0
        for s in range(direction.shape[1]):
            red, green, blue = weight[n, s]
            if red == 0.0 and green == 0.0 and blue == 0.0:
                continue
            basis(order, 0, direction[n, s, 0], direction[n, s, 1], direction[n, s, 2], table, values)
            for i in range(count):
                out[n, 0, i] += red * values[i]
                out[n, 1, i] += green * values[i]
                out[n, 2, i] += blue * values[i]


@scalar
def _row_of(rows: int, wo: Array) -> tuple[int, float, float, float]:
    """Between which rows a view lies and at which share, and cosine and sine of its azimuth."""
    x, y, z = wo[0], wo[1], max(wo[2], 0.0)
    across = math.hypot(x, y)
    place = min(across / (1.0 + z), 1.0) * (rows - 1)
    low = min(int(place), rows - 2)
    if across > 0.0:
        return low, place - low, x / across, y / across
    return low, place - low, 1.0, 0.0


@scalar
def _between(table: Array, low: int, share: float, i: int, k: int) -> float:
    """Coefficient `i` of channel `k` between two rows of `table`."""
    return (1.0 - share) * table[low, i, k] + share * table[low + 1, i, k]


@parallel
def isotropic_rows(order: int, table: Array, wo: Array, out: Array) -> None:
    """Coefficients (N, order^2, 3) towards `wo` (N, 3) of a `table` (R, order^2, 3) at azimuth 0, m >= 0."""
    for n in prange(wo.shape[0]):
        if wo[n, 2] <= 0.0:
            out[n] = 0.0
            continue
        low, share, c, s = _row_of(table.shape[0], wo[n])
        cosine, sine = 1.0, 0.0
        for m in range(order):
            for degree in range(m, order):
                at = degree * (degree + 1)
                for k in range(3):
                    value = _between(table, low, share, at + m, k)
                    out[n, at + m, k] = cosine * value
                    if m > 0:
                        out[n, at - m, k] = sine * value
            cosine, sine = cosine * c - sine * s, cosine * s + sine * c


@parallel
def isotropic_radiance(order: int, table: Array, wo: Array, light: Array, out: Array) -> None:
    """Radiance (N, 3) towards `wo` (N, 3) under `light` (N, order^2, 3); 0 below the horizon. As `isotropic_rows`."""
    for n in prange(wo.shape[0]):
        out[n] = 0.0
        if wo[n, 2] <= 0.0:
            continue
        low, share, c, s = _row_of(table.shape[0], wo[n])
        cosine, sine = 1.0, 0.0
        for m in range(order):
            for degree in range(m, order):
                at = degree * (degree + 1)
                for k in range(3):
                    value = _between(table, low, share, at + m, k)
                    lit = cosine * light[n, at + m, k]
                    if m > 0:
                        lit += sine * light[n, at - m, k]
                    out[n, k] += value * lit
            cosine, sine = cosine * c - sine * s, cosine * s + sine * c


@parallel
def expand(seen: Array, first: Array, second: Array, start: Array, index: Array, weight: Array, out: Array) -> None:
    """Symmetric matrices (B, n, n) from SH (B, (2 order - 1)^2), by `Products`; `out` holds zeros before."""
    for b in prange(seen.shape[0]):
        for pair in range(first.shape[0]):
            total = 0.0
            for term in range(start[pair], start[pair + 1]):
                total += weight[term] * seen[b, index[term]]
            out[b, first[pair], second[pair]] = total
            out[b, second[pair], first[pair]] = total


@parallel
def transfer(rows: Array, light: Array, out: Array) -> None:
    """Products (R, 3) of `rows` (R, 1 or 3, n) and `light` (n, 3), both float32; bound by reading the rows."""
    count = light.shape[0]
    for r in prange(rows.shape[0]):
        for c in range(3):
            row = rows[r, c if rows.shape[1] == 3 else 0]
            total = np.float32(0.0)
            for j in range(count):
                total += row[j] * light[j, c]
            out[r, c] = total


@parallel
def transfer_each(rows: Array, light: Array, count: int, out: Array) -> None:
    """The same with `light` (V, n, 3) of one's own for every `count` rows."""
    size = light.shape[1]
    for r in prange(rows.shape[0]):
        for c in range(3):
            row = rows[r, c if rows.shape[1] == 3 else 0]
            total = np.float32(0.0)
            for j in range(size):
                total += row[j] * light[r // count, j, c]
            out[r, c] = total


@parallel
def total(values: Array) -> float:
    """The sum of `values` (N,) float32, N a multiple of 1000: what reading them costs, for measurements."""
    sums = np.zeros(values.shape[0] // 1000, np.float32)
    for block in prange(sums.shape[0]):
        part = np.zeros(25, np.float32)
        for row in range(40):
            for k in range(25):
                part[k] += values[block * 1000 + row * 25 + k]
        sums[block] = part.sum()
    return float(sums.sum())


@parallel
def view(matrix: Array, coefficients: Array, out: Array) -> None:
    """Vectors (V, 3, n) of `matrix` (V, n, 1 or 3, n), transposed, times `coefficients` (V, n, 3)."""
    count = matrix.shape[1]
    for v in prange(matrix.shape[0]):
        out[v] = 0.0
        for i in range(count):
            for c in range(3):
                row = matrix[v, i, c if matrix.shape[2] == 3 else 0]
                factor = np.float32(coefficients[v, i, c])
                for j in range(count):
                    out[v, c, j] += factor * row[j]


@parallel
def gather(count: int, met: Array, corners: Array, share: Array, weight: Array, sent: Array, out: Array) -> None:
    """Add to `out` (B, W, C, n) what the `count` rays of each vertex find: `weight` (B count, W) of what is sent.

    `met` (B count,) says which rays find a surface, at the vertices `corners` (B count, 3) by `share` (B count, 3);
    `sent` is (V, C, n).
    """
    channels, size = sent.shape[1:]
    for b in prange(out.shape[0]):
        found = np.empty((channels, size), np.float32)
        for ray in range(b * count, (b + 1) * count):
            if not met[ray]:
                continue
            found[:] = 0.0
            for corner in range(3):
                factor = np.float32(share[ray, corner])
                for c in range(channels):
                    for j in range(size):
                        found[c, j] += factor * sent[corners[ray, corner], c, j]
            for w in range(weight.shape[1]):
                factor = np.float32(weight[ray, w])
                if factor == 0.0:
                    continue
                for c in range(channels):
                    for j in range(size):
                        out[b, w, c, j] += factor * found[c, j]
