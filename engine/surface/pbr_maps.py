"""Maps of physically based rendering: normals, height, base colour, roughness and reflectance, with their uncertainty.

The terms are those of metallic-roughness in glTF 2.0: the reflectance at normal incidence is F = f0 (1 − metallic) +
base_colour metallic, the diffuse part (1 − F) (1 − metallic) base_colour / π, and the highlight GGX of alpha =
roughness² with height-correlated shadowing. Normals point out of
the image in its own frame, x to the right, y up and z towards the camera, which is that of OpenGL normal maps.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from engine.brdf.models.microfacet import MetallicRoughness
from engine.brdf.models.openpbr import OpenPbr
from engine.core.colour import REC_709, WorkingSpace, working_space
from engine.core.figure_text import number, percent
from engine.core.summary import Summary

Map = NDArray[np.float32]

#: Largest distance of the length of a normal from one.
UNIT = 1e-3

#: Distance of a colour from Rec.709 that counts as clipped.
WORTH_SAYING = 0.01

#: Most UDIM tiles a side of a square.
MAX_TILES = 10

#: Reflectance of a dielectric of index 1.5 at normal incidence.
DIELECTRIC_F0 = 0.04


@dataclass(frozen=True)
class ObservedSlopes:
    """The slopes that the lamps of a capture could tell.

    `kind` is 'both' for lamps that span the plane, 'along the arc' for those of one arc, whose direction is `azimuth`
    (radians, 0 = right, π/2 = up in the image; None else), and 'none' where no slope is known.
    """

    kind: Literal["both", "along the arc", "none"]
    azimuth: float | None = None

    def __post_init__(self) -> None:
        if (self.kind == "along the arc") != (self.azimuth is not None):
            raise ValueError(f"slopes observed {self.kind!r} with the azimuth {self.azimuth}")


@dataclass(frozen=True)
class MapErrors:
    """Errors against the photographs, in codes of 8-bit sRGB unless named otherwise; NaN where one is not known.

    Attributes
    ----------
    in_sample : root mean square over texels, channels and photographs of the maps relit by the lamps.
    left_out : the same for photographs that the maps were made without.
    mean_picture : of the mean of the photographs in place of each.
    normal_sigma : median standard deviation of the normals, radians.
    """

    in_sample: float = np.nan
    left_out: float = np.nan
    mean_picture: float = np.nan
    normal_sigma: float = np.nan


@dataclass(frozen=True, eq=False)
class Uncertainty:
    """One standard deviation of each map, in the unit of the map, of normals in radians; inf where nothing is known.

    That of normals is the root mean square angle by which they err; where slopes are observed along an arc, that of the
    slope along it alone.
    `base_colour` is (H, W, 3), all else (H, W); `height` and `occlusion` are None where their map is.
    """

    base_colour: Map
    normal: Map
    roughness: Map
    metallic: Map
    f0: Map
    height: Map | None = None
    occlusion: Map | None = None


@dataclass(frozen=True, eq=False)
class WideColours:
    """Base colours in a space wider than Rec.709, and one standard deviation of each, in the same space.

    Attributes
    ----------
    space : name of the `engine.core.colour.WorkingSpace`, other than 'rec709'.
    base_colour : (H, W, 3) float32 in [0, 1]. sigma : the same shape, 0 or more; None where it is not known.
    clipped : share of texels that lie beyond Rec.709, and the largest distance of a component from what Rec.709 holds.
    """

    space: str
    base_colour: Map
    sigma: Map | None = None
    clipped: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        if working_space(self.space) == REC_709:
            raise ValueError("colours in Rec.709 are not wide")
        _check("base_colour", self.base_colour, self.base_colour.shape[:2], 0.0, 1.0)
        _check_sigma("base_colour", self.sigma, self.base_colour.shape)


@dataclass(frozen=True, eq=False, repr=False)
class PbrMaps(Summary):
    """Metallic-roughness maps of one flat sample, all float32; ValueError for another shape, range or kind.

    Attributes
    ----------
    base_colour : (H, W, 3) linear sRGB in [0, 1], clipped where `wide` has more.
    normal : (H, W, 3) unit vectors: x to the right of the image, y up, z out of the surface.
    roughness : (H, W) in [0, 1], GGX alpha is its square.
    metallic : (H, W) in [0, 1].
    f0 : (H, W) reflectance of dielectrics at normal incidence, in [0, 1].
    height : (H, W) in widths of a texel, mean 0; None where the slopes are not known.
    occlusion : (H, W) share of the hemisphere's diffuse light that relief leaves, in [0, 1]; None where not known.
    uncertainty : one standard deviation of each; None for maps of unknown origin.
    region : (H, W) number of the region of a texel, from 0 by falling size; None for one region. Depth edges divide the
        surface into regions, between which the step of the height is unknown. The height's standard deviation is that
        from the mean of its region, and inf on the edges.
    mask : (H, W) 1 where the surface is, 0 for background, of which nothing is known; None where all is surface.
    multiple_scattering : True if light that facets scatter more than once is beside their highlight, as materials of
        other programs want it; False for maps that were fitted to photographs, whose highlight holds it already.
    layers : what lies over the base, the same at all texels (`engine.surface.layered`); None for nothing. An OpenPBR
        model is the whole of what texels reflect, whose base alone is that of the maps; of `metallic-roughness` sheen
        and clear coat count, which glTF lays over the maps.
    wide : the base colours in a wider space, in which the maps were made; None for Rec.709.
    tiles : a side of the square of UDIM tiles that the maps hold: texture coordinates are divided by it.
    """

    base_colour: Map
    normal: Map
    roughness: Map
    metallic: Map
    f0: Map
    height: Map | None = None
    occlusion: Map | None = None
    uncertainty: Uncertainty | None = None
    observed: ObservedSlopes = ObservedSlopes("both")
    errors: MapErrors = MapErrors()
    region: Map | None = None
    mask: Map | None = None
    multiple_scattering: bool = False
    layers: OpenPbr | MetallicRoughness | None = None
    wide: WideColours | None = None
    tiles: int = 1

    def __post_init__(self) -> None:
        if not 1 <= self.tiles <= MAX_TILES:
            raise ValueError(f"{self.tiles} tiles a side")
        shape = self.roughness.shape
        if len(shape) != 2:
            raise ValueError(f"maps must be (H, W), got {shape}")
        if self.wide is not None and self.wide.base_colour.shape[:2] != shape:
            raise ValueError(f"wide colours must be of {shape}, got {self.wide.base_colour.shape}")
        for name in ("base_colour", "roughness", "metallic", "f0", "occlusion"):
            _check(name, getattr(self, name), shape, 0.0, 1.0)
        _check("normal", self.normal, shape, -1.0 - UNIT, 1.0 + UNIT)
        _check("height", self.height, shape, -np.inf, np.inf)
        _check("mask", self.mask, shape, 0.0, 1.0)
        _check("region", self.region, shape, 0.0, shape[0] * shape[1])
        lengths = np.einsum("ijk,ijk->ij", self.normal, self.normal)
        if not np.abs(lengths - 1.0).max(initial=0.0) < 2.0 * UNIT:
            raise ValueError("normals must be unit vectors")
        if self.uncertainty is not None:
            for name in ("base_colour", "normal", "roughness", "metallic", "f0", "height", "occlusion"):
                sigma = getattr(self.uncertainty, name)
                if (sigma is None) != (getattr(self, name) is None):
                    raise ValueError(f"{name} and its uncertainty must both be known or not")
                _check_sigma(name, sigma, (*shape, 3) if name == "base_colour" else shape)

    @property
    def of_gltf(self) -> MetallicRoughness | None:
        """Sheen and clear coat of glTF; None where there are none, or an OpenPBR model in their place."""
        return self.layers if isinstance(self.layers, MetallicRoughness) else None

    @property
    def openpbr(self) -> OpenPbr | None:
        """The OpenPBR model that texels are; None where they are the base, or it under layers of glTF."""
        return self.layers if isinstance(self.layers, OpenPbr) else None

    @property
    def size(self) -> tuple[int, int]:
        """(H, W) in texels."""
        return self.roughness.shape[0], self.roughness.shape[1]

    @property
    def size_bytes(self) -> int:
        """Bytes of all maps and their uncertainty."""
        names = ("base_colour", "normal", "roughness", "metallic", "f0", "height", "occlusion", "region", "mask")
        found = [getattr(source, name, None) for source in (self, self.uncertainty) for name in names]
        found += [] if self.wide is None else [self.wide.base_colour, self.wide.sigma]
        return sum(values.nbytes for values in found if values is not None)

    def summary(self) -> dict[str, Any]:
        """Return what `repr` says."""
        height, width = self.size
        return {"size": f"{width} × {height} texels", "height": self.height is not None}


def clip_wide(space: WorkingSpace, wide: Map, sigma: Map | None) -> tuple[Map, Map | None, WideColours | None]:
    """Base colours (H, W, 3) of a space and their deviations, in Rec.709 clipped to [0, 1], and as they are.

    Deviations are taken to be independent. The last is None for Rec.709.
    """
    if space == REC_709:
        return wide, sigma, None
    matrix = space.to_rec709.astype(np.float32)
    plain = wide @ matrix.T
    clipped = np.clip(plain, 0.0, 1.0)
    outside = np.abs(plain - clipped).max(axis=2)
    lost = float((outside > WORTH_SAYING).mean()), float(outside.max(initial=0.0))
    of_plain = None if sigma is None else np.minimum(np.sqrt(sigma**2 @ (matrix**2).T), 1.0)
    return clipped, of_plain, WideColours(space.name, wide, sigma, lost)


def space_of(maps: PbrMaps) -> WorkingSpace:
    """The space of the base colours of maps, wide ones where there are any."""
    return REC_709 if maps.wide is None else working_space(maps.wide.space)


def wide_text(wide: WideColours) -> str:
    """A sentence on base colours beyond Rec.709."""
    label, (share, distance) = working_space(wide.space).label, wide.clipped
    if not share:
        return f"base colours are kept in {label}; none lies beyond Rec.709"
    clipped = f"{percent(share)} of them lie beyond Rec.709 and are clipped by up to {number(distance)} of white"
    return f"base colours are kept in {label}; {clipped} in images and in exports that hold Rec.709 alone"


def count_regions(maps: PbrMaps) -> int:
    """Number of regions between which the steps of the height are unknown, at least 1."""
    return 1 if maps.region is None else int(maps.region.max()) + 1


@dataclass(frozen=True, eq=False)
class SurfaceMaps:
    """Maps of the surface behind photographs, and the radiance of the white card that they are relative to.

    Attributes
    ----------
    white : radiance of the card where it faces a lamp, 1 = white level of the photographs; ValueError unless positive.
    """

    maps: PbrMaps
    white: float = 1.0

    def __post_init__(self) -> None:
        if not 0.0 < self.white < np.inf:
            raise ValueError(f"a white card of radiance {self.white}")


def _check(name: str, values: Map | None, shape: tuple[int, ...], low: float, high: float) -> None:
    if values is None:
        return
    wanted = (*shape, 3) if name in ("base_colour", "normal") else shape
    if values.shape != wanted or values.dtype != np.float32:
        raise ValueError(f"{name} must be float32 of {wanted}, got {values.dtype} of {values.shape}")
    if not (np.isfinite(values).all() and low <= values.min(initial=high) and values.max(initial=low) <= high):
        raise ValueError(f"{name} must be finite and in [{low:g}, {high:g}]")
    values.flags.writeable = False


def _check_sigma(name: str, sigma: Map | None, wanted: tuple[int, ...]) -> None:
    if sigma is None:
        return
    if sigma.shape != wanted or sigma.dtype != np.float32 or not (sigma >= 0.0).all():
        raise ValueError(f"the uncertainty of {name} must be float32 of {wanted}, zero or more")
    sigma.flags.writeable = False
