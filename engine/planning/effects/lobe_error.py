"""Predicted error of Gaussians on a scene, by fitting some of them: no table, and nothing is baked.

For some pairs of point and view, transport towards the three of the 92 views that are mixed for it is tabulated and
fitted by the code of a bake, with as many directions; the diffuse part has the order of a bake. What they make of
the light and its lamps is compared with the sum over texels that are the finer the less even the light is, and over
directions drawn from the BRDF (the balance heuristic, as in `engine.transport.gaussian.error`): lamps smaller
than any texel and lobes narrower than one are then seen as they are. Pairs are drawn by what they weigh, by
their share of the squares of the radiance, and of those of the glossy part, a third each, because a few at grazing
angles make most of the error. What neighbours do to each other in a bake, and mixing across triangles, is not in the
figure.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.core.directions import Vectors
from engine.core.one_thread import one_thread
from engine.light.gaussian_prefilter import gaussian_integral
from engine.planning.costs.cost_model import DIFFUSE_ORDER
from engine.planning.effects.estimates import Scenery
from engine.planning.effects.fine_light import FineLight, fine_light
from engine.planning.effects.radiance import coefficients
from engine.planning.effects.relative_error import relative_error
from engine.planning.effects.sample import Sample
from engine.planning.effects.simplified import lambertian
from engine.transport.baking.diffuse_specular import parts
from engine.transport.gaussian.error import part_of
from engine.transport.gaussian.fitting.fit import Fit, FitSettings, TransportSamples, fit_vertices
from engine.transport.gaussian.fitting.lobes import Lobes
from engine.transport.gaussian.fitting.views import nearest_views, view_directions
from engine.transport.gaussian.lighting import GaussianLight, lobe_radiance
from engine.transport.gaussian.samples import (
    GlossySurface,
    density_local,
    direct,
    gathered,
    on_threads,
    products,
)
from engine.transport.gaussian.transfer import GaussianTransport, SeenLobes, lobes_towards
from engine.transport.sh.basis import evaluate

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

#: Pairs that are fitted with one lobe, two and three; directions for each view, and directions drawn for each pair
#: beside the texels.
PAIRS, DIRECTIONS, DRAWN = (96, 48, 32), 128, 256

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
    pairs = _pairs(scene)
    if pairs.surface.material.glossy is None:
        return None
    single = _values(scene, 1)
    error = _error(pairs, single, margin=True)
    if lobes == 1:
        return error
    several = _values(scene, lobes)
    alone = _error(pairs, [value[: len(several[0])] for value in single], margin=False)
    return error * _error(pairs, several, margin=False) / alone if alone > 0.0 else error


@lru_cache(maxsize=6)
def _values(scene: Scenery, lobes: int) -> list[Array]:
    """The radiance of the first pairs by fitted lobes, weighed in two ways."""
    pairs, count = _pairs(scene), PAIRS[lobes - 1]
    with one_thread():
        fitted = fit_vertices(pairs.first(count), pairs.alone[:count], Fit.empty(1, lobes).lobes, FitSettings(lobes))
        return [
            np.maximum(pairs.diffuse[:count] + _glossy(pairs, each, count), 0.0)
            for each in (fitted.lobes, fitted.preserving())
        ]


def _error(pairs: _Pairs, values: Sequence[Array], *, margin: bool) -> float:
    """Error of the nearer of `values` (M, 3) at the first M pairs."""
    count = len(values[0])
    wanted, shares = pairs.wanted[:count, None], [each[:count] for each in pairs.shares]
    return min(relative_error(value[:, None], wanted, shares, margin=margin, least=MARGIN) for value in values)


@dataclass(frozen=True, eq=False)
class _Pairs:
    """M pairs, each as if its point were a vertex of a model of its own.

    Attributes
    ----------
    points : (M,) of the `sample`. views : (M, 3) in the world. shares : what each pair counts for, twice (M, 1).
    """

    sample: Sample
    points: Indices
    views: Vectors
    shares: tuple[Array, Array]
    surface: GlossySurface

    @property
    def alone(self) -> list[Indices]:
        """No neighbours that are done."""
        return [np.zeros(0, np.int64)] * len(self.points)

    @cached_property
    def light(self) -> FineLight:
        return fine_light(self.sample.light)

    @cached_property
    def samples(self) -> TransportSamples:
        """Transport towards the views that are mixed for the pair's own; nothing towards the others."""
        asked = nearest_views(self.views)[0]

        def of_pair(pair: int) -> Any:
            wanted = np.zeros(len(view_directions()), np.bool_)
            wanted[asked[pair]] = True
            wanted &= view_directions() @ self.surface.frames[pair, :, 2] > 0.0
            return wanted, direct(self.surface, pair, view_directions()[wanted], DIRECTIONS)

        return gathered(on_threads(of_pair, np.arange(len(self.points))))

    def first(self, count: int) -> TransportSamples:
        """Transport of the first pairs alone."""
        every = self.samples
        start = every.start[: count * len(view_directions()) + 1]
        end = int(start[-1])
        return TransportSamples(start, every.direction[:end], every.value[:end], every.area[:end])

    @cached_property
    def both(self) -> tuple[Array, Array]:
        """(M, 3) radiance, and that of the diffuse part at the order of a bake."""
        towards = evaluate(DIFFUSE_ORDER, self.light.direction) @ coefficients(self.sample.light)[: DIFFUSE_ORDER**2]
        found = on_threads(lambda pair: _summed(self, pair, towards), np.arange(len(self.points)))
        whole, diffuse = zip(*found, strict=True)
        return np.array(whole), np.array(diffuse)

    @property
    def wanted(self) -> Array:
        return self.both[0]

    @property
    def diffuse(self) -> Array:
        return self.both[1]


@lru_cache(maxsize=2)
def _pairs(scene: Scenery) -> _Pairs:
    """The pairs of a scene that are looked at; the first of them are as evenly spread as all."""
    sample = scene.sample
    weight = sample.shares[0]
    chance = _chance(scene, weight)
    reached = np.cumsum(chance.ravel())
    drawn = np.searchsorted(reached, (np.arange(PAIRS[0]) + 1.0) * GOLDEN % 1.0 * reached[-1])
    points, view = np.divmod(np.minimum(drawn, reached.size - 1), weight.shape[1])
    counts = [(each[points, view] / chance[points, view])[:, None] for each in sample.shares]
    views = np.einsum("nij,nj->ni", sample.frames[points], sample.views[points, view])
    return _Pairs(sample, points, views, (counts[0], counts[1]), _surface(scene, points))


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


def _summed(pairs: _Pairs, pair: int, towards: Array) -> tuple[Array, Array]:
    """(3,) the radiance of a pair, and what the diffuse part makes of light of low order, `towards` (T, 3)."""
    surface, light, frame = pairs.surface, pairs.light, pairs.surface.frames[pair]
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
    return whole + _of_lamps(pairs, pair), np.maximum(low, 0.0)


def _open(surface: GlossySurface, pair: int, direction: Vectors) -> NDArray[np.bool_]:
    if surface.of.free[pair]:
        return np.ones(len(direction), np.bool_)
    origin = np.broadcast_to(surface.of.origin[pair], direction.shape)
    return ~np.asarray(surface.of.caster.occluded(origin, direction))


def _of_lamps(pairs: _Pairs, pair: int) -> Array:
    """(3,) the radiance of a pair by lamps."""
    sample, point, frame = pairs.sample, pairs.points[pair], pairs.surface.frames[pair]
    lit = np.flatnonzero(sample.lamp_lit[point])
    wi = sample.lamp_direction[lit] @ frame
    if not lit.size:
        return np.zeros(3)
    wo = np.broadcast_to(pairs.views[pair] @ frame, wi.shape)
    value = pairs.surface.material_at(pair).whole.f(wi, wo) * np.maximum(wi[:, 2:], 0.0)
    return np.asarray((value * sample.lamp_irradiance[lit]).sum(axis=0))


def _glossy(pairs: _Pairs, lobes: Lobes, count: int) -> Array:
    """(M, 3) what lobes of the first pairs make of the light."""
    mesh = part_of(pairs.surface.mesh, np.arange(count))
    transport = GaussianTransport(mesh, count, 0.0, (lobes,), None)
    seen = lobes_towards(transport, pairs.views[:count])
    lamps = GaussianLight(lamps=pairs.sample.light.lamps)
    value = lobe_radiance(lamps, seen.energy, seen.mean, seen.sigma)
    for pair in range(count):
        value[pair] += _under(pairs.light, seen, pair)
    return value


def _under(light: FineLight, seen: SeenLobes, pair: int) -> Array:
    """(3,) of the lobes of a pair; each is made wider by what a texel is wide, as if that were a Gaussian."""
    sigma = seen.sigma[pair]
    square = sigma[:, None] ** 2 + light.area / 12.0
    height = np.exp((seen.mean[pair] @ light.direction.T - 1.0) / square) / gaussian_integral(np.sqrt(square))
    return np.asarray(np.einsum("kt,tc,kc->c", height, light.incident, seen.energy[pair]))
