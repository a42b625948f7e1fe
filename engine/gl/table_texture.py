"""A reflectance without a shader of its own, as a texture: its table in half and difference angles, in float32.

Another BRDF than such a table is resampled to one first, which takes a second or, where it is scattered data, many;
a window that must not wait makes the table beforehand (`engine.brdf.resample`). Of what is not reciprocal both ways of
the light are kept, as two halves of a whole turn of phi_d. What that costs in accuracy, and what it cannot show, are
messages.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from engine.brdf.brdf import Brdf
from engine.brdf.resample import SHAPE, table_from, whole_turn
from engine.brdf.table import HalfDifferenceTable
from engine.gl.context import Limits
from engine.steps import drain

#: Texture unit, above those of a material and the lights.
UNIT = 5

#: Bins for scattered data, and for anisotropic ones, of which only the mean is shown.
COARSE = (45, 45, 90)

#: The shader that looks the table up.
SOURCE = "table"


class TableTexture:
    """Owns the texture of one BRDF; `messages` tells where it is not the BRDF itself that is shown."""

    def __init__(self, context: Any, brdf: Brdf, limits: Limits) -> None:
        self.messages: list[str] = []
        self.turn = np.pi
        if isinstance(brdf, HalfDifferenceTable) and _fits(brdf, limits):
            lattice = brdf.lattice
        else:
            if brdf.reciprocal:
                table = table_from(brdf, _shape(brdf), dtype=np.float32)
                lattice, error = table.lattice, table.health.figures["resampling_rms_rel"]
            else:
                lattice, error = drain(whole_turn(brdf, _shape(brdf)))
                self.turn = 2.0 * np.pi
            self.messages.append(
                f"The measured reflectance is shown from a table that errs by {100.0 * error:.2g} % RMS."
            )
        if not brdf.isotropic:
            self.messages.append(
                "The reflectance is anisotropic and is shown as its mean over all azimuths; "
                "the renderer on the processor (--renderer cpu) shows it as it is."
            )
        layers, height, width = lattice.shape[:3]
        texels = np.ascontiguousarray(lattice, np.float32)
        self.texture = context.texture_array((width, height, layers), 3, texels, dtype="f4")
        self.texture.filter = (context.NEAREST, context.NEAREST)

    def bind(self, program: Any) -> None:
        self.texture.use(UNIT)
        program["brdf_table"].value = UNIT
        program["brdf_turn"].value = self.turn

    def release(self) -> None:
        self.texture.release()


def _shape(brdf: Brdf) -> tuple[int, int, int]:
    """The resolution of MERL data; half of it where every value is slow, and smooth beyond it."""
    from engine.brdf.scattered import ScatteredBrdf  # slow to load, and the window must open at once

    return COARSE if isinstance(brdf, ScatteredBrdf) or not brdf.isotropic else SHAPE


def _fits(table: HalfDifferenceTable, limits: Limits) -> bool:
    layers, height, width = table.lattice.shape[:3]
    return layers <= limits.layers and max(height, width) <= limits.texture_size
