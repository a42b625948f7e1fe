"""Triangle meshes: the value, reading files, and what a file may lack (normals, texture coordinates).

Files are read by trimesh in another process (`engine.files.untrusted`). Faces that cannot be used are dropped and
counted. Missing normals are area-weighted over the faces that meet at a point, except where the surface bends
sharply. Missing texture coordinates come from a box projection along the axis nearest to the smoothed normal, one
unit over the longest side of the bounding box, so that the texel density is even. v points up, image row 0 is v = 1.
Cost: about 1 s for 100,000 faces, most of it in trimesh.
"""

from __future__ import annotations

import io
import os
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.directions import normalize, world_from_tangent
from engine.errors import InputError
from engine.files.untrusted import AGAIN, decode_in_child
from engine.health import Finding, Health, Verdict
from engine.mesh_text import checked_text
from engine.tangents import uv_tangents

#: Kinds of file, by the ending of the name.
SUFFIXES = (".glb", ".gltf", ".obj", ".off", ".ply", ".stl")

#: Where a face turns further than this away from the smooth normal of its corner, its neighbours are looked at …
BENT = np.cos(np.radians(10.0))

#: … and those that meet it at more than this angle do not share their normal with it.
SHARP = np.cos(np.radians(50.0))

#: Where more faces than this meet at a bent point (the tip of a cone), each keeps its own normal.
MOST_AROUND = 64


@dataclass(frozen=True, eq=False)
class Mesh:
    """A surface of triangles in the coordinates of its file.

    Attributes
    ----------
    positions : (V, 3) float64.
    normals : (V, 3) float32 unit vectors.
    uv : (V, 2) float32 texture coordinates, v up.
    faces : (F, 3) int32, counter-clockwise seen from the side that the normals point to.
    name : shown to people.
    health : what was dropped or filled while reading.
    """

    positions: NDArray[np.float64]
    normals: NDArray[np.float32]
    uv: NDArray[np.float32]
    faces: NDArray[np.int32]
    name: str
    health: Health = field(default_factory=Health)

    def __post_init__(self) -> None:
        count = len(self.positions)
        if not (self.normals.shape == (count, 3) and self.uv.shape == (count, 2) and self.faces.shape[1:] == (3,)):
            raise ValueError("positions, normals, uv and faces do not fit together")
        if len(self.faces) == 0 or self.faces.min() < 0 or self.faces.max() >= count:
            raise ValueError("faces are missing or name vertices that do not exist")
        for array in (self.positions, self.normals, self.uv, self.faces):
            array.flags.writeable = False

    @cached_property
    def centre(self) -> NDArray[np.float64]:
        """Centre (3,) of the bounding box."""
        return (self.positions.min(axis=0) + self.positions.max(axis=0)) / 2.0

    @cached_property
    def radius(self) -> float:
        """Radius of the smallest sphere about `centre` that holds the mesh."""
        return float(np.sqrt(np.max(np.sum((self.positions - self.centre) ** 2, axis=1))))

    @cached_property
    def tangents(self) -> NDArray[np.float32]:
        """(V, 3) float32 unit vectors along which brushed materials run: dP/du where the mesh came with coordinates.

        Where texture coordinates were made, they are those of `world_from_tangent`.
        """
        if self.health.figures.get("texture_coordinates_made"):
            return world_from_tangent(normalize(self.normals))[..., 0].astype(np.float32)
        return uv_tangents(self.positions, self.normals, self.uv, self.faces)[0].astype(np.float32)


def read_mesh(path: str | os.PathLike[str]) -> Mesh:
    """Read OBJ, PLY, STL, OFF, glTF or GLB; InputError for a file that holds no usable triangle."""
    suffix = Path(path).suffix.lower()
    if suffix not in SUFFIXES:
        raise InputError(
            path, f"is not a mesh that can be read ({suffix or 'no ending'})", f"Give {', '.join(SUFFIXES)}"
        )
    reply = decode_in_child("engine.mesh:decode_mesh", path, timeout_s=120.0)
    figures = MappingProxyType({name: float(count) for name, count in reply["figures"].items()})
    dropped = {name: int(count) for name, count in figures.items() if name.endswith("_dropped") and count}
    findings = tuple(
        Finding(Verdict.WARNING, f"{count} {name.removesuffix('_dropped').replace('_', ' ')} left out")
        for name, count in dropped.items()
    )
    return Mesh(
        reply["positions"], reply["normals"], reply["uv"], reply["faces"], Path(path).stem, Health(figures, findings)
    )


def decode_mesh(content: bytes, name: str) -> dict[str, Any]:
    """Decode the content of a mesh file into the arrays of a `Mesh` and counts; runs in the decoder process."""
    suffix = Path(name).suffix.lower().lstrip(".")
    scene = _scene(checked_text(content, suffix, name), suffix, name)
    parts = [
        _part(scene.geometry[name], transform) for transform, name in map(scene.graph.get, scene.graph.nodes_geometry)
    ]
    parts = [part for part in parts if len(part["faces"])]
    if not parts:
        raise InputError(name, "holds no triangles", "Give a mesh with faces, not points or curves alone")
    first_vertex = np.cumsum([0] + [len(part["positions"]) for part in parts])
    faces = [part["faces"] + first for part, first in zip(parts, first_vertex, strict=False)]
    normals, uv = (
        np.concatenate([part[key] for part in parts]) if all(part[key] is not None for part in parts) else None
        for key in ("normals", "uv")
    )
    return complete(np.concatenate([part["positions"] for part in parts]), np.concatenate(faces), normals, uv, name)


def _scene(content: bytes, suffix: str, name: str) -> Any:
    """What trimesh finds, where it could read all of it."""
    import trimesh

    options = {"skip_materials": True} if suffix == "obj" else {}
    with warnings.catch_warnings():
        # numpy stops at the first thing that is no number, and trimesh goes on with what came before it
        warnings.filterwarnings("error", message=".*could not be read to its end", category=DeprecationWarning)
        try:
            return trimesh.load_scene(io.BytesIO(content), file_type=suffix, process=False, **options)
        except (DeprecationWarning, ImportError, NameError) as error:
            raise InputError(name, f"is damaged or of an unknown kind ({error})", AGAIN) from None


def _part(geometry: Any, world_from_part: NDArray[np.float64]) -> dict[str, Any]:
    """Faces, positions, normals and texture coordinates of one geometry of a scene, the last two None where absent.

    trimesh's own concatenation would do, but copies materials, and for that it wants an image library.
    """
    if not hasattr(geometry, "faces"):
        return {"faces": ()}
    linear = world_from_part[:3, :3]
    positions = np.asarray(geometry.vertices, np.float64) @ linear.T + world_from_part[:3, 3]
    normals = geometry._cache.cache.get("vertex_normals")
    if normals is not None and len(normals) == len(positions):
        normals = np.asarray(normals, np.float64) @ np.linalg.inv(linear)
    else:
        normals = None
    uv = getattr(geometry.visual, "uv", None)
    usable = uv is not None and len(uv) == len(positions) and np.isfinite(uv).all() and np.ptp(uv, axis=0).all()
    faces = np.asarray(geometry.faces, np.int64).reshape(-1, 3)
    return {
        "faces": faces[:, ::-1] if np.linalg.det(linear) < 0.0 else faces,
        "positions": positions,
        "normals": normals,
        "uv": np.asarray(uv, np.float64)[:, :2] if usable else None,
    }


def complete(
    positions: NDArray[np.float64],
    faces: NDArray[np.integer[Any]],
    normals: NDArray[np.float64] | None,
    uv: NDArray[np.float64] | None,
    name: str,
) -> dict[str, Any]:
    """Drop what cannot be used, fill in what is missing, and lay the result out as the arrays of a `Mesh`.

    Returns positions, normals, uv, faces and `figures`, the counts of what was dropped and filled. InputError where
    no face is left.
    """
    faces, figures = usable_faces(positions, faces)
    if len(faces) == 0:
        raise InputError(name, "holds no usable triangle", "Export it again; all its faces are damaged or have no area")
    points, point_of_vertex = np.unique(np.where(np.isfinite(positions), positions, 0.0), axis=0, return_inverse=True)
    merged = point_of_vertex.reshape(-1)[faces]
    directed = np.cross(points[merged[:, 1]] - points[merged[:, 0]], points[merged[:, 2]] - points[merged[:, 0]])
    incidence = _incidence(merged, len(points))
    smooth = normalize(incidence @ directed, fallback=(0.0, 0.0, 0.0))

    if normals is None:
        corner_normals = _corner_normals(smooth, directed, merged, incidence)
    else:
        given = normalize(normals, fallback=(0.0, 0.0, 0.0))[faces]
        corner_normals = np.where(given.any(axis=-1, keepdims=True), given, normalize(directed)[:, None])
        figures["normals_replaced"] = len(np.unique(faces[~given.any(axis=-1)]))
        if np.sum(corner_normals * directed[:, None]) < 0.0:
            faces, corner_normals = faces[:, ::-1], corner_normals[:, ::-1]

    if uv is None:
        corner_uv = _box_projection(points, faces, point_of_vertex.reshape(-1), directed, smooth, incidence)
    else:
        corner_uv = uv[faces]
    figures["texture_coordinates_made"] = int(uv is None)
    return {**_weld(positions, faces, corner_normals, corner_uv), "figures": figures}


def usable_faces(
    positions: NDArray[np.float64], faces: NDArray[np.integer[Any]]
) -> tuple[NDArray[np.int64], dict[str, int]]:
    """The faces (F, 3) that name existing, finite vertices and have an area, and counts of the others by reason."""
    faces = np.asarray(faces, np.int64)
    inside = ((faces >= 0) & (faces < len(positions))).all(axis=1)
    counts = {"faces_with_wrong_indices_dropped": int(np.sum(~inside))}
    faces = np.compress(inside, faces, axis=0)
    vertex_is_finite = np.all(np.isfinite(positions), axis=1, keepdims=True)
    finite = vertex_is_finite[faces, 0].all(axis=1)
    counts["faces_with_non_finite_vertices_dropped"] = int(np.sum(~finite))
    faces = np.compress(finite, faces, axis=0)
    a, b, c = (positions[faces[:, corner]] for corner in range(3))
    with np.errstate(over="ignore", invalid="ignore"):
        area = np.cross(b - a, c - a)
    flat = ~(np.isfinite(area).all(axis=1) & area.any(axis=1))
    counts["faces_without_area_dropped"] = int(np.sum(flat))
    return np.compress(~flat, faces, axis=0), counts


def _incidence(faces: NDArray[np.int64], points: int) -> Any:
    """Sparse (points, faces) matrix: 1 where the point is a corner of the face."""
    from scipy.sparse import csr_matrix

    columns = np.repeat(np.arange(len(faces)), 3)
    return csr_matrix((np.ones(columns.size), (faces.reshape(-1), columns)), shape=(points, len(faces)))


def _corner_normals(
    smooth: NDArray[np.float64], directed: NDArray[np.float64], faces: NDArray[np.int64], incidence: Any
) -> NDArray[np.float64]:
    """(F, 3, 3) the smooth normal of the point; where it bends sharply, from the faces on this side of the bend."""
    flat = normalize(directed)
    normals = smooth[faces]
    face, corner = np.nonzero(np.einsum("fci,fi->fc", normals, flat) < BENT)
    point = faces[face, corner]
    around = np.diff(incidence.indptr)[point]
    few = around <= MOST_AROUND
    normals[face[~few], corner[~few]] = flat[face[~few]]
    face, corner, point, around = face[few], corner[few], point[few], around[few]
    first = np.cumsum(around) - around
    which = np.repeat(np.arange(len(face)), around)
    other = incidence.indices[incidence.indptr[point][which] + np.arange(len(which)) - first[which]]
    near = np.einsum("pi,pi->p", flat[face[which]], flat[other]) > SHARP
    for axis in range(3):
        normals[face, corner, axis] = np.bincount(which, near * directed[other, axis], minlength=len(face))
    normals[face, corner] = normalize(normals[face, corner])
    return normals


def _box_projection(
    points: NDArray[np.float64],
    faces: NDArray[np.int64],
    point_of_vertex: NDArray[np.int64],
    directed: NDArray[np.float64],
    smooth: NDArray[np.float64],
    incidence: Any,
) -> NDArray[np.float64]:
    """(F, 3, 2) coordinates along the axis nearest to the smoothed normal, so that the patches are large.

    A face that this would foreshorten to less than half is projected along the axis nearest to its own normal.
    """
    area = np.linalg.norm(directed, axis=1, keepdims=True)
    for _ in range(8):
        facing = normalize(incidence.T @ smooth)
        smooth = normalize(incidence @ (facing * area))
    used = points[np.unique(point_of_vertex[faces])]
    low, high = used.min(axis=0), used.max(axis=0)
    corners = (points[point_of_vertex[faces]] - (low + high) / 2.0) / np.max(high - low)
    own = normalize(directed)
    axis = np.argmax(np.abs(facing), axis=1)
    steep = np.abs(own[np.arange(len(axis)), axis]) < 0.5
    axis, facing = np.where(steep, np.argmax(np.abs(own), axis=1), axis), np.where(steep[:, None], own, facing)
    sign = np.sign(np.take_along_axis(facing, axis[:, None], axis=1))
    x, y, z = np.moveaxis(corners, -1, 0)
    by_axis = np.stack([np.stack([-sign * z, y], -1), np.stack([x, -sign * z], -1), np.stack([sign * x, y], -1)])
    return by_axis[axis, np.arange(len(axis))]


def _weld(
    positions: NDArray[np.float64],
    faces: NDArray[np.int64],
    corner_normals: NDArray[np.float64],
    corner_uv: NDArray[np.float64],
) -> Mapping[str, Any]:
    """One vertex for all corners that agree in vertex, normal and texture coordinate."""
    corners = np.concatenate(
        [faces.reshape(-1, 1), corner_normals.reshape(-1, 3).astype(np.float32), corner_uv.reshape(-1, 2)], axis=1
    )
    order = np.lexsort(corners.T)
    starts = np.concatenate([[True], (np.diff(corners[order], axis=0) != 0.0).any(axis=1)])
    first = order[starts]
    index = np.empty(len(corners), np.int64)
    index[order] = np.cumsum(starts) - 1
    return {
        "positions": positions[faces.reshape(-1)[first]],
        "normals": corners[first, 1:4].astype(np.float32),
        "uv": corners[first, 4:].astype(np.float32),
        "faces": index.reshape(-1, 3).astype(np.int32),
    }
