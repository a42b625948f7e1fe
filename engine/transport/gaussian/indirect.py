"""Light that reaches a glossy vertex by way of the model itself, as transport from the distant light.

Green2006 Sec. 4.1: paths start where the BRDF of the vertex sends them, go on
from what they meet, drawn from the whole BRDF there, until they leave the model; the direction in which they do
is where the light comes from. The first step takes the directions of `gaussian.samples`, of which those that meet
something are each followed several times. Sides of a surface are alike. A path that goes on after `bounces` points is
given up, and with it what it would have brought.

What paths bring is summed over the texels of a cube map, which lobes are then fitted to. Paths are few, so each is
spread over a Gaussian about as wide as a texel (15° at an edge of 6), lest lobes stand on single ones; nothing narrower
comes out of it.

Every vertex has random numbers of its own, so nothing depends on chunks or threads. Bound by numpy: some 1 µs for each
path and point, and rays.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from engine.core.directions import Vectors, dot, frames_along, normalize
from engine.geometry.ray_caster import offset_origins
from engine.light.cube_map import cube_directions, cube_solid_angles, texel_numbers
from engine.transport.gaussian.fitting.fit import TransportSamples
from engine.transport.gaussian.fitting.views import view_directions
from engine.transport.gaussian.samples import Drawn, GlossySurface, Material, draw, gather, on_threads

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

#: Edge of the cube map that arrivals are summed over, and how often each ray that meets something is followed.
EDGE, SPLIT = 6, 2

#: Width in rad that paths are spread over.
SPREAD = 0.2

#: Points of the surface that a path touches after the vertex, at most.
BOUNCES = 4

#: Least cosine between the normal that shades and the direction of view, as in `engine.render.surface`.
MIN_FACING = 0.01


@dataclass(frozen=True, eq=False)
class Arrivals:
    """Paths that left the model: `view` (P,) number of theirs, world `direction` (P, 3), `value` (P, 3).

    The sum of the values of a view is the integral of its indirect transport.
    """

    view: Indices
    direction: Vectors
    value: Floats


@dataclass(frozen=True, eq=False)
class _Front:
    """Paths that have just met the surface."""

    view: Indices
    face: NDArray[np.int32]
    barycentric: Floats
    incoming: Vectors
    value: Floats


def arrivals(
    surface: GlossySurface, vertex: int, views: Vectors, count: int, *, bounces: int = BOUNCES, seed: int = 0
) -> Arrivals:
    """Indirect glossy transport of a vertex towards world `views` (M, 3) above its horizon, `count` directions each."""
    if surface.of.free[vertex]:
        return _join([])
    drawn = draw(surface, vertex, views, count)
    view, sample = np.nonzero(drawn.value.any(axis=-1))
    value = drawn.value[view, sample] * drawn.weight[view, sample, None]
    direction = drawn.direction[view, sample]
    origin = np.broadcast_to(surface.of.origin[vertex], direction.shape)
    front = _split(_find_surface_points(surface, view, origin, direction, value)[0])
    rng, found = np.random.default_rng([seed, vertex]), []
    for _ in range(bounces):
        if not front.view.size:
            break
        front, left = _go_on(surface, front, rng)
        found.append(left)
    return _join(found)


def _split(front: _Front) -> _Front:
    return _Front(
        np.repeat(front.view, SPLIT),
        np.repeat(front.face, SPLIT),
        np.repeat(front.barycentric, SPLIT, axis=0),
        np.repeat(front.incoming, SPLIT, axis=0),
        np.repeat(front.value, SPLIT, axis=0) / SPLIT,
    )


def _join(found: list[Arrivals]) -> Arrivals:
    if not found:
        return Arrivals(np.zeros(0, np.int64), np.zeros((0, 3)), np.zeros((0, 3)))
    names = ("view", "direction", "value")
    return Arrivals(*(np.concatenate([getattr(each, name) for each in found]) for name in names))


def _find_surface_points(
    surface: GlossySurface, view: Indices, origin: Vectors, direction: Vectors, value: Floats
) -> tuple[_Front, NDArray[np.bool_]]:
    """The rays that meet the surface, and which do."""
    hits = surface.of.caster.intersect(origin, direction)
    met = hits.face >= 0
    return _Front(view[met], hits.face[met], hits.barycentric[met], direction[met], value[met]), met


def _go_on(surface: GlossySurface, front: _Front, rng: np.random.Generator) -> tuple[_Front, Arrivals]:
    """Follow a direction from every point: the paths that meet the surface again, and those that leave it."""
    origin, frame, viewer = _points(surface, front)
    wi, value = _reflect(surface, front, viewer, rng.random((len(viewer), 3)))
    direction = np.einsum("nij,nj->ni", frame, wi)
    bright = np.flatnonzero(value.any(axis=1))
    direction, value, view = direction[bright], value[bright], front.view[bright]
    after, met = _find_surface_points(surface, view, origin[bright], direction, value)
    own = after.face == front.face[bright[met]]
    after = _Front(
        *(getattr(after, name)[~own] for name in ("view", "face", "barycentric", "incoming", "value")),
    )
    return after, Arrivals(view[~met], direction[~met], value[~met])


def _points(surface: GlossySurface, front: _Front) -> tuple[Vectors, Vectors, Vectors]:
    """Origins of rays (N, 3), frames (N, 3, 3), and the way back in these (N, 3)."""
    mesh, caster = surface.mesh, surface.of.caster
    corners = mesh.faces[front.face]
    a, b, c = (caster.positions[corners[:, k]] for k in range(3))
    away = -front.incoming
    flat = normalize(np.cross(b - a, c - a), fallback=(0.0, 0.0, 0.0))
    flat = np.where(dot(flat, flat)[:, None] > 0.0, flat, away)
    side = np.where(dot(flat, away) < 0.0, -1.0, 1.0)[:, None]
    shading = normalize(np.einsum("nk,nki->ni", front.barycentric, mesh.normals[corners].astype(np.float64)) * side)
    low = np.maximum(MIN_FACING - dot(shading, away), 0.0)
    tangent = np.einsum("nk,nki->ni", front.barycentric, mesh.tangents[corners].astype(np.float64))
    frame = frames_along(normalize(shading + low[:, None] * away), tangent)
    point = np.einsum("nk,nki->ni", front.barycentric, np.stack([a, b, c], axis=1))
    return offset_origins(point, side * flat, caster), frame, np.einsum("nij,ni->nj", frame, away)


def _reflect(surface: GlossySurface, front: _Front, viewer: Vectors, u: Floats) -> tuple[Vectors, Floats]:
    """Directions (N, 3) in the frames of the points, and what paths bring from there (N, 3)."""
    wi, value = np.empty(viewer.shape), np.zeros(viewer.shape)
    for material, some in _materials(surface, front):
        if material is None:
            radius, phi = np.sqrt(u[some, 1]), 2.0 * np.pi * u[some, 2]
            up = np.sqrt(1.0 - u[some, 1])
            wi[some] = np.column_stack([radius * np.cos(phi), radius * np.sin(phi), up])
            value[some] = surface.ground_albedo
            continue
        with surface.guard:
            wi[some] = material.sampler.sample(viewer[some], u[some])
            density = material.sampler.pdf(wi[some], viewer[some])
            product = material.whole.f(wi[some], viewer[some]) * np.maximum(wi[some, 2:], 0.0)
        value[some] = product * np.where(density > 0.0, 1.0 / np.where(density > 0.0, density, 1.0), 0.0)[:, None]
    return wi, value * front.value


def _materials(surface: GlossySurface, front: _Front) -> list[tuple[Material | None, Indices]]:
    """The materials at the points, None for the ground, and which points have each."""
    corner = front.barycentric.argmax(axis=1)
    vertex = surface.mesh.faces[front.face, corner]
    on_ground = vertex >= surface.ground_vertex
    groups: list[tuple[Material | None, Indices]] = [(None, np.flatnonzero(on_ground))] if on_ground.any() else []
    model = np.flatnonzero(~on_ground)
    kind, made = surface.coarse
    kind = kind[vertex[model]]
    return [*groups, *((made[number], model[kind == number]) for number in np.unique(kind))]


def bin_values(found: Arrivals, views: int, edge: int) -> Floats:
    """(views, 6 edge², 3) mean transport over each texel of a cube map."""
    texel = found.view * (6 * edge * edge) + texel_numbers(found.direction, edge)
    count = views * 6 * edge * edge
    sums = np.stack([np.bincount(texel, found.value[:, k], count) for k in range(3)], axis=-1)
    area = np.tile(cube_solid_angles(edge).reshape(-1), 6)
    result: Floats = sums.reshape(views, -1, 3) / area[:, None]
    return result


def indirect_samples(
    surface: GlossySurface, vertices: Indices, count: int, *, bounces: int = BOUNCES
) -> TransportSamples:
    """Indirect glossy transport of `vertices` (B,) of the model towards the 92 views, from `count` directions each."""
    return gather(on_threads(lambda vertex: _mask_vertex(surface, vertex, count, bounces), vertices))


def _mask_vertex(surface: GlossySurface, vertex: int, count: int, bounces: int) -> tuple[NDArray[np.bool_], Drawn]:
    """Mask of the 92 views that get indirect light from a vertex, and its transport towards these over texels."""
    views = view_directions()
    above = views @ surface.frames[vertex, :, 2] > 0.0
    value = spread(bin_values(arrivals(surface, vertex, views[above], count, bounces=bounces), int(above.sum()), EDGE))
    lit = value.any(axis=(1, 2))
    above[np.flatnonzero(above)[~lit]] = False
    return above, texels(value[lit])


def spread(value: Floats) -> Floats:
    """Transport (M, 6 N², 3) over texels, each texel's share spread over those around it; the integral stays."""
    kernel, area = _spreading(int(np.sqrt(value.shape[1] // 6)))
    return np.einsum("mtc,tu->muc", value * area[:, None], kernel, optimize=True)


@lru_cache(maxsize=4)
def _spreading(edge: int) -> tuple[Floats, Floats]:
    """(T, T) what a unit of energy in each texel is over all texels, per sr, and their solid angles (T,)."""
    direction = cube_directions(edge).reshape(-1, 3)
    area = np.tile(cube_solid_angles(edge).reshape(-1), 6)
    kernel = np.exp((direction @ direction.T - 1.0) / SPREAD**2)
    return kernel / (kernel @ area)[:, None], area


def texels(value: Floats) -> Drawn:
    """Transport (M, 6 N², 3) over the texels of a cube map as what was drawn."""
    edge = int(np.sqrt(value.shape[1] // 6))
    direction = cube_directions(edge).reshape(-1, 3)
    area = np.tile(cube_solid_angles(edge).reshape(-1), 6)
    shape = (len(value), len(direction))
    return Drawn(np.broadcast_to(direction, (*shape, 3)), value, np.broadcast_to(area, shape))
