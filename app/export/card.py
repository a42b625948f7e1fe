"""A target as a card: a check box with its name, a ball as the target shows it, and its figures beside it.

The cards of all targets lie on a board.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QRectF, QSize, Qt
from PySide6.QtGui import QAccessible, QColor, QImage, QMouseEvent, QPainter, QPaintEvent, QResizeEvent
from PySide6.QtWidgets import QCheckBox, QFrame, QGridLayout, QLabel, QVBoxLayout, QWidget

from app.widgets import theme
from app.widgets.panels import Scrolled, enable, keep_hint, text
from app.widgets.theme import PADDING, ROW, STEP, role
from engine.core.figure_text import number, percent, size_text

#: Pixels across a ball, from small to large, and what a card has beside it and above it, its margins included.
SPHERES, BESIDE, ABOVE = (96, 128, 160, 224), 200, 52

#: Pixels of the gap between cards, and of the bar that scrolls them.
GAP, BAR = 1, 14

#: Figures on a card: label, hint.
FIGURES = (
    ("Material", "Relative RMSE against the material itself under studio, noon and overcast"),
    ("FLIP", "Mean difference that a user sees, against the material itself under the same environments"),
    ("Photographs", "Relative RMSE against the photographs, each under its own lamp, seen from above"),
    ("Size", "Bytes of all files"),
    ("Bytes per point", "Bytes of the maps that shading one point reads: what its evaluation costs"),
)


class Sphere(QWidget):
    """An image with coverage, in the middle of its place."""

    accessible_role = QAccessible.Role.Graphic

    def __init__(self, name: str) -> None:
        super().__init__()
        self.setAccessibleName(name)
        self.image: QImage | None = None

    def show_codes(self, codes: NDArray[np.uint8] | None) -> None:
        """Show (H, W, 4) sRGB codes, or nothing."""
        self.image = None
        if codes is not None:
            height, width = codes.shape[:2]
            pixels = np.ascontiguousarray(codes)
            self.image = QImage(pixels.data, width, height, 4 * width, QImage.Format.Format_RGBA8888).copy()
        self.update()

    def paintEvent(self, _event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform)
        place = QRectF(self.rect()).adjusted(2, 2, -2, -2)
        if self.image is not None:
            painter.drawImage(place, self.image)
            return
        painter.setPen(QColor(theme.current().line))
        painter.drawEllipse(place)


class Card(QWidget):
    """One target; `box` is None for the material itself, which always leaves as a bundle."""

    def __init__(self, name: str, title: str, hint: str, *, is_choice: bool = True) -> None:
        super().__init__()
        role(self, "panel")
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self.name, self.title, self.hint = name, title, hint
        self.box: QCheckBox | None = QCheckBox(title) if is_choice else None
        head: QWidget = self.box or text(title, "title")
        head.setMinimumHeight(ROW - 4)
        keep_hint(head, hint)
        self.sphere = Sphere(f"{title}, on a preview sphere")
        self.figures: list[QLabel] = []
        self.labels: list[QLabel] = []
        lines = QGridLayout()
        lines.setContentsMargins(0, 0, 0, 0)
        lines.setHorizontalSpacing(2 * STEP)
        lines.setVerticalSpacing(0)
        lines.setColumnStretch(1, 1)
        for place, (label, words) in enumerate(FIGURES):
            caption, figure = text(label, "secondary"), text("–")
            figure.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
            for widget in (caption, figure):
                widget.setToolTip(words)
            lines.addWidget(caption, place, 0)
            lines.addWidget(figure, place, 1)
            self.labels.append(caption)
            self.figures.append(figure)
        self.words = text("", "secondary", wrap=True)
        self.words.setAlignment(Qt.AlignmentFlag.AlignTop | Qt.AlignmentFlag.AlignLeft)
        self.words.hide()
        beside = QVBoxLayout()
        beside.setSpacing(0)
        beside.addLayout(lines)
        beside.addWidget(self.words, 1)
        whole = QGridLayout(self)
        whole.setContentsMargins(PADDING, 2 * STEP, PADDING, 2 * STEP)
        whole.setHorizontalSpacing(PADDING)
        whole.setVerticalSpacing(2 * STEP)
        whole.addWidget(head, 0, 0, 1, 2)
        whole.addWidget(self.sphere, 1, 0, Qt.AlignmentFlag.AlignTop)
        whole.addLayout(beside, 1, 1, Qt.AlignmentFlag.AlignTop)
        whole.setColumnStretch(1, 1)
        self.enlarge(SPHERES[0])

    def enlarge(self, sphere: int) -> None:
        """Show the ball with so many pixels across, and be as large as that takes."""
        self.sphere.setFixedSize(sphere, sphere)
        self.setMinimumWidth(sphere + BESIDE)
        self.setFixedHeight(sphere + ABOVE)

    def sizeHint(self) -> QSize:
        return self.minimumSize()

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        """A click anywhere on the card is one on its box."""
        is_click = event.button() == Qt.MouseButton.LeftButton and self.rect().contains(event.position().toPoint())
        if is_click and self.box is not None and self.box.isEnabled():
            self.box.click()

    @property
    def is_chosen(self) -> bool:
        return self.box is not None and self.box.isChecked() and self.box.isEnabled()

    def forget(self) -> None:
        """Show that nothing is known yet."""
        self._say("")
        self.sphere.show_codes(None)
        for figure in self.figures:
            figure.setText("–")
        self._enable("")

    def refuse(self, why: str) -> None:
        """Show the sentence why this material cannot be written to the target."""
        self.sphere.show_codes(None)
        self._say(why)
        self._enable(why)

    def show_entry(self, entry: dict[str, Any], codes: NDArray[np.uint8] | None) -> None:
        """Show the figures of an entry of the record of an export, and the ball (H, W, 4)."""
        self._enable("")
        self.sphere.show_codes(codes)
        if codes is None:
            said = entry["warnings"] or ("It shows no image of the surface",)
            self._say(f"{said[-1]}. {size_text(entry['bytes'])}.")
            return
        self._say("")
        shown = {
            "rmse_rel_reference": lambda value: percent(value, 3),
            "flip": number,
            "rmse_rel": lambda value: percent(value, 3),
            "bytes": size_text,
            "bytes_per_texel": lambda value: f"{number(value, 3)} B",
        }
        for figure, (name, words) in zip(self.figures, shown.items(), strict=True):
            figure.setText("–" if entry[name] is None else words(entry[name]))

    def _say(self, words: str) -> None:
        """Show `words` in place of figures, or figures where there are none."""
        self.words.setText(words)
        self.words.setVisible(bool(words))
        for widget in (*self.labels, *self.figures):
            widget.setVisible(not words)

    def _enable(self, why_not: str) -> None:
        if self.box is not None:
            enable(self.box, why_not, self.hint)


class Board(Scrolled):
    """Cards in as many columns as there is room for, as large as all fit; it scrolls where the window is low."""

    def __init__(self, cards: Sequence[Card]) -> None:
        super().__init__()
        self.setAccessibleName("Targets of an export")
        self.cards = list(cards)
        self.columns = self.sphere = 0
        role(self, "canvas")
        inside = role(QWidget(), "canvas")
        self.grid = QGridLayout(inside)
        self.grid.setContentsMargins(0, 0, 0, 0)
        self.grid.setSpacing(GAP)
        self.setWidgetResizable(True)
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setWidget(inside)
        self._lay_out(2, SPHERES[0])

    def minimumSizeHint(self) -> QSize:
        return QSize(SPHERES[0] + BESIDE + 20, 160)

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        fitting = [sphere for sphere in SPHERES if self._height(sphere) <= self.height()]
        sphere = max(fitting, default=SPHERES[0])
        self._lay_out(self._columns(sphere), sphere)

    def _columns(self, sphere: int) -> int:
        return max(1, min(len(self.cards), (self.width() - BAR) // (sphere + BESIDE + GAP)))

    def _height(self, sphere: int) -> int:
        """Pixels of all rows of cards with such balls."""
        return -(-len(self.cards) // self._columns(sphere)) * (sphere + ABOVE + GAP)

    def _lay_out(self, columns: int, sphere: int) -> None:
        if sphere != self.sphere:
            self.sphere = sphere
            for card in self.cards:
                card.enlarge(sphere)
        if columns == self.columns:
            return
        for column in range(self.columns):
            self.grid.setColumnStretch(column, 0)
        self.columns = columns
        for place, card in enumerate(self.cards):
            self.grid.removeWidget(card)
            self.grid.addWidget(card, *divmod(place, columns))
        for column in range(columns):
            self.grid.setColumnStretch(column, 1)
        rows = -(-len(self.cards) // columns)
        for row in range(len(self.cards) + 1):
            self.grid.setRowStretch(row, int(row == rows))
