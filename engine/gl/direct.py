"""Draws a `Scene`: one pass per tile of the image into a texture of linear radiance, then tone mapping.

The counterpart of `engine.render.direct`. Sub-pixels, tiles and bands are those of `engine.gl.tiles`. Meshes, materials
and lights are uploaded when they are other objects than the last time.

Textures of what light is looked up by: the directional lights of a scene, and the cosines of a directional map.
"""

from __future__ import annotations

import logging
from collections.abc import Generator, Iterator, Sequence
from dataclasses import replace

import moderngl
import numpy as np
from numpy.typing import NDArray

from engine.brdf.brdf import MODELS, Brdf, model_name
from engine.brdf.models.diffuse import Lambert
from engine.brdf.models.model import Model
from engine.core.params import parameters
from engine.geometry.ground import Ground, with_ground
from engine.geometry.mesh import Mesh
from engine.gl.brdf_textures import SOURCE, FactorTextures, PbrTextures, TableTexture, factor_source, factor_textures
from engine.gl.buffers import MeshBuffers
from engine.gl.context import Limits, limits
from engine.gl.material_textures import MaterialTextures, Shading
from engine.gl.program import ShaderError, find_uniform, load_program, set_uniforms
from engine.gl.shadow_maps import Key, ShadowMaps, key_of
from engine.gl.tiles import Paint, Tiles
from engine.light.environment import DistantLights
from engine.light.near_lamps import NearLamp
from engine.render.display import Display
from engine.render.near_light import facets_of
from engine.scene.scene import Scene, TilingMode
from engine.shading.directional.effective_light import EffectiveCosine
from engine.surface.pbr_maps import PbrMaps

#: Texture units of both, above those of a material.
COSINE_UNIT, LIGHT_UNIT, NEAR_UNIT = 3, 4, 7


class LightTexture:
    """Owns the texture of one set of lights: a row for each, its direction and its irradiance in float32."""

    def __init__(self, context: moderngl.Context, lights: DistantLights) -> None:
        count = len(lights.direction)
        texels = np.ones((count, 2, 4), np.float32)
        texels[:, 0, :3] = lights.direction
        texels[:, 1, :3] = np.minimum(lights.irradiance, np.finfo(np.float32).max)
        self.texture = context.texture((2, count), 4, texels, dtype="f4")
        self.texture.filter = (context.NEAREST, context.NEAREST)

    def bind(self, program: moderngl.Program) -> None:
        self.texture.use(LIGHT_UNIT)
        find_uniform(program, "lights").value = LIGHT_UNIT

    def release(self) -> None:
        self.texture.release()


class NearLampTexture:
    """Owns the texture of lights near a model: a row of six texels for each, as `near_lamps.glsl` reads them."""

    def __init__(self, context: moderngl.Context, lamps: Sequence[NearLamp], centre: NDArray[np.float64]) -> None:
        texels = np.zeros((len(lamps), 6, 4))
        for row, lamp in zip(texels, lamps, strict=True):
            row[0] = (*(np.asarray(lamp.position) - centre), ("sphere", "rectangle", "disc").index(lamp.shape))
            row[1:3, :3], row[1:3, 3] = lamp.half_sides, (lamp.extent, lamp.radius)
            row[3, :3], row[4, :3] = lamp.facing, lamp.intensity
            row[5, :3] = 0.0 if lamp.is_point else lamp.radiance
        largest = np.finfo(np.float32).max
        content = np.clip(texels, -largest, largest).astype(np.float32)
        self._count = len(lamps)
        self._texture = context.texture((6, len(lamps)), 4, np.ascontiguousarray(content), dtype="f4")
        self._texture.filter = (context.NEAREST, context.NEAREST)

    def bind(self, program: moderngl.Program, points: int) -> None:
        self._texture.use(NEAR_UNIT)
        set_uniforms(program, {"near_lamps": NEAR_UNIT, "near_count": self._count, "near_points": points})

    def release(self) -> None:
        self._texture.release()


#: Definitions of a model that say what texels decide.
OF_TEXELS = ("NO_METAL", "NO_DIELECTRIC")


def _near_definitions(lamps: Sequence[NearLamp], brdf: Brdf | PbrMaps | None) -> dict[str, str]:
    """The definitions for lights near the model; `brdf` is None where a material is looked up."""
    if not lamps:
        return {}
    if isinstance(brdf, PbrMaps):
        return {"NEAR_LAMPS": "1"} if brdf.layers is not None else {"NEAR_LAMPS": "1", "FACETS": "1"}
    if brdf is not None and facets_of(brdf, 0) is not None:
        return {"NEAR_LAMPS": "1", "FACETS": "1", f"FACETS_{model_name(brdf).upper().replace('-', '_')}": "1"}
    return {"NEAR_LAMPS": "1"}


def _shadow_definitions(scene: Scene) -> dict[str, str]:
    """The definitions for shadows of sharp lights."""
    if key_of(scene) is None:
        return {}
    return {"SHADOWS": "1", **({"NEAR_LIGHTS": str(len(scene.near_lamps))} if scene.near_lamps else {})}


class CosineTexture:
    """Owns the texture of the table by which a directional map is looked up for one BRDF (`EffectiveCosine`).

    It holds powers of cosines over the power of the share, and azimuths, which repeat.
    """

    def __init__(self, context: moderngl.Context, table: EffectiveCosine) -> None:
        self.table = table
        rows, entries = table.power.shape
        self._texture = context.texture((entries, rows), 1, table.power.tobytes(), dtype="f4")
        self._texture.filter = (context.LINEAR, context.LINEAR)
        self._texture.repeat_x = False

    def bind(self, program: moderngl.Program) -> None:
        self._texture.use(COSINE_UNIT)
        set_uniforms(program, {"cosine_powers": COSINE_UNIT, "lowest_power": self.table.lowest})

    def release(self) -> None:
        self._texture.release()


log = logging.getLogger(__name__)


class DirectRenderer:
    """Owns everything that drawing a scene needs in GPU memory; belongs to one context and its thread.

    Attributes
    ----------
    messages : what had to be reduced or replaced for the last image, as sentences for a user.
    invalid_samples : with `debug`, how many samples of the last `radiance` were not finite (drawn magenta).
    """

    def __init__(self, context: moderngl.Context, *, texture_limits: Limits | None = None, debug: bool = False) -> None:
        self.context = context
        self.limits = texture_limits or limits(context)
        self.debug = debug
        self.messages: list[str] = []
        self._tiles = Tiles(context, self.limits)
        self._programs: dict[tuple[tuple[str, str], ...], moderngl.Program | None] = {}
        self._last_good: moderngl.Program | None = None
        self._mesh: tuple[Mesh, MeshBuffers] | None = None
        self._ground: tuple[Mesh, Ground, MeshBuffers] | None = None
        self._material: tuple[Shading, TilingMode, MaterialTextures] | None = None
        self._lights: tuple[DistantLights, LightTexture] | None = None
        self._near: tuple[tuple[tuple[NearLamp, ...], Mesh], NearLampTexture] | None = None
        self._shadows: tuple[Key, ShadowMaps] | None = None
        self._cosines: tuple[EffectiveCosine, CosineTexture] | None = None
        self._tables: dict[
            tuple[int, TilingMode], tuple[Brdf | PbrMaps, TableTexture | FactorTextures | PbrTextures]
        ] = {}

    def draw(
        self,
        scene: Scene,
        framebuffer: moderngl.Framebuffer,
        size: tuple[int, int],
        *,
        samples: int = 2,
        display: Display | None = None,
    ) -> None:
        """Draw `scene`, tone-mapped and sRGB-coded, over `framebuffer`, whose `size` is (width, height) in pixels."""
        self._tiles.draw(self._painting(scene, size), framebuffer, size, samples, display or Display())

    def bands(
        self, scene: Scene, framebuffer: moderngl.Framebuffer, size: tuple[int, int], *, samples: int = 2
    ) -> Generator[None, int, None]:
        """The linear image in pieces, as `Tiles.bands`; other drawing with this renderer meanwhile spoils it."""
        return self._tiles.bands(self._painting(scene, size), framebuffer, size, samples)

    def radiance(self, scene: Scene, size: tuple[int, int], *, samples: int = 2) -> NDArray[np.float32]:
        """The image (height, width, 4) float32, row 0 on top: linear radiance times coverage, and coverage."""
        return self._tiles.radiance(self._painting(scene, size), size, samples)

    @property
    def invalid_samples(self) -> int:
        return self._tiles.invalid_samples

    def _painting(self, scene: Scene, size: tuple[int, int]) -> Paint:
        return lambda tile_from_clip: self._paint(scene, size[0] / size[1], tile_from_clip)

    def _paint(self, scene: Scene, aspect: float, tile_from_clip: NDArray[np.float64]) -> None:
        """Draw everything for one tile."""
        self._prepare_mesh(scene)
        reach = self._prepare_ground(scene)
        self._prepare_shadows(scene, reach)
        clip_from_model = scene.camera.clip_from_model(scene.mesh.centre, reach, aspect)
        matrix = np.ascontiguousarray((tile_from_clip @ clip_from_model).T, np.float32)
        assert self._mesh is not None
        self._keep_tables(scene)
        self.messages = []
        for number, part in enumerate(scene.parts):
            program = self._prepare(part)
            find_uniform(program, "clip_from_model").write(matrix)
            self._mesh[1].draw(program, number if len(scene.parts) > 1 else None)
        self._draw_ground(scene, matrix)

    def _prepare_mesh(self, scene: Scene) -> None:
        if self._mesh is None or self._mesh[0] is not scene.mesh:
            if self._mesh is not None:
                self._mesh[1].release()
            self._mesh = (scene.mesh, MeshBuffers(self.context, scene.mesh))

    def _prepare_shadows(self, scene: Scene, reach: float) -> None:
        """Draw what sharp lights see, where they cast shadows and that is not known."""
        key = key_of(scene)
        if key is None or (self._shadows is not None and self._shadows[0] == key):
            return
        if self._shadows is not None:
            self._shadows[1].release()
            self._shadows = None
        assert self._mesh is not None
        casters = [self._mesh[1]]
        if scene.ground is not None and self._ground is not None:
            casters.append(self._ground[2])
        self._shadows = (key, ShadowMaps(self.context, key, casters, reach, self.limits))

    def _prepare_ground(self, scene: Scene) -> float:
        """Upload what the model stands on; returns how far from the centre of the model anything is."""
        if scene.ground is None:
            return scene.mesh.radius
        if self._ground is None or self._ground[0] is not scene.mesh or self._ground[1] != scene.ground:
            if self._ground is not None:
                self._ground[2].release()
            square = _square(scene.mesh, scene.ground)
            self._ground = (scene.mesh, scene.ground, MeshBuffers(self.context, square, scene.mesh.centre))
        corners = self._ground[2].mesh.positions - scene.mesh.centre
        return max(scene.mesh.radius, float(np.sqrt(np.max(np.sum(corners**2, axis=1)))))

    def _draw_ground(self, scene: Scene, matrix: NDArray[np.float32]) -> None:
        """The ground, where there is one: Lambertian, under the same lights."""
        if scene.ground is None or self._ground is None:
            return
        near = _near_definitions(scene.near_lamps, Lambert())
        definitions = {
            "BRDF": "brdf/lambert.glsl",
            "SOURCE_NONE": "1",
            **near,
            **_shadow_definitions(scene),
            **self._debug,
        }
        key = (("ground", ""), *definitions.items())
        if key not in self._programs:
            try:
                self._programs[key] = load_program(self.context, "direct.vert", "direct.frag", definitions)
            except ShaderError as error:
                log.error("%s", error)
                self._programs[key] = None
        program = self._programs[key]
        if program is None:
            self.messages.append("The ground cannot be drawn: its shader does not compile; see the log.")
            return
        eye = tuple(np.subtract(scene.camera.eye, scene.mesh.centre))
        set_uniforms(program, {"eye": eye, "repeats": 1.0, "brdf_albedo": (scene.ground.albedo,) * 3})
        self._bind_lights(program, scene)
        find_uniform(program, "clip_from_model").write(matrix)
        self._ground[2].draw(program)

    def _prepare(self, scene: Scene) -> moderngl.Program:
        """Upload what changed, choose the program and set its uniforms."""
        textures = self._upload(scene)
        program = self._program(scene, textures)
        self._say(textures.messages if textures else [])
        eye = np.subtract(scene.camera.eye, scene.mesh.centre)
        values = {
            "eye": tuple(eye),
            "sigma": scene.sigma,
            "repeats": scene.texture_scale,
            "r_max": textures.r_max if textures else 1.0,
            "layers": float(textures.layers) if textures else 0.0,
            "lowest_cosine": textures.lowest_cosine if textures else 1.0,
        }
        set_uniforms(program, values)
        self._set_brdf(program, scene)
        if textures:
            textures.bind(program)
            if textures.source == "SOURCE_PLANES":
                self._bind_cosines(program, scene)
        self._bind_lights(program, scene)
        return program

    def _bind_cosines(self, program: moderngl.Program, scene: Scene) -> None:
        table = scene.effective_cosine
        if self._cosines is None or self._cosines[0] is not table:
            if self._cosines is not None:
                self._cosines[1].release()
            self._cosines = (table, CosineTexture(self.context, table))
        self._cosines[1].bind(program)

    def _bind_lights(self, program: moderngl.Program, scene: Scene) -> None:
        if self._lights is None or self._lights[0] is not scene.lights:
            if self._lights is not None:
                self._lights[1].release()
            self._lights = (scene.lights, LightTexture(self.context, scene.lights))
        self._lights[1].bind(program)
        set_uniforms(program, {"light_count": len(scene.lights.direction)})
        if scene.near_lamps:
            key = scene.near_lamps, scene.mesh
            if self._near is None or self._near[0][0] != key[0] or self._near[0][1] is not key[1]:
                if self._near is not None:
                    self._near[1].release()
                self._near = (key, NearLampTexture(self.context, scene.near_lamps, scene.mesh.centre))
            self._near[1].bind(program, scene.directions)
        if self._shadows is not None and key_of(scene) is not None:
            self._shadows[1].bind(program)

    def _set_brdf(self, program: moderngl.Program, scene: Scene) -> None:
        """The parameters of a model as uniforms, factors as textures, or any other BRDF as a texture of its table."""
        brdf = scene.pbr or scene.brdf
        if type(brdf) in MODELS.values():
            set_uniforms(
                program, {f"brdf_{parameter.name}": getattr(brdf, parameter.name) for parameter in parameters(brdf)}
            )
            return
        key = id(brdf), scene.tiling_mode
        if key not in self._tables:
            owner: TableTexture | FactorTextures | PbrTextures
            if isinstance(brdf, PbrMaps):
                owner = PbrTextures(self.context, brdf, self.limits, scene.tiling_mode)
            else:
                owner = factor_textures(self.context, brdf) or TableTexture(self.context, brdf, self.limits)
            self._tables[key] = (brdf, owner)
        self._tables[key][-1].bind(program)
        self._say(self._tables[key][-1].messages)

    def _say(self, messages: Sequence[str]) -> None:
        self.messages += [each for each in messages if each not in self.messages]

    def _keep_tables(self, scene: Scene) -> None:
        """Free the textures of BRDFs and PBR maps that the scene does not have."""
        wanted = {(id(each.pbr or each.brdf), scene.tiling_mode) for each in scene.parts}
        for key in [each for each in self._tables if each not in wanted]:
            self._tables.pop(key)[-1].release()

    def load(self, shading: Shading, mode: TilingMode = "grid") -> Iterator[None]:
        """Bring the maps of a material to the device piece by piece, some milliseconds each; nothing is drawn
        meanwhile. Closing the iterator early leaves nothing that could be drawn."""
        if self._material is not None and self._material[0] is shading and self._material[1] == mode:
            return
        if self._material is not None:
            self._material[-1].release()
            self._material = None
        textures = MaterialTextures(self.context, shading, self.limits, mode)
        try:
            yield from textures.fill()
        except BaseException:
            textures.release()
            raise
        self._material = (shading, mode, textures)

    def _upload(self, scene: Scene) -> MaterialTextures | None:
        if scene.shading is None:
            if self._material is not None:
                self._material[-1].release()
                self._material = None
            return None
        for _ in self.load(scene.shading, scene.tiling_mode):
            pass
        assert self._material is not None
        return self._material[-1]

    def _program(self, scene: Scene, textures: MaterialTextures | None) -> moderngl.Program:
        """The program for this kind of scene; the last good one, with a log entry, where it does not compile."""
        definitions = {
            "BRDF": f"brdf/{PbrTextures.SOURCE if scene.pbr else _shader_of(scene.brdf)}.glsl",
            textures.source if textures else "SOURCE_NONE": "1",
        }
        definitions |= {f"LOOKUP_{scene.lookup.upper()}": "1", f"ABOVE_{scene.above.upper()}": "1"}
        if (len(scene.lights.direction) == 1 and not scene.near_lamps) or scene.lookup in ("texture", "outgoing"):
            definitions["ONE_LOOKUP"] = "1"
        definitions |= {"GAINS": "1"} if textures and textures.source != "SOURCE_SLICES" else {}
        if textures and textures.layers:
            definitions["PLANE_LAYERS" if textures.source == "SOURCE_PLANES" else "LAYERS"] = str(textures.layers)
        definitions |= _near_definitions(
            scene.near_lamps, None if scene.shading is not None else scene.pbr or scene.brdf
        )
        definitions |= _shadow_definitions(scene)
        if scene.pbr is not None and scene.pbr.openpbr is not None:
            definitions["PBR_LAYERS"] = "1"
            layers = scene.pbr.openpbr.shader_definitions
            definitions |= {name: value for name, value in layers.items() if name not in OF_TEXELS}
        elif scene.pbr is not None:
            definitions |= {} if scene.pbr.multiple_scattering else {"SINGLE_SCATTERING": "1"}
            over = scene.pbr.of_gltf
            definitions |= {"PBR_COAT": "1"} if over is not None and over.coat_weight else {}
            definitions |= {"PBR_SHEEN": "1"} if over is not None and any(over.sheen_color) else {}
        elif scene.pbr is None and isinstance(scene.brdf, Model):
            definitions |= scene.brdf.shader_definitions
        definitions |= {"HEX_TILING": "1"} if scene.has_texels and scene.tiling_mode == "hex" else {}
        definitions |= {"VERTEX_COLOURS": "1"} if scene.colours is not None else {}
        definitions |= {"PBR_MAPS": "1"} if scene.pbr else {} if scene.brdf.isotropic else {"BRUSHED": "1"}
        definitions |= self._debug
        key = tuple(definitions.items())
        if key not in self._programs:
            try:
                self._programs[key] = load_program(self.context, "direct.vert", "direct.frag", definitions)
            except ShaderError as error:
                if self._last_good is None:
                    raise
                log.error("%s", error)
                self._programs[key] = self._last_good
        program = self._programs[key]
        assert program is not None
        self._last_good = program
        return program

    @property
    def _debug(self) -> dict[str, str]:
        return {"DEBUG": "1"} if self.debug else {}

    def release(self) -> None:
        """Free everything; the renderer can be used again afterwards and uploads anew."""
        for owner in (
            *(
                self._mesh,
                self._ground,
                self._material,
                self._lights,
                self._near,
                self._cosines,
                self._shadows,
            ),
            *self._tables.values(),
        ):
            if owner is not None:
                owner[-1].release()
        for program in {id(program): program for program in self._programs.values() if program}.values():
            program.release()
        self._tiles.release()
        self._tables.clear()
        self._mesh = self._ground = self._material = self._lights = self._cosines = None
        self._near = self._shadows = None
        self._last_good = None
        self._programs.clear()


def _shader_of(brdf: Brdf) -> str:
    if type(brdf) in MODELS.values():
        return model_name(brdf)
    factors = factor_source(brdf)
    return factors.SOURCE if factors else SOURCE


def _square(mesh: Mesh, ground: Ground) -> Mesh:
    """The ground alone, as the two triangles that it is for the eye."""
    whole, first = with_ground(mesh, replace(ground, cells=1))
    kept = len(whole.positions) - 4
    arrays = (whole.positions[kept:], whole.normals[kept:], whole.uv[kept:], whole.faces[first:] - np.int32(kept))
    return Mesh(*arrays, name="ground")
