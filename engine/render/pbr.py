"""PBR maps at points of a surface: the BRDF of the texel, and the frame that the map of normals bends.

Base colour, roughness, metallic and f0 are filtered as colours are, normals as their mean and the spread of their
slopes (`engine.surface.normal_spread`), so that relief seen from afar reflects as it does from near. The axes of the
texture are those of its coordinates, x to the right and y up. A bent normal that would point away from the viewer is
bent back until it just faces the viewer, as an interpolated one is. Height and occlusion are not drawn: light that
relief hides is not hidden here.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.brdf.models.microfacet import MetallicRoughness
from engine.brdf.models.multiple_scattering import SMOOTHEST
from engine.brdf.models.openpbr import OpenPbr
from engine.core.directions import dot, frames_along, normalize
from engine.render.hex_tiling import Maps, blend, differences_at, normals_at
from engine.render.mip_maps import filter_levels
from engine.surface.layered import cover, reflect_layers
from engine.surface.metallic_roughness import reflectance
from engine.surface.normal_spread import ALIKE, reflect_spread, spread_slopes
from engine.surface.pbr_maps import PbrMaps

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

#: Least cosine between the normal that shades and the direction of view.
MIN_FACING = 0.01

#: Variance of the logarithm of roughness from which two values stand for it, and half of the most skewness.
ALIKE_GLOSS, MAX_SKEW = 1e-4, 4.0

#: Sum of the variances of slopes, over alpha², above which normals differ much.
MUCH = 0.1


@dataclass(frozen=True, eq=False)
class Texels:
    """The maps at N points: `base_colour` (N, 3), `roughness`, `metallic` and `f0` (N,), `normal` (N, 3) unit,
    with the covariance `spread` (N, 3) of the slopes that a point covers, and the `length` (N,) of their mean normal.
    `scatters_again` and `layers` are those of `PbrMaps`. `joint` (N, 3) and `apart` (N, 3) say how
    texels below a point differ, as `pbr_levels` has them; None where they do not. `upright` (N, 3) is the normal of the
    surface in the frame that the map's bends, None where none has been bent.
    """

    base_colour: Floats
    roughness: Floats
    metallic: Floats
    f0: Floats
    normal: Floats
    spread: Floats
    length: Floats
    scatters_again: bool = False
    layers: OpenPbr | MetallicRoughness | None = None
    joint: Floats | None = None
    apart: Floats | None = None
    upright: Floats | None = None

    def scatter(self, points: Indices, count: int, among: Texels | None) -> Texels:
        """The same at the `points` (N,) of so many, beside those `among` them; nothing where texels differ within."""
        names = ("base_colour", "roughness", "metallic", "f0", "normal", "spread", "length")
        values: dict[str, Any] = {}
        for name in names:
            own = getattr(self, name)
            values[name] = np.zeros((count, *own.shape[1:])) if among is None else getattr(among, name)
            values[name][points] = own
        return replace(self, joint=None, apart=None, **values)

    def with_layers_of(self, maps: PbrMaps) -> Texels:
        """The same with the layers of `maps`."""
        return replace(self, scatters_again=maps.multiple_scattering, layers=maps.layers)

    def tint(self, colours: Floats | None) -> Texels:
        """The same with base colours times `colours` (N, 3)."""
        if colours is None:
            return self
        joint = None if self.joint is None else self.joint * colours
        return replace(self, base_colour=self.base_colour * colours, joint=joint)

    def parts(self) -> list[tuple[Floats, Texels]]:
        """Texels of one roughness whose sum, with weights (N,), the point shows: metal, what is none, and a mixture as
        far as texels are one themselves, in two roughnesses each."""
        alone = replace(self, joint=None, apart=None)
        if self.joint is None or self.apart is None:
            return [(np.ones(len(self.roughness)), alone)]
        is_open = isinstance(self.layers, OpenPbr)
        by_metal = [(np.ones(len(self.roughness)), alone)] if is_open else self._parts_by_metal(alone)
        by_roughness = self._parts_by_roughness()
        return [
            (weight * share, replace(part, roughness=roughness))
            for weight, part in by_metal
            for share, roughness in by_roughness
        ]

    def _parts_by_metal(self, alone: Texels) -> list[tuple[Floats, Texels]]:
        assert self.joint is not None
        assert self.apart is not None
        metal, variance = self.metallic, self.apart[:, 2]
        most = metal * (1.0 - metal)
        share = np.where(variance > ALIKE, np.clip(variance / np.maximum(most, 1e-9), 0.0, 1.0), 0.0)
        if not share.any():
            return [(np.ones(len(metal)), alone)]
        found = [(1.0 - share, alone)] if (share < 1.0).any() else []
        for sign, value, part in ((1.0, 1.0, metal), (-1.0, 0.0, 1.0 - metal)):
            base = self.base_colour + sign * self.joint / np.maximum(share * part, 1e-6)[:, None]
            same = np.full(len(metal), value)
            found.append((share * part, replace(alone, base_colour=np.clip(base, 0.0, 1.0), metallic=same)))
        return found

    def _parts_by_roughness(self) -> list[tuple[Floats, Floats]]:
        """Two roughnesses with their weights, of which the mean, and the variance and the third moment of the logarithm
        are those of all (Gauss quadrature): exact where there are but two."""
        assert self.apart is not None
        variance, third = self.apart[:, 0], self.apart[:, 1]
        differ = variance > ALIKE_GLOSS
        if not differ.any():
            return [(np.ones(len(variance)), self.roughness)]
        deviation = np.sqrt(np.where(differ, variance, 1.0))
        half = np.clip(0.5 * third / deviation**3, -MAX_SKEW, MAX_SKEW)
        root = np.sqrt(1.0 + half**2)
        weights = [0.5 * (1.0 - sign * half / root) for sign in (1.0, -1.0)]
        values = [np.exp(deviation * (half + sign * root)) for sign in (1.0, -1.0)]
        scale = np.maximum(self.roughness, SMOOTHEST) / (weights[0] * values[0] + weights[1] * values[1])
        return [
            (np.where(differ, weight, 0.5), np.where(differ, np.minimum(scale * value, 1.0), self.roughness))
            for weight, value in zip(weights, values, strict=True)
        ]

    @property
    def differ_within(self) -> NDArray[np.bool_]:
        """(N,) where normals within a point differ by more than its highlight is wide."""
        return np.asarray(self.spread[:, 0] + self.spread[:, 1] > MUCH * np.maximum(self.roughness, SMOOTHEST) ** 4)

    def product(self, point: Indices, wi: Floats, wo: Floats) -> Floats:
        """f times the cosine (K, 3) at the points (K,) for directions (K, 3) in their bent frames, averaged over the
        normals that a point covers; `wi` may lie below the horizon of their mean."""
        value, is_spread = np.empty((len(point), 3)), self.spread[point, 0] + self.spread[point, 1] > ALIKE
        even, spread = np.flatnonzero(~is_spread), np.flatnonzero(is_spread)
        if even.size:
            value[even] = self._f(point[even], wi[even], wo[even]) * wi[even, 2:]
        if spread.size:
            at = point[spread]
            there = self.base_colour[at], self.roughness[at], self.metallic[at], self.f0[at]
            if isinstance(self.layers, OpenPbr):
                variance = self.spread[at, 0] + self.spread[at, 1]
                f = reflect_layers(self.layers, wi[spread], wo[spread], *there, variance)
                value[spread] = f * np.maximum(wi[spread, 2:], 0.0)
                return value
            value[spread] = reflect_spread(
                wi[spread], wo[spread], *there, self.spread[at], self.length[at], self.scatters_again
            )
        return self._cover(point, value, wi, wo, np.where(is_spread, self.length[point], 1.0))

    def even_product(self, point: Indices, wi: Floats, wo: Floats) -> Floats:
        """The same of the normals themselves, which do not differ within a point."""
        return self._cover(point, self._f(point, wi, wo) * wi[:, 2:], wi, wo)

    def _f(self, point: Indices, wi: Floats, wo: Floats) -> Floats:
        """Values (K, 3) in 1/sr at the points (K,) for directions (K, 3) in their bent frames, below glTF layers."""
        there = self.base_colour[point], self.roughness[point], self.metallic[point], self.f0[point]
        if isinstance(self.layers, OpenPbr):
            return reflect_layers(self.layers, wi, wo, *there)
        return reflectance(wi, wo, *there, self.scatters_again)

    def _cover(self, point: Indices, value: Floats, wi: Floats, wo: Floats, length: ArrayLike = 1.0) -> Floats:
        """`value` (K, 3), f times the cosine, under sheen, and a clear coat, whose normal is that of the surface."""
        if not isinstance(self.layers, MetallicRoughness):
            return value
        assert self.upright is not None
        return cover(self.layers, value, wi, wo, self.upright[point], self.scatters_again, length)

    def in_frames(self, frame: Floats, bent: Floats) -> Texels:
        """The same where normals bend frames (N, 3, 3) of the surface to those of `bend_frames`."""
        return replace(self, upright=np.einsum("nij,ni->nj", bent, frame[..., 2]))

    def bend_frames(self, frame: Floats, axes: Floats, wo: Floats) -> Floats:
        """Frames (N, 3, 3) about the normals of the map, along the axes of the texture, from those of the surface.

        `axes` (N, 2, 3) are those of the texture, `wo` (N, 3) leads to the viewer, in the world like `frame`.
        """
        x, y, z = (self.normal[:, at, None] for at in range(3))
        normal = normalize(x * axes[:, 0] + y * axes[:, 1] + z * frame[..., 2])
        facing = dot(normal, wo)[:, None]
        normal = np.where(facing < MIN_FACING, normalize(normal + (MIN_FACING - facing) * wo), normal)
        bent = frames_along(normal, axes[:, 0])
        mirrored = dot(np.cross(axes[:, 0], axes[:, 1]), frame[..., 2]) < 0.0
        bent[mirrored, :, 1] *= -1.0
        return bent


def texels_at(looked_up: Maps, uv: Floats, detail: Floats, maps: PbrMaps) -> Texels:
    """The `maps` at `uv` (N, 2) with the mip levels `detail` (N,), as they are `looked_up`."""
    if looked_up.tables is not None:
        base, gloss, mean, square, within = blend(looked_up, uv, detail)
    else:
        base, gloss = (filter_levels(looked_up.levels, layer, uv, detail) for layer in range(2))
        within = differences_at(looked_up.levels, uv, detail)
        mean, square = normals_at(looked_up.levels, uv, detail)
    known = base, gloss[:, 0], gloss[:, 1], gloss[:, 2], normalize(mean), *spread_slopes(mean, square)
    return Texels(*known, maps.multiple_scattering, maps.layers, *within)
