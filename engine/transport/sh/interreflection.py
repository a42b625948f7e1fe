"""Interreflection of a model, for transport in spherical harmonics (Sloan2002 Sec. 5).

On its way light meets surfaces as diffuse ones, with the albedo that they have under even light: exact for
Lambertian models, and said in the file and by the program for others; the last reflection, the one that is seen, is
always that of the BRDF. Each bounce sends rays from every vertex in directions as dense as the cosine, and reads
what arrives at the three corners of the triangle that is met.

Bound by the rays, `Surroundings.rays` for each vertex and bounce, and by order² or order⁴ sums for each that meets.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.core.directions import Vectors
from engine.core.steps import Step, Steps
from engine.geometry.ray_caster import RayCaster, meets_front
from engine.storage.scratch import scratch_array
from engine.transport.baking import visibility_kernel
from engine.transport.baking.chunks import Recipe, Remote, each_of, open_workers
from engine.transport.baking.visibility import Receivers
from engine.transport.sh import kernel as sh_kernel
from engine.transport.sh.basis import evaluate
from engine.transport.sh.transfer import even_in_z

#: Rays of a bounce that are followed at once, times the spherical harmonics of each.
CHUNK_RAYS = 1 << 22


@dataclass(frozen=True, eq=False)
class Surroundings:
    """Receivers as seen by each other: the surface that they are the vertices of, the order, rays from each."""

    positions: Vectors
    faces: NDArray[np.int32]
    of: Receivers
    order: int
    rays: int


def reflections(
    around: Surroundings,
    rounds: int,
    albedo: NDArray[np.float32],
    bounds: NDArray[np.int64],
    cluster: str | None = None,
) -> Steps[NDArray[np.float32]]:
    """(V, C, order²) radiance that each vertex sends to every side, after up to `rounds` − 1 reflections before.

    What it reflects itself of the distant light, with `albedo` (V, C), then what it reflects of that, and so on.
    `bounds` cut the vertices into parts that are worked on at once, by the workers of a `cluster` where its address is
    given (`engine.transport.baking.chunks`).
    """
    shape = (*albedo.shape, around.order**2)
    latest, total = None, scratch_array(shape, np.float32)
    for bounce in range(rounds):
        arriving, done = scratch_array(shape, np.float32), 0
        by = Remote(cluster, maker, _recipe_of(around, latest)) if cluster else partial(receive, around, latest)
        parts = (np.arange(start, stop) for start, stop in pairwise(bounds))
        with open_workers(by) as run, closing(each_of(run, parts)) as found:
            for vertices, light in found:
                arriving[vertices], done = light, done + len(vertices)
                yield Step((bounce + done / len(albedo)) / rounds, f"following bounce {bounce + 1} of {rounds}")
        arriving *= albedo[..., None]
        total += arriving
        latest = arriving
    return total


def receive(
    around: Surroundings, sent: NDArray[np.float32] | None, vertices: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
    """`vertices`, and irradiance / π (B, C, order²) there of the distant light, or of what all vertices have `sent`."""
    return vertices, transfer_open(around, vertices) if sent is None else gather(around, vertices, sent)


def maker(recipe: Recipe) -> Callable[[NDArray[np.int64]], Any]:
    """`receive` of vertices, from `_recipe_of` it."""
    caster = RayCaster(recipe["shading_positions"], recipe["shading_faces"])
    of = Receivers(caster, recipe["origin"], recipe["normal"], recipe["free"])
    around = Surroundings(recipe["positions"], recipe["faces"], of, recipe["order"], recipe["rays"])
    return partial(receive, around, recipe.get("sent"))


def _recipe_of(around: Surroundings, sent: NDArray[np.float32] | None) -> Recipe:
    of = around.of
    return {
        "positions": around.positions,
        "faces": around.faces,
        "shading_positions": of.caster.positions,
        "shading_faces": of.caster.faces,
        "origin": of.origin,
        "normal": of.normal,
        "free": of.free,
        "order": around.order,
        "rays": around.rays,
        **({} if sent is None else {"sent": sent}),
    }


def _rays(around: Surroundings, vertices: NDArray[np.int64]) -> tuple[Vectors, NDArray[np.float32]]:
    """Origins and directions (B D, 3), as dense as the cosine and rotated for each vertex."""
    rays: tuple[Vectors, NDArray[np.float32]] = visibility_kernel.hemisphere_rays(
        vertices, around.of.origin, around.of.normal, make_pattern(around.rays)
    )
    return rays


def make_pattern(count: int) -> Vectors:
    """(count, 3) directions about +z in a spiral, as dense as the cosine."""
    index = np.arange(count)
    radius, azimuth = np.sqrt((index + 0.5) / count), index * np.pi * (3.0 - np.sqrt(5.0))
    return np.stack([radius * np.cos(azimuth), radius * np.sin(azimuth), np.sqrt(1.0 - radius**2)], axis=-1)


def _blocks(around: Surroundings, vertices: NDArray[np.int64]) -> Iterator[slice]:
    step = max(1, CHUNK_RAYS // (around.rays * around.order**2))
    yield from (slice(start, start + step) for start in range(0, len(vertices), step))


def transfer_open(around: Surroundings, vertices: NDArray[np.int64]) -> NDArray[np.float32]:
    """(B, 1, order²) transfer to irradiance / π of the distant light, by the rays of a bounce."""
    result = np.empty((len(vertices), 1, around.order**2), np.float32)
    for block in _blocks(around, vertices):
        origin, direction = _rays(around, vertices[block])
        seen = (~around.of.caster.occluded(origin, direction)).reshape(-1, around.rays)
        basis = evaluate(around.order, direction).reshape(*seen.shape, -1)
        result[block, 0] = np.einsum("bd,bdi->bi", seen / around.rays, basis)
    return result


def gather(
    around: Surroundings,
    vertices: NDArray[np.int64],
    sent: NDArray[np.float32],
    frames: Vectors | None = None,
) -> NDArray[np.float32]:
    """Light that `vertices` get from other parts of the surface, which send `sent` (V, C, order²) to every side.

    Irradiance / π (B, C, order²); with `frames` (B, 3, 3) instead the rows of matrices (B, order², C, order²), of
    light as a mirror at the tangent plane would show it. Surfaces are black from behind.
    """
    order, count = around.order, around.rays
    shape = (len(vertices), *sent.shape[1:]) if frames is None else (len(vertices), order**2, *sent.shape[1:])
    result = np.zeros(shape, np.float32)
    doubled = np.where(even_in_z(order), 2.0, 0.0)
    for block in _blocks(around, vertices):
        origin, direction = _rays(around, vertices[block])
        hits = around.of.caster.intersect(origin, direction)
        corners = around.faces[hits.face]
        met = (hits.face >= 0) & meets_front(around.positions, corners, direction)
        if frames is None:
            weight = np.full((len(direction), 1), 1.0 / count)
        else:
            own = np.einsum("bij,bdi->bdj", frames[block], direction.reshape(-1, count, 3)).reshape(-1, 3)
            weight = evaluate(order, own) * doubled * (np.pi / count / np.maximum(own[:, 2:], 1e-3))
        out = result[block].reshape(-1, weight.shape[1], *sent.shape[1:])
        sh_kernel.gather(count, met, corners, hits.barycentric, weight, sent, out)
    return result
