"""Texture coordinates for meshes that have none, in charts that do not overlap (xatlas, after Levy2002).

As with the box projection that stands in elsewhere, one unit of texture is the longest side of the bounding box;
xatlas keeps areas in the mean, so that the density is even. Charts that it cuts mirrored are turned over, and then all
are laid out once more.
xatlas has no way to be stopped, and its time grows faster than the mesh. It therefore works in the decoder process,
under a limit, and on meshes of at most `MAX_FACES`; what it cannot do in time keeps the box projection.
"""

from __future__ import annotations

import os
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.core.errors import InputError
from engine.core.health import Finding, Verdict
from engine.geometry.mesh_repair import Corners, corner_rows, merge_points, weld
from engine.storage.untrusted import decode_content

#: Largest mesh that is given charts: 6,000 faces take about 0.4 s of one core, 20,000 already 9 s.
MAX_FACES = 10_000

#: Most parts that do not hang together: each is a chart, and 10,000 loose triangles take more than a minute.
MAX_PARTS = 300

#: Seconds after which the box projection stays.
LIMIT_S = 15.0

#: Texels over the longest side, to which xatlas rounds the places of its charts, and texels between charts.
TEXELS, PADDING = 1024, 2


def with_atlas(reply: dict[str, Any], path: str | os.PathLike[str]) -> tuple[Finding, ...]:
    """Replace the made texture coordinates in the arrays of a mesh by charts, where that takes seconds only.

    `reply` holds positions, normals, uv, faces and figures; what was done is returned.
    """
    faces, parts = len(reply["faces"]), int(reply["figures"]["components"])
    if faces > MAX_FACES:
        why = f"the mesh has {faces} faces, and charts are cut for at most {MAX_FACES}"
    elif parts > MAX_PARTS:
        why = f"the mesh has {parts} parts, and charts are cut for at most {MAX_PARTS}"
    else:
        try:
            tables = [reply[key] for key in ("positions", "normals", "colours") if key in reply]
            arrays = np.concatenate(tables, axis=1, dtype=np.float64), reply["faces"].astype(np.int32)
            content = b"".join(array.tobytes() for array in arrays)
            reply |= decode_content(
                "engine.geometry.unwrap:decode_atlas",
                path,
                content,
                timeout_s=LIMIT_S,
                vertices=len(arrays[0]),
                columns=arrays[0].shape[1],
            )
            return (Finding(Verdict.NOTE, "texture coordinates were made, in charts that do not overlap"),)
        except InputError as error:
            why = f"charts could not be cut ({error.problem})"
    return (Finding(Verdict.NOTE, f"texture coordinates were made by a box projection: {why}"),)


def decode_atlas(content: bytes, name: str, vertices: int, columns: int = 6) -> dict[str, Any]:
    """positions, normals, uv and faces with charts, from the bytes of (V, 6) float64 and (F, 3) int32.

    Vertices of 9 numbers have colours.
    """
    size = vertices * columns * 8
    table = np.frombuffer(content[:size]).reshape(-1, columns)
    faces = np.frombuffer(content[size:], np.int32).reshape(-1, 3).astype(np.int64)
    points, place = merge_points(table[:, :3])
    corners, vertex = place[faces], faces.astype(np.int32)
    colours = Corners(table[:, 6:], vertex) if columns == 9 else None
    uv = Corners(atlas(points, corners, name))
    return weld(points, corner_rows(corners, Corners(table[:, 3:6], vertex), uv, colours))


def atlas(points: NDArray[np.float64], faces: NDArray[np.int64], name: str = "") -> NDArray[np.float64]:
    """(F, 3, 2) texture coordinates of the corners of `faces` between different `points`.

    InputError about `name` where xatlas finds none: it works in 32 bits, in which charts of extreme shape vanish.
    """
    import xatlas

    used, index = np.unique(faces, return_inverse=True)
    corners = index.reshape(-1, 3).astype(np.uint32)
    low, high = points[used].min(axis=0), points[used].max(axis=0)
    charts = xatlas.Atlas()
    charts.add_mesh(((points[used] - low) / np.max(high - low)).astype(np.float32), corners)
    vertex, cut, uv = _pack(charts, name)
    if cut.shape != faces.shape or not np.array_equal(vertex[cut], corners):
        raise ValueError("the charts are not those of the mesh")
    turned = xatlas.Atlas()
    turned.add_uv_mesh(_turn_over(uv, cut).astype(np.float32), cut)
    vertex, again, uv = _pack(turned, name)
    if again.shape != cut.shape or not np.array_equal(vertex[again], cut):
        raise ValueError("the charts changed as they were laid out")
    return uv[again]


def _pack(charts: Any, name: str) -> tuple[NDArray[np.uint32], NDArray[np.uint32], NDArray[np.float64]]:
    """Cut and lay out: which vertex each new one was, the faces between new ones, and where these lie."""
    import xatlas

    pack = xatlas.PackOptions()
    pack.texels_per_unit, pack.padding = TEXELS, PADDING
    pack.rotate_charts = False  # it exchanges u and v, which mirrors
    charts.generate(xatlas.ChartOptions(), pack)
    vertex, faces, uv = charts.get_mesh(0)
    uv = uv * (np.array([charts.width, charts.height], np.float64) / TEXELS)
    if not np.isfinite(uv).all():
        raise InputError(
            name, "they have no size in 32 bits where a mesh is much longer than wide", "Cut them elsewhere"
        )
    return vertex, faces, uv


def _turn_over(uv: NDArray[np.float64], faces: NDArray[np.uint32]) -> NDArray[np.float64]:
    """Coordinates (V, 2) with the charts that are mirrored seen from behind."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    pairs = faces[:, [0, 1, 1, 2]].reshape(-1, 2)
    joined = coo_matrix((np.ones(len(pairs), np.int8), (pairs[:, 0], pairs[:, 1])), shape=(len(uv), len(uv)))
    count, chart = connected_components(joined, directed=False)
    a, b, c = (uv[faces[:, corner]] for corner in range(3))
    area = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    mirrored = np.bincount(chart[faces[:, 0]], area, count)[chart] < 0.0
    return np.stack([np.where(mirrored, uv[:, 0].max() - uv[:, 0], uv[:, 0]), uv[:, 1]], axis=-1)
