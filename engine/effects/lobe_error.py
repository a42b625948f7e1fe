"""How far Gaussians would be from the truth on a scene, by fitting some of them: no table, and nothing is baked.

At `POINTS` points of the finer sample, transport towards the views of the 92 that are mixed for the sample's own views
is tabulated and fitted by the code of a bake, with as many directions; the matt part is taken at the order of a bake.
What they make of the light and its lamps is compared with the sum over the texels, as every other method is. Lobes
narrower than its texels (`engine.effects.sample.FINE`) are therefore judged too badly, lamps smaller than them too
well: half of what a bake finds under a finer map. What neighbours do to each other in a bake, and mixing across
triangles, is not in the figure.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.effects.cost_model import MATT_ORDER
from engine.effects.estimates import Scenery, relative_error
from engine.effects.radiance import coefficients
from engine.effects.sample import Sample
from engine.one_thread import one_thread
from engine.prefilter import prefiltered
from engine.transport.gaussian import GaussianTransport, lobes_towards
from engine.transport.gaussian_error import part_of
from engine.transport.gaussian_fit import Fit, FitSettings, TransportSamples, fit_vertices
from engine.transport.gaussian_lighting import GaussianLight, levels_for, lobe_radiance
from engine.transport.gaussian_samples import GlossySurface, direct, gathered, on_threads
from engine.transport.sh import evaluate
from engine.transport.spherical_gaussian import NARROWEST, Lobes
from engine.transport.view_directions import nearest_views, view_directions

Array = NDArray[np.float64]

#: Points that are fitted, and directions for each view.
POINTS, DIRECTIONS = 32, 128


@lru_cache(maxsize=24)
def lobe_error(scene: Scenery, lobes: int) -> float | None:
    """The error of `lobes` Gaussians for each vertex and view, by the better of the two ways to weigh them.

    None where nothing about the reflectance is glossy.
    """
    rows = np.unique(np.linspace(0, len(scene.fine.vertices) - 1, POINTS).astype(np.int64))
    surface = _surface(scene.fine, scene.brdf, rows)
    if surface.material.glossy is None:
        return None
    views = np.einsum("nij,nkj->nki", surface.frames, scene.fine.views[rows])
    with one_thread():
        matt = _matt(scene.fine, surface, rows)
        fitted = _fitted(surface, views, lobes)
        wanted, seen = scene.methods.full[rows], scene.fine.seen[rows]
        found = [matt + _glossy(scene.fine, surface, each, views) for each in (fitted.lobes, fitted.preserving())]
    return min(relative_error(np.maximum(value, 0.0), wanted, seen) for value in found)


def _surface(sample: Sample, brdf: Any, rows: NDArray[np.int64]) -> GlossySurface:
    """The chosen points as if they were the vertices of the model."""
    vertices, of = sample.vertices[rows], sample.of
    some = replace(of, origin=of.origin[vertices], normal=of.normal[vertices], free=of.free[vertices])
    mesh = part_of(sample.surface, vertices)
    return GlossySurface(mesh, len(rows), 0.0, brdf, {}, some, sample.frames[rows])


def _fitted(surface: GlossySurface, views: Array, lobes: int) -> Fit:
    samples = _tabulated(surface, views)
    alone, around = Fit.empty(1, lobes).lobes, [np.zeros(0, np.int64)] * len(views)
    return fit_vertices(samples, around, alone, FitSettings(lobes=lobes))


def _tabulated(surface: GlossySurface, views: Array) -> TransportSamples:
    """Transport towards the views that are mixed for `views` (N, K, 3); nothing towards the others."""
    asked = nearest_views(views)[0]

    def of_point(point: int) -> Any:
        wanted = np.zeros(len(view_directions()), np.bool_)
        wanted[asked[point].reshape(-1)] = True
        wanted &= view_directions() @ surface.frames[point, :, 2] > 0.0
        return wanted, direct(surface, point, view_directions()[wanted], DIRECTIONS)

    return gathered(on_threads(of_point, np.arange(len(views))))


def _glossy(sample: Sample, surface: GlossySurface, lobes: Lobes, views: Array) -> Array:
    """(N, K, 3) what lobes make of the light."""
    transport = GaussianTransport(surface.mesh, len(views), 0.0, (lobes,), None)
    cube = sample.light.cube
    least = NARROWEST * 512 / cube.edge
    widths = [width for width in levels_for((lobes,)).sigma if width >= least] or [least]
    light = GaussianLight(prefiltered(cube, np.array(widths)), lamps=sample.light.lamps)
    values = []
    for wo in np.moveaxis(views, 1, 0):
        towards = lobes_towards(transport, wo)
        values.append(lobe_radiance(light, towards.energy, towards.mean, towards.sigma))
    return np.stack(values, axis=1)


def _matt(sample: Sample, surface: GlossySurface, rows: NDArray[np.int64]) -> Array:
    """(N, K, 3) the matt part under light of `MATT_ORDER`."""
    light = evaluate(MATT_ORDER, sample.texels.direction) @ coefficients(sample.light)[: MATT_ORDER**2]
    incident = light * sample.texels.area[:, None]
    part, views = surface.material.matt, sample.views[rows]
    values = np.zeros(views.shape)
    for number, frame in enumerate(surface.frames):
        cosine = sample.texels.direction @ frame[:, 2]
        gain = part.gain(cosine) * np.maximum(cosine, 0.0) * sample.visible[rows[number]]
        flat = np.asarray(part.colour) / math.pi * (gain @ incident)
        values[number] = part.gain(views[number, :, 2])[:, None] * np.maximum(flat, 0.0)
    return values
