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
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from engine.geometry.mesh import Mesh
from engine.planning.effects.between_vertices import Between, sum_lamps_between
from engine.planning.effects.estimates import Scenery
from engine.planning.effects.lobe_pairs import Pairs
from engine.planning.effects.mode_error import together
from engine.planning.effects.relative_error import relative_error
from engine.planning.effects.sample import by_worth
from engine.planning.effects.simplified import lambertian
from engine.transport.baking.diffuse_specular import parts
from engine.transport.gaussian.error import part_of
from engine.transport.gaussian.samples import GlossySurface
from engine.transport.gaussian.transfer import SeenLobes, mix

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
