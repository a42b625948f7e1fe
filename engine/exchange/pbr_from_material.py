"""PBR maps nearest to a material, for programs that know no shading map.

A material reflects S(r) at a texel, r = σ Y(f_r(wi, wo)) cos θi (Kautz2004 Eq. 2), in place of f cos θi. The maps
minimise, texel by texel, the mean of |S(r) − f cos θi|² over pairs of directions: the light anywhere above the surface,
the viewer as a ball shows its surface to one, with a density of cos θo. Half of the pairs are drawn so and half by the
BRDF, so that narrow highlights are met; both count by the balance heuristic (Veach1997 Sec. 9.2).

For a given roughness, metallic and f0, f cos θi is linear in the base colour b, b A + B:

    dielectric   A = (1 − F) cos θi / π,           B = F L cos θi         with F = f0 + (1 − f0) g,
    metal        A = (1 − g) L cos θi,             B = g L cos θi         with L = D G / (4 n·l n·v), g = (1 − h·wi)⁵,

and S is linear in the slices s, S = Σ h_l(r) s_l. Maps are relative to a white card that faces a lamp and shows the
radiance W there, as those of `engine.surface` are: what is fitted is S / (π W). So b = (⟨A, S⟩ − ⟨A, B⟩) / ⟨A, A⟩, and
its error, are sums over slices with weights that all texels share; the directions are gone before the first texel is
looked at. ⟨S, S⟩ is the same for all choices and left out of the error. The roughness of each texel is the best of
`ROUGHNESSES`, of a metal up to `ROUGHEST_METAL`, metallic the best for the whole material, and f0 what every importer
takes for granted. Normals are flat, because a shading map does not hold the side that light came from; shades of
relief are in the base colour, darker than the surface is.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.brdf.models.sampling import sampler_of
from engine.core.colour import luminance
from engine.core.directions import normalize
from engine.core.errors import UsageError
from engine.core.kernels import scalar
from engine.core.side_by_side import side_by_side
from engine.core.steps import Step, Steps
from engine.exchange.loss import scene_of
from engine.scene.material import Material
from engine.shading.lookup import layer_at, share_and_gain
from engine.surface.metallic_roughness import lobe_and_grazing
from engine.surface.pbr_maps import DIELECTRIC_F0, ObservedSlopes, PbrMaps

Floats = NDArray[np.float64]

#: Rows and columns of maps.
Part = tuple[slice, slice]

#: Values that are tried for each texel.
ROUGHNESSES = tuple(float(value) for value in np.linspace(0.08, 1.0, 24).round(3))

#: Roughest metal that is tried: it loses a tenth of the light between facets in this model, one of 0.9 more than half.
#: Programs that add it back draw rougher ones so much brighter that they would not look like what they stand for.
ROUGHEST_METAL = 0.5

#: Pairs of directions.
PAIRS = 1 << 13

#: Slices that stand for a power law, texels that metallic is chosen by, and texels times slices of one step, which stay
#: in the cache, and in memory where that is limited.
LAYERS, CHOSEN_BY, TILE = 17, 1 << 13, 1 << 14

#: Share of texels and channels that a white card is at least as bright as.
BRIGHT = 0.999

#: Directions of light, in angles from the normal and about it, that stand for a directional map.
TILTS, TURNS = 6, 8


@dataclass(frozen=True, eq=False)
class Family:
    """The choices of roughness of a metallic, rising (K,): ⟨A, h_l⟩ and ⟨B, h_l⟩ (L, K), and ⟨A, A⟩, ⟨A, B⟩ and ⟨B, B⟩
    (3, K)."""

    metallic: float
    roughness: Floats
    slope: Floats
    offset: Floats
    products: Floats

    def fit(self, layers: Floats) -> tuple[Floats, Floats, Floats]:
        """Base colour (rows, W, 3) and roughness (rows, W) of least error, and the error without ⟨S, S⟩ (rows, W)."""
        size = layers.shape[1:3]
        base, best, error = np.empty((*size, 3)), np.empty(size, np.int64), np.empty(size)
        texels = np.ascontiguousarray(layers).reshape(len(layers), -1, 3)
        _fit_texels(texels, self.slope, self.offset, self.products, base.reshape(-1, 3), best.ravel(), error.ravel())
        return base, self.roughness[best], error


def nearest_maps(material: Material, white: float | None = None) -> Steps[tuple[PbrMaps, float]]:
    """The maps nearest to `material`, with flat normals, no height and no occlusion, and W; UsageError without a map.

    `white` is W, None for 1 or more where texels are brighter. `errors` of the maps are unknown:
    `engine.exchange.loss` measures them.
    """
    yield Step(0.0, "comparing directions")
    layers = _Layers(material) if material.directional is None else _DirectionalLayers(material)
    wi, wo, weight = _directions(material)
    families = _families(wi, wo, weight, layers.hats(wi, wo))
    yield Step(0.1, "choosing metallic")
    few = _sample(layers, CHOSEN_BY)
    white = white or max(1.0, float(np.quantile(few.max(axis=0), BRIGHT)))
    few = few / (np.pi * white)
    chosen = min(families, key=lambda family: float(family.fit(few)[2].sum()))
    base = np.empty((*layers.size, 3), np.float32)
    roughness = np.empty(layers.size, np.float32)

    def fit_tile(part: Part) -> int:
        base[part], roughness[part], _ = chosen.fit(layers.tile(part) / (np.pi * white))
        return part[0].stop

    with closing(side_by_side(fit_tile, _tiles(layers.size, max(1, TILE // layers.count)))) as fitted:
        for last in fitted:
            yield Step(0.2 + 0.8 * last / layers.size[0], "finding the nearest maps")
    flat = np.zeros((*layers.size, 3), np.float32)
    flat[..., 2] = 1.0
    maps = PbrMaps(
        base_colour=base,
        normal=flat,
        roughness=roughness,
        metallic=np.full(layers.size, chosen.metallic, np.float32),
        f0=np.full(layers.size, DIELECTRIC_F0, np.float32),
        observed=ObservedSlopes("none"),
    )
    return maps, white


def cavity(material: Material) -> NDArray[np.float32] | None:
    """Share of a uniform sky that a texel shows, of what flat ground as bright under the highest lamp would, (H, W).

    On a Lambertian look-up r is r_max cos θ, and a texel of exponent K has ∫ (cos θ)^K dω = 2π / (K + 1) where flat
    ground has π: 2 / (K + 1), at most 1. K is that of the channels together, by luminance. The lamps stood on one arc;
    the sky is taken to look alike from all sides. None without a power law.
    """
    if material.power_law is None:
        return None
    share: NDArray[np.float32] = np.minimum(2.0 / (luminance(material.power_law.exponent) + 1.0), 1.0)
    return share.astype(np.float32)


def _tiles(size: tuple[int, int], most: int) -> Iterator[Part]:
    """Parts of maps of `size` (H, W), whole rows or pieces of one, of `most` texels at most."""
    height, width = size
    rows, columns = max(1, most // width), min(most, width)
    for top in range(0, height, rows):
        for left in range(0, width, columns):
            yield slice(top, min(top + rows, height)), slice(left, min(left + columns, width))


class _Layers:
    """The slices of a material by tiles, S as a piecewise linear function of r; negative noise counts as 0."""

    def __init__(self, material: Material) -> None:
        if material.shading_map is None and material.power_law is None:
            raise UsageError("the material has neither a shading map nor a power law")
        self._material = material
        self._map, self._law = material.shading_map, material.power_law
        if self._map is not None:
            self.count, height, width = self._map.slices.shape[:3]
        else:
            assert self._law is not None
            self.count, (height, width) = LAYERS, self._law.error_map.shape
        self.size = (height, width)

    def tile(self, part: Part) -> Floats:
        """(L, h, w, 3)."""
        if self._map is not None:
            return np.maximum(self._map.slices[:, *part], 0.0).astype(np.float64)
        assert self._law is not None
        images = [
            self._law.slice_image(self._law.r_max * share, part=part) for share in np.linspace(0.0, 1.0, self.count)
        ]
        return np.stack(images).astype(np.float64)

    def hats(self, wi: Floats, wo: Floats) -> Floats:
        """(L, M) the share of each slice in S at each pair."""
        shading = self._map or self._law
        assert shading is not None
        r = scene_of(self._material).sigma * luminance(self._material.reflectance.f(wi, wo)) * wi[:, 2]
        lower, beyond = layer_at(share_and_gain(r, shading.r_max, "clamp")[0], self.count)
        hats, pairs = np.zeros((self.count, len(wi))), np.arange(len(wi))
        hats[lower, pairs] = 1.0 - beyond
        hats[lower + 1, pairs] += beyond
        return hats


class _DirectionalLayers:
    """The same of a directional map: its images under `TILTS` x `TURNS` lights, bilinear between these.

    A pair of directions counts as the light that shows as much to a viewer straight above (`Scene.effective_cosine`).
    """

    def __init__(self, material: Material) -> None:
        assert material.directional is not None
        self._material, self._map = material, material.directional
        self.count = TILTS * TURNS
        self.size = (material.directional.planes.shape[1], material.directional.planes.shape[2])
        self._cosine = np.maximum(np.cos(np.repeat(np.linspace(0.0, 0.5 * np.pi, TILTS), TURNS)), 0.0)
        self._azimuth = np.tile(np.arange(TURNS) * (2.0 * np.pi / TURNS), TILTS)

    def tile(self, part: Part) -> Floats:
        """(L, h, w, 3)."""
        planes = self._map.planes[:, *part]
        found = self._map.sample(planes.reshape(len(planes), -1).T, self._cosine, self._azimuth)
        return found.swapaxes(0, 1).reshape(self.count, *planes.shape[1:], 3)

    def hats(self, wi: Floats, wo: Floats) -> Floats:
        """(L, M) the share of each image in S at each pair."""
        scene = scene_of(self._material)
        r = scene.sigma * luminance(self._material.reflectance.f(wi, wo)) * wi[:, 2]
        azimuth = np.arctan2(wi[:, 1], wi[:, 0])
        cosine = scene.effective_cosine(share_and_gain(r, self._map.r_max, "clamp")[0], azimuth)
        down, tilt_share = layer_at(np.arccos(np.clip(cosine, 0.0, 1.0)) / (0.5 * np.pi), TILTS)
        turn = np.mod(azimuth / (2.0 * np.pi), 1.0) * TURNS
        around = np.minimum(turn.astype(np.int64), TURNS - 1)
        hats, pairs = np.zeros((TILTS, TURNS, len(wi))), np.arange(len(wi))
        for row, of_row in ((down, 1.0 - tilt_share), (down + 1, tilt_share)):
            for column, of_column in ((around, 1.0 - (turn - around)), ((around + 1) % TURNS, turn - around)):
                hats[row, column, pairs] += of_row * of_column
        return hats.reshape(self.count, len(wi))


def _sample(layers: _Layers | _DirectionalLayers, count: int) -> Floats:
    """(L, rows, W, 3) of evenly spaced rows with about `count` texels."""
    height, width = layers.size
    wanted = np.unique(np.linspace(0, height - 1, min(height, max(1, count // width))).astype(int))
    return np.concatenate([layers.tile((slice(row, row + 1), slice(None))) for row in wanted], axis=1)


def _directions(material: Material) -> tuple[Floats, Floats, Floats]:
    """Pairs of directions (M, 3) each, and weights (M,) that sum to 1."""
    from scipy.stats import qmc

    u = qmc.Sobol(6, seed=0).random(PAIRS)
    radius, phi = np.sqrt(u[:, 0]), 2.0 * np.pi * u[:, 1]
    wo = np.column_stack([radius * np.cos(phi), radius * np.sin(phi), np.sqrt(np.maximum(1.0 - u[:, 0], 1e-6))])
    wo = normalize(wo)
    height, around = u[:, 2], 2.0 * np.pi * u[:, 3]
    sine = np.sqrt(1.0 - height**2)
    wi = np.column_stack([sine * np.cos(around), sine * np.sin(around), height])
    sampler = sampler_of(material.reflectance)
    drawn = PAIRS // 2
    wi[:drawn] = sampler.sample(wo[:drawn], u[:drawn, 3:])
    above = wi[:, 2] > 1e-4
    wi, wo = wi[above], wo[above]
    uniform = 0.5 / np.pi
    weight = uniform / (0.5 * uniform + 0.5 * sampler.pdf(wi, wo))
    return wi, wo, weight / weight.sum()


def _families(wi: Floats, wo: Floats, weight: Floats, hats: Floats) -> list[Family]:
    """The dielectrics, and the metals."""
    found = []
    for metallic, roughest in ((0.0, 1.0), (1.0, ROUGHEST_METAL)):
        roughnesses = np.array([roughness for roughness in ROUGHNESSES if roughness <= roughest])
        pairs = np.stack([_linear_in_base(wi, wo, metallic, roughness) for roughness in roughnesses]) * wi[:, 2]
        a, b = pairs[:, 0], pairs[:, 1]
        products = np.stack([(a * a) @ weight, (a * b) @ weight, (b * b) @ weight])
        found.append(Family(metallic, roughnesses, hats @ (weight * a).T, hats @ (weight * b).T, products))
    return found


def _linear_in_base(wi: Floats, wo: Floats, metallic: float, roughness: float) -> tuple[Floats, Floats]:
    """A and B without cos θi."""
    lobe, grazing = lobe_and_grazing(wi, wo, roughness)
    if metallic:
        return (1.0 - grazing) * lobe, grazing * lobe
    fresnel = DIELECTRIC_F0 + (1.0 - DIELECTRIC_F0) * grazing
    return (1.0 - fresnel) / np.pi, fresnel * lobe


@scalar
def _fit_texels(
    layers: Floats,
    slope: Floats,
    offset: Floats,
    products: Floats,
    base: Floats,
    best: NDArray[np.int64],
    error: Floats,
) -> None:
    """Write the base colour (T, 3), the place of the best choice (T,) and its error without ⟨S, S⟩ (T,) of `layers`.

    Bound by arithmetic: 6 L K products a texel, of which four are made at once.
    """
    count, choices = slope.shape
    along_a, along_b = np.empty((3, choices)), np.empty((3, choices))
    for texel in range(len(best)):
        along_a[:], along_b[:] = 0.0, 0.0
        for layer in range(count):
            for channel in range(3):
                value = layers[layer, texel, channel]
                for choice in range(choices):
                    along_a[channel, choice] += value * slope[layer, choice]
                    along_b[channel, choice] += value * offset[layer, choice]
        least, chosen = np.inf, 0
        for choice in range(choices):
            aa, ab, bb = products[0, choice], products[1, choice], products[2, choice]
            total = 0.0
            for channel in range(3):
                a = along_a[channel, choice]
                colour = min(max((a - ab) / aa, 0.0), 1.0)
                total += colour * (colour * aa - 2.0 * a + 2.0 * ab) - 2.0 * along_b[channel, choice] + bb
            if total < least:
                least, chosen = total, choice
        for channel in range(3):
            colour = (along_a[channel, chosen] - products[1, chosen]) / products[0, chosen]
            base[texel, channel] = min(max(colour, 0.0), 1.0)
        best[texel], error[texel] = chosen, least
