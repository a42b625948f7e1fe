"""Triangle meshes: the value, reading files, and what a file may lack (normals, texture coordinates).

Files are read by trimesh in another process (`engine.storage.untrusted`). Faces that cannot be used are dropped and
counted. Missing normals are area-weighted over the faces that meet at a point, except where the surface bends
sharply. Missing texture coordinates come from a box projection along the axis nearest to the smoothed normal, one
unit over the longest side of the bounding box, so that the texel density is even. v points up, image row 0 is v = 1.
Cost: about 1 s for 100,000 faces, most of it in trimesh.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.core.cached import cached_property
from engine.core.directions import normalize, uv_tangents, world_from_tangent
from engine.core.errors import InputError, UsageError
from engine.core.health import Finding, Health, Verdict
from engine.core.summary import Summary
from engine.geometry import mesh_repair, polygons, usd
from engine.geometry.brushing import Brushing
from engine.geometry.mesh_repair import (
    INSIDE_OUT,
    LARGEST,
    SMALLEST,
    Corners,
    Topology,
    blocks_of,
    corner_rows,
    list_used,
    merge_points,
    topology,
    usable_faces,
    weld,
    with_count,
)
from engine.geometry.mesh_text import check_text
from engine.geometry.mesh_weld import GAP, without_gaps
from engine.geometry.orientation import Orientation, find_turned
from engine.geometry.polygons import make_from_polygons
from engine.geometry.read_scene import check_memory, decoder_memory_bytes, files_beside, list_named_files
from engine.geometry.unwrap import with_atlas
from engine.storage.readers import load, readers, suffixes
from engine.storage.untrusted import decode_in_child

if TYPE_CHECKING:
    from scipy.sparse import csr_matrix

_POINTS = "It holds points or curves; give a mesh with faces, as .ply or .obj"
_UNPACK = "Unpack it and give the mesh that is in it"

#: Remedies for kinds of file that trimesh reads with further libraries only, or that hold no surface.
INSTEAD = {
    **dict.fromkeys((".3mf", ".3dxml", ".xaml", ".amf"), "Export it as .stl, .obj or .glb"),
    **dict.fromkeys((".dae", ".zae", ".fbx", ".blend", ".3ds"), "Export it as .glb"),
    **dict.fromkeys((".ctm", ".drc", ".binvox", ".wrl", ".x3d"), "Convert it to .ply"),
    **dict.fromkeys((".step", ".stp", ".iges", ".igs"), "Export the tessellated shape as .stl or .obj"),
    **dict.fromkeys((".xyz", ".pcd", ".las", ".dxf", ".svg"), _POINTS),
    **dict.fromkeys((".zip", ".gz", ".bz2", ".xz", ".7z", ".tar"), _UNPACK),
}

#: The figure that tells how many of the first faces of a mesh have a back, which as many faces after them are
#: (`engine.geometry.backs`).
BACKS = "backs"

#: Faces of a part whose gaps are closed, but for STL, whose faces share no vertices: of more it takes long.
MAX_CLOSED = 1 << 19

#: Seconds that reading may take.
LIMIT_S = 600.0

#: If a face turns further than this away from the smooth normal of its corner, its neighbours are looked at …
BENT = np.cos(np.radians(10.0))

#: … and those that meet it at more than this angle do not share their normal with it.
SHARP = np.cos(np.radians(50.0))

#: If more faces than this meet at a bent point (the tip of a cone), each keeps its own normal.
MAX_AROUND = 64


@dataclass(frozen=True, eq=False, repr=False)
class Mesh(Summary):
    """A surface of triangles in the coordinates of its file.

    Attributes
    ----------
    positions : (V, 3) float64.
    normals : (V, 3) float32 unit vectors.
    uv : (V, 2) float32 texture coordinates, v up.
    faces : (F, 3) int32, counter-clockwise seen from the side that the normals point to.
    name : shown to users.
    health : what was dropped or filled while reading.
    brushing : the direction along which anisotropic materials run.
    part : (F,) int32, for each face the place of its material among `part_names`; None where the file states none.
    part_names : names of the materials of the file.
    colours : (V, 3) float32 linear colours of the vertices, which multiply the base colour of PBR maps; None for white.
    """

    positions: NDArray[np.float64]
    normals: NDArray[np.float32]
    uv: NDArray[np.float32]
    faces: NDArray[np.int32]
    name: str
    health: Health = field(default_factory=Health)
    brushing: Brushing = field(default_factory=Brushing)
    part: NDArray[np.int32] | None = None
    part_names: tuple[str, ...] = ()
    colours: NDArray[np.float32] | None = None

    def __post_init__(self) -> None:
        count = len(self.positions)
        if not (self.normals.shape == (count, 3) and self.uv.shape == (count, 2) and self.faces.shape[1:] == (3,)):
            raise ValueError("positions, normals, uv and faces do not fit together")
        if len(self.faces) == 0 or self.faces.min() < 0 or self.faces.max() >= count:
            raise ValueError("faces are missing or name vertices that do not exist")
        if self.part is not None and not (
            self.part.shape == (len(self.faces),) and 0 <= self.part.min() <= self.part.max() < len(self.part_names)
        ):
            raise ValueError("each face needs a part that has a name")
        if self.colours is not None and self.colours.shape != (count, 3):
            raise ValueError("each vertex needs one colour")
        for array in (self.positions, self.normals, self.uv, self.faces, self.part, self.colours):
            if array is not None:
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
        """(V, 3) float32 unit vectors along which brushed materials run, as `brushing` says.

        Along the texture they are dP/du, or those of `world_from_tangent` where texture coordinates were made. A
        constant vector is that vector, which is projected into the surface where it is used.
        """
        normals = normalize(self.normals)
        if self.health.figures.get("texture_coordinates_made"):
            textured = world_from_tangent(normals)[..., 0]
        elif self.brushing.along is None:
            textured = uv_tangents(self.positions, self.normals, self.uv, self.faces)[0]
        else:
            textured = normals  # which the constant vector takes the place of
        return self.brushing.rotate(normals, textured)

    @cached_property
    def topology(self) -> Topology:
        """Connection of the faces: closed or convex, and counts of what is doubtful."""
        points, place = merge_points(self.positions)
        return topology(points, place[self.faces])

    def flipped(self) -> Mesh:
        """The same surface seen from its other side."""
        figures = {**self.health.figures, "flipped": 1.0 - self.health.figures.get("flipped", 0.0)}
        findings = tuple(finding for finding in self.health.findings if finding.text != INSIDE_OUT)
        health = Health(MappingProxyType(figures), findings)
        faces = np.ascontiguousarray(self.faces[:, ::-1])
        return replace(self, normals=-self.normals, faces=faces, health=health)

    def brush(self, brushing: Brushing) -> Mesh:
        """The same surface, brushed in another direction."""
        return self if brushing == self.brushing else replace(self, brushing=brushing)

    def summary(self) -> dict[str, Any]:
        """Return what `repr` says."""
        facts = {"name": self.name, "vertices": len(self.positions), "faces": len(self.faces)}
        return {**facts, "warnings": len(self.health.warnings)}


def read_mesh(path: str | os.PathLike[str], orientation: Orientation = "auto") -> Mesh:
    """Read a mesh of a known ending; InputError for a file that holds no usable triangle.

    One that would not fit in memory is refused before it is read. `orientation` says what is done with faces that are
    turned against each other or inside out (`engine.geometry.orientation`).
    """
    suffix = Path(path).suffix.lower()
    if suffix not in suffixes("mesh"):
        kind = suffix or "no ending"
        remedy = INSTEAD.get(suffix, f"Give {', '.join(suffixes('mesh'))}")
        raise InputError(path, f"is not a mesh that can be read ({kind})", remedy)
    limits: dict[str, Any] = {"memory_bytes": decoder_memory_bytes(), "timeout_s": LIMIT_S}
    decode = "engine.geometry.mesh:decode_mesh" if orientation == "auto" else "engine.geometry.mesh:decode_as_it_is"
    if suffix in usd.SUFFIXES:
        reply = usd.ask_usd(decode, Path(path), process=usd.__name__, **limits)
    else:
        check_memory(path)
        names = "engine.geometry.mesh:decode_names"
        named = decode_in_child(names, path, **limits)["uris"] if suffix == ".gltf" else []
        reply = decode_in_child(decode, path, beside=files_beside(path, named), **limits)
    mesh = _mesh(reply, path)
    return mesh.flipped() if orientation == "flip" else mesh


def mesh_of_arrays(positions: ArrayLike, faces: ArrayLike, uv: ArrayLike | None = None, name: str = "mesh") -> Mesh:
    """Make a mesh of arrays: vertices (V, 3), triangles (F, 3) of their indices, texture coordinates (V, 2) or None.

    Normals are made, and faces that cannot be used are dropped and counted, as in a file. UsageError for arrays of
    other shapes or kinds, InputError where no face is left.
    """
    points, indices = np.asarray(positions), np.asarray(faces)
    if points.ndim != 2 or points.shape[1] != 3 or points.dtype.kind not in "fiu" or not len(points):
        raise UsageError(f"vertices must be an array V × 3 of numbers, not {points.dtype} {points.shape}")
    if indices.ndim != 2 or indices.shape[1] != 3 or indices.dtype.kind not in "iu" or not len(indices):
        raise UsageError(f"faces must be an array F × 3 of vertex indices, not {indices.dtype} {indices.shape}")
    if indices.min() < 0 or indices.max() >= len(points):
        raise UsageError(f"faces name vertices {indices.min()} to {indices.max()}, and there are {len(points)} from 0")
    coordinates = None if uv is None else np.asarray(uv, np.float64)
    if coordinates is not None and coordinates.shape != (len(points), 2):
        raise UsageError(f"uv must be an array {len(points)} × 2, one row a vertex, not {coordinates.shape}")
    reply = complete(points.astype(np.float64), indices.astype(np.int64), None, coordinates, name)
    return _mesh(reply, name)


def _mesh(reply: dict[str, Any], path: str | os.PathLike[str]) -> Mesh:
    """The mesh of what `complete` returned; `path` names it."""
    figures = {name: float(count) for name, count in reply["figures"].items()}
    findings = tuple(Finding(Verdict(verdict), text) for verdict, text in reply["findings"])
    if figures["texture_coordinates_made"]:
        findings += with_atlas(reply, path)
    health = Health(MappingProxyType(figures), findings)
    return Mesh(
        reply["positions"],
        reply["normals"],
        reply["uv"],
        reply["faces"],
        Path(path).stem,
        health,
        part=reply.get("part"),
        part_names=tuple(reply.get("part_names", ())),
        colours=reply.get("colours"),
    )


def decode_as_it_is(content: bytes, name: str, **more: Any) -> dict[str, Any]:
    """As `decode_mesh`, with the faces turned as the file has them."""
    return decode_mesh(content, name, oriented=False, **more)


def decode_mesh(
    content: bytes,
    name: str,
    beside: Mapping[str, bytes] = MappingProxyType({}),
    oriented: bool = True,
    **copied: str,
) -> dict[str, Any]:
    """Decode the content of a mesh file into the arrays of a `Mesh` and counts; runs in the decoder process.

    `beside` holds the other files that a glTF file names; `copied` are the folder (`copies`) and the file that a USD
    file was copied to, in the place of its content, and it may lack layers, which are returned. Faces are `oriented`
    outwards and alike.
    """
    kind = Path(name).suffix.lower().lstrip(".")
    read = load(next(each.decode for each in readers("mesh") if f".{kind}" in each.endings))
    if copied:
        found = read(name=name, **copied)
        if isinstance(found, dict):
            return found
    else:
        content = check_text(content, kind, name)
        found = read(content, name, **({"beside": beside} if beside else {}))
    parts, too_few = (found, 0) if isinstance(found, list) else _cut(found)
    moved = 0
    for part in parts:
        if not kind.startswith("stl") and len(part["faces"]) > MAX_CLOSED:
            continue
        part["positions"], count = without_gaps(part["positions"], part["faces"])
        moved += count
    if not any(len(part["faces"]) for part in parts):
        raise InputError(name, "holds no triangles", "Give a mesh with faces, not points or curves alone")
    counted = {"faces_of_fewer_than_3_corners_dropped": too_few, "points_moved_to_close_gaps": moved}
    counted |= parts[0].get("counts", {})
    first_vertex = np.cumsum([0] + [len(part["positions"]) for part in parts])
    faces = [
        np.where(part["faces"] >= 0, part["faces"] + first, -1)
        for part, first in zip(parts, first_vertex, strict=False)
    ]
    colours = _join(parts, "colours", 3)
    names = list(dict.fromkeys(part["material"] for part in parts if part.get("material") is not None))
    part = parts[0].get("part") if len(parts) == 1 else None
    if names:
        part = np.concatenate([np.full(len(each["faces"]), names.index(each["material"])) for each in parts])
    names = names or parts[0].get("part_names", [])
    arrays = [np.concatenate(faces), np.concatenate([each["positions"] for each in parts])]
    normals, uv = _join(parts, "normals", 3), _join(parts, "uv", 2)
    del found, parts, faces
    completed = complete(
        arrays.pop(),  # so that they can be freed within
        arrays.pop(),
        normals,
        uv,
        name,
        counted,
        oriented,
        colours=None if colours is None else np.nan_to_num(colours, nan=1.0),
        part=part,
    )
    return {**completed, "part_names": names}


def decode_names(content: bytes, name: str) -> dict[str, Any]:
    """The other files that a glTF file names, as `uris`; runs in the decoder process."""
    return {"uris": list_named_files(content)}


def prepare() -> None:
    """Load the readers and compile what `decode_mesh` runs, before the child is confined."""
    polygons.prepare()
    mesh_repair.prepare()
    for reader in readers("mesh"):
        load(reader.decode)


def _cut(found: Any) -> tuple[list[dict[str, Any]], int]:
    """The triangles of `Polygons`, or of arrays (vertices, triangles), and how many polygons were none."""
    if isinstance(found, tuple):
        positions, faces = np.asarray(found[0], np.float64), np.asarray(found[1], np.int64)
        return [{"positions": positions, "faces": faces}], 0
    return [{"positions": found.points, **make_from_polygons(found)}], int(np.sum(found.sizes < 3))


def _join(parts: list[dict[str, Any]], key: str, columns: int) -> NDArray[np.float64] | None:
    """A table of the vertices of all parts, NaN for those that state nothing; None where none does.

    That of a single part may be of corners, (F, 3, columns), in place of vertices.
    """
    tables = [part.get(key) for part in parts]
    if len(parts) == 1 or all(table is None for table in tables):
        return tables[0] if len(parts) == 1 else None
    missing = [np.full((len(part["positions"]), columns), np.nan) for part in parts]
    return np.concatenate([rows if table is None else table for table, rows in zip(tables, missing, strict=True)])


def complete(
    positions: NDArray[np.float64],
    faces: NDArray[np.integer[Any]],
    normals: NDArray[np.float64] | None,
    uv: NDArray[np.float64] | None,
    name: str,
    counted: Mapping[str, int] = MappingProxyType({}),
    oriented: bool = True,
    *,
    colours: NDArray[np.float64] | None = None,
    part: NDArray[np.integer[Any]] | None = None,
) -> dict[str, Any]:
    """Drop what cannot be used, fill in what is missing, and lay the result out as the arrays of a `Mesh`.

    Normals, texture coordinates and colours are those of vertices, (V, …), or of corners, (F, 3, …), NaN where there
    are none; `part` (F,) is the number of the material of each face.
    Faces are turned as `engine.geometry.orientation` says where they are to be `oriented`.
    Returns positions, normals, uv, faces, `figures`, the counts of what was dropped and filled (with those `counted`
    before), and `findings`, pairs of a verdict and what it says. InputError where no face is left.
    """
    usable, figures = usable_faces(positions, faces)
    figures |= counted
    if not usable.any():
        counts = ", ".join(with_count(count, _plain(reason)) for reason, count in figures.items() if count)
        raise InputError(name, f"holds no usable triangle ({counts})", "Export it again")
    faces = np.asarray(faces, np.int64)[usable]
    vertex = faces.astype(np.int32)
    of_normals, of_uv, of_colours = (
        None if table is None else Corners(table, vertex) if table.ndim == 2 else Corners(table[usable])
        for table in (normals, uv, colours)
    )
    del normals, uv, colours
    used, place_of = list_used(faces, len(positions))
    figures["vertices_without_faces_dropped"] = len(positions) - len(used)
    positions = positions[used]
    points, place = merge_points(positions)
    figures["vertices_at_the_same_place"] = len(place) - len(points)
    faces = place[place_of[faces]]
    del positions, used, place, place_of
    _check_size(points, name)

    directed = np.cross(points[faces[:, 1]] - points[faces[:, 0]], points[faces[:, 2]] - points[faces[:, 0]])
    turned = _find_turned(points, faces, directed, of_normals) if oriented else np.zeros(len(faces), np.bool_)
    figures["faces_turned"] = int(turned.sum())
    ordered: list[NDArray[Any]] = [
        faces,
        vertex,
        *(each.table for each in (of_normals, of_uv, of_colours) if each and each.vertex is None),
    ]
    for rows in ordered:
        rows[turned] = rows[turned, ::-1]
    directed[turned] *= -1.0
    incidence = _incidence(faces, len(points))
    smooth = normalize(incidence @ directed, fallback=(0.0, 0.0, 0.0))
    corner_normals = _corner_normals(smooth, directed, faces, incidence)
    if of_normals is not None:
        wrong, facing = _take_stated(corner_normals, of_normals, directed)
        figures["normals_replaced"] = len(np.unique(faces[wrong]))
        if oriented:
            corner_normals[facing < 0.0] *= -1.0
        elif np.sum(facing) < 0.0:
            directed, smooth = -directed, -smooth
            for rows in (*ordered, corner_normals):
                rows[:] = rows[:, ::-1].copy()
    made = ~_find_usable_uv(of_uv, len(faces))
    if made.any():
        projected = _box_projection(points, faces, directed, smooth, incidence)
        if of_uv is not None:
            for block in blocks_of(len(faces)):
                projected[block] = np.where(made[block, None, None], projected[block], of_uv.at(block))
        of_uv = Corners(projected)
    assert of_uv is not None
    figures["texture_coordinates_made"] = int(made.all())
    figures["faces_without_texture_coordinates"] = int(made.sum())
    del directed, incidence, smooth  # what follows takes as much memory again
    corners = corner_rows(faces, Corners(corner_normals), of_uv, of_colours)
    del corner_normals, of_normals, of_uv, of_colours, vertex, ordered
    welded = weld(points, corners)
    del corners
    shape = topology(points, faces)
    findings = [(int(one.verdict), one.text) for one in (*findings_of(figures), *shape.findings)]
    return {
        **welded,
        **({} if part is None else {"part": part[usable].astype(np.int32)}),
        "figures": {**figures, **shape.figures},
        "findings": findings,
    }


def _find_turned(
    points: NDArray[np.float64],
    faces: NDArray[np.int64],
    directed: NDArray[np.float64],
    normals: Corners | None,
) -> NDArray[np.bool_]:
    """Which faces (F,) are to be turned; those that state `normals` vote by them for the front of an open part."""
    votes = np.linalg.norm(directed, axis=1)
    if normals is None:
        return find_turned(points, faces, votes)
    for block in blocks_of(len(faces)):
        facing = np.nan_to_num(np.einsum("fci,fi->f", normals.at(block), directed[block]), nan=1.0)
        votes[block] *= np.where(facing < 0.0, -1.0, 1.0)
    return find_turned(points, faces, votes)


def _check_size(points: NDArray[np.float64], name: str) -> None:
    size = float(np.max(np.ptp(points, axis=0)))
    if size < SMALLEST:
        raise InputError(name, f"is {size:.3g} across, too small to be drawn", f"Scale it to more than {SMALLEST:g}")


def _take_stated(
    made: NDArray[np.float32], stated: Corners, directed: NDArray[np.float64]
) -> tuple[NDArray[np.bool_], NDArray[np.float64]]:
    """Put unit normals that are `stated` in the place of those `made` (F, 3, 3).

    What is zero or not finite becomes the normal of the face. Returned is at which corners (F, 3), and the sum of the
    normals of a face along its own (F,), which is negative where they look the other way.
    """
    replaced, facing = np.empty(made.shape[:2], np.bool_), np.empty(len(made))
    for block in blocks_of(len(made)):
        given = stated.at(block)
        unit = normalize(given, fallback=(0.0, 0.0, 0.0))
        missing = np.all(np.isnan(given), axis=-1)
        replaced[block] = wrong = ~np.any(unit, axis=-1) & ~missing
        unit = np.where(wrong[..., None], normalize(directed[block])[:, None], unit)
        unit = np.where(missing[..., None], made[block], unit)
        facing[block] = np.einsum("fci,fi->f", unit, directed[block])
        made[block] = unit
    return replaced, facing


def _find_usable_uv(stated: Corners | None, count: int) -> NDArray[np.bool_]:
    """Which of so many faces (F,) have texture coordinates of use among those `stated`.

    Those that are one point or one line for the whole mesh count as none.
    """
    usable = np.zeros(count, np.bool_)
    if stated is None:
        return usable
    low, high = np.full(2, np.inf), np.full(2, -np.inf)
    for block in blocks_of(count):
        given = stated.at(block)
        usable[block] = np.all(np.abs(given) < LARGEST, axis=(1, 2))
        low = np.minimum(low, given[usable[block]].min(axis=(0, 1), initial=np.inf))
        high = np.maximum(high, given[usable[block]].max(axis=(0, 1), initial=-np.inf))
    return usable if (high > low).all() else np.zeros(count, np.bool_)


def _plain(figure: str) -> str:
    return figure.removesuffix("_dropped").replace("_", " ").replace("non finite", "non-finite")


def findings_of(figures: Mapping[str, float]) -> list[Finding]:
    """Findings in words for the counts of a mesh."""
    findings = []
    for name, count in figures.items():
        if name.endswith("_dropped") and count:
            verdict = Verdict.NOTE if name.startswith("vertices") else Verdict.WARNING
            findings.append(Finding(verdict, with_count(int(count), f"{_plain(name)} excluded")))
    if count := int(figures.get("points_moved_to_close_gaps", 0)):
        text = f"points were moved by less than {2 * GAP:g} of the size, to close gaps that rounding had left"
        findings.append(Finding(Verdict.NOTE, with_count(count, text)))
    if count := int(figures.get("subdivision_surfaces", 0)):
        text = "subdivision surfaces are drawn as their control meshes"
        findings.append(Finding(Verdict.NOTE, with_count(count, text)))
    if count := int(figures.get("faces_turned", 0)):
        text = "faces were turned, so that neighbours are alike and closed parts face outwards"
        findings.append(Finding(Verdict.WARNING, with_count(count, text)))
    if count := int(figures.get("normals_replaced", 0)):
        findings.append(Finding(Verdict.WARNING, with_count(count, "normals were none and taken from the faces")))
    count = int(figures["faces_without_texture_coordinates"])
    if count and not figures["texture_coordinates_made"]:
        text = with_count(count, "faces without texture coordinates got those of a box")
        findings.append(Finding(Verdict.WARNING, text))
    return findings


def _incidence(faces: NDArray[np.int64], points: int) -> Any:
    """Sparse (points, faces) matrix: 1 where the point is a corner of the face."""
    from scipy.sparse import csr_matrix

    columns = np.repeat(np.arange(len(faces)), 3)
    return csr_matrix((np.ones(columns.size), (faces.reshape(-1), columns)), shape=(points, len(faces)))


def _corner_normals(
    smooth: NDArray[np.float64], directed: NDArray[np.float64], faces: NDArray[np.int64], incidence: csr_matrix
) -> NDArray[np.float32]:
    """(F, 3, 3) the smooth normal of the point; where it bends sharply, from the faces on this side of the bend."""
    flat = normalize(directed)
    bent = np.empty(faces.shape, np.bool_)
    for block in blocks_of(len(faces)):
        bent[block] = np.einsum("fci,fi->fc", smooth[faces[block]], flat[block]) < BENT
    normals = smooth.astype(np.float32)[faces]  # vertices have no more
    face, corner = np.nonzero(bent)
    point = faces[face, corner]
    around = np.diff(incidence.indptr)[point]
    few = around <= MAX_AROUND
    normals[face[~few], corner[~few]] = flat[face[~few]]
    face, corner, point, around = face[few], corner[few], point[few], around[few]
    first = np.cumsum(around) - around
    which = np.repeat(np.arange(len(face)), around)
    other = incidence.indices[incidence.indptr[point][which] + np.arange(len(which)) - first[which]]
    near = np.einsum("pi,pi->p", flat[face[which]], flat[other]) > SHARP
    around_here = [np.bincount(which, near * directed[other, axis], minlength=len(face)) for axis in range(3)]
    normals[face, corner] = normalize(np.stack(around_here, axis=-1))
    return normals


def _box_projection(
    points: NDArray[np.float64],
    faces: NDArray[np.int64],
    directed: NDArray[np.float64],
    smooth: NDArray[np.float64],
    incidence: csr_matrix,
) -> NDArray[np.float32]:
    """(F, 3, 2) coordinates along the axis nearest to the smoothed normal, so that the patches are large.

    A face that this would foreshorten to less than half is projected along the axis nearest to its own normal.
    """
    area = np.linalg.norm(directed, axis=1, keepdims=True)
    for _ in range(8):
        facing = normalize(incidence.T @ smooth)
        smooth = normalize(incidence @ (facing * area))
    low, high = points.min(axis=0), points.max(axis=0)
    centred = (points - (low + high) / 2.0) / np.max(high - low)
    uv = np.empty((*faces.shape, 2), np.float32)
    for block in blocks_of(len(faces)):
        uv[block] = _project(centred, faces[block], normalize(directed[block]), facing[block])
    return uv


def _project(
    centred: NDArray[np.float64],
    faces: NDArray[np.int64],
    own: NDArray[np.float64],
    facing: NDArray[np.float64],
) -> NDArray[np.float64]:
    """(F, 3, 2) coordinates of corners along the axis nearest to the normals `facing` (F, 3), or to their `own`."""
    axis = np.argmax(np.abs(facing), axis=1)
    steep = np.abs(own[np.arange(len(axis)), axis]) < 0.5
    axis, facing = np.where(steep, np.argmax(np.abs(own), axis=1), axis), np.where(steep[:, None], own, facing)
    sign = np.sign(np.take_along_axis(facing, axis[:, None], axis=1))[:, 0]
    # along x: −s z and y; along y: x and −s z; along z: s x and y
    along_u, along_v = np.array([2, 0, 0])[axis], np.array([1, 2, 1])[axis]
    sign_u = np.where(axis == 0, -sign, np.where(axis == 2, sign, 1.0))
    sign_v = np.where(axis == 1, -sign, 1.0)
    u = sign_u[:, None] * centred[faces, along_u[:, None]]
    return np.stack([u, sign_v[:, None] * centred[faces, along_v[:, None]]], axis=-1)
