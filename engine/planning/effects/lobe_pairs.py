"""Pairs of a point and a view: their transport tabulated and fitted as in a bake, and their radiance summed exactly.

Each point is as if it were a vertex of a model of its own. The exact radiance is a sum over texels that are the finer
the less even the light is, and over directions drawn from the BRDF (the balance heuristic, as in
`engine.transport.gaussian.error`): lamps smaller than any texel and lobes narrower than one are then seen as they are.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.core.directions import Vectors
from engine.core.one_thread import one_thread
from engine.light.gaussian_prefilter import gaussian_integral
from engine.light.lamps import lights_of_all
from engine.planning.costs.cost_model import DIFFUSE_ORDER
from engine.planning.effects.fine_light import FineLight, fine_light
from engine.planning.effects.radiance import coefficients
from engine.planning.effects.sample import Light
from engine.transport.gaussian.error import part_of
from engine.transport.gaussian.fitting.fit import Fit, FitSettings, TransportSamples, fit_vertices
from engine.transport.gaussian.fitting.lobes import Lobes
from engine.transport.gaussian.fitting.views import nearest_views, view_directions
from engine.transport.gaussian.lighting import GaussianLight, lobe_radiance
from engine.transport.gaussian.samples import GlossySurface, density_local, direct, gather, on_threads, products
from engine.transport.gaussian.transfer import GaussianTransport, SeenLobes, lobes_towards
from engine.transport.sh.basis import evaluate

Array = NDArray[np.float64]

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
