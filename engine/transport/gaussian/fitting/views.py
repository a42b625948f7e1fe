"""The 92 view directions of Gaussian transport: the icosahedron of frequency 3, and the three views around a direction.

Each of the 20 faces is cut into nine triangles by points that divide it evenly and are then put on the sphere: 12 + 60
+ 20 points and 180 triangles. Seen from the centre, a face and its nine triangles stay triangles, so the triangle that
holds a direction is known from its coordinates on the face: the face is the one whose centre is nearest, and the whole
parts of three times the barycentric coordinates number the triangle. Nothing is searched for.

The weights are those with which the three views add up to the direction, scaled to sum 1: none is negative, they are
continuous over the sphere, and exactly (1, 0, 0) at a view. The same tables serve shaders (`view_tables`).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.core.kernels import scalar

VIEWS, TRIANGLES = 92, 180

#: Shares of the sum of weights below this are rounding errors: exactly at a view, the others weigh nothing.
ROUNDING = 1e-14

#: Into so many parts an edge of the icosahedron is cut.
FREQUENCY = 3

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class ViewTables:
    """Tables for finding the views around a direction d, on any CPU; all read-only.

    1. face: the largest component of `centres` @ d.
    2. (a, b, c) = `face_inverse`[face] @ d, made to sum 3; i = min(⌊a⌋, 2), j = min(⌊b⌋, 2 − i).
    3. triangle = `triangle`[face, i, j, k], k = 1 where (a − i) + (b − j) > 1 and i + j < 2, else 0.
    4. weights = `inverse`[triangle] @ d, not below 0, made to sum 1, of the views `corners`[triangle].

    Attributes
    ----------
    directions : (92, 3) unit vectors.
    corners : (180, 3) the views at the corners of each triangle, counter-clockwise from outside.
    inverse : (180, 3, 3) inverses of the matrices whose columns are the corners.
    centres : (20, 3) unit vectors to the centres of the faces. face_inverse : (20, 3, 3) as `inverse`.
    triangle : (20, 3, 3, 2) the number of a triangle on its face; 0 where there is none.
    """

    directions: Array
    corners: NDArray[np.int64]
    inverse: Array
    centres: Array
    face_inverse: Array
    triangle: NDArray[np.int64]


def view_directions() -> Array:
    """(92, 3) the views as unit vectors in the world, from the surface towards the viewer."""
    return view_tables().directions


def view_triangles() -> NDArray[np.int64]:
    """(180, 3) the views at the corners of each triangle, counter-clockwise from outside."""
    return view_tables().corners


@cache
def view_neighbours() -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The views (92, 6) joined to each by an edge of a triangle, in rising order and −1 behind them, and how many.

    The 12 corners of the icosahedron have five, all others six.
    """
    beside: list[set[int]] = [set() for _ in range(VIEWS)]
    for triangle in view_triangles():
        for corner in triangle:
            beside[corner].update(int(other) for other in triangle if other != corner)
    neighbours = np.full((VIEWS, 6), -1, np.int64)
    for view, others in enumerate(beside):
        neighbours[view, : len(others)] = sorted(others)
    return _freeze(neighbours), _freeze(np.array([len(others) for others in beside], np.int64))


def nearest_views(direction: ArrayLike) -> tuple[NDArray[np.int64], Array]:
    """The three views (..., 3) around each `direction` (..., 3) of any length but 0, and their weights (..., 3)."""
    towards = np.asarray(direction, np.float64)
    flat = np.ascontiguousarray(towards.reshape(-1, 3))
    index, weight = np.empty(flat.shape, np.int64), np.empty(flat.shape)
    tables = view_tables()
    nearest_views_kernel(
        flat,
        tables.centres,
        tables.face_inverse,
        tables.triangle,
        tables.corners,
        tables.inverse,
        index,
        weight,
    )
    return index.reshape(towards.shape), weight.reshape(towards.shape)


@scalar
def nearest_views_kernel(
    direction: NDArray[np.floating],
    centres: NDArray[np.floating],
    face_inverse: NDArray[np.floating],
    triangle: NDArray[np.integer],
    corners: NDArray[np.integer],
    inverse: NDArray[np.floating],
    index: NDArray[np.integer],
    weight: NDArray[np.floating],
) -> None:
    """`nearest_views` for (N, 3): fills `index` and `weight`; some 50 ns each, the rest are those of `ViewTables`."""
    for n in range(len(direction)):
        x, y, z = direction[n, 0], direction[n, 1], direction[n, 2]
        face, nearest = 0, -np.inf
        for f in range(len(centres)):
            along = centres[f, 0] * x + centres[f, 1] * y + centres[f, 2] * z
            if along > nearest:
                face, nearest = f, along
        m = face_inverse[face]
        a = m[0, 0] * x + m[0, 1] * y + m[0, 2] * z
        b = m[1, 0] * x + m[1, 1] * y + m[1, 2] * z
        c = m[2, 0] * x + m[2, 1] * y + m[2, 2] * z
        scale = 3.0 / (a + b + c)
        a, b = max(a * scale, 0.0), max(b * scale, 0.0)
        i = min(int(a), 2)
        j = min(int(b), 2 - i)
        turned = 1 if (a - i) + (b - j) > 1.0 and i + j < 2 else 0
        found = triangle[face, i, j, turned]
        total = 0.0
        for corner in range(3):
            row = inverse[found, corner]
            share = row[0] * x + row[1] * y + row[2] * z
            index[n, corner], weight[n, corner] = corners[found, corner], max(share, 0.0)
            total += weight[n, corner]
        kept = 0.0
        for corner in range(3):
            if weight[n, corner] < ROUNDING * total:
                weight[n, corner] = 0.0
            kept += weight[n, corner]
        for corner in range(3):
            weight[n, corner] /= kept


@cache
def view_tables() -> ViewTables:
    """The tables that belong to the 92 views, made once."""
    points, faces = _icosahedron()
    corners_of = points[faces]
    number: dict[tuple[int, ...], int] = {}
    directions: list[Array] = []

    def view(face: int, shares: tuple[int, int, int]) -> int:
        """The number of the point that divides a face in these shares; points of edges belong to two faces."""
        key = tuple(sorted((int(faces[face, k]), share) for k, share in enumerate(shares) if share))
        flat = tuple(part for pair in key for part in pair)
        if flat not in number:
            point = sum(share * points[corner] for corner, share in key)
            number[flat] = len(directions)
            directions.append(point / np.sqrt((point**2).sum()))
        return number[flat]

    corners = np.empty((TRIANGLES, 3), np.int64)
    triangle = np.zeros((20, FREQUENCY, FREQUENCY, 2), np.int64)
    count, cells = 0, [(i, j) for i in range(FREQUENCY) for j in range(FREQUENCY - i)]
    for face in range(20):
        for i, j in cells:
            k = FREQUENCY - 1 - i - j
            corners[count] = view(face, (i + 1, j, k)), view(face, (i, j + 1, k)), view(face, (i, j, k + 1))
            triangle[face, i, j, 0] = count
            count += 1
            if k > 0:
                k -= 1
                turned = (i, j + 1, k + 1), (i + 1, j, k + 1), (i + 1, j + 1, k)
                corners[count] = [view(face, shares) for shares in turned]
                triangle[face, i, j, 1] = count
                count += 1
    all_directions = np.array(directions)
    centres = corners_of.sum(axis=1)
    return ViewTables(
        _freeze(all_directions),
        _freeze(corners),
        _freeze(np.linalg.inv(all_directions[corners].swapaxes(1, 2))),
        _freeze(centres / np.linalg.norm(centres, axis=1)[:, None]),
        _freeze(np.linalg.inv(corners_of.swapaxes(1, 2))),
        _freeze(triangle),
    )


def _icosahedron() -> tuple[Array, NDArray[np.int64]]:
    """The twelve corners (12, 3) on the unit sphere and the faces (20, 3), counter-clockwise from outside."""
    golden = 0.5 * (1.0 + np.sqrt(5.0))
    points = np.array(
        [np.roll([0.0, one, other * golden], turn) for turn in range(3) for one in (1.0, -1.0) for other in (1.0, -1.0)]
    )
    apart = ((points[:, None] - points) ** 2).sum(axis=-1)
    joined = np.abs(apart - 4.0) < 0.1
    faces = []
    for a in range(12):
        for b in range(a + 1, 12):
            for c in range(b + 1, 12):
                if joined[a, b] and joined[b, c] and joined[a, c]:
                    outside = np.dot(points[a], np.cross(points[b], points[c])) > 0.0
                    faces.append((a, b, c) if outside else (a, c, b))
    return points / np.sqrt(1.0 + golden**2), np.array(faces, np.int64)


def _freeze(array: NDArray[Any]) -> NDArray[Any]:
    array.flags.writeable = False
    return array
