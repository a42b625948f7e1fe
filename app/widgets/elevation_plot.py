"""Mean radiance of photographs against the elevation of their light; the plot is made with its first point.

Its library takes longer to load than the rest of an empty window.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from numpy.typing import ArrayLike
from PySide6.QtCore import QSize, QTimer, Signal
from PySide6.QtWidgets import QVBoxLayout, QWidget

from engine.core.cached import cached_property

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
        self._wanted: tuple[ArrayLike, ArrayLike, Sequence[bool], int | None] | None = None
        self._soon = QTimer(self, singleShot=True, interval=0)
        self._soon.timeout.connect(self._draw_wanted)

    @property
    def inside(self) -> Elevations:
        """The plot itself, with the means of now."""
        self._draw_wanted()
        return self._plot

    @cached_property
    def _plot(self) -> Elevations:
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
        """As `Elevations.show_means`, once for all that is asked in one turn of the event loop."""
        if len(excluded) or "_plot" in vars(self):
            self._wanted = (elevation_deg, mean, excluded, current)
            self._soon.start()

    def _draw_wanted(self) -> None:
        wanted, self._wanted = self._wanted, None
        if wanted is not None:
            self._plot.show_means(*wanted)

    def apply_theme(self) -> None:
        """Take the colours of the current theme."""
        if "_plot" in vars(self):
            self._plot.apply_theme()
