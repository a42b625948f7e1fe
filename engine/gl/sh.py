"""Transported spherical harmonics on the graphics device: the table of a reflectance as a texture.

The twin of `BrdfTable.radiance`, for each vertex in every frame; between vertices radiance is interpolated. At order 5
that is 55 fetches for a vertex with an isotropic table, and 125 with an anisotropic one.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from engine.factor.maps import KINDS
from engine.gl.factor_textures import layers
from engine.gl.program import set_uniforms
from engine.transport.lit import LitHarmonics

#: Texture unit, above those of a material and the lights.
UNIT = 5


class HarmonicTextures:
    """Owns the table of one reflectance."""

    SOURCE = "sh.glsl"

    def __init__(self, context: Any, lit: LitHarmonics) -> None:
        table = lit.table
        self.definitions = {"ORDER": str(table.order), "BRUSHED": "1"}
        self._values = {"flat_row": lit.flat_vertex * table.order**2}
        if table.isotropic:
            self._name = "table_rows"
            texels = np.ascontiguousarray(table.values, np.float32)
            self._texture = context.texture(texels.shape[1::-1], 3, texels, dtype="f4")
            self._texture.filter = (context.NEAREST, context.NEAREST)
        else:
            self._name = "table_map"
            self._texture = layers(context, np.moveaxis(table.values, 2, 0))
            self.definitions["PARABOLIC"] = "1"
            self._values |= {"brdf_map": KINDS.index("parabolic"), "brdf_size": table.values.shape[0]}

    @staticmethod
    def key(lit: LitHarmonics) -> object:
        """What the textures are made of, and where the rows of flat vertices begin."""
        return lit.table, lit.flat_vertex

    @staticmethod
    def rows(lit: LitHarmonics) -> Any:
        return np.concatenate([lit.rows[: lit.flat_vertex * lit.table.order**2], lit.flat])

    def bind(self, program: Any) -> None:
        self._texture.use(UNIT)
        set_uniforms(program, {self._name: UNIT, **self._values})

    def release(self) -> None:
        self._texture.release()
