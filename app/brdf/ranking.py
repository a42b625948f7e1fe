"""The ranking of all models for one BRDF: each fitted, with its error in two norms, and any of them to be compared."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QDialog, QHBoxLayout, QVBoxLayout, QWidget

from app.widgets.figure_table import FigureTable
from app.widgets.panels import button, text
from app.widgets.theme import STEP
from engine.brdf.brdf import MODELS, label_of, model_name
from engine.brdf.fit import fit_data
from engine.core.figure_text import number, percent
from engine.core.steps import Step, Steps

if TYPE_CHECKING:
    from engine.brdf.ranking import Offer

HEADINGS = ("Model", "Error", "Log error")

#: Width and height of the dialog.
SIZE_PX = (420, 420)


class Ranking(QDialog):
    """`wanted(offer)`: one of the fits is to become an entry of the list."""

    wanted = Signal(object)

    def __init__(self, window: QWidget, name: str, offers: Sequence[Offer]) -> None:
        super().__init__(window)
        self.offers = tuple(offers)
        self.setWindowTitle(f"All models for {name}")
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.resize(*SIZE_PX)
        self.table = FigureTable("Models by their error", HEADINGS)
        rows = [(label_of(model_name(each.brdf)), percent(each.linear, 3), number(each.log, 3)) for each in self.offers]
        self.table.show_rows(rows, 0 if rows else None)
        self.table.itemActivated.connect(lambda _item: self._add())
        words = text(
            "Error: RMS of BRDF × cosine relative to that of the data, which highlights outweigh. "
            "Log error: of the logarithms, where dim values count as much; the least is on top.",
            "secondary",
            wrap=True,
        )
        self.add = button("Add to the list", "primary")
        self.add.clicked.connect(self._add)
        close = button("Close")
        close.clicked.connect(self.close)
        foot = QHBoxLayout()
        foot.setSpacing(2 * STEP)
        foot.addStretch(1)
        foot.addWidget(close)
        foot.addWidget(self.add)
        column = QVBoxLayout(self)
        column.setSpacing(2 * STEP)
        column.addWidget(words)
        column.addWidget(self.table, 1)
        column.addLayout(foot)

    def _add(self) -> None:
        place = self.table.currentRow()
        if place >= 0:
            self.wanted.emit(self.offers[place])


def all_models(brdf: Any, weighting: Any) -> Steps[list[Offer]]:
    """Every model fitted to `brdf`, the best first; some seconds to a minute."""
    yield Step(0.0, "taking samples")
    from engine.brdf.ranking import rank

    return (yield from rank(fit_data(brdf), [model() for model in MODELS.values()], weighting=weighting))
