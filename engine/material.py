"""A material: the mesostructure (shading map or its compression) and the reflectance that looks it up."""

from __future__ import annotations

from dataclasses import dataclass, field

from engine.health import Health
from engine.shading.power_law import PowerLawMap
from engine.shading.shading_map import ShadingMap


@dataclass(frozen=True, eq=False)
class Material:
    """What is seen on a model.

    Attributes
    ----------
    shading_map, power_law : at least one of them where the material comes from photographs.
    brdf : the text that names the BRDF, as on the command line (`phong:exponent=20`).
    sigma : the factor in r = sigma f_r cos(theta_i); None means automatic (see `engine.brdf.brdf.auto_sigma`).
    elevation_deg : elevations of the lights of the capture, which the automatic sigma needs.
    name : shown to people.
    """

    shading_map: ShadingMap | None
    power_law: PowerLawMap | None
    brdf: str = "phong:exponent=20"
    sigma: float | None = None
    elevation_deg: tuple[float, ...] = ()
    name: str = "material"
    health: Health = field(default_factory=Health)
