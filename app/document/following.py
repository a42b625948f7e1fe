"""Workspaces that follow the document: the one on screen at once, those behind it part by part a moment later.

A change that concerns all of them, like a project that is opened, would otherwise hold the window up for as long as
all of them take together.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Generator

import shiboken6
from PySide6.QtCore import QEvent, QObject, QTimer
from PySide6.QtWidgets import QWidget

from app.document.document import Project
from app.document.open_document import Document

#: Milliseconds between two parts, in which the window draws and hears the user.
BETWEEN_MS = 5

#: Returned by parts when none is left.
DONE = object()

#: Shows a project in place of another; what takes long yields between its parts.
Follow = Callable[[Project, Project], Generator[None] | None]


class Following(QObject):
    """The link of `workspace` to `document`: calls `follow` with the project before and after each change.

    While another workspace hides it, changes are told in turns of the event loop of their own, several as one, and all
    that is left when it is shown. In a window that is not on screen all are told at once.
    """

    def __init__(self, document: Document, workspace: QWidget, follow: Follow) -> None:
        super().__init__(workspace)
        self._document, self._workspace, self._follow = document, workspace, follow
        self._known = document.project
        self._parts: Generator[None] | None = None
        document.changed.connect(self._on_changed)
        workspace.installEventFilter(self)

    def _on_changed(self, _old: Project, _new: Project) -> None:
        if self._workspace.isVisible() or not self._workspace.window().isVisible():
            self.catch_up()
        elif self not in _behind:
            _behind.append(self)
            if len(_behind) == 1:
                QTimer.singleShot(BETWEEN_MS, _tell_a_part)

    def catch_up(self) -> None:
        """Tell all that has not been told yet."""
        while self.tell_a_part():
            pass

    def tell_a_part(self) -> bool:
        """Tell a part of what has not been told yet; False where nothing is left."""
        if self._parts is None:
            known, self._known = self._known, self._document.project
            if known is self._known:
                return False
            self._parts = self._follow(known, self._known)
        if self._parts is not None and next(self._parts, DONE) is DONE:
            self._parts = None
        return self._parts is not None or self._known is not self._document.project

    def eventFilter(self, _workspace: QObject, event: QEvent) -> bool:
        if event.type() == QEvent.Type.Show:
            self.catch_up()
        return False


#: Those that have not been told everything, in the order in which they will be.
_behind: deque[Following] = deque()


def _tell_a_part() -> None:
    following = _behind.popleft()
    try:
        if shiboken6.isValid(following) and following.tell_a_part():
            _behind.appendleft(following)
    finally:
        if _behind:
            QTimer.singleShot(BETWEEN_MS, _tell_a_part)
