"""The vertices that pictures of a scene need: those of the faces that its camera sees, and of the faces around them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from engine.ray_caster import caster_of
from engine.scene import Scene


def shown_vertices(scene: Scene, size: tuple[int, int], samples: int) -> NDArray[np.int64]:
    """Vertices of model and ground, rising, for pictures of `size` (width, height), `samples` along a side of a pixel.

    Faces around those that are seen belong to them: drawn on a grid or by rays, an edge may fall on either side.
    """
    surface = scene.surface
    width, height = size[0] * samples, size[1] * samples
    column, row = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    directions = scene.camera.rays(column, row, width, height).reshape(-1, 3)
    hits = caster_of(surface).intersect(np.broadcast_to(scene.camera.eye, directions.shape), directions)
    needed = np.zeros(len(surface.positions), np.bool_)
    needed[surface.faces[np.unique(hits.face[hits.face >= 0])]] = True
    needed[surface.faces[needed[surface.faces].any(axis=1)]] = True
    return np.flatnonzero(needed)
