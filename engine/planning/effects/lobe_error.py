"""Predicted error of Gaussians on a scene, by fitting some of them: no table, and nothing is baked.

For some pairs of point and view, transport towards the three of the 92 views that are mixed for it is tabulated and
fitted by the code of a bake, with as many directions; the diffuse part has the order of a bake. What they make of
the light and its lamps is compared with the exact radiance (`lobe_pairs`). Pairs are drawn by what they weigh, by
their share of the squares of the radiance, and of those of the glossy part, a third each, because a few at grazing
angles make most of the error.

In the image of a camera lobes are mixed across triangles. In some of its pixels, more where lamps are reflected,
lobes are fitted at the place itself and at the corners of its face; what the mixture of these and those make of the
light differs where highlights wander off or end on a face. What neighbours do to each other in a bake is not in the
figure.

Pairs of a point and a view: their transport tabulated and fitted as in a bake, and their radiance summed exactly.

Each point is as if it were a vertex of a model of its own. The exact radiance is a sum over texels that are the finer
the less even the light is, and over directions drawn from the BRDF (the balance heuristic, as in
`engine.transport.gaussian.error`): lamps smaller than any texel and lobes narrower than one are then seen as they are.

An environment in few texels of unequal size: large where it is even, small where it is not.

The texels of a coarse cube map are cut in four where that makes the largest difference, and again, until lamps that are
smaller than a degree stand alone. Some thousand texels then tell what a hundred thousand would.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.core.cached import cached_property
from engine.core.colour import luminance
from engine.core.directions import Vectors
from engine.core.one_thread import one_thread
from engine.geometry.mesh import Mesh
from engine.light.cube_map import cube_directions, cube_of, cube_solid_angles, texel_numbers
from engine.light.gaussian_prefilter import gaussian_integral
from engine.light.lamps import lights_of_all
from engine.planning.costs.cost_model import DIFFUSE_ORDER
from engine.planning.effects.between_vertices import Between, sum_lamps_between
from engine.planning.effects.estimates import Scenery
from engine.planning.effects.mode_error import together
from engine.planning.effects.radiance import coefficients
from engine.planning.effects.relative_error import relative_error
from engine.planning.effects.sample import Light, by_worth
from engine.planning.effects.simplified import lambertian
from engine.transport.baking.diffuse_specular import parts
from engine.transport.gaussian.error import part_of
from engine.transport.gaussian.fitting.fit import Fit, FitSettings, TransportSamples, fit_vertices
from engine.transport.gaussian.fitting.lobes import Lobes
from engine.transport.gaussian.fitting.views import nearest_views, view_directions
from engine.transport.gaussian.lighting import GaussianLight, lobe_radiance
from engine.transport.gaussian.samples import GlossySurface, density_local, direct, gather, on_threads, products
from engine.transport.gaussian.transfer import GaussianTransport, SeenLobes, lobes_towards, mix
from engine.transport.sh.basis import evaluate

#: Edges of the cube maps that texels are of, each twice the one before, and how many of one are cut into the next.
EDGES, CUT = (16, 32, 64, 128), (256, 384, 512)


@dataclass(frozen=True, eq=False)
class FineLight:
    """T texels of a light without its lamps.

    Attributes
    ----------
    direction : (T, 3) of their middles. area : (T,) sr, which add up to 4 π. radiance : (T, 3).
    """

    direction: Vectors
    area: Array
    radiance: Array
    _number: NDArray[np.int64]

    @property
    def incident(self) -> Array:
        """(T, 3) radiance times solid angle."""
        return self.radiance * self.area[:, None]

    def at(self, direction: Vectors) -> NDArray[np.int64]:
        """(N,) the texels that directions (N, 3) lie in."""
        found: NDArray[np.int64] = self._number[texel_numbers(direction, EDGES[-1])]
        return found


@lru_cache(maxsize=4)
def fine_light(light: Light) -> FineLight:
    """Fine cells of `light` without its lamps; some 50 ms, and remembered."""
    fine = cube_of(light.rest, EDGES[-1]).radiance.astype(np.float64)
    area = np.tile(cube_solid_angles(EDGES[-1]), (6, 1, 1))
    bright: Array = np.asarray(luminance(fine), np.float64)
    whole: NDArray[np.bool_] = np.ones((6, EDGES[0], EDGES[0]), np.bool_)
    number = np.zeros(area.shape, np.int64)
    directions: list[Vectors] = []
    areas: list[Array] = []
    radiances: list[Array] = []
    for edge, cut in zip(EDGES, (*CUT, 0), strict=True):
        size = EDGES[-1] // edge
        own = _sums(area, size)
        split = _max_uneven(np.where(whole, _unevenness(bright, area, size), 0.0), cut)
        left = whole & ~split
        first = sum(len(each) for each in areas)
        numbers = np.cumsum(left.ravel()).reshape(left.shape) - 1 + first
        number = np.where(_spread(left, size), _spread(numbers, size), number)
        directions.append(cube_directions(edge)[left])
        areas.append(own[left])
        radiances.append(np.stack([_sums(each * area, size) for each in np.moveaxis(fine, -1, 0)], -1)[left])
        radiances[-1] /= areas[-1][:, None]
        whole = _spread(split, 2)
    return FineLight(np.concatenate(directions), np.concatenate(areas), np.concatenate(radiances), number.ravel())


def _sums(values: Array, size: int) -> Array:
    """(6, N / size, N / size) of (6, N, N)."""
    edge = values.shape[1] // size
    return np.asarray(values.reshape(6, edge, size, edge, size).sum(axis=(2, 4)))


def _spread(values: NDArray[Any], size: int) -> NDArray[Any]:
    """(6, N size, N size) of (6, N, N)."""
    return np.repeat(np.repeat(values, size, axis=1), size, axis=2)


def _unevenness(bright: Array, area: Array, size: int) -> Array:
    """(6, N / size, N / size) how much light of each texel is not where it would be if it were even."""
    mean = _sums(bright * area, size) / _sums(area, size)
    return _sums(np.abs(bright - _spread(mean, size)) * area, size)


def _max_uneven(gain: Array, count: int) -> NDArray[np.bool_]:
    """The `count` texels of the largest `gain`, those without any apart."""
    chosen = np.zeros(gain.size, np.bool_)
    if count:
        chosen[np.argpartition(gain.ravel(), -count)[-count:]] = True
    return (chosen & (gain.ravel() > 1e-9 * gain.sum())).reshape(gain.shape)


#: Directions for each view, as in a bake, and directions drawn for each pair beside the texels.
DIRECTIONS, DRAWN = 128, 256


@dataclass(frozen=True, eq=False)
class Pairs:
    """M pairs under one light: the points are those of `surface`, one after the other, `views` (M, 3) in the world."""

    light: Light
    surface: GlossySurface
    views: Vectors

    def first(self, count: int) -> Pairs:
        """The first pairs alone, without what is known of them."""
        every = self.surface
        of = replace(
            every.of, origin=every.of.origin[:count], normal=every.of.normal[:count], free=every.of.free[:count]
        )
        varied = {name: values[:count] for name, values in every.varied.items()}
        mesh = part_of(every.mesh, np.arange(count))
        some = replace(every, mesh=mesh, ground_vertex=count, varied=varied, of=of, frames=every.frames[:count])
        return Pairs(self.light, some, self.views[:count])

    @cached_property
    def fine(self) -> FineLight:
        return fine_light(self.light)

    @cached_property
    def samples(self) -> TransportSamples:
        """Transport towards the views that are mixed for the pair's own; nothing towards the others."""
        asked = nearest_views(self.views)[0]

        def shade_pair(pair: int) -> Any:
            wanted = np.zeros(len(view_directions()), np.bool_)
            wanted[asked[pair]] = True
            wanted &= view_directions() @ self.surface.frames[pair, :, 2] > 0.0
            return wanted, direct(self.surface, pair, view_directions()[wanted], DIRECTIONS)

        return gather(on_threads(shade_pair, np.arange(len(self.views))))

    def fitted(self, lobes: int, count: int) -> list[Lobes]:
        """Lobes of the first `count` pairs, weighed in two ways: nearest to the transport, and with all its energy."""
        every = self.samples
        start = every.start[: count * len(view_directions()) + 1]
        end = int(start[-1])
        some = TransportSamples(start, every.direction[:end], every.value[:end], every.area[:end])
        alone = [np.zeros(0, np.int64)] * count  # no neighbours that are done
        with one_thread():
            found = fit_vertices(some, alone, Fit.empty(1, lobes).lobes, FitSettings(lobes))
            return [found.lobes, found.preserving()]

    def seen(self, lobes: Lobes) -> SeenLobes:
        """The lobes of the first pairs, as many as there are, towards their views."""
        count = len(lobes.sigma)
        mesh = part_of(self.surface.mesh, np.arange(count))
        return lobes_towards(GaussianTransport(mesh, count, 0.0, (lobes,), None), self.views[:count])

    def under(self, seen: SeenLobes) -> Array:
        """(n, 3) radiance of lobes under the light; texels make each wider, as if they were Gaussians."""
        value = lobe_radiance(GaussianLight(lamps=self.light.lamps), seen.energy, seen.mean, seen.sigma)
        light = self.fine
        for row, sigma in enumerate(seen.sigma):
            square = sigma[:, None] ** 2 + light.area / 12.0
            height = np.exp((seen.mean[row] @ light.direction.T - 1.0) / square) / gaussian_integral(np.sqrt(square))
            value[row] += np.einsum("kt,tc,kc->c", height, light.incident, seen.energy[row])
        return value

    @cached_property
    def both(self) -> tuple[Array, Array]:
        """(M, 3) exact radiance, and that of the diffuse part at the order of a bake."""
        towards = evaluate(DIFFUSE_ORDER, self.fine.direction) @ coefficients(self.light)[: DIFFUSE_ORDER**2]
        found = on_threads(lambda pair: _sum_up(self, pair, towards), np.arange(len(self.views)))
        whole, diffuse = zip(*found, strict=True)
        return np.array(whole), np.array(diffuse)

    @property
    def wanted(self) -> Array:
        return self.both[0]

    @property
    def diffuse(self) -> Array:
        return self.both[1]


def _sum_up(pairs: Pairs, pair: int, towards: Array) -> tuple[Array, Array]:
    """(3,) the radiance of a pair, and what the diffuse part makes of light of low order, `towards` (T, 3)."""
    surface, light, frame = pairs.surface, pairs.fine, pairs.surface.frames[pair]
    material = surface.material_at(pair)
    wi = light.direction @ frame
    up = np.flatnonzero(wi[:, 2] > 0.0)
    up = up[_open(surface, pair, light.direction[up])]
    wi, area = wi[up], light.area[up]
    view = pairs.views[pair]
    wo = np.broadcast_to(view @ frame, wi.shape)
    drawn = direct(surface, pair, view[None], DRAWN)
    with surface.guard:
        value = products(material.glossy, wi, wo)
        density = density_local(material, wi, wo, DRAWN)
        flat = np.asarray(material.diffuse.f(wi, wo)) * wi[:, 2:]
    whole = (light.radiance[up] * (value / (1.0 / area + density)[:, None] + flat * area[:, None])).sum(axis=0)
    texel = light.at(drawn.direction[0])
    counts = 1.0 / (1.0 / drawn.weight[0] + 1.0 / light.area[texel])
    whole += (drawn.value[0] * light.radiance[texel] * counts[:, None]).sum(axis=0)
    low = (towards[up] * flat * area[:, None]).sum(axis=0)
    return whole + _sum_lamps(pairs, pair), np.maximum(low, 0.0)


def _open(surface: GlossySurface, pair: int, direction: Vectors) -> NDArray[np.bool_]:
    if surface.of.free[pair]:
        return np.ones(len(direction), np.bool_)
    origin = np.broadcast_to(surface.of.origin[pair], direction.shape)
    return ~np.asarray(surface.of.caster.occluded(origin, direction))


def _sum_lamps(pairs: Pairs, pair: int) -> Array:
    """(3,) the radiance of a pair by lamps."""
    surface, lamps = pairs.surface, lights_of_all(pairs.light.lamps)
    wi = lamps.direction @ surface.frames[pair]
    lit = np.flatnonzero(wi[:, 2] > 0.0)
    lit = lit[_open(surface, pair, lamps.direction[lit])]
    if not lit.size:
        return np.zeros(3)
    wi = wi[lit]
    wo = np.broadcast_to(pairs.views[pair] @ surface.frames[pair], wi.shape)
    with surface.guard:
        value = surface.material_at(pair).whole.f(wi, wo)
    return np.asarray((value * wi[:, 2:] * lamps.irradiance[lit]).sum(axis=0))


Array = NDArray[np.float64]
Indices = NDArray[np.int64]

#: Pairs that are fitted with one lobe, two and three; pixels whose lobes are mixed.
PAIRS, PIXELS = (96, 48, 32), 64

#: Steps of this share of the whole spread points evenly, however many are taken.
GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0

#: Least factor that raises the predicted error of a method: a hundred pairs, or two, know it to a third.
MARGIN = 1.4


@lru_cache(maxsize=24)
def lobe_error(scene: Scenery, lobes: int) -> float | None:
    """The error of `lobes` Gaussians for each vertex and view, by the better of the two ways to weigh them.

    More lobes are fitted to fewer pairs, and judged by their error there beside a single one: what pairs have in
    common cancels. None where nothing about the BRDF is glossy.
    """
    if parts(scene.brdf)[1] is None:
        return None
    pairs, shares = _pairs(scene)
    single = _values(scene, 1)
    error = _error(pairs, shares, single, margin=True)
    if lobes > 1:
        several = _values(scene, lobes)
        alone = _error(pairs, shares, [value[: len(several[0])] for value in single], margin=False)
        error *= _error(pairs, shares, several, margin=False) / alone if alone > 0.0 else 1.0
    return together(error, _mixing_error(scene))


@lru_cache(maxsize=6)
def _values(scene: Scenery, lobes: int) -> list[Array]:
    """The radiance of the first pairs by fitted lobes, weighed in two ways."""
    (pairs, _), count = _pairs(scene), PAIRS[lobes - 1]
    glossy = [pairs.under(pairs.seen(each)) for each in pairs.fitted(lobes, count)]
    return [np.maximum(pairs.diffuse[:count] + each, 0.0) for each in glossy]


def _error(pairs: Pairs, shares: Sequence[Array], values: Sequence[Array], *, margin: bool) -> float:
    """Error of the nearer of `values` (M, 3) at the first M pairs, which count for `shares`."""
    count = len(values[0])
    wanted, shares = pairs.wanted[:count, None], [each[:count] for each in shares]
    return min(relative_error(value[:, None], wanted, shares, margin=margin, least=MARGIN) for value in values)


@lru_cache(maxsize=2)
def _pairs(scene: Scenery) -> tuple[Pairs, tuple[Array, Array]]:
    """The pairs that are looked at, and what each counts for, twice; the first are as evenly spread as all."""
    sample = scene.sample
    weight = sample.shares[0]
    chance = _chance(scene, weight)
    reached = np.cumsum(chance.ravel())
    drawn = np.searchsorted(reached, (np.arange(PAIRS[0]) + 1.0) * GOLDEN % 1.0 * reached[-1])
    points, view = np.divmod(np.minimum(drawn, reached.size - 1), weight.shape[1])
    first, second = ((each[points, view] / chance[points, view])[:, None] for each in sample.shares)
    views = np.einsum("nij,nj->ni", sample.frames[points], sample.views[points, view])
    return Pairs(sample.light, _surface(scene, points), views), (first, second)


def _chance(scene: Scenery, weight: Array) -> Array:
    """(N, K) how often a pair is drawn: by `weight`, by what it weighs of the light, and of what is glossy."""
    flat = np.asarray(parts(scene.brdf)[0].colour) / np.maximum(lambertian(scene.brdf).albedo, 1e-9)
    glossy = np.maximum(scene.radiances.full - flat * scene.radiances.diffuse, 0.0)
    squares = [(weight * (each**2).sum(axis=-1)) for each in (scene.radiances.full, glossy)]
    shares = [each / each.sum() for each in (weight, *squares) if each.sum() > 0.0]
    return np.asarray(np.mean(shares, axis=0))


def _surface(scene: Scenery, points: Indices) -> GlossySurface:
    """The chosen points as if they were the vertices of the model."""
    sample = scene.sample
    vertices, of = sample.vertices[points], sample.of
    some = replace(of, origin=of.origin[vertices], normal=of.normal[vertices], free=of.free[vertices])
    mesh = part_of(sample.surface, vertices)
    values = {} if scene.varied is None else {name: each[vertices] for name, each in scene.varied.values.items()}
    return GlossySurface(mesh, len(points), 0.0, scene.brdf, values, some, sample.frames[points])


@lru_cache(maxsize=2)
def _mixing_error(scene: Scenery) -> float:
    """Change that mixing a lobe across triangles makes in the image of a camera, relative to it; 0 without one."""
    if scene.between is None:
        return 0.0
    pairs, corners, barycentric, weight = _pixels(scene.between, scene)
    count = len(weight)
    exact = pairs.first(count).wanted
    found = []
    for lobes in pairs.fitted(1, len(pairs.views)):
        seen = pairs.seen(lobes)
        own = SeenLobes(seen.energy[:count], seen.mean[:count], seen.sigma[:count])
        apart = pairs.under(mix(seen, corners, barycentric)) - pairs.under(own)
        found.append(float((weight[:, None] * apart**2).sum()))
    whole = float((weight[:, None] * exact**2).sum())
    return math.sqrt(min(found) / whole) if whole > 0.0 else 0.0


def _pixels(between: Between, scene: Scenery) -> tuple[Pairs, Indices, Array, Array]:
    """P places that pixels show and then the corners of their faces; corners (P, 3), shares (P, 3), and weights (P,).

    More places are drawn where a lamp is reflected by the place, or by a corner, and weigh less.
    """
    places = between.many
    count = len(places.barycentric)
    lit = np.abs(sum_lamps_between(between, scene.brdf)).sum(axis=1).reshape(4, count)
    rows, weight = by_worth(lit[0] + lit[1:].max(axis=0), PIXELS, np.random.default_rng(3))
    every = (rows + count * np.arange(4)[:, None]).ravel()
    of, frames, chosen = places.of, places.frames[every], places.chosen[every]
    some = replace(of, origin=of.origin[chosen], normal=of.normal[chosen], free=of.free[chosen])
    flat = np.zeros((len(every), 2), np.float32)
    mesh = Mesh(some.origin, frames[:, :, 2], flat, np.zeros((1, 3), np.int32), "places")
    surface = GlossySurface(mesh, len(every), 0.0, scene.brdf, {}, some, frames)
    views = np.einsum("nij,nj->ni", frames, places.views[every])
    corners = np.arange(PIXELS)[:, None] + PIXELS * np.arange(1, 4)
    return Pairs(between.looked.light, surface, views), corners, places.barycentric[rows], weight
