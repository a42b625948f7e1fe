"""Icons are drawn at whatever size a layout leaves for them."""

from __future__ import annotations

from PySide6.QtCore import QRect, QSize, qInstallMessageHandler
from PySide6.QtGui import QColor, QImage, QPainter

from app.widgets import theme


def test_an_icon_without_a_place_is_not_drawn(qapp: object) -> None:
    """Qt warned, some times, of drawing into an image of no pixels."""
    said: list[str] = []
    before = qInstallMessageHandler(lambda _kind, _context, words: said.append(words))
    image = QImage(20, 20, QImage.Format.Format_ARGB32_Premultiplied)
    image.fill(QColor(0, 0, 0, 0))
    painter = QPainter(image)
    for place in (QRect(3, 3, 0, 16), QRect(3, 3, -2, 16), QRect(3, 3, 16, 0)):
        theme.icon("fit").paint(painter, place)
    assert theme.icon("fit").pixmap(QSize(0, 5)).isNull()
    blank = image.copy()
    theme.icon("fit").paint(painter, QRect(2, 2, 16, 16))
    painter.end()
    qInstallMessageHandler(before)
    assert image != blank
    assert not said
