"""Polygons of any number of corners as files hold them, and how they are cut into triangles.

Convex polygons become fans. A quadrilateral with an inward corner is cut from that corner; other polygons with inward
corners lose their ears one by one (Meisters1975, 'Polygons have ears') in the plane of their Newell normal. Every
polygon of n corners gives n − 2 triangles, also where it crosses itself and no cut is right.
Ours instead of mapbox_earcut's, which takes one polygon a call and leaves out ears without area, so that edges of
neighbours would stay open.
Cost: about 0.1 s for a million convex polygons; an ear costs as many steps as the polygon has corners.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.core.kernels import only, scalar

#: A corner turns inwards where the cross product of its edges lies against the normal by this share of its bound.
INWARD = 1e-9

#: Polygons of more corners are cut as fans, whatever their shape: ears would take minutes.
MAX_CORNERS = 20_000


@dataclass(frozen=True, eq=False)
class Polygons:
    """Polygons of a file.

    Attributes
    ----------
    points : (P, 3) float64.
    corners : (C,) int64 indices of points, those of one polygon after those of the other; they may be wrong.
    sizes : (N,) int64 corners of each polygon, C together.
    normals : (C, 3) float64 of the corners, NaN where the file states none; None where it states none at all.
    uv : (C, 2) float64 texture coordinates of the corners, v up, likewise.
    colours : (C, 3) float64 linear colours of the corners, likewise.
    part : (N,) int64 for each polygon the place of its material among `part_names`; None where the file has none.
    """

    points: NDArray[np.float64]
    corners: NDArray[np.int64]
    sizes: NDArray[np.int64]
    normals: NDArray[np.float64] | None = None
    uv: NDArray[np.float64] | None = None
    colours: NDArray[np.float64] | None = None
    part: NDArray[np.int64] | None = None
    part_names: tuple[str, ...] = ()


def triangulate(polygons: Polygons) -> NDArray[np.int64]:
    """(T, 3) indices into `polygons.corners`, in the order of the polygons; those of fewer than 3 corners give none."""
    sizes = polygons.sizes
    if (sizes == 3).all():
        return np.arange(len(polygons.corners)).reshape(-1, 3)
    first = np.cumsum(sizes) - sizes
    inside = (polygons.corners >= 0) & (polygons.corners < len(polygons.points))
    points = polygons.points[np.where(inside, polygons.corners, 0)]
    parts = [_triangulate_size(points, first[sizes == size], int(size)) for size in np.unique(sizes[sizes >= 3])]
    if not parts:
        return np.empty((0, 3), np.int64)
    triangles = np.concatenate([part.reshape(-1, 3) for part in parts])
    return triangles[np.argsort(triangles[:, 0], kind="stable")] if len(parts) > 1 else triangles


def _triangulate_size(points: NDArray[np.float64], first: NDArray[np.int64], size: int) -> NDArray[np.int64]:
    """(polygons, size − 2, 3) triangles of the polygons whose `size` corners begin at `first`."""
    steps = np.arange(size - 2)
    fan = np.stack([np.zeros_like(steps), steps + 1, steps + 2], axis=-1)
    local = np.broadcast_to(fan, (len(first), *fan.shape))
    if 3 < size <= MAX_CORNERS:
        local = np.array(local)
        flat, inward = _flatten(points[first[:, None] + np.arange(size)])
        concave = np.flatnonzero(inward.any(axis=1))
        if size == 4:
            local[concave] = (local[concave] + np.argmax(inward[concave], axis=1)[:, None, None]) % 4
        else:
            for polygon in concave:
                local[polygon] = _without_ears(flat[polygon])
    return first[:, None, None] + local


def _flatten(corners: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """(N, size, 2) polygons seen along their normal, counter-clockwise, and (N, size) which corners turn inwards."""
    with np.errstate(over="ignore", invalid="ignore"):
        corners = corners - corners[:, :1]
        extent = np.max(np.abs(corners), axis=(1, 2), keepdims=True)
        corners = np.nan_to_num(corners / np.where(extent > 0.0, extent, 1.0), nan=0.0, posinf=0.0, neginf=0.0)
    normal = np.sum(np.cross(corners, np.roll(corners, -1, axis=1)), axis=1)
    axis = np.argmax(np.abs(normal), axis=1)
    rows = np.arange(len(corners))
    flat = np.stack([corners[rows, :, (axis + 1) % 3], corners[rows, :, (axis + 2) % 3]], axis=-1)
    flat[..., 1] *= np.where(normal[rows, axis] < 0.0, -1.0, 1.0)[:, None]
    before, after = flat - np.roll(flat, 1, axis=1), np.roll(flat, -1, axis=1) - flat
    turn = before[..., 0] * after[..., 1] - before[..., 1] * after[..., 0]
    return flat, turn < -INWARD


def _without_ears(flat: NDArray[np.float64]) -> NDArray[np.int64]:
    triangles: NDArray[np.int64] = _cut_ears(np.ascontiguousarray(flat))
    # the first corner names the polygon when triangles are put in order
    return triangles


@scalar
def _cut_ears(p: np.ndarray) -> np.ndarray:
    """(n − 2, 3) triangles of the counter-clockwise polygon p (n, 2); n² steps in the usual case."""
    count = p.shape[0]
    before = np.arange(count) - 1
    before[0] = count - 1
    after = (np.arange(count) + 1) % count
    triangles = np.empty((count - 2, 3), np.int64)
    corner, tried, best, best_area = 0, 0, 0, -np.inf
    left, cut = count, 0
    while left > 3:
        a, c = before[corner], after[corner]
        area = _area(p, a, corner, c)
        empty = area > 0.0
        if area > best_area:
            best, best_area = corner, area
        other = after[c]
        while empty and other != a:
            empty = not _holds(p, a, corner, c, other)
            other = after[other]
        tried += 1
        if not empty and tried < left:
            corner = c
            continue
        if not empty:  # no ear anywhere: the polygon crosses itself or is flat
            corner = best
            a, c = before[corner], after[corner]
        triangles[cut] = (a, corner, c)
        cut += 1
        after[a], before[c] = c, a
        corner, tried, best_area, left = c, 0, -np.inf, left - 1
    triangles[cut] = (before[corner], corner, after[corner])
    return triangles


@scalar
def _area(p: np.ndarray, a: int, b: int, c: int) -> float:
    return (p[b, 0] - p[a, 0]) * (p[c, 1] - p[a, 1]) - (p[b, 1] - p[a, 1]) * (p[c, 0] - p[a, 0])


@scalar
def _holds(p: np.ndarray, a: int, b: int, c: int, other: int) -> bool:
    """True if the triangle a, b, c holds the corner `other`, which is none of its own corners met a second time."""
    for own in (a, b, c):
        if p[own, 0] == p[other, 0] and p[own, 1] == p[other, 1]:
            return False
    return _area(p, a, b, other) >= 0.0 and _area(p, b, c, other) >= 0.0 and _area(p, c, a, other) >= 0.0


def make_from_polygons(polygons: Polygons) -> dict[str, Any]:
    """The triangles as `faces` (T, 3) with `normals`, `uv` and `colours` (T, 3, …) of their corners, or None.

    Likewise `part` (T,), with `part_names`.
    """
    triangles = triangulate(polygons)
    part = None
    if polygons.part is not None:
        part = np.repeat(polygons.part, polygons.sizes)[triangles[:, 0]]
    return {
        "faces": polygons.corners[triangles],
        "normals": None if polygons.normals is None else polygons.normals[triangles],
        "uv": None if polygons.uv is None else polygons.uv[triangles],
        "colours": None if polygons.colours is None else polygons.colours[triangles],
        "part": part,
        "part_names": list(polygons.part_names),
    }


def prepare() -> None:
    """Compile before the process gives up what compiling needs."""
    only(_cut_ears, "int64[:, ::1](float64[:, ::1])")
