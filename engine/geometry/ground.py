"""A ground for a model to stand on: a level square of triangles below it, with a diffuse albedo of its own.

The ground is part of the surface that rays meet and that transport is found for, so that the model shades it and
light comes back from it. +Y is up. Its texture has the density of made texture coordinates: one unit over the longest
side of the model's bounding box.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from math import isfinite

import numpy as np
from numpy.typing import NDArray

from engine.core.errors import UsageError
from engine.geometry.mesh import Mesh

#: Distance, in bounding radii, that a ground without a stated height keeps from the lowest point: a flat underside
#: and the ground would otherwise be one plane, on which every ray is a doubtful case.
GAP = 1e-3

#: Most cells along a side; 2 million triangles.
MAX_CELLS = 1024


@dataclass(frozen=True)
class Ground:
    """A level square under a model.

    Attributes
    ----------
    height : world y; None for just under the lowest point of the model.
    albedo : of the Lambertian surface, 0 … 1.
    extent : half the side, in radii of the model's bounding sphere.
    cells : squares along a side, each of two triangles; what is kept per vertex is as fine as these.
    """

    height: float | None = None
    albedo: float = 0.5
    extent: float = 4.0
    cells: int = 64

    def __post_init__(self) -> None:
        if self.height is not None and not isfinite(self.height):
            raise UsageError(f"a ground at the height {self.height} is not possible")
        if not (0.0 <= self.albedo <= 1.0 and 0.0 < self.extent < float("inf") and 1 <= self.cells <= MAX_CELLS):
            raise UsageError(
                f"a ground of albedo {self.albedo} (0 … 1), extent {self.extent} (above 0) and {self.cells} cells "
                f"(1 … {MAX_CELLS}) is not possible"
            )


@lru_cache(maxsize=2)
def with_ground(mesh: Mesh, ground: Ground) -> tuple[Mesh, int]:
    """`mesh` and after it the vertices and triangles of `ground`, and the index of the first triangle of the ground.

    The name and health of the model are kept, and its tangents, too. The last two are remembered, so that images of
    one model share what is made for its surface.
    """
    across = np.linspace(-1.0, 1.0, ground.cells + 1) * ground.extent * mesh.radius
    x, z = np.meshgrid(across, -across)
    offset = np.stack([x, np.zeros_like(x), z], axis=-1).reshape(-1, 3)
    positions = offset + mesh.centre
    positions[:, 1] = _height(mesh, ground)
    normals = np.broadcast_to(np.array([0.0, 1.0, 0.0], np.float32), positions.shape)
    uv = np.stack([x, -z], axis=-1).reshape(-1, 2) / np.max(np.ptp(mesh.positions, axis=0))
    faces = np.concatenate([mesh.faces, _squares(ground.cells) + len(mesh.positions)]).astype(np.int32)
    both = Mesh(
        np.concatenate([mesh.positions, positions]),
        np.concatenate([mesh.normals, normals]),
        np.concatenate([mesh.uv, uv.astype(np.float32)]),
        faces,
        mesh.name,
        mesh.health,
        mesh.brushing,
    )
    return both, len(mesh.faces)


def _height(mesh: Mesh, ground: Ground) -> float:
    if ground.height is not None:
        return ground.height
    return float(mesh.positions[:, 1].min() - GAP * mesh.radius)


def _squares(cells: int) -> NDArray[np.int64]:
    """(2 cells², 3) triangles of a grid whose rows run along −Z and columns along +X, seen from above."""
    index = np.arange((cells + 1) ** 2).reshape(cells + 1, cells + 1)
    a, b, c, d = index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]
    return np.stack([np.stack([a, b, c], -1), np.stack([a, c, d], -1)], axis=2).reshape(-1, 3)
