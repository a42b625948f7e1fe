"""Light near a model that a surface reflects: the sums of `engine.render.direct`.

Two lobes have closed forms over the polygon of directions in which a light is seen: the cosine, and GGX's distribution
of facets, for D(h) cos θ_h is the cosine after the linear transformation diag(α_x, α_y, 1) of directions, exactly
(Heitz2016). A facet h reflects light from ω = 2 (h·o) h − o, so that the polygon of ω is mapped to one of h ∝ ω + o,
edge by edge in short steps, and nothing is fitted, whatever the width, the viewer and the shadowing term:

    ∫ ρ cos dω  = ρ̄ ∫ cos dω,           ∫ f cos dω = W̄ ∫ D cos θ_h dω_h,    W = F G₂ (h·o) / (cos θ_o cos θ_h),

with ρ what is diffuse. ρ̄ and W̄ are means over `POINTS` points of the light, weighted by the lobes, and what a narrow
lobe has between these points is taken at its middle: both factors change slowly, so that few points serve highlights of
every width. Polygons are cut at the horizon. A sphere is the disc of directions
in which it is seen, and discs are polygons of `CORNERS` corners and their own area. Lights that are seen very small are
their points alone.

What stands in the way is told by rays to the same points: an integral becomes smaller by the share of its sum over them
that is blocked.

Other BRDFs are summed over as many points of each light as the scene has `directions`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.brdf.brdf import Brdf
from engine.brdf.models.diffuse import Lambert
from engine.brdf.models.microfacet import Ggx, GgxAnisotropic, MetallicRoughness
from engine.brdf.models.multiple_scattering import SMOOTHEST, multiple_scattering, schlick_mean
from engine.core.directions import dot, normalize, world_from_tangent
from engine.core.kernels import scalar
from engine.light.near_lamps import NearLamp, near_lights
from engine.render.pbr import Texels
from engine.surface.normal_spread import ALIKE, spread_lobe

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

#: Whether a light reaches points, by their indices (M,), from unit directions (M, 3) towards it; bools (M,).
Reached = Callable[[NearLamp, Indices, Floats], NDArray[np.bool_]]

#: Points of a light over which slowly changing factors are averaged.
POINTS = 16

#: Corners of the polygon of a light, eight on each side of a rectangle; and of the part of the horizon that cuts it.
CORNERS, ON_HORIZON = 32, 8

#: Extent over distance below which a light is its points alone.
SMALL = 1e-3

#: The least cosine between a half vector and the normal that is divided by.
MIN_COSINE = 1e-6


@dataclass(frozen=True, eq=False)
class Facets:
    """Reflection by facets of GGX over a diffuse part, at N points.

    Attributes
    ----------
    diffuse : (N, 3) albedo. shields : facets take from the diffuse part what they reflect.
    f0 : (N, 3) reflectance of facets at normal incidence.
    alpha : (N, 2) widths along tangent and bitangent.
    correlated : Smith's term of both directions at once, else the product of two.
    again : share of light scattered again between facets.
    glossy : there are facets beside the diffuse part.
    roughness, spread : (N,) and (N, 3), of PBR maps whose normals differ within a point
        (`engine.surface.normal_spread`).
    length : (N,) factor on the cosine of what is diffuse.
    """

    diffuse: Floats
    f0: Floats
    alpha: Floats
    length: Floats
    shields: bool = True
    correlated: bool = False
    again: float = 0.0
    glossy: bool = True
    roughness: Floats | None = None
    spread: Floats | None = None

    def at(self, points: Indices) -> Facets:
        """Those at some of the points."""
        names = ("diffuse", "f0", "alpha", "length", *(("roughness", "spread") if self.spread is not None else ()))
        return replace(self, **{name: getattr(self, name)[points] for name in names})


def facets_of(brdf: Brdf, count: int) -> Facets | None:
    """The facets of a BRDF at `count` points; None for a BRDF that has no facets of GGX and is not diffuse alone."""

    def repeat(part: ArrayLike) -> Floats:
        return np.tile(np.asarray(part, np.float64), (count, 1))

    length = np.ones(count)
    if isinstance(brdf, Lambert):
        return Facets(repeat(brdf.albedo), repeat((0.0,) * 3), repeat((1.0, 1.0)), length, shields=False, glossy=False)
    if isinstance(brdf, MetallicRoughness) and brdf.coat_weight == 0.0 and not any(brdf.sheen_color):
        base, alpha = np.asarray(brdf.base_color), max(brdf.roughness, SMOOTHEST) ** 2
        diffuse, f0 = (1.0 - brdf.metallic) * base, 0.04 + (base - 0.04) * brdf.metallic
        again = brdf.multiple_scattering
        return Facets(repeat(diffuse), repeat(f0), repeat((alpha, alpha)), length, again=again)
    if isinstance(brdf, Ggx | GgxAnisotropic):
        widths = (brdf.alpha, brdf.alpha) if isinstance(brdf, Ggx) else (brdf.alpha_x, brdf.alpha_y)
        return Facets(repeat(brdf.kd), repeat(brdf.f0), repeat(widths), length, shields=False, correlated=True)
    return None


def facets_of_texels(texels: Texels) -> Facets:
    """The facets of PBR maps; where normals differ within a point, about as wide as facets and normals together."""
    metal = texels.metallic[:, None]
    alpha2 = np.maximum(texels.roughness, SMOOTHEST) ** 4
    xx, yy, xy = (2.0 * part for part in texels.spread.T)
    wide = np.column_stack([alpha2 + xx, alpha2 + yy])
    slanted = np.clip(1.0 - xy**2 / (wide[:, 0] * wide[:, 1]), 1e-6, 1.0)
    return Facets(
        diffuse=(1.0 - metal) * texels.base_colour,
        f0=texels.f0[:, None] * (1.0 - metal) + texels.base_colour * metal,
        alpha=np.minimum(np.sqrt(wide) * slanted[:, None] ** 0.25, 1.0),
        length=texels.length,
        again=float(texels.scatters_again),
        roughness=texels.roughness,
        spread=texels.spread,
    )


def reflect_near(
    lamps: Sequence[NearLamp],
    positions: Floats,
    frame: Floats,
    wo: Floats,
    facets: Facets,
    points: int = POINTS,
    reached: Reached | None = None,
) -> Floats:
    """Radiance (N, 3) that points at `positions` (N, 3) reflect to `wo` (N, 3), in their `frame` (N, 3, 3).

    Nothing casts a shadow unless `reached` says what lights reach.
    """
    total = np.zeros((len(wo), 3))
    for lamp in lamps:
        sums, lobes = np.zeros((2, len(wo), 3)), np.zeros((2, len(wo)))
        for direction, irradiance in near_lights(lamp, positions, points):
            wi = np.einsum("nij,ni->nj", frame, direction)
            lit = np.flatnonzero((wi[:, 2] > 0.0) & irradiance.any(axis=1))
            factors, densities = _split(wi[lit], wo[lit], facets.at(lit))
            seen = irradiance[lit] if reached is None else irradiance[lit] * reached(lamp, lit, direction[lit])[:, None]
            for k in range(2):
                found = densities[k] * irradiance[lit].max(axis=1)
                sums[k, lit] += factors[k] * densities[k][:, None] * seen
                lobes[k, lit] += found
        if lamp.is_point:
            total += sums.sum(axis=0)
            continue
        radiance = np.asarray(lamp.radiance)
        integrals, middles = lobe_integrals(lamp, positions, frame, wo, facets.alpha)
        wanted = np.where(integrals >= 0.0, integrals * radiance.max(), lobes)
        for k in range(2):
            total += sums[k] * (np.minimum(wanted[k], lobes[k]) / np.where(lobes[k] > 0.0, lobes[k], 1.0))[:, None]
            missed = np.flatnonzero((wanted[k] > lobes[k]) & (middles[k, :, 2] > 0.0))
            factor = _split(middles[k, missed], wo[missed], facets.at(missed))[0][k]
            colour = radiance / max(float(radiance.max()), 1e-300)
            if reached is not None:
                towards = np.einsum("nij,nj->ni", frame[missed], middles[k, missed])
                factor = factor * reached(lamp, missed, towards)[:, None]
            total[missed] += factor * (wanted[k] - lobes[k])[missed, None] * colour
    return total


def _split(wi: Floats, wo: Floats, facets: Facets) -> tuple[tuple[Floats, Floats], tuple[Floats, Floats]]:
    """f cos θ as factors times lobes: what is diffuse times cos θ, and W times D cos θ_h / (4 h·o)."""
    both, alpha = wi + wo, facets.alpha
    size = np.maximum(np.sqrt(dot(both, both)), 1e-12)
    half, cosine = both / size[:, None], wi[:, 2]
    fresnel = facets.f0 + (1.0 - facets.f0) * (np.clip(1.0 - 0.5 * size, 0.0, 1.0) ** 5)[:, None]
    diffuse = (1.0 - fresnel if facets.shields else 1.0) * facets.diffuse / np.pi
    if facets.again > 0.0:
        width = np.maximum(alpha[:, 0], SMOOTHEST**2)
        again = multiple_scattering(cosine, wo[:, 2], width, schlick_mean(np.moveaxis(facets.f0, -1, 0)))
        diffuse = diffuse + facets.again * np.moveaxis(again, 0, -1)
    scaled = np.column_stack([half[:, :2] / alpha, half[:, 2]])
    density = half[:, 2] / (2.0 * np.pi * size * alpha[:, 0] * alpha[:, 1] * dot(scaled, scaled) ** 2)
    slope_i, slope_o = _slope_length(wi, alpha), _slope_length(wo, alpha)
    if facets.correlated:
        shadowing = 2.0 * (cosine * slope_o + wo[:, 2] * slope_i)
    else:
        shadowing = (cosine + slope_i) * (wo[:, 2] + slope_o)
    weight = 2.0 * size * cosine * facets.glossy / (np.maximum(half[:, 2], MIN_COSINE) * shadowing)
    if facets.spread is not None and facets.roughness is not None:
        differ = np.flatnonzero(facets.spread[:, 0] + facets.spread[:, 1] > ALIKE)
        lobe = spread_lobe(wi[differ], wo[differ], half[differ], facets.roughness[differ], facets.spread[differ])
        weight[differ] = lobe / np.maximum(density[differ], 1e-300)
    return (diffuse * facets.length[:, None], weight[:, None] * fresnel), (cosine, density)


def _slope_length(direction: Floats, alpha: Floats) -> Floats:
    return np.asarray(np.sqrt(direction[:, 2] ** 2 + ((alpha * direction[:, :2]) ** 2).sum(axis=1)))


def lobe_integrals(
    lamp: NearLamp, positions: Floats, frame: Floats, wo: Floats, alpha: Floats
) -> tuple[Floats, Floats]:
    """The integrals (2, N) of cos θ and of D cos θ_h over the directions and the half vectors of a lamp.

    With them the directions (2, N, 3) at the middle of either lobe within the lamp. Integrals are −1 where the lamp is
    seen so small that its points stand for it, and 0 where it shines to the other side.
    """
    offset = np.asarray(lamp.position) - positions
    distance = np.sqrt(dot(offset, offset))
    axes = np.broadcast_to(lamp.half_sides, (len(positions), 2, 3))
    faces = np.ones(len(positions), np.bool_) if lamp.shape == "sphere" else offset @ np.asarray(lamp.facing) < 0.0
    if lamp.shape == "sphere":
        sine = np.minimum(lamp.radius / np.maximum(distance, lamp.radius), 1.0 - 1e-9)
        offset = normalize(offset, (0.0, 1.0, 0.0))
        tangent = sine / np.sqrt(1.0 - sine**2)
        axes = np.swapaxes(world_from_tangent(offset)[..., :2], -1, -2) * tangent[:, None, None]
    near = np.flatnonzero(faces & (lamp.extent > SMALL * distance))
    local = np.einsum("nij,ni->nj", frame[near], offset[near])
    across = np.einsum("nij,nai->naj", frame[near], axes[near])
    viewer, widths = np.ascontiguousarray(wo[near]), np.ascontiguousarray(alpha[near])
    vectors = integrate_lobes(local, across, viewer, widths, outline(lamp))
    integrals, middles = np.where(faces, -1.0, 0.0) * np.ones((2, 1)), np.zeros((2, len(positions), 3))
    vectors *= np.where(vectors[..., 2:] < 0.0, -1.0, 1.0)
    integrals[:, near] = (vectors[..., 2] * (0.5, 0.5 / np.pi)).T
    half = normalize(vectors[:, 1] * np.column_stack([widths, np.ones(len(near))]))
    middles[0, near] = normalize(vectors[:, 0])
    middles[1, near] = 2.0 * dot(half, viewer)[:, None] * half - viewer
    return integrals, middles


def outline(lamp: NearLamp) -> Floats:
    """(CORNERS, 2) corners of the polygon of a lamp, in half sides from its centre."""
    if lamp.shape == "rectangle":
        along = np.linspace(-1.0, 1.0, CORNERS // 4 + 1)[:-1]
        one = np.ones_like(along)
        sides = [(along, -one), (one, along), (-along, one), (-one, -along)]
        return np.concatenate([np.column_stack(side) for side in sides])
    turn = 2.0 * np.pi / CORNERS
    angle = turn * np.arange(CORNERS)
    return np.sqrt(turn / np.sin(turn)) * np.column_stack([np.cos(angle), np.sin(angle)])


@scalar
def integrate_lobes(
    centre: np.ndarray, axes: np.ndarray, viewer: np.ndarray, alpha: np.ndarray, corners: np.ndarray
) -> np.ndarray:
    """Sums over the edges of polygons around `centre` (N, 3) along `axes` (N, 2, 3), in the frame of each point.

    (N, 2, 3): the angle of each edge times its unit normal, of directions and of half vectors over `alpha`. A convex
    polygon meets the horizon where it leaves and where it enters, and between them has an edge along the horizon.
    """
    found = np.zeros((len(centre), 2, 3))
    corner, before, cut = np.empty(3), np.empty(3), np.empty(3)
    last, now, leaves, enters = np.empty((2, 3)), np.empty((2, 3)), np.empty(3), np.empty(3)
    for n in range(len(centre)):
        is_cut = False
        for k in range(-1, len(corners)):
            for i in range(3):
                corner[i] = centre[n, i] + corners[k, 0] * axes[n, 0, i] + corners[k, 1] * axes[n, 1, i]
            if k >= 0 and (before[2] > 0.0) != (corner[2] > 0.0):
                share = before[2] / (before[2] - corner[2])
                for i in range(3):
                    cut[i] = before[i] + share * (corner[i] - before[i]) if i < 2 else 0.0
                is_cut = True
                _put_lobes(cut, viewer[n], alpha[n], now)
                if corner[2] > 0.0:
                    enters[:] = cut
                    last[:] = now
                else:
                    leaves[:] = cut
                    _add_edge(last, now, found[n])
            if corner[2] > 0.0:
                _put_lobes(corner, viewer[n], alpha[n], now)
                if k >= 0:
                    _add_edge(last, now, found[n])
                last[:] = now
            before[:] = corner
        if is_cut:
            _put_lobes(leaves, viewer[n], alpha[n], last)
            for step in range(1, ON_HORIZON + 1):
                part = step / ON_HORIZON
                for i in range(3):
                    cut[i] = leaves[i] + part * (enters[i] - leaves[i])
                _put_lobes(cut, viewer[n], alpha[n], now)
                _add_edge(last, now, found[n])
                last[:] = now
    return found


@scalar
def _put_lobes(corner: np.ndarray, viewer: np.ndarray, alpha: np.ndarray, now: np.ndarray) -> None:
    """Put the direction of a corner into `now`, and of its half vector over `alpha`; both are unit vectors."""
    length, squared = np.sqrt(corner[0] ** 2 + corner[1] ** 2 + corner[2] ** 2), 0.0
    for i in range(3):
        now[0, i] = corner[i] / length if length > 0.0 else (1.0 if i == 2 else 0.0)
        now[1, i] = (now[0, i] + viewer[i]) / (alpha[i] if i < 2 else 1.0)
        squared += now[1, i] ** 2
    for i in range(3):
        now[1, i] /= np.sqrt(squared)


@scalar
def _add_edge(one: np.ndarray, two: np.ndarray, sums: np.ndarray) -> None:
    """Add the angle of an edge times its unit normal, for both lobes."""
    for k in range(2):
        x = one[k, 1] * two[k, 2] - one[k, 2] * two[k, 1]
        y = one[k, 2] * two[k, 0] - one[k, 0] * two[k, 2]
        z = one[k, 0] * two[k, 1] - one[k, 1] * two[k, 0]
        sine = np.sqrt(x * x + y * y + z * z)
        cosine = one[k, 0] * two[k, 0] + one[k, 1] * two[k, 1] + one[k, 2] * two[k, 2]
        share = np.arctan2(sine, cosine) / sine if sine > 1e-12 else 1.0
        sums[k, 0] += share * x
        sums[k, 1] += share * y
        sums[k, 2] += share * z
