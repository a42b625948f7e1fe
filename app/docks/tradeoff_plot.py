"""Error against cost, a colour and a marker for each mode, the front joined; a click applies a setting.

Both axes are logarithmic: modes differ by orders of magnitude in each. Points that cost nothing on the axis that is
looked at are left out, and the dock says how many.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from math import log10
from typing import Any

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QPointF, Qt, Signal
from PySide6.QtGui import QColor, QKeyEvent, QMouseEvent

from app.document.measured import AXES, Accuracy, describe
from app.document.modes import mode_named, modes
from app.factor.plot import log_ticks
from app.widgets import theme
from app.widgets.language import translate
from app.widgets.plots import Plot
from engine.planning.costs.setting import Setting
from engine.tradeoff.front import front
from engine.tradeoff.point import Point

MARK_PX = 9

#: Errors below this are drawn on it: a logarithm needs an end.
MINIMUM = 1e-6


class TradeoffPlot(Plot):
    """`picked(Setting)` follows a click on a point or Enter on the one that the arrow keys have reached."""

    picked = Signal(object)

    def __init__(self) -> None:
        super().__init__(AXES["frame"][0], "Error / %")
        self.setAccessibleName("Error against cost")
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.shown: list[Point] = []
        self.axis = "frame"
        self.accuracy: Accuracy | None = None
        self.current: Setting | None = None
        self.focused: Setting | None = None
        item = self.getPlotItem()
        self.joined = pg.PlotCurveItem(stepMode=None)
        self.bars = pg.ErrorBarItem(x=np.zeros(0), y=np.zeros(0), top=np.zeros(0), bottom=np.zeros(0), beam=0.0)
        self.ring = pg.ScatterPlotItem(size=MARK_PX + 9, brush=None, tip=None)
        self.reached = pg.ScatterPlotItem(size=MARK_PX + 5, symbol="s", brush=None, tip=None)
        self.marks: dict[str, Any] = {}
        for each in (self.joined, self.bars, self.ring, self.reached):
            item.addItem(each, ignoreBounds=True)
        self.nothing = pg.TextItem(translate("Measured settings appear here"), anchor=(0.5, 0.5))
        item.addItem(self.nothing, ignoreBounds=True)
        for mode in modes():
            marks = pg.ScatterPlotItem(
                size=MARK_PX, symbol=mode.mark[0], hoverable=True, hoverSize=MARK_PX + 4, tip=self._tip
            )
            marks.sigClicked.connect(self._on_clicked)
            marks.setZValue(4)
            item.addItem(marks, ignoreBounds=True)
            self.marks[mode.value] = marks
        self._draw()

    def show_points(self, accuracy: Accuracy | None, axis: str, current: Setting | None) -> None:
        """Show all points against `axis` (`engine.tradeoff.point.COSTS`), a ring around the `current` setting."""
        are_others = accuracy is not self.accuracy or axis != self.axis
        is_other = current != self.current
        self.accuracy, self.axis, self.current = accuracy, axis, current
        if are_others:
            self._draw()
        elif is_other:
            self._ring()

    def _draw(self) -> None:
        accuracy, axis = self.accuracy, self.axis
        points = accuracy.points if accuracy is not None else ()
        self.shown = [point for point in points if point.cost(axis) > 0.0]
        self.x_label = AXES[axis][0]
        best = {id(point) for point in front(self.shown, axis)}
        for mode, marks in self.marks.items():
            self._mark(marks, [point for point in self.shown if point.mode == mode], best)
        self._join(axis)
        self._ring()
        self._fit()
        super().apply_theme()

    @property
    def free(self) -> int:
        """The number of points without cost on this axis; they are not shown."""
        return len(self.accuracy.points) - len(self.shown) if self.accuracy is not None else 0

    def _mark(self, marks: pg.ScatterPlotItem, points: Sequence[Point], best: set[int]) -> None:
        colour = theme.line(mode_named(points[0].mode).colour) if points else "#000000"
        panel = theme.current().panel
        marks.setData(
            x=[self._place(point)[0] for point in points],
            y=[self._place(point)[1] for point in points],
            data=list(points),
            brush=[pg.mkBrush(colour if id(point) in best else panel) for point in points],
            pen=[pg.mkPen(colour, width=1.4)] * len(points),
        )

    def _join(self, axis: str) -> None:
        """The front as steps, and bars of uncertainty."""
        places = [self._place(point) for point in front(self.shown, axis)]
        corners = [places[0]] if places else []
        for before, after in itertools.pairwise(places):
            corners += [(after[0], before[1]), after]
        x, y = np.array([x for x, _ in corners]), np.array([y for _, y in corners])
        self.joined.setData(x, y, pen=pg.mkPen(theme.current().secondary, width=1.2))
        spread = [self._spread(point) for point in self.shown]
        self.bars.setData(
            x=np.array([self._place(point)[0] for point in self.shown]),
            y=np.array([self._place(point)[1] for point in self.shown]),
            top=np.array([top for top, _ in spread]),
            bottom=np.array([bottom for _, bottom in spread]),
            pen=pg.mkPen(theme.current().secondary, width=1.0),
        )

    def _spread(self, point: Point) -> tuple[float, float]:
        error = max(point.error_rmse_rel, MINIMUM)
        low = max(error - point.error_uncertainty, 0.05 * error)
        return log10((error + point.error_uncertainty) / error), log10(error / low)

    def _place(self, point: Point) -> tuple[float, float]:
        x = AXES[self.axis][1] * point.cost(self.axis)
        return log10(x), log10(100.0 * max(point.error_rmse_rel, MINIMUM))

    def _ring(self) -> None:
        for ring, setting, colour in (
            (self.ring, self.current, theme.current().text),
            (self.reached, self.focused, theme.current().accent),
        ):
            at = [self._place(point) for point in self.shown if point.setting == setting]
            ring.setData(x=[x for x, _ in at], y=[y for _, y in at], pen=pg.mkPen(colour, width=1.6))

    def _fit(self) -> None:
        self.nothing.setVisible(not self.shown)
        if not self.shown:
            for side in ("bottom", "left"):
                self.getPlotItem().getAxis(side).setTicks([])  # numbers would be of nothing
            self.nothing.setColor(QColor(theme.current().secondary))
            self.nothing.setPos(self.getPlotItem().getViewBox().viewRect().center())
            return
        places = [self._place(point) for point in self.shown]
        for at, (side, least) in enumerate((("bottom", 0.5), ("left", 0.4))):
            values = [place[at] for place in places]
            middle, half = (min(values) + max(values)) / 2.0, max(max(values) - min(values), least) / 2.0
            low, high = middle - 1.14 * half, middle + 1.14 * half
            self.getPlotItem().getAxis(side).setTicks(log_ticks(low, high))
            (self.setYRange if at else self.setXRange)(low, high, padding=0)

    def _tip(self, x: float, y: float, data: Point) -> str:
        del x, y
        return f"{describe(data, self.accuracy)}\nClick to use it"

    def apply_theme(self) -> None:
        """Take the colours of the current theme."""
        super().apply_theme()
        if hasattr(self, "marks"):
            self._draw()

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        event.accept()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        order = sorted(self.shown, key=self._place)
        settings = [point.setting for point in order]
        step = {int(Qt.Key.Key_Left): -1, int(Qt.Key.Key_Right): 1}.get(event.key())
        if event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter) and self.focused is not None:
            self.picked.emit(self.focused)
        elif step is None or not settings:
            super().keyPressEvent(event)
        else:
            start = self.focused if self.focused in settings else self.current
            at = settings.index(start) + step if start in settings else 0
            self.focused = settings[min(max(at, 0), len(settings) - 1)]
            self.setAccessibleDescription(describe(order[settings.index(self.focused)], self.accuracy))
            self._ring()

    def _on_clicked(self, _points: pg.ScatterPlotItem, clicked: Sequence[Any], _event: object) -> None:
        if len(clicked):
            self.picked.emit(clicked[0].data().setting)

    def place_of(self, setting: Setting) -> QPointF | None:
        """The position on the widget of the point of a setting."""
        for point in self.shown:
            if point.setting == setting:
                box = self.getPlotItem().getViewBox()
                return QPointF(self.mapFromScene(box.mapViewToScene(QPointF(*self._place(point)))))
        return None
