"""The lamps of a capture as dots on the disk of their hemisphere, from above: where to click, and where to draw.

The middle is the zenith, the rim the plane of the sample, azimuth 0° is on the right and 90° on top as in the image.
Dots are coloured by how far the other photographs are from predicting theirs, from blue for not at all to red for the
farthest; those of left out photographs are hollow.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from PySide6.QtCore import QEvent, QPointF, QSize, Qt, Signal
from PySide6.QtGui import (
    QAccessible,
    QColor,
    QHelpEvent,
    QKeyEvent,
    QMouseEvent,
    QPainter,
    QPaintEvent,
    QPen,
    QPolygonF,
)
from PySide6.QtWidgets import QGridLayout, QHBoxLayout, QToolTip, QVBoxLayout, QWidget

from app.widgets import theme
from app.widgets.number_field import NumberField
from app.widgets.panels import button, enable, text
from app.widgets.theme import PADDING, STEP, role
from engine.capture.lights.azimuth_spread import ONE_ARC, azimuth_spread
from engine.capture.stack import ImageStack
from engine.core.figure_text import format_fixed, percent

#: Radius of a dot, distance at which a click still meets one, and distance after which a drag is a lasso, in pixels.
DOT, REACH, DRAG = 4.5, 9.0, 4.0

#: Relative error of predicting a photograph from the others below which no dot has the last colour.
MIN_WORST = 0.1


@dataclass(frozen=True)
class Lamp:
    """The lamp of one photograph; `error` is that of predicting it from the others, None where nobody knows it."""

    name: str
    elevation_deg: float
    azimuth_deg: float
    error: float | None
    excluded: bool

    @property
    def place(self) -> tuple[float, float]:
        """(x, y) in the unit disk, y upwards."""
        radius = math.cos(math.radians(self.elevation_deg))
        azimuth = math.radians(self.azimuth_deg)
        return radius * math.cos(azimuth), radius * math.sin(azimuth)

    def is_within(self, azimuth_deg: float, tolerance_deg: float, elevation_deg: tuple[float, float]) -> bool:
        """True if the azimuth is within the tolerance, round the circle, and the elevation in its range."""
        apart = abs((self.azimuth_deg - azimuth_deg + 180.0) % 360.0 - 180.0)
        return apart <= tolerance_deg and elevation_deg[0] <= self.elevation_deg <= elevation_deg[1]


def lamps_of(stack: ImageStack | None, excluded: frozenset[str]) -> tuple[Lamp, ...]:
    """The lamps of a stack, in its order; none where it knows no azimuths, or one arc alone."""
    if stack is None or stack.azimuth is None or azimuth_spread(stack.azimuth) <= ONE_ARC:
        return ()
    azimuths = np.degrees(stack.azimuth) % 360.0
    errors = [each.leave_one_out_error for each in stack.quality] or [None] * len(stack.sources)
    rows = zip(stack.sources, stack.elevation_deg, azimuths, errors, strict=True)
    return tuple(Lamp(name, float(el), float(az), error, name in excluded) for name, el, az, error in rows)


class DomeImage(QWidget):
    """The disk. A click chooses a lamp, with Ctrl it picks one more or less; a line drawn round lamps picks them."""

    accessible_role = QAccessible.Role.Chart

    chosen = Signal(int)
    picked = Signal(list)

    #: Words where the mouse rests beside the lamps.
    legend = (
        "Blue: the other photographs predict this one. Red: they are the farthest from it. Hollow: excluded\n"
        "Click a lamp to see its photograph; Ctrl adds one; draw a line round several to select them"
    )

    def __init__(self) -> None:
        super().__init__()
        self.lamps: tuple[Lamp, ...] = ()
        self.selection: frozenset[int] = frozenset()
        self.current: int | None = None
        self._lasso: list[QPointF] = []
        self.setMinimumSize(120, 120)
        self.setMouseTracking(True)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setAccessibleName("Lamps above the sample")

    def sizeHint(self) -> QSize:
        return QSize(180, 180)

    def position(self, place: int) -> QPointF:
        """The middle of a lamp's dot, in pixels of the widget."""
        x, y = self.lamps[place].place
        return self._middle + QPointF(x, -y) * self._radius

    @property
    def _middle(self) -> QPointF:
        return QPointF(0.5 * self.width(), 0.5 * self.height())

    @property
    def _radius(self) -> float:
        return 0.5 * min(self.width(), self.height()) - 2.0 * PADDING

    def at(self, position: QPointF) -> int | None:
        """The lamp nearest to a position, within reach."""
        apart = [math.dist(self.position(place).toTuple(), position.toTuple()) for place in range(len(self.lamps))]
        nearest = int(np.argmin(apart)) if apart else None
        return nearest if nearest is not None and apart[nearest] <= REACH else None

    def mousePressEvent(self, event: QMouseEvent) -> None:
        if event.button() == Qt.MouseButton.LeftButton:
            self._lasso = [event.position()]

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        if self._lasso and math.dist(self._lasso[-1].toTuple(), event.position().toTuple()) >= DRAG:
            self._lasso.append(event.position())
            self.update()

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        drawn, self._lasso = self._lasso, []
        is_added = bool(event.modifiers() & Qt.KeyboardModifier.ControlModifier)
        if len(drawn) > 2:
            outline = QPolygonF(drawn)
            rule = Qt.FillRule.WindingFill
            inside = {place for place in range(len(self.lamps)) if outline.containsPoint(self.position(place), rule)}
            self.picked.emit(sorted(inside | self.selection if is_added else inside))
        elif drawn:
            met = self.at(drawn[0])
            if met is not None and is_added:
                self.picked.emit(sorted(self.selection ^ {met}))
            elif met is not None:
                self.chosen.emit(met)
        self.update()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Choose the lamp before or after the current one by arrow keys; Space selects it or not."""
        step = {int(Qt.Key.Key_Left): -1, int(Qt.Key.Key_Right): 1}.get(event.key())
        if self.lamps and step is not None:
            self.chosen.emit((0 if self.current is None else self.current + step) % len(self.lamps))
        elif self.current is not None and event.key() == Qt.Key.Key_Space:
            self.picked.emit(sorted(self.selection ^ {self.current}))
        else:
            super().keyPressEvent(event)

    def event(self, event: QEvent) -> bool:
        if isinstance(event, QHelpEvent):
            place = self.at(QPointF(event.pos()))
            QToolTip.showText(event.globalPos(), self.legend if place is None else self.words(self.lamps[place]), self)
            return True
        return super().event(event)

    def colour(self, lamp: Lamp, worst: float) -> tuple[int, int, int]:
        """Red, green and blue of a dot, by the error of predicting its photograph over the `worst` one."""
        return dot_colour((lamp.error or 0.0) / worst)

    def words(self, lamp: Lamp) -> str:
        """Return the lines that describe a lamp where the mouse rests on it."""
        error = "" if lamp.error is None else f"\nThe other photographs predict it to {percent(lamp.error)}"
        state = "\nExcluded from the material" if lamp.excluded else ""
        elevation, azimuth = format_fixed(lamp.elevation_deg, 1), format_fixed(lamp.azimuth_deg, 1)
        return f"{lamp.name}\nelevation {elevation}°, azimuth {azimuth}°{error}{state}"

    def paintEvent(self, _event: QPaintEvent) -> None:
        painter, colours = QPainter(self), theme.current()
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.fillRect(self.rect(), QColor(colours.panel))
        self._paint_disk(painter)
        worst = max([MIN_WORST, *(lamp.error for lamp in self.lamps if lamp.error is not None)])
        for place, lamp in enumerate(self.lamps):
            colour = QColor(*self.colour(lamp, worst))
            painter.setBrush(QColor(colours.panel) if lamp.excluded else colour)
            painter.setPen(QPen(colour, 1.5))
            painter.drawEllipse(self.position(place), DOT, DOT)
            if place == self.current or place in self.selection:
                painter.setBrush(Qt.BrushStyle.NoBrush)
                painter.setPen(QPen(QColor(colours.text if place == self.current else colours.accent), 1.5))
                painter.drawEllipse(self.position(place), DOT + 2.5, DOT + 2.5)
        if len(self._lasso) > 1:
            painter.setPen(QPen(QColor(colours.accent), 1.5, Qt.PenStyle.DashLine))
            painter.setBrush(Qt.BrushStyle.NoBrush)
            painter.drawPolygon(QPolygonF(self._lasso))

    def _paint_disk(self, painter: QPainter) -> None:
        colours, middle, radius = theme.current(), self._middle, self._radius
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.setPen(QPen(QColor(colours.disabled), 1.0))
        for elevation_deg in (0.0, 30.0, 60.0):
            ring = radius * math.cos(math.radians(elevation_deg))
            painter.drawEllipse(middle, ring, ring)
        painter.drawLine(middle - QPointF(radius, 0.0), middle + QPointF(radius, 0.0))
        painter.drawLine(middle - QPointF(0.0, radius), middle + QPointF(0.0, radius))
        painter.setFont(theme.font(11))
        painter.setPen(QColor(colours.secondary))
        painter.drawText(middle + QPointF(radius + 3.0, 4.0), "0°")
        painter.drawText(middle + QPointF(-10.0, -radius - 3.0), "90°")


def dot_colour(share: float) -> tuple[int, int, int]:
    """Red, green and blue at a share 0 … 1 of the largest error: a mix of blue and yellow, and of yellow and red."""
    stops = [QColor(theme.LINES[place]) for place in (0, 1, 4)]
    red, green, blue = (
        round(float(np.interp(2.0 * share, (0.0, 1.0, 2.0), channel)))
        for channel in zip(*((stop.red(), stop.green(), stop.blue()) for stop in stops), strict=True)
    )
    return red, green, blue


class LightDome(QWidget):
    """The disk, the range of azimuth and elevation that picks lamps, and what can be done with those that are picked.

    `chosen` is one lamp to look at, `picked` the lamps that are selected, `used` those that alone shall remain;
    `save_wanted` asks for a file of all.
    """

    chosen = Signal(int)
    picked = Signal(list)
    used = Signal(list)
    save_wanted = Signal()

    def __init__(self) -> None:
        super().__init__()
        role(self, "panel")
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self.image = DomeImage()
        self.image.chosen.connect(self.chosen)
        self.image.picked.connect(self.picked)
        self.azimuth = NumberField(0.0, 0.0, 360.0, unit="°")
        self.tolerance = NumberField(10.0, 0.0, 180.0, unit="°")
        self.lowest = NumberField(0.0, 0.0, 90.0, unit="°")
        self.highest = NumberField(90.0, 0.0, 90.0, unit="°")
        names = ("Azimuth", "Tolerance of the azimuth", "Lowest elevation", "Highest elevation")
        for field, name in zip((self.azimuth, self.tolerance, self.lowest, self.highest), names, strict=True):
            field.setAccessibleName(name)
            field.setToolTip(name)
            field.setFixedWidth(58)
            field.edited.connect(lambda _value, _final: self._pick_range())
        self.only = button("Use only these")
        self.every = button("Use all")
        self.only.clicked.connect(lambda: self.used.emit(sorted(self.image.selection)))
        self.every.clicked.connect(lambda: self.used.emit(list(range(len(self.image.lamps)))))
        self.save = button("Save the lights…", hint="For later captures under the same lamps")
        self.save.clicked.connect(self.save_wanted)
        self.count = text("", "secondary")
        self._lay_out()

    def _lay_out(self) -> None:
        grid = QGridLayout()
        grid.setHorizontalSpacing(STEP)
        grid.setVerticalSpacing(STEP)
        rows = (("Azimuth", self.azimuth, "±", self.tolerance), ("Elevation", self.lowest, "to", self.highest))
        for row, (label, first, between, second) in enumerate(rows):
            for column, part in enumerate((text(label, "secondary"), first, text(between, "secondary"), second)):
                grid.addWidget(part, row, column)
        beside = QVBoxLayout()
        beside.setSpacing(STEP)
        beside.addWidget(text("Lamps", "title"))
        beside.addLayout(grid)
        beside.addWidget(self.count)
        beside.addWidget(self.only)
        beside.addWidget(self.every)
        beside.addWidget(self.save)
        beside.addStretch(1)
        outer = QHBoxLayout(self)
        outer.setContentsMargins(PADDING, PADDING, PADDING, PADDING)
        outer.addWidget(self.image, 1)
        outer.addLayout(beside)

    def show_lamps(self, lamps: Sequence[Lamp], current: int | None, selection: Sequence[int] = ()) -> None:
        """Show the lamps and mark that of the photograph on screen and those selected; hidden without lamps."""
        self.image.lamps, self.image.current = tuple(lamps), current
        self.setVisible(bool(lamps))
        self.show_selection(selection)

    def show_selection(self, selection: Sequence[int]) -> None:
        """Mark the lamps that are selected."""
        lamps = self.image.lamps
        self.image.selection = frozenset(place for place in selection if place < len(lamps))
        number = len(self.image.selection)
        self.count.setText(f"{number} of {len(lamps)} selected")
        used = frozenset(place for place, lamp in enumerate(lamps) if not lamp.excluded)
        few = "Select two lamps or more: click, or draw a line round them"
        same = "These are the ones in use"
        enable(
            self.only,
            few if number < 2 else same if self.image.selection == used else "",
            "Leave all other photographs out of the material",
        )
        enable(self.every, "All are in use" if len(used) == len(lamps) else "", "Leave no photograph out")
        self.image.update()

    def _pick_range(self) -> None:
        ranges = (self.azimuth.value, self.tolerance.value, (self.lowest.value, self.highest.value))
        self.picked.emit([place for place, lamp in enumerate(self.image.lamps) if lamp.is_within(*ranges)])

    def apply_theme(self) -> None:
        """Redraw what does not follow the palette by itself."""
        self.image.update()
