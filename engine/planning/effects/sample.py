"""Some points of a scene and what they see: enough to tell within a second what each effect adds to its images.

Vertices are drawn by the area around them, evenly along the list of vertices, which neighbours share; views of each
evenly over its hemisphere, and a pair weighs as its cosine: pairs at grazing angles, where highlights are brightest,
are few in images, but make much of their errors. A mean over such pairs is a mean over pixels of images from all
around, save that parts of the model hide others: pairs whose view is blocked are marked in `seen`. Where a camera is
given the pairs are pixels of its image: a corner of the face that each shows, and the way from there to the eye.
Light is a cube map of the environment without its suns, which are lamps; visibility is asked once for each texel.
Effects are estimated from many pairs under a coarse map, because few pairs make most of a highlight; the errors of
methods from fewer under a finer one.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import product
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from engine.core.cached import cached_property
from engine.core.colour import luminance
from engine.core.directions import Vectors, dot, normalize
from engine.geometry.camera import Camera
from engine.geometry.ground import Ground, with_ground
from engine.geometry.mesh import Mesh
from engine.light.cube_map import CubeMap, cube_of, face_coordinates
from engine.light.environment import DistantLights, EnvironmentMap
from engine.light.lamps import Lamp, lights_of_all
from engine.light.sun_split import split_sun
from engine.transport.baking.visibility import Receivers, receivers, visibility_shares
from engine.transport.sh.transfer import tangent_frames
from engine.transport.wavelet.lighting import rotate
from engine.transport.wavelet.transfer import GRAZING, Texels, cube_texels

if TYPE_CHECKING:
    from engine.brdf.brdf import Brdf

Array = NDArray[np.float64]

#: Points, views of each, and texels along an edge of the light's cube map: for effects, and for methods.
POINTS, VIEWS, EDGE = 192, 8, 16
FINE = (128, 4, 32)

#: Pixels along a side of the image by which a camera looks at the model, and pairs from all around for each of its.
SIDE, SHARE = 96, 2

#: Pixels that are looked at under lamps alone.
LAMP_PIXELS = 2048

#: Share of the light that is brought by few sharp lights where others do not count.
FEW_SHARP = 0.9

#: Pixels along a side of the images whose silhouettes are left out.
COMPARED = 128


@dataclass(frozen=True, eq=False)
class Light:
    """A distant light: `rest` without its suns, which are among `lamps`, and the `whole` map as it came."""

    rest: EnvironmentMap
    whole: EnvironmentMap
    lamps: tuple[Lamp, ...]
    suns: int
    cube: CubeMap
    whole_cube: CubeMap

    @property
    def is_sharp(self) -> bool:
        """True if lamps, suns among them, bring `FEW_SHARP` of the light: what lights it are few sharp lights."""
        texels = cube_texels(self.cube.edge)
        rest = float(luminance(self.cube.radiance.reshape(-1, 3)) @ texels.area)
        sharp = sum(float(luminance(np.array(lamp.flux))) for lamp in self.lamps)
        return sharp > 0.0 and sharp >= FEW_SHARP * (sharp + rest)


@lru_cache(maxsize=4)
def light_of(
    environment: EnvironmentMap, rotation: float = 0.0, lamps: tuple[Lamp, ...] = (), edge: int = EDGE
) -> Light:
    """The light of `environment`, rotated about +Y by `rotation` rad, with `lamps` of the scene beside it."""
    rest, suns = split_sun(environment)
    rest, whole = rotate(rest, rotation), rotate(environment, rotation)
    cube = cube_of(rest, edge)
    moved = tuple(sun.rotate(rotation) for sun in suns)
    return Light(rest, whole, (*moved, *lamps), len(suns), cube, cube_of(whole, edge) if suns else cube)


@dataclass(frozen=True, eq=False)
class Sample:
    """N points with K views each.

    Attributes
    ----------
    surface : the model, with its ground where it has one. of : all its vertices as receivers of light.
    vertices : (N,) of the model.
    frames : (N, 3, 3) with columns tangent, bitangent, normal.
    views : (N, K, 3) in the frame of the point. weight : (N, K) share that a pair has of an image.
    seen : (N, K) whether no part of the surface blocks the view.
    visible : (N, 6 edge²) bool, or the visible shares of texels.
    mirrored : the same below the horizon, as a mirror at the tangent plane shows it.
    lamp_direction : (S, 3) world. lamp_irradiance : (S, 3). lamp_lit : (N, S) bool.
    unoccluded_fraction : of the model's vertices, those that see their whole hemisphere.
    by_camera : whether the views are those of one camera, and not from all around.
    """

    surface: Mesh
    of: Receivers
    vertices: NDArray[np.int64]
    frames: Array
    views: Array
    weight: Array
    seen: NDArray[np.bool_]
    visible: NDArray[Any]
    mirrored: NDArray[Any]
    light: Light
    lamp_direction: Array
    lamp_irradiance: Array
    lamp_lit: NDArray[np.bool_]
    unoccluded_fraction: float
    model_vertices: int
    by_camera: bool

    @property
    def edge(self) -> int:
        return self.light.cube.edge

    @cached_property
    def texels(self) -> Texels:
        return cube_texels(self.edge)

    @property
    def shares(self) -> tuple[Array, Array]:
        """(N, K) what each pair counts for, without and with those whose view is blocked."""
        return self.weight, self.weight * self.seen

    @property
    def incident(self) -> Array:
        """(6 edge², 3) radiance times solid angle."""
        return np.asarray(self.light.cube.radiance.reshape(-1, 3) * self.texels.area[:, None])

    @property
    def open_share(self) -> float:
        """Open share of the cosine-weighted hemisphere, on average over the points."""
        cosine = np.maximum(self.frames[:, :, 2] @ self.texels.direction.T, 0.0) * self.texels.area
        return float((cosine * self.visible).sum() / cosine.sum())


def sample(
    mesh: Mesh,
    environment: EnvironmentMap,
    *,
    rotation: float = 0.0,
    lamps: Sequence[Lamp] = (),
    ground: Ground | None = None,
    points: int = POINTS,
    views: int = VIEWS,
    edge: int = EDGE,
    seed: int = 0,
    camera: Camera | None = None,
    brdf: Brdf | None = None,
) -> Sample:
    """Draw the points of `mesh` and look around from each; the same call draws the same.

    With a camera points are those of its pixels, each with one view, and there are half as many pairs; where the camera
    sees none of the model, it is looked at from all around. With a `brdf` more of the pixels are where it reflects the
    lamps, and count for less: highlights of a sun lie in few pixels and make most of an error.
    """
    of, frames, areas = _prepare(mesh, ground)
    rng = np.random.default_rng(seed)
    most = points * views // SHARE
    asked = most if brdf is None else LAMP_PIXELS
    pixels = None if camera is None else pixels_of(camera, of, len(mesh.faces), asked, rng)
    light = light_of(environment, rotation, tuple(lamps), edge)
    scene = Place(sample_surface(mesh, ground), of, light, len(mesh.positions))
    if pixels is not None and len(pixels.face):
        corner = (np.cumsum(pixels.barycentric, axis=1) < rng.random((len(pixels.face), 1))).sum(axis=1).clip(max=2)
        chosen = of.caster.faces[pixels.face, corner].astype(np.int64)
        local = above(np.einsum("nij,ni->nj", frames[chosen], -pixels.direction))
        if len(chosen) <= most:
            return by_camera(scene, chosen, frames[chosen], local)
        assert brdf is not None, "without a BRDF no more pixels are looked for than are kept"
        lit = sum_lamps(of, chosen, frames[chosen], local, lights_of_all(light.lamps), brdf)
        rows, weight = by_worth(np.abs(lit).sum(axis=1), most, rng)
        return by_camera(scene, chosen[rows], frames[chosen[rows]], local[rows], weight=weight)
    chosen = _draw(areas, points, rng)
    own = frames[chosen]
    local = _all_around(len(chosen), views, rng)
    world = np.einsum("nij,nkj->nki", own, local).reshape(-1, 3)
    blocked = of.caster.occluded(np.repeat(of.origin[chosen], views, axis=0), world).reshape(-1, views)
    return _look(scene, chosen, own, local, local[..., 2], ~blocked, False)


@dataclass(frozen=True, eq=False)
class Place:
    """A surface, its vertices as receivers, of which the first are the model's, and the light on it."""

    surface: Mesh
    of: Receivers
    light: Light
    model_vertices: int


def by_camera(
    scene: Place, chosen: NDArray[np.int64], frames: Array, local: Array, fine: int = 1, weight: Array | None = None
) -> Sample:
    """The sample of one view (N, 3) of each of the receivers `chosen`, all of them pixels of an image.

    Texels that are partly visible are cut into `fine`² parts. Pixels count for their `weight` (N,), else alike.
    """
    seen = np.ones((len(chosen), 1), np.bool_)
    shares = seen.astype(np.float64) if weight is None else weight[:, None]
    return _look(scene, chosen, frames, local[:, None], shares, seen, True, fine)


def sum_lamps(
    of: Receivers, chosen: NDArray[np.int64], frames: Array, views: Array, lights: DistantLights, brdf: Brdf
) -> Array:
    """(N, 3) radiance of `lights` alone at the receivers `chosen`, with `frames` and one of `views` (N, 3) each."""
    total = np.zeros((len(chosen), 3))
    for direction, irradiance in zip(lights.direction, lights.irradiance, strict=True):
        local = np.einsum("nij,i->nj", frames, direction)
        facing = np.flatnonzero(local[:, 2] > 0.0)
        origin = of.origin[chosen[facing]]
        lit = facing[~of.caster.occluded(origin, np.broadcast_to(direction, origin.shape))]
        total[lit] += brdf.f(local[lit], views[lit]) * (irradiance * local[lit, 2:])
    return total


def by_worth(worth: Array, most: int, rng: np.random.Generator) -> tuple[NDArray[np.int64], Array]:
    """`most` rows, half of them as often as their `worth` (N,) and half evenly, and what each counts for."""
    chance = np.full(len(worth), 1.0 / len(worth))
    if worth.sum() > 0.0:
        chance = 0.5 * (chance + worth / worth.sum())
    at = (np.arange(most) + rng.random(most)) / most * chance.sum()
    rows = np.minimum(np.searchsorted(np.cumsum(chance), at, side="right"), len(worth) - 1)
    return rows, 1.0 / (len(worth) * chance[rows])


def _look(
    scene: Place,
    chosen: NDArray[np.int64],
    own: Array,
    local: Array,
    weight: Array,
    seen: NDArray[np.bool_],
    has_camera: bool,
    fine: int = 1,
) -> Sample:
    """The sample of views `local` (N, K, 3) of the receivers `chosen`: what they see of the light."""
    of, light = scene.of, scene.light
    edge, origin = light.cube.edge, of.origin[chosen]
    counts = np.concatenate([each for _, each in visibility_shares(of, edge, fine, chosen)])
    visible = counts > 0 if fine == 1 else counts / fine**2
    directional = lights_of_all(light.lamps)
    lit = np.ones((len(chosen), len(directional.direction)), np.bool_)
    for number, direction in enumerate(directional.direction):
        facing = own[:, :, 2] @ direction > 0.0
        lit[:, number] = facing & ~of.caster.occluded(origin, np.broadcast_to(direction, origin.shape))
    return Sample(
        scene.surface,
        of,
        chosen,
        own,
        local,
        weight,
        seen,
        visible,
        _mirror(visible, own, edge),
        light,
        directional.direction,
        directional.irradiance,
        lit,
        float(np.mean(of.free[: scene.model_vertices])),
        scene.model_vertices,
        has_camera,
    )


def sample_surface(mesh: Mesh, ground: Ground | None) -> Mesh:
    return mesh if ground is None else with_ground(mesh, ground)[0]


@lru_cache(maxsize=2)
def _prepare(mesh: Mesh, ground: Ground | None) -> tuple[Receivers, Vectors, Array]:
    """Receivers, frames, and the area around each vertex of the model; remembered, because plans are made often."""
    surface = sample_surface(mesh, ground)
    a, b, c = (mesh.positions[mesh.faces[:, corner]] for corner in range(3))
    across = np.cross(b - a, c - a)
    face = np.sqrt(dot(across, across))
    areas = np.bincount(mesh.faces.ravel(), np.repeat(face, 3), len(mesh.positions)).astype(np.float64)
    return receivers(surface), tangent_frames(surface), areas


def _draw(areas: Array, points: int, rng: np.random.Generator) -> NDArray[np.int64]:
    """(points,) vertices, as often as their share of the area, evenly along the list."""
    total = np.cumsum(areas / areas.max()) if areas.max(initial=0.0) > 0.0 else np.arange(1.0, len(areas) + 1)
    at = (np.arange(points) + rng.random(points)) / points * total[-1]
    return np.minimum(np.searchsorted(total, at, side="right"), len(areas) - 1).astype(np.int64)


def _all_around(count: int, views: int, rng: np.random.Generator) -> Array:
    """(count, views, 3) directions, evenly over the hemisphere about +z."""
    u, turn = rng.random((2, count, views))
    cosine, phi = np.maximum((np.arange(views) + u) / views, 1e-3), 2.0 * math.pi * turn
    radius = np.sqrt(1.0 - cosine**2)
    return normalize(np.stack([radius * np.cos(phi), radius * np.sin(phi), cosine], axis=-1))


def above(directions: Array) -> Array:
    """(N, 3) unit directions above the horizon, as images are drawn; some smooth normals look away from the eye."""
    return normalize(np.concatenate([directions[:, :2], np.maximum(directions[:, 2:], GRAZING)], axis=1))


class Pixels(NamedTuple):
    """M places of the model that an image shows: the face (M,), `barycentric` and the `direction` of view (M, 3)."""

    face: NDArray[np.int32]
    barycentric: Array
    direction: Vectors

    def at(self, rows: NDArray[np.int64]) -> Pixels:
        return Pixels(self.face[rows], self.barycentric[rows], self.direction[rows])


def pixels_of(camera: Camera, of: Receivers, faces: int, most: int, rng: np.random.Generator) -> Pixels:
    """Up to `most` pixels of an image that the first `faces`, the model's, cover, evenly over it.

    Silhouettes are left out, as where images are compared: what a grazing eye sees there is far brighter and darker
    than what lies beside it, and is not seen by itself. A model that covers no pixel keeps all that show it.
    """
    row, column = np.mgrid[0:SIDE, 0:SIDE].reshape(2, -1) + rng.random((2, SIDE**2))
    direction = camera.rays(column, row, SIDE, SIDE)
    hits = of.caster.intersect(np.broadcast_to(np.asarray(camera.eye), direction.shape), direction)
    shown = (hits.face >= 0) & (hits.face < faces)
    covered = shown & _measure_coverage(camera, of, faces, row, column)
    met = np.flatnonzero(covered if covered.any() else shown)
    if len(met) > most:
        met = met[((np.arange(most) + rng.random(most)) / most * len(met)).astype(np.int64)]
    return Pixels(hits.face[met], hits.barycentric[met], direction[met])


def _measure_coverage(camera: Camera, of: Receivers, faces: int, row: Array, column: Array) -> NDArray[np.bool_]:
    """True where the model is also met at the corners of pixels of an image of `COMPARED`² round the places."""
    covered, half = np.ones(len(row), np.bool_), 0.5 * SIDE / COMPARED
    for down, right in product((-half, half), repeat=2):
        direction = camera.rays(column + right, row + down, SIDE, SIDE)
        hits = of.caster.intersect(np.broadcast_to(np.asarray(camera.eye), direction.shape), direction)
        covered &= (hits.face >= 0) & (hits.face < faces)
    return covered


def _mirror(visible: NDArray[Any], frames: Array, edge: int) -> NDArray[Any]:
    """`visible` with the texels below each horizon as their mirror images above it are."""
    direction = cube_texels(edge).direction
    result = visible.copy()
    for number, normal in enumerate(frames[:, :, 2]):
        height = direction @ normal
        below = np.flatnonzero(height <= 0.0)
        face, s, t = face_coordinates(direction[below] - 2.0 * height[below, None] * normal)
        row, column = (np.minimum((place * edge).astype(np.int64), edge - 1) for place in (t, s))
        result[number, below] = visible[number, (face * edge + row) * edge + column]
    return result
