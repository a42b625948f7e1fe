"""What of the distant light reaches a vertex: bits of a cube map, shares of its texels, and the open part of the sky.

Rays start a little off the surface (`engine.ray_caster.offset_origins`), on the outer side of all the faces that meet
at the vertex's place, whatever vertices share it. A ray aimed exactly at a vertex or along an edge may slip through,
and regular meshes invite that; so the directions are turned a little for each vertex: by some hundredths of a texel for
cube maps, about the normal for `occlusion`. The turn depends on the index of the vertex alone, so no result depends on
threads or chunks. What lies below the horizon of the vertex's normal is never asked and not visible. Where the whole
mesh lies below that horizon, everything above it is visible, and no ray is cast.

Bound by the rays: some 0.1 µs each on a core for cube maps, whose neighbours are alike, 0.3 µs for `occlusion`. Memory:
`chunk_bytes` for the chunk that is at work.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.cube_map import cube_directions, direction_on_face, face_coordinates
from engine.mesh import Mesh
from engine.ray_caster import RayCaster, offset_origins
from engine.transport import visibility_kernel as kernel

#: Directions for a coarse look; a share is known to about ± 0.03.
DIRECTIONS = 64

#: Angle by which the directions of a cube map are turned for a vertex, in widths of a texel.
TURN = 0.05

#: A neighbour on the convex hull may rise by this much, in radians, above a horizon that is still free: what float32
#: normals are off by, and below what the offset of the origins clears.
FREE = 1e-6

#: Rays of a chunk, roughly.
RAYS = 1 << 20

#: Bytes for a ray of a chunk: origin, direction, vertex and texel, the answer.
RAY_BYTES = 24 + 12 + 4 + 1


@dataclass(frozen=True, eq=False)
class Receivers:
    """The vertices of a mesh as places where light arrives.

    Attributes
    ----------
    caster : the mesh, ready for rays.
    origin : (V, 3) float64, off the surface; equal for vertices of one place and equal sides.
    normal : (V, 3) float64 unit vectors, whose horizon bounds what is asked.
    free : (V,) bool, whether all of the mesh lies below that horizon.
    """

    caster: RayCaster
    origin: NDArray[np.float64]
    normal: NDArray[np.float64]
    free: NDArray[np.bool_]

    def __len__(self) -> int:
        return len(self.origin)


def receivers(mesh: Mesh, caster: RayCaster | None = None) -> Receivers:
    """The vertices of `mesh` among what `caster` holds, which is the mesh itself where nothing is given.

    With another caster (a simplified mesh, or the mesh and a ground) no vertex counts as free. Some 0.2 s for 50,000
    vertices.
    """
    point = _points(mesh.positions)
    normal = mesh.normals.astype(np.float64)
    away = outward(mesh, point)
    free = sees_hemisphere(mesh, point) if caster is None else np.zeros(len(normal), np.bool_)
    caster = RayCaster(mesh.positions, mesh.faces) if caster is None else caster
    return Receivers(caster, offset_origins(mesh.positions, away, caster), normal, free)


def _points(positions: NDArray[np.float64]) -> NDArray[np.int64]:
    """For each vertex (V,) the number of its place, equal for equal positions."""
    order = np.lexsort(positions.T)
    new = np.concatenate([[False], (np.diff(positions[order], axis=0) != 0.0).any(axis=1)])
    point = np.empty(len(positions), np.int64)
    point[order] = np.cumsum(new)
    return point


def outward(mesh: Mesh, point: NDArray[np.int64]) -> NDArray[np.float64]:
    """(V, 3) by how many offsets, and in which direction, an origin must leave its vertex to clear all its faces.

    The normal itself does where every face around the place is turned to it. Otherwise a direction is sought that they
    all are turned to, by adding the normals of those that are not (a perceptron, which finds one where there is one).
    Faces turned against the normal are the far side of a sheet and do not count. The length grows where faces are
    steep, to `kernel.LONGEST` at most.
    """
    corners = point[mesh.faces]
    count = int(point.max()) + 1 if len(point) else 0
    start = np.concatenate([[0], np.cumsum(np.bincount(corners.ravel(), minlength=count))])
    face = np.argsort(corners.ravel(), kind="stable") // 3
    flat: NDArray[np.float64] = kernel.face_normals(mesh.positions, mesh.faces)
    away: NDArray[np.float64] = kernel.outward(mesh.normals.astype(np.float64), point, start, face, flat)
    return away


def sees_hemisphere(mesh: Mesh, point: NDArray[np.int64] | None = None) -> NDArray[np.bool_]:
    """(V,) whether all of `mesh` lies below the horizon of the vertex's normal, so that no ray above it meets anything.

    Only corners of the convex hull can be such; there, neighbours on the hull decide for all (a linear function with
    no larger neighbour is at its largest). A flat mesh is judged by the box around it. False where in doubt.
    """
    from scipy.spatial import ConvexHull, QhullError

    point = _points(mesh.positions) if point is None else point
    used = np.unique(mesh.faces)
    centred = mesh.positions - mesh.centre
    centred = centred / max(float(np.abs(centred).max()), float(np.finfo(np.float64).tiny))
    normal = mesh.normals.astype(np.float64)
    first = np.unique(point[used], return_index=True)[1]
    places = used[first]
    try:
        hull = ConvexHull(centred[places])
    except QhullError:
        return _above_box(centred, used, normal)
    edges = np.unique(np.sort(hull.simplices[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1), axis=0)
    edges = np.concatenate([edges, edges[:, ::-1]])
    edges = edges[np.argsort(edges[:, 0], kind="stable")]
    start = np.searchsorted(edges[:, 0], np.arange(len(places) + 1))
    place_of_point = np.full(int(point.max()) + 1, -1)
    place_of_point[point[places]] = np.arange(len(places))
    free: NDArray[np.bool_] = kernel.hull_corners_free(
        centred[places], start, edges[:, 1], normal, place_of_point[point], FREE
    )
    return free


def _above_box(
    positions: NDArray[np.float64], used: NDArray[np.int32], normal: NDArray[np.float64]
) -> NDArray[np.bool_]:
    """(V,) whether the normal's horizon leaves below it a box that holds the used positions of a nearly flat mesh."""
    middle = positions[used].mean(axis=0)
    axes = np.linalg.svd(positions[used] - middle, full_matrices=False)[2]
    along = (positions - middle) @ axes.T
    low, high = along[used].min(axis=0), along[used].max(axis=0)
    turned = normal @ axes.T
    highest = np.maximum(turned * low, turned * high).sum(axis=1)
    free: NDArray[np.bool_] = highest - np.einsum("vi,vi->v", turned, along) <= FREE
    return free


def occlusion(
    mesh: Mesh, directions: int = DIRECTIONS, *, of: Receivers | None = None, skip: bool = True
) -> NDArray[np.float64]:
    """(V,) the share of the cosine-weighted hemisphere about each normal that is open, from so many directions each.

    1 is a free vertex; the share of vertices that see less is `np.mean(occlusion(mesh) < 1)`. With `skip`, rays are
    spared where the whole mesh lies below the horizon; the result is the same.
    """
    of = receivers(mesh) if of is None else of
    pattern = _cosine_directions(directions)
    open_share = np.ones(len(of))
    for vertices in _chunks(np.flatnonzero(~(of.free & skip)), directions):
        origin, direction = kernel.hemisphere_rays(vertices, of.origin, of.normal, pattern)
        met = of.caster.occluded(origin, direction)
        open_share[vertices] = 1.0 - met.reshape(len(vertices), directions).mean(axis=1)
    return open_share


def _cosine_directions(count: int) -> NDArray[np.float64]:
    """(count, 3) directions about +z in an even spiral, as dense as the cosine; neighbours follow each other."""
    index = np.arange(count)
    radius, azimuth = np.sqrt((index + 0.5) / count), index * np.pi * (3.0 - np.sqrt(5.0))
    directions = np.stack([radius * np.cos(azimuth), radius * np.sin(azimuth), np.sqrt(1.0 - radius**2)], axis=-1)
    octant = (directions[:, :2] < 0.0) @ (1, 2)
    result: NDArray[np.float64] = directions[np.argsort(octant, kind="stable")]
    return result


def _chunks(vertices: NDArray[np.int64], rays_each: int) -> Iterator[NDArray[np.int64]]:
    step = max(1, RAYS // rays_each)
    for start in range(0, len(vertices), step):
        yield vertices[start : start + step]


def visibility_cube(
    of: Receivers, edge: int, vertices: NDArray[np.int64] | None = None, *, skip: bool = True
) -> Iterator[tuple[NDArray[np.int64], NDArray[np.uint8]]]:
    """What each vertex sees towards the texels of a cube map: chunks of vertices (N,), their bits (N, ⌈6 edge² / 8⌉).

    The bits are those of `engine.cube_map.cube_directions`, packed as by `np.packbits`: 1 where the texel's centre is
    above the horizon and nothing is in the way. `vertices` are all by default. With `skip`, rays are spared for free
    vertices; the result is the same. A chunk takes `chunk_bytes(edge)`.
    """
    for chunk, visible in _visible(of, edge, vertices, skip, TURN * 2.0 / edge):
        yield chunk, np.packbits(visible, axis=1)


def visibility_shares(
    of: Receivers, edge: int, fine: int = 4, vertices: NDArray[np.int64] | None = None, *, skip: bool = True
) -> Iterator[tuple[NDArray[np.int64], NDArray[np.uint8]]]:
    """Like `visibility_cube`, by how many of the fine² parts of a texel are visible: counts (N, 6 edge²).

    Only texels that differ from one beside them are looked at so closely, and there the count over fine² is the exact
    mean of what `visibility_cube` gives at `fine` times the edge; others have none or all. ValueError unless `fine` is
    from 1 to 15.
    """
    if not 1 <= fine <= 15:
        raise ValueError(f"a texel is cut into 1 to 15 parts along its side, not {fine}")
    angle = TURN * 2.0 / (edge * fine)
    parts = _parts(edge, fine)
    neighbours = _neighbours(edge)
    for chunk, visible in _visible(of, edge, vertices, skip, angle):
        counts = visible * np.uint8(fine * fine)
        rows, texels = kernel.borders(visible, neighbours)
        step = max(1, RAYS // (fine * fine))
        for start in range(0, len(rows), step):
            some = slice(start, start + step)
            origin, direction, pair = kernel.finer_rays(
                chunk, rows[some], texels[some], of.origin, of.normal, parts, angle
            )
            met = of.caster.occluded(origin, direction, coherent=True)
            counts[rows[some], texels[some]] = np.bincount(pair[~met], minlength=len(rows[some]))
        yield chunk, counts


def chunk_bytes(edge: int) -> int:
    """Most memory that a chunk of `visibility_cube` or `visibility_shares` takes beside the mesh."""
    texels = 6 * edge * edge
    return (RAY_BYTES + 4) * max(RAYS, texels) + 24 * texels


def _visible(
    of: Receivers, edge: int, vertices: NDArray[np.int64] | None, skip: bool, angle: float
) -> Iterator[tuple[NDArray[np.int64], NDArray[np.bool_]]]:
    """Chunks of vertices (N,) and whether each texel is visible (N, 6 edge²), directions turned by `angle`."""
    directions = cube_directions(edge).reshape(-1, 3)
    order = _tiled(edge)
    for chunk in _chunks(np.arange(len(of)) if vertices is None else np.asarray(vertices, np.int64), len(directions)):
        visible = of.normal[chunk] @ directions.T > 0.0
        asked = np.flatnonzero(~(of.free[chunk] & skip))
        origin, direction, place = kernel.cube_rays(chunk[asked], of.origin, of.normal, directions, order, angle)
        seen = np.zeros((len(asked), len(directions)), np.bool_)
        seen.reshape(-1)[place] = ~of.caster.occluded(origin, direction, coherent=True)
        visible[asked] = seen
        yield chunk, visible


def _tiled(edge: int) -> NDArray[np.int64]:
    """The texels of a cube map square by square of 4 × 4, so that a packet of rays stays together: a quarter faster."""
    row, column = np.meshgrid(np.arange(edge), np.arange(edge), indexing="ij")
    face = np.lexsort((column.ravel(), row.ravel(), column.ravel() // 4, row.ravel() // 4))
    return (np.arange(6)[:, None] * edge * edge + face).ravel()


def _parts(edge: int, fine: int) -> NDArray[np.float64]:
    """(6 edge², fine², 3) directions through the centres of the parts of each texel."""
    directions = cube_directions(edge * fine).reshape(6, edge, fine, edge, fine, 3)
    return np.ascontiguousarray(directions.swapaxes(2, 3).reshape(6 * edge * edge, fine * fine, 3))


def _neighbours(edge: int) -> NDArray[np.int64]:
    """(6 edge², 4) the texels beside each, over the edges of the faces too."""
    face, row, column = np.meshgrid(np.arange(6), np.arange(edge), np.arange(edge), indexing="ij")
    beside = []
    for down, right in ((0, 1), (0, -1), (1, 0), (-1, 0)):
        s, t = (column + right + 0.5) / edge, (row + down + 0.5) / edge
        other, s, t = face_coordinates(direction_on_face(face, s, t))
        rows, columns = (np.minimum((place * edge).astype(np.int64), edge - 1) for place in (t, s))
        beside.append((other * edge + rows) * edge + columns)
    return np.stack(beside, axis=-1).reshape(-1, 4)
