"""Lobes that were not fitted to anything, for tests of what is made of them."""

from __future__ import annotations

import numpy as np

from engine.brdf.models.diffuse import Lambert
from engine.core.directions import normalize
from engine.geometry.ground import Ground, with_ground
from engine.geometry.mesh import Mesh
from engine.transport.gaussian.fitting.lobes import Lobes
from engine.transport.gaussian.fitting.views import VIEWS, view_directions
from engine.transport.gaussian.transfer import GaussianTransport
from engine.transport.sh.brdf_table import lambert_table
from engine.transport.sh.transfer import ShTransport


def mirror_lobes(normals: np.ndarray, sigma: float = 0.2, weight: float = 1.0) -> Lobes:
    """One lobe about the mirrored view at every vertex; weight 0 for views below the horizon, whose means go on."""
    views = view_directions()
    cosine = normals @ views.T
    mean = 2.0 * cosine[..., None] * normals[:, None] - views
    weights = np.where(cosine > 0.0, weight, 0.0)[..., None, None] * np.array([1.0, 0.7, 0.4])
    widths = np.full((len(normals), VIEWS, 1), sigma)
    return Lobes(*(np.ascontiguousarray(array, np.float32) for array in (weights, mean[:, :, None], widths)))


def random_lobes(vertices: int, count: int, seed: int = 0, narrow: float = 0.05, wide: float = 0.8) -> Lobes:
    """Anything at every vertex, view and lobe; a third of the weights 0."""
    rng = np.random.default_rng(seed)
    shape = (vertices, VIEWS, count)
    weight = rng.random((*shape, 3)) * (rng.random((*shape, 1)) > 1 / 3)
    sigma = np.exp(rng.uniform(np.log(narrow), np.log(wide), shape))
    return Lobes(*(array.astype(np.float32) for array in (weight, normalize(rng.normal(size=(*shape, 3))), sigma)))


def vectors(mesh: Mesh, first: int, albedo: float, seed: int = 1) -> ShTransport:
    """A diffuse part of order 5 whose vectors are about those of open vertices."""
    rng = np.random.default_rng(seed)
    rows = (0.05 * rng.normal(size=(len(mesh.positions), 1, 25))).astype(np.float32)
    rows[..., 0] += 0.3
    return ShTransport(mesh, first, True, albedo, lambert_table(Lambert((0.5, 0.4, 0.3)), 5), False, rows)


def transport_of(
    mesh: Mesh, *components: Lobes, ground: Ground | None = None, diffuse: bool = False, grazing: bool = False
) -> GaussianTransport:
    surface, first = (with_ground(mesh, ground)[0] if ground else mesh), len(mesh.positions)
    albedo = ground.albedo if ground else 0.0
    part = vectors(surface, first, albedo) if diffuse or ground else None
    return GaussianTransport(surface, first, albedo, components, part, "synthetic", grazing)
