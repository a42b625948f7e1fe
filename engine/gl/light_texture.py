"""Directional lights as a texture: a row for each, its direction and its irradiance in float32."""

from __future__ import annotations

from typing import Any

import numpy as np

from engine.light.environment import DistantLights

#: Texture unit, above those of a material.
UNIT = 4


class LightTexture:
    """Owns the texture of one set of lights."""

    def __init__(self, context: Any, lights: DistantLights) -> None:
        count = len(lights.direction)
        texels = np.ones((count, 2, 4), np.float32)
        texels[:, 0, :3] = lights.direction
        texels[:, 1, :3] = np.minimum(lights.irradiance, np.finfo(np.float32).max)
        self.texture = context.texture((2, count), 4, texels, dtype="f4")
        self.texture.filter = (context.NEAREST, context.NEAREST)

    def bind(self, program: Any) -> None:
        self.texture.use(UNIT)
        program["lights"].value = UNIT

    def release(self) -> None:
        self.texture.release()
