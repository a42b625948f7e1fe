"""The diffuse part beside lobes: vectors of spherical harmonics, with shadows, and light between parts of the model.

Green2006 Sec. 4.1, give the diffuse part to SH of fifth order.
A vertex has t_j = 1/π ∫ V(s) g(cos θ) cos θ y_j(s) ds, with g the gain of `diffuse_part`; the gain to the viewer is
the renderer's. Where colours differ from vertex to vertex, or light comes by way of the model, the vector of each
channel holds the colour itself; else one vector serves all channels and the colour stands beside it.

For interreflection every surface counts as diffuse, with its albedo under even light, as in `sh_bake`.

Bound by rays: some 3,000 for each vertex at an edge of 32, and for each bounce `GATHER`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.core.cached import cached_property
from engine.core.directions import surface_direction
from engine.core.one_thread import one_thread
from engine.core.steps import Step, Steps
from engine.light.cube_map import cube_directions
from engine.transport.baking.diffuse_specular import DiffusePart
from engine.transport.baking.held_visibility import merge_texels
from engine.transport.baking.visibility import visibility_shares
from engine.transport.gaussian.samples import GlossySurface, Material, draw_local, products
from engine.transport.sh.bake import default_edge
from engine.transport.sh.interreflection import Surroundings, gather, reflections
from engine.transport.sh.transfer import diffuse_vectors, texel_basis

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

#: Rays from each vertex for a bounce, and bounces.
GATHER, BOUNCES = 512, 3

#: Vertices whose bounces are followed at once, and whose rows are found between two steps.
BLOCK, CHUNK = 512, 256


@dataclass(frozen=True, eq=False)
class DiffuseTransfer:
    """The diffuse part of a surface, ready for its rows.

    Attributes
    ----------
    order : of the spherical harmonics.
    edge, fine : cube map that visibility is counted over, and parts of its texels, as for `sh.bake.BakeSettings`.
    sent : what each vertex sends to the others, from `send_light`; None without light between parts of the model.
    """

    surface: GlossySurface
    order: int
    edge: int
    fine: int
    sent: NDArray[np.float32] | None = None

    @property
    def channels(self) -> int:
        """3 where rows hold colours, else 1."""
        return 1 if self.sent is None and self.surface.is_uniform else 3

    @property
    def albedo(self) -> tuple[float, float, float]:
        """Factor of the rows of the model; white if they hold the colour."""
        return self.surface.material.diffuse.colour if self.channels == 1 else (1.0, 1.0, 1.0)

    @property
    def grazing(self) -> bool:
        return self.surface.material.diffuse.grazing

    @cached_property
    def colours(self) -> Floats:
        """(ground_vertex, 3) of the diffuse part at each vertex."""
        kind, made = self.surface.exact
        return np.array([diffuse.colour for diffuse in made])[kind]

    def rows(self, vertices: Indices) -> NDArray[np.float32]:
        """(B, C, order²) of `vertices`, of the model and of the ground."""
        surface, of = self.surface, self.surface.of
        counts, edge, full = self._counts(vertices)
        model = vertices < surface.ground_vertex
        own = np.empty((len(vertices), self.order**2), np.float32)
        free = of.free[vertices]
        with one_thread():
            plain = ~model if self.grazing else np.ones(len(vertices), bool)
            own[plain] = diffuse_vectors(
                *(counts[plain], full, edge, self.order, of.normal[vertices[plain]], free[plain])
            )
            own[~plain] = self._fading(counts[~plain], full, edge, vertices[~plain])
        rows = np.repeat(own[:, None], self.channels, axis=1)
        if self.sent is not None:
            around = _around(surface, self.order)
            share = np.where(model, mean_gain(surface.material.diffuse), 1.0).astype(np.float32)
            rows += gather(around, vertices, self.sent) * share[:, None, None]
        if self.channels == 3:
            rows[model] *= self.colours[vertices[model]].astype(np.float32)[..., None]
        return rows

    def _counts(self, vertices: Indices) -> tuple[NDArray[np.uint8], int, int]:
        """Visible parts of texels, the edge of the cube map, no larger than the order needs, and parts of a texel."""
        seen, edge, full = self.surface.seen, self.edge, self.fine**2
        if seen is None or (seen.edge, seen.fine) != (edge, self.fine):
            found = [some for _, some in visibility_shares(self.surface.of, edge, self.fine, vertices)]
            return np.concatenate(found), edge, full
        counts = seen.counts(vertices)
        while edge % 2 == 0 and edge > default_edge(self.order) and 4 * full < 256:
            counts, edge, full = merge_texels(counts, edge), edge // 2, 4 * full
        return counts, edge, full

    def _fading(self, counts: NDArray[np.uint8], full: int, edge: int, vertices: Indices) -> NDArray[np.float32]:
        """(B, order²) of a diffuse part whose gain falls towards grazing."""
        directions = cube_directions(edge).reshape(-1, 3)
        cosine = np.maximum(self.surface.of.normal[vertices] @ directions.T, 0.0)
        gain = DiffusePart((1.0, 1.0, 1.0), grazing=True).gain(cosine)
        shares = (counts * (gain * cosine / (np.pi * full))).astype(np.float32)
        return np.asarray(shares @ texel_basis(edge, self.order), np.float32)


def rows_of_all(diffuse: DiffuseTransfer) -> Steps[NDArray[np.float32]]:
    """(V, C, order²) the rows of all vertices, of the model and of the ground."""
    count, found = len(diffuse.surface.mesh.positions), []
    for start in range(0, count, CHUNK):
        stop = min(start + CHUNK, count)
        found.append(diffuse.rows(np.arange(start, stop)))
        yield Step(stop / count, "baking the diffuse part")
    return np.concatenate(found)


def _around(surface: GlossySurface, order: int) -> Surroundings:
    return Surroundings(surface.mesh.positions, surface.mesh.faces, surface.of, order, GATHER)


def mean_gain(diffuse: DiffusePart) -> float:
    """The mean of the gain over cosine-weighted directions, 2 ∫ g(c) c dc."""
    at, share = np.polynomial.legendre.leggauss(8)
    cosine = 0.5 * (at + 1.0)
    return float(share @ (diffuse.gain(cosine) * cosine))


def send_light(diffuse: DiffuseTransfer, cluster: str | None = None) -> Steps[NDArray[np.float32]]:
    """(V, 3, order²) what each vertex sends to every side after up to `BOUNCES` reflections, here or by a `cluster`."""
    surface = diffuse.surface
    kind, made = surface.coarse
    albedo = np.full((len(surface.mesh.positions), 3), surface.ground_albedo, np.float32)
    albedo[: surface.ground_vertex] = np.array([even_albedo(material) for material in made])[kind]
    bounds = np.unique(np.append(np.arange(0, len(albedo), BLOCK), len(albedo)))
    return (yield from reflections(_around(surface, diffuse.order), BOUNCES, albedo, bounds, cluster))


def even_albedo(material: Material) -> Floats:
    """(3,) the share of even light from all sides that a BRDF sends back, at most 1."""
    count = 16
    theta, phi = np.arcsin(np.sqrt((np.arange(count) + 0.5) / count)), 2.4 * np.arange(count)
    wo = surface_direction(theta, phi)
    wi, weight = draw_local(material, wo, 256)
    value = products(material.glossy, wi.reshape(-1, 3), np.repeat(wo, 256, axis=0)).reshape(wi.shape)
    glossy = np.einsum("ms,msc->c", weight, value) / count
    diffuse = np.asarray(material.diffuse.colour) * mean_gain(material.diffuse) ** 2
    return np.clip(glossy + diffuse, 0.0, 1.0)
