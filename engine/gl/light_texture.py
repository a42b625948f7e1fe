"""Textures of what light is looked up by: the directional lights of a scene, and the cosines of a directional map."""

from __future__ import annotations

from typing import Any

import numpy as np

from engine.gl.program import set_uniforms
from engine.light.environment import DistantLights
from engine.shading.directional.effective_light import EffectiveCosine

#: Texture units of both, above those of a material.
COSINE_UNIT, LIGHT_UNIT = 3, 4


class LightTexture:
    """Owns the texture of one set of lights: a row for each, its direction and its irradiance in float32."""

    def __init__(self, context: Any, lights: DistantLights) -> None:
        count = len(lights.direction)
        texels = np.ones((count, 2, 4), np.float32)
        texels[:, 0, :3] = lights.direction
        texels[:, 1, :3] = np.minimum(lights.irradiance, np.finfo(np.float32).max)
        self.texture = context.texture((2, count), 4, texels, dtype="f4")
        self.texture.filter = (context.NEAREST, context.NEAREST)

    def bind(self, program: Any) -> None:
        self.texture.use(LIGHT_UNIT)
        program["lights"].value = LIGHT_UNIT

    def release(self) -> None:
        self.texture.release()


class CosineTexture:
    """Owns the texture of the table by which a directional map is looked up for one BRDF (`EffectiveCosine`).

    It holds powers of cosines over the power of the share, and azimuths, which repeat.
    """

    def __init__(self, context: Any, table: EffectiveCosine) -> None:
        self.table = table
        rows, entries = table.power.shape
        self._texture = context.texture((entries, rows), 1, table.power.tobytes(), dtype="f4")
        self._texture.filter = (context.LINEAR, context.LINEAR)
        self._texture.repeat_x = False

    def bind(self, program: Any) -> None:
        self._texture.use(COSINE_UNIT)
        set_uniforms(program, {"cosine_powers": COSINE_UNIT, "lowest_power": self.table.lowest})

    def release(self) -> None:
        self._texture.release()
