"""Kernels of RGL measurements: values, densities and samples of the adaptive parametrisation, in float64.

Bounded by scattered reads: a value takes about 20 of the visible normals' tables and 24 of the colours, most of them
from the cache. Directions are independent, so the result does not depend on the number of threads.

Tables over the unit square are (P, T, Y, X): one slice per azimuth and elevation of the incident direction, each a
density that is bilinear between its nodes. `rows` (P, T, Y) holds the running integral over Y of whole rows, `columns`
(P, T, Y, X) that of each row over X, both 0 at first. Between slices densities and integrals are mixed linearly, so
what is inverted is the integral of the mixture itself.
"""

from __future__ import annotations

import numpy as np

from engine.core.kernels import parallel, prange, scalar

#: Of the Jacobian of a half vector's place: only at the very normal, where it vanishes, is it less.
MIN_JACOBIAN = 1e-12

#: Of the cosine that values are divided by, so that they stay finite at the horizon.
MIN_COSINE = 1e-9

#: tan² theta of a half vector below which its azimuth is a rounding error, and 0 is taken: 1e-8 radian.
AT_NORMAL = 1e-16


@scalar
def _interval(axis: np.ndarray, value: float) -> tuple[int, int, float]:
    """(lower node, upper node, weight of the upper), held at the ends of `axis`."""
    count = axis.size
    if count == 1:
        return 0, 0, 0.0
    low, high = 0, count - 1
    while high - low > 1:
        middle = (low + high) // 2
        if axis[middle] < value:
            low = middle
        else:
            high = middle
    weight = (value - axis[low]) / (axis[high] - axis[low])
    return low, high, min(max(weight, 0.0), 1.0)


@scalar
def _slices(
    phi_axis: np.ndarray, theta_axis: np.ndarray, phi: float, theta: float
) -> tuple[int, int, float, int, int, float]:
    """The slices around an incident direction: (p, q, weight of q, t, r, weight of r)."""
    p, q, p_weight = _interval(phi_axis, phi)
    t, r, t_weight = _interval(theta_axis, theta)
    return p, q, p_weight, t, r, t_weight


@scalar
def _mix_row(rows: np.ndarray, at: tuple[int, int, float, int, int, float], y: int) -> float:
    p, q, p_weight, t, r, t_weight = at
    value = (1.0 - t_weight) * rows[p, t, y] + t_weight * rows[p, r, y]
    if p_weight > 0.0:
        other = (1.0 - t_weight) * rows[q, t, y] + t_weight * rows[q, r, y]
        value = (1.0 - p_weight) * value + p_weight * other
    return value


@scalar
def _mix(table: np.ndarray, at: tuple[int, int, float, int, int, float], y: int, x: int) -> float:
    p, q, p_weight, t, r, t_weight = at
    value = (1.0 - t_weight) * table[p, t, y, x] + t_weight * table[p, r, y, x]
    if p_weight > 0.0:
        other = (1.0 - t_weight) * table[q, t, y, x] + t_weight * table[q, r, y, x]
        value = (1.0 - p_weight) * value + p_weight * other
    return value


@scalar
def _cell(u: float, count: int) -> tuple[int, float]:
    """(index of the cell, place inside) of `u` in [0, 1] between `count` nodes."""
    place = min(max(u, 0.0), 1.0) * (count - 1)
    index = min(int(place), count - 2)
    return index, place - index


@scalar
def _plain(table: np.ndarray, x: float, y: float) -> float:
    """A table (Y, X) of nodes, bilinear."""
    j, b = _cell(y, table.shape[0])
    i, a = _cell(x, table.shape[1])
    lower = (1.0 - a) * table[j, i] + a * table[j, i + 1]
    upper = (1.0 - a) * table[j + 1, i] + a * table[j + 1, i + 1]
    return (1.0 - b) * lower + b * upper


@scalar
def _density(density: np.ndarray, at: tuple[int, int, float, int, int, float], x: float, y: float) -> float:
    j, b = _cell(y, density.shape[2])
    i, a = _cell(x, density.shape[3])
    lower = (1.0 - a) * _mix(density, at, j, i) + a * _mix(density, at, j, i + 1)
    upper = (1.0 - a) * _mix(density, at, j + 1, i) + a * _mix(density, at, j + 1, i + 1)
    return (1.0 - b) * lower + b * upper


@scalar
def _invert(
    density: np.ndarray,
    columns: np.ndarray,
    rows: np.ndarray,
    at: tuple[int, int, float, int, int, float],
    x: float,
    y: float,
) -> tuple[float, float, float]:
    """Uniform numbers in the unit square that the warp sends to (x, y), and the density there."""
    height, width = density.shape[2], density.shape[3]
    j, b = _cell(y, height)
    i, a = _cell(x, width)
    left = (1.0 - b) * _mix(density, at, j, i) + b * _mix(density, at, j + 1, i)
    right = (1.0 - b) * _mix(density, at, j, i + 1) + b * _mix(density, at, j + 1, i + 1)
    before = (1.0 - b) * _mix(columns, at, j, i) + b * _mix(columns, at, j + 1, i)
    lower, upper = _mix(columns, at, j, width - 1), _mix(columns, at, j + 1, width - 1)
    whole = (1.0 - b) * lower + b * upper
    u = x
    if whole > 0.0:
        u = (before + a * (left + 0.5 * a * (right - left)) / (width - 1)) / whole
    v = _mix_row(rows, at, j) + b * (lower + 0.5 * b * (upper - lower)) / (height - 1)
    return u, v, (1.0 - a) * left + a * right


@scalar
def _part(share: float, first: float, second: float) -> float:
    """t in [0, 1] at which the integral of the line from `first` to `second` is `share`, in units of the interval."""
    total = 0.5 * (first + second)
    if total <= 0.0:
        return 0.5
    root = np.sqrt(max(first * first + 2.0 * share * (second - first), 0.0))
    return min(max(2.0 * share / max(first + root, 1e-300), 0.0), 1.0)


@scalar
def _draw(
    density: np.ndarray,
    columns: np.ndarray,
    rows: np.ndarray,
    at: tuple[int, int, float, int, int, float],
    u: float,
    v: float,
) -> tuple[float, float, float]:
    """(x, y, density there) of uniform numbers (u, v); the inverse of `_invert`."""
    height, width = density.shape[2], density.shape[3]
    low, high = 0, height - 1
    while high - low > 1:
        middle = (low + high) // 2
        if _mix_row(rows, at, middle) <= v:
            low = middle
        else:
            high = middle
    lower, upper = _mix(columns, at, low, width - 1), _mix(columns, at, high, width - 1)
    b = _part((v - _mix_row(rows, at, low)) * (height - 1), lower, upper)
    target = u * ((1.0 - b) * lower + b * upper)
    left, right = 0, width - 1
    while right - left > 1:
        middle = (left + right) // 2
        if (1.0 - b) * _mix(columns, at, low, middle) + b * _mix(columns, at, high, middle) <= target:
            left = middle
        else:
            right = middle
    before = (1.0 - b) * _mix(columns, at, low, left) + b * _mix(columns, at, high, left)
    first = (1.0 - b) * _mix(density, at, low, left) + b * _mix(density, at, high, left)
    second = (1.0 - b) * _mix(density, at, low, right) + b * _mix(density, at, high, right)
    a = _part((target - before) * (width - 1), first, second)
    return (left + a) / (width - 1), (low + b) / (height - 1), (1.0 - a) * first + a * second


@scalar
def _signs(reduction: int, x: float, y: float) -> tuple[float, float]:
    """Signs of x and y that bring a direction to the measured azimuths, by the symmetry of the file.

    2 is a half turn (to y ≤ 0), 4 two mirrors (to x ≤ 0 and y ≤ 0), as the files of the database have it.
    """
    if reduction < 2:
        return 1.0, 1.0
    y_sign = -1.0 if y > 0.0 else 1.0
    if reduction == 4:
        return -1.0 if x > 0.0 else 1.0, y_sign
    return y_sign, y_sign


@scalar
def _place(relative: bool, phi: float, x: float, y: float, z: float) -> tuple[float, float]:
    """The unit square's (x, y) for a half vector; `relative` files count its azimuth from the incident one, `phi`."""
    across = x * x + y * y
    turn = 0.5
    if across > AT_NORMAL * z * z:
        turn += (np.arctan2(y, x) - (phi if relative else 0.0)) / (2.0 * np.pi)
    return np.sqrt(np.arctan2(np.sqrt(across), z) * (2.0 / np.pi)), turn - np.floor(turn)


@scalar
def _usable(directions: np.ndarray, n: int) -> bool:
    """Above the horizon and finite; a NaN would become a place in memory."""
    z = directions[n, 2]
    return z > 0.0 and np.isfinite(directions[n, 0] + directions[n, 1] + z)


@scalar
def _colour(
    colours: np.ndarray, at: tuple[int, int, float, int, int, float], j: int, i: int, b: float, a: float, channel: int
) -> float:
    p, q, p_weight, t, r, t_weight = at
    value = (1.0 - t_weight) * _patch(colours, p, t, j, i, b, a, channel)
    value += t_weight * _patch(colours, p, r, j, i, b, a, channel)
    if p_weight > 0.0:
        other = (1.0 - t_weight) * _patch(colours, q, t, j, i, b, a, channel)
        other += t_weight * _patch(colours, q, r, j, i, b, a, channel)
        value = (1.0 - p_weight) * value + p_weight * other
    return value


@scalar
def _patch(colours: np.ndarray, p: int, t: int, j: int, i: int, b: float, a: float, channel: int) -> float:
    lower = (1.0 - a) * colours[p, t, j, i, channel] + a * colours[p, t, j, i + 1, channel]
    upper = (1.0 - a) * colours[p, t, j + 1, i, channel] + a * colours[p, t, j + 1, i + 1, channel]
    return (1.0 - b) * lower + b * upper


@parallel
def values(
    phi_axis: np.ndarray,
    theta_axis: np.ndarray,
    reduction: int,
    relative: bool,
    density: np.ndarray,
    columns: np.ndarray,
    rows: np.ndarray,
    lowest: float,
    colours: np.ndarray,
    scaled: bool,
    ndf: np.ndarray,
    sigma: np.ndarray,
    wi: np.ndarray,
    wo: np.ndarray,
    out: np.ndarray,
) -> None:
    """Fill out (N, 3) with values in 1/sr, not below `lowest`, for incident wi (N, 3) and outgoing wo (N, 3).

    colours (P, T, Y, X, 3) times, where `scaled`, ndf / (4 sigma); over the outgoing cosine.
    """
    for n in prange(wi.shape[0]):
        out[n, 0], out[n, 1], out[n, 2] = 0.0, 0.0, 0.0
        if not (_usable(wi, n) and _usable(wo, n)):
            continue
        x_sign, y_sign = _signs(reduction, wi[n, 0], wi[n, 1])
        x, y, z = x_sign * wi[n, 0], y_sign * wi[n, 1], wi[n, 2]
        theta, phi = np.arctan2(np.sqrt(x * x + y * y), z), np.arctan2(y, x)
        at = _slices(phi_axis, theta_axis, phi, theta)
        u, v = _place(relative, phi, x + x_sign * wo[n, 0], y + y_sign * wo[n, 1], z + wo[n, 2])
        sample_x, sample_y, _ = _invert(density, columns, rows, at, u, v)
        scale = 1.0 / max(wo[n, 2], MIN_COSINE)
        if scaled:
            area = _plain(sigma, np.sqrt(theta * (2.0 / np.pi)), (phi + np.pi) / (2.0 * np.pi))
            scale = scale * _plain(ndf, u, v) / (4.0 * area) if area > 0.0 else 0.0
        j, b = _cell(sample_y, colours.shape[2])
        i, a = _cell(sample_x, colours.shape[3])
        for channel in range(3):
            out[n, channel] = max(_colour(colours, at, j, i, b, a, channel) * scale, lowest)


@parallel
def densities(
    phi_axis: np.ndarray,
    theta_axis: np.ndarray,
    reduction: int,
    relative: bool,
    density: np.ndarray,
    columns: np.ndarray,
    rows: np.ndarray,
    luminance: np.ndarray,
    fixed: np.ndarray,
    drawn: np.ndarray,
    out: np.ndarray,
) -> None:
    """Fill out (N,) with the density in 1/sr at which `samples` draws `drawn` (N, 3) for `fixed` (N, 3).

    Also below the horizon, where a mirrored direction may end; 0 where `fixed` is not above it.
    """
    for n in prange(fixed.shape[0]):
        out[n] = 0.0
        if not (_usable(fixed, n) and np.isfinite(drawn[n, 0] + drawn[n, 1] + drawn[n, 2])):
            continue
        x_sign, y_sign = _signs(reduction, fixed[n, 0], fixed[n, 1])
        x, y, z = x_sign * fixed[n, 0], y_sign * fixed[n, 1], fixed[n, 2]
        theta, phi = np.arctan2(np.sqrt(x * x + y * y), z), np.arctan2(y, x)
        at = _slices(phi_axis, theta_axis, phi, theta)
        half_x, half_y, half_z = x + x_sign * drawn[n, 0], y + y_sign * drawn[n, 1], z + drawn[n, 2]
        length = np.sqrt(half_x * half_x + half_y * half_y + half_z * half_z)
        if length == 0.0:
            continue
        side = -1.0 if half_z < 0.0 else 1.0
        u, v = _place(relative, phi, side * half_x, side * half_y, side * half_z)
        sample_x, sample_y, visible = _invert(density, columns, rows, at, u, v)
        sine = np.sqrt(half_x * half_x + half_y * half_y) / length
        cosine = abs(x * half_x + y * half_y + z * half_z) / length
        jacobian = max(2.0 * np.pi * np.pi * u * sine, MIN_JACOBIAN) * 4.0 * cosine
        if jacobian > 0.0:
            out[n] = visible * _density(luminance, at, sample_x, sample_y) / jacobian


@parallel
def samples(
    phi_axis: np.ndarray,
    theta_axis: np.ndarray,
    reduction: int,
    relative: bool,
    density: np.ndarray,
    columns: np.ndarray,
    rows: np.ndarray,
    luminance: np.ndarray,
    luminance_columns: np.ndarray,
    luminance_rows: np.ndarray,
    fixed: np.ndarray,
    uniform: np.ndarray,
    out: np.ndarray,
) -> None:
    """Fill out (N, 3) with directions drawn for `fixed` (N, 3) by uniform (N, 2): the normal where it is not above."""
    for n in prange(fixed.shape[0]):
        out[n, 0], out[n, 1], out[n, 2] = 0.0, 0.0, 1.0
        if not (_usable(fixed, n) and np.isfinite(uniform[n, 0] + uniform[n, 1])):
            continue
        x_sign, y_sign = _signs(reduction, fixed[n, 0], fixed[n, 1])
        x, y, z = x_sign * fixed[n, 0], y_sign * fixed[n, 1], fixed[n, 2]
        theta, phi = np.arctan2(np.sqrt(x * x + y * y), z), np.arctan2(y, x)
        at = _slices(phi_axis, theta_axis, phi, theta)
        u, v, _ = _draw(luminance, luminance_columns, luminance_rows, at, uniform[n, 1], uniform[n, 0])
        place_x, place_y, _ = _draw(density, columns, rows, at, u, v)
        phi_half = (2.0 * place_y - 1.0) * np.pi
        if relative:
            phi_half += phi
        theta_half = place_x * place_x * (0.5 * np.pi)
        half_x = np.sin(theta_half) * np.cos(phi_half)
        half_y = np.sin(theta_half) * np.sin(phi_half)
        half_z = np.cos(theta_half)
        twice = 2.0 * (x * half_x + y * half_y + z * half_z)
        out[n, 0] = x_sign * (twice * half_x - x)
        out[n, 1] = y_sign * (twice * half_y - y)
        out[n, 2] = twice * half_z - z
