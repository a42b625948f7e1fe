"""Which keys a text field takes, and where the focus goes when its text is taken: one rule for all fields."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, cast

from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QComboBox, QLineEdit, QWidget

from app.widgets.number_field import NUMERIC, NumberField
from app.window.focus import text_field
from app.window.main_window import MainWindow
from app.window.top_bar import WORKSPACES
from tests.app.window.test_main_window import fill

CTRL = Qt.KeyboardModifier.ControlModifier


def focus() -> QWidget:
    """The widget that has the focus."""
    widget = QApplication.focusWidget()
    assert widget is not None
    return widget


def press(key: Qt.Key, modifier: Qt.KeyboardModifier = Qt.KeyboardModifier.NoModifier) -> None:
    """A key press where the focus is."""
    QTest.keyClick(focus(), key, modifier)


def write(text: str) -> None:
    """Type `text` where the focus is, wherever it goes meanwhile."""
    for letter in text:
        QTest.keyClicks(focus(), letter)


def fields(window: MainWindow) -> Iterator[tuple[str, QWidget, QLineEdit]]:
    """Each text field within reach in any workspace or dock: the workspace, the widget with the focus, the field."""
    for name in WORKSPACES:
        window.show_workspace(name)
        for kind in (QLineEdit, QComboBox):
            for widget in window.findChildren(kind):
                field = text_field(widget)
                is_inner = kind is QLineEdit and isinstance(widget.parentWidget(), QComboBox)
                if field is not None and widget.isVisible() and widget.isEnabled() and not is_inner:
                    yield name, widget, field


def test_keys_reach_what_they_are_meant_for_in_every_field(window: MainWindow, qtbot: Any) -> None:
    fill(window)
    window.bench.document.change("A bound", mixed=True)
    window.capture.dome.show()  # which it is where lamps stand on several sides
    window.activateWindow()
    window.show_workspace("view")
    qtbot.waitUntil(lambda: window.view.default_mesh is not None and window.isActiveWindow(), timeout=60_000)
    for add in (window.view.lights.add_lamp, window.view.lights.add_near_lamp):
        add()
    document, seen = window.bench.document, []
    for name, widget, field in fields(window):
        label = f"{name}: {field.accessibleName() or widget.accessibleName() or field.text()}"
        seen.append(name)
        document.change("A note", notes=f"{document.project.notes}.")
        notes, before = document.project.notes, field.text()
        widget.setFocus(Qt.FocusReason.MouseFocusReason)
        assert focus() is widget, label
        press(Qt.Key.Key_Z, CTRL)
        assert (document.project.notes, field.text()) == (notes[:-1], before), f"{label}: Ctrl+Z undoes the gesture"
        if field.property(NUMERIC):
            look = document.project.look
            write("qbhw")
            assert field.text() == before, f"{label}: letters are no number"
            document.change("As before", look=look)
            widget.setFocus(Qt.FocusReason.MouseFocusReason)
        field.selectAll()
        before, look = field.text(), document.project.look
        write("7bh")
        assert field.text() == "7bh", f"{label}: letters go to a text that is being edited"
        assert document.project.look == look, label
        for _ in range(9):
            if field.isModified():
                press(Qt.Key.Key_Z, CTRL)
        assert (field.text(), document.project.look) == (before, look), f"{label}: Ctrl+Z undoes typing first"
        if isinstance(field, NumberField):
            value = field.low if field.value != field.low else field.high
            field.selectAll()
            write(f"{value:.6g}")
            press(Qt.Key.Key_Return)
            assert text_field(focus()) is None, f"{label}: Enter gives the focus away"
            assert not field.isModified(), label
    assert set(seen) == set(WORKSPACES)


def test_a_typed_light_is_undone_from_where_enter_leaves_the_focus(window: MainWindow, qtbot: Any) -> None:
    window.activateWindow()
    window.show_workspace("view")
    qtbot.waitUntil(lambda: window.view.default_mesh is not None and window.isActiveWindow(), timeout=60_000)
    look = lambda: window.bench.document.project.look  # noqa: E731
    first, field = look(), cast(Any, window.view.lights.light.editors["light_theta_deg"]).field
    QTest.mouseClick(field, Qt.MouseButton.LeftButton)
    write("60")
    press(Qt.Key.Key_Return)
    assert look().light_theta_deg == 30.0, "elevations are typed, angles from straight up are kept"
    assert field.text() == "60°"
    assert focus() is window.view.viewport
    press(Qt.Key.Key_B)
    assert look().comparing == "wipe"
    for _ in range(5):
        press(Qt.Key.Key_Z, CTRL)
    assert look() == first
    QTest.mouseClick(field, Qt.MouseButton.LeftButton)
    write("600")
    press(Qt.Key.Key_Return)
    assert focus() is field, "what is no angle stays to be mended"
    press(Qt.Key.Key_Escape)
    assert focus() is window.view.viewport
    QTest.mouseClick(field, Qt.MouseButton.LeftButton)
    window.show_workspace("capture")
    window.show_workspace("view")
    assert focus() is window.view.viewport, "a field is not entered by coming back"
