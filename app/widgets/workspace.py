"""The layout of a workspace: panels beside an image, and over it a bar with the choices of what it shows."""

from __future__ import annotations

from PySide6.QtCore import QSize, Qt
from PySide6.QtWidgets import QHBoxLayout, QLayout, QVBoxLayout, QWidget

from app.widgets.theme import PADDING, STEP, role

HEIGHT = 36


def side_by_side(*parts: QWidget, stretch: int = 0) -> QWidget:
    """Panels and image beside each other with a thin line between them; part number `stretch` takes the room."""
    holder = role(QWidget(), "gap")
    holder.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
    row = QHBoxLayout(holder)
    row.setContentsMargins(0, 0, 0, 0)
    row.setSpacing(1)
    for place, part in enumerate(parts):
        put_beside(holder, part, takes_room=place == stretch)
    return holder


def put_beside(holder: QWidget, part: QWidget, *, takes_room: bool = False) -> None:
    """Put one more part at the right of those that stand `side_by_side` in `holder`."""
    row = holder.layout()
    assert isinstance(row, QHBoxLayout)
    row.addWidget(_Rest(part) if takes_room else part, int(takes_room))


def bar_of_choices(gap: int = 2 * STEP) -> tuple[QWidget, QHBoxLayout]:
    """The bar and its row, still empty; `gap` pixels between what the row gets."""
    bar = role(QWidget(), "bar")
    bar.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
    bar.setFixedHeight(HEIGHT)
    row = QHBoxLayout(bar)
    row.setContentsMargins(PADDING, 0, PADDING, 0)
    row.setSpacing(gap)
    return bar, row


def under(bar: QWidget, work: QWidget | QLayout) -> QWidget:
    """The bar with `work` below it, which takes the room that is left."""
    holder = QWidget()
    column = QVBoxLayout(holder)
    column.setContentsMargins(0, 0, 0, 0)
    column.setSpacing(0)
    column.addWidget(bar)
    if isinstance(work, QWidget):
        column.addWidget(work, 1)
    else:
        column.addLayout(work, 1)
    return holder


def beside(image: QWidget, colour_bar: QWidget) -> QLayout:
    """An image with the bar of its false colours at its right."""
    row = QHBoxLayout()
    row.setSpacing(0)
    row.addWidget(image, 1)
    row.addWidget(colour_bar)
    return row


class _Rest(QWidget):
    """An image between panels: it wishes for no more width than it needs at least, and takes what they leave."""

    def __init__(self, image: QWidget) -> None:
        super().__init__()
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.addWidget(image)

    def sizeHint(self) -> QSize:
        return QSize(self.minimumSizeHint().width(), super().sizeHint().height())
