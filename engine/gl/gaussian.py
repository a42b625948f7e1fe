"""Gaussian transport on the graphics device: lobes and the filtered environment as textures.

The counterpart of `engine.transport.gaussian.transfer`: the views around the eye are found, and lobes mixed, at each
vertex; then they are mixed across triangles and looked up at each fragment. A lobe takes 12 bytes: its mean on an
octahedron (7e-5 rad), the logarithm of its width in 65,536 steps and its energy as half floats (5e-4). When only the
light turns, nothing is uploaded.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import moderngl
import numpy as np
from numpy.typing import NDArray

from engine.gl.buffers import PIECE_BYTES, Colours
from engine.gl.context import Limits
from engine.gl.program import set_uniforms
from engine.light.gaussian_prefilter import PrefilteredCube
from engine.light.lamps import Lamp
from engine.scene.scene import MAX_LAMPS
from engine.transport.gaussian.fitting.views import VIEWS, view_tables
from engine.transport.gaussian.gpu_layout import Atlas, atlas_of, sigma_span
from engine.transport.gaussian.kernel import NODES, REACH, SHARES
from engine.transport.gaussian.lighting import GaussianLight, chord, lamp_light
from engine.transport.relight import RelightGaussians

#: Texture units, beside that of `engine.gl.buffers`.
LOBES_UNIT, VIEWS_UNIT, LIGHT_UNIT = 5, 6, 8

#: Lobes of a vertex for which drivers promise to carry numbers to fragments.
MAX_LOBES = 8

#: Lobes beside each other in a line of their texture.
WIDTH = 4096

#: Levels that the shader has room for.
MAX_LEVELS = 32


class Textures:
    """Owns the lobes of one transport, the views, and the environment of the last light."""

    SHADER, SOURCE = "gaussian", "gaussian_views.glsl"

    def __init__(self, context: moderngl.Context, relit: RelightGaussians, texture_limits: Limits) -> None:
        transport = relit.transport
        if transport.lobes > MAX_LOBES:
            raise ValueError(f"{transport.lobes} lobes for each vertex are more than the {MAX_LOBES} that are drawn")
        self.context, self._limits = context, texture_limits
        self.messages: list[str] = []
        self._filtered: tuple[PrefilteredCube | None, moderngl.TextureArray | None] = (None, None)
        self._views = _view_table(context)
        self._lobes: moderngl.Texture | None = None
        self._values: dict[str, object] = {
            "view_table": VIEWS_UNIT,
            "view_centres": [tuple(row) for row in view_tables().centres.tolist()],
            "grazing": transport.grazing,
        }
        self._light: dict[str, object] = {}
        self._definitions: dict[str, str] = {}
        self._scale = 1.0
        self._uneven: dict[str, str] = {}
        self._lamps: tuple[Lamp, ...] = ()
        if transport.lobes:
            first, step = sigma_span()
            self._lobes = _lobe_texture(context, len(transport.texels), texture_limits)
            self._texels = transport.texels
            self._values |= {
                "lobe_texels": LOBES_UNIT,
                "lobes_width": self._lobes.width,
                "sigma_span": (first, step),
                "gauss": list(zip(NODES.tolist(), SHARES.tolist(), strict=True)),
            }
            self._definitions = {
                "LOBES": str(transport.lobes),
                "VIEWS": str(VIEWS),
                "MAX_LEVELS": str(MAX_LEVELS),
                "MAX_LAMPS": str(MAX_LAMPS),
                "NODES": str(len(NODES)),
                "REACH": f"{REACH:.1f}",
            }

    @property
    def definitions(self) -> dict[str, str]:
        """Definitions that the shaders are compiled with for these lobes and the last light."""
        lamps = {"LAMPS": "1"} if self._lamps else {}
        discs = {"DISCS": "1"} if any(lamp.radius for lamp in self._lamps) else {}
        light = self._uneven | lamps | discs
        return {**self._definitions, **(light if self._lobes is not None else {})}

    @staticmethod
    def key(relit: RelightGaussians) -> object:
        """The transport of the lobes: equal for what can share them."""
        return relit.transport

    @staticmethod
    def rows(relit: RelightGaussians) -> list[Colours]:
        return [relit.diffuse]

    def fill(self) -> Iterator[None]:
        """Bring the lobes to the device, piece by piece; none can be drawn before."""
        if self._lobes is None:
            return
        words, width = self._texels, self._lobes.width
        lines = max(1, PIECE_BYTES // (12 * width))
        for first in range(0, self._lobes.height, lines):
            part = words[first * width : (first + lines) * width]
            whole = len(part) // width
            if whole:
                self._lobes.write(part[: whole * width], viewport=(0, first, width, whole))
            if whole * width < len(part):
                self._lobes.write(part[whole * width :], viewport=(0, first + whole, len(part) - whole * width, 1))
            yield

    def relight(self, relit: RelightGaussians) -> Iterator[None]:
        """Take the light of `relit`, piece by piece; an environment that is there already is not uploaded again."""
        if self._lobes is None:
            return
        cube = relit.light.environment
        if cube is not self._filtered[0] or self._filtered[1] is None:
            if self._filtered[1] is not None:
                self._filtered[1].release()
            self._filtered = (None, None)
            atlas = self._atlas(relit.light)
            texture = _atlas_texture(self.context, atlas)
            try:
                for face, texels in enumerate(atlas.texels):
                    texture.write(texels, viewport=(0, 0, face, texture.width, texture.height, 1))
                    yield
            except BaseException:
                texture.release()
                raise
            self._scale = atlas.scale
            self._filtered = (cube, texture)
            self._light, self._uneven = _atlas_values(atlas), {} if atlas.is_even else {"UNEVEN": "1"}
        self._light |= _light_values(relit.light, self._scale)
        self._lamps = relit.light.lamps

    def _atlas(self, light: GaussianLight) -> Atlas:
        """The light's own, or a smaller one where the device needs that."""
        atlas, most = light.atlas, self._limits.texture_size
        if len(atlas.levels) > MAX_LEVELS:
            raise ValueError(f"{len(atlas.levels)} levels of light are more than the {MAX_LEVELS} that are drawn")
        if max(atlas.texels.shape[1:3]) > most:
            atlas = atlas_of(light.environment, most)
        words = f"The light is drawn with at most {atlas.reduced} texels along a face"
        self.messages = [words] if atlas.reduced else []
        return atlas

    def bind(self, program: moderngl.Program) -> None:
        self._views.use(VIEWS_UNIT)
        if self._lobes is not None:
            assert self._filtered[1] is not None
            self._lobes.use(LOBES_UNIT)
            self._filtered[1].use(LIGHT_UNIT)
        set_uniforms(program, {**self._values, **self._light})

    def release(self) -> None:
        for texture in (self._views, self._lobes, self._filtered[1]):
            if texture is not None:
                texture.release()
        self._filtered = (None, None)


def _atlas_values(atlas: Atlas) -> dict[str, object]:
    """Uniforms that find a level in its texture."""
    logarithms = atlas.levels[:, 1]
    height, width = atlas.texels.shape[1:3]
    rows = [tuple(row) for row in atlas.levels.tolist()]
    return {
        "filtered": LIGHT_UNIT,
        "levels": rows + [(0.0, 0.0, 0.0, 0.0)] * (MAX_LEVELS - len(rows)),
        "last_level": len(rows) - 1,
        "levels_per_log": (len(rows) - 1) / (logarithms[-1] - logarithms[0]),
        "filtered_texel": (1.0 / width, 1.0 / height),
        "filtered_mean": tuple((atlas.mean / atlas.scale).tolist()),
    }


def _atlas_texture(context: moderngl.Context, atlas: Atlas) -> moderngl.TextureArray:
    faces, height, width, _ = atlas.texels.shape
    texture = context.texture_array((width, height, faces), 4, dtype="f2")
    texture.filter = (context.LINEAR, context.LINEAR)
    texture.repeat_x = texture.repeat_y = False
    return texture


def _light_values(light: GaussianLight, scale: float) -> dict[str, object]:
    """Uniforms of what turns and shines beside the environment."""
    lamps = [(*lamp.direction, chord(lamp)) for lamp in light.lamps]
    colours = [tuple(lamp_light(lamp).tolist()) for lamp in light.lamps]
    free = MAX_LAMPS - len(lamps)
    if free < 0:
        raise ValueError(f"{len(lamps)} lamps are more than the {MAX_LAMPS} of a scene")
    return {
        "factor": light.factor * scale,
        "map_from_world": tuple(light.map_from_world.T.ravel().tolist()),
        "lamp_count": len(lamps),
        "lamps": lamps + [(0.0, 1.0, 0.0, 0.0)] * free,
        "lamp_light": colours + [(0.0, 0.0, 0.0)] * free,
    }


def _lobe_texture(context: moderngl.Context, count: int, texture_limits: Limits) -> moderngl.Texture:
    """Room for so many lobes."""
    width = min(WIDTH, texture_limits.texture_size)
    height = max(1, math.ceil(count / width))
    if height > texture_limits.texture_size:
        raise ValueError(f"{count:,} lobes are more than the {width * texture_limits.texture_size:,} that fit")
    texture = context.texture((width, height), 3, dtype="u4")
    texture.filter = (context.NEAREST, context.NEAREST)
    return texture


def _view_table(context: moderngl.Context) -> moderngl.Texture:
    """Tables by which `gaussian_views.glsl` finds the views."""
    tables = view_tables()
    triangle = tables.triangle.reshape(-1)
    rows: NDArray[np.float32] = np.zeros((20 + len(triangle) + math.ceil(VIEWS / 3), 3, 4), np.float32)
    rows[:20, :, :3] = tables.face_inverse
    rows[20 : 20 + len(triangle), :, :3] = tables.inverse[triangle]
    rows[20 : 20 + len(triangle), :, 3] = tables.corners[triangle]
    rows[20 + len(triangle) :].reshape(-1, 4)[:VIEWS, :3] = tables.directions
    texture = context.texture((3, len(rows)), 4, rows, dtype="f4")
    texture.filter = (context.NEAREST, context.NEAREST)
    return texture
