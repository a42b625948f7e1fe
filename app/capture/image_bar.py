"""The line above the big image: its buttons, before or after the import, the texel under the pointer."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QHBoxLayout, QWidget

from app.widgets.panels import Segments, text, tool
from app.widgets.theme import PADDING, STEP, role

HEIGHT = 36


class ImageBar(QWidget):
    """Buttons for `actions`, the choice `when` ('before' or 'after'), and two read-outs."""

    def __init__(self, actions: Sequence[QAction]) -> None:
        super().__init__()
        role(self, "bar")
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self.setFixedHeight(HEIGHT)
        row = QHBoxLayout(self)
        row.setContentsMargins(PADDING - 4, 0, PADDING, 0)
        row.setSpacing(STEP)
        for action in actions:
            row.addWidget(tool(action))
        self.when = Segments(
            (
                ("before", "Before", "The photograph as it was taken, with handles to frame it"),
                ("after", "After", "Calibrated, aligned and framed"),
            )
        )
        self.when.choose("after")
        row.addSpacing(2 * STEP)
        row.addWidget(self.when)
        row.addStretch(1)
        self.readout = text("", "secondary")
        self.zoom = text("", "secondary")
        self.zoom.setMinimumWidth(48)
        self.zoom.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
        row.addWidget(self.readout)
        row.addSpacing(2 * STEP)
        row.addWidget(self.zoom)
