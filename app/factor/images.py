"""The textures of factors as images, made off the window's thread and shown term by term.

Texels that hold no direction are hatched. What may be negative, products after the first, is blue below 0 and orange
above; what cannot be is its colour. The white of each image is written under it.

The projections of a factorisation are drawn as a diagram: the directions along the two axes of each texture.

Each texture has two disks, the parabolic coordinates of the two directions from above. An arrow is a row of the 2 × 4
matrix: its left half in one disk, its right half in the other; a texture coordinate grows along it. The two axes have
two colours and two heads. What is not linear is drawn for what it is.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import hypot, radians, sin, sqrt, tan
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QPointF, QRect, QRectF, QSize, Qt, Signal
from PySide6.QtGui import (
    QBrush,
    QColor,
    QImage,
    QKeyEvent,
    QMouseEvent,
    QPainter,
    QPaintEvent,
    QPen,
    QPolygonF,
    QResizeEvent,
)
from PySide6.QtWidgets import QSizePolicy, QWidget

from app.widgets import theme
from app.widgets.labels import DISKS, projection_name, shares
from app.widgets.number_field import plain
from app.widgets.panels import Scrolled
from app.widgets.theme import PADDING, STEP, role
from engine.core.colour import luminance, srgb_encode
from engine.core.figure_text import percent
from engine.core.steps import Step, Steps
from engine.factor.projections import LinearProjection, Projection, texture_mask
from engine.factor.separable_factors import SeparableFactors
from engine.render.display import diverging

if TYPE_CHECKING:
    from engine.factor.errors import Factors

GAP, CAPTION = 2 * STEP, 17
SMALLEST = 72


@dataclass(frozen=True, eq=False)
class TextureImage:
    """One texture: its term from 1, its label, the image with transparent masked texels, and the value of white."""

    term: int
    name: str
    image: QImage
    white: str


def texture_images(factors: Factors, exposure_ev: float) -> Steps[list[TextureImage]]:
    """The images of all textures of `factors`, brighter by so many stops."""
    yield Step(0.0, "drawing textures")

    if isinstance(factors, SeparableFactors):
        sides = ("view", "light") if factors.parametrisation == "in-out" else ("half vector", "difference")
        mask = factors.hemisphere_map.mask
        if factors.hemisphere_map.kind == "polar":
            mask = np.ones(factors.hemisphere_map.shape, bool)
        made = []
        for term in range(factors.terms):
            for name, textures in zip(sides, (factors.first, factors.second), strict=True):
                made.append(_image(term + 1, name, textures[term], mask, exposure_ev, "sr^-½"))
            yield Step((term + 1) / factors.terms, "drawing textures")
        return made

    found = []
    for term, (texture, projection) in enumerate(zip(factors.textures, factors.projections, strict=True)):
        mask = texture_mask(projection, factors.parametrisation, factors.reciprocal, len(texture))
        level = texture[mask].mean(axis=0) if mask.any() else 0.0
        grown = np.exp(np.clip(texture - level, -30.0, 30.0))
        name = projection_name(projection, factors.parametrisation)
        found.append(_image(term + 1, name, grown, mask, exposure_ev, "of the mean"))
    return found


def _image(
    term: int, name: str, texture: NDArray[Any], mask: NDArray[np.bool_], exposure_ev: float, unit: str
) -> TextureImage:
    values = np.asarray(texture, np.float64)[::-1]
    seen = mask[::-1]
    inside = values[seen]
    middle, high = np.quantile(np.abs(inside), (0.5, 0.95)) if inside.size else (0.0, 1.0)
    white = max(1.6 * float(middle), float(high), 1e-30) * 2.0**-exposure_ev
    signed = bool(inside.size) and float(inside.min()) < -1e-3 * float(np.abs(inside).max())
    if signed:
        pixels = diverging(luminance(values) / white)
    else:
        pixels = np.asarray(np.round(255.0 * srgb_encode(np.clip(values / white, 0.0, 1.0))), np.uint8)
    rows, columns = seen.shape
    coded = np.zeros((rows, columns, 4), np.uint8)
    coded[..., :3], coded[..., 3] = pixels, np.where(seen, 255, 0)
    image = QImage(coded.tobytes(), columns, rows, 4 * columns, QImage.Format.Format_RGBA8888).copy()
    said = plain(float(f"{white:.2g}"))
    words = f"×{said}" if unit == "of the mean" else f"{'±' if signed else ''}{said} sr⁻½"
    return TextureImage(term, name, image, words)


class TexturesView(Scrolled):
    """Images from left to right, as high as there is room. `picked(terms)`: a click on one, or the arrow keys."""

    picked = Signal(int)

    def __init__(self) -> None:
        super().__init__()
        role(self, "canvas")
        self.strip = _Strip(self)
        self.setWidget(self.strip)
        self.setWidgetResizable(True)
        self.setFrameShape(Scrolled.Shape.NoFrame)
        self.setVerticalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setAccessibleName("Textures of the factors")
        self.setToolTip(
            "Each texture, its term and the value of white; hatched texels hold no direction. Click: use terms up to it"
        )
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setMinimumHeight(SMALLEST + CAPTION * 2 + 2 * GAP)

    def sizeHint(self) -> QSize:
        return QSize(400, 150)

    def show_images(self, images: Sequence[TextureImage], terms: int | None) -> None:
        """Show `images`, with those of the first `terms` terms in use."""
        self.strip.images, self.strip.terms = list(images), terms
        self.strip.updateGeometry()
        self.strip.fit()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        step = {Qt.Key.Key_Left: -1, Qt.Key.Key_Right: 1}.get(Qt.Key(event.key()))
        most = max((image.term for image in self.strip.images), default=0)
        if step is None or not most:
            super().keyPressEvent(event)
            return
        now = self.strip.terms or most
        if 1 <= now + step <= most:
            self.picked.emit(now + step)

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self.strip.fit()


class _Strip(QWidget):
    def __init__(self, view: TexturesView) -> None:
        super().__init__()
        self.view = view
        self.images: list[TextureImage] = []
        self.terms: int | None = None

    def rows(self) -> int:
        """Two rows where terms have two textures and are larger so than in one row."""
        return 2 if self._find_pairs() and self._across() < self._high(2) else 1

    def side(self) -> int:
        """Pixels along a side of each image: what there is room for in height, or, in one row of pairs, in width."""
        rows = self.rows()
        return min(self._high(1), self._across()) if self._find_pairs() and rows == 1 else self._high(rows)

    def _find_pairs(self) -> bool:
        return len(self.images) > 1 and self.images[0].term == self.images[1].term

    def _high(self, rows: int) -> int:
        room = self.view.viewport().height() - (rows + 1) * GAP - rows * CAPTION
        return max(SMALLEST // rows, room // rows)

    def _across(self) -> int:
        """The side with which all images fit beside each other."""
        return (self.view.viewport().width() - 2 * PADDING) // max(1, len(self.images)) - GAP

    def columns(self) -> int:
        return -(-len(self.images) // self.rows())

    def fit(self) -> None:
        """Be as wide as the images need."""
        self.setMinimumWidth(2 * PADDING + self.columns() * (max(self.side(), SMALLEST) + GAP))
        self.update()

    def place(self, index: int) -> QRect:
        """The rectangle of image number `index`."""
        column, row = index // self.rows(), index % self.rows()
        side, pitch = self.side(), max(self.side(), SMALLEST) + GAP
        return QRect(PADDING + column * pitch, GAP + row * (side + CAPTION + GAP), side, side)

    def mousePressEvent(self, event: QMouseEvent) -> None:
        for index, image in enumerate(self.images):
            if self.place(index).contains(event.position().toPoint()):
                self.view.picked.emit(image.term)

    def paintEvent(self, _event: QPaintEvent) -> None:
        painter = QPainter(self)
        colours = theme.current()
        painter.fillRect(self.rect(), QColor(colours.canvas))
        painter.setFont(theme.font(11))
        for index, image in enumerate(self.images):
            place = self.place(index)
            used = self.terms is None or image.term <= self.terms
            painter.setOpacity(1.0 if used else 0.35)
            painter.fillRect(place, QBrush(QColor(colours.line), Qt.BrushStyle.BDiagPattern))
            painter.drawImage(QRectF(place), image.image)
            painter.setPen(QPen(QColor(colours.line), 1))
            painter.drawRect(place.adjusted(0, 0, -1, -1))
            words = QRect(place.left(), place.bottom() + 2, max(place.width(), SMALLEST) + 4, CAPTION)
            painter.setPen(QColor(colours.text))
            metrics = painter.fontMetrics()
            name = f"{image.term}  {image.name}"
            room = words.width()
            both = metrics.horizontalAdvance(name) + metrics.horizontalAdvance(image.white) + 10 <= room
            painter.drawText(
                words, Qt.AlignmentFlag.AlignLeft, metrics.elidedText(name, Qt.TextElideMode.ElideRight, room)
            )
            if both:
                painter.setPen(QColor(colours.secondary))
                painter.drawText(words.adjusted(0, 0, -4, 0), Qt.AlignmentFlag.AlignRight, image.white)
        painter.setOpacity(1.0)


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


class ProjectionsView(Scrolled):
    """Shows the projections of homomorphic factors, or the two maps of separable ones."""

    def __init__(self) -> None:
        super().__init__()
        role(self, "canvas")
        self.inside = _Diagram()
        self.setWidget(self.inside)
        self.setWidgetResizable(True)
        self.setFrameShape(Scrolled.Shape.NoFrame)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setAccessibleName("Projections of the textures")
        self.setToolTip(
            "Blue and orange are the two coordinates of a texture: each grows along its arrow in the disks of both "
            "directions, seen from above"
        )

    def sizeHint(self) -> QSize:
        return QSize(240, 180)

    def show_factors(self, factors: Factors | None) -> None:
        """Show what leads to the textures of `factors`; None shows nothing."""
        self.inside.factors = factors
        self.inside.rows = rows_of(factors)
        self.inside.setMinimumHeight(2 * STEP + ROW_PX * max(1, len(self.inside.rows)))
        self.setAccessibleDescription("; ".join(words for _, words, _ in self.inside.rows))
        self.inside.update()


def rows_of(factors: Factors | None) -> list[tuple[Projection | str, str, str]]:
    """For each texture, or side of separable ones: the projection or the side, its name, and a remark."""
    if factors is None:
        return []
    if isinstance(factors, SeparableFactors):
        sides = ("view", "light") if factors.parametrisation == "in-out" else ("half vector", "difference")
        return [
            (side, f"{side[:1].upper()}{side[1:]} maps", f"{factors.hemisphere_map.kind}, {factors.terms} of them")
            for side in sides
        ]
    found: list[tuple[Projection | str, str, str]] = []
    for number, projection in enumerate(factors.projections, start=1):
        name = projection_name(projection, factors.parametrisation)
        remark = "fixed"
        if isinstance(projection, LinearProjection):
            parts = zip(shares(projection), DISKS[factors.parametrisation], strict=True)
            remark = ", ".join(f"{percent(share)} {disk}" for share, disk in parts)
        found.append((projection, f"{number}  {name[:1].upper()}{name[1:]}", remark))
    return found


def _has_two_disks(what: Projection | str) -> bool:
    return not isinstance(what, str) and (
        isinstance(what, LinearProjection) or bool(ANGLES.get(what.angles or what.name))
    )


class _Diagram(QWidget):
    def __init__(self) -> None:
        super().__init__()
        self.factors: Factors | None = None
        self.rows: Sequence[tuple[Projection | str, str, str]] = ()

    def paintEvent(self, _event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        colours = theme.current()
        painter.fillRect(self.rect(), QColor(colours.canvas))
        for index, (what, name, remark) in enumerate(self.rows):
            middle = STEP + ROW_PX * (index + 0.5)
            left = QPointF(PADDING + RADIUS, middle)
            right = left + QPointF(2 * RADIUS + 3 * STEP, 0.0)
            painter.setFont(theme.font(12))
            needed = right.x() + RADIUS + 4 * STEP + painter.fontMetrics().horizontalAdvance(name)
            if needed > self.width() and not _has_two_disks(what):
                right = left  # one disk needs no room for two
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

    def _draw(self, painter: QPainter, what: Projection | str, left: QPointF, right: QPointF) -> None:
        """The two disks of one projection, or the one of a fixed one or of a side."""
        if isinstance(what, str):
            self._disk(painter, (left + right) / 2, _letter(what))
            assert isinstance(self.factors, SeparableFactors)
            self._rings(painter, (left + right) / 2, self.factors.hemisphere_map.kind)
            return
        if isinstance(what, LinearProjection):
            assert self.factors is not None
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
    """An arrow from `start`; the second axis has a hollow head, so that more than its colour distinguishes it."""
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
