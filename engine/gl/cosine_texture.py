"""The table by which a directional map is looked up for one BRDF, as a texture (`EffectiveCosine`)."""

from __future__ import annotations

from typing import Any

from engine.gl.program import set_uniforms
from engine.shading.directional.effective_light import EffectiveCosine

#: Texture unit, between those of a directional map and of the lights.
UNIT = 3


class CosineTexture:
    """Owns the texture of one table: powers of cosines over the power of the share, and azimuths, which repeat."""

    def __init__(self, context: Any, table: EffectiveCosine) -> None:
        self.table = table
        rows, entries = table.power.shape
        self._texture = context.texture((entries, rows), 1, table.power.tobytes(), dtype="f4")
        self._texture.filter = (context.LINEAR, context.LINEAR)
        self._texture.repeat_x = False

    def bind(self, program: Any) -> None:
        self._texture.use(UNIT)
        set_uniforms(program, {"cosine_powers": UNIT, "lowest_power": self.table.lowest})

    def release(self) -> None:
        self._texture.release()
