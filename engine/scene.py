"""Everything that one picture shows: model, material, reflectance, light and camera, as one value.

The GL renderer (`engine.gl.direct`) and the CPU renderer (`engine.render.direct`) draw the same scene to the same
numbers. Following Kautz et al. 2004, section 4, with a directional light of irradiance L (perpendicular to it):

    r = sigma Y(f_r(wi, wo)) cos(theta_i),    radiance = S(r) L            (Eqs. 2 and 3)

where Y is the luminance; the material's colour is in S. Figure 6 compares this look-up, 'radiance', with three others:

    texture   S(r_max) r / r_max L                      a lit texture
    outgoing  S(r L)                                    the look-up outside the integral
    angle     S(r_max cos(theta_i)) sigma Y(f_r) / r_max L    the slice from the light's angle alone

For a Lambertian surface photographed from above, 'angle' and 'radiance' are one function. Without a material the
picture shows f_r cos(theta_i) L.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import radians
from typing import Literal

from engine.brdf.brdf import Brdf
from engine.camera import Camera
from engine.directions import normalize
from engine.material import Material, auto_sigma
from engine.mesh import Mesh
from engine.shading.lookup import Above
from engine.shading.power_law import PowerLawMap
from engine.shading.shading_map import ShadingMap

Source = Literal["slices", "power-law"]
Lookup = Literal["radiance", "texture", "outgoing", "angle"]

SOURCES: tuple[Source, ...] = ("slices", "power-law")
LOOKUPS: tuple[Lookup, ...] = ("radiance", "texture", "outgoing", "angle")
ABOVES: tuple[Above, ...] = ("clamp", "scale")


@dataclass(frozen=True, eq=False)
class Scene:
    """One model with one material under one directional light.

    Attributes
    ----------
    light : (3,) world direction towards the light.
    irradiance : L, of the light on a surface that faces it.
    source : which form of the material is looked up, where it has both.
    repeats : how often the material repeats over one unit of texture coordinates.
    """

    mesh: Mesh
    camera: Camera
    brdf: Brdf
    material: Material | None = None
    light: tuple[float, float, float] = (0.35, 0.6, 0.72)
    irradiance: float = 1.0
    source: Source = "slices"
    lookup: Lookup = "radiance"
    above: Above = "clamp"
    repeats: float = 4.0

    def __post_init__(self) -> None:
        if self.source not in SOURCES or self.lookup not in LOOKUPS or self.above not in ABOVES:
            raise ValueError(f"unknown source {self.source!r}, lookup {self.lookup!r} or above {self.above!r}")
        if not (0.0 <= self.irradiance < float("inf") and 0.0 < self.repeats < float("inf")):
            raise ValueError(f"irradiance {self.irradiance!r} or repeats {self.repeats!r} is not a positive number")
        object.__setattr__(self, "light", tuple(float(x) for x in normalize(self.light, (0.0, 1.0, 0.0))))

    @property
    def shading(self) -> ShadingMap | PowerLawMap | None:
        """The form of the material that is looked up: the wanted one, or the one it has; None without a material."""
        if self.material is None:
            return None
        slices, power_law = self.material.shading_map, self.material.power_law
        return (slices or power_law) if self.source == "slices" else (power_law or slices)

    @property
    def sigma(self) -> float:
        """The factor in r: the material's own, or the one that fits the capture; 1 without a material."""
        if self.material is None or self.shading is None:
            return 1.0
        if self.material.sigma is not None:
            return self.material.sigma
        return auto_sigma(self.brdf, [radians(e) for e in self.material.elevation_deg], self.shading.r_max)
