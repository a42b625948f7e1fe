"""Gaussian transport in memory for the figures on it, and its pictures."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from engine.brdf.diffuse import Lambert
from engine.camera import Camera
from engine.environment import EnvironmentMap
from engine.figures.figure import Picture, error_of
from engine.mesh import Mesh
from engine.render.reference import ReferencePicture
from engine.render.transported import picture_of
from engine.shapes import grid_mesh, shape
from engine.steps import Step, Steps, part
from engine.transport.gaussian import GaussianTransport
from engine.transport.gaussian_fit import Fit, FitSettings, fit
from engine.transport.gaussian_matt import Matt
from engine.transport.gaussian_samples import GlossySurface, direct_samples
from engine.transport.lit import lit_gaussians
from engine.transport.sh_table import lambert_table
from engine.transport.sh_transfer import ShTransport
from engine.transport.spherical_gaussian import Lobes

#: Order of the matt part's harmonics, edge of the cube maps its visibility is counted over, and parts of a texel.
ORDER, EDGE, FINE = 5, 32, 4

#: Vertices whose matt part is found at once.
CHUNK = 256


@dataclass(frozen=True, eq=False)
class Fitted:
    """Lobes of a surface by either way to weigh, and the rows of its matt part."""

    surface: GlossySurface
    fit: Fit
    matt: ShTransport

    def transport(self, lobes: Lobes) -> GaussianTransport:
        """What the mode draws, of `fit.lobes` or `fit.preserving()`."""
        surface = self.surface
        grazing = surface.material.matt.grazing
        return GaussianTransport(surface.mesh, surface.ground_vertex, 0.0, (lobes,), self.matt, "", grazing)


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


def fitted(surface: GlossySurface, lobes: int, samples: int) -> Steps[Fitted]:
    """Direct transport of `surface`, so many Gaussians for each vertex and view, from so many directions."""
    settings = FitSettings(lobes=lobes)
    steps = fit(surface.mesh, lambda vertices: direct_samples(surface, vertices, samples), settings)
    found = yield from part(steps, 0.0, 0.9)
    matt, rows = Matt(surface, ORDER, EDGE, FINE), []
    for start in range(0, len(surface.mesh.positions), CHUNK):
        rows.append(matt.rows(np.arange(start, min(start + CHUNK, len(surface.mesh.positions)))))
        yield Step(0.9 + 0.1 * min(1.0, (start + CHUNK) / len(surface.mesh.positions)), "the matt part")
    red, green, blue = matt.albedo
    table = lambert_table(Lambert((red, green, blue)), ORDER)
    transport = ShTransport(
        surface.mesh, surface.ground_vertex, True, 0.0, table, False, np.concatenate(rows).astype(np.float32)
    )
    return Fitted(surface, found, transport)


def nearer_picture(
    own: Fitted, environment: EnvironmentMap, camera: Camera, size: tuple[int, int], truth: ReferencePicture
) -> Steps[tuple[Picture, dict[str, Any]]]:
    """The picture with those weights, of least squares or with all energy, that have the lower error, and their name.

    `lightarc bake` chooses likewise, and judges by some vertices.
    """
    pictures = {}
    for number, (name, lobes) in enumerate((("plain", own.fit.lobes), ("preserving", own.fit.preserving()))):
        lit = lit_gaussians(own.transport(lobes), environment)
        steps = picture_of(lit, camera, size)
        pictures[name] = (yield from part(steps, 0.5 * number, 0.5 * number + 0.5)).picture
    best = min(pictures, key=lambda name: error_of(pictures[name], truth).rmse_rel)
    return pictures[best], {"weights": best}
