"""A material: the mesostructure (shading map or its compression) and the BRDF that looks it up, or PBR maps.

PBR maps are a BRDF for each texel. What has room for one BRDF takes `brdf`, the one at the mean of the maps.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.brdf.brdf import MODELS, Brdf, brdf_from_text, brdf_to_text
from engine.brdf.fit import fit_data, fit_error
from engine.brdf.models.microfacet import MetallicRoughness
from engine.brdf.models.model import Model
from engine.brdf.table import DirectionTable, HalfDifferenceTable
from engine.core.colour import luminance
from engine.core.directions import surface_direction
from engine.core.health import Health
from engine.core.params import parameters
from engine.core.summary import Summary
from engine.scene.credits import Credits
from engine.shading.directional.planes import DirectionalMap
from engine.shading.power_law import PowerLawMap
from engine.shading.shading_map import ShadingMap
from engine.surface.layered import MAX_F0
from engine.surface.pbr_maps import PbrMaps, SurfaceMaps

if TYPE_CHECKING:
    from engine.factor.homomorphic import HomomorphicFactors
    from engine.factor.separable_factors import SeparableFactors


@dataclass(frozen=True, eq=False, repr=False)
class Material(Summary):
    """Material of a model.

    Attributes
    ----------
    shading_map, power_law : at least one of them where the material comes from photographs along one arc.
    directional : in their place where lamps stood on several sides.
    pbr : in their place where the material is a BRDF for each texel.
    brdf : the text that names the BRDF, as on the command line (`phong:exponent=20`).
    sigma : the factor in r = sigma f_r cos(theta_i); None means automatic (see `auto_sigma`).
    elevation_deg : elevations of the lights of the capture, which the automatic sigma needs.
    name : shown to users.
    measured : the BRDF as it was measured, a table, or factors, which a bundle holds as a table; `brdf` is then
        the model nearest to it, for what holds no table.
    surface : PBR maps of the surface behind the photographs, beside what is looked up. Exports take them; nothing is
        drawn from them here.
    parts : materials of the parts of the model that it came with, by their names; one for each name that its file has.
        What has room for one material takes this one.
    credits : its title, author, licence and source, as far as they are known.
    mask : (H, W) bool, True for texels of the object; the others are background, which pages show transparent. None
        where all are the object's.
    """

    shading_map: ShadingMap | None
    power_law: PowerLawMap | None
    brdf: str = "phong:exponent=20"
    sigma: float | None = None
    elevation_deg: tuple[float, ...] = ()
    name: str = "material"
    health: Health = field(default_factory=Health)
    measured: HalfDifferenceTable | DirectionTable | SeparableFactors | HomomorphicFactors | None = None
    directional: DirectionalMap | None = None
    pbr: PbrMaps | None = None
    surface: SurfaceMaps | None = None
    mask: NDArray[np.bool_] | None = None
    credits: Credits = field(default_factory=Credits)
    parts: tuple[Material, ...] = ()

    @property
    def has_map(self) -> bool:
        """True if texels are looked up on a surface: the material comes from photographs, or is PBR maps."""
        return self.maps != (None, None, None, None)

    @property
    def maps(self) -> tuple[ShadingMap | None, PowerLawMap | None, DirectionalMap | None, PbrMaps | None]:
        """Slices, power law, planes and PBR maps."""
        return self.shading_map, self.power_law, self.directional, self.pbr

    @property
    def size(self) -> tuple[int, int]:
        """(H, W) in texels of what comes from photographs, or of PBR maps; ValueError where there is neither."""
        if self.pbr is not None:
            return self.pbr.size
        if self.directional is not None:
            return self.directional.planes.shape[1], self.directional.planes.shape[2]
        if self.shading_map is not None:
            return self.shading_map.slices.shape[1], self.shading_map.slices.shape[2]
        if self.power_law is not None:
            return self.power_law.error_map.shape[0], self.power_law.error_map.shape[1]
        raise ValueError("a material without photographs has no texels")

    def looking_like(self, other: Material) -> Material:
        """This material with the name, the BRDF and the scale of another."""
        return replace(self, **{name: getattr(other, name) for name in ("name", "brdf", "measured", "sigma")})

    @property
    def reflectance(self) -> Brdf:
        """The measured BRDF, or else the model that `brdf` names."""
        return self.measured or brdf_from_text(self.brdf)

    def summary(self) -> dict[str, Any]:
        """Return what `repr` says."""
        kinds = ("slices", "power law", "planes", "PBR maps")
        maps = [kind for kind, held in zip(kinds, self.maps, strict=True) if held is not None]
        height, width = self.size if maps else (0, 0)
        facts = {"name": self.name, "maps": ", ".join(maps) or "none", "size": f"{width} × {height} texels"}
        return {**facts, "brdf": self.brdf, "warnings": len(self.health.warnings)}


def material_of_maps(maps: PbrMaps, name: str, health: Health | None = None) -> Material:
    """A material of PBR maps, whose one BRDF is `metallic-roughness`, or the OpenPBR model of layers, at their mean."""
    base = tuple(round(float(mean), 5) for mean in maps.base_colour.mean(axis=(0, 1), dtype=np.float64))
    metallic, roughness = (round(float(each.mean(dtype=np.float64)), 5) for each in (maps.metallic, maps.roughness))
    mean: Model = replace(
        maps.of_gltf or MetallicRoughness(),
        base_color=(base[0], base[1], base[2]),
        metallic=metallic,
        roughness=max(roughness, 0.01),
        multiple_scattering=float(maps.multiple_scattering),
    )
    if maps.openpbr is not None:
        root = min(float(maps.f0.mean(dtype=np.float64)), MAX_F0) ** 0.5
        largest = next(each.high for each in parameters(maps.openpbr) if each.name == "specular_ior")
        mean = replace(
            maps.openpbr,
            base_color=(base[0], base[1], base[2]),
            base_metalness=metallic,
            specular_roughness=roughness,
            specular_ior=min(round((1.0 + root) / (1.0 - root), 5), largest),
        )
    return Material(None, None, brdf_to_text(mean), name=name, health=health or Health(), pbr=maps)


def without_maps(material: Material) -> Material:
    """The material as its BRDF alone, and its parts as theirs."""
    parts = tuple(without_maps(each) for each in material.parts)
    return replace(material, shading_map=None, power_law=None, directional=None, pbr=None, parts=parts)


def material_of_brdfs(brdfs: Sequence[Brdf], names: Sequence[str]) -> Material:
    """A material whose parts of these `names` have these BRDFs."""
    parts = []
    for brdf, name in zip(brdfs, names, strict=True):
        plain = Material(None, None, name=name)
        is_model = type(brdf) in MODELS.values()
        measured: Any = None if is_model else brdf
        parts.append(replace(plain, brdf=brdf_to_text(brdf) if is_model else plain.brdf, measured=measured))
    return replace(parts[0], parts=tuple(parts))


def at_mean(material: Material) -> Material:
    """The material with PBR maps of one texel, the mean of all, and its parts with theirs."""
    parts = tuple(at_mean(each) for each in material.parts)
    maps = material.pbr
    if maps is None:
        return replace(material, parts=parts)

    def mean(values: NDArray[np.float32]) -> NDArray[np.float32]:
        return np.asarray(values.mean(axis=(0, 1), keepdims=True, dtype=np.float64), np.float32)

    kept = {"multiple_scattering": maps.multiple_scattering, "layers": maps.layers}
    flat = np.array([[[0.0, 0.0, 1.0]]], np.float32)
    values = [mean(each) for each in (maps.base_colour, maps.roughness, maps.metallic, maps.f0)]
    one = PbrMaps(values[0], flat, *values[1:], **kept)  # type: ignore[arg-type]
    return replace(material, pbr=one, parts=parts)


def set_multiple_scattering(material: Material, on: bool) -> Material:
    """The material whose PBR maps have the light that facets scatter more than once, or not; ValueError without any."""
    if material.pbr is None:
        raise ValueError("multiple scattering is that of PBR maps")
    maps = replace(material.pbr, multiple_scattering=on)
    plain = [each.pbr is not None and each.pbr.openpbr is None for each in material.parts]
    parts = tuple(
        set_multiple_scattering(each, on) if has_none else each
        for each, has_none in zip(material.parts, plain, strict=True)
    )
    return replace(material, pbr=maps, brdf=material_of_maps(maps, material.name).brdf, parts=parts)


def error_figures(material: Material) -> dict[str, Any]:
    """Amounts and errors of compression and tiling, for the manifest of a bundle and for scripts.

    `rms`, `quantisation_*_radiance` and `max_error_radiance` are in units of radiance, `seam_error` is the ratio of
    steps across the seams to steps inside the sample; None for what does not apply to `material`.
    """
    shading_map, power_law = material.shading_map, material.power_law
    storage = power_law.storage if power_law is not None else None
    rounded = storage if storage is not None and storage.exponent_bits < 32 else None
    compressed: Mapping[str, float] = power_law.health.figures if power_law is not None else {}
    tiled = shading_map.health if shading_map is not None else material.health
    seam_error = tiled.figures.get("seam_error")
    height, width = material.size if seam_error is not None else (None, None)
    return {
        "rms": power_law.rms if power_law is not None else None,
        "exponent_bits": storage.exponent_bits if storage is not None else None,
        "quantisation_bound_radiance": rounded.bound if rounded is not None else None,
        "quantisation_error_radiance": rounded.measured if rounded is not None else None,
        "max_error_radiance": compressed.get("error_bound"),
        "kept_tile_fraction": compressed.get("kept_tile_fraction"),
        "seam_error": seam_error,
        "tile_width_px": width,
        "tile_height_px": height,
        "brdf_fit_rmse_rel": compute_fit_error(material),
    }


def compute_fit_error(material: Material) -> float | None:
    """Relative RMSE of f cos(theta_i) of the model that `brdf` names against the measured BRDF; None without one."""
    if material.measured is None:
        return None

    return fit_error(brdf_from_text(material.brdf), fit_data(material.measured)).rmse_rel


def auto_sigma(brdf: Brdf, elevation: ArrayLike, r_max: float) -> float:
    """The sigma of r = sigma f_r cos(theta_i) (Kautz2004 Eq. 2) that makes model and photographs agree.

    The largest r over the lights of the capture, seen from above, becomes `r_max`; f_r counts with its luminance.

    Parameters
    ----------
    elevation : (N,) radians above the sample plane, the capture's lights; empty where unknown, and then the light
        is taken to have stood overhead.
    r_max : a_max, the mean luminance of the brightest photograph.

    Returns
    -------
    sigma > 0; 1 where the BRDF reflects nothing on the arc, so that r is 0 rather than undefined.
    """
    elevation = np.asarray(elevation, np.float64).reshape(-1)
    wi = surface_direction(np.pi / 2 - (elevation if elevation.size else np.array([np.pi / 2])))
    largest = float(np.max(luminance(brdf.f(wi, (0.0, 0.0, 1.0))) * wi[:, 2], initial=0.0))
    return r_max / largest if largest > 0.0 and r_max > 0.0 else 1.0
