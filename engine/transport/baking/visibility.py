"""Visibility of the distant light at a vertex: bits of a cube map, shares of its texels, and the open part of the sky.

Rays start a little off the surface (`engine.geometry.ray_caster.offset_origins`), on the outer side of all the faces
that meet at the vertex's place, whatever vertices share it. A ray aimed exactly at a vertex or along an edge may slip
through, and regular meshes invite that; so the directions are turned a little for each vertex: by some hundredths of a
texel for cube maps, about the normal for `occlusion`. The turn depends on the index of the vertex alone, so no result
depends on threads or chunks. What lies below the horizon of the vertex's normal is never asked and not visible. Where
the whole mesh lies below that horizon, everything above it is visible, and no ray is cast.

Bound by the rays: some 0.1 µs each on a core for cube maps, whose neighbours are alike, 0.3 µs for `occlusion`. Memory:
`chunk_bytes` for the chunk that is at work.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from engine.core.directions import normalize
from engine.geometry.mesh import Mesh
from engine.geometry.ray_caster import CHUNK, RayCaster, caster_of, in_chunks, offset_origins
from engine.light.cube_map import cube_directions, direction_on_face, texel_numbers
from engine.transport.baking import visibility_kernel as kernel

#: Directions for a coarse look; a share is known to about ± 0.03.
DIRECTIONS = 64

#: Angle by which the directions of a cube map are turned for a vertex, in widths of a texel.
TURN = 0.05

#: Rise above a horizon, as a share of an offset, that hides nothing: the error of float32 normals.
RISE = 0.1

#: Texels of a chunk, roughly.
TEXELS = 1 << 21


class Record(Protocol):
    """Shares that were found before (`engine.transport.baking.visibility_record`)."""

    def shares(
        self,
        of: Receivers,
        edge: int,
        fine: int,
        vertices: NDArray[np.int64],
        find: Callable[[NDArray[np.int64]], NDArray[np.uint8]],
    ) -> Iterator[tuple[NDArray[np.int64], NDArray[np.uint8]]]:
        """As `visibility_shares`; `find` gives the counts of vertices that are missing."""


@dataclass(frozen=True, eq=False)
class Receivers:
    """The vertices of a mesh as places where light arrives.

    Attributes
    ----------
    caster : the mesh, ready for rays.
    origin : (V, 3) float64, off the surface; on the outer side of the faces there.
    normal : (V, 3) float64 unit vectors, whose horizon bounds what is asked.
    free : (V,) bool, whether all that the caster holds lies below that horizon.
    record : where shares are kept and looked for before rays are cast; None for nowhere.
    """

    caster: RayCaster
    origin: NDArray[np.float64]
    normal: NDArray[np.float64]
    free: NDArray[np.bool_]
    record: Record | None = None

    def __len__(self) -> int:
        return len(self.origin)

    def describe(self) -> dict[str, NDArray[Any]]:
        """Return the arrays of which another process makes receivers, without a record."""
        return {
            "positions": self.caster.positions,
            "faces": self.caster.faces,
            "origin": self.origin,
            "normal": self.normal,
            "free": self.free,
        }


def receivers(mesh: Mesh, caster: RayCaster | None = None) -> Receivers:
    """The vertices of `mesh` among what `caster` holds, which is the mesh itself where nothing is given.

    `caster` may hold a simplified mesh, or the mesh and a ground. Some 0.2 s for 50,000 vertices.
    """
    caster = caster_of(mesh) if caster is None else caster
    normal = normalize(mesh.normals)
    free = sees_hemisphere(mesh.positions, normal, caster)
    away = np.where(free[:, None], normal, outward(mesh))
    return Receivers(caster, offset_origins(mesh.positions, away, caster), normal, free)


def find_unshaded(mesh: Mesh, caster: RayCaster) -> Receivers:
    """The vertices of `mesh` where nothing shades them: all are free, and `caster` is never asked."""
    normal = normalize(mesh.normals)
    return Receivers(caster, mesh.positions, normal, np.ones(len(normal), np.bool_))


def every_ray(of: Receivers, edge: int, fine: int) -> Receivers:
    """The same with rays cast from all vertices: those stay free that their rays find to be.

    What free vertices see is known without a ray. This looks nevertheless, and trusts the rays alone: over the texels
    of a cube map of `edge`, cut into `fine`² parts where that changes.
    """
    asked = np.flatnonzero(of.free)
    free = of.free.copy()
    known = visibility_shares(of, edge, fine, asked)
    for (chunk, without), (_, cast) in zip(known, visibility_shares(of, edge, fine, asked, skip=False), strict=True):
        free[chunk] = (without == cast).all(axis=1)
    return replace(of, free=free)


def _points(positions: NDArray[np.float64]) -> NDArray[np.int64]:
    """For each vertex (V,) the number of its place, equal for equal positions."""
    order = np.lexsort(positions.T)
    new = np.concatenate([[False], (np.diff(positions[order], axis=0) != 0.0).any(axis=1)])
    point = np.empty(len(positions), np.int64)
    point[order] = np.cumsum(new)
    return point


def outward(mesh: Mesh) -> NDArray[np.float64]:
    """(V, 3) by how many offsets, and in which direction, an origin must leave its vertex to clear all its faces.

    The normal itself does where every face around the place is turned to it. Otherwise a direction is sought that they
    all are turned to, by adding the normals of those that are not (a perceptron, which finds one where there is one).
    Faces turned against the normal are the far side of a sheet and do not count. The length grows where faces are
    steep, to `kernel.LONGEST` at most.
    """
    point = _points(mesh.positions)
    corners = point[mesh.faces]
    count = int(point.max()) + 1 if len(point) else 0
    start = np.concatenate([[0], np.cumsum(np.bincount(corners.ravel(), minlength=count))])
    face = np.argsort(corners.ravel(), kind="stable") // 3
    flat: NDArray[np.float64] = kernel.face_normals(mesh.positions, mesh.faces)
    away: NDArray[np.float64] = kernel.outward(normalize(mesh.normals), point, start, face, flat)
    return away


def sees_hemisphere(
    positions: NDArray[np.float64], normals: NDArray[np.float64], caster: RayCaster
) -> NDArray[np.bool_]:
    """(V,) whether all that `caster` holds lies below the horizon of each vertex, so no ray above it meets anything.

    `RISE` offsets are allowed above it, which rays that start an offset above clear. The highest point along a normal
    is sought in boxes of boxes of points, in some 1 µs a vertex.
    """
    points = caster.positions[np.unique(caster.faces)]
    blocks = kernel.boxes_of_boxes((points - caster.centre) / caster.extent)
    free = np.empty(len(positions), np.bool_)
    rise = RISE * caster.offset / caster.extent

    def look(rows: slice) -> None:
        free[rows] = kernel.nothing_above(
            (positions[rows] - caster.centre) / caster.extent, normals[rows], blocks, rise
        )

    in_chunks(look, len(positions))
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
    asked = np.flatnonzero(~(of.free & skip))

    def look(rows: slice) -> None:
        origin, direction = kernel.hemisphere_rays(asked[rows], of.origin, of.normal, pattern)
        met = of.caster.occluded(origin, direction)
        open_share[asked[rows]] = 1.0 - met.reshape(-1, directions).mean(axis=1)

    in_chunks(look, len(asked), max(1, CHUNK // directions))
    return open_share


def _cosine_directions(count: int) -> NDArray[np.float64]:
    """(count, 3) directions about +z in an even spiral, as dense as the cosine; neighbours follow each other."""
    index = np.arange(count)
    radius, azimuth = np.sqrt((index + 0.5) / count), index * np.pi * (3.0 - np.sqrt(5.0))
    directions = np.stack([radius * np.cos(azimuth), radius * np.sin(azimuth), np.sqrt(1.0 - radius**2)], axis=-1)
    octant = (directions[:, :2] < 0.0) @ (1, 2)
    result: NDArray[np.float64] = directions[np.argsort(octant, kind="stable")]
    return result


def visibility_cube(
    of: Receivers, edge: int, vertices: NDArray[np.int64] | None = None, *, skip: bool = True
) -> Iterator[tuple[NDArray[np.int64], NDArray[np.uint8]]]:
    """Visibility of the texels of a cube map: chunks of vertices (N,), their bits (N, ⌈6 edge² / 8⌉).

    The bits are those of `engine.light.cube_map.cube_directions`, packed as by `np.packbits`: 1 where the texel's
    centre is above the horizon and nothing is in the way. `vertices` are all by default. With `skip`, rays are spared
    for free vertices; the result is the same. A chunk takes `chunk_bytes(edge)`.
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
    vertices = np.arange(len(of)) if vertices is None else np.asarray(vertices, np.int64)
    if of.record is None or not skip:
        yield from _find_shares(of, edge, fine, vertices, skip)
        return
    yield from of.record.shares(
        *(of, edge, fine, vertices),
        lambda block: np.concatenate([counts for _, counts in _find_shares(of, edge, fine, block, skip=True)]),
    )


def _find_shares(
    of: Receivers, edge: int, fine: int, vertices: NDArray[np.int64], skip: bool
) -> Iterator[tuple[NDArray[np.int64], NDArray[np.uint8]]]:
    """Cast the rays of `visibility_shares`."""
    angle = TURN * 2.0 / (edge * fine)
    parts = _parts(edge, fine)
    neighbours = _neighbours(edge)
    for chunk, visible in _visible(of, edge, vertices, skip, angle):
        counts = visible * np.uint8(fine * fine)
        rows, texels = kernel.borders(visible, neighbours)

        def look_closely(
            some: slice,
            chunk: NDArray[np.int64] = chunk,
            counts: NDArray[np.uint8] = counts,
            rows: NDArray[np.int64] = rows,
            texels: NDArray[np.int64] = texels,
        ) -> None:
            origin, direction, pair = kernel.finer_rays(
                chunk, rows[some], texels[some], of.origin, of.normal, parts, angle
            )
            met = np.zeros(len(pair), np.bool_)
            asked = np.flatnonzero(~(of.free[chunk[rows[some]]] & skip)[pair])
            if asked.size:
                met[asked] = of.caster.occluded(origin[asked], direction[asked], coherent=True)
            counts[rows[some], texels[some]] = np.bincount(pair[~met], minlength=len(rows[some]))

        in_chunks(look_closely, len(rows), CHUNK // (fine * fine))
        yield chunk, counts


def chunk_bytes(edge: int) -> int:
    """Most memory that a chunk of `visibility_cube` or `visibility_shares` takes beside the mesh and its rays.

    At most as many texels are borders, with two indices of eight bytes each; the rays of a thread at work are few.
    """
    texels = 6 * edge * edge
    return (1 + 1 + 16) * max(TEXELS, texels) + (24 + 24 * 16 + 32) * texels


def _visible(
    of: Receivers, edge: int, vertices: NDArray[np.int64] | None, skip: bool, angle: float
) -> Iterator[tuple[NDArray[np.int64], NDArray[np.bool_]]]:
    """Chunks of vertices (N,) and whether each texel is visible (N, 6 edge²), directions rotated by `angle`."""
    directions = cube_directions(edge).reshape(-1, 3)
    order = _tile(edge)
    vertices = np.arange(len(of)) if vertices is None else np.asarray(vertices, np.int64)
    step = max(1, TEXELS // len(directions))
    for start in range(0, len(vertices), step):
        chunk = vertices[start : start + step]
        visible = np.empty((len(chunk), len(directions)), np.bool_)

        def look(rows: slice, chunk: NDArray[np.int64] = chunk, visible: NDArray[np.bool_] = visible) -> None:
            free = of.free[chunk[rows]] & skip
            origin, direction, place = kernel.cube_rays(
                chunk[rows], free, of.origin, of.normal, directions, order, angle, visible[rows]
            )
            if len(place):
                visible[rows].reshape(-1)[place] = ~of.caster.occluded(origin, direction, coherent=True)

        in_chunks(look, len(chunk), portion(edge))
        yield chunk, visible


def portion(edge: int) -> int:
    """Vertices that a thread takes at a time for a cube map."""
    return max(1, 2 * CHUNK // (6 * edge * edge))


@lru_cache(maxsize=2)
def _tile(edge: int) -> NDArray[np.int64]:
    """The texels of a cube map square by square of 4 × 4, so that a packet of rays stays together: a quarter faster."""
    row, column = np.meshgrid(np.arange(edge), np.arange(edge), indexing="ij")
    face = np.lexsort((column.ravel(), row.ravel(), column.ravel() // 4, row.ravel() // 4))
    return (np.arange(6)[:, None] * edge * edge + face).ravel()


@lru_cache(maxsize=2)
def _parts(edge: int, fine: int) -> NDArray[np.float64]:
    """(6 edge², fine², 3) directions through the centres of the parts of each texel."""
    directions = cube_directions(edge * fine).reshape(6, edge, fine, edge, fine, 3)
    return np.ascontiguousarray(directions.swapaxes(2, 3).reshape(6 * edge * edge, fine * fine, 3))


@lru_cache(maxsize=2)
def _neighbours(edge: int) -> NDArray[np.int64]:
    """(6 edge², 4) the texels beside each, over the edges of the faces too."""
    face, row, column = np.meshgrid(np.arange(6), np.arange(edge), np.arange(edge), indexing="ij")
    beside = []
    for down, right in ((0, 1), (0, -1), (1, 0), (-1, 0)):
        s, t = (column + right + 0.5) / edge, (row + down + 0.5) / edge
        beside.append(texel_numbers(direction_on_face(face, s, t), edge))
    return np.stack(beside, axis=-1).reshape(-1, 4)


def miss_rate(mesh: Mesh, rays: int = 200_000, seed: int = 0) -> float:
    """The share of rays from inside a closed mesh that leave it unnoticed; embree's robust mode keeps it below 2e-5.

    Half of them go anywhere, the others exactly at vertices and at points of edges, from behind random faces.
    ValueError for a mesh with open edges.
    """
    corners = _points(mesh.positions)[mesh.faces]
    ends = np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]])
    way, edge = ends[:, 0] < ends[:, 1], np.unique(np.sort(ends, axis=1), axis=0, return_inverse=True)[1].reshape(-1)
    if np.bincount(edge, np.where(way, 1.0, -1.0)).any():
        raise ValueError("the mesh has open edges; rays may leave it")
    caster = RayCaster(mesh.positions, mesh.faces)
    a, b, c = (mesh.positions[mesh.faces[:, corner]] - caster.centre for corner in range(3))
    outside = np.sign(np.einsum("fi,fi->", a / caster.extent, np.cross(b / caster.extent, c / caster.extent)))
    rng = np.random.default_rng(seed)
    face, other = rng.integers(len(mesh.faces), size=(2, rays))
    inwards = -outside * kernel.face_normals(mesh.positions, mesh.faces)[face]
    origin = offset_origins((a + b + c)[face] / 3.0 + caster.centre, inwards, caster)
    along = np.where(np.arange(rays) % 4 == 0, 0.0, rng.random(rays))[:, None]
    aimed = a[other] + along * (b - a)[other] + caster.centre - origin
    anywhere = rng.normal(size=(rays, 3))
    direction = np.where((np.arange(rays) % 2 == 0)[:, None], aimed, anywhere)
    return float(np.mean(~caster.occluded(origin, direction)))
