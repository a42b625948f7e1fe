"""The page of a workspace that has nothing to show yet: what to do, and the buttons that do it."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import Qt, SignalInstance
from PySide6.QtWidgets import QHBoxLayout, QLabel, QStackedWidget, QVBoxLayout, QWidget

from app.widgets import theme
from app.widgets import theme as icons
from app.widgets.panels import button, text
from app.widgets.theme import STEP, role


class EmptyState(QWidget):
    """The hint of an empty view, and the buttons that follow it: (label, icon, signal), the best one first."""

    def __init__(
        self, icon_name: str, heading: str, words: str, offers: Sequence[tuple[str, str, SignalInstance]]
    ) -> None:
        super().__init__()
        role(self, "canvas")
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self.icon_name = icon_name
        self.image = QLabel()
        self.image.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self.words = text(words, "secondary", wrap=True)
        self.words.setAlignment(Qt.AlignmentFlag.AlignHCenter)
        self.words.setFixedWidth(400)
        self.words.setFixedHeight(self.words.heightForWidth(400) + STEP)
        title = text(heading, "heading")
        title.setAlignment(Qt.AlignmentFlag.AlignCenter)
        actions = QHBoxLayout()
        actions.setSpacing(2 * STEP)
        actions.addStretch(1)
        for place, (label, icon, wanted) in enumerate(offers):
            made = button(label, "" if place else "primary", icon)
            made.clicked.connect(wanted)
            actions.addWidget(made)
        actions.addStretch(1)
        column = QVBoxLayout(self)
        column.setSpacing(3 * STEP)
        column.addStretch(2)
        column.addWidget(self.image)
        column.addWidget(title)
        column.addWidget(self.words, 0, Qt.AlignmentFlag.AlignHCenter)
        column.addSpacing(STEP)
        column.addLayout(actions)
        column.addStretch(3)
        self.apply_theme()

    def apply_theme(self) -> None:
        """Draw the icon in the colour of the current theme."""
        self.image.setPixmap(icons.pixmap(self.icon_name, 48, theme.current().disabled, self.devicePixelRatioF()))


def with_empty_state(tab: QWidget, empty: EmptyState, work: QWidget) -> QStackedWidget:
    """Fill `tab` with two pages: 0 is `empty`, for as long as there is nothing to do `work` (1) on."""
    pages = QStackedWidget()
    pages.addWidget(empty)
    pages.addWidget(work)
    column = QVBoxLayout(tab)
    column.setContentsMargins(0, 0, 0, 0)
    column.addWidget(pages)
    return pages
