"""Repair of a mesh: unusable faces are left out and counted, doubtful connections are counted.

Faces are looked at relative to the size of the whole, so that units do not matter. Connections are found between
points, vertices at the same place being one.
Cost: about 0.3 s for 100,000 faces, most of it in sorting edges.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.core.directions import dot, normalize
from engine.core.health import Finding, Verdict
from engine.core.kernels import only, scalar

#: Coordinates beyond this cannot be squared in 32 bits, which graphics devices and rays work with …
LARGEST = 1e15

#: … and a mesh smaller than this neither.
SMALLEST = 1e-15

#: A face whose height is below this share of its longest edge has no usable normal: a needle.
NEEDLE = 1e-8

#: Rows from which on equal ones are found by a compiled kernel, which takes half a second to load.
MANY_ROWS = 1 << 16

#: Faces that are looked at together where a step takes much memory for each.
BLOCK = 1 << 18

#: With more open edges than this, points on other edges (T-junctions) are not looked for.
MAX_OPEN_EDGES = 20_000

#: Largest distance of a point from an edge that it divides, as a share of the length.
ON_EDGE = 1e-6

#: Largest inward bulge of a convex mesh at an edge, for a size of 1: what 32 bits leave of a plane.
DENT = 1e-6

#: Said of a mesh whose volume is negative; `engine.geometry.mesh.Mesh.flipped` mends it.
INSIDE_OUT = "the surface is inside out; it can be flipped"

Points = NDArray[np.float64]
Faces = NDArray[np.int64]


def blocks_of(count: int) -> Iterator[slice]:
    """Slices of so many faces, `BLOCK` each."""
    yield from (slice(first, first + BLOCK) for first in range(0, count, BLOCK))


def equal_rows(rows: NDArray[np.float64] | Faces) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The first row of each set of equal rows of (N, columns), in their order, and the set (N,) of each row.

    A few rows are put in order of a hash of their bits. Where two different rows share it, which one in 10^9 meshes of
    a million rows does, equal rows may stay apart. Many go through a table of hashes.
    """
    without_negative_zeros = rows + 0.0 if rows.dtype.kind == "f" else rows
    return _equal_bits(np.ascontiguousarray(without_negative_zeros).view(np.uint64))


def _equal_bits(bits: NDArray[np.uint64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    if len(bits) >= MANY_ROWS:
        size = 1 << int(4 * len(bits) // 3).bit_length()
        found, index = _match_rows(bits, np.full(size, -1, np.int32))
        return found.astype(np.int64), index
    factors = np.random.default_rng(0).integers(1, 1 << 63, bits.shape[1], dtype=np.uint64) * 2 + 1
    mixed = np.sum((bits ^ (bits >> np.uint64(32))) * factors, axis=1, dtype=np.uint64)
    order = np.argsort(mixed, kind="stable")
    starts = np.concatenate([np.ones(min(len(bits), 1), bool), (np.diff(bits[order], axis=0) != 0).any(axis=1)])
    first = order[starts]
    rank = np.empty(len(first), np.int64)
    rank[np.argsort(first)] = np.arange(len(first))
    index = np.empty(len(bits), np.int64)
    index[order] = rank[np.cumsum(starts) - 1]
    return np.sort(first), index


@scalar
def _match_rows(bits: np.ndarray, table: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The first of each set of equal rows, and the set of each row; `table` of 2^n entries, more than rows, holds −1.

    Bounded by fetches of rows and entries that lie anywhere: about 0.1 µs a row.
    """
    count, columns = bits.shape
    first, index = np.empty(count, np.int32), np.empty(count, np.int64)
    found, mask = 0, np.uint64(len(table) - 1)
    for row in range(count):
        mixed = np.uint64(0)
        for column in range(columns):
            mixed = (mixed ^ bits[row, column]) * np.uint64(0x9E3779B97F4A7C15)
            mixed ^= mixed >> np.uint64(29)
        entry = mixed & mask
        while True:
            known = table[entry]
            if known < 0:
                table[entry] = found
                first[found] = row
                index[row] = found
                found += 1
                break
            other = first[known]
            column = 0
            while column < columns and bits[row, column] == bits[other, column]:
                column += 1
            if column == columns:
                index[row] = known
                break
            entry = (entry + np.uint64(1)) & mask
    return first[:found].copy(), index


def prepare() -> None:
    """Compile before the process gives up what compiling needs."""
    only(_match_rows, "Tuple((int32[::1], int64[::1]))(uint64[:, ::1], int32[::1])")


def list_used(values: NDArray[np.integer[Any]], count: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Numbers below `count` that are among `values`, in their order, and the place (count,) of each there."""
    is_used = np.zeros(count, np.bool_)
    is_used[values.reshape(-1)] = True
    return np.flatnonzero(is_used), np.cumsum(is_used) - 1


def merge_points(positions: Points, known: NDArray[np.bool_] | None = None) -> tuple[Points, NDArray[np.int64]]:
    """The different places (P, 3) among positions (V, 3), and the place (V,) of each.

    NaN and infinity count as 0, and so does what is not `known` (V,).
    """
    usable = np.isfinite(positions) if known is None else known[:, None]
    places = np.where(usable, positions, 0.0)
    places += 0.0  # without negative zeros
    first, index = _equal_bits(places.view(np.uint64))
    return np.where(usable[first], positions[first], 0.0), index


def usable_faces(positions: Points, faces: NDArray[np.integer[Any]]) -> tuple[NDArray[np.bool_], dict[str, int]]:
    """Mask (F,) of the usable faces, and counts of the others by reason, each named for the first that applies.

    A face is left out if it names a vertex that does not exist, one that is not finite (or beyond `LARGEST`), if it
    has no area or is a needle, or if another face has the same three corners in the same order of rotation.
    """
    faces = np.asarray(faces, np.int64)
    usable = np.ones(len(faces), bool)
    counts: dict[str, int] = {}

    def leave_out(wrong: NDArray[np.bool_], reason: str) -> None:
        counts[f"{reason}_dropped"] = int(np.sum(wrong))
        usable[np.flatnonzero(usable)[wrong]] = False

    leave_out(np.any((faces < 0) | (faces >= len(positions)), axis=1), "faces_with_wrong_indices")
    finite = np.all(np.abs(positions) <= LARGEST, axis=1)
    leave_out(~np.all(finite[faces[usable]], axis=1), "faces_with_non_finite_vertices")
    points, place = merge_points(positions, finite)
    corners = place[faces[usable]]
    blocks = [corners[first : first + BLOCK] for first in range(0, max(len(corners), 1), BLOCK)]
    thickness = np.concatenate([_thickness(points, block) for block in blocks])
    del corners, blocks
    leave_out(thickness == 0.0, "faces_without_area")
    leave_out(thickness[thickness > 0.0] < NEEDLE, "needles")
    leave_out(_repeat(place[faces[usable]]), "repeated_faces")
    return usable, counts


def _thickness(points: Points, faces: Faces) -> NDArray[np.float64]:
    """(F,) height over the longest edge, scale-free; 0 for faces without area."""
    a, b, c = (points[faces[:, corner]] for corner in range(3))
    edges = np.stack([b - a, c - b, a - c], axis=1)
    size = np.max(np.abs(edges), axis=(1, 2), initial=0.0)[:, None, None]
    edges = edges / np.where(size > 0.0, size, 1.0)
    longest = np.max(np.sum(edges**2, axis=-1), axis=1, initial=0.0)
    area = np.linalg.norm(np.cross(edges[:, 0], -edges[:, 2]), axis=1)
    return area / np.where(longest > 0.0, longest, 1.0)


def _repeat(faces: Faces) -> NDArray[np.bool_]:
    """Mask of the faces that are there a second time, turned the same way."""
    start = np.argmin(faces, axis=1)
    rows = np.arange(len(faces))
    turned = np.stack([faces[rows, (start + step) % 3] for step in range(3)], axis=-1)
    again = np.ones(len(faces), bool)
    again[equal_rows(turned)[0]] = False
    return again


@dataclass(frozen=True, eq=False)
class Corners:
    """Values of the corners of faces.

    Attributes
    ----------
    table : (F, 3, k) of corners, or (V, k) of vertices, which take a third of the memory and less.
    vertex : (F, 3) the vertex of each corner for a table of vertices, which several tables may share.
    """

    table: NDArray[np.floating[Any]]
    vertex: NDArray[np.int32] | None = None

    def at(self, faces: slice) -> NDArray[np.floating[Any]]:
        """(n, 3, k) of some faces."""
        return self.table[faces] if self.vertex is None else self.table[self.vertex[faces]]


def corner_rows(faces: Faces, normals: Corners, uv: Corners, colours: Corners | None = None) -> NDArray[np.float32]:
    """Point, normal, texture coordinate and colour of all corners, (3 F, 6 or 10)."""
    rows = np.zeros((*faces.shape, 6 if colours is None else 10), np.float32)
    for block in blocks_of(len(faces)):
        rows[block, :, 1:4], rows[block, :, 4:6] = normals.at(block), uv.at(block)
        if colours is not None:
            rows[block, :, 6:9] = colours.at(block)
    rows += 0.0  # without negative zeros
    rows[..., 0] = faces.astype(np.int32).view(np.float32)
    return rows.reshape(faces.size, -1)


def weld(points: Points, corners: NDArray[np.float32]) -> dict[str, Any]:
    """One vertex for all corners, of `corner_rows`, that agree in point, normal, texture coordinate and colour."""
    first, index = _equal_bits(corners.view(np.uint64))
    return {
        "positions": points[np.ascontiguousarray(corners[first, 0]).view(np.int32)],
        "normals": np.ascontiguousarray(corners[first, 1:4]),
        "uv": np.ascontiguousarray(corners[first, 4:6]),
        "faces": index.reshape(-1, 3).astype(np.int32),
        **({} if corners.shape[1] == 6 else {"colours": np.ascontiguousarray(corners[first, 6:9])}),
    }


#: Words of findings for many, and for one.
_SINGULAR = {
    **{"faces": "face", "edges": "edge", "points": "point", "vertices": "vertex", "normals": "normal"},
    **{"shapes": "shape", "curves": "curve", "instancers": "instancer", "surfaces": "surface"},
}
_SINGULAR_VERBS = {"are": "is", "have": "has", "lie": "lies", "were": "was"}


def with_count(count: int, text: str) -> str:
    """`3 edges are open`, but `1 edge is open`: the first noun and the first verb follow the count."""
    words = text.split(" ")
    for singular in (_SINGULAR, _SINGULAR_VERBS) if count == 1 else ():
        first = next((place for place, word in enumerate(words) if word in singular), None)
        if first is not None:
            words[first] = singular[words[first]]
    return " ".join([str(count), *words])


@dataclass(frozen=True)
class Topology:
    """Connections between the faces of a mesh.

    Attributes
    ----------
    open_edges : edges of one face.
    crowded_edges : edges of more than two faces.
    clashing_edges : edges whose two faces are turned against each other.
    junctions : points that lie within an open edge; None where there were too many open edges to look.
    components : parts that share no point.
    inside_out : closed parts whose faces look inwards; the hollow of a thick wall is one.
    volume : inside, negative where most of it is inside out; meaningful for closed meshes.
    closed : every edge has exactly two faces, turned alike.
    convex : closed, in one part, and bent outwards at every edge.
    """

    open_edges: int
    crowded_edges: int
    clashing_edges: int
    junctions: int | None
    components: int
    inside_out: int
    volume: float
    closed: bool
    convex: bool

    @property
    def figures(self) -> dict[str, float]:
        return {name: float(value) for name, value in vars(self).items() if value is not None}

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Findings for a user, with the counts."""
        said = (
            (self.open_edges, "edges are open: the surface has borders or holes"),
            (self.crowded_edges, "edges have more than two faces"),
            (self.clashing_edges, "edges have faces that are turned against each other"),
            (self.junctions, "points lie within edges of other faces (T-junctions), where light may pass through"),
        )
        findings = [Finding(Verdict.WARNING, with_count(count, text)) for count, text in said if count]
        if self.volume < 0.0 and self.inside_out:
            findings.append(Finding(Verdict.WARNING, INSIDE_OUT))
        return tuple(findings)


def topology(points: Points, faces: Faces) -> Topology:
    """Topology of `faces` (F, 3) between different `points` (P, 3)."""
    used = points[list_used(faces, len(points))[0]]
    low, high = used.min(axis=0), used.max(axis=0)
    size = max(float(np.max(high - low)), np.finfo(float).tiny)
    points = (points - (low + high) / 2.0) / size
    directed = faces.astype(np.int32)[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    components, part = _components(directed, faces, len(points))
    key = directed.min(axis=1) * np.int64(len(points))
    key += directed.max(axis=1)
    order = np.argsort(key, kind="stable")
    starts = np.flatnonzero(np.concatenate([[True], np.diff(key[order]) != 0]))
    del key
    count = np.diff(np.append(starts, len(order)))
    pairs = order[starts[count == 2][:, None] + np.arange(2)]
    clashing = directed[pairs[:, 0], 0] == directed[pairs[:, 1], 0]
    alone = order[starts[count == 1]]

    volume = np.bincount(part, _volumes(points, faces), components)
    sound = np.ones(components, bool)
    sound[part[alone // 3]] = False
    sound[part[order[np.repeat(count, count) > 2] // 3]] = False
    sound[part[pairs[clashing, 0] // 3]] = False
    closed = bool(sound.all())
    return Topology(
        open_edges=len(alone),
        crowded_edges=int(np.sum(count > 2)),
        clashing_edges=int(np.sum(clashing)),
        junctions=_junctions(points, directed[alone]),
        components=components,
        inside_out=int(np.sum(sound & (volume < 0.0))),
        volume=float(volume.sum()) * size**3,
        closed=closed,
        convex=closed and components == 1 and volume[0] > 0.0 and _bends_outwards(points, faces, pairs),
    )


def _volumes(points: Points, faces: Faces) -> NDArray[np.float64]:
    """(F,) volume of the tetrahedron between each face and the origin."""
    volumes = np.empty(len(faces))
    for block in blocks_of(len(faces)):
        a, b, c = np.moveaxis(points[faces[block]], 1, 0)
        volumes[block] = np.einsum("fi,fi->f", a, np.cross(b, c)) / 6.0
    return volumes


def _components(directed: NDArray[np.integer[Any]], faces: Faces, count: int) -> tuple[int, NDArray[np.int64]]:
    """Number of parts, and the part (F,) of each face."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    ones = np.ones(len(directed), np.int8)
    joined = coo_matrix((ones, (directed[:, 0], directed[:, 1])), shape=(count, count))
    label = connected_components(joined, directed=False)[1][faces[:, 0]]
    parts, place = list_used(label, count)
    return len(parts), place[label]


def _bends_outwards(points: Points, faces: Faces, pairs: Faces) -> bool:
    """True if no face rises above the plane of a neighbour, and all surround a point inside exactly once.

    Then the surface is locally convex and does not wind about itself, which makes it convex (Heijenoort1952).
    The turns about the point are the sum of solid angles (Oosterom1983) over 4π.
    """
    a, b, c = (points[faces[:, corner]] for corner in range(3))
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    for one, other in ((0, 1), (1, 0)):
        face, neighbour, edge = pairs[:, one] // 3, pairs[:, other] // 3, pairs[:, other] % 3
        opposite = points[faces[neighbour, (edge + 2) % 3]]
        if np.einsum("ei,ei->e", normal[face], opposite - a[face]).max() > DENT:
            return False
    inside = points[np.unique(faces)].mean(axis=0)
    a, b, c = (normalize(corner - inside) for corner in (a, b, c))
    volume = dot(a, np.cross(b, c))
    turns = np.sum(np.arctan2(volume, 1.0 + dot(a, b) + dot(b, c) + dot(c, a))) / (2.0 * np.pi)
    return bool(volume.min() > 0.0 and abs(turns - 1.0) < 1e-3)


def _junctions(points: Points, edges: Faces) -> int | None:
    """Number of points of open edges that lie within another open edge."""
    from scipy.spatial import cKDTree

    if len(edges) > MAX_OPEN_EDGES:
        return None
    if len(edges) == 0:
        return 0
    used = np.unique(edges)
    tree = cKDTree(points[used])
    start, along = points[edges[:, 0]], points[edges[:, 1]] - points[edges[:, 0]]
    length = np.linalg.norm(along, axis=1)
    near = tree.query_ball_point(start + along / 2.0, length / 2.0)
    edge = np.repeat(np.arange(len(edges)), [len(found) for found in near])
    point = used[np.concatenate([np.asarray(found, np.int64) for found in near])]
    share = np.einsum("pi,pi->p", points[point] - start[edge], along[edge]) / length[edge] ** 2
    distance = np.linalg.norm(points[point] - start[edge] - share[:, None] * along[edge], axis=1)
    within = (distance < ON_EDGE * length[edge]) & (share > ON_EDGE) & (share < 1.0 - ON_EDGE)
    return len(np.unique(point[within]))
