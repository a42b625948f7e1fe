"""Overlaps of cube texels with equirectangular texels, added up along meridians.

Along a meridian both maps are cut into segments; in sin(latitude), in which areas on the sphere are lengths, the length
of a segment times the width of the meridian's slice is the overlap. On the upright faces a column of texels lies
between two meridians, so the only error is that of two-point quadrature of a smooth function; on +Y and −Y the slices
cut texels obliquely, and the areas returned are those that the slices cover. Bound by the segments: some 6 ns each.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from engine.core.kernels import parallel, prange, scalar

Integers = NDArray[np.integer]
Floats = NDArray[np.floating]

#: Faces by azimuth, from −Z over +X and +Z to −X.
_UPRIGHT = np.array([5, 0, 4, 1])


@scalar
def _side_edge(row: int, n: int, cosine: float) -> float:
    """sin(latitude) of the upper edge of a row of an upright face where the longitude is off its middle."""
    height = (1.0 - 2.0 * row / n) * cosine
    return height / math.sqrt(1.0 + height * height)


@scalar
def _add(target: Floats, area: Floats, source: Floats, forward: bool, texel: int, cell: int, weight: float) -> None:
    """One overlap of a cube texel and an equirectangular cell, by their flat numbers; `forward` goes to the cube."""
    to, of = (texel, cell) if forward else (cell, texel)
    for k in range(3):
        target[to, k] += weight * source[of, k]
    area[to] += weight


@scalar
def _walk_side(
    target: Floats,
    area: Floats,
    source: Floats,
    shape: tuple[int, int, int, bool],
    edges: Floats,
    azimuth: float,
    width: float,
    c: int,
    side: int,
) -> None:
    """Down the part of a meridian that an upright face shows."""
    n, height, columns, forward = shape
    quadrant = side // n
    face, j = _UPRIGHT[quadrant], n - 1 - side % n
    cosine = math.cos(azimuth - 0.5 * math.pi * quadrant)
    at = _side_edge(0, n, cosine)
    r = 0
    while r < height - 1 and edges[r + 1] >= at:
        r += 1
    for i in range(n):
        below = _side_edge(i + 1, n, cosine)
        while r < height - 1 and edges[r + 1] > below:
            _add(target, area, source, forward, (face * n + i) * n + j, r * columns + c, width * (at - edges[r + 1]))
            at = edges[r + 1]
            r += 1
        _add(target, area, source, forward, (face * n + i) * n + j, r * columns + c, width * (at - below))
        at = below


@scalar
def _walk_pole(
    target: Floats,
    area: Floats,
    source: Floats,
    shape: tuple[int, int, int, bool],
    edges: Floats,
    azimuth: float,
    width: float,
    c: int,
    pole: int,
) -> None:
    """From the middle of +Y (pole 0) or −Y (1) to the rim; the face's plane has its distances as cot(latitude)."""
    n, height, columns, forward = shape
    across = math.sin(azimuth)
    down = -math.cos(azimuth) if pole == 0 else math.cos(azimuth)
    rim = 1.0 / max(abs(across), abs(down))
    i = j = n // 2
    if n % 2 == 0:
        i -= down < 0.0
        j -= across < 0.0
    step_i, step_j = (1 if down > 0.0 else -1), (1 if across > 0.0 else -1)
    r = 0
    at, sine_at = 0.0, 1.0
    while at < rim:
        edge_i, edge_j = i + (step_i > 0), j + (step_j > 0)
        to_i = abs(2.0 * edge_i / n - 1.0) / abs(down) if down != 0.0 else math.inf
        to_j = abs(2.0 * edge_j / n - 1.0) / abs(across) if across != 0.0 else math.inf
        texel_ends = min(to_i, to_j, rim)
        sine = 1.0 / math.sqrt(1.0 + texel_ends * texel_ends)
        row = height - 1 - r if pole else r
        row_ends = -edges[row] if pole else edges[row + 1]
        if row_ends > sine and r < height - 1:
            _add(
                target,
                area,
                source,
                forward,
                ((2 + pole) * n + i) * n + j,
                row * columns + c,
                width * (sine_at - row_ends),
            )
            sine_at = row_ends
            r += 1
            continue
        _add(target, area, source, forward, ((2 + pole) * n + i) * n + j, row * columns + c, width * (sine_at - sine))
        at, sine_at = texel_ends, sine
        if at < rim:
            i += step_i * (to_i == texel_ends)
            j += step_j * (to_j == texel_ends)


@parallel
def _fill_faces(
    target: Floats,
    area: Floats,
    source: Floats,
    shape: tuple[int, int, int, bool],
    edges: Floats,
    azimuth: Floats,
    width: Floats,
    column: Integers,
    side: Integers,
    first: Integers,
) -> None:
    """Each task owns its texels: the two faces at the poles, and then each column of the upright ones."""
    for task in prange(len(first) + 1):
        if task < 2:
            for m in range(len(azimuth)):
                _walk_pole(target, area, source, shape, edges, azimuth[m], width[m], column[m], task)
        else:
            for m in range(first[task - 2], first[task - 1]):
                _walk_side(target, area, source, shape, edges, azimuth[m], width[m], column[m], side[m])


@parallel
def _fill_rows(
    target: Floats,
    area: Floats,
    source: Floats,
    shape: tuple[int, int, int, bool],
    edges: Floats,
    azimuth: Floats,
    width: Floats,
    column: Integers,
    side: Integers,
    first: Integers,
) -> None:
    """Each task owns a column of the equirectangular map."""
    for task in prange(len(first) - 1):
        for m in range(first[task], first[task + 1]):
            _walk_side(target, area, source, shape, edges, azimuth[m], width[m], column[m], side[m])
            _walk_pole(target, area, source, shape, edges, azimuth[m], width[m], column[m], 0)
            _walk_pole(target, area, source, shape, edges, azimuth[m], width[m], column[m], 1)


def to_faces(
    rows: Floats, n: int, azimuth: Floats, width: Floats, column: Integers, side: Integers
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Flux (6, N, N, 3) and covered area (6, N, N) of cube texels from radiance `rows` (H, W, 3)."""
    flux, area = np.zeros((6 * n * n, 3)), np.zeros(6 * n * n)
    first = np.searchsorted(side, np.arange(4 * n + 1))
    edges = np.cos(np.linspace(0.0, np.pi, len(rows) + 1))
    shape = (n, *rows.shape[:2], True)
    _fill_faces(flux, area, rows.reshape(-1, 3), shape, edges, azimuth, width, column, side, first)
    return flux.reshape(6, n, n, 3), area.reshape(6, n, n)


def to_rows(
    faces: Floats, height: int, azimuth: Floats, width: Floats, column: Integers, side: Integers
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Flux (H, 2 H, 3) and covered area (H, 2 H) of equirectangular texels from radiance `faces` (6, N, N, 3)."""
    columns = 2 * height
    flux, area = np.zeros((height * columns, 3)), np.zeros(height * columns)
    order = np.argsort(column, kind="stable")
    azimuth, width, column, side = azimuth[order], width[order], column[order], side[order]
    first = np.searchsorted(column, np.arange(columns + 1))
    edges = np.cos(np.linspace(0.0, np.pi, height + 1))
    shape = (faces.shape[1], height, columns, False)
    _fill_rows(flux, area, faces.reshape(-1, 3), shape, edges, azimuth, width, column, side, first)
    return flux.reshape(height, columns, 3), area.reshape(height, columns)
