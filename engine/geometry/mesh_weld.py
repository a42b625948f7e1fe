"""Close the gaps that rounding leaves in meshes where faces share no vertices.

These are all faces of STL files, and seams of texture coordinates whose sides a program has computed apart.

Points of open edges that differ by less than `GAP` of the size of the mesh become one, the first of them. No face loses
its area by that: where two corners of one face are as near, all points there stay. Points fall into one where they
share a cell of one of eight grids, each shifted by half a cell along some axes, so that no border of a grid parts what
is near. Cost: about 1 s for a million points of open edges.
"""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.typing import NDArray

from engine.geometry.mesh_repair import LARGEST, Faces, Points, equal_rows, merge_points

#: Largest gap, as a share of the longest side of the bounding box: some steps of 32 bits, of which STL files are made.
GAP = 5e-7


def without_gaps(positions: Points, faces: Faces) -> tuple[Points, int]:
    """Positions (V, 3) with the gaps between open edges of `faces` (F, 3) closed, and how many points were moved."""
    usable = faces[np.all((faces >= 0) & (faces < len(positions)), axis=1)]
    usable = usable[np.all(np.abs(positions[usable]) <= LARGEST, axis=(1, 2))]
    if not len(usable):
        return positions, 0
    points, place = merge_points(positions)
    corners = place[usable]
    border = _border(corners, len(points))
    gap = GAP * float(np.max(np.ptp(points[corners.reshape(-1)], axis=0)))
    if not len(border) or gap == 0.0:
        return positions, 0
    group = _groups(points[border], gap)
    group[_are_stretched(points[border], group, 2.0 * gap)] = -1
    of_point = np.full(len(points), -1)
    of_point[border] = group
    a, b, c = of_point[corners].T
    for one, other in ((a, b), (b, c), (c, a)):
        group[np.isin(group, one[(one == other) & (one >= 0)])] = -1
    of_point[border] = group
    joined = np.flatnonzero(of_point >= 0)
    _, first, index = np.unique(of_point[joined], return_index=True, return_inverse=True)
    target = np.arange(len(points))
    target[joined] = joined[first][index.reshape(-1)]
    moved = target != np.arange(len(points))
    new = np.where(moved[place][:, None], points[target[place]], positions)
    return new, int(moved.sum())


def _border(corners: Faces, count: int) -> NDArray[np.int64]:
    """Points of edges that one face has."""
    edges = np.sort(corners[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    edges = edges[edges[:, 0] != edges[:, 1]]
    key, uses = np.unique(edges[:, 0] * count + edges[:, 1], return_counts=True)
    alone = key[uses == 1]
    return np.unique([alone // count, alone % count])


def _groups(points: Points, gap: float) -> NDArray[np.int64]:
    """The group (N,) of each point; points nearer than `gap` along all axes are in one."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    count = len(points)
    cells = (points - points.min(axis=0)) / (2.0 * gap)
    firsts = []
    for shift in product((0.0, 0.5), repeat=3):
        first, index = equal_rows(np.floor(cells + shift))
        firsts.append(first[index])
    links = (np.tile(np.arange(count), len(firsts)), np.concatenate(firsts))
    graph = coo_matrix((np.ones(len(links[0]), np.int8), links), shape=(count, count))
    return connected_components(graph, directed=False)[1].astype(np.int64)


def _are_stretched(points: Points, group: NDArray[np.int64], most: float) -> NDArray[np.bool_]:
    """True (N,) for points of a group that is longer than `most`: a chain of points, no gap."""
    low, high = (np.full((int(group.max()) + 1, 3), bound) for bound in (np.inf, -np.inf))
    np.minimum.at(low, group, points)
    np.maximum.at(high, group, points)
    stretched: NDArray[np.bool_] = np.any(high - low > most, axis=1)[group]
    return stretched
