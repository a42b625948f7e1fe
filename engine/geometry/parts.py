"""Parts of a model with materials of their own (`Mesh.part`), of which each vertex belongs to one.

What is baked at vertices changes at the seam between two materials from one triangle to the next, so the vertices on a
seam are there once for each part. Positions, normals and texture coordinates are those of the model.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from engine.geometry.mesh import Mesh


@lru_cache(maxsize=2)
def split_parts(mesh: Mesh) -> Mesh:
    """`mesh` with a copy of each vertex for each part that meets there; the mesh itself where none is shared.

    The last two are remembered, so that bakes of one model share what is made for its surface.
    """
    if mesh.part is None:
        return mesh
    corners = mesh.faces.reshape(-1).astype(np.int64)
    own = corners * len(mesh.part_names) + np.repeat(mesh.part, 3)
    used, place = np.unique(own, return_inverse=True)
    source = used // len(mesh.part_names)
    if len(np.unique(source)) == len(source):
        return mesh
    return replace(
        mesh,
        positions=mesh.positions[source],
        normals=mesh.normals[source],
        uv=mesh.uv[source],
        faces=place.reshape(-1, 3).astype(np.int32),
        colours=None if mesh.colours is None else mesh.colours[source],
    )


def parts_of_vertices(mesh: Mesh) -> NDArray[np.int32]:
    """(V,) the part of each vertex, 0 where no face has it; ValueError where a vertex has faces of two parts."""
    if mesh.part is None:
        raise ValueError("the mesh has no parts")
    found = np.zeros(len(mesh.positions), np.int32)
    found[mesh.faces] = mesh.part[:, None]
    if (found[mesh.faces] != mesh.part[:, None]).any():
        raise ValueError("a vertex has faces of two parts")
    return found
