"""Gaussian transport in memory for the figures on it, and its images."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from engine.brdf.brdf import brdf_from_text
from engine.brdf.models.diffuse import Lambert
from engine.core.steps import Steps, part
from engine.figures.figure import Image, Settings, ShownRow, camera_of, compare_with, error_of, reference_of
from engine.geometry.camera import Camera
from engine.geometry.mesh import Mesh
from engine.geometry.shapes import grid_mesh, shape
from engine.light.environment import EnvironmentMap
from engine.render.reference import ReferenceImage
from engine.render.transported import image_of
from engine.scene.scene import Scene
from engine.transport.baking.held_visibility import hold_visibility
from engine.transport.gaussian.bake import BakeSettings
from engine.transport.gaussian.diffuse import DiffuseTransfer, rows_of_all
from engine.transport.gaussian.fitting.fit import Fit, fit
from engine.transport.gaussian.fitting.lobes import Lobes
from engine.transport.gaussian.samples import GlossySurface, direct_samples, glossy_surface
from engine.transport.gaussian.transfer import GaussianTransport
from engine.transport.relight import relight_gaussians
from engine.transport.sh.brdf_table import lambert_table
from engine.transport.sh.transfer import ShTransport

#: Order of the diffuse part's spherical harmonics, edge of the cube maps its visibility is counted over, and parts of a
#: texel.
ORDER, EDGE, FINE = 5, 64, 4


@dataclass(frozen=True, eq=False)
class Fitted:
    """Lobes of a surface by either way to weigh, and the rows of its diffuse part."""

    surface: GlossySurface
    fit: Fit
    diffuse: ShTransport

    def transport(self, lobes: Lobes) -> GaussianTransport:
        """Transport that the mode draws, of `fit.lobes` or `fit.preserving()`."""
        surface = self.surface
        grazing = surface.material.diffuse.grazing
        return GaussianTransport(surface.mesh, surface.ground_vertex, 0.0, (lobes,), self.diffuse, "", grazing)


def coarse_knot(down: int, across: int) -> Mesh:
    """The built-in torus knot with every `down`-th ring of its vertices around and every `across`-th along."""
    whole = shape("torus-knot")
    rows = 65
    columns = len(whole.positions) // rows
    grids = (
        values.reshape(rows, columns, -1)[::down, ::across].astype(np.float64)
        for values in (whole.positions, whole.normals, whole.uv)
    )
    return grid_mesh("torus-knot", *grids)


def without_shadows(surface: GlossySurface) -> GlossySurface:
    """The same surface as if each vertex saw its whole hemisphere."""
    free = np.ones(len(surface.of.free), np.bool_)
    return replace(surface, of=replace(surface.of, free=free))


def fit_lobes(surface: GlossySurface, lobes: int, samples: int) -> Steps[Fitted]:
    """Direct transport of `surface`, so many Gaussians for each vertex and view, from so many directions."""
    settings = BakeSettings(lobes=lobes).fit
    surface = replace(surface, seen=(yield from part(hold_visibility(surface.of, EDGE, FINE), 0.0, 0.1)))
    steps = fit(surface.mesh, lambda vertices: direct_samples(surface, vertices, samples), settings)
    found = yield from part(steps, 0.1, 0.9)
    diffuse = DiffuseTransfer(surface, ORDER, EDGE, FINE)
    rows = yield from part(rows_of_all(diffuse), 0.9, 1.0)
    red, green, blue = diffuse.albedo
    table = lambert_table(Lambert((red, green, blue)), ORDER)
    transport = ShTransport(surface.mesh, surface.ground_vertex, True, 0.0, table, False, rows)
    return Fitted(surface, found, transport)


def nearer_image(
    own: Fitted, environment: EnvironmentMap, camera: Camera, size: tuple[int, int], expected: ReferenceImage
) -> Steps[tuple[Image, str]]:
    """The image with those weights, of least squares or with all energy, that have the lower error, and their name.

    `lightarc bake` chooses likewise, and judges by some vertices.
    """
    images = {}
    for number, (name, lobes) in enumerate((("plain", own.fit.lobes), ("preserving", own.fit.preserving()))):
        relit = relight_gaussians(own.transport(lobes), environment)
        steps = image_of(relit, camera, size)
        images[name] = (yield from part(steps, 0.5 * number, 0.5 * number + 0.5)).image
    best = min(images, key=lambda name: error_of(images[name], expected).rmse_rel)
    return images[best], best


@dataclass(frozen=True)
class Way:
    """One way to draw a glossy model: what is said of it, its parameters, its lobes, and whether with shadows."""

    words: str
    parameters: Mapping[str, Any]
    lobes: int = 1
    shadows: bool = True


def compare_ways(
    mesh: Mesh, brdf: str, environment: EnvironmentMap, settings: Settings, ways: Sequence[Way]
) -> Steps[ShownRow]:
    """An image by each way, with its error against the reference, which is the last."""
    reflectance, camera = brdf_from_text(brdf), camera_of(mesh, settings.size)
    scene = Scene(mesh, camera, reflectance, environment=environment)
    expected = yield from part(reference_of(scene, settings), 0.0, 0.1)
    surface = glossy_surface(mesh, reflectance)
    # a fit takes about as long again for each lobe
    ends = 0.1 + 0.9 * np.cumsum([0, *(way.lobes for way in ways)]) / sum(way.lobes for way in ways)
    panels = []
    for way, start, stop in zip(ways, ends[:-1], ends[1:], strict=True):
        seen = surface if way.shadows else without_shadows(surface)
        own = yield from part(fit_lobes(seen, way.lobes, settings.directions), start, stop - 0.05)
        drawing = nearer_image(own, environment, camera, settings.size, expected)
        image, weights = yield from part(drawing, stop - 0.05, stop)
        flips = own.fit.health.figures.get("flipped_pairs", 0.0)
        parameters = {"lobes": way.lobes, **way.parameters, "weights": weights, "flipped_pairs": flips}
        panels.append((way.words, parameters, image))
    return ShownRow(brdf, compare_with(panels, expected, "reference"))
