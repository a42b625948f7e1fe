"""Transported spherical harmonics on the graphics device: the table of a BRDF as a texture.

The counterpart of `BrdfTable.radiance` and `VariedTable.radiance`, for each vertex in every frame; between vertices
radiance is interpolated. At order 5 that is 55 fetches for a vertex with an isotropic table, and 125 with an
anisotropic one; where one parameter varies 85 and 225, where two do 145 and 425.
"""

from __future__ import annotations

from collections.abc import Iterator

import moderngl
import numpy as np
from numpy.typing import NDArray

from engine.factor.hemisphere_map import KINDS
from engine.gl.brdf_textures import layers, plain
from engine.gl.buffers import Colours
from engine.gl.context import Limits
from engine.gl.program import set_uniforms
from engine.transport.relight import RelightSh
from engine.transport.sh.brdf_table_varying import VariedTable, tables_of

#: Texture unit, above those of a material and the lights.
UNIT = 5

#: Coefficients of a brushed BRDF that lie beside each other in its texture, as in sh.glsl: what a vertex reads
#: is then in few lines of the cache. With a layer for each, a frame takes half as long again.
BESIDE = 32


class Textures:
    """Owns the table of one BRDF."""

    SHADER, SOURCE = "transported", "sh.glsl"

    def __init__(self, context: moderngl.Context, relit: RelightSh, _limits: Limits) -> None:
        self.messages: list[str] = []
        tables = tables_of(relit.table)
        first, count = tables[0], relit.table.order**2
        self.definitions = {"ORDER": str(relit.table.order), "BRUSHED": "1"}
        flat_row = relit.flat_vertex * count
        self._values: dict[str, object] = {"flat_row": flat_row}
        if first.isotropic:
            self._name = "table_rows"
            values = np.stack([table.values for table in tables])
            is_varied = isinstance(relit.table, VariedTable)
            self._texture = layers(context, values) if is_varied else plain(context, values[0])
        else:
            self._name = "table_map"
            self._texture = layers(context, np.concatenate([_beside_each_other(table.values) for table in tables]))
            self.definitions["PARABOLIC"] = "1"
            self._values |= {"brdf_map": KINDS.index("parabolic"), "brdf_size": first.values.shape[0]}
        if isinstance(relit.table, VariedTable):
            flat = len(relit.mesh.positions) - relit.flat_vertex
            self.definitions["VARIED"] = str(1 + (relit.table.steps[1] > 1))
            self._values |= {"steps": relit.table.steps, "place_row": flat_row + flat}

    @staticmethod
    def key(relit: RelightSh) -> object:
        """The source of the textures, and the first row of flat vertices."""
        return relit.table, relit.flat_vertex

    @staticmethod
    def rows(relit: RelightSh) -> list[Colours]:
        """(R, 3) light of each vertex, radiance of the flat ones, and where the others are among the tables."""
        parts = [relit.rows[: relit.flat_vertex * relit.table.order**2], relit.flat]
        if isinstance(relit.table, VariedTable):
            parts.append(relit.table.places[: relit.flat_vertex])
        return parts

    def fill(self) -> Iterator[None]:
        """All of it is small, and there from the beginning."""
        return iter(())

    def relight(self, _relit: RelightSh) -> Iterator[None]:
        """All light is in the rows of the vertices."""
        return iter(())

    def bind(self, program: moderngl.Program) -> None:
        self._texture.use(UNIT)
        set_uniforms(program, {self._name: UNIT, **self._values})

    def release(self) -> None:
        self._texture.release()


def _beside_each_other(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """(L, S, S BESIDE, 3) from the texels (S, S, order², 3) of a map."""
    rows, columns, count, _ = values.shape
    padded = np.pad(values, ((0, 0), (0, 0), (0, -count % BESIDE), (0, 0)))
    blocks = padded.reshape(rows, columns, -1, BESIDE, 3)
    return np.moveaxis(blocks, 2, 0).reshape(-1, rows, columns * BESIDE, 3)
