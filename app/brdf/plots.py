"""Plots of BRDFs: in the plane of incidence, over half and difference angles, albedo, residual."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import cos, radians, sin
from typing import Any

import numpy as np
import pyqtgraph as pg
from numpy.typing import ArrayLike, NDArray
from pyqtgraph.graphicsItems.ScatterPlotItem import Symbols
from PySide6.QtCore import QEvent, QPointF, QRectF, Qt, Signal
from PySide6.QtGui import QColor, QIcon, QMouseEvent, QPainter, QPainterPath, QPen, QPixmap, QTransform

from app.commands.brdf_figures import NEAR_HORIZON
from app.widgets import theme
from app.widgets.number_field import plain
from app.widgets.plots import Plot, colour_table
from engine.core.figure_text import number

Floats = NDArray[np.float64]

#: Decades that the image over half and difference angles shows below its highest value.
DECADES = 5.0
MARK_PX = 9
RINGS = (0.25, 0.5, 0.75, 1.0)
SPOKES_DEG = (-90, -60, -30, 0, 30, 60, 90)


@dataclass(frozen=True, eq=False)
class Line:
    """One curve: its points, and the colour and marker of its entry; `live` is not in the list yet."""

    x: Floats
    y: Floats
    colour: str
    marker: str
    live: bool = False


class _Lines:
    """Curves of a plot and their markers, reused from image to image."""

    def __init__(self, plot: Plot) -> None:
        self.plot = plot
        self.items: list[tuple[Any, Any]] = []

    def show(self, lines: Sequence[Line], every: int) -> None:
        """Show `lines` with a marker at every so many points, shifted from line to line."""
        while len(self.items) < len(lines):
            made = pg.PlotCurveItem(), pg.ScatterPlotItem(size=MARK_PX, tip=None)
            for item in made:
                self.plot.addItem(item, ignoreBounds=True)
            self.items.append(made)
        for place, (curve, marks) in enumerate(self.items):
            shown = place < len(lines)
            curve.setVisible(shown)
            marks.setVisible(shown)
            if not shown:
                continue
            line = lines[place]
            dash = Qt.PenStyle.DashLine if line.live else Qt.PenStyle.SolidLine
            curve.setData(line.x, line.y, pen=pg.mkPen(line.colour, width=1.6, style=dash))
            chosen = slice((place * 3) % every if every > 1 else 0, None, every)
            marks.setData(
                x=line.x[chosen],
                y=line.y[chosen],
                symbol=line.marker,
                brush=pg.mkBrush(line.colour),
                pen=pg.mkPen(theme.current().panel, width=0.8),
            )


class PolarPlot(Plot):
    """Values in the plane of incidence as distance from the middle; the light comes from the left."""

    def __init__(self) -> None:
        super().__init__("", "")
        item = self.getPlotItem()
        item.getViewBox().setAspectLocked(True)
        for side in ("left", "bottom"):
            item.hideAxis(side)
        self.setAccessibleName("Values in the plane of incidence")
        self.setToolTip("Distance from the centre: the value in that direction. Dashed line: the light")
        self.grid = pg.PlotCurveItem(connect="finite")
        self.light = pg.PlotCurveItem()
        for part in (self.grid, self.light):
            self.addItem(part, ignoreBounds=True)
        self.labels = []
        for angle in SPOKES_DEG:
            label = pg.TextItem(f"{abs(angle)}°", anchor=(0.5, 0.5))
            label.setPos(1.14 * sin(radians(angle)), 1.1 * cos(radians(angle)))
            self.addItem(label, ignoreBounds=True)
            self.labels.append(label)
        self.lines = _Lines(self)
        self.setXRange(-1.25, 1.25, padding=0)
        self.setYRange(-0.06, 1.2, padding=0)
        self._tint()

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        event.accept()

    def apply_theme(self) -> None:
        super().apply_theme()
        self.showGrid(x=False, y=False)
        if hasattr(self, "grid"):
            self._tint()

    def _tint(self) -> None:
        colours = theme.current()
        turn = np.radians(np.linspace(-90.0, 90.0, 91))
        pieces = [np.stack([ring * np.sin(turn), ring * np.cos(turn)]) for ring in RINGS]
        pieces += [np.array([[0.0, sin(radians(a))], [0.0, cos(radians(a))]]) for a in SPOKES_DEG]
        gap = np.full((2, 1), np.nan)
        x, y = np.concatenate([part for piece in pieces for part in (piece, gap)], axis=1)
        self.grid.setData(x, y, pen=pg.mkPen(colours.line, width=1))
        for label in self.labels:
            label.setColor(QColor(colours.secondary))
            label.setFont(theme.font(10))

    def show_lines(self, lines: Sequence[Line], theta_i: float) -> None:
        """`x` of a line is the signed angle, `y` the share of the outermost ring."""
        x, y = -1.08 * sin(theta_i), 1.08 * cos(theta_i)
        self.light.setData(
            [0.0, x], [0.0, y], pen=pg.mkPen(theme.current().text, width=1.4, style=Qt.PenStyle.DashLine)
        )
        self.lines.show(
            [
                Line(line.y * np.sin(line.x), line.y * np.cos(line.x), line.colour, line.marker, line.live)
                for line in lines
            ],
            36,
        )


class HalfDifferencePlot(Plot):
    """One BRDF over theta_h and theta_d, luminance in colours by its logarithm; the pointer reads values."""

    read = Signal(str)

    def __init__(self) -> None:
        super().__init__("θ half / °", "θ difference / °")
        self.values: Floats | None = None
        self.image = pg.ImageItem(axisOrder="row-major")
        self.image.setLookupTable(colour_table())
        self.image.setRect(QRectF(0.0, 0.0, 90.0, 90.0))
        self.addItem(self.image)
        self.showGrid(x=False, y=False)
        self.setXRange(0.0, 90.0, padding=0)
        self.setYRange(0.0, 90.0, padding=0)
        for side in ("left", "bottom"):
            self.getPlotItem().getAxis(side).setTickSpacing(30, 30)
        self.setAccessibleName("Values over half and difference angle")
        self.setToolTip("The highlight is on the left, grazing reflection above, retro-reflection below")
        self.scene().sigMouseMoved.connect(self._on_pointed)

    def apply_theme(self) -> None:
        super().apply_theme()
        self.showGrid(x=False, y=False)

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        event.accept()

    def show_values(self, values: Floats | None) -> None:
        """`values` (N, N), theta_h by column and theta_d by row from the bottom; None shows nothing."""
        if values is self.values:
            return
        self.values = values
        self.image.setVisible(values is not None)
        if values is not None:
            highest = self._highest()
            logs = np.log10(np.maximum(values[::-1], highest * 10.0**-DECADES) / highest)
            self.image.setImage(logs, levels=(min(float(logs.min()), -1e-3), 0.0))
            self.image.setRect(QRectF(0.0, 0.0, 90.0, 90.0))
        self.read.emit(self.range_text())

    def _highest(self) -> float:
        """The largest value away from the horizon, beyond which the colours stay at the top."""
        assert self.values is not None
        angle = np.radians(90.0) * (np.arange(len(self.values)) + 0.5) / len(self.values)
        cosine = np.cos(angle[None, :]) * np.cos(angle[::-1, None])
        return max(float(self.values[cosine > cos(NEAR_HORIZON)].max()), 1e-12)

    def range_text(self) -> str:
        """The range of values that the colours span."""
        if self.values is None:
            return ""
        highest = self._highest()
        lowest = max(float(self.values.min()), highest * 10.0**-DECADES)
        return f"{number(lowest)}–{number(highest, 3)} sr⁻¹"

    def _on_pointed(self, place: QPointF) -> None:
        if self.values is None:
            return
        at = self.getPlotItem().getViewBox().mapSceneToView(place)
        size = len(self.values)
        column, row = int(at.x() / 90.0 * size), int(at.y() / 90.0 * size)
        if 0 <= column < size and 0 <= row < size:
            value = float(self.values[size - 1 - row, column])
            self.read.emit(f"{at.x():.0f}°, {at.y():.0f}°: {plain(value)}")
        else:
            self.read.emit(self.range_text())

    def leaveEvent(self, event: QEvent) -> None:
        super().leaveEvent(event)
        self.read.emit(self.range_text())


class AlbedoPlot(Plot):
    """The share of light that leaves towards a viewer, against the viewer's angle."""

    def __init__(self) -> None:
        super().__init__("Angle from the normal / °", "Albedo")
        self.setAccessibleName("Albedo against angle")
        self.setToolTip("Above 1, the dashed line, the BRDF would reflect more light than it receives")
        self.one = pg.InfiniteLine(1.0, angle=0)
        self.addItem(self.one, ignoreBounds=True)
        self.lines = _Lines(self)
        self.setXRange(0.0, 90.0, padding=0.02)
        self.getPlotItem().getAxis("bottom").setTickSpacing(30, 30)
        self._tint()

    def apply_theme(self) -> None:
        super().apply_theme()
        if hasattr(self, "one"):
            self._tint()

    def _tint(self) -> None:
        self.one.setPen(pg.mkPen(theme.current().secondary, style=Qt.PenStyle.DashLine))

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        event.accept()

    def show_lines(self, lines: Sequence[Line]) -> None:
        """`x` of a line in degrees, `y` its albedo."""
        highest = max((float(line.y.max()) for line in lines), default=1.0)
        self.setYRange(0.0, 1.08 * max(min(highest, 4.0), 0.05), padding=0)
        self.lines.show(lines, 1)


class ResidualPlot(Plot):
    """The residual of a fit against the half angle: at its start, and now."""

    def __init__(self) -> None:
        super().__init__("θ half / °", "Error / %")
        self.setAccessibleName("Error of the fit by half angle")
        self.setToolTip("RMS of BRDF × cosine relative to that of the data: the dashed line at the start of the fit")
        self.setFixedHeight(124)
        self.start = pg.PlotCurveItem()
        self.now = pg.PlotCurveItem()
        for item in (self.start, self.now):
            self.addItem(item)
        self.setXRange(0.0, 90.0, padding=0.02)
        self.getPlotItem().getAxis("bottom").setTickSpacing(30, 30)

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        event.accept()

    def show_errors(self, edges: ArrayLike, start: Floats, now: Floats, colour: str) -> None:
        """`edges` (N + 1,) in radians, errors (N,) as fractions."""
        middles = np.degrees(np.asarray(edges)[:-1] + np.diff(edges) / 2.0)
        grey = theme.current().secondary
        self.start.setData(middles, 100.0 * start, pen=pg.mkPen(grey, width=1.2, style=Qt.PenStyle.DashLine))
        self.now.setData(middles, 100.0 * now, pen=pg.mkPen(colour, width=1.6))
        self.setYRange(0.0, 108.0 * max(float(start.max()), float(now.max()), 1e-3), padding=0)


def marker_path(marker: str, size: float) -> QPainterPath:
    """The outline of a marker, `size` pixels across, around the origin."""
    path = QPainterPath(Symbols[marker])
    box = path.boundingRect()
    scale = size / max(box.width(), box.height(), 1e-6)
    return QTransform.fromScale(scale, scale).map(path)


def marker_icon(colour: str, marker: str) -> QIcon:
    """A marker on its line, as in the plots."""
    image = QPixmap(44, 32)
    image.setDevicePixelRatio(2.0)
    image.fill(Qt.GlobalColor.transparent)
    painter = QPainter(image)
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    painter.setPen(QPen(QColor(colour), 1.8))
    painter.drawLine(QPointF(1, 8), QPointF(21, 8))
    painter.translate(11, 8)
    painter.setPen(QPen(QColor(theme.current().panel), 0.8))
    painter.setBrush(QColor(colour))
    painter.drawPath(marker_path(marker, 10.0))
    painter.end()
    icon = QIcon(image)
    icon.addPixmap(image, QIcon.Mode.Selected)
    return icon
