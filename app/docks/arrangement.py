"""The docks of the window: where they stand, how large they are, and which of them belong to the View workspace.

Effects and accuracy belong to the View workspace and stand below its image, or right of it where the window is wide
enough, unless a user has put one of them elsewhere. What else lies below shares the place of accuracy: three docks
beside each other are too narrow for their words.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from PySide6.QtCore import QByteArray, QObject, QSize, Qt, QTimer
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QMainWindow

from app.commands.workbench import Workbench
from app.docks.accuracy import AccuracyDock
from app.docks.effects import EffectsDock
from app.docks.health import HealthDock
from app.docks.jobs_and_log import DocksOf, JobsDock, LogDock
from app.view.lobe_inspector import LobeInspector
from app.view.tab import ViewTab

#: Areas of the docks. From the width `WIDE` of the window on, those of the View workspace stand right of the image.
BOTTOM, RIGHT = Qt.DockWidgetArea.BottomDockWidgetArea, Qt.DockWidgetArea.RightDockWidgetArea
WIDE = 1700

#: Across, in pixels, and the share of each of the two along the window.
DOCK_HEIGHT, DOCK_WIDTH, SHARES = 226, 400, (0.42, 0.58)


class Docks(QObject):
    """Makes and places the docks of `window`."""

    def __init__(self, window: QMainWindow, bench: Workbench, view: ViewTab) -> None:
        super().__init__(window)
        self.window = window
        self.jobs = JobsDock(bench.jobs, window)
        self.log = LogDock(window)
        self.accuracy = AccuracyDock(bench, view, window)
        self.effects = EffectsDock(bench, view, window)
        self.health = HealthDock(bench, view, window)
        self.lobes = LobeInspector(bench, view, window)
        self.of_view = DocksOf(window, (self.effects, self.accuracy))
        self.others = (self.health, self.lobes, self.jobs, self.log)
        self._is_view_in_front = False
        self._has_drawn = False
        self._sizes: list[QSize] = []
        for dock in (self.effects, self.accuracy, *self.others):
            window.addDockWidget(BOTTOM, dock)
            dock.hide()
        self._place(BOTTOM)
        for dock in self.others:
            dock.toggleViewAction().triggered.connect(lambda shown, dock=dock: dock.raise_() if shown else None)
        view.drawn.connect(lambda _seconds: self._image_drawn())

    @property
    def actions(self) -> list[QAction]:
        """The actions that show and hide each of them, in the order of the menu."""
        others = (self.lobes, self.health, self.jobs, self.log)
        return [*self.of_view.actions, *(dock.toggleViewAction() for dock in others)]

    def show_of_view(self, is_view_in_front: bool) -> None:
        """Show those of the View workspace beside it, at the earliest when its image is on screen."""
        if self._is_view_in_front and not is_view_in_front:
            self._note_sizes()
        self._is_view_in_front = is_view_in_front
        self._show_of_view()

    def show_health(self) -> None:
        """Bring the health report to the front."""
        self.health.show()
        self.health.raise_()

    def measure_modes(self) -> None:
        """Measure all modes on the scene of the View workspace."""
        self.accuracy.show()
        self.accuracy.raise_()
        self.accuracy.measure()

    def follow_width(self) -> None:
        """Place those of the View workspace anew where the window has become wide, or narrow."""
        wanted = RIGHT if self.window.width() >= WIDE else BOTTOM
        now = BOTTOM if wanted == RIGHT else RIGHT
        docks = self.of_view.docks
        if all(self.window.dockWidgetArea(dock) == now and not dock.isFloating() for dock in docks):
            self._place(wanted)

    def restore(self, layout: str, closed: Sequence[str], sizes: Sequence[int]) -> None:
        """Let them stand as they did when the program ended, which `layout` describes in Qt's words, in hexadecimal.

        `closed` are those that the user had closed, `sizes` those of the View workspace, which are hidden now.
        """
        if layout:
            self._is_sized = self.window.restoreState(QByteArray(bytes.fromhex(layout)))
            self._sizes = [QSize(*pair) for pair in zip(sizes[::2], sizes[1::2], strict=True)]
        self.of_view.close(closed)

    def apply_theme(self) -> None:
        """Take the colours of the theme."""
        for dock in (self.effects, self.accuracy, self.health, self.lobes):
            dock.apply_theme()

    def _place(self, area: Qt.DockWidgetArea) -> None:
        """Effects and accuracy beside each other below the image, or above each other right of it."""
        window, is_lying = self.window, area == BOTTOM
        for dock in self.of_view.docks:
            window.addDockWidget(area, dock)
        direction = Qt.Orientation.Horizontal if is_lying else Qt.Orientation.Vertical
        window.splitDockWidget(self.effects, self.accuracy, direction)
        others = [dock for dock in self.others if window.dockWidgetArea(dock) == BOTTOM and not dock.isFloating()]
        for before, behind in pairwise([self.accuracy, *others] if is_lying else others):
            if behind not in window.tabifiedDockWidgets(before):  # each time lays the window out anew
                window.tabifyDockWidget(before, behind)
        self._is_sized = False
        self._show_of_view()

    def _show_of_view(self) -> None:
        is_shown = self._is_view_in_front and self._has_drawn
        self.of_view.show(is_shown)
        if is_shown:
            QTimer.singleShot(0, self, self._size)

    def _image_drawn(self) -> None:
        if not self._has_drawn:
            self._has_drawn = True
            QTimer.singleShot(0, self, self._show_of_view)

    @property
    def sizes(self) -> tuple[int, ...]:
        """Widths and heights of those of the View workspace in turn; empty where they are not beside each other."""
        self._note_sizes()
        return tuple(side for size in self._sizes for side in (size.width(), size.height()))

    def _note_sizes(self) -> None:
        """Note how large a user has them: as docks hide one after the other, each leaves its room to the next."""
        docks = self.of_view.docks
        if not self._sizes and all(dock.isVisible() for dock in docks):  # or else they are on their way
            is_whole = self._is_sized and not any(dock.isFloating() for dock in docks)
            self._sizes = [dock.size() for dock in docks] if is_whole else []

    def _size(self) -> None:
        """Give those of the View workspace their part of the window, or what they had when they were seen last."""
        docks, window = list(self.of_view.docks), self.window
        if not all(dock.isVisible() for dock in docks) or (self._is_sized and len(self._sizes) != len(docks)):
            return
        is_lying = window.dockWidgetArea(docks[0]) == BOTTOM
        along, across = (window.width(), DOCK_HEIGHT) if is_lying else (window.height(), DOCK_WIDTH)
        if not self._is_sized:
            both = [QSize(round(share * along), across) for share in SHARES]
            self._sizes = both if is_lying else [size.transposed() for size in both]
        self._is_sized = True
        window.resizeDocks(docks, [size.width() for size in self._sizes], Qt.Orientation.Horizontal)
        window.resizeDocks(docks, [size.height() for size in self._sizes], Qt.Orientation.Vertical)
        self._sizes = []
