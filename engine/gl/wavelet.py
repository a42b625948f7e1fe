"""Wavelet transport on the graphics device: view maps as textures, and how many terms each fragment looks up.

The counterpart of `engine.transport.wavelet.transfer`. The light is made into K-tuples on the CPU; here they are
multiplied with the view maps, which each fragment looks up in the direction of the eye. Drivers carry only so many
numbers from vertices to fragments: with more than `MAX_TERMS` terms the sum is made at the vertices. Bound by fetches
of texels, so four numbers lie in each: of maps without colour, four terms.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import moderngl
import numpy as np
from numpy.typing import NDArray

from engine.gl.brdf_textures import pack
from engine.gl.buffers import Colours
from engine.gl.context import Limits
from engine.gl.program import set_uniforms
from engine.transport.relight import RelightWavelets

#: Terms of three numbers that fit beside the other numbers of a vertex into the 60 that OpenGL 3.3 promises.
MAX_TERMS = 16

#: Largest number of a texture; light may be brighter.
BRIGHTEST = float(np.finfo(np.float32).max)

#: Texture unit, above those of a material and the lights.
UNIT = 5


class Textures:
    """Owns the view maps of one transport."""

    SHADER, SOURCE = "transported", "wavelet.glsl"

    def __init__(self, context: moderngl.Context, relit: RelightWavelets, _limits: Limits) -> None:
        self.messages: list[str] = []
        factors, terms, kinds = relit.transport.factors, relit.transport.terms, relit.transport.kinds
        numbers = _numbers(factors.first).reshape(kinds, -1, *factors.hemisphere_map.shape)
        numbers = np.pad(numbers, ((0, 0), (0, -numbers.shape[1] % 4), (0, 0), (0, 0)))  # each begins with a layer
        self._texture = pack(context, numbers.reshape(-1, *numbers.shape[2:]))
        self.definitions = {"TERMS": str(terms)} if terms <= MAX_TERMS else {}
        self.definitions |= {"PLANES": str(len(_numbers(factors.first)) // factors.terms)}
        self.definitions |= {} if relit.transport.kind is None else {"KINDS": "1"}
        self.definitions |= {} if factors.isotropic else {"BRUSHED": "1"}
        self._values = {
            "brdf_map": factors.hemisphere_map.number,
            "brdf_size": factors.hemisphere_map.size,
            "term_count": terms,
            "flat_row": relit.flat_vertex * terms,
            "flat_factor": relit.transport.ground_albedo / math.pi,
        }
        if relit.transport.kind is not None:
            self._values["kind_row"] = relit.transport.rows

    @staticmethod
    def key(relit: RelightWavelets) -> object:
        """The source of the textures."""
        return relit.transport

    @staticmethod
    def rows(relit: RelightWavelets) -> list[Colours]:
        """The K-tuples (R, 4), marked where the radiance of the vertex itself may be asked for, and kinds of BRDFs."""
        transport = relit.transport
        first, terms = transport.ground_vertex, transport.terms
        rows = np.zeros((transport.rows, 4), np.float32)
        rows[:, :3] = np.clip(relit.rows, -BRIGHTEST, BRIGHTEST)
        rows[: first * terms : terms, 3] = transport.turning[:first]
        if transport.kind is None:
            return [rows]
        return [rows, np.repeat(transport.kind.astype(np.float32)[:, None], 3, axis=1)]

    def fill(self) -> Iterator[None]:
        """All of it is small, and there from the beginning."""
        return iter(())

    def relight(self, _relit: RelightWavelets) -> Iterator[None]:
        """All light is in the rows of the vertices."""
        return iter(())

    def bind(self, program: moderngl.Program) -> None:
        self._texture.use(UNIT)
        set_uniforms(program, {"view_maps": UNIT, **self._values})

    def release(self) -> None:
        self._texture.release()


def _numbers(maps: NDArray[np.float32]) -> NDArray[np.float32]:
    """(K P, rows, columns) of view maps (K, rows, columns, 3); P is 1 where none of them has colour, else 3."""
    planes = np.moveaxis(maps, 3, 1)
    planes = planes[:, :1] if (planes == planes[:, :1]).all() else planes
    return planes.reshape(-1, *maps.shape[1:3])
