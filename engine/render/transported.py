"""Images of baked transport, drawn on the CPU.

A pixel's triangle is found by a ray. At each of its corners the radiance towards the eye is the product of the view
maps, looked up in the frame of that corner, and the K-tuple there (`engine.transport.wavelet.transfer`), or of the
spherical harmonics of the BRDF and of the light there (`engine.transport.sh.transfer`); the pixel is their mean by
barycentric weights. At a vertex that is the vertex's own radiance, and where frames of neighbours differ, as at the one
singularity of frames without texture coordinates, nothing has to be said about what lies between. About 2 µs for each
sub-pixel and term. Of Gaussian transport the lobes are mixed across the triangle and looked up once for each sub-pixel
(`engine.transport.gaussian.transfer`); its diffuse part is the mean of the corners like the others.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.core.steps import Step, Steps
from engine.geometry.camera import Camera
from engine.geometry.mesh import Mesh
from engine.geometry.ray_caster import caster_of, meets_front
from engine.transport.relight import RelightTransport, Shade

#: Sub-pixels of a band, about 50 ms of work.
BAND = 50_000


@dataclass(frozen=True, eq=False)
class Transported:
    """`image` (height, width, 4) float32: radiance times coverage, and coverage; `negative_rel` clamped over kept."""

    image: NDArray[np.float32]
    negative_rel: float


def image_of(relit: RelightTransport, camera: Camera, size: tuple[int, int], samples: int = 2) -> Steps[Transported]:
    """The image of `size` (width, height), samples² sub-pixels each, of transport under its light."""
    return _image(relit.mesh, camera, size, samples, relit.shade(camera.eye))


def _image(mesh: Mesh, camera: Camera, size: tuple[int, int], samples: int, shade: Shade) -> Steps[Transported]:
    width, height = size
    if samples < 1 or min(size) < 1:
        raise ValueError(f"an image of {width} × {height} pixels with {samples} samples is not possible")
    caster = caster_of(mesh)
    image = np.zeros((height, width, 4), np.float32)
    kept = cut = 0.0
    band = max(1, BAND // (width * samples * samples))
    for top in range(0, height, band):
        stop = min(top + band, height)
        row, column = np.mgrid[top * samples : stop * samples, 0 : width * samples].reshape(2, -1)
        rays = camera.rays(column + 0.5, row + 0.5, width * samples, height * samples)
        hits = caster.intersect(np.broadcast_to(camera.eye, rays.shape), rays)
        seen = np.flatnonzero(hits.face >= 0)
        corners = mesh.faces[hits.face[seen]].astype(np.int64)
        value = shade(corners, hits.barycentric[seen])
        value[~meets_front(mesh.positions, corners, rays[seen])] = 0.0
        kept, cut = kept + float(np.maximum(value, 0.0).sum()), cut + float(np.maximum(-value, 0.0).sum())
        pixels = np.zeros((len(rays), 4))
        pixels[seen, :3], pixels[seen, 3] = np.maximum(value, 0.0), 1.0
        mean = pixels.reshape(stop - top, samples, width, samples, 4).mean(axis=(1, 3))
        image[top:stop] = np.minimum(mean, np.finfo(np.float32).max)
        yield Step(stop / height, "drawing on the CPU", image)
    return Transported(image, cut / kept if kept > 0.0 else 0.0)
