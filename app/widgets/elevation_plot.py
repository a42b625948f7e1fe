"""Mean radiance of photographs against the elevation of their light; the plot is made with its first point.

Its library takes longer to load than the rest of an empty window.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING

from numpy.typing import ArrayLike
from PySide6.QtCore import QSize, Signal
from PySide6.QtWidgets import QVBoxLayout, QWidget

if TYPE_CHECKING:
    from app.widgets.plots import Elevations


class ElevationPlot(QWidget):
    """`selected` and `toggled` are those of `Elevations`."""

    selected = Signal(int)
    toggled = Signal(int)

    def __init__(self) -> None:
        super().__init__()
        self.column = QVBoxLayout(self)
        self.column.setContentsMargins(0, 0, 0, 0)
        self.setMinimumHeight(120)

    @cached_property
    def inside(self) -> Elevations:
        """The plot itself."""
        from app.widgets.plots import Elevations

        plot = Elevations()
        plot.selected.connect(self.selected)
        plot.toggled.connect(self.toggled)
        self.column.addWidget(plot)
        return plot

    def sizeHint(self) -> QSize:
        return QSize(320, 180)

    def show_means(
        self, elevation_deg: ArrayLike, mean: ArrayLike, excluded: Sequence[bool], current: int | None
    ) -> None:
        """As `Elevations.show_means`."""
        if len(excluded) or "inside" in vars(self):
            self.inside.show_means(elevation_deg, mean, excluded, current)

    def apply_theme(self) -> None:
        """Take the colours of the current theme."""
        if "inside" in vars(self):
            self.inside.apply_theme()
