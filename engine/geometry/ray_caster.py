"""Rays against a mesh: the nearest hit, or only whether there is one.

embree looks for the face, in float32 and in its robust mode, in coordinates about the centre of the bounding box that
are scaled by a power of two to about one; so scaling a mesh by a power of two changes no answer. Where the ray meets
that face is then worked out in float64 from the vertices as they are given. Of faces that coincide, the one of lowest
index is met whose front the ray meets, or the one of lowest index where there is none.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.core.budget import thread_count
from engine.core.directions import dot
from engine.core.kernels import scalar
from engine.geometry.embree import embree_scene
from engine.geometry.mesh import Mesh
from engine.geometry.mesh_repair import equal_rows, list_used

Floats = NDArray[np.floating[Any]]

#: Rays that one thread takes at a time.
CHUNK = 1 << 15

#: Unit roundoff of embree's float32 coordinates and of the float64 ones that they come from.
UNIT, FINE_UNIT = 2.0**-24, 2.0**-53

#: An origin is pushed off a face by so many roundings of the largest coordinate: three of the vertices and three of the
#: origin, some twenty of the edge tests (pbrt's gamma bounds), and what `engine.geometry.embree.NUDGE` moves at the far
#: side.
ROUNDINGS = 96


@dataclass(frozen=True, eq=False)
class Hits:
    """Nearest hits of rays.

    Attributes
    ----------
    face : (N,) int32 index of the face, −1 where a ray meets none.
    distance : (N,) float64 in lengths of the direction; infinite where nothing is met.
    barycentric : (N, 3) float64 weights of the face's corners, each in [0, 1], with sum 1; zero where nothing is met.
    """

    face: NDArray[np.int32]
    distance: NDArray[np.float64]
    barycentric: NDArray[np.float64]


class RayCaster:
    """The triangles (F, 3) of a mesh with vertices (V, 3), ready for rays; the arrays must not change afterwards.

    Attributes
    ----------
    centre : (3,) float64, the centre of the bounding box.
    extent : the largest distance of a coordinate from the centre, at least the smallest normal number.
    offset : how far an origin on a face must stand off it: `ROUNDINGS` of `extent`, and of the coordinates in float64.

    About 0.2 µs a face to build on one core, and 100 bytes a face. ValueError for faces that name no vertex, or
    vertices that are not finite.
    """

    def __init__(self, positions: ArrayLike, faces: ArrayLike) -> None:
        self.positions = np.ascontiguousarray(positions, np.float64).reshape(-1, 3)
        self.faces = np.ascontiguousarray(faces, np.int32).reshape(-1, 3)
        if self.faces.size and not 0 <= int(self.faces.min()) <= int(self.faces.max()) < len(self.positions):
            raise ValueError("faces name vertices that do not exist")
        used = self.positions[list_used(self.faces, len(self.positions))[0]]
        if not np.isfinite(used).all():
            raise ValueError("vertices are not finite")
        low, high = (used.min(axis=0), used.max(axis=0)) if len(used) else (np.zeros(3), np.zeros(3))
        self.centre = low / 2.0 + high / 2.0
        self.extent = max(float(np.max(high / 2.0 - low / 2.0)), float(np.finfo(np.float64).tiny))
        largest = max(float(np.abs(low).max()), float(np.abs(high).max()))
        self.offset = gamma(ROUNDINGS, UNIT) * self.extent + gamma(ROUNDINGS, FINE_UNIT) * largest
        self._scale = math.ldexp(1.0, -math.frexp(self.extent)[1])
        self._kept, self._behind = _first_of_coincident(self.positions, self.faces)
        inside = (np.where(np.isfinite(self.positions), self.positions, self.centre) - self.centre) * self._scale
        self._scene = embree_scene(inside.astype(np.float32), self.faces[self._kept])

    def intersect(self, origin: Floats, direction: Floats, *, coherent: bool = False) -> Hits:
        """The nearest face along each ray from `origin` (N, 3) towards `direction` (N, 3), of any length but zero.

        Rays that are not finite, and those without direction, meet nothing. `coherent` says that rays that follow each
        other are alike; it changes the speed, not the answer.
        """
        face = np.empty(len(origin), np.int32)
        distance, barycentric = np.empty(len(origin)), np.empty((len(origin), 3))

        def work(rays: slice) -> None:
            self._scene.intersect(origin[rays], direction[rays], self.centre, self._scale, face[rays], coherent)
            _refine(
                self.positions,
                self.faces,
                self._kept,
                self._behind,
                self._scale,
                origin[rays],
                direction[rays],
                face[rays],
                distance[rays],
                barycentric[rays],
            )

        in_chunks(work, len(origin))
        return Hits(face, distance, barycentric)

    def occluded(self, origin: Floats, direction: Floats, *, coherent: bool = False) -> NDArray[np.bool_]:
        """True for each ray from `origin` (N, 3) towards `direction` (N, 3) that meets any face; bools (N,)."""
        found = np.empty(len(origin), np.bool_)

        def work(rays: slice) -> None:
            self._scene.occluded(origin[rays], direction[rays], self.centre, self._scale, found[rays], coherent)

        in_chunks(work, len(origin))
        return found


def caster_of(mesh: Mesh) -> RayCaster:
    """The caster of a mesh, made once and kept as long as the mesh is."""
    caster = _CASTERS.get(mesh)
    if caster is None:
        caster = _CASTERS[mesh] = RayCaster(mesh.positions, mesh.faces)
    return caster


_CASTERS: WeakKeyDictionary[Mesh, RayCaster] = WeakKeyDictionary()


def meets_front(
    positions: NDArray[np.floating[Any]], corners: NDArray[np.integer[Any]], direction: Floats
) -> NDArray[np.bool_]:
    """(n,) whether rays along `direction` (n, 3) meet the front of triangles with these `corners` (n, 3)."""
    a, b, c = (positions[corners[:, corner]] for corner in range(3))
    return np.asarray(dot(np.cross(b - a, c - a), direction) < 0.0)


def gamma(count: int, unit: float) -> float:
    """Bound of the relative error of `count` roundings (Higham2002, lemma 3.1)."""
    return count * unit / (1.0 - count * unit)


def offset_origins(positions: Floats, normals: Floats, caster: RayCaster) -> NDArray[np.float64]:
    """`positions` (N, 3) moved along the unit `normals` (N, 3) by `caster.offset`: rays from there miss their own face.

    The normal given decides the side. The offset grows with the bounding box and, far from the origin of the
    coordinates, with the coordinates; it is some 6e-6 of half the box.
    """
    return np.asarray(positions, np.float64) + caster.offset * np.asarray(normals, np.float64)


def _first_of_coincident(
    positions: NDArray[np.float64], faces: NDArray[np.int32]
) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """Faces without those that have the same three corners as an earlier one, whichever way round, and their backs.

    The back of a face is the first that has its corners the other way round, −1 where there is none.
    """
    corners = equal_rows(positions)[1][faces]
    first, group = equal_rows(np.sort(corners, axis=1))
    behind = np.full(len(first), len(faces))
    if len(first) < len(faces):
        a, b, c = corners.T
        turn = ((a < b).astype(np.int8) + (b < c) + (c < a)) % 2  # even permutations rise twice, odd ones once
        opposite = np.flatnonzero(turn != turn[first][group])
        np.minimum.at(behind, group[opposite], opposite)
    behind = np.where(behind < len(faces), behind, -1)
    return first.astype(np.int32), behind.astype(np.int32)


def in_chunks(work: Callable[[slice], None], count: int, size: int = CHUNK) -> None:
    """Call `work` for slices of `size` of 0 … `count`, on as many threads as there are cores; nothing follows order."""
    chunks = [slice(start, start + size) for start in range(0, count, size)]
    if len(chunks) < 2:
        for chunk in chunks:
            work(chunk)
        return
    with ThreadPoolExecutor(min(len(chunks), thread_count())) as pool:
        list(pool.map(work, chunks))


@scalar
def _refine(
    positions: NDArray[np.floating],
    faces: NDArray[np.integer],
    kept: NDArray[np.integer],
    behind: NDArray[np.integer],
    scale: float,
    origin: NDArray[np.floating],
    direction: NDArray[np.floating],
    face: NDArray[np.integer],
    distance: NDArray[np.floating],
    barycentric: NDArray[np.floating],
) -> None:
    """Work out in float64 where rays meet the faces that embree found, numbered among `kept`; fills the last three.

    A face that is met from its back is the one `behind` it where there is one.

    The weights of the corners are the volumes that the ray spans with the opposite edges, not below zero; the distance
    is that of the point they make, so it stays right where ray and face are nearly parallel. In coordinates about the
    origin of the ray, scaled to about one.
    """
    corner, towards = np.empty((3, 3)), np.empty(3)
    for ray in range(len(face)):
        distance[ray] = np.inf
        barycentric[ray] = 0.0
        if face[ray] < 0:
            continue
        number = face[ray]
        face[ray] = kept[number]
        length = 0.0
        for axis in range(3):
            towards[axis] = direction[ray, axis]
            length += towards[axis] * towards[axis]
        _weigh(positions, faces[face[ray]], scale, origin[ray], towards, corner, barycentric[ray])
        if behind[number] >= 0 and barycentric[ray].sum() > 0.0:
            face[ray] = behind[number]
            _weigh(positions, faces[face[ray]], scale, origin[ray], towards, corner, barycentric[ray])
        if barycentric[ray].sum() < 0.0:
            barycentric[ray] *= -1.0
        total = 0.0
        for k in range(3):
            barycentric[ray, k] = max(barycentric[ray, k], 0.0)
            total += barycentric[ray, k]
        along = 0.0
        for k in range(3):
            barycentric[ray, k] = barycentric[ray, k] / total if total > 0.0 else 1.0 / 3.0
            for axis in range(3):
                along += barycentric[ray, k] * corner[k, axis] * towards[axis]
        distance[ray] = max(along / length / scale, 0.0)


@scalar
def _weigh(
    positions: NDArray[np.floating],
    face: NDArray[np.integer],
    scale: float,
    origin: NDArray[np.floating],
    towards: NDArray[np.floating],
    corner: NDArray[np.floating],
    volume: NDArray[np.floating],
) -> None:
    """Fill the corners of a face about the origin of a ray, and the volumes that the ray spans with opposite edges."""
    for k in range(3):
        for axis in range(3):
            corner[k, axis] = (positions[face[k], axis] - origin[axis]) * scale
    for k in range(3):
        volume[k] = _volume(towards, corner[(k + 1) % 3], corner[(k + 2) % 3])


@scalar
def _volume(a: NDArray[np.floating], b: NDArray[np.floating], c: NDArray[np.floating]) -> float:
    return a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0])
