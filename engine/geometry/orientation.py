"""Orientation of the faces of a mesh: neighbours alike, closed parts outwards.

Faces that share an edge with no third one form patches. Within a patch all faces are turned alike where that is
possible, which it is not on a Möbius strip. Then a patch that is closed, but for small holes, gets a positive volume;
one inside another turns with that, so that the hollow of a thick wall stays one. An open patch is turned as most of its
area was, by its normals where the file states them: either side of it may be the front.
Cost: about 0.5 s for 100,000 faces, most of it in sorting edges.
"""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from engine.geometry.mesh_repair import Faces, Points, blocks_of, equal_rows, list_used

Bools = NDArray[np.bool_]

#: What is done with the orientation of a file: mended, kept, or kept and turned to the other side as a whole.
Orientation = Literal["auto", "keep", "flip"]
ORIENTATIONS: tuple[Orientation, ...] = get_args(Orientation)

#: Share of holes in the area of a patch up to which its volume tells the outside, by the rim of each as if it were
#: round, and the least volume over area^1.5 that tells it (a sphere has 0.094).
HOLES, MIN_VOLUME = 0.1, 1e-3

#: Most closed patches of which it is found which lies in which.
MAX_NESTED = 64


def find_turned(points: Points, faces: Faces, votes: NDArray[np.float64]) -> Bools:
    """(F,) which of `faces` (F, 3) between different `points` (P, 3) are to be turned.

    `votes` (F,) are areas, negative where the stated normals are those of the other side. Two faces at the same place,
    which are the sides of a sheet, count once and stay turned against each other.
    """
    first, sheet = equal_rows(np.sort(faces, axis=1))
    if len(first) < len(faces):
        return np.asarray(find_turned(points, faces[first], votes[first])[sheet])
    del first, sheet
    corners = faces.astype(np.int32)  # half the memory
    begin, end = corners.reshape(-1), corners[:, [1, 2, 0]].reshape(-1)  # of each edge
    key = np.minimum(begin, end) * np.int64(len(points)) + np.maximum(begin, end)
    order = np.argsort(key, kind="stable")
    starts = np.flatnonzero(np.concatenate([[True], np.diff(key[order]) != 0]))
    sizes = np.diff(np.append(starts, len(key)))
    pairs = order[starts[sizes == 2][:, None] + np.arange(2)]
    clashing = begin[pairs[:, 0]] == begin[pairs[:, 1]]
    alone, crowded = order[starts[sizes == 1]], order[np.repeat(sizes > 2, sizes)]
    of_crowded = key[crowded]
    pairs //= 3
    del key, order, starts, sizes  # what follows takes as much memory again
    patch, parity = _colour(len(faces), pairs, clashing)
    del pairs, clashing
    # an edge of one face of a patch is its rim, whatever other patches meet there
    _, first, times = np.unique(
        np.stack([patch[crowded // 3], of_crowded]), axis=1, return_index=True, return_counts=True
    )
    rim = np.concatenate([alone, crowded[first[times == 1]]])
    sign = np.where(parity, -1.0, 1.0)
    area, volume = _measure(points, faces, patch, sign)
    length = np.linalg.norm(points[end[rim]] - points[begin[rim]], axis=1)
    holes = _measure_holes(patch[rim // 3], begin[rim], end[rim], length, len(area))
    turned = np.bincount(patch, sign * votes) < 0.0
    is_closed = (holes <= HOLES * area) & (np.abs(volume) > MIN_VOLUME * area**1.5)
    turned[is_closed] = volume[is_closed] < 0.0
    of_one_side = np.bincount(patch, parity) == 0.0
    _turn_with_outer(points, faces, patch, is_closed & (holes == 0.0), turned, of_one_side)
    return np.asarray(parity ^ turned[patch])


def _colour(count: int, pairs: Faces, clashing: Bools) -> tuple[Faces, Bools]:
    """The patch (F,) of each face, and whether it is turned against the first of its patch.

    Each face stands for itself and for its other side in a graph of sides that agree: where a patch has two sides,
    its faces fall into two parts.
    """
    one, other = pairs.T.astype(np.int32)
    across = np.where(clashing, np.int32(count), np.int32(0))
    rows = np.concatenate([one, one + count])
    sides = _connect(rows, np.concatenate([other + across, other + count - across]), 2 * count)
    front, back = sides[:count], sides[count:]
    side = np.minimum(front, back)
    first = np.empty(2 * count, np.int64)
    first[side[::-1]] = np.arange(count - 1, -1, -1)  # the last that is written is the first face
    patch = list_used(side, 2 * count)[1][side]
    return patch, np.asarray((front != front[first[side]]) & (front != back))


def _measure(
    points: Points, faces: Faces, patch: Faces, sign: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Area of each patch, and its volume about its centre; faces have a `sign`."""
    size, of_face = np.empty(len(faces)), np.empty((len(faces), 3))
    for block in blocks_of(len(faces)):
        a, b, c = (points[faces[block, corner]] for corner in range(3))
        size[block] = np.linalg.norm(0.5 * np.cross(b - a, c - a), axis=1)
        of_face[block] = size[block, None] * ((a + b + c) / 3.0)
    area = _add_up(patch, size)
    weighted = np.stack([_add_up(patch, axis) for axis in of_face.T], axis=-1)
    middle = weighted / np.maximum(area, np.finfo(float).tiny)[:, None]
    volume = size  # in its place
    for block in blocks_of(len(faces)):
        a, b, c = (points[faces[block, corner]] for corner in range(3))
        directed = 0.5 * np.cross(b - a, c - a)
        volume[block] = sign[block] * np.einsum("fi,fi->f", directed, a - middle[patch[block]]) / 3.0
    return area, _add_up(patch, volume)


def _measure_holes(
    patch: Faces, begin: Faces, end: Faces, length: NDArray[np.float64], count: int
) -> NDArray[np.float64]:
    """(count,) area of the holes of each patch, as if each were round, by the edges of its rims and their lengths."""
    if not len(patch):
        return np.zeros(count)
    # rims of two patches that meet at a point are apart
    ends, place = np.unique(np.stack([np.tile(patch, 2), np.concatenate([begin, end])]), axis=1, return_inverse=True)
    one, other = place.reshape(2, -1)
    rim = _connect(one, other, ends.shape[1])
    around = _add_up(rim[one], length)
    of_patch = np.zeros(len(around), np.int64)
    of_patch[rim[one]] = patch
    return np.asarray(np.bincount(of_patch, around**2 / (4.0 * np.pi), count))


def _connect(one: Faces, other: Faces, count: int) -> Faces:
    """(count,) the number of the part that each node belongs to, where nodes `one` and `other` (E,) are connected."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    joined = coo_matrix((np.ones(len(one), np.int8), (one, other)), shape=(count, count))
    return np.asarray(connected_components(joined, directed=False)[1], np.int64)


def _add_up(patch: Faces, values: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(np.bincount(patch, values), np.float64)


def _turn_with_outer(
    points: Points, faces: Faces, patch: Faces, closed: Bools, turned: Bools, of_one_side: Bools
) -> None:
    """Set in `turned` what lies within another `closed` patch as that is, where its faces were `of_one_side` before."""
    candidates = np.flatnonzero(closed).tolist()
    if not 1 < len(candidates) <= MAX_NESTED:
        return
    corners = {each: points[faces[patch == each]] for each in candidates}
    boxes = {each: (corner.min(axis=(0, 1)), corner.max(axis=(0, 1))) for each, corner in corners.items()}
    larger: list[int] = []
    for each in sorted(candidates, key=lambda each: -float(np.prod(boxes[each][1] - boxes[each][0]))):
        point = corners[each][0].mean(axis=0)
        for outer in larger:
            low, high = boxes[outer]
            if (low < point).all() and (point < high).all() and abs(_turns(corners[outer] - point)) > 0.5:
                turned[each] = turned[outer] if of_one_side[each] else turned[each]
                break
        larger.append(each)


def _turns(corners: Points) -> float:
    """How often triangles (F, 3, 3) surround the origin (Oosterom1983)."""
    a, b, c = np.moveaxis(corners, 1, 0)
    lengths = [np.linalg.norm(each, axis=1) for each in (a, b, c)]
    above = np.einsum("fi,fi->f", a, np.cross(b, c))
    below = lengths[0] * lengths[1] * lengths[2]
    for one, two, three in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        below = below + np.einsum("fi,fi->f", (a, b, c)[one], (a, b, c)[two]) * lengths[three]
    return float(np.sum(np.arctan2(above, below)) / (2.0 * np.pi))
