"""The error of leaving an effect out, by brute force: other points, other views, and rays cast one by one.

Nothing of `engine.planning` is used: points come from random places on triangles weighted by area, taken to their
nearest corner; views are random over the sphere and weighted by n · wo; light is summed over all texels of a cube map.

Models and skies are made once: the program remembers what it found of the same object.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, lru_cache
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from engine.brdf.brdf import Brdf
from engine.core.directions import normalize
from engine.core.steps import drain
from engine.geometry.camera import Camera
from engine.geometry.mesh import Mesh
from engine.geometry.ray_caster import caster_of, offset_origins
from engine.light.cube_map import cube_directions, cube_of, cube_solid_angles
from engine.light.environment import EnvironmentMap, texel_directions
from engine.light.sun_split import split_sun
from engine.render.reference import reference
from engine.scene.scene import Scene
from engine.transport.sh.transfer import tangent_frames

Array = NDArray[np.float64]
Value = Callable[[Array, Array], Array]

#: Texels along an edge of the cube map, points, and views of each.
EDGE, POINTS, VIEWS = 24, 240, 8


@dataclass(frozen=True, eq=False)
class BruteForce:
    """Points of a scene with views, and what each texel and each sun sends there."""

    vertices: NDArray[np.int64]
    frames: Array
    views: Array
    weight: Array
    seen: NDArray[np.bool_]
    direction: Array
    incident: Array
    visible: NDArray[np.bool_]

    def radiance(self, f: Value | Sequence[Value], *, shadows: bool = True) -> Array:
        """(N, K, 3) of the BRDF `f`, or of one for each point, with or without shadows."""
        result = np.zeros((*self.views.shape[:2], 3))
        for point, frame in enumerate(self.frames):
            wi = self.direction @ frame
            up = wi[:, 2] > 0.0
            if shadows:
                up &= self.visible[point]
            light = self.incident[up] * wi[up, 2:]
            local = self.views[point] @ frame
            for view in np.flatnonzero(self.weight[point] > 0.0):
                value = f(wi[up], local[view]) if callable(f) else f[point](wi[up], local[view])
                result[point, view] = (value * light).sum(axis=0)
        return result

    def error(self, values: Array, wanted: Array) -> tuple[float, float]:
        """Relative root mean square over all pairs, and over those that the surface does not hide."""
        apart, whole = ((values - wanted) ** 2).sum(axis=-1), (wanted**2).sum(axis=-1)
        pairs = (self.weight, self.weight * self.seen)
        return tuple(float(np.sqrt((apart * w).sum() / (whole * w).sum())) for w in pairs)  # type: ignore[return-value]


@lru_cache(maxsize=4)
def brute_force(mesh: Mesh, environment: EnvironmentMap, seed: int = 7) -> BruteForce:
    rng = np.random.default_rng(seed)
    a, b, c = (mesh.positions[mesh.faces[:, corner]] for corner in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    face = rng.choice(len(area), POINTS, p=area / area.sum())
    vertices = mesh.faces[face, rng.integers(3, size=POINTS)]
    frames = tangent_frames(mesh)[vertices]
    views = normalize(rng.normal(size=(POINTS, VIEWS, 3)))
    weight = np.maximum(np.einsum("nki,ni->nk", views, frames[:, :, 2]), 0.0)
    caster = caster_of(mesh)
    origin = offset_origins(mesh.positions[vertices], frames[:, :, 2], caster)
    rest, suns = split_sun(environment)
    direction = np.concatenate([cube_directions(EDGE).reshape(-1, 3), *([sun.direction] for sun in suns)])
    area = np.tile(cube_solid_angles(EDGE).reshape(-1), 6)[:, None]
    incident = np.concatenate([cube_of(rest, EDGE).radiance.reshape(-1, 3) * area, *([sun.irradiance] for sun in suns)])
    visible = np.stack([~caster.occluded(np.broadcast_to(p, direction.shape), direction) for p in origin])
    blocked = caster.occluded(np.repeat(origin, VIEWS, axis=0), views.reshape(-1, 3)).reshape(POINTS, VIEWS)
    return BruteForce(cast(Any, vertices), frames, views, weight, ~blocked, direction, incident, visible)


def compute_bounced_share(
    mesh: Mesh, brdf: Brdf, environment: EnvironmentMap, side: int = 28, samples: int = 24
) -> float:
    """The interreflected share of all light, by the reference renderer, over pixels from four sides."""
    part = whole = 0.0
    for number, towards in enumerate(((1, 1, 1), (-1, -1, 1), (-1, 1, -1))):
        eye = tuple(np.asarray(mesh.centre) + 3.2 * mesh.radius * normalize(np.array(towards, float)))
        scene = Scene(mesh, Camera(eye, tuple(mesh.centre)), brdf, environment=environment)

        def image(depth: int, seed: int, scene: Scene = scene) -> Any:
            return drain(reference(scene, (side, side), samples=samples, max_depth=depth, seed=seed)).image

        full = [image(5, 10 * number + seed) for seed in (1, 2)]
        direct = [image(1, 10 * number + seed) for seed in (3, 4)]
        inside = np.minimum.reduce([each[..., 3] for each in (*full, *direct)]) > 0.99
        one, other = ((f[..., :3] - d[..., :3])[inside].astype(float) for f, d in zip(full, direct, strict=True))
        part += float((one * other).sum())
        whole += float((full[0][..., :3] * full[1][..., :3])[inside].sum())
    return float(np.sqrt(max(part, 0.0) / whole))


@cache
def gradient_sky(slope: float = 0.6) -> EnvironmentMap:
    """Radiance 1 + slope · y: nothing above the band l = 1."""
    y = texel_directions(32, 64)[..., 1:2]
    return EnvironmentMap((1.0 + slope * y * np.ones(3)).astype(np.float32), "gradient")


@cache
def lamp_sky(radius: float = 0.3, level: float = 40.0) -> EnvironmentMap:
    """A round softbox high on one side of a dim room."""
    towards = texel_directions(64, 128)
    inside = towards @ normalize(np.array([0.6, 0.7, 0.4])) > np.cos(radius)
    return EnvironmentMap(np.where(inside[..., None], level, 0.2).astype(np.float32) * np.ones(3, np.float32), "lamp")


@cache
def sunny_sky(sun: float) -> EnvironmentMap:
    """A gradient with one texel as bright as `sun`."""
    radiance = gradient_sky().radiance.copy()
    radiance[8, 20] = sun
    return EnvironmentMap(radiance, "sunny")


@cache
def bowl(depth: float = 0.5, rows: int = 14) -> Mesh:
    """The inside and the outside of a cap of a sphere, whose rim is at the share `depth` of the polar angle."""
    theta = np.pi * depth * (np.arange(rows) + 0.5) / rows
    phi = 2.0 * np.pi * np.arange(2 * rows) / (2 * rows)
    t, p = np.meshgrid(theta, phi, indexing="ij")
    points = np.stack([np.sin(t) * np.cos(p), -np.cos(t), np.sin(t) * np.sin(p)], axis=-1).reshape(-1, 3)
    index = np.arange(len(points)).reshape(rows, -1)
    right = np.roll(index, -1, axis=1)
    one = np.stack([index[:-1], right[:-1], right[1:]], axis=-1).reshape(-1, 3)
    two = np.stack([index[:-1], right[1:], index[1:]], axis=-1).reshape(-1, 3)
    faces = np.concatenate([one, two])[:, ::-1]
    a, b, c = (points[faces[:, corner]] for corner in range(3))
    if float(np.einsum("fi,fi->", np.cross(b - a, c - a), a)) > 0.0:
        faces = faces[:, ::-1]
    both = np.concatenate([points, 1.03 * points])
    normals = np.concatenate([-points, points]).astype(np.float32)
    whole = np.concatenate([faces, faces[:, ::-1] + len(points)]).astype(np.int32)
    return Mesh(both, normals, np.zeros((len(both), 2), np.float32), np.ascontiguousarray(whole), "bowl")


@cache
def sphere(rows: int = 16) -> Mesh:
    """A closed convex sphere."""
    theta, phi = np.meshgrid(np.pi * np.arange(1, rows) / rows, np.pi * np.arange(2 * rows) / rows, indexing="ij")
    ring = np.stack([np.sin(theta) * np.sin(phi), np.cos(theta), np.sin(theta) * np.cos(phi)], axis=-1).reshape(-1, 3)
    points = np.concatenate([ring, [[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]]])
    index = np.arange(len(ring)).reshape(rows - 1, 2 * rows)
    right, poles = np.roll(index, -1, axis=1), np.full(2 * rows, len(ring))
    quads = (index[:-1], index[1:], right[1:]), (index[:-1], right[1:], right[:-1])
    faces = [np.stack(each, -1).reshape(-1, 3) for each in quads]
    caps = [np.stack([poles, index[0], right[0]], -1), np.stack([poles + 1, right[-1], index[-1]], -1)]
    uv = np.zeros((len(points), 2), np.float32)
    return Mesh(points, points.astype(np.float32), uv, np.concatenate([*faces, *caps]).astype(np.int32), "ball")


@cache
def spheres(apart: float) -> Mesh:
    """Two of them, so far apart between their middles."""
    one = sphere()
    points = np.concatenate([one.positions, one.positions + np.array([apart, 0.0, 0.0])])
    faces = np.concatenate([one.faces, one.faces + np.int32(len(one.positions))])
    return Mesh(points, np.concatenate([one.normals] * 2), np.concatenate([one.uv] * 2), faces, "balls")


@cache
def spots(count: int = 24, radius: float = 0.03, level: float = 1500.0) -> EnvironmentMap:
    """Small lamps all around in a dim room, none of which is a sun beside the others."""
    towards = texel_directions(128, 256)
    lit = np.zeros(towards.shape[:2], np.bool_)
    for lamp in normalize(np.random.default_rng(5).standard_normal((count, 3))):
        lit |= towards @ lamp > np.cos(radius)
    return EnvironmentMap(np.where(lit[..., None], level, 0.2).astype(np.float32) * np.ones(3, np.float32), "spots")


@cache
def even_sphere(count: int = 800) -> Mesh:
    """A sphere whose vertices stand for equal areas."""
    towards = _spiral(count)
    return _around(towards, towards)


@cache
def dent(count: int = 1200) -> Mesh:
    """A ball with deep dents, whose vertices stand for nearly equal areas."""
    towards = _spiral(10_000)
    fine = _around(_dents(towards), towards)
    a, b, c = (fine.positions[fine.faces[:, corner]] for corner in range(3))
    area = np.bincount(fine.faces.ravel(), np.repeat(np.linalg.norm(np.cross(b - a, c - a), axis=1), 3))
    reached = np.cumsum(area) / area.sum()
    towards = towards[np.unique(np.searchsorted(reached, (np.arange(count) + 0.5) / count))]
    return _around(_dents(towards), towards)


def _dents(towards: Array) -> Array:
    x, y, z = np.moveaxis(towards, -1, 0)
    return np.asarray(towards * (1.0 + 0.35 * np.cos(5.0 * x) * np.cos(4.0 * y + 1.0) * np.cos(4.0 * z))[:, None])


def _spiral(count: int) -> Array:
    """(count, 3) directions, each for the same solid angle."""
    index = np.arange(count) + 0.5
    height, turn = 1.0 - 2.0 * index / count, np.pi * (1.0 + 5.0**0.5) * index
    across = np.sqrt(1.0 - height**2)
    return np.stack([across * np.cos(turn), height, across * np.sin(turn)], axis=-1)


def _around(points: Array, towards: Array) -> Mesh:
    """The mesh of `points` (V, 3) around the origin, each of which is alone in its direction."""
    faces = ConvexHull(towards).simplices
    a, b, c = (points[faces[:, corner]] for corner in range(3))
    across = np.cross(b - a, c - a)
    inward = np.einsum("fi,fi->f", across, towards[faces[:, 0]]) < 0.0
    faces[inward], across[inward] = faces[inward][:, ::-1], -across[inward]
    normals = np.zeros_like(points)
    for corner in range(3):
        np.add.at(normals, faces[:, corner], across)
    uv = np.zeros((len(points), 2), np.float32)
    return Mesh(points.copy(), normalize(normals).astype(np.float32), uv, faces.astype(np.int32), "around")
