"""Layers beside an image, of what the centre of each pixel shows: the normal and the albedo.

Other programs denoise, mask and relight by them. The albedo is the share of the light from the direction of the camera
that the BRDF reflects to all sides, which for a reciprocal BRDF is also the share of an even light from all sides that
it sends to the camera; a shading map on top of it is not part of it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from engine.brdf.analysis import albedo
from engine.core.directions import normalize, surface_direction
from engine.core.steps import Step, Steps
from engine.geometry.ray_caster import caster_of
from engine.scene.scene import Scene

LAYERS = ("albedo", "normal")

#: Angles of the table of albedos, and samples of each: an error of some 0.5 %.
ANGLES, SAMPLES = 33, 4096

#: Rows of pixels at a time.
STRIP = 32


def layers(scene: Scene, size: tuple[int, int]) -> Steps[dict[str, NDArray[np.float32]]]:
    """'albedo' and 'normal', (height, width, 3) float32 of `size` (width, height), 0 where there is no surface.

    Normals are unit vectors of the world on the camera's side, those of the mesh between its vertices.
    """
    width, height = size
    surface, caster = scene.surface, caster_of(scene.surface)
    theta = np.linspace(0.0, 0.5 * np.pi - 1e-3, ANGLES)
    table = np.asarray(albedo(scene.brdf, surface_direction(theta, np.zeros(ANGLES)), count=SAMPLES), np.float64)
    table = np.broadcast_to(table.reshape(ANGLES, -1), (ANGLES, 3))
    found = {name: np.zeros((height, width, 3), np.float32) for name in LAYERS}
    for first in range(0, height, STRIP):
        row, column = np.mgrid[first : min(first + STRIP, height), 0:width].reshape(2, -1)
        rays = scene.camera.rays(column + 0.5, row + 0.5, width, height)
        hits = caster.intersect(np.broadcast_to(scene.camera.eye, rays.shape), rays, coherent=True)
        met = np.flatnonzero(hits.face >= 0)
        corners = surface.normals[surface.faces[hits.face[met]]]
        normal = normalize(np.einsum("nc,nci->ni", hits.barycentric[met], corners))
        cosine = -np.einsum("ni,ni->n", normal, rays[met])
        normal = np.where(cosine[:, None] < 0.0, -normal, normal)
        angle = np.arccos(np.clip(np.abs(cosine), 0.0, 1.0))
        share = np.stack([np.interp(angle, theta, table[:, channel]) for channel in range(3)], axis=1)
        if scene.ground is not None:
            share[hits.face[met] >= len(scene.mesh.faces)] = scene.ground.albedo
        found["normal"][row[met], column[met]] = normal
        found["albedo"][row[met], column[met]] = share
        yield Step(min(1.0, (first + STRIP) / height), "albedo and normals")
    return found
