"""The textures of factors as pictures, made off the window's thread and shown term by term.

Texels that hold no direction are hatched. What may be negative, products after the first, is blue below 0 and orange
above; what cannot be is its colour. The white of each picture is written under it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QRect, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QBrush, QColor, QImage, QKeyEvent, QMouseEvent, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QScrollArea, QSizePolicy, QWidget

from app import theme
from app.number_field import plain
from app.projection_names import projection_name
from app.theme import PADDING, STEP, role
from engine.colour import luminance, srgb_encode
from engine.render.display import diverging
from engine.steps import Step, Steps

GAP, CAPTION = 2 * STEP, 17
SMALLEST = 72


@dataclass(frozen=True, eq=False)
class TexturePicture:
    """One texture: its term from 1, what it is of, the picture with transparent masked texels, and what white is."""

    term: int
    name: str
    image: QImage
    white: str


def texture_pictures(factors: Any, exposure_ev: float) -> Steps[list[TexturePicture]]:
    """The pictures of all textures of `factors`, brighter by so many stops."""
    yield Step(0.0, "drawing textures")
    from engine.factor.separable_factors import SeparableFactors

    if isinstance(factors, SeparableFactors):
        sides = ("view", "light") if factors.parametrisation == "in-out" else ("half vector", "difference")
        mask = factors.chart.mask
        if factors.chart.kind == "polar":
            mask = np.ones(factors.chart.shape, bool)
        made = []
        for term in range(factors.terms):
            for name, textures in zip(sides, (factors.first, factors.second), strict=True):
                made.append(_picture(term + 1, name, textures[term], mask, exposure_ev, "sr^-½"))
            yield Step((term + 1) / factors.terms, "drawing textures")
        return made
    from engine.factor.projections import texture_mask

    found = []
    for term, (texture, projection) in enumerate(zip(factors.textures, factors.projections, strict=True)):
        mask = texture_mask(projection, factors.parametrisation, factors.reciprocal, len(texture))
        level = texture[mask].mean(axis=0) if mask.any() else 0.0
        grown = np.exp(np.clip(texture - level, -30.0, 30.0))
        name = projection_name(projection, factors.parametrisation)
        found.append(_picture(term + 1, name, grown, mask, exposure_ev, "of the mean"))
    return found


def _picture(
    term: int, name: str, texture: NDArray[Any], mask: NDArray[np.bool_], exposure_ev: float, unit: str
) -> TexturePicture:
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
    return TexturePicture(term, name, image, words)


class TexturesView(QScrollArea):
    """Pictures from left to right, as high as there is room. `picked(terms)`: a click on one, or the arrow keys."""

    picked = Signal(int)

    def __init__(self) -> None:
        super().__init__()
        role(self, "canvas")
        self.strip = _Strip(self)
        self.setWidget(self.strip)
        self.setWidgetResizable(True)
        self.setFrameShape(QScrollArea.Shape.NoFrame)
        self.setVerticalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setAccessibleName("Textures of the factors")
        self.setToolTip(
            "Each texture, its term and what white is; hatched texels hold no direction. Click to use terms up to it"
        )
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setMinimumHeight(SMALLEST + CAPTION * 2 + 2 * GAP)

    def sizeHint(self) -> QSize:
        return QSize(400, 150)

    def show_pictures(self, pictures: Sequence[TexturePicture], terms: int | None) -> None:
        """Show `pictures`, with those of the first `terms` terms in use."""
        self.strip.pictures, self.strip.terms = list(pictures), terms
        self.strip.updateGeometry()
        self.strip.fit()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        step = {Qt.Key.Key_Left: -1, Qt.Key.Key_Right: 1}.get(Qt.Key(event.key()))
        most = max((picture.term for picture in self.strip.pictures), default=0)
        if step is None or not most:
            super().keyPressEvent(event)
            return
        now = self.strip.terms or most
        if 1 <= now + step <= most:
            self.picked.emit(now + step)

    def resizeEvent(self, event: Any) -> None:
        super().resizeEvent(event)
        self.strip.fit()


class _Strip(QWidget):
    def __init__(self, view: TexturesView) -> None:
        super().__init__()
        self.view = view
        self.pictures: list[TexturePicture] = []
        self.terms: int | None = None

    def rows(self) -> int:
        """Two rows where terms have two textures and are larger so than in one row."""
        return 2 if self._paired() and self._across() < self._high(2) else 1

    def side(self) -> int:
        """Pixels along a side of each picture: what there is room for in height, or, in one row of pairs, in width."""
        rows = self.rows()
        return min(self._high(1), self._across()) if self._paired() and rows == 1 else self._high(rows)

    def _paired(self) -> bool:
        return len(self.pictures) > 1 and self.pictures[0].term == self.pictures[1].term

    def _high(self, rows: int) -> int:
        room = self.view.viewport().height() - (rows + 1) * GAP - rows * CAPTION
        return max(SMALLEST // rows, room // rows)

    def _across(self) -> int:
        """The side with which all pictures fit beside each other."""
        return (self.view.viewport().width() - 2 * PADDING) // max(1, len(self.pictures)) - GAP

    def columns(self) -> int:
        return -(-len(self.pictures) // self.rows())

    def fit(self) -> None:
        """Be as wide as the pictures need."""
        self.setMinimumWidth(2 * PADDING + self.columns() * (max(self.side(), SMALLEST) + GAP))
        self.update()

    def place(self, index: int) -> QRect:
        """Where picture number `index` is."""
        column, row = index // self.rows(), index % self.rows()
        side, pitch = self.side(), max(self.side(), SMALLEST) + GAP
        return QRect(PADDING + column * pitch, GAP + row * (side + CAPTION + GAP), side, side)

    def mousePressEvent(self, event: QMouseEvent) -> None:
        for index, picture in enumerate(self.pictures):
            if self.place(index).contains(event.position().toPoint()):
                self.view.picked.emit(picture.term)

    def paintEvent(self, _event: QPaintEvent) -> None:
        painter = QPainter(self)
        colours = theme.current()
        painter.fillRect(self.rect(), QColor(colours.canvas))
        painter.setFont(theme.font(11))
        for index, picture in enumerate(self.pictures):
            place = self.place(index)
            used = self.terms is None or picture.term <= self.terms
            painter.setOpacity(1.0 if used else 0.35)
            painter.fillRect(place, QBrush(QColor(colours.line), Qt.BrushStyle.BDiagPattern))
            painter.drawImage(QRectF(place), picture.image)
            painter.setPen(QPen(QColor(colours.line), 1))
            painter.drawRect(place.adjusted(0, 0, -1, -1))
            words = QRect(place.left(), place.bottom() + 2, max(place.width(), SMALLEST) + 4, CAPTION)
            painter.setPen(QColor(colours.text))
            metrics = painter.fontMetrics()
            name = f"{picture.term}  {picture.name}"
            room = words.width()
            both = metrics.horizontalAdvance(name) + metrics.horizontalAdvance(picture.white) + 10 <= room
            painter.drawText(
                words, Qt.AlignmentFlag.AlignLeft, metrics.elidedText(name, Qt.TextElideMode.ElideRight, room)
            )
            if both:
                painter.setPen(QColor(colours.secondary))
                painter.drawText(words.adjusted(0, 0, -4, 0), Qt.AlignmentFlag.AlignRight, picture.white)
        painter.setOpacity(1.0)
