"""Which keys a text field of the window takes, and where the focus goes when its text is taken.

One rule holds for every text field, also for those that Qt makes in tables and editable lists. A field is *being
edited* while its text differs from what it took last.

- A field that is being edited gets every key that is typed, and Ctrl+Z undoes typing.
- A field that isn't leaves Ctrl+Z and its opposite to the project. A field of numbers then also takes no character but
  those that begin a number: letters are shortcuts there as elsewhere.
- Enter takes the text and gives the focus to the work area of the workspace in front, and so does whatever else lets a
  field go (Esc, the end of a drag). Invalid text keeps the focus.

The window is told of the focus by Qt; only the field that has it is watched, so that events of others cost nothing.
"""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QEvent, QObject, Qt
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import QAbstractItemView, QApplication, QComboBox, QLineEdit, QWidget

from app.widgets.number_field import NUMERIC

#: Characters that begin a number or an expression.
BEGINNINGS = "0123456789.,+-−("

#: Keys that undo and redo while Ctrl is held.
HISTORY = (Qt.Key.Key_Z, Qt.Key.Key_Y)

#: Modifiers that make a command of a key.
COMMANDS = Qt.KeyboardModifier.ControlModifier | Qt.KeyboardModifier.AltModifier | Qt.KeyboardModifier.MetaModifier


def belongs_to(field: QLineEdit, event: QKeyEvent) -> bool:
    """True where the key of `event` is for the text of `field`, False where it is for the window."""
    if event.key() in HISTORY and event.modifiers() & Qt.KeyboardModifier.ControlModifier:
        is_redo = event.key() == Qt.Key.Key_Y or bool(event.modifiers() & Qt.KeyboardModifier.ShiftModifier)
        return field.isRedoAvailable() if is_redo else field.isModified() and field.isUndoAvailable()
    typed = event.text()
    if field.isModified() or event.modifiers() & COMMANDS or not (typed and typed.isprintable()):
        return True
    return typed in BEGINNINGS or not field.property(NUMERIC)


def takes_back(field: QLineEdit, event: QEvent) -> bool:
    """True where the key of `event` is Esc and a number is being edited: it takes that back before it is a shortcut."""
    is_esc = isinstance(event, QKeyEvent) and event.key() == Qt.Key.Key_Escape
    return is_esc and bool(field.property(NUMERIC)) and field.isModified()


class FieldKeys(QObject):
    """Applies the rule to the text fields of `window`; `focus_on_work` gives the focus to its work area."""

    def __init__(self, window: QWidget, focus_on_work: Callable[[], None]) -> None:
        super().__init__(window)
        self.window, self.focus_on_work = window, focus_on_work
        application = QApplication.instance()
        assert isinstance(application, QApplication)
        application.focusChanged.connect(self._focus_moved)

    def _focus_moved(self, before: QWidget | None, now: QWidget | None) -> None:
        field = self._field(before)
        if before is not None and field is not None:
            before.removeEventFilter(self)
            field.editingFinished.disconnect(self._taken)
            _settle(field)
            if now is None and self.window.isActiveWindow():
                self.focus_on_work()
        field = self._field(now)
        if now is not None and field is not None:
            now.installEventFilter(self)
            field.editingFinished.connect(self._taken)  # after the slots of the field's own module

    def _field(self, widget: QWidget | None) -> QLineEdit | None:
        """The text field of the window that gets the keys while `widget` has the focus."""
        return text_field(widget) if widget is not None and widget.window() is self.window else None

    def _taken(self) -> None:
        """Let the field go that Enter was pressed in."""
        focus = QApplication.focusWidget()
        field = self._field(focus)
        if field is self.sender() and field is not None:
            _settle(field)
            if not field.isModified() and not _is_cell(field):
                self.focus_on_work()

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        if event.type() in (QEvent.Type.ShortcutOverride, QEvent.Type.KeyPress):
            field = text_field(watched)
            if field is not None and isinstance(event, QKeyEvent) and not belongs_to(field, event):
                event.ignore()
                return True
            if event.type() == QEvent.Type.ShortcutOverride and field is not None and takes_back(field, event):
                event.accept()
                return True
        return False


def text_field(widget: QObject) -> QLineEdit | None:
    """`widget`, or the field within it where it is an editable list, which keeps the focus itself."""
    if isinstance(widget, QComboBox):
        return widget.lineEdit()
    return widget if isinstance(widget, QLineEdit) else None


def _settle(field: QLineEdit) -> None:
    """Note that the text of `field` is taken, unless it is marked as invalid."""
    if not field.property("invalid"):
        field.setModified(False)


def _is_cell(field: QLineEdit) -> bool:
    """True for the editor of a cell: Qt gives its focus back to the table, for the arrow keys."""
    holder = field.parentWidget()
    return holder is not None and isinstance(holder.parentWidget(), QAbstractItemView)
