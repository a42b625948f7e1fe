"""Everything that one image shows: model, ground, material, BRDF, light and camera, as one value.

The GL renderer (`engine.gl.direct`) and the CPU renderer (`engine.render.direct`) draw the same scene to the same
numbers. Following Kautz2004 Sec. 4, the light is one direction or several, chosen by importance from an
environment map and spread over lamps, of irradiance E_j perpendicular to them:

    r_j = sigma Y(f_r(wi_j, wo)) cos(theta_j),    radiance = sum_j S(r_j) E_j    (Kautz2004 Eq. 2, Kautz2004 Eq. 3)

where Y is the luminance; the material's colour is in S. The look-up is inside the sum, because S is not linear.
Figure 6 compares this look-up, 'radiance', with three others; there rho_j = sigma Y(f_r) / r_max:

    texture   S(r_max) sum rho_j cos(theta_j) E_j                a lit texture
    outgoing  S(Y(L)) L / Y(L) with L = sum r_j E_j              the look-up outside the integral
    angle     sum S(r_max cos(theta_j)) rho_j E_j                the slice from the light's angle alone

For a Lambertian surface photographed from above, 'angle' and 'radiance' are one function. In a directional map, S
depends on the azimuth of the light as well (`engine.shading.directional.effective_light`): on that of each light, and
in 'texture' and 'outgoing' on that of the mean of all, weighted by r. PBR maps hold a BRDF at each texel:
with them the image shows sum f_r cos(theta_j) E_j, f_r that of the texel, in the frame that the map of normals bends.
Without a material it shows the same with one f_r. Parts of a model with materials of their own show these, and colours
of vertices multiply base colours. Lights below the surface's own horizon add nothing, and what other
parts of the model would reflect is not part of these images. Sharp lights (the one light, lamps, near lamps and the
suns of the environment) cast shadows where the scene has `shadows`; the lights that stand for the rest of an
environment reach every point.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import isfinite, radians
from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from engine.brdf.brdf import Brdf, brdf_from_text
from engine.core.cached import cached_property
from engine.core.directions import normalize, world_direction
from engine.core.errors import UsageError
from engine.geometry.brushing import Brushing
from engine.geometry.camera import Camera, Vector
from engine.geometry.ground import Ground, with_ground
from engine.geometry.mesh import Mesh
from engine.light.environment import NO_LIGHTS, DistantLights, EnvironmentMap
from engine.light.lamps import Lamp, lights_from_all_sides, lights_of_all
from engine.light.light_tree import choose_lights
from engine.light.near_lamps import NearLamp, near_irradiance
from engine.light.sun_split import split_sun
from engine.scene.material import Material, auto_sigma
from engine.scene.settings import DEFAULTS
from engine.shading.directional.effective_light import EffectiveCosine, effective_cosine
from engine.shading.directional.planes import DirectionalMap
from engine.shading.lookup import Above
from engine.shading.power_law import PowerLawMap
from engine.shading.shading_map import ShadingMap
from engine.surface.pbr_maps import PbrMaps

Source = Literal["slices", "power-law"]
Lookup = Literal["radiance", "texture", "outgoing", "angle"]

TilingMode = Literal["grid", "hex"]

SOURCES: tuple[Source, ...] = ("slices", "power-law")
LOOKUPS: tuple[Lookup, ...] = ("radiance", "texture", "outgoing", "angle")
ABOVES: tuple[Above, ...] = ("clamp", "scale")
TILING_MODES: tuple[TilingMode, ...] = ("grid", "hex")

#: Most directions of an environment: four times what the smoothest image needs.
MAX_DIRECTIONS = 4096

#: Most irradiance: times the brightest texel and squared it is still a number.
MAX_IRRADIANCE = 1e100

#: Most lamps beside it; a texture of all lights then still fits every graphics device.
MAX_LAMPS = 64


def direction_of(light_deg: tuple[float, float] | None) -> tuple[float, float, float]:
    """The world direction of a light by its angles from +Y, and from +Z towards +X; None for the default."""
    x, y, z = world_direction(*map(radians, light_deg or DEFAULTS.light_deg))
    return float(x), float(y), float(z)


#: World direction towards the light where no other is given.
DEFAULT_LIGHT = direction_of(None)


#: Radiance (n, 3), which may be negative, at places in triangles: their corners (n, 3) and barycentric weights (n, 3).
Shade = Callable[[NDArray[np.int64], NDArray[np.float64]], NDArray[np.float64]]


class RelightTransport(Protocol):
    """Transport of whatever method under its light.

    Attributes
    ----------
    method : the name of the method (`engine.transport.method`).
    flat_vertex : the first vertex that is as bright towards every side.
    size_bytes : of the light in the rows of the transport.
    """

    @property
    def method(self) -> str: ...
    @property
    def transport(self) -> Any: ...
    @property
    def mesh(self) -> Mesh: ...
    @property
    def flat_vertex(self) -> int: ...
    @property
    def size_bytes(self) -> int: ...
    def shade(self, eye: Vector) -> Shade:
        """Radiance seen from `eye`."""


@dataclass(frozen=True, eq=False)
class Scene:
    """One model with one material under one directional light or an environment, and any lamps beside it.

    Attributes
    ----------
    light : (3,) world direction towards the light.
    irradiance : of the light on a surface that faces it; with an environment, the factor on the map's radiance. With
        0 and no environment, the lamps are the only lights.
    environment : takes the place of the light.
    environment_rotation : radians about +Y, as `DistantLights.rotated`.
    directions : how many lights stand for the environment; powers of two are spread best.
    source : which form of the material is looked up, where it has both.
    repeats : how often the material repeats over one unit of texture coordinates.
    tiling_mode : 'grid' where each repeat shows the same; 'hex' for maps in hexagonal cells that all differ.
    lamps : lights beside the one or the environment, in the world; the rotation and the factor are not theirs.
    near_lamps : lights near the model, in its coordinates; of baked methods those that know `near_light` show them.
    ground : what the model stands on; None for nothing.
    faint : irradiance that comes from all sides besides, over that of all lights.
    shadows : whether sharp lights cast shadows; the tiny bright sources of an environment are then lights of their own.
    relit : a bake of the model relit by this light (`engine.transport.relight`), which is drawn in place of sums over
        lights by whoever can draw it; with a material, its texels are shown in that light (`engine.render.shadowed`).
    """

    mesh: Mesh
    camera: Camera
    brdf: Brdf
    material: Material | None = None
    light: tuple[float, float, float] = DEFAULT_LIGHT
    irradiance: float = DEFAULTS.irradiance
    source: Source = "slices"
    lookup: Lookup = "radiance"
    above: Above = "clamp"
    repeats: float = DEFAULTS.repeats
    tiling_mode: TilingMode = "grid"
    environment: EnvironmentMap | None = None
    environment_rotation: float = 0.0
    directions: int = 64
    lamps: tuple[Lamp, ...] = ()
    near_lamps: tuple[NearLamp, ...] = ()
    ground: Ground | None = None
    faint: float = 0.0
    shadows: bool = False
    relit: RelightTransport | None = None

    def __post_init__(self) -> None:
        if self.source not in SOURCES or self.lookup not in LOOKUPS or self.above not in ABOVES:
            raise UsageError(f"unknown source {self.source!r}, form {self.lookup!r} or region above {self.above!r}")
        if not 0.0 <= self.irradiance <= MAX_IRRADIANCE:
            raise UsageError(f"an irradiance of {self.irradiance!r} is outside 0 … {MAX_IRRADIANCE:g}")
        if self.tiling_mode not in TILING_MODES:
            raise UsageError(f"unknown tiling mode {self.tiling_mode!r}; choose from {', '.join(TILING_MODES)}")
        if not 0.0 < self.repeats < float("inf"):
            raise UsageError(f"{self.repeats!r} repeats are not a positive number")
        if not (isfinite(self.environment_rotation) and 1 <= self.directions <= MAX_DIRECTIONS):
            raise UsageError(
                f"a rotation of {self.environment_rotation} or {self.directions} directions (1 … {MAX_DIRECTIONS}) "
                "is not possible"
            )
        if max(len(self.lamps), len(self.near_lamps)) > MAX_LAMPS:
            count = max(len(self.lamps), len(self.near_lamps))
            raise UsageError(f"a scene has at most {MAX_LAMPS} lamps, not {count}")
        object.__setattr__(self, "lamps", tuple(self.lamps))
        object.__setattr__(self, "light", tuple(float(x) for x in normalize(self.light, (0.0, 1.0, 0.0))))

    @cached_property
    def lights(self) -> DistantLights:
        """Lights of the sums, in the world: those that stand for an environment, then the sharp ones, which are the one
        light or the suns that are split off and then those of the lamps, and last the faint ones from all sides."""
        found = self._soft.beside(self.sharp_lights)
        if self.faint == 0.0:
            return found
        near = near_irradiance(self.near_lamps, self.mesh.centre, self.mesh.radius)
        return found.beside(lights_from_all_sides(found, self.faint, near))

    @property
    def casting(self) -> range:
        """The lights, by their place among `lights`, that cast shadows."""
        first = len(self._soft.direction)
        return range(first, first + len(self.sharp_lights.direction)) if self.shadows else range(0)

    @cached_property
    def _soft(self) -> DistantLights:
        """Lights that stand for the environment, without its suns where these cast shadows."""
        if self.environment is None:
            return NO_LIGHTS
        chosen = choose_lights(split_sun(self.environment)[0] if self.shadows else self.environment, self.directions)
        return DistantLights(chosen.direction, chosen.irradiance * self.irradiance).rotate(self.environment_rotation)

    @cached_property
    def sharp_lights(self) -> DistantLights:
        """The one light, or the suns of the environment where they cast shadows, and then those of the lamps."""
        lamps = lights_of_all(self.lamps)
        if self.environment is None:
            one = DistantLights(np.array([self.light]), np.full((1, 3), self.irradiance))
            return lamps if self.lamps and self.irradiance == 0.0 else one.beside(lamps)
        if not self.shadows:
            return lamps
        suns = lights_of_all(split_sun(self.environment)[1])
        suns = DistantLights(suns.direction, suns.irradiance * self.irradiance).rotate(self.environment_rotation)
        return suns.beside(lamps)

    @cached_property
    def surface(self) -> Mesh:
        """Surface that rays meet: the model, and after it the vertices and triangles of the ground if there is one."""
        return self.mesh if self.ground is None else with_ground(self.mesh, self.ground)[0]

    @property
    def pbr(self) -> PbrMaps | None:
        """The PBR maps, in whose place `brdf` stands where one BRDF is wanted; None without any."""
        return None if self.material is None else self.material.pbr

    @property
    def texture_scale(self) -> float:
        """Repeats of the maps over one unit of texture coordinates; maps of UDIM tiles hold several units."""
        return self.repeats / (1 if self.pbr is None else self.pbr.tiles)

    @property
    def shading(self) -> ShadingMap | PowerLawMap | DirectionalMap | None:
        """The form of the material that is looked up: the wanted one, or the one it has; None without a material."""
        if self.material is None:
            return None
        if self.material.directional is not None:
            return self.material.directional
        slices, power_law = self.material.shading_map, self.material.power_law
        return (slices or power_law) if self.source == "slices" else (power_law or slices)

    @cached_property
    def parts(self) -> tuple[Scene, ...]:
        """The scene with the material of each part of the model (`Mesh.part`) on everything; itself alone where all
        have one. Parts whose names the material does not know have the material itself."""
        found = materials_of_parts(self.mesh, self.material)
        if not found:
            return (self,)
        scenes = tuple(replace(self, material=each, brdf=each.reflectance) for each in found)
        shared = {name: getattr(self, name) for name in ("_soft", "sharp_lights", "lights")}
        for scene in scenes:
            vars(scene).update(shared)
        return scenes

    @property
    def colours(self) -> NDArray[np.float32] | None:
        """Colours (V, 3) of the vertices of the model, which multiply the base colours of PBR maps; None for none."""
        return None if self.pbr is None else self.mesh.colours

    @property
    def has_texels(self) -> bool:
        """True if the material is not the same everywhere: it has maps."""
        return self.pbr is not None or self.shading is not None

    @property
    def sigma(self) -> float:
        """The factor in r: the material's own, or the one that fits the capture; 1 without a material."""
        if self.material is None or self.shading is None:
            return 1.0
        if self.material.sigma is not None:
            return self.material.sigma
        if isinstance(self.shading, DirectionalMap):
            largest = self.effective_cosine.largest
            return self.shading.r_max / largest if largest > 0.0 else 1.0
        return auto_sigma(self.brdf, [radians(e) for e in self.material.elevation_deg], self.shading.r_max)

    @cached_property
    def effective_cosine(self) -> EffectiveCosine:
        """The table of the scene's BRDF by which a directional map is looked up."""
        return effective_cosine(self.brdf)


def materials_of_parts(mesh: Mesh, material: Material | None) -> tuple[Material, ...]:
    """The material of each part of a model, by the names of its parts; nothing where all have one.

    Parts whose names `material` does not know have the material itself.
    """
    if material is None or not material.parts or len(mesh.part_names) < 2:
        return ()
    known = {each.name: each for each in material.parts}
    return tuple(known.get(name, material) for name in mesh.part_names)


def brdfs_of_parts(mesh: Mesh, material: Material | None) -> tuple[Brdf, ...]:
    """The BRDF of each part of a model, that at the mean of its maps where it has maps; nothing where all have one."""
    return tuple(each.reflectance for each in materials_of_parts(mesh, material))


def make_scene(
    mesh: Mesh,
    camera: Camera,
    *,
    brdf: Brdf | None = None,
    material: Material | None = None,
    light_deg: tuple[float, float] | None = None,
    irradiance: float = DEFAULTS.irradiance,
    environment: EnvironmentMap | None = None,
    environment_rotation_deg: float = DEFAULTS.environment_rotation_deg,
    lamps: Sequence[Lamp] = (),
    near_lamps: Sequence[NearLamp] = (),
    ground_albedo: float | None = None,
    brushing: Brushing | None = None,
    **options: Any,
) -> Scene:
    """Make the scene of what a user names; the command line and the library share it.

    Parameters
    ----------
    brdf : in place of the material's own; a Phong BRDF where neither is given.
    light_deg : angles of the one light from +Y, and from +Z towards +X. Where lamps alone are given, it is out.
    irradiance : of the light, or the factor on the environment.
    ground_albedo : of a ground below the model; None for no ground.
    brushing : direction of an anisotropic BRDF; None for that of the model.
    **options : further fields of `Scene`.
    """
    only_lamps = bool(lamps or near_lamps) and environment is None and light_deg is None
    options.setdefault("light", direction_of(light_deg))
    return Scene(
        mesh=mesh if brushing is None else mesh.brush(brushing),
        camera=camera,
        brdf=brdf or (material.reflectance if material is not None else brdf_from_text("phong")),
        material=material,
        irradiance=0.0 if only_lamps else irradiance,
        environment=environment,
        environment_rotation=radians(environment_rotation_deg),
        lamps=tuple(lamps),
        near_lamps=tuple(near_lamps),
        ground=None if ground_albedo is None else Ground(albedo=ground_albedo),
        **options,
    )
