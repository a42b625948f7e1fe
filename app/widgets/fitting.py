"""A line of text that says as much as there is room for."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QLabel, QSizePolicy

from app.widgets.theme import role


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
