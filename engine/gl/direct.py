"""Draws a `Scene`: one pass per tile of the picture into a texture of linear radiance, then tone mapping.

The twin of `engine.render.direct`. `samples` sub-pixels along each side of a pixel are shaded and averaged (a box,
symmetric about the pixel centre); with 1 the pixel centre alone. Pictures of any size are drawn in tiles of at most
2048 sub-pixels along a side, and where a window must go on meanwhile, band by band. Meshes, materials and lights are
uploaded when they are other objects than the last time.
"""

from __future__ import annotations

import logging
from collections.abc import Generator, Iterator
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.brdf.brdf import MODELS, model_name
from engine.gl.context import Limits, limits
from engine.gl.factor_textures import FactorTextures, factor_source
from engine.gl.light_texture import LightTexture
from engine.gl.material_textures import MaterialTextures
from engine.gl.mesh_buffers import MeshBuffers
from engine.gl.program import ShaderError, load_program, set_uniforms
from engine.gl.table_texture import SOURCE, TableTexture
from engine.gl.tonemap import ToneMapper
from engine.ground import Ground, with_ground
from engine.mesh import Mesh
from engine.params import parameters
from engine.render.display import Display
from engine.scene import Scene

#: Longest side of the texture that is drawn into, in sub-pixels.
TILE = 2048

#: A part of a picture: left, top, width, height in pixels.
Tile = tuple[int, int, int, int]

log = logging.getLogger(__name__)


class DirectRenderer:
    """Owns everything that drawing a scene needs in GPU memory; belongs to one context and its thread.

    Attributes
    ----------
    messages : what had to be reduced or replaced for the last picture, as sentences for a person.
    invalid_samples : with `debug`, how many samples of the last `radiance` were not finite (drawn magenta).
    """

    def __init__(self, context: Any, *, texture_limits: Limits | None = None, debug: bool = False) -> None:
        self.context = context
        self.limits = texture_limits or limits(context)
        self.debug = debug
        self.messages: list[str] = []
        self.invalid_samples = 0
        self._programs: dict[tuple[Any, ...], Any] = {}
        self._last_good: Any = None
        self._mesh: tuple[Any, MeshBuffers] | None = None
        self._ground: tuple[Mesh, Ground, MeshBuffers] | None = None
        self._material: tuple[Any, MaterialTextures] | None = None
        self._lights: tuple[Any, LightTexture] | None = None
        self._table: tuple[Any, TableTexture | FactorTextures] | None = None
        self._target: tuple[tuple[int, int], Any] | None = None
        self._tone_mapper: ToneMapper | None = None

    def draw(
        self, scene: Scene, framebuffer: Any, size: tuple[int, int], *, samples: int = 2, display: Display | None = None
    ) -> None:
        """Draw `scene`, tone-mapped and sRGB-coded, over `framebuffer`, whose `size` is (width, height) in pixels."""
        for tile, texture in self._tiles(scene, size, samples):
            self._show(tile, texture, framebuffer, size, samples, display or Display())

    def bands(
        self, scene: Scene, framebuffer: Any, size: tuple[int, int], *, samples: int = 2
    ) -> Generator[None, int, None]:
        """The linear picture in pieces, for a thread that has more to do: each `send(rows)` draws so many rows.

        Rows are of sub-pixels. The float32 `framebuffer` (`engine.gl.screen.Picture`) holds radiance times coverage,
        and coverage, when the generator ends; with 1, 2 or 4 samples they show what `draw` shows to the bit. Other
        drawing with this renderer in the meantime spoils it.
        """
        for tile in self._cut(size, samples):
            done, rows = 0, tile[3] * samples
            while done < rows:
                wanted = yield
                texture = self._shade(scene, size, tile, samples, (done, min(wanted, rows - done)))
                done += wanted
            self._show(tile, texture, framebuffer, size, samples, None)

    def radiance(self, scene: Scene, size: tuple[int, int], *, samples: int = 2) -> NDArray[np.float32]:
        """The picture (height, width, 4) float32, row 0 on top: linear radiance times coverage, and coverage."""
        picture = np.zeros((size[1], size[0], 4), np.float32)
        self.invalid_samples = 0
        for (left, top, width, height), texture in self._tiles(scene, size, samples):
            texels = np.frombuffer(texture.read(), np.float32).reshape(texture.height, texture.width, 4)
            part = texels[: height * samples, : width * samples]
            self.invalid_samples += int(np.sum(part[..., 3] > 1.5))
            blocks = np.minimum(part, (np.inf, np.inf, np.inf, 1.0)).reshape(height, samples, width, samples, 4)
            picture[top : top + height, left : left + width] = blocks.mean(axis=(1, 3), dtype=np.float64)[::-1]
        return picture

    def _tiles(self, scene: Scene, size: tuple[int, int], samples: int) -> Iterator[tuple[Tile, Any]]:
        """Draw tile by tile; yields each and the texture whose lower left holds it."""
        for tile in self._cut(size, samples):
            yield tile, self._shade(scene, size, tile, samples, (0, tile[3] * samples))

    def _cut(self, size: tuple[int, int], samples: int) -> Iterator[Tile]:
        if samples < 1:
            raise ValueError(f"samples = {samples} must be at least 1")
        edge = self._edge(samples)
        for top in range(0, size[1], edge):
            for left in range(0, size[0], edge):
                yield left, top, min(edge, size[0] - left), min(edge, size[1] - top)

    def _edge(self, samples: int) -> int:
        return max(1, min(TILE, self.limits.texture_size) // samples)

    def _shade(self, scene: Scene, size: tuple[int, int], tile: Tile, samples: int, band: tuple[int, int]) -> Any:
        """Draw the rows `band` (first, count) of sub-pixels of `tile`, from below; returns the texture they are in."""
        program = self._prepare(scene, size)
        edge = self._edge(samples)
        target = self._framebuffer((min(size[0], edge) * samples, min(size[1], edge) * samples))
        target.use()
        target.viewport = (0, 0, tile[2] * samples, tile[3] * samples)
        target.scissor = (0, band[0], tile[2] * samples, band[1])
        target.clear(0.0, 0.0, 0.0, 0.0)
        self.context.enable_only(self.context.DEPTH_TEST)
        reach = self._prepare_ground(scene)
        clip_from_model = scene.camera.clip_from_model(scene.mesh.centre, reach, size[0] / size[1])
        matrix = np.ascontiguousarray((_tile_from_clip(tile, size) @ clip_from_model).T, np.float32)
        program["clip_from_model"].write(matrix)
        assert self._mesh is not None
        self._mesh[1].draw(program)
        self._draw_ground(scene, matrix)
        target.scissor = None
        return target.color_attachments[0]

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
        definitions = {"BRDF": "brdf/lambert.glsl", "SOURCE_NONE": "1", **self._debug}
        key = ("ground", *definitions.items())
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
        program["clip_from_model"].write(matrix)
        self._ground[2].draw(program)

    def _show(
        self,
        tile: Tile,
        texture: Any,
        framebuffer: Any,
        size: tuple[int, int],
        samples: int,
        display: Display | None,
    ) -> None:
        if self._tone_mapper is None:
            self._tone_mapper = ToneMapper(self.context)
        left, top, width, height = tile
        rectangle = (left, size[1] - top - height, width, height)
        self._tone_mapper.draw(texture, framebuffer, rectangle, samples, display)

    def _prepare(self, scene: Scene, size: tuple[int, int]) -> Any:
        """Upload what changed, choose the program and set its uniforms."""
        if self._mesh is None or self._mesh[0] is not scene.mesh:
            if self._mesh is not None:
                self._mesh[1].release()
            self._mesh = (scene.mesh, MeshBuffers(self.context, scene.mesh))
        textures = self._upload(scene)
        program = self._program(scene, textures)
        self.messages = list(textures.messages) if textures else []
        eye = np.subtract(scene.camera.eye, scene.mesh.centre)
        values = {
            "eye": tuple(eye),
            "sigma": scene.sigma,
            "repeats": scene.repeats,
            "r_max": textures.r_max if textures else 1.0,
            "layers": float(textures.layers) if textures else 0.0,
        }
        set_uniforms(program, values)
        self._set_brdf(program, scene)
        if textures:
            textures.bind(program)
        self._bind_lights(program, scene)
        return program

    def _bind_lights(self, program: Any, scene: Scene) -> None:
        if self._lights is None or self._lights[0] is not scene.lights:
            if self._lights is not None:
                self._lights[1].release()
            self._lights = (scene.lights, LightTexture(self.context, scene.lights))
        self._lights[1].bind(program)
        set_uniforms(program, {"light_count": len(scene.lights.direction)})

    def _set_brdf(self, program: Any, scene: Scene) -> None:
        """The parameters of a model as uniforms, factors as textures, or any other BRDF as a texture of its table."""
        brdf = scene.brdf
        if type(brdf) in MODELS.values():
            set_uniforms(
                program, {f"brdf_{parameter.name}": getattr(brdf, parameter.name) for parameter in parameters(brdf)}
            )
            return
        if self._table is None or self._table[0] is not brdf:
            if self._table is not None:
                self._table[1].release()
                self._table = None
            factors = factor_source(brdf)
            owner = factors(self.context, brdf) if factors else TableTexture(self.context, brdf, self.limits)
            self._table = (brdf, owner)
        self._table[1].bind(program)
        self.messages += self._table[1].messages

    def _upload(self, scene: Scene) -> MaterialTextures | None:
        shading = scene.shading
        if self._material is not None and self._material[0] is not shading:
            self._material[1].release()
            self._material = None
        if shading is not None and self._material is None:
            self._material = (shading, MaterialTextures(self.context, shading, self.limits))
        return self._material[1] if self._material else None

    def _program(self, scene: Scene, textures: MaterialTextures | None) -> Any:
        """The program for this kind of scene; the last good one, with a log entry, where it does not compile."""
        definitions = {
            "BRDF": f"brdf/{_shader_of(scene.brdf)}.glsl",
            textures.source if textures else "SOURCE_NONE": "1",
        }
        definitions |= {f"LOOKUP_{scene.lookup.upper()}": "1", f"ABOVE_{scene.above.upper()}": "1"}
        if len(scene.lights.direction) == 1 or scene.lookup in ("texture", "outgoing"):
            definitions["ONE_LOOKUP"] = "1"
        definitions |= {"LAYERS": str(textures.layers)} if textures and textures.layers else {}
        definitions |= {} if scene.brdf.isotropic else {"BRUSHED": "1"}
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
        self._last_good = self._programs[key]
        return self._last_good

    @property
    def _debug(self) -> dict[str, str]:
        return {"DEBUG": "1"} if self.debug else {}

    def _framebuffer(self, size: tuple[int, int]) -> Any:
        if self._target is None or self._target[0] != size:
            self._release_target()
            colour = self.context.texture(size, 4, dtype="f4")
            colour.filter = (self.context.NEAREST, self.context.NEAREST)
            depth = self.context.depth_renderbuffer(size)
            self._target = (size, self.context.framebuffer([colour], depth))
        return self._target[1]

    def _release_target(self) -> None:
        if self._target is not None:
            framebuffer = self._target[1]
            # a new framebuffer restores the one bound before it, which must not be one that is gone
            self.context.detect_framebuffer(0).use()
            for item in (framebuffer, framebuffer.depth_attachment, *framebuffer.color_attachments):
                item.release()
            self._target = None

    def release(self) -> None:
        """Free everything; the renderer can be used again afterwards and uploads anew."""
        for owner in (self._mesh, self._ground, self._material, self._lights, self._table):
            if owner is not None:
                owner[-1].release()
        for program in {id(program): program for program in self._programs.values() if program}.values():
            program.release()
        if self._tone_mapper is not None:
            self._tone_mapper.release()
        self._release_target()
        self._mesh = self._ground = self._material = self._lights = self._table = None
        self._tone_mapper = self._last_good = None
        self._programs.clear()


def _shader_of(brdf: Any) -> str:
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


def _tile_from_clip(tile: Tile, size: tuple[int, int]) -> NDArray[np.float64]:
    """(4, 4) matrix that makes the tile (left, top, width, height) of a picture of `size` fill clip space."""
    left, top, width, height = tile
    matrix = np.eye(4)
    matrix[0, 0], matrix[1, 1] = size[0] / width, size[1] / height
    matrix[0, 3] = (size[0] - 2.0 * left) / width - 1.0
    matrix[1, 3] = 1.0 - (size[1] - 2.0 * top) / height
    return matrix
