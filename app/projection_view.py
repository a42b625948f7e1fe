"""The projections of a factorisation as a diagram: which directions the two axes of each texture look along.

Each texture has two disks, the parabolic coordinates of the two directions from above. An arrow is a row of the 2 × 4
matrix: its left half in one disk, its right half in the other; a texture coordinate grows along it. The two axes have
two colours and two heads. What is not linear is drawn for what it is.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import hypot, radians, sin, sqrt, tan
from typing import Any

from PySide6.QtCore import QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QPainter, QPaintEvent, QPen, QPolygonF
from PySide6.QtWidgets import QScrollArea, QSizePolicy, QWidget

from app import theme
from app.projection_names import DISKS, projection_name, shares
from app.theme import PADDING, STEP, role

ROW_PX, RADIUS = 62, 23
AXES = (theme.LINES[0], theme.LINES[1])

#: Fixed projections whose two coordinates are two angles from the normal, which grow from the middle of a disk.
ANGLES = {
    "wi-dot-h": ("θh", "θd"),
    "elevations": ("θi", "θo"),
    "elevations-exchanged": ("θo", "θi"),
    "half-mean": ("θh", "θm"),
    "wi-dot-h-mean": ("θd", "θm"),
}

#: An arrow shorter than this share of the disk is not drawn.
SHORT = 0.06


class ProjectionsView(QScrollArea):
    """Shows the projections of homomorphic factors, or the two maps of separable ones."""

    def __init__(self) -> None:
        super().__init__()
        role(self, "canvas")
        self.inside = _Diagram()
        self.setWidget(self.inside)
        self.setWidgetResizable(True)
        self.setFrameShape(QScrollArea.Shape.NoFrame)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setAccessibleName("Projections of the textures")
        self.setToolTip(
            "Blue and orange are the two coordinates of a texture: each grows along its arrow in the disks of both "
            "directions, seen from above"
        )

    def sizeHint(self) -> QSize:
        return QSize(240, 180)

    def show_factors(self, factors: Any) -> None:
        """Show what leads to the textures of `factors`; None shows nothing."""
        self.inside.factors = factors
        self.inside.rows = rows_of(factors)
        self.inside.setMinimumHeight(2 * STEP + ROW_PX * max(1, len(self.inside.rows)))
        self.setAccessibleDescription("; ".join(words for _, words, _ in self.inside.rows))
        self.inside.update()


def rows_of(factors: Any) -> list[tuple[Any, str, str]]:
    """For each texture, or side of separable ones: the projection or the side, what it is called, and a remark."""
    if factors is None:
        return []
    if hasattr(factors, "chart"):
        sides = ("view", "light") if factors.parametrisation == "in-out" else ("half vector", "difference")
        return [
            (side, f"{side[:1].upper()}{side[1:]} maps", f"{factors.chart.kind}, {factors.terms} of them")
            for side in sides
        ]
    found = []
    for number, projection in enumerate(factors.projections, start=1):
        name = projection_name(projection, factors.parametrisation)
        remark = "fixed"
        if projection.name == "linear":
            parts = zip(shares(projection), DISKS[factors.parametrisation], strict=True)
            remark = ", ".join(f"{100 * share:.0f} % {disk}" for share, disk in parts)
        found.append((projection, f"{number}  {name[:1].upper()}{name[1:]}", remark))
    return found


class _Diagram(QWidget):
    def __init__(self) -> None:
        super().__init__()
        self.factors: Any = None
        self.rows: Sequence[tuple[Any, str, str]] = ()

    def paintEvent(self, _event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        colours = theme.current()
        painter.fillRect(self.rect(), QColor(colours.canvas))
        for index, (what, name, remark) in enumerate(self.rows):
            middle = STEP + ROW_PX * (index + 0.5)
            left = QPointF(PADDING + RADIUS, middle)
            right = left + QPointF(2 * RADIUS + 3 * STEP, 0.0)
            self._draw(painter, what, left, right)
            x = right.x() + RADIUS + 3 * STEP
            words = QRectF(x, middle - 18, max(0.0, self.width() - x - STEP), 18)
            painter.setFont(theme.font(12))
            painter.setPen(QColor(colours.text))
            elide = Qt.TextElideMode.ElideRight
            painter.drawText(words, painter.fontMetrics().elidedText(name, elide, int(words.width())))
            painter.setFont(theme.font(11))
            painter.setPen(QColor(colours.secondary))
            painter.drawText(
                words.translated(0, 18), painter.fontMetrics().elidedText(remark, elide, int(words.width()))
            )

    def _draw(self, painter: QPainter, what: Any, left: QPointF, right: QPointF) -> None:
        """The two disks of one projection, or the one of a fixed one or of a side."""
        if isinstance(what, str):
            self._disk(painter, (left + right) / 2, _letter(what))
            self._rings(painter, (left + right) / 2, self.factors.chart.kind)
            return
        if what.name == "linear":
            letters = ("i", "o") if self.factors.parametrisation == "in-out" else ("h", "d")
            for half, (middle, letter) in enumerate(zip((left, right), letters, strict=True)):
                self._disk(painter, middle, letter)
                for axis, colour in enumerate(AXES):
                    x, y = (float(part) for part in what.rows[axis, 2 * half : 2 * half + 2])
                    _arrow(painter, middle, QPointF(x, -y) * RADIUS, colour, hollow=bool(axis))
            return
        angles = ANGLES.get(what.angles or what.name)
        if angles:
            for middle, letter in zip((left, right), angles, strict=True):
                self._disk(painter, middle, letter)
            _arrow(painter, left, QPointF(0.9 * RADIUS, 0.0), AXES[0], hollow=False)
            _arrow(painter, right, QPointF(0.9 * RADIUS, 0.0), AXES[1], hollow=True)
            return
        middle = {"wi": left, "wo": right}.get(what.name, (left + right) / 2)
        self._disk(painter, middle, {"wi": "i", "wo": "o", "half": "h"}[what.name])
        _arrow(painter, middle, QPointF(0.9 * RADIUS, 0.0), AXES[0], hollow=False)
        _arrow(painter, middle, QPointF(0.0, -0.9 * RADIUS), AXES[1], hollow=True)

    def _disk(self, painter: QPainter, middle: QPointF, letter: str) -> None:
        colours = theme.current()
        painter.setPen(QPen(QColor(colours.secondary), 1))
        painter.setBrush(QColor(colours.panel))
        painter.drawEllipse(middle, RADIUS, RADIUS)
        painter.setBrush(QColor(colours.secondary))
        painter.setPen(Qt.PenStyle.NoPen)
        painter.drawEllipse(middle, 1.5, 1.5)
        painter.setPen(QColor(colours.secondary))
        painter.setFont(theme.font(10))
        painter.drawText(QPointF(middle.x() - RADIUS, middle.y() - RADIUS + 6), letter)

    def _rings(self, painter: QPainter, middle: QPointF, kind: str) -> None:
        """Angles of 30 and 60 degrees where the map has them."""
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.setPen(QPen(QColor(theme.current().line), 1))
        for angle in (radians(30.0), radians(60.0)):
            share = {"orthographic": sin(angle), "polar": sqrt(2.0) * sin(angle / 2), "parabolic": tan(angle / 2)}[kind]
            painter.drawEllipse(middle, share * RADIUS, share * RADIUS)


def _letter(side: str) -> str:
    return {"view": "o", "light": "i", "half vector": "h", "difference": "d"}[side]


def _arrow(painter: QPainter, start: QPointF, along: QPointF, colour: str, *, hollow: bool) -> None:
    """An arrow from `start`; the second axis has a hollow head, so that not only its colour tells it apart."""
    length = hypot(along.x(), along.y())
    if length < SHORT * RADIUS:
        return
    unit = along / length
    side = QPointF(-unit.y(), unit.x())
    head = min(6.0, 0.6 * length)
    tip = start + along
    painter.setPen(QPen(QColor(colour), 1.8))
    painter.drawLine(start, tip - unit * head)
    painter.setBrush(Qt.BrushStyle.NoBrush if hollow else QColor(colour))
    painter.setPen(QPen(QColor(colour), 1.3))
    painter.drawPolygon(QPolygonF([tip, tip - unit * head + side * 0.5 * head, tip - unit * head - side * 0.5 * head]))
