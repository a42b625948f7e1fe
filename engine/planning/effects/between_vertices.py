"""Error of light that is baked at vertices and interpolated between them, in the image of a camera.

A pixel shows a place of a face. There the radiance towards the eye is worked out with the normal and the visibility of
the place itself, and once more as the mean of that of the three corners by barycentric weights, which is what drawing
with baked light does. Highlights that are narrower than a face, and shadows that end on one, make them differ. Edges of
the shadows of lamps, suns among them, lie in few pixels: lamps are looked at in many more, and by themselves. The rest
is the coarse map of `engine.planning.effects.sample`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from engine.core.directions import dot, frames_along, normalize
from engine.core.one_thread import one_thread
from engine.geometry.camera import Camera
from engine.geometry.mesh import Mesh
from engine.geometry.ray_caster import offset_origins
from engine.light.environment import DistantLights
from engine.planning.effects.radiance import radiances
from engine.planning.effects.sample import LAMP_PIXELS, Pixels, Place, Sample, above, by_camera, pixels_of, sum_lamps
from engine.transport.baking.visibility import Receivers

if TYPE_CHECKING:
    from engine.brdf.brdf import Brdf

Array = NDArray[np.float64]

#: Pixels that are looked at under the map, and parts of a texel that is partly visible, along its side.
PIXELS, PARTS = 96, 3


@dataclass(frozen=True, eq=False)
class Corners:
    """M places that pixels show, and then the three corners of the face of each.

    Attributes
    ----------
    of : the M places and the V corners that differ. chosen : (4 M,) of them. frames : (4 M, 3, 3).
    views : (4 M, 3) towards the eye, in the frames. barycentric : (M, 3).
    """

    of: Receivers
    chosen: NDArray[np.int64]
    frames: Array
    views: Array
    barycentric: Array

    def apart(self, radiance: Array) -> tuple[Array, Array]:
        """Interpolated minus exact radiance (M, 3), and the exact one, from that of all (4 M, 3)."""
        count = len(self.barycentric)
        exact, corners = radiance[:count], radiance[count:].reshape(3, count, 3)
        return np.einsum("nk,knc->nc", self.barycentric, corners) - exact, exact


@dataclass(frozen=True, eq=False)
class Between:
    """Places between the vertices: `some` under the map, whose sample is `looked`, and `many` under the lamps."""

    looked: Sample
    some: Corners
    many: Corners


def between_vertices(looked: Sample, camera: Camera, faces: int, seed: int = 2) -> Between | None:
    """Pixels of `camera`, of the scene that `looked` is a sample of, with its first `faces`; None if it sees none."""
    rng = np.random.default_rng(seed)
    pixels = pixels_of(camera, looked.of, faces, LAMP_PIXELS, rng)
    if not len(pixels.face):
        return None
    few = np.sort(rng.permutation(len(pixels.face))[:PIXELS])
    some = _corners(looked, camera, pixels.at(few))
    place = Place(looked.surface, some.of, looked.light, looked.model_vertices)
    sample = by_camera(place, some.chosen, some.frames, some.views, PARTS)
    return Between(sample, some, _corners(looked, camera, pixels))


def _corners(looked: Sample, camera: Camera, pixels: Pixels) -> Corners:
    of, surface = looked.of, looked.surface
    corners = of.caster.faces[pixels.face].astype(np.int64)
    own, origin = _at_places(surface, pixels, corners, of)
    vertices, where = np.unique(corners.T, return_inverse=True)
    count, where = len(corners), where.reshape(-1)
    among = Receivers(
        of.caster,
        np.concatenate([origin, of.origin[vertices]]),
        np.concatenate([own[:, :, 2], of.normal[vertices]]),
        np.concatenate([np.zeros(count, np.bool_), of.free[vertices]]),
    )
    frames = np.concatenate([own, frames_along(of.normal[vertices], surface.tangents[vertices])[where]])
    eye = normalize(np.asarray(camera.eye) - surface.positions[corners.T.reshape(-1)])
    towards = np.concatenate([-pixels.direction, eye])
    chosen = np.concatenate([np.arange(count), count + where])
    return Corners(among, chosen, frames, above(np.einsum("nij,ni->nj", frames, towards)), pixels.barycentric)


def _at_places(surface: Mesh, pixels: Pixels, corners: NDArray[np.int64], of: Receivers) -> tuple[Array, Array]:
    """Frames (M, 3, 3) and origins (M, 3) of the places that the pixels show, on the side of the face that is seen."""
    position, normal, tangent = (
        np.einsum("nk,nki->ni", pixels.barycentric, each[corners])
        for each in (surface.positions, surface.normals, surface.tangents)
    )
    one, other, third = (surface.positions[corners[:, k]] for k in range(3))
    flat = normalize(np.cross(other - one, third - one))
    side = np.where(dot(flat, pixels.direction) < 0.0, 1.0, -1.0)[:, None]
    return frames_along(normalize(normal), tangent), offset_origins(position, side * flat, of.caster)


def interpolation_error(between: Between, brdf: Brdf) -> float:
    """RMS of interpolated minus exact radiance over the pixels, relative to that of the exact one.

    The few pixels under the map may all miss the highlights of lamps, so that their energy is taken from the many.
    """
    with one_thread():
        found = radiances(between.looked, brdf, effects=False, methods=False)
    lamps = np.zeros_like(found.full[:, 0]) if found.lamps is None else found.lamps[:, 0]
    apart, exact = between.some.apart(found.full[:, 0] - lamps)
    squares, whole = _energy(apart), _energy(exact)
    if found.lamps is not None:
        _, lit = between.some.apart(lamps)
        apart, exact_lamps = between.many.apart(sum_lamps_between(between, brdf))
        squares += _energy(apart)
        whole += 2.0 * float((exact * lit).sum(axis=1).mean()) + _energy(exact_lamps)
    return float(np.sqrt(squares / whole)) if whole > 0.0 else 0.0


def _energy(radiance: Array) -> float:
    """The mean over pixels of the squares of (M, 3) radiance, summed over channels."""
    return float((radiance**2).sum(axis=1).mean())


def sum_lamps_between(between: Between, brdf: Brdf) -> Array:
    """(4 M, 3) radiance of the lamps alone."""
    looked, at = between.looked, between.many
    lights = DistantLights(looked.lamp_direction, looked.lamp_irradiance)
    return sum_lamps(at.of, at.chosen, at.frames, at.views, lights, brdf)
