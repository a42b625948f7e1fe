"""Light along paths: what the pixels of an image receive, one random path for each sample.

A path starts in its pixel (uniformly, the box filter), meets the surface, and collects there the light that comes
straight from the environment and the lamps; then it goes on in a direction drawn from the BRDF. `max_depth` is the
number of points of the surface that light may touch: 1 is direct light with shadows, and nothing else. Light from the
environment and from lamps that are discs is found in two ways, by directions drawn from the light and by those drawn
from the BRDF, weighted by the power heuristic (Veach1997 Sec. 9.2). The weights compare the light's density with
that of the highlights alone: directions drawn from the light already follow the cosine, and what is diffuse is left to
them, for two estimates of it would be worse than one. Directional lights are found by themselves. Lights near the
model are found in both ways as well, and shadowed by what is between them and the surface; they hide nothing, and no
ray of the camera sees them. From the fourth point on, paths end at random, the dark ones sooner.

The surface is opaque and alike on both sides; `engine.render.surface_points` says how it is shaded. A triangle neither
lights itself nor is lit from behind. With a material, f cos is replaced by the look-up of `engine.scene.scene` at full
detail, whose 'outgoing' form depends on all light at once and has no such sum. With PBR maps, f is that of the texel at
full detail. The ground is Lambertian.

Paths are followed many at a time: each stage is one pass over all of them, in numba or numpy, and stages are bounded
by their arithmetic or by rays; about 2 µs a path with direct light on one core.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.core.directions import frames_along
from engine.core.errors import UsageError
from engine.core.kernels import scalar
from engine.geometry.ray_caster import caster_of, offset_origins
from engine.light.lamps import Lamp
from engine.light.near_lamps import NearLamp
from engine.render.light_sampling import (
    EnvironmentSampler,
    disc_density,
    draw_in_disc,
    environment_sampler,
    in_disc,
)
from engine.render.near_light_sampling import draw_towards, light_along
from engine.render.sobol import SOBOL, mix, pair, pairs
from engine.render.surface import Points, Reflector, to_local, to_world
from engine.render.surface_points import surface_points
from engine.scene.scene import Scene

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

#: Points of a path after which it may end at random, and the largest chance to go on.
CERTAIN_DEPTH, LARGEST_SURVIVAL = 3, 0.95


@dataclass(frozen=True, eq=False)
class Traced:
    """Result of paths: `radiance` (N, 3), `coverage` (N,) 1 if the camera sees the surface, and counts.

    `rays` were asked for; `rejected` samples were not finite and count as 0.
    """

    radiance: Floats
    coverage: Floats
    rays: int
    rejected: int


@dataclass(frozen=True, eq=False)
class Front:
    """Paths that have just met the surface: `path` (M,) are their places among all, the rest is along the paths.

    `incoming` (M, 3) world directions of the rays, `weight` (M, 3) what radiance found from here on is multiplied by.
    """

    path: Indices
    face: NDArray[np.int32]
    barycentric: Floats
    incoming: Floats
    weight: Floats


class Paths:
    """The paths of one scene in an image of `size` (width, height)."""

    def __init__(self, scene: Scene, size: tuple[int, int], max_depth: int) -> None:
        if max_depth < 1:
            raise ValueError(f"max_depth = {max_depth} must be at least 1")
        check_scene(scene)
        self.scene, self.size, self.max_depth = scene, size, max_depth
        surface = scene.surface
        self._caster = caster_of(surface)
        is_isotropic = all(each.brdf.isotropic for each in scene.parts)
        self._normals, self._tangents = surface.normals, None if is_isotropic else surface.tangents
        self._environment, self._lamps, self._near_lamps = _lights(scene)
        self._reflector = Reflector(scene)

    def __call__(self, state: np.uint64, pixel: Indices, sample: Indices) -> Traced:
        """Trace a path for each pair of a pixel (row × width + column) and a sample; `state` is of `seed_state`."""
        numbers = Numbers(state, pixel, sample, 3 + len(self._lamps) + len(self._near_lamps))
        traced = _Gathered(len(pixel))
        eye = np.broadcast_to(np.asarray(self.scene.camera.eye), (len(pixel), 3))
        direction = self._camera_directions(state, pixel, sample)
        weight = np.ones((len(pixel), 3))
        front = self._find_surface_points(traced, np.arange(len(pixel)), eye, direction, weight, coherent=True)[0]
        traced.coverage[front.path] = 1.0
        for depth in range(self.max_depth):
            if front.path.size == 0:
                break
            at = self._points(front)
            self._light_directly(traced, numbers.at(front.path, depth), front, at)
            front = self._go_on(traced, numbers.at(front.path, depth), front, at, last=depth + 1 == self.max_depth)
        return traced.result()

    def _camera_directions(self, state: np.uint64, pixel: Indices, sample: Indices) -> Floats:
        camera = self.scene.camera
        extent = float(np.tan(np.radians(camera.fov_deg) / 2.0))
        return camera_directions(state, pixel, sample, *self.size, extent, camera.camera_from_world, SOBOL)

    def _find_surface_points(
        self,
        traced: _Gathered,
        path: Indices,
        origin: Floats,
        direction: Floats,
        weight: Floats,
        *,
        coherent: bool = False,
    ) -> tuple[Front, Indices, Floats]:
        """The rays that meet the surface, which do not, and the distances (N,) after which they do, or infinity."""
        hits = self._caster.intersect(origin, direction, coherent=coherent)
        traced.rays += len(origin)
        met = np.flatnonzero(hits.face >= 0)
        front = Front(path[met], hits.face[met], hits.barycentric[met], direction[met], weight[met])
        return front, np.flatnonzero(hits.face < 0), hits.distance

    def _points(self, front: Front) -> Points:
        caster = self._caster
        point, flat, frame, viewer = surface_points(
            front.face, front.barycentric, front.incoming, caster.positions, self._normals, caster.faces
        )
        if self._tangents is not None:
            tangent = np.einsum("nc,nci->ni", front.barycentric, self._tangents[caster.faces[front.face]])
            frame = frames_along(frame[..., 2], tangent)
            viewer = -to_local(frame, front.incoming)
        at = Points(front.face, front.barycentric, offset_origins(point, flat, caster), frame, viewer)
        return self._reflector.texture(at, -front.incoming)

    def _light_directly(self, traced: _Gathered, numbers: NumbersAt, front: Front, at: Points) -> None:
        """Add the light of directions that are drawn from the lights."""
        if self._environment is not None:
            direction, radiance, density = self._environment.draw(numbers.pair(0), at.frame[..., 2])
            self._add_lit(traced, front, at, direction, radiance, density)
        for number, lamp in enumerate(self._lamps):
            if lamp.radius == 0.0:
                direction = np.broadcast_to(np.asarray(lamp.direction), front.incoming.shape)
                self._add_lit(traced, front, at, direction, np.asarray(lamp.irradiance), None)
            else:
                direction = draw_in_disc(numbers.pair(3 + number), np.asarray(lamp.direction), lamp.radius)
                density = np.full(len(direction), disc_density(lamp.radius))
                self._add_lit(traced, front, at, direction, np.asarray(lamp.radiance), density)
        for number, near in enumerate(self._near_lamps, 3 + len(self._lamps)):
            direction, distance, light, found = draw_towards(near, numbers.pair(number), at.origin)
            self._add_lit(traced, front, at, direction, light, found, distance)

    def _add_lit(
        self,
        traced: _Gathered,
        front: Front,
        at: Points,
        direction: Floats,
        light: Floats,
        density: Floats | None,
        distance: Floats | None = None,
    ) -> None:
        """Add `light` from `direction`, found with `density`; None for a light that nothing else finds.

        It stands at a `distance` (M,), None for a distant one.
        """
        wi = to_local(at.frame, direction)
        is_lit = wi[:, 2] > 0.0
        above = np.flatnonzero(is_lit if density is None else is_lit & (density > 0.0))
        wi = wi[above]
        light = light[above] if light.ndim == 2 else light
        value = front.weight[above] * self._reflector.product(at, above, wi) * light
        if density is not None:
            own = density[above]
            value *= (power_weight(own, self._reflector.highlight(at, above, wi)) / own)[:, None]
        far = None if distance is None else distance[above]
        self._add_seen(traced, front.path[above], at.origin[above], direction[above], value, far)

    def _go_on(self, traced: _Gathered, numbers: NumbersAt, front: Front, at: Points, *, last: bool) -> Front:
        """Follow directions drawn from the BRDF: add the light that they find, and return those that meet the surface.

        From the `last` point only highlights are followed, and only towards light.
        """
        if last and not self._reflector.has_highlight:
            return _nothing()
        other = numbers.pair(2)
        u = np.column_stack([other[:, 0], numbers.pair(1)])
        wi = self._reflector.draw(at, u, highlight=last)
        above = np.flatnonzero(wi[:, 2] > 0.0)
        wi = wi[above]
        highlight = self._reflector.highlight(at, above, wi)
        density = highlight if last else self._reflector.density(at, above, wi, highlight)
        weight = front.weight[above] * self._reflector.product(at, above, wi)
        weight *= np.where(density > 0.0, 1.0 / np.where(density > 0.0, density, 1.0), 0.0)[:, None]
        keep = np.flatnonzero(weight.any(axis=1))
        above, weight, highlight = above[keep], weight[keep], highlight[keep]
        direction, normal = to_world(at.frame[above], wi[keep]), at.frame[above, :, 2]
        if last:
            value = weight * self._light_along(direction, highlight, normal)
            self._add_seen(traced, front.path[above], at.origin[above], direction, value)
            for light, distance in self._near_light_along(at.origin[above], direction, highlight):
                self._add_seen(traced, front.path[above], at.origin[above], direction, weight * light, distance)
            return _nothing()
        reached, missed, free = self._find_surface_points(
            traced, front.path[above], at.origin[above], direction, weight
        )
        light = self._light_along(direction[missed], highlight[missed], normal[missed])
        traced.add(front.path[above[missed]], weight[missed] * light)
        for light, distance in self._near_light_along(at.origin[above], direction, highlight):
            traced.add(front.path[above], (distance < free)[:, None] * weight * light)
        return self._surviving(reached, front.face[above], missed, other[above, 1], numbers.depth)

    def _add_seen(
        self,
        traced: _Gathered,
        path: Indices,
        origin: Floats,
        direction: Floats,
        value: Floats,
        distance: Floats | None = None,
    ) -> None:
        """Add `value` where nothing stands in the way, up to a `distance` (M,) if there is one.

        Nothing is asked where there is nothing to add.
        """
        counts = np.flatnonzero(value.any(axis=1))
        if distance is None:
            shadowed = self._caster.occluded(origin[counts], direction[counts])
        else:
            shadowed = self._caster.intersect(origin[counts], direction[counts]).distance < distance[counts]
        traced.rays += len(counts)
        counts = counts[~shadowed]
        traced.add(path[counts], value[counts])

    def _light_along(self, direction: Floats, density: Floats, normal: Floats) -> Floats:
        """Radiance (N, 3) from directions with the `density` of highlights, times their share beside the lights'."""
        found = np.zeros((len(direction), 3))
        if self._environment is not None:
            radiance, other = self._environment.look_up(direction, normal)
            found += radiance * power_weight(density, other)[:, None]
        for lamp in self._lamps:
            if lamp.radius > 0.0:
                inside = np.flatnonzero(in_disc(direction, np.asarray(lamp.direction), lamp.radius))
                share = power_weight(density[inside], np.full(len(inside), disc_density(lamp.radius)))
                found[inside] += share[:, None] * lamp.radiance
        return found

    def _near_light_along(self, origin: Floats, direction: Floats, density: Floats) -> Iterator[tuple[Floats, Floats]]:
        """For each light near the model: as `_light_along`, and its distances (N,), infinite where there is none."""
        for lamp in self._near_lamps:
            if not lamp.is_point:
                light, other, distance = light_along(lamp, origin, direction)
                yield light * power_weight(density, other)[:, None], distance

    def _surviving(self, reached: Front, left: NDArray[np.int32], missed: Indices, u: Floats, depth: int) -> Front:
        """Without rays that meet the triangle they left, and from `CERTAIN_DEPTH` on without some others."""
        met = np.ones(len(left), np.bool_)
        met[missed] = False
        alive = reached.face != left[met]
        weight = reached.weight
        if depth + 1 >= CERTAIN_DEPTH:
            chance = np.minimum(np.abs(weight).max(axis=1, initial=0.0), LARGEST_SURVIVAL)
            alive &= u[met] < chance
            weight = weight / np.where(chance > 0.0, chance, 1.0)[:, None]
        return Front(
            reached.path[alive], reached.face[alive], reached.barycentric[alive], reached.incoming[alive], weight[alive]
        )


def check_scene(scene: Scene) -> None:
    """Raise UsageError for a look-up that is not a sum over light."""
    if scene.shading is not None and scene.lookup == "outgoing":
        raise UsageError("the form 'outgoing' depends on all light at once: no reference exists for it")


def _nothing() -> Front:
    none = np.zeros((0, 3))
    return Front(np.zeros(0, np.int64), np.zeros(0, np.int32), none, none, none)


def power_weight(own: Floats, other: Floats) -> Floats:
    """own² / (own² + other²), without squares that overflow; 0 where both are 0."""
    larger = np.maximum(own, other)
    larger = np.where(larger > 0.0, larger, 1.0)
    one, two = own / larger, other / larger
    return one * one / np.maximum(one * one + two * two, 1e-300)


def _lights(scene: Scene) -> tuple[EnvironmentSampler | None, tuple[Lamp, ...], tuple[NearLamp, ...]]:
    """Sources behind `Scene.lights`: the map or none, and all lamps that are not dark, the one light among them.

    Last those near the model.
    """
    environment, lamps = None, scene.lamps
    if scene.environment is None:
        lamps = (Lamp(scene.light, (scene.irradiance,) * 3), *lamps)
    else:
        environment = environment_sampler(scene.environment, scene.irradiance, scene.environment_rotation)
    near_lamps = tuple(lamp for lamp in scene.near_lamps if any(lamp.power))
    return environment, tuple(lamp for lamp in lamps if any(lamp.irradiance)), near_lamps


class _Gathered:
    """Radiance and counts gathered so far along paths."""

    def __init__(self, count: int) -> None:
        self.radiance, self.coverage = np.zeros((count, 3)), np.zeros(count)
        self.rays = 0

    def add(self, path: Indices, value: Floats) -> None:
        """Add `value` (M, 3) to the radiance of `path` (M,), no path twice."""
        self.radiance[path] += value

    def result(self) -> Traced:
        finite = np.isfinite(self.radiance.sum(axis=1))
        radiance = np.where(finite[:, None], self.radiance, 0.0)
        return Traced(radiance, self.coverage, self.rays, int(len(finite) - finite.sum()))


@dataclass(frozen=True, eq=False)
class Numbers:
    """The random numbers of paths; each point of a path has `dimensions` pairs, and the camera one before them."""

    state: np.uint64
    pixel: Indices
    sample: Indices
    dimensions: int

    def at(self, path: Indices, depth: int) -> NumbersAt:
        return NumbersAt(self, self.pixel[path], self.sample[path], depth)


@dataclass(frozen=True, eq=False)
class NumbersAt:
    """Those of some paths at their point number `depth`."""

    numbers: Numbers
    pixel: Indices
    sample: Indices
    depth: int

    def pair(self, dimension: int) -> Floats:
        """(M, 2) in [0, 1)."""
        dimension += 1 + self.depth * self.numbers.dimensions
        drawn: Floats = pairs(self.numbers.state, self.pixel, dimension, self.sample, SOBOL)
        return drawn


@scalar
def camera_directions(
    state: np.uint64,
    pixel: np.ndarray,
    sample: np.ndarray,
    width: int,
    height: int,
    extent: float,
    rotation: np.ndarray,
    sobol: np.ndarray,
) -> np.ndarray:
    """Unit world directions (N, 3) through a random place in each pixel, as `Camera.rays`.

    `extent` is the tangent of half the vertical field of view, `rotation` the camera's `camera_from_world`.
    """
    direction = np.empty((pixel.size, 3))
    for n in range(pixel.size):
        u, v = pair(mix(state, pixel[n]), 0, sample[n], sobol)
        x = (2.0 * (pixel[n] % width + u) / width - 1.0) * extent * width / height
        y = (1.0 - 2.0 * (pixel[n] // width + v) / height) * extent
        length = np.sqrt(x * x + y * y + 1.0)
        for i in range(3):
            direction[n, i] = (x * rotation[0, i] + y * rotation[1, i] - rotation[2, i]) / length
    return direction
