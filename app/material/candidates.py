"""The representations that a material was weighed in: a table of their errors and bytes, and the verdict in words."""

from __future__ import annotations

import math
from dataclasses import dataclass

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QGridLayout, QLabel, QWidget

from app.widgets.fitting import Elided
from app.widgets.panels import Rows, text
from app.widgets.theme import ROW, STEP, role
from engine.core.figure_text import number
from engine.scene.material import Material

#: Columns of the table, with what is said where the mouse rests.
COLUMNS = (
    ("Held out", "Root mean square error of photographs held out in turn"),
    ("Training", "The same of the photographs that the map was made of, which flatters it"),
    ("Bytes", "Of a texel, before compression"),
)

#: Rows at most: both representations and the mean image.
MAXIMUM = 3

#: Words for representations, by the name that figures have of them.
NAMES = {"directional": "Directional map", "shading_map": "Shading map"}


@dataclass(frozen=True)
class Candidate:
    """A row: a representation, its errors in 8-bit levels, and bytes of a texel; NaN for what is not known."""

    name: str
    left_out: float
    in_sample: float
    bytes_per_texel: float


def candidates_of(material: Material) -> list[Candidate]:
    """The representation of `material` first, the other, and the mean image; empty where nothing was weighed."""
    found, figures = material.directional, dict(material.health.figures)
    if found is not None:
        own = {"leave_one_out_rmse_srgb8": found.leave_one_out, "in_sample_rmse_srgb8": found.in_sample}
        own |= {"bytes_per_texel": float(found.bytes_per_texel)}
        figures |= {f"directional_{name}": value for name, value in own.items()}
        figures["mean_picture_rmse_srgb8"] = found.mean_picture
    chosen = "shading_map" if found is None else "directional"
    names = sorted(NAMES, key=lambda name: name != chosen)
    rows = [
        Candidate(
            NAMES[name],
            figures[f"{name}_leave_one_out_rmse_srgb8"],
            figures.get(f"{name}_in_sample_rmse_srgb8", math.nan),
            figures.get(f"{name}_bytes_per_texel", math.nan),
        )
        for name in names
        if math.isfinite(figures.get(f"{name}_leave_one_out_rmse_srgb8", math.nan))
    ]
    mean = figures.get("mean_picture_rmse_srgb8", math.nan)
    return [*rows, Candidate("Mean image", mean, math.nan, 3.0)] if rows and math.isfinite(mean) else []


def verdict(rows: list[Candidate]) -> tuple[str, str]:
    """The verdict on the first of `rows` in words, and its role in the theme."""
    ours, mean = rows[0].left_out, rows[-1].left_out
    if ours > mean:
        return f"Worse than the mean image: {rows[0].name.lower()}s do not suit these photographs.", "warning"
    if ours > 0.95 * mean:
        return "Held-out error equals that of the mean image.", "good"
    return f"Held-out error is {number(mean / max(ours, 1e-9))}x lower than the mean image.", "good"


class Candidates(Rows):
    """The table; hidden where nothing was weighed."""

    def __init__(self) -> None:
        super().__init__("Error (8-bit levels)")
        self.rows: list[Candidate] = []
        table = QWidget()
        grid = QGridLayout(table)
        grid.setContentsMargins(0, 0, 0, 0)
        grid.setHorizontalSpacing(2 * STEP)
        grid.setColumnStretch(0, 1)
        for column, (heading, hint) in enumerate(COLUMNS, start=1):
            caption = _right("secondary")
            caption.setText(heading)
            caption.setToolTip(hint)
            grid.addWidget(caption, 0, column)
        self.lines: list[list[QLabel]] = [[Elided(), *(_right() for _ in COLUMNS)] for _ in range(MAXIMUM)]
        for row, line in enumerate(self.lines, start=1):
            grid.setRowMinimumHeight(row, ROW)
            for column, cell in enumerate(line):
                grid.addWidget(cell, row, column)
        self.wide(table)
        self.verdict = text("", wrap=True)
        self.wide(self.verdict)
        self.hide()

    def show_material(self, material: Material) -> None:
        """Show what `material` was weighed against; the first row is what it is."""
        self.rows = candidates_of(material)
        self.setVisible(bool(self.rows))
        for place, line in enumerate(self.lines):
            cells = _cells(self.rows[place]) if place < len(self.rows) else ("",) * len(line)
            for cell, words in zip(line, cells, strict=True):
                cell.setText(words)
                cell.setVisible(bool(words))
        if self.rows:
            words, look = verdict(self.rows)
            self.verdict.setText(words)
            role(self.verdict, look)


def _cells(row: Candidate) -> tuple[str, ...]:
    errors = ("–" if math.isnan(each) else number(each, 3) for each in (row.left_out, row.in_sample))
    return row.name, *errors, "–" if math.isnan(row.bytes_per_texel) else str(round(row.bytes_per_texel))


def _right(look: str = "") -> QLabel:
    label = text("", look)
    label.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
    return label
