"""The bar above everything: name of the program, menus, a button for each workspace, and the title of the project."""

from __future__ import annotations

from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtGui import QEnterEvent
from PySide6.QtWidgets import QButtonGroup, QGridLayout, QHBoxLayout, QLabel, QMenuBar, QToolButton, QWidget

from app.widgets import theme
from app.widgets.fitting import Fitting
from app.widgets.panels import text
from app.widgets.theme import PADDING, STEP, role

#: The workspaces in the order of the work, and what their buttons say.
WORKSPACES = {
    "capture": "Capture",
    "material": "Material",
    "brdf": "BRDF",
    "factor": "Factor",
    "view": "View",
    "export": "Export",
}

#: Height of the bar and of the program's mark, in pixels.
HEIGHT, MARK = 40, 20


class TopBar(QWidget):
    """`wanted`: a workspace was clicked, by its name. `entered`: the pointer has come over the bar."""

    wanted = Signal(str)
    entered = Signal()

    def __init__(self, menus: QMenuBar) -> None:
        super().__init__()
        role(self, "bar")
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self.setFixedHeight(HEIGHT)
        self.mark = QLabel()
        self.buttons = QButtonGroup(self)
        self.title = Fitting()
        grid = QGridLayout(self)
        grid.setContentsMargins(PADDING, 0, PADDING, 0)
        grid.setHorizontalSpacing(0)
        grid.addLayout(self._program(menus), 0, 0)
        grid.addLayout(self._workspaces(), 0, 1)
        grid.addWidget(self.title, 0, 2)
        grid.setColumnStretch(0, 1)
        grid.setColumnStretch(2, 1)

    def enterEvent(self, event: QEnterEvent) -> None:
        super().enterEvent(event)
        self.entered.emit()

    def show_workspace(self, name: str) -> None:
        """Mark the workspace `name` as the one in front; none for another name."""
        self.buttons.setExclusive(name in WORKSPACES)
        for place, workspace in enumerate(WORKSPACES):
            self.buttons.button(place).setChecked(workspace == name)

    def show_title(self, name: str, state: str) -> None:
        """Show the name of the project and, after it, what is not as usual; the name is cut where room is short."""
        shorter = (f"{name[:length].rstrip()}…" for length in range(len(name) - 1, 2, -1))
        names = (name, *shorter, "") if name else ("",)
        self.title.say(*(" – ".join(filter(None, [each, state])) for each in names))

    def apply_theme(self) -> None:
        """Take the colours of the theme."""
        self.mark.setPixmap(theme.pixmap("lightarc", MARK, theme.current().accent, self.devicePixelRatioF()))
        for place, name in enumerate(WORKSPACES):
            self.buttons.button(place).setIcon(theme.icon(name))

    def _program(self, menus: QMenuBar) -> QHBoxLayout:
        row = QHBoxLayout()
        row.setSpacing(2 * STEP)
        row.addWidget(self.mark)
        row.addWidget(text("Lightarc", "title"))
        row.addWidget(menus, 0, Qt.AlignmentFlag.AlignVCenter)
        row.addStretch(1)
        return row

    def _workspaces(self) -> QHBoxLayout:
        row = QHBoxLayout()
        row.setSpacing(0)
        for place, (name, words) in enumerate(WORKSPACES.items()):
            button = QToolButton()
            button.setText(words)
            button.setCheckable(True)
            button.setIconSize(QSize(theme.SMALL, theme.SMALL))
            button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
            button.setToolTip(f"{words} (Ctrl+{place + 1})")
            button.clicked.connect(lambda _checked, name=name: self.wanted.emit(name))
            role(button, "workspace")
            self.buttons.addButton(button, place)
            row.addWidget(button)
        return row
