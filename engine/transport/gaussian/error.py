"""Error of lobes in radiance against the sum over all texels, for both ways to weight them.

What is compared stands in `radiance_error`; here it is direct light, for the glossy part alone and for the whole. The
error holds the distance of the fit and what mixing between the 92 views adds. Lobes fitted by least squares lose
energy; scaled to the energy of the transport they are further from it. Which has the lower error depends on the light:
`GaussianError.better` says.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from engine.core.directions import Vectors, normalize
from engine.core.steps import Step, Steps
from engine.geometry.mesh import Mesh
from engine.light.cube_map import CubeMap, cube_directions, cube_solid_angles, texel_numbers
from engine.light.gaussian_prefilter import gaussian_integral, prefilter
from engine.transport.baking.radiance_error import Deviation
from engine.transport.baking.visibility import visibility_shares
from engine.transport.gaussian.diffuse import DiffuseTransfer
from engine.transport.gaussian.fitting.fit import Fit
from engine.transport.gaussian.fitting.lobes import NARROWEST, Lobes
from engine.transport.gaussian.lighting import GaussianLight, levels_for, lobe_radiance
from engine.transport.gaussian.samples import GlossySurface, density_local, direct, products
from engine.transport.gaussian.transfer import GaussianTransport, lobes_towards
from engine.transport.sh.lighting import project

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

Weighting = Literal["plain", "preserving"]

#: Into so many parts, squared, a texel is cut where visibility changes.
FINE = 4

#: Directions drawn for each pair of vertex and view, beside the texels.
DRAWN = 256


@dataclass(frozen=True)
class GaussianError:
    """Errors of the radiance relative to it, root mean square, with the weights of least squares and with all energy.

    `plain_rmse_rel`, `preserving_rmse_rel` of the whole radiance, `plain_mean_rel` and so on how much brighter it is in
    the mean, `glossy_plain_rmse_rel` and so on of the glossy part alone; of so many `pairs` of vertex and view.
    """

    plain_rmse_rel: float
    preserving_rmse_rel: float
    plain_mean_rel: float
    preserving_mean_rel: float
    glossy_plain_rmse_rel: float
    glossy_preserving_rmse_rel: float
    pairs: int

    @property
    def better(self) -> Weighting:
        return "plain" if self.plain_rmse_rel <= self.preserving_rmse_rel else "preserving"

    def of(self, weighting: Weighting) -> float:
        """The error of the whole radiance."""
        return self.plain_rmse_rel if weighting == "plain" else self.preserving_rmse_rel

    def mean_of(self, weighting: Weighting) -> float:
        """Relative excess of the mean of the whole radiance."""
        return self.plain_mean_rel if weighting == "plain" else self.preserving_mean_rel


@dataclass(frozen=True, eq=False)
class Known:
    """Vertices (B,) whose lobes and diffuse rows are at hand."""

    vertices: Indices
    fit: Fit
    rows: NDArray[np.float32]


def gaussian_error(
    surface: GlossySurface, diffuse: DiffuseTransfer, known: Known, cube: CubeMap, *, views: int = 20, seed: int = 1
) -> Steps[GaussianError]:
    """The error of lobes of some vertices of the model under a cube map, whose edge visibility is counted over too."""
    towards = normalize(np.random.default_rng(seed).standard_normal((views, 3)))
    chosen = known.vertices
    yield Step(0.0, "casting rays")
    shares = visibility_shares(surface.of, cube.edge, FINE, chosen)
    visible = np.concatenate([counts for _, counts in shares])
    plain, preserving = known.fit.lobes, known.fit.preserving()
    found = [_glossy(surface, chosen, lobes, cube, towards) for lobes in (plain, preserving)]
    light = project(cube, diffuse.order)
    flat = np.einsum("bcj,jc->bc", np.broadcast_to(known.rows, (len(chosen), 3, diffuse.order**2)), light)
    flat *= np.asarray(diffuse.albedo)
    incident = cube.radiance.reshape(-1, 3).astype(np.float64)
    deviations = [[Deviation(), Deviation()], [Deviation(), Deviation()]]  # glossy and whole, plain and preserving
    for number, vertex in enumerate(chosen):
        frame = surface.frames[vertex]
        cosine = towards @ frame[:, 2]
        seen = np.flatnonzero(cosine > 0.0)
        exact = _exact(surface, int(vertex), visible[number] / FINE**2, incident, towards[seen])
        gain = surface.material.diffuse.gain(cosine[seen])[:, None]
        flats = np.maximum(flat[number] * gain, 0.0)
        for row, value in enumerate((exact[0], exact[0] + exact[1])):
            for deviation, each in zip(deviations[row], found, strict=True):
                deviation.add(cosine[seen], each[seen, number] + row * flats, value)
        yield Step((number + 1) / len(chosen), "comparing with the sum over all texels")
    (glossy_plain, glossy_preserving), (whole_plain, whole_preserving) = deviations
    return GaussianError(
        whole_plain.rmse_rel,
        whole_preserving.rmse_rel,
        whole_plain.mean_rel,
        whole_preserving.mean_rel,
        glossy_plain.rmse_rel,
        glossy_preserving.rmse_rel,
        whole_plain.pairs,
    )


def _glossy(surface: GlossySurface, chosen: Indices, lobes: Lobes, cube: CubeMap, towards: Vectors) -> Floats:
    """(views, B, 3) what lobes make of the light."""
    transport = GaussianTransport(part_of(surface.mesh, chosen), len(chosen), 0.0, (lobes,), None)
    light, values = _light((lobes,), cube), []
    for wo in towards:
        seen = lobes_towards(transport, np.broadcast_to(wo, (len(chosen), 3)))
        values.append(lobe_radiance(light, seen.energy, seen.mean, seen.sigma))
    return np.array(values)


def _light(components: tuple[Lobes, ...], cube: CubeMap) -> GaussianLight:
    """A cube map as lobes see it, in levels that are not below its own texels."""
    widths = [width for width in levels_for(components).sigma if width >= _least(cube.edge)]
    return GaussianLight(prefilter(cube, np.array(widths or [_least(cube.edge)])))


def change(lobes: Lobes, other: Lobes, cube: CubeMap, *, most: int = 400) -> float:
    """Difference in radiance between `other` and `lobes` under a cube map, towards the 92 views of up to `most`
    vertices: root mean square of the difference over that of the radiance."""
    light, some = _light((lobes,), cube), slice(None, None, max(1, len(lobes) // most))
    values = []
    for each in (lobes, other):
        weight, mean, sigma = (
            array[some].reshape(-1, *array.shape[2:]) for array in (each.weight, each.mean, each.sigma)
        )
        values.append(lobe_radiance(light, weight * gaussian_integral(sigma)[..., None], mean, sigma))
    one, two = values
    total = float((one**2).sum())
    return math.sqrt(float(((one - two) ** 2).sum()) / total) if total > 0.0 else 0.0


def _least(edge: int) -> float:
    """Half a texel of a cube map of that edge in rad."""
    return NARROWEST * 512 / edge


def part_of(mesh: Mesh, vertices: Indices) -> Mesh:
    """A mesh with some of the vertices of another, and no surface to speak of."""
    return replace(
        mesh,
        positions=mesh.positions[vertices],
        normals=mesh.normals[vertices],
        uv=mesh.uv[vertices],
        faces=np.zeros((1, 3), np.int32),
        part=None,
        colours=None,
    )


def _exact(
    surface: GlossySurface, vertex: int, visible: Floats, light: Floats, views: Vectors
) -> tuple[Floats, Floats]:
    """(views, 3) the sums with the glossy and with the diffuse part themselves, of `light` (6 N², 3).

    Highlights narrower than a texel fall between their centres. So directions that are drawn from the BRDF are
    summed as well, and each counts by how many of both kinds there are (the balance heuristic).
    """
    frame, material = surface.frames[vertex], surface.material_at(vertex)
    edge = int(math.sqrt(len(light) // 6))
    area = np.tile(cube_solid_angles(edge).reshape(-1), 6)
    wi = cube_directions(edge).reshape(-1, 3) @ frame
    lit = np.flatnonzero((wi[:, 2] > 0.0) & (visible > 0.0))
    wi, area, incident = wi[lit], area[lit], light[lit] * visible[lit, None]
    glossy, diffuse = np.zeros((len(views), 3)), np.zeros((len(views), 3))
    drawn = direct(surface, vertex, views, DRAWN)
    for number, wo in enumerate(views @ frame):
        with surface.guard:
            value = products(material.glossy, wi, np.broadcast_to(wo, wi.shape))
            density = density_local(material, wi, np.broadcast_to(wo, wi.shape), DRAWN)
        glossy[number] = (value * incident / (1.0 / area + density)[:, None]).sum(axis=0)
        texel = texel_numbers(drawn.direction[number], edge)
        weight = 1.0 / (1.0 / drawn.weight[number] + 1.0 / cube_solid_angles(edge).reshape(-1)[texel % (edge * edge)])
        glossy[number] += (drawn.value[number] * light[texel] * weight[:, None]).sum(axis=0)
        diffuse[number] = (material.diffuse.f(wi, wo) * wi[:, 2:] * incident * area[:, None]).sum(axis=0)
    return glossy, diffuse
