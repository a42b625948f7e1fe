"""Colours of vertices as the lines of a texture: as many as one likes for each, which shaders fetch by number."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.gl.context import Limits

#: Texture unit, above those of maps.
UNIT = 7

#: Colours beside each other in a line.
WIDTH = 4096


class VertexRows:
    """Owns the texture; `write` replaces its content where the number of colours stays."""

    def __init__(self, context: Any, texture_limits: Limits) -> None:
        self.context = context
        self._width = min(WIDTH, texture_limits.texture_size)
        self._most = self._width * texture_limits.texture_size
        self._texture: Any = None

    def write(self, colours: NDArray[np.floating[Any]]) -> None:
        """Take colours (R, 3), or with a mark (R, 4); ValueError where the device cannot hold so many."""
        if len(colours) > self._most:
            raise ValueError(f"{len(colours):,} colours of vertices are more than the {self._most:,} that fit")
        height = max(1, -(-len(colours) // self._width))
        texels = np.zeros((height * self._width, 4), np.float32)
        texels[: len(colours), : colours.shape[1]] = colours
        if self._texture is not None and self._texture.height != height:
            self.release()
        if self._texture is None:
            self._texture = self.context.texture((self._width, height), 4, dtype="f4")
            self._texture.filter = (self.context.NEAREST, self.context.NEAREST)
        self._texture.write(texels)

    def bind(self, program: Any) -> None:
        self._texture.use(UNIT)
        program["rows"].value = UNIT
        program["row_width"].value = self._width

    def release(self) -> None:
        if self._texture is not None:
            self._texture.release()
            self._texture = None
