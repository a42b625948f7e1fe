"""Plots in pyqtgraph: axes with units, Okabe–Ito lines with distinct markers, double-click to see everything."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pyqtgraph as pg
from numpy.typing import ArrayLike, NDArray
from PySide6.QtCore import QPointF, QSize, Qt, Signal
from PySide6.QtGui import QAccessible, QColor, QFontMetrics, QMouseEvent, QPainter, QPaintEvent, QResizeEvent
from PySide6.QtWidgets import QWidget

from app.widgets import theme
from app.widgets.language import translate
from app.widgets.number_field import plain
from engine.core.figure_text import format_fixed, local

pg.setConfigOptions(antialias=True)

#: Pixels along an axis of a plot that are not its own: those of the other axis and the margins.
BESIDE_AXIS = 56


class Axis(pg.AxisItem):
    """An axis with its figures in the form of the chosen language."""

    def tickStrings(self, values: Any, scale: Any, spacing: Any) -> list[str]:
        return [local(str(each)) for each in super().tickStrings(values, scale, spacing)]


class Plot(pg.PlotWidget):
    """A plot in the window's colours."""

    accessible_role = QAccessible.Role.Chart

    x_label = y_label = ""

    def __init__(self, x_label: str, y_label: str) -> None:
        axes = {side: Axis(side) for side in ("bottom", "left")}
        super().__init__(enableMenu=False, axisItems=axes)
        self.x_label, self.y_label = x_label, y_label
        self.setAccessibleName(y_label or x_label)
        item = self.getPlotItem()
        item.hideButtons()
        item.getViewBox().setMouseEnabled(x=False, y=False)
        item.setContentsMargins(4, 8, 12, 4)
        self.setMinimumHeight(120)
        self.apply_theme()

    def sizeHint(self) -> QSize:
        return QSize(320, 180)

    def apply_theme(self) -> None:
        """Take the colours of the current theme."""
        colours = theme.current()
        self.setBackground(colours.panel)
        for side in ("bottom", "left"):
            axis = self.getPlotItem().getAxis(side)
            axis.setPen(pg.mkPen(colours.line))
            axis.setTextPen(pg.mkPen(colours.secondary))
            axis.setTickFont(theme.font(11))
            axis.setStyle(tickLength=-4, maxTickLevel=1)
        self.name_axes()
        self.showGrid(x=False, y=True, alpha=0.12)

    def name_axes(self) -> None:
        """Name each axis in the longest of three forms that there is room for, or not at all.

        A part of the quantity's name that follows a comma goes before its unit does.
        """
        style = {"color": theme.current().secondary, "font-size": "11px"}
        for side, words in self._fitting().items():
            self.getPlotItem().getAxis(side).setLabel(translate(words) or None, siPrefixEnableRanges=(), **style)

    def _fitting(self) -> dict[str, str]:
        metrics, fitting = QFontMetrics(theme.font(11)), {}
        for side, words, room in (("bottom", self.x_label, self.width()), ("left", self.y_label, self.height())):
            quantity, _, unit = words.partition(" / ")
            short = quantity.split(",")[0]
            forms = (words, f"{short} / {unit}" if unit else short, short)
            fits = (form for form in forms if metrics.horizontalAdvance(form) <= room - BESIDE_AXIS)
            fitting[side] = next(fits, "")
        return fitting

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        axis_of = self.getPlotItem().getAxis if self.y_label else None  # pyqtgraph resizes it before it is made
        if axis_of is not None and any(axis_of(side).labelText != words for side, words in self._fitting().items()):
            self.name_axes()

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        self.getPlotItem().autoRange()
        event.accept()


class Elevations(Plot):
    """Mean radiance of the photographs against the light's elevation.

    A click on a point selects its photograph; a click on the handle below it excludes it or takes it in again.
    """

    selected = Signal(int)
    toggled = Signal(int)

    def __init__(self) -> None:
        super().__init__("Elevation of the light / °", "Mean radiance")
        self.line = self.plot([], [], pen=pg.mkPen(theme.LINES[0], width=1.5))
        self.points = pg.ScatterPlotItem(size=9, hoverable=True, hoverSize=11, tip=None)
        self.points.sigClicked.connect(self._on_clicked)
        self.addItem(self.points)
        self.handles = pg.ScatterPlotItem(size=8, symbol="t1", hoverable=True, hoverSize=12, tip=None)
        self.handles.sigClicked.connect(self._handle_clicked)
        self.addItem(self.handles)
        self.setToolTip("Click a point to show its photograph, the triangle below it to exclude or include it")

    def show_means(
        self, elevation_deg: ArrayLike, mean: ArrayLike, excluded: Sequence[bool], current: int | None
    ) -> None:
        """Filled points are used, hollow ones excluded; the current photograph has a ring in the text's colour."""
        elevation, radiance = np.asarray(elevation_deg, float), np.asarray(mean, float)
        used = ~np.asarray(excluded, bool) if len(excluded) else np.ones(len(elevation), bool)
        order = np.argsort(elevation[used], kind="stable")
        self.line.setData(elevation[used][order], radiance[used][order])
        colours = theme.current()
        blue, panel = QColor(theme.LINES[0]), QColor(colours.panel)
        self.points.setData(
            x=elevation,
            y=radiance,
            data=list(range(len(elevation))),
            brush=[pg.mkBrush(blue if use else panel) for use in used],
            pen=[
                pg.mkPen(colours.text, width=2.5) if index == current else pg.mkPen(blue, width=1.5)
                for index in range(len(elevation))
            ],
        )
        if len(elevation):
            top = max(float(radiance.max()) * 1.08, 1e-6)
            self.handles.setData(
                x=elevation,
                y=np.full(len(elevation), -0.06 * top),
                data=list(range(len(elevation))),
                brush=[pg.mkBrush(QColor(colours.secondary) if use else panel) for use in used],
                pen=pg.mkPen(colours.secondary, width=1.2),
            )
            self.setYRange(-0.12 * top, top, padding=0)
            self.setXRange(float(elevation.min()) - 3, float(elevation.max()) + 3, padding=0)

    def _on_clicked(self, _points: pg.ScatterPlotItem, clicked: Sequence[Any], _event: object) -> None:
        if len(clicked):
            self.selected.emit(int(clicked[0].data()))

    def _handle_clicked(self, _handles: Any, clicked: Sequence[Any], _event: object) -> None:
        if len(clicked):
            self.toggled.emit(int(clicked[0].data()))


class RadiancePlot(Plot):
    """Mean radiance of the slices: measured points on the line they should lie on."""

    def __init__(self) -> None:
        super().__init__("r = BRDF × cosine", "Mean radiance")
        self.target = self.plot([], [], pen=pg.mkPen(theme.LINES[1], width=1.5), name="target")
        self.measured = pg.ScatterPlotItem(size=8, brush=pg.mkBrush(theme.LINES[0]), pen=None)
        self.current = pg.InfiniteLine(angle=90, pen=pg.mkPen(theme.current().secondary, style=Qt.PenStyle.DashLine))
        self.addItem(self.measured)
        self.addItem(self.current)
        self.current.hide()

    def show_slices(self, target: ArrayLike, mean: ArrayLike) -> None:
        """Show `target` and `mean` (S,): the intended and the actual mean luminance of each slice."""
        target, mean = np.asarray(target, float), np.asarray(mean, float)
        self.target.setData(target, target)
        self.measured.setData(x=target, y=mean)
        if len(target):
            self.setXRange(0.0, float(target[-1]), padding=0.04)
            self.setYRange(0.0, float(max(target[-1], mean.max())) * 1.06 or 1.0, padding=0)

    def show_current(self, r: float | None) -> None:
        """A dashed line at the r of the image on screen."""
        self.current.setVisible(r is not None)
        if r is not None:
            self.current.setValue(r)


class TexelPlot(Plot):
    """One texel over r: its slices as points, the power law as a line, in the three channels."""

    CHANNELS = (("#d55e00", "o"), ("#009e73", "s"), ("#56b4e9", "t"))

    def __init__(self) -> None:
        super().__init__("r = BRDF × cosine", "Radiance of the texel")
        self.points = [
            pg.ScatterPlotItem(size=7, symbol=mark, brush=colour, pen=None) for colour, mark in self.CHANNELS
        ]
        self.curves = [self.plot([], [], pen=pg.mkPen(colour, width=1.5)) for colour, _ in self.CHANNELS]
        for points in self.points:
            self.addItem(points)

    def show_texel(
        self,
        r: NDArray[np.float64],
        slices: NDArray[np.float64] | None,
        fitted: NDArray[np.float64] | None,
        fitted_r: NDArray[np.float64],
    ) -> None:
        """`slices` (S, 3) at `r` (S,) and `fitted` (M, 3) at `fitted_r` (M,); None where there is none."""
        highest = 0.0
        for channel in range(3):
            values = slices[:, channel] if slices is not None else np.empty(0)
            self.points[channel].setData(x=r[: len(values)], y=values)
            curve = fitted[:, channel] if fitted is not None else np.empty(0)
            self.curves[channel].setData(fitted_r if len(curve) else [], curve)
            highest = max(highest, 1e-6, *(float(v.max()) for v in (values, curve) if len(v)))
        if len(r):
            self.setXRange(float(r[0]), float(r[-1]), padding=0.04)
            self.setYRange(0.0, highest * 1.08, padding=0)


class ColourBar(QWidget):
    """The scale of a map: colours from `low` to `high`, with figures."""

    accessible_role = QAccessible.Role.Graphic

    def __init__(self, table: NDArray[np.uint8]) -> None:
        super().__init__()
        self.table = table
        self.setAccessibleName("Colour scale")
        self.low = self.high = 0.0
        self.caption = ""
        self.setFixedWidth(84)

    def show_scale(self, high: float, caption: str, low: float = 0.0) -> None:
        """The values of the last and the first colour, and what the colours mean; no scale where they are equal."""
        self.low, self.high, self.caption = low, high, caption
        self.update()

    def paintEvent(self, _event: QPaintEvent) -> None:
        painter = QPainter(self)
        colours = theme.current()
        painter.fillRect(self.rect(), QColor(colours.canvas))
        if self.high <= self.low:
            return
        top, bottom = 40, self.height() - 24
        for y in range(top, bottom):
            red, green, blue = self.table[round(255 * (bottom - 1 - y) / max(1, bottom - 1 - top))]
            painter.fillRect(8, y, 12, 1, QColor(int(red), int(green), int(blue)))
        painter.setFont(theme.font(11))
        painter.setPen(QColor(colours.secondary))
        painter.drawText(QPointF(8, 22), self.caption)
        painter.setPen(QColor(colours.text))
        for number, label in enumerate(scale_labels(self.low, self.high)):
            place = bottom - 0.25 * number * (bottom - top)
            painter.drawText(QPointF(26, place + 4), label)


def scale_labels(low: float, high: float) -> list[str]:
    """The values at five equal steps of a scale, with as few decimals as tell them, two digits of a step at most."""
    values, step = np.linspace(low, high, 5), 0.25 * (high - low)
    if not 1e-4 <= step < 1e5:
        return [plain(float(f"{value:.2g}")) for value in values]
    digits = -math.floor(math.log10(step))
    few, most = max(0, digits), max(0, digits + 1)
    places = few if np.abs(values - values.round(few)).max() < 0.01 * step else most
    return [format_fixed(float(value), places) for value in values]


def colour_table(name: str = "cividis") -> NDArray[np.uint8]:
    """(256, 3) uint8 of a perceptually even colour map."""
    return np.asarray(pg.colormap.get(name).getLookupTable(nPts=256, alpha=False), np.uint8)
