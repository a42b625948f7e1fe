"""Sums under spherical Gaussians over the texels of a cube map, at the nodes of a grid on each face.

Sources are float32: `flux` are the three channels times the solid angle and the solid angle itself, `towards`
(3, 6, N, N) unit vectors. A node's value is the weighted flux over the weighted solid angle, so that a constant stays
as it is. Where the neighbourhood of a node lies within its face, whole rows of nodes are computed at once, one source
offset after the other, which compilers turn into vector instructions; the rest goes face by face. Each row of sources
is summed in float32, of which nothing cancels because nothing is negative, and the rows in float64.
Bound by arithmetic: some 60 operations for each node and source on all faces, 2 to 3 ns where rows are long.

The Gaussian may be narrowed by what coarser texels and smoother look-ups widen: `narrow` is that variance in squares of
the distance between texels on the face's plane, where a step is 1 / (1 + r²) long towards the middle of the face and
1 / √(1 + r²) around it.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from engine.core.kernels import parallel, prange, scalar

Integers = NDArray[np.integer]
Floats = NDArray[np.floating]

#: Gaussians end where they have fallen to exp(−CUT): 0.4 % of their weight lies beyond, and is spread over the rest.
CUT = 5.5

#: Nodes that are computed at once.
_RUN = 128


@scalar
def _weight(exponent: np.float32) -> np.float32:
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
def _shape_at(x: float, y: float, sigma: float, narrow: float, at: Floats) -> None:
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
def _span(a: float, c: float, reach: float, n: int) -> tuple[int, int]:
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
def _gather(
    texels: Floats, n: int, towards: Floats, faces: Floats, rotated: Integers, at: Floats, reach: float, sums: Floats
) -> None:
    """Sums (6, 4) at the node of each face that lies at `at` when it is rotated to where +Z is, over all faces."""
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
            left, right = 0, last - first
            while left < right and weights[left] == 0.0:
                left += 1
            while right > left and weights[right - 1] == 0.0:
                right -= 1
            if left == right:
                continue
            for own in range(6):
                stride = 4 * rotated[own, face, 2]
                place = 4 * (rotated[own, face, 0] + i * rotated[own, face, 1]) + (first + left) * stride
                red = green = blue = area = np.float32(0.0)
                for j in range(left, right):
                    w = weights[j]
                    red += w * texels[place]
                    green += w * texels[place + 1]
                    blue += w * texels[place + 2]
                    area += w * texels[place + 3]
                    place += stride
                sums[own, 0] += red
                sums[own, 1] += green
                sums[own, 2] += blue
                sums[own, 3] += area


@scalar
def _reach_in_texels(x: float, y: float, reach: float, n: int) -> tuple[float, float]:
    """Extent of a small cone over a face's plane along rows and columns, in texels."""
    square = 1.0 + x * x + y * y
    stretch = 0.5 * n * reach * (1.0 + reach * math.sqrt(square))
    return stretch * math.sqrt(square * (1.0 + x * x)), stretch * math.sqrt(square * (1.0 + y * y))


@scalar
def _columns(x: float, y: float, down: float, reach: float) -> tuple[float, float]:
    """Lowest and highest offset on the face's plane that an ellipse about (x, y) covers `down` away; empty if none."""
    square, flat = 1.0 + x * x + y * y, 1.0 + y * y
    reach *= 1.0 + reach * math.sqrt(square)
    middle = x * y * down / flat
    rest = reach * reach * square * square / flat - down * down * square / (flat * flat)
    if rest < 0.0:
        return math.inf, -math.inf
    half = math.sqrt(rest)
    return middle - half, middle + half


@scalar
def _form_at(x: float, y: float, sigma: float, narrow: float, forms: Floats, lane: int) -> None:
    """Coefficients of dx², dx dy and dy² that make, times 1 / (1 + r²) of a texel, the leading term of its exponent.

    sin² of the angle between (x, y, 1) and (x + dx, y + dy, 1) is dx² + dy² + (x dy − y dx)² over both lengths².
    """
    square = x * x + y * y
    length = 1.0 + square
    half = 0.5 / (sigma * sigma)
    out = (0.5 / (sigma * sigma - narrow / (length * length)) - half) / length
    turn = 0.5 / (sigma * sigma - narrow / length) - half
    xx, xy, yy = (x * x / square, x * y / square, y * y / square) if square > 0.0 else (1.0, 0.0, 0.0)
    half /= length
    forms[0, lane] = half * (1.0 + y * y) + out * xx + turn * yy
    forms[1, lane] = 2.0 * ((out - turn) * xy - half * x * y)
    forms[2, lane] = half * (1.0 + x * x) + out * yy + turn * xx


@scalar
def _run(
    flux: Floats,
    inverse: Floats,
    row: int,
    column: int,
    count: int,
    shift_y: float,
    shift_x: float,
    forms: Floats,
    ry: int,
    reach: float,
    curved: float,
    sums: Floats,
    part: Floats,
    weights: Floats,
) -> None:
    """Sums (19, count) of nodes whose neighbourhoods lie within the face, on all faces.

    The first lies `shift_x`, `shift_y` texels beyond the upper left corner of texel (row, column), each of the others
    two texels further.
    """
    step = 2.0 / flux.shape[2]
    a, b, c = forms[0, :count], forms[1, :count], forms[2, :count]
    weight = weights[:count]
    y = (row + shift_y) * step - 1.0
    left, right = (column + shift_x) * step - 1.0, (column + 2 * (count - 1) + shift_x) * step - 1.0
    sums[:] = 0.0
    bend = np.float32(curved)
    for i in range(row - ry, row + ry + 1):
        down = (i + 0.5 - row - shift_y) * step
        low_left, high_left = _columns(left, y, down, reach)
        low_right, high_right = _columns(right, y, down, reach)
        lowest, highest = min(low_left, low_right), max(high_left, high_right)
        if lowest > highest:
            continue
        part[:] = np.float32(0.0)
        dy = np.float32(down)
        first = math.ceil(lowest / step - 0.5 + shift_x)
        for tap in range(first, math.floor(highest / step - 0.5 + shift_x) + 1):
            dx = np.float32((tap + 0.5 - shift_x) * step)
            odd, low = (column + tap) % 2, (column + tap) // 2
            high = low + count
            shrink = inverse[i, odd, low:high]
            for k in range(count):
                e = shrink[k] * ((a[k] * dx + b[k] * dy) * dx + c[k] * dy * dy)
                weight[k] = _weight(e + bend * e * e)
            for plane in range(18):
                of, to = flux[plane // 6, plane % 6, i, odd, low:high], part[plane]
                for k in range(count):
                    to[k] += weight[k] * of[k]
            of, to = flux[3, 0, i, odd, low:high], part[18]
            for k in range(count):
                to[k] += weight[k] * of[k]
        for plane in range(19):
            of, total = part[plane], sums[plane]
            for k in range(count):
                total[k] += of[k]


@parallel
def convolve(
    flux: Floats,
    texels: Floats,
    inverse: Floats,
    towards: Floats,
    faces: Floats,
    rotated: Integers,
    sigma: float,
    narrow: float,
    dense: int,
    ghost: int,
    nodes: Floats,
) -> None:
    """Fill `nodes` (6, p N / 2 + 1 + 2 g, …, 3): the edges of the faces are nodes, `ghost` g more lie beyond.

    There are `dense` p nodes for every two texels. `flux` and `inverse` (N, 2, N / 2), 1 / (1 + r²), have the even
    columns before the odd ones, `texels` are the flux again, the four channels side by side. Turned to where +Z is,
    every face has the same weights: they are computed once. `rotated` (6, 6, 3) gives for each face at which flat
    place, and with what steps along rows and columns, the faces seen from there have their texels.
    """
    n, size = flux.shape[2], nodes.shape[1]
    step = 2.0 / n
    reach = 2.0 * math.asin(min(1.0, sigma * math.sqrt(0.5 * CUT)))
    for line in prange(size):
        down = 2.0 * (line - ghost) / dense
        row = math.floor(down)
        y = down * step - 1.0
        forms = np.empty((3, _RUN), np.float32)
        sums, part, weights = np.empty((19, _RUN)), np.empty((19, _RUN), np.float32), np.empty(_RUN, np.float32)
        at, alone = np.empty(12), np.empty((6, 4))
        for phase in range(dense):
            column = first = phase
            while column < size:
                ry = count = 0
                while column < size and count < _RUN and reach <= 0.5:
                    across = 2.0 * (column - ghost) / dense
                    x = across * step - 1.0
                    wide, high = _reach_in_texels(x, y, reach, n)
                    if min(down, n - down) < high + 1.0 or min(across, n - across) < wide + 1.0:
                        break
                    _form_at(x, y, sigma, narrow * step * step, forms, count)
                    ry = max(ry, int(high) + 1)
                    count += 1
                    column += dense
                across = 2.0 * (first - ghost) / dense
                if count:
                    left = math.floor(across)
                    ry = min(ry, row, n - 1 - row)
                    shift_y, shift_x, bend = down - row, across - left, 0.5 * sigma * sigma
                    _run(flux, inverse, row, left, count, shift_y, shift_x, forms, ry, reach, bend, sums, part, weights)
                    for k in range(count):
                        whole = 1.0 / sums[18, k]
                        for plane in range(18):
                            nodes[plane % 6, line, first + k * dense, plane // 6] = sums[plane, k] * whole
                else:
                    _shape_at(across * step - 1.0, y, sigma, narrow * step * step, at)
                    _gather(texels, n, towards, faces, rotated, at, reach, alone)
                    for own in range(6):
                        for k in range(3):
                            nodes[own, line, column, k] = alone[own, k] / alone[own, 3]
                    column += dense
                first = column


@parallel
def halve(padded: Floats, coarse: Floats) -> None:
    """Spread the flux of each texel over the three nearest of half as many, per axis 10 : 5 : 1; `coarse` (4, 6, N, N).

    That is a binomial of variance 5/16 and no skewness wherever a texel lies. `padded` (4, 6, 2 N + 4, 2 N + 4) has
    two texels of the adjoining faces around each face, and at its corners, where only three faces meet, its own corner
    mirrored, so that no flux is lost.
    """
    n = coarse.shape[2]
    for task in prange(4 * 6 * n):
        channel, face, i = task // (6 * n), task // n % 6, task % n
        rows = padded[channel, face, 2 * i : 2 * i + 6]
        r0, r1, r2, r3, r4, r5 = rows[0], rows[1], rows[2], rows[3], rows[4], rows[5]
        line = np.empty(2 * n + 4, np.float32)
        one, five, ten = np.float32(1 / 16), np.float32(5 / 16), np.float32(10 / 16)
        for k in range(2 * n + 4):
            line[k] = one * (r0[k] + r5[k]) + five * (r1[k] + r4[k]) + ten * (r2[k] + r3[k])
        for j in range(n):
            k = 2 * j
            outer, inner, middle = line[k] + line[k + 5], line[k + 1] + line[k + 4], line[k + 2] + line[k + 3]
            coarse[channel, face, i, j] = one * outer + five * inner + ten * middle


@parallel
def refine(nodes: Floats, factor: int, fine: Floats) -> None:
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
        line, values = np.zeros(3 * coarse + 3, np.float32), np.empty(3 * (coarse - 2), np.float32)
        a0, a1, a2, a3 = a[0], a[1], a[2], a[3]
        for k in range(3 * coarse):
            line[k] = a0 * first[k] + a1 * second[k] + a2 * third[k] + a3 * lowest[k]
        target = fine[face, row]
        for phase in range(factor):
            b0, b1, b2, b3 = weights[phase, 0], weights[phase, 1], weights[phase, 2], weights[phase, 3]
            for k in range(3 * (coarse - 2)):
                values[k] = b0 * line[k] + b1 * line[k + 3] + b2 * line[k + 6] + b3 * line[k + 9]
            for j in range((size - phase + factor - 1) // factor):
                at = j * factor + phase
                target[at, 0], target[at, 1], target[at, 2] = values[3 * j], values[3 * j + 1], values[3 * j + 2]


@scalar
def _spline(t: float, weights: Floats) -> None:
    """The four weights of the uniform cubic B-spline at t in [0, 1]."""
    s = 1.0 - t
    weights[0] = s * s * s / 6.0
    weights[1] = (4.0 - 6.0 * t * t + 3.0 * t * t * t) / 6.0
    weights[2] = (4.0 - 6.0 * s * s + 3.0 * s * s * s) / 6.0
    weights[3] = t * t * t / 6.0


@parallel
def energy(level: Floats, weight: Floats) -> NDArray[np.float64]:
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
def _bilinear(
    texels: Floats, start: int, cells: int, face: int, s: float, t: float, weight: float, value: Floats
) -> None:
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
    texels: Floats,
    starts: Integers,
    cells: Integers,
    level: Integers,
    share: Floats,
    mean: Floats,
    mean_share: Floats,
    faces: Floats,
    towards: Floats,
    values: Floats,
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
