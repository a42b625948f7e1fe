"""About single texels of a compressed material: the worst ones to jump to, and the numbers of the picked one."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np
from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QLabel

from app.widgets.panels import Rows, button, text
from engine.core.figure_text import format_fixed, number
from engine.core.steps import Step, Steps
from engine.scene.material import Material
from engine.shading.power_law import PowerLawMap
from engine.shading.power_law_error import Texel, worst_texels

WORST_SHOWN = 6


class WorstTexels(Rows):
    """The texels with the largest errors, worst first. `chosen(column, row)` follows a click on one."""

    chosen = Signal(int, int)

    def __init__(self) -> None:
        super().__init__()
        self.texels: tuple[Texel, ...] = ()
        self.links = [button("–", "link", hint="Show this texel") for _ in range(WORST_SHOWN)]
        self.errors = [text("–", "") for _ in range(WORST_SHOWN)]
        for place, (link, error) in enumerate(zip(self.links, self.errors, strict=True)):
            link.clicked.connect(partial(self._on_clicked, place))
            error.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
            row = self.grid.rowCount()
            self.grid.addWidget(link, row, 0)
            self.grid.addWidget(error, row, 1)

    def show_texels(self, texels: Sequence[Texel]) -> None:
        """List `texels`, and leave out the rows that are not needed."""
        self.texels = tuple(texels)
        for place, (link, error) in enumerate(zip(self.links, self.errors, strict=True)):
            there = place < len(self.texels)
            link.setVisible(there)
            error.setVisible(there)
            if there:
                texel = self.texels[place]
                link.setText(f"{texel.column}, {texel.row}")
                link.setAccessibleName(f"Texel in column {texel.column}, row {texel.row}")
                error.setText(number(texel.error, 3))

    def _on_clicked(self, place: int) -> None:
        self.chosen.emit(self.texels[place].column, self.texels[place].row)


class TexelFigures(Rows):
    """The position of the picked texel, the error of its power law against its slices, and the six numbers."""

    def __init__(self) -> None:
        super().__init__()
        self.place = self.figure("Place", "Column and row; click the image to choose another")
        self.residual = self.figure("Residual", "Root mean square over slices and channels, in units of radiance")
        self.scale = self.figure("Scale k", "Red, green and blue")
        self.exponent = self.figure("Exponent K", "Red, green and blue")

    def show_texel(self, material: Material, column: int, row: int) -> None:
        """Show the texel of `material` at `column` and `row`."""
        self.place.setText(f"{column}, {row}")
        power_law = material.power_law
        if power_law is None:
            for figure in (self.residual, self.scale, self.exponent):
                figure.setText("–")
            return
        tiles = power_law.kept
        kept = tiles is not None and tiles.place[row // tiles.size, column // tiles.size] >= 0
        self.residual.setText("0, slices kept" if kept else number(float(power_law.error_map[row, column]), 3))
        _show_three(self.scale, power_law.scale[row, column], 3)
        _show_three(self.exponent, power_law.exponent[row, column], 2)


def _show_three(figure: QLabel, values: np.ndarray, digits: int) -> None:
    figure.setText("   ".join(format_fixed(float(value), digits) for value in values))


def worst(power_law: PowerLawMap | None) -> Steps[tuple[Texel, ...]]:
    """The texels for the list; none where the material is not compressed, or where no texel has an error."""
    yield Step(0.0, "finding the worst texels")
    found = worst_texels(power_law, WORST_SHOWN) if power_law is not None else ()
    return tuple(texel for texel in found if texel.error > 0.0)
