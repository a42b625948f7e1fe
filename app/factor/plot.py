"""Error against terms, time or bytes, a line and a marker per run; a click on a point chooses these terms.

All axes but that of terms are logarithmic: methods differ by orders of magnitude in each.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import log10
from typing import TYPE_CHECKING, Any

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QPointF, Qt, Signal
from PySide6.QtGui import QContextMenuEvent, QKeyEvent, QMouseEvent
from PySide6.QtWidgets import QMenu

from app.document.factoring import METRICS, Run
from app.factor.runs import Live
from app.widgets import theme
from app.widgets.number_field import plain
from app.widgets.plot_files import rows_of
from app.widgets.plots import Plot

if TYPE_CHECKING:
    from engine.factor.errors import TermError

MARK_PX = 10

#: The command of the plot's menu.
SAVE = "Save plot as PNG, SVG or CSV…"

#: Quantities on the horizontal axis, and their labels.
AGAINST = {"terms": "Number of terms", "time": "Time / s", "bytes": "Size / kB"}

#: Errors below this are drawn on it: they are rounding, and a logarithm needs an end. So do times and sizes.
MINIMUM, SHORTEST = 1e-12, 1e-3

#: Steps of ticks within a decade, from coarse to fine, and the fewest ticks that an axis can be read by.
STEPS = ((1,), (1, 2, 5), (1, 2, 3, 5, 7), (1, 1.5, 2, 2.5, 3, 4, 5, 6, 7, 8, 9), (*np.arange(1.0, 9.9, 0.2),))
FEWEST = 3


@dataclass(frozen=True, eq=False)
class ErrorLine:
    """One run: the places and logarithms of the errors of its line, and of its points with the terms of each."""

    run: Run
    x: list[float]
    y: list[float]
    marks: list[tuple[float, float, int]]
    going: bool


class ErrorPlot(Plot):
    """`picked(run, terms)` follows a click on a point; `save_wanted` asks for the plot as a file."""

    picked = Signal(int, int)
    save_wanted = Signal()

    def __init__(self) -> None:
        super().__init__(AGAINST["terms"], "Error")
        self.setAccessibleName("Error of the factors")
        self.setToolTip(
            "Click a point to preview and export that number of terms (left and right arrow keys); right-click to save"
        )
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.lines: list[tuple[Any, Any]] = []
        self.shown: list[ErrorLine] = []
        self.chosen: tuple[int, int] | None = None
        self.ring = pg.ScatterPlotItem(size=MARK_PX + 8, brush=None, tip=None)
        self.ring.setZValue(5)
        self.addItem(self.ring, ignoreBounds=True)

    def show_errors(
        self, runs: Sequence[tuple[Run, Live]], against: str, metric: str, chosen: tuple[int, int] | None
    ) -> None:
        """Show the errors called `metric` of all runs; `chosen` is the run and the terms with a ring around them."""
        self.shown = [made for run, live in runs if (made := line_of(run, live, against, metric)) is not None]
        self._label(against, metric)
        while len(self.lines) < len(self.shown):
            marks = pg.ScatterPlotItem(size=MARK_PX, hoverable=True, hoverSize=MARK_PX + 3, tip=None)
            marks.sigClicked.connect(self._on_clicked)
            pair = pg.PlotCurveItem(), marks
            for item in pair:
                self.addItem(item, ignoreBounds=True)
            self.lines.append(pair)
        for place, (curve, marks) in enumerate(self.lines):
            for item in (curve, marks):
                item.setVisible(place < len(self.shown))
            if place < len(self.shown):
                self._draw(self.shown[place], curve, marks)
        self.chosen = chosen
        self._show_ring(chosen)
        self._fit()

    def _draw(self, line: ErrorLine, curve: pg.PlotCurveItem, marks: pg.ScatterPlotItem) -> None:
        colour = line.run.colour
        dash = Qt.PenStyle.DashLine if line.going else Qt.PenStyle.SolidLine
        curve.setData(np.array(line.x), np.array(line.y), pen=pg.mkPen(colour, width=1.6, style=dash))
        marks.setData(
            x=[x for x, _, _ in line.marks],
            y=[y for _, y, _ in line.marks],
            data=[(line.run.number, terms) for _, _, terms in line.marks],
            symbol=line.run.marker,
            brush=pg.mkBrush(colour),
            pen=pg.mkPen(theme.current().panel, width=0.8),
        )

    def _show_ring(self, chosen: tuple[int, int] | None) -> None:
        at = [(x, y) for line in self.shown for x, y, terms in line.marks if (line.run.number, terms) == chosen]
        self.ring.setData(x=[x for x, _ in at], y=[y for _, y in at], pen=pg.mkPen(theme.current().text, width=1.6))

    def _label(self, against: str, metric: str) -> None:
        self.x_label, self.y_label = AGAINST[against], label_of(metric)
        self.name_axes()
        bottom = self.getPlotItem().getAxis("bottom")
        bottom.setTicks(None)
        bottom.setTickSpacing(self._step(), 1)

    def _step(self) -> int:
        """Steps between numbers of terms that are written."""
        most = max((terms for line in self.shown for _, _, terms in line.marks), default=1)
        return max(1, int(np.ceil(most / 12)))

    def _fit(self) -> None:
        x = [value for line in self.shown for value in line.x]
        y = [value for line in self.shown for value in line.y]
        if not x:
            return
        low, high = min(y), max(y)
        room = 0.08 * max(high - low, 0.6)
        self.setYRange(low - room, high + room, padding=0)
        self.getPlotItem().getAxis("left").setTicks(log_ticks(low - room, high + room))
        left, right = min(x), max(x)
        side = 0.05 * max(right - left, 0.5)
        if self.x_label != AGAINST["terms"]:
            self.getPlotItem().getAxis("bottom").setTicks(log_ticks(left - side, right + side))
        self.setXRange(left - side, right + side, padding=0)

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        event.accept()

    def contextMenuEvent(self, event: QContextMenuEvent) -> None:
        menu = QMenu(self)
        menu.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        menu.addAction(SAVE, self.save_wanted.emit)
        menu.popup(event.globalPos())

    def keyPressEvent(self, event: QKeyEvent) -> None:
        step = {int(Qt.Key.Key_Left): -1, int(Qt.Key.Key_Right): 1}.get(event.key())
        if step is None or self.chosen is None:
            super().keyPressEvent(event)
            return
        number, terms = self.chosen
        if any((line.run.number, of) == (number, terms + step) for line in self.shown for _, _, of in line.marks):
            self.picked.emit(number, terms + step)

    def _on_clicked(self, _points: pg.ScatterPlotItem, clicked: Sequence[Any], _event: object) -> None:
        if len(clicked):
            number, terms = clicked[0].data()
            self.picked.emit(number, terms)

    def place_of(self, number: int, terms: int) -> QPointF | None:
        """The position on the widget of the point of a run and its number of terms."""
        for line in self.shown:
            for x, y, of in line.marks:
                if (line.run.number, of) == (number, terms):
                    box = self.getPlotItem().getViewBox()
                    return QPointF(self.mapFromScene(box.mapViewToScene(QPointF(x, y))))
        return None


def label_of(metric: str) -> str:
    """An error metric with its unit; errors of logarithms are pure numbers."""
    words, unit = METRICS[metric]
    return f"{words} / {unit or 1}"


def errors_as_csv(runs: Sequence[tuple[Run, Live]]) -> bytes:
    """All errors of all runs, a line for each number of terms; empty where one is not known."""
    headings = ("Run", "Method", "Number of terms", "Textures", "Time / s", "Size / B", *map(label_of, METRICS))
    lines = (
        (
            run.name,
            live.factorisation.method if live.factorisation is not None else "",
            *(term_error.terms, term_error.textures, term_error.time_s, term_error.size_bytes),
            *(term_error.error(metric) for metric in METRICS),
        )
        for run, live in runs
        for term_error in live.term_errors
    )
    return rows_of(headings, lines)


def log_ticks(low: float, high: float) -> list[list[tuple[float, str]]]:
    """Ticks for an axis from 10^`low` to 10^`high`: the fewer steps in a decade, the more decades there are."""
    decades = range(int(np.floor(low)), int(np.ceil(high)) + 1)
    apart = -(-len(decades) // 8)
    seen: list[tuple[float, float]] = []
    for steps in STEPS[0 if high - low >= 2.5 else 1 if high - low >= 1.0 else 2 :]:
        found = [(decade + float(np.log10(step)), step * 10.0**decade) for decade in decades[::apart] for step in steps]
        seen = [(place, value) for place, value in found if low <= place <= high]
        if len(seen) >= FEWEST:
            break
    return [[(place, plain(float(f"{value:.6g}"))) for place, value in seen]]


def line_of(run: Run, live: Live, against: str, metric: str) -> ErrorLine | None:
    """The error line of a run; None before it has found anything, and for errors that are not known of it.

    Against time the line goes through everything that was found on the way, against the others through the terms.
    """
    term_errors = [term_error for term_error in live.term_errors if term_error.error(metric) is not None]
    if not term_errors:
        return None

    def error(term_error: TermError) -> float:
        value = term_error.error(metric)
        assert value is not None, "points without an error are not shown"
        return log10(max(value, MINIMUM))

    def place(term_error: TermError) -> float:
        if against == "terms":
            return float(term_error.terms)
        return log10(max(term_error.time_s if against == "time" else term_error.size_bytes / 1e3, SHORTEST))

    way = term_errors
    if against == "time":
        way = [term_error for term_error in live.history if term_error.error(metric) is not None]
        way += [term_error for term_error in term_errors if term_error not in way]
        way.sort(key=lambda term_error: term_error.time_s)
    marks = [(place(term_error), error(term_error), term_error.terms) for term_error in term_errors]
    return ErrorLine(
        run,
        [place(term_error) for term_error in way],
        [error(term_error) for term_error in way],
        marks,
        live.job is not None,
    )
