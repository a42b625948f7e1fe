"""Texture coordinates for meshes that have none, in charts that do not overlap (xatlas, after Lévy et al. 2002).

As with the box projection that stands in elsewhere, one unit of texture is the longest side of the bounding box;
xatlas keeps areas in the mean, so that the density is even. Charts that it lays out mirrored are turned back.
xatlas has no way to be stopped, and its time grows faster than the mesh. It therefore works in the decoder process,
under a limit, and on meshes of at most `MOST_FACES`; what it cannot do in time keeps the box projection.
"""

from __future__ import annotations

import os
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.errors import InputError
from engine.files.untrusted import decode_content
from engine.health import Finding, Verdict
from engine.mesh_clean import merged_points, weld

#: Largest mesh that is given charts: about 2 s.
MOST_FACES = 10_000

#: Seconds after which the box projection stays.
LIMIT_S = 20.0

#: Texels over the longest side, to which xatlas rounds the places of its charts, and texels between charts.
TEXELS, PADDING = 1024, 2


def with_atlas(reply: dict[str, Any], path: str | os.PathLike[str]) -> tuple[Finding, ...]:
    """Replace the made texture coordinates in the arrays of a mesh by charts, where that takes seconds only.

    `reply` holds positions, normals, uv and faces; what was done is returned.
    """
    faces = len(reply["faces"])
    if faces > MOST_FACES:
        why = f"the mesh has {faces} faces, and charts are cut for at most {MOST_FACES}"
    else:
        try:
            arrays = np.concatenate([reply["positions"], reply["normals"]], axis=1), reply["faces"].astype(np.int32)
            content = b"".join(array.tobytes() for array in arrays)
            reply |= decode_content(
                "engine.unwrap:decode_atlas", path, content, timeout_s=LIMIT_S, vertices=len(arrays[0])
            )
            return (Finding(Verdict.NOTE, "texture coordinates were made, in charts that do not overlap"),)
        except InputError as error:
            why = f"charts could not be cut ({error.problem})"
    return (Finding(Verdict.NOTE, f"texture coordinates were made by a box projection: {why}"),)


def decode_atlas(content: bytes, name: str, vertices: int) -> dict[str, Any]:
    """positions, normals, uv and faces with charts, from the bytes of (V, 6) float64 and (F, 3) int32."""
    size = vertices * 6 * 8
    table = np.frombuffer(content[:size]).reshape(-1, 6)
    faces = np.frombuffer(content[size:], np.int32).reshape(-1, 3).astype(np.int64)
    points, place = merged_points(table[:, :3])
    return weld(points, place[faces], table[:, 3:][faces], atlas(points, place[faces]))


def atlas(points: NDArray[np.float64], faces: NDArray[np.int64]) -> NDArray[np.float64]:
    """(F, 3, 2) texture coordinates of the corners of `faces` between different `points`."""
    import xatlas

    used, index = np.unique(faces, return_inverse=True)
    low, high = points[used].min(axis=0), points[used].max(axis=0)
    inside = ((points[used] - low) / np.max(high - low)).astype(np.float32)
    pack = xatlas.PackOptions()
    pack.texels_per_unit, pack.padding = TEXELS, PADDING
    charts = xatlas.Atlas()
    charts.add_mesh(inside, index.reshape(-1, 3).astype(np.uint32))
    charts.generate(xatlas.ChartOptions(), pack)
    vertex, corners, uv = charts.get_mesh(0)
    if corners.shape != faces.shape or not np.array_equal(vertex[corners], index.reshape(-1, 3)):
        raise ValueError("the charts are not those of the mesh")
    size = np.array([charts.width, charts.height], np.float64) / charts.texels_per_unit
    return _turned_back(uv.astype(np.float64) * size, corners.astype(np.int64))


def _turned_back(uv: NDArray[np.float64], corners: NDArray[np.int64]) -> NDArray[np.float64]:
    """(F, 3, 2) coordinates of corners, each chart that is mirrored reflected within the place that it takes."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    pairs = corners[:, [0, 1, 1, 2]].reshape(-1, 2)
    joined = coo_matrix((np.ones(len(pairs), np.int8), (pairs[:, 0], pairs[:, 1])), shape=(len(uv), len(uv)))
    count, chart = connected_components(joined, directed=False)
    a, b, c = (uv[corners[:, corner]] for corner in range(3))
    area = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    mirrored = np.bincount(chart[corners[:, 0]], area, count)[chart] < 0.0
    low, high = np.full(count, np.inf), np.full(count, -np.inf)
    np.minimum.at(low, chart, uv[:, 0])
    np.maximum.at(high, chart, uv[:, 0])
    u = np.where(mirrored, low[chart] + high[chart] - uv[:, 0], uv[:, 0])
    return np.stack([u, uv[:, 1]], axis=-1)[corners]
