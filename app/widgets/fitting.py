"""A line of text that says as much as there is room for."""

from __future__ import annotations

import re

from PySide6.QtCore import QSize, Qt
from PySide6.QtGui import QPainter, QPaintEvent, QResizeEvent
from PySide6.QtWidgets import QLabel, QSizePolicy

from app.widgets.theme import role


def breakable(words: str) -> str:
    """`words` with places in long ones, such as names of files, where a line may break."""
    return re.sub(r"[^\s/_.-]{16}|[/_.-]{1,3}(?=\S)", lambda part: f"{part[0]}\u200b", words)


class Fitting(QLabel):
    """A quiet line that says as much as there is room for: the first of its forms that fits, or nothing."""

    def __init__(self) -> None:
        super().__init__()
        role(self, "secondary")
        self.forms: tuple[str, ...] = ()
        self.setTextFormat(Qt.TextFormat.PlainText)
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)
        self.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)

    def say(self, *forms: str) -> None:
        """Show one of `forms`, the longest first; all of it is said where the mouse rests."""
        self.forms = forms
        self.setToolTip(forms[0] if forms else "")
        self._fit()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._fit()

    def _fit(self) -> None:
        metrics, room = self.fontMetrics(), self.width() - 2
        chosen = next((form for form in self.forms if metrics.horizontalAdvance(form) <= room), "")
        if chosen != self.text():
            self.setText(chosen)


class Elided(QLabel):
    """A line whose end is cut with an ellipsis where it has no room; all of it is said where the mouse rests."""

    def __init__(self) -> None:
        super().__init__()
        self.setTextFormat(Qt.TextFormat.PlainText)
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)

    def minimumSizeHint(self) -> QSize:
        return QSize(0, super().minimumSizeHint().height())

    def paintEvent(self, _event: QPaintEvent) -> None:
        shown = self.fontMetrics().elidedText(self.text(), Qt.TextElideMode.ElideRight, self.width())
        self.setToolTip(self.text() if shown != self.text() else "")
        painter = QPainter(self)
        alignment = Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter
        self.style().drawItemText(
            painter, self.rect(), alignment, self.palette(), self.isEnabled(), shown, self.foregroundRole()
        )
