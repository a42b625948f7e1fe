"""Images of what is known at vertices: what each pixel sees is found once for all images from one camera.

As in `engine.render.transported`, which finds it anew for each image: a pixel is the mean by barycentric weights of
what the corners of its triangle send to the eye, black where a triangle is seen from behind, and not below 0.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.core.directions import Vectors, normalize
from engine.geometry.camera import Camera
from engine.geometry.mesh import Mesh
from engine.geometry.ray_caster import caster_of, meets_front
from engine.transport.wavelet.transfer import GRAZING

#: Sub-pixels along a side of a pixel.
SAMPLES = 2


@dataclass(frozen=True, eq=False)
class View:
    """Surface seen by sub-pixels: `seen` (n,) of them a face, with its `corners` (n, 3) and their `weights` (n, 3)."""

    mesh: Mesh
    camera: Camera
    size: tuple[int, int]
    seen: NDArray[np.int64]
    corners: NDArray[np.int64]
    weights: NDArray[np.float64]

    def local(self, frames: Vectors) -> Vectors:
        """(V, 3) directions to the eye in the `frames` (V, 3, 3) of the vertices, a little above the horizon at least.

        A vertex of a face that is seen may be turned away itself.
        """
        towards = normalize(np.asarray(self.camera.eye) - self.mesh.positions)
        local = np.einsum("vij,vi->vj", frames, towards)
        local[:, 2] = np.maximum(local[:, 2], GRAZING)
        return normalize(local)

    def image(self, values: NDArray[np.floating]) -> NDArray[np.float32]:
        """(height, width, 4) from radiance (V, 3) of the vertices towards the eye, which may be negative."""
        width, height = self.size
        pixels = np.zeros((height * width * SAMPLES**2, 4))
        pixels[self.seen, :3] = np.maximum(np.einsum("nk,nkc->nc", self.weights, values[self.corners]), 0.0)
        pixels[self.seen, 3] = 1.0
        shaped = pixels.reshape(height, SAMPLES, width, SAMPLES, 4)
        return shaped.mean(axis=(1, 3)).astype(np.float32)


def view_of(mesh: Mesh, camera: Camera, size: tuple[int, int]) -> View:
    """Part of `mesh` that `camera` sees in an image of `size` (width, height)."""
    width, height = size
    row, column = np.mgrid[0 : height * SAMPLES, 0 : width * SAMPLES].reshape(2, -1)
    rays = camera.rays(column + 0.5, row + 0.5, width * SAMPLES, height * SAMPLES)
    hits = caster_of(mesh).intersect(np.broadcast_to(camera.eye, rays.shape), rays)
    seen = np.flatnonzero(hits.face >= 0)
    corners = mesh.faces[hits.face[seen]].astype(np.int64)
    front = meets_front(mesh.positions, corners, rays[seen])
    return View(mesh, camera, size, seen, corners, hits.barycentric[seen] * front[:, None])
