"""Sums under spherical Gaussians over the texels of a cube map, at the nodes of a grid on each face.

Sources are planar float32: `flux` (4, 6, N, N), the three channels times the solid angle and the solid angle itself,
and `towards` (3, 6, N, N), unit vectors. A node's value is the weighted flux over the weighted solid angle, so that a
constant stays as it is. Where the neighbourhood of a node lies within its face, whole rows of nodes are computed at
once, one source offset after the other, which compilers turn into vector instructions; the rest goes face by face.
Bound by arithmetic: some 20 operations for each node and source, eight at a time.

The Gaussian may be narrowed by what coarser texels and smoother look-ups widen: `narrow` is that variance in squares of
the distance between texels on the face's plane, where a step is 1 / (1 + r²) long towards the middle of the face and
1 / √(1 + r²) around it.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from engine.kernels import parallel, prange, scalar

#: Gaussians end where they have fallen to exp(−CUT): 0.4 % of their weight lies beyond, and is spread over the rest.
CUT = 5.5

#: Nodes that are computed at once.
_RUN = 64


@scalar
def _weight(exponent: Any) -> Any:
    """exp(−exponent) in float32 to 1e-4 of itself, 0 beyond CUT: a short series to the 32nd power."""
    u = exponent * np.float32(-1.0 / 32.0)
    one = np.float32(1.0)
    e = one + u * (one + u * (np.float32(0.5) + u * (np.float32(1.0 / 6.0) + u * np.float32(1.0 / 24.0))))
    e *= e
    e *= e
    e *= e
    e *= e
    e *= e
    return e if exponent < np.float32(CUT) else np.float32(0.0)


@scalar
def _shape_at(x: float, y: float, sigma: float, narrow: float, at: Any) -> None:
    """Fill `at` (12) as if the face were +Z: the direction, 1 / 2 σ², and two vectors whose products narrow it."""
    square = x * x + y * y
    length = math.sqrt(1.0 + square)
    radius = math.sqrt(square)
    along, around = (x / radius, y / radius) if radius > 0.0 else (1.0, 0.0)
    half = 0.5 / (sigma * sigma)
    out = math.sqrt(0.5 / (sigma * sigma - narrow / (1.0 + square) ** 2) - half)
    turn = math.sqrt(0.5 / (sigma * sigma - narrow / (1.0 + square)) - half)
    at[0], at[1], at[2], at[3] = x / length, -y / length, 1.0 / length, half
    at[4], at[5], at[6] = out * along / length, -out * around / length, -out * radius / length
    at[8], at[9], at[10] = turn * around, turn * along, 0.0


@scalar
def _span(a: float, c: float, reach: float, n: int) -> Any:
    """First and last + 1 texel that a cone of half-angle `reach` covers along one axis of a face; empty if none."""
    across = math.sqrt(a * a + c * c)
    sine = math.sin(min(reach, 0.5 * math.pi))
    if reach >= 0.5 * math.pi or across <= sine:
        return 0, n
    middle, half = math.atan2(a, c), math.asin(sine / across)
    low, high = max(middle - half, -0.25 * math.pi), min(middle + half, 0.25 * math.pi)
    if low >= high:
        return 0, 0
    first = math.floor(0.5 * n * (math.tan(low) + 1.0))
    last = math.ceil(0.5 * n * (math.tan(high) + 1.0))
    return max(first, 0), min(last, n)


@scalar
def _gather(flux: Any, area: Any, towards: Any, faces: Any, turned: Any, at: Any, reach: float, sums: Any) -> None:
    """Sums (19) at the node of all six faces that lies at `at` when they are turned to where +Z is, over all faces."""
    n = area.shape[1]
    sums[:] = 0.0
    weights = np.empty(n, np.float32)
    x, y, z = np.float32(at[0]), np.float32(at[1]), np.float32(at[2])
    half = np.float32(at[3])
    ox, oy, oz = np.float32(at[4]), np.float32(at[5]), np.float32(at[6])
    sx, sy, sz = np.float32(at[8]), np.float32(at[9]), np.float32(at[10])
    for face in range(6):
        a = b = c = 0.0
        for k in range(3):
            a += at[k] * faces[face, 0, k]
            b += at[k] * faces[face, 1, k]
            c += at[k] * faces[face, 2, k]
        if reach < 0.5 * math.pi and c < -math.sin(reach):
            continue
        first, last = _span(a, c, reach, n)
        top, bottom = _span(b, c, reach, n)
        if last <= first:
            continue
        for i in range(top, bottom):
            tx, ty, tz = (
                towards[0, face, i, first:last],
                towards[1, face, i, first:last],
                towards[2, face, i, first:last],
            )
            for j in range(last - first):
                dx, dy, dz = tx[j] - x, ty[j] - y, tz[j] - z
                out = dx * ox + dy * oy + dz * oz
                side = dx * sx + dy * sy + dz * sz
                weights[j] = _weight(half * (dx * dx + dy * dy + dz * dz) + out * out + side * side)
            for j in range(last - first):
                w = np.float64(weights[j])
                if w > 0.0:
                    for own in range(6):
                        place = turned[own, face, 0] + i * turned[own, face, 1] + (first + j) * turned[own, face, 2]
                        sums[own] += w * flux[0, place]
                        sums[6 + own] += w * flux[1, place]
                        sums[12 + own] += w * flux[2, place]
                    sums[18] += w * area[i, first + j]


@scalar
def _reach_in_texels(x: float, y: float, reach: float, n: int) -> Any:
    """How far a small cone extends over a face's plane along rows and columns, in texels."""
    square = 1.0 + x * x + y * y
    stretch = 0.5 * n * reach * (1.0 + reach * math.sqrt(square))
    return stretch * math.sqrt(square * (1.0 + x * x)), stretch * math.sqrt(square * (1.0 + y * y))


@scalar
def _columns(x: float, y: float, down: float, reach: float, n: int) -> Any:
    """First and last offset in texels that an ellipse about (x, y) covers in the rows `down` away; empty if none."""
    square, flat = 1.0 + x * x + y * y, 1.0 + y * y
    reach *= 1.0 + reach * math.sqrt(square)
    middle = x * y * down / flat
    rest = reach * reach * square * square / flat - down * down * square / (flat * flat)
    if rest < 0.0:
        return n, -n
    half = math.sqrt(rest)
    return math.floor(0.5 * n * (middle - half)) - 1, math.ceil(0.5 * n * (middle + half)) + 1


@scalar
def _run(
    flux: Any,
    towards: Any,
    row: int,
    start: int,
    stop: int,
    ghost: int,
    shapes: Any,
    ry: int,
    rx: int,
    reach: float,
    out: Any,
) -> None:
    """Values of nodes start … stop of a row on all faces, whose neighbourhoods of 2 ry × 2 rx texels lie within."""
    n = flux.shape[2]
    count = stop - start
    total, part = np.zeros((19, _RUN)), np.empty((19, _RUN), np.float32)
    weights = np.empty(_RUN, np.float32)
    x, y, z, half = shapes[0, start:stop], shapes[1, start:stop], shapes[2, start:stop], shapes[3, start:stop]
    ox, oy, oz = shapes[4, start:stop], shapes[5, start:stop], shapes[6, start:stop]
    sx, sy, sz = shapes[8, start:stop], shapes[9, start:stop], shapes[10, start:stop]
    left, right = (start - ghost) * 2.0 / n - 1.0, (stop - 1 - ghost) * 2.0 / n - 1.0
    height = (row - ghost) * 2.0 / n - 1.0
    for i in range(row - ghost - ry, row - ghost + ry):
        down = (i + 0.5 - row + ghost) * 2.0 / n
        first_left, last_left = _columns(left, height, down, reach, n)
        first_right, last_right = _columns(right, height, down, reach, n)
        part[:] = 0.0
        for shift in range(max(min(first_left, first_right), -rx), min(max(last_left, last_right), rx)):
            low, high = start - ghost + shift, stop - ghost + shift
            tx, ty, tz = towards[0, i, low:high], towards[1, i, low:high], towards[2, i, low:high]
            for k in range(count):
                dx, dy, dz = tx[k] - x[k], ty[k] - y[k], tz[k] - z[k]
                outwards = dx * ox[k] + dy * oy[k] + dz * oz[k]
                side = dx * sx[k] + dy * sy[k] + dz * sz[k]
                weights[k] = _weight(half[k] * (dx * dx + dy * dy + dz * dz) + outwards * outwards + side * side)
            for plane in range(18):
                of, to = flux[plane // 6, plane % 6, i, low:high], part[plane]
                for k in range(count):
                    to[k] += weights[k] * of[k]
            of, to = flux[3, 0, i, low:high], part[18]
            for k in range(count):
                to[k] += weights[k] * of[k]
        for plane in range(19):
            for k in range(count):
                total[plane, k] += part[plane, k]
    for k in range(count):
        for plane in range(18):
            out[plane % 6, row, start + k, plane // 6] = total[plane, k] / total[18, k]


@parallel
def convolve(
    flux: Any, towards: Any, faces: Any, turned: Any, sigma: float, narrow: float, ghost: int, nodes: Any
) -> None:
    """Fill `nodes` (6, N + 1 + 2 g, N + 1 + 2 g, 3): the edges of the faces are nodes, `ghost` g more lie beyond.

    Turned to where +Z is, every face has the same weights: they are computed once. `turned` (6, 6, 3) tells for each
    face at which flat place, and with what steps along rows and columns, the faces seen from there have their texels.
    """
    n, size = flux.shape[2], nodes.shape[1]
    step = 2.0 / n
    reach = 2.0 * math.asin(min(1.0, sigma * math.sqrt(0.5 * CUT)))
    flat = flux[:3].reshape(3, -1)
    for row in prange(size):
        y = (row - ghost) * step - 1.0
        shapes = np.zeros((12, size), np.float32)
        at, sums = np.empty(12), np.empty(19)
        column = 0
        while column < size:
            stop = column
            rx = ry = 0
            while stop < size and stop - column < _RUN and reach <= 0.5:
                x = (stop - ghost) * step - 1.0
                wide, high = _reach_in_texels(x, y, reach, n)
                new_x, new_y = max(rx, int(wide) + 1), max(ry, int(high) + 1)
                above, below = row - ghost - new_y, row - ghost + new_y
                if above < 0 or below > n or column - ghost - new_x < 0 or stop - ghost + new_x > n:
                    break
                rx, ry = new_x, new_y
                _shape_at(x, y, sigma, narrow * step * step, at)
                for k in range(12):
                    shapes[k, stop] = at[k]
                stop += 1
            if stop > column:
                _run(flux, towards[:, 4], row, column, stop, ghost, shapes, ry, rx, reach, nodes)
                column = stop
            else:
                _shape_at((column - ghost) * step - 1.0, y, sigma, narrow * step * step, at)
                _gather(flat, flux[3, 0], towards, faces, turned, at, reach, sums)
                for plane in range(18):
                    nodes[plane % 6, row, column, plane // 6] = sums[plane] / sums[18]
                column += 1


@parallel
def halve(flux: Any, padded: Any, coarse: Any) -> None:
    """Spread the flux of each texel over the four nearest of half as many, 9 : 3 : 3 : 1; `coarse` (4, 6, N/2, N/2).

    `padded` (4, 6, N + 2, N + 2) has the texels of the adjoining faces around it, and at its corners, where only three
    faces meet, the corner texel again, so that no flux is lost.
    """
    n = coarse.shape[2]
    for task in prange(4 * 6 * n):
        channel, face, i = task // (6 * n), task // n % 6, task % n
        rows = padded[channel, face, 2 * i : 2 * i + 4]
        for j in range(n):
            total = 0.0
            for k in range(4):
                w = 0.25 if k == 0 or k == 3 else 0.75
                k_row = rows[k, 2 * j : 2 * j + 4]
                total += w * (0.25 * (np.float64(k_row[0]) + k_row[3]) + 0.75 * (np.float64(k_row[1]) + k_row[2]))
            coarse[channel, face, i, j] = total


@parallel
def refine(nodes: Any, factor: int, fine: Any) -> None:
    """Cubic B-spline over `nodes` (6, N + 3, N + 3, 3), one beyond each edge, at `factor` as many; (6, f N + 1, …)."""
    size, coarse = fine.shape[1], nodes.shape[1]
    weights = np.empty((factor, 4), np.float32)
    for phase in range(factor):
        _spline(phase / factor, weights[phase])
    flat = nodes.reshape(6, coarse, 3 * coarse)
    for task in prange(6 * size):
        face, row = task // size, task % size
        i, a = row // factor, weights[row % factor]
        lowest = flat[face, min(i + 3, coarse - 1)]
        first, second, third = flat[face, i], flat[face, i + 1], flat[face, i + 2]
        line = np.empty(3 * coarse + 3, np.float32)
        for k in range(3 * coarse):
            line[k] = a[0] * first[k] + a[1] * second[k] + a[2] * third[k] + a[3] * lowest[k]
        line[3 * coarse :] = 0.0
        for phase in range(factor):
            b = weights[phase]
            for j in range((size - phase + factor - 1) // factor):
                for c in range(3):
                    k = 3 * j + c
                    value = b[0] * line[k] + b[1] * line[k + 3] + b[2] * line[k + 6] + b[3] * line[k + 9]
                    fine[face, row, j * factor + phase, c] = value


@scalar
def _spline(t: float, weights: Any) -> None:
    """The four weights of the uniform cubic B-spline at t in [0, 1]."""
    s = 1.0 - t
    weights[0] = s * s * s / 6.0
    weights[1] = (4.0 - 6.0 * t * t + 3.0 * t * t * t) / 6.0
    weights[2] = (4.0 - 6.0 * s * s + 3.0 * s * s * s) / 6.0
    weights[3] = t * t * t / 6.0


@parallel
def energy(level: Any, weight: Any) -> Any:
    """Sums (6, M + 1, 3) of a level's nodes by rows, times their weights (M + 1, M + 1)."""
    size = len(weight)
    sums = np.zeros((6, size, 3))
    for task in prange(6 * size):
        face, i = task // size, task % size
        red = green = blue = 0.0
        for j in range(size):
            red += weight[i, j] * level[face, i, j, 0]
            green += weight[i, j] * level[face, i, j, 1]
            blue += weight[i, j] * level[face, i, j, 2]
        sums[face, i, 0], sums[face, i, 1], sums[face, i, 2] = red, green, blue
    return sums


@scalar
def _bilinear(texels: Any, start: int, cells: int, face: int, s: float, t: float, weight: float, value: Any) -> None:
    """Add `weight` times the value at (s, t) in [0, 1] of one level, (6, cells + 1, cells + 1) nodes from `start`."""
    x, y = s * cells, t * cells
    j, i = min(int(x), cells - 1), min(int(y), cells - 1)
    wx, wy = x - j, y - i
    row = cells + 1
    at = start + (face * row + i) * row + j
    for c in range(3):
        upper = (1.0 - wx) * texels[at, c] + wx * texels[at + 1, c]
        lower = (1.0 - wx) * texels[at + row, c] + wx * texels[at + row + 1, c]
        value[c] += weight * ((1.0 - wy) * upper + wy * lower)


def _look_up(
    texels: Any,
    starts: Any,
    cells: Any,
    level: Any,
    share: Any,
    mean: Any,
    mean_share: Any,
    faces: Any,
    towards: Any,
    values: Any,
) -> None:
    for n in prange(len(towards)):
        x, y, z = towards[n, 0], towards[n, 1], towards[n, 2]
        ax, ay, az = abs(x), abs(y), abs(z)
        if ax >= ay and ax >= az:
            face, longest = (0 if x >= 0.0 else 1), ax
        elif ay >= az:
            face, longest = (2 if y >= 0.0 else 3), ay
        else:
            face, longest = (4 if z >= 0.0 else 5), az
        s = t = 0.0
        for k in range(3):
            s += faces[face, 0, k] * towards[n, k]
            t += faces[face, 1, k] * towards[n, k]
        s = min(max(0.5 + 0.5 * s / longest, 0.0), 1.0)
        t = min(max(0.5 + 0.5 * t / longest, 0.0), 1.0)
        rest = 1.0 - mean_share[n]
        for c in range(3):
            values[n, c] = mean_share[n] * mean[c]
        low = level[n]
        if share[n] < 1.0:
            _bilinear(texels, starts[low], cells[low], face, s, t, rest * (1.0 - share[n]), values[n])
        if share[n] > 0.0:
            _bilinear(texels, starts[low + 1], cells[low + 1], face, s, t, rest * share[n], values[n])


#: Look-ups of values (N, 3), for few directions and for many.
look_up = scalar(_look_up), parallel(_look_up)
