"""Line icons drawn for the program: `resources/icons/NAME.svg` in the colour that the theme asks for."""

from __future__ import annotations

from functools import cache

from PySide6.QtCore import QByteArray, QRectF, Qt
from PySide6.QtGui import QIcon, QPainter, QPixmap
from PySide6.QtSvg import QSvgRenderer

from app import theme

SMALL, MEDIUM, LARGE = 16, 20, 24


def icon(name: str, colour: str | None = None) -> QIcon:
    """The icon `name` at all three sizes, in `colour` (the theme's text by default) and greyed where disabled."""
    return _icon(name, colour or theme.current().text, theme.current().disabled)


def pixmap(name: str, size: int, colour: str | None = None, scale: float = 1.0) -> QPixmap:
    """The icon `name` as a picture of `size` device-independent pixels on a screen of `scale`."""
    picture = QPixmap(_pixmap(name, round(size * scale), colour or theme.current().text))
    picture.setDevicePixelRatio(scale)
    return picture


@cache
def _icon(name: str, colour: str, disabled: str) -> QIcon:
    drawn = QIcon()
    for size in (SMALL, MEDIUM, LARGE, 2 * SMALL, 2 * MEDIUM, 2 * LARGE):
        drawn.addPixmap(_pixmap(name, size, colour), QIcon.Mode.Normal)
        drawn.addPixmap(_pixmap(name, size, disabled), QIcon.Mode.Disabled)
    return drawn


@cache
def _pixmap(name: str, size: int, colour: str) -> QPixmap:
    drawing = (theme.RESOURCES / "icons" / f"{name}.svg").read_text(encoding="utf-8").replace("currentColor", colour)
    renderer = QSvgRenderer(QByteArray(drawing.encode()))
    picture = QPixmap(size, size)
    picture.fill(Qt.GlobalColor.transparent)
    painter = QPainter(picture)
    renderer.render(painter, QRectF(0, 0, size, size))
    painter.end()
    return picture
