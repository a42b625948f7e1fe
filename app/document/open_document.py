"""The document that is open in the window: the project, one undo command, one signal.

A change swaps the whole `Project`; arrays are shared between old and new, so undo costs a pointer, and what only
earlier states hold is bounded (`app.document.history`). A view compares its part of old and new by identity and redraws
when it is another object.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, cast

from PySide6.QtCore import QObject, QSignalBlocker, QTimer, Signal
from PySide6.QtGui import QUndoCommand, QUndoStack

from app.document import history
from app.document.document import Project, Step
from app.document.history import KEPT_STEPS, count_freed_bytes, steps_to_keep
from engine.core.errors import FileError
from engine.geometry.camera import Camera


def _nothing_found(name: str) -> Project:
    raise KeyError(name)


class Document(QObject):
    """Holds the project and its history.

    Signals
    -------
    changed : the project before and after, at every change, undo and redo.
    seen : the model is seen from elsewhere, which is no step of the history.
    unread : a FileError, where a step cannot be read because the disk of the project is gone. All is as it was.
    """

    changed = Signal(object, object)
    seen = Signal()
    unread = Signal(object)

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.project = Project()
        self.find: Callable[[str], Project] = _nothing_found
        self.undo_stack = QUndoStack(self)
        self.undo_stack.setUndoLimit(KEPT_STEPS)
        self._gestures = 0
        self._restoring = False

    def change(self, text: str, *, gesture: str = "", **parts: Any) -> None:
        """Replace `parts` of the project as one undo step; successive steps of the same `gesture` become one."""
        new = dataclasses.replace(self.project, **parts)
        gesture = f"{gesture} {self._gestures}" if gesture else ""
        last = self._last
        if last is not None and gesture and last.gesture == gesture:
            last.go_on_to(new)
            self._show(new)
        else:
            step = _Change(self, text, self.project, new, gesture)
            self._show(new)
            self.undo_stack.push(step)
        self._forget_oldest()

    @property
    def _last(self) -> _Change | None:
        """The step that led to the project; None at the beginning, and where the project is one that was undone to."""
        stack = self.undo_stack
        return None if stack.canRedo() or not stack.canUndo() else cast(_Change, stack.command(stack.count() - 1))

    def _forget_oldest(self) -> None:
        """Drop the oldest steps where they keep too much; a stack of Qt's loses them only by being filled anew."""
        stack = self.undo_stack
        steps = [cast(_Change, stack.command(at)) for at in range(stack.count())]
        kept = steps_to_keep([step.given_up_bytes for step in steps], history.KEPT_BYTES)
        if kept == len(steps):
            return
        again = [_Change(self, step.text(), step.old, step.new, step.gesture) for step in steps[-kept:]]
        with QSignalBlocker(stack):
            stack.clear()
            for step in again:
                stack.push(step)

    def complete(self, **parts: Any) -> None:
        """Put `parts` into the project that it had before and that were gone: no step of the history.

        The steps that led to the project and from it lead to the complete one and from it.
        """
        before, stack = self.project, self.undo_stack
        after = dataclasses.replace(before, **parts)
        for at in range(stack.count()):
            step = cast(_Change, stack.command(at))
            if step.new is before or (at == stack.index() - 1 and isinstance(step.new, str)):
                step.new = after
            if step.old is before or (at == stack.index() and isinstance(step.old, str)):
                step.old = after
        self._show(after)

    def look_from(self, camera: Camera | None) -> None:
        """The model is seen from `camera`; None where it is framed. Undo leaves that as it is."""
        if camera != self.project.camera:
            self.project = dataclasses.replace(self.project, camera=camera)
            self.seen.emit()

    def take_back(self, project: Project) -> None:
        """Undo the last step and forget it, where it led to `project`; nothing where the user has gone on since."""
        last = self._last
        if last is not None and last.new is project:
            before = last.old
            last.setObsolete(True)
            self.undo_stack.undo()  # drops an obsolete step without undoing it
            self._go_to(before)

    def end_gesture(self) -> None:
        """The mouse was released: the next change of the same kind is a step of its own."""
        self._gestures += 1

    @property
    def steps(self) -> tuple[Step, ...]:
        """The history, the oldest first; the first `undo_stack.index()` of them lead to the project."""
        stack = self.undo_stack
        commands = (cast(_Change, stack.command(at)) for at in range(stack.count()))
        return tuple(Step(each.text(), each.gesture, each.old, each.new) for each in commands)

    def clear(self, first: Project | None = None) -> None:
        """Begin anew, without history, with `first` or with nothing chosen."""
        self.restore(first or Project())

    def restore(
        self,
        project: Project,
        steps: Sequence[Step] = (),
        position: int = 0,
        find: Callable[[str], Project] | None = None,
    ) -> None:
        """Go on with `project` and the history that led to it; `find` reads states that steps know by name."""
        stack, self.find = self.undo_stack, find or _nothing_found
        self.end_gesture()
        with QSignalBlocker(stack):
            stack.clear()
            for step in steps:
                stack.push(_Change(self, step.text, step.old, step.new, step.gesture))
            self._restoring = True
            stack.setIndex(position)
            self._restoring = False
        stack.indexChanged.emit(stack.index())
        stack.canUndoChanged.emit(stack.canUndo())
        stack.canRedoChanged.emit(stack.canRedo())
        stack.undoTextChanged.emit(stack.undoText())
        stack.redoTextChanged.emit(stack.redoText())
        self._show(project)

    def _go_to(self, project: Project | str) -> None:
        if self._restoring:
            return
        try:
            found = self.find(project) if isinstance(project, str) else project
        except FileError as error:
            QTimer.singleShot(0, self, partial(self._stay, self.undo_stack.index(), error))
            return
        if found.mesh is self.project.mesh and found.camera != self.project.camera:
            found = dataclasses.replace(found, camera=self.project.camera)
        self._show(found)

    def _stay(self, position: int, error: FileError) -> None:
        """Take the history back to the step that led to the project, from one that could not be read."""
        led = (at + 1 for at, step in enumerate(self.steps) if step.new is self.project)
        self._restoring = True
        self.undo_stack.setIndex(next(led, position))
        self._restoring = False
        self.unread.emit(error)

    def _show(self, project: Project) -> None:
        old, self.project = self.project, project
        self.changed.emit(old, project)


class _Change(QUndoCommand):
    """A step that has been done: pushing it changes nothing.

    Qt's own merging of steps is not used: PySide never frees what was merged, here a project for each mouse move.
    """

    def __init__(self, document: Document, text: str, old: Project | str, new: Project | str, gesture: str) -> None:
        super().__init__(text)
        self.document, self.old, self.gesture = document, old, gesture
        self._is_pushed = False
        self.go_on_to(new)

    def go_on_to(self, new: Project | str) -> None:
        """Lead to another project, as a drag that goes on."""
        self.new = new
        self.given_up_bytes = 0
        if isinstance(self.old, Project) and isinstance(new, Project):
            self.given_up_bytes = count_freed_bytes(self.old, new)

    def redo(self) -> None:
        if self._is_pushed:
            self.document._go_to(self.new)
        self._is_pushed = True

    def undo(self) -> None:
        self.document._go_to(self.old)
