"""Keys act on the workspace in front whatever has the focus, and a theme reaches every icon."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QColor, QIcon
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QAbstractButton, QApplication, QLineEdit, QMenuBar, QVBoxLayout, QWidget

from app.widgets import theme
from app.widgets.panels import Segments, button, text
from app.window.main_window import MainWindow
from app.window.top_bar import WORKSPACES


@pytest.fixture
def viewing(window: MainWindow, qtbot: Any) -> MainWindow:
    window.activateWindow()
    window.show_workspace("view")
    qtbot.waitUntil(lambda: window.view.default_mesh is not None and window.isActiveWindow(), timeout=60_000)
    return window


def test_keys_act_on_the_workspace_in_front_unless_a_text_field_has_the_focus(viewing: MainWindow, qtbot: Any) -> None:
    look = lambda: viewing.bench.document.project.look  # noqa: E731
    viewing.view.tone_map.setFocus()
    QTest.keyClick(viewing.view.tone_map, Qt.Key.Key_R)
    assert look().mode == "reference"
    QTest.keyClick(viewing.view.tone_map, Qt.Key.Key_D)
    QTest.keyClick(viewing.view.tone_map, Qt.Key.Key_B)
    assert (look().mode, look().against, look().comparing) == ("direct", "reference", "wipe")
    QTest.keyClick(viewing.view.tone_map, Qt.Key.Key_Tab)
    assert (look().mode, look().against) == ("reference", "direct")
    field: Any = viewing.view.exposure.editors["exposure_ev"]
    field.field.setFocus()
    field.field.selectAll()
    QTest.keyClicks(field.field, "1d")
    assert field.field.text() == "1d", "letters go to a text that is being edited"
    QTest.keyClick(field.field, Qt.Key.Key_Tab)
    assert (look().mode, look().against) == ("reference", "direct")
    QTest.keyClick(field.field, Qt.Key.Key_Escape)
    viewing.bench.document.change("Alone", look=dataclasses.replace(look(), comparing=""))
    viewing.view.tone_map.setFocus()
    QTest.keyClick(viewing.view.tone_map, Qt.Key.Key_Tab)
    assert look().mode == "reference", "Tab leads on where nothing is compared"
    viewport = viewing.view.viewport
    camera, azimuth_deg = viewport.camera, look().light_phi_deg
    QTest.keyClick(viewport, Qt.Key.Key_Right)
    assert viewport.camera != camera, "arrow keys rotate the model"
    QTest.keyClick(viewport, Qt.Key.Key_Right, Qt.KeyboardModifier.ControlModifier)
    assert look().light_phi_deg == azimuth_deg + 5.0, "with Ctrl they move the light"
    before = viewport.camera
    QTest.keyClick(viewport, Qt.Key.Key_Right, Qt.KeyboardModifier.ShiftModifier)
    assert before is not None
    assert viewport.camera is not None
    moved = np.subtract(viewport.camera.eye, before.eye)
    assert np.allclose(moved, np.subtract(viewport.camera.target, before.target)), "with Shift they pan"
    assert moved @ before.camera_from_world[0] < 0.0, "the model follows the key"
    viewport.overlay.wipe = 0.5
    with qtbot.waitSignal(viewport.wipe_moved) as wiped:
        QTest.keyClick(viewport, Qt.Key.Key_Left, Qt.KeyboardModifier.AltModifier)
    assert wiped.args == [pytest.approx(0.48)], "with Alt they move the wipe line"
    viewing.show_workspace("capture")
    QTest.keyClick(viewing, Qt.Key.Key_D)
    assert look().mode == "reference"


@pytest.mark.parametrize("name", ["light", "dark"])
def test_the_choice_of_segments_can_be_told_from_their_focus(qapp: QApplication, qtbot: Any, name: str) -> None:
    theme.apply(qapp, name)
    segments = Segments([("a", "First", ""), ("b", "Second", ""), ("c", "Third", "")])
    qtbot.addWidget(segments)
    segments.choose("a")
    segments.show()
    qtbot.waitExposed(segments)
    segments.activateWindow()
    qtbot.waitUntil(segments.isActiveWindow, timeout=30_000)

    def observe(value: str) -> tuple[QColor, QColor]:
        """Colours of the fill and of the edge of the segment `value`."""
        image = segments.grab().toImage()
        box = segments.buttons[value].geometry()
        return image.pixelColor(box.left() + 5, box.center().y()), image.pixelColor(box.left() + 1, box.top() + 1)

    segments.buttons["c"].setFocus()
    chosen, free, focused = observe("a"), observe("b"), observe("c")
    segments.buttons["a"].setFocus()
    chosen_and_focused = observe("a")
    assert contrast(chosen[0], free[0]) >= 3.0, "the choice is told by its fill"
    assert focused[0] == free[0], "the focus does not look like a choice"
    assert contrast(focused[1], free[1]) >= 3.0, "the focus is told by its edge"
    assert chosen_and_focused[0] == chosen[0]
    assert contrast(chosen_and_focused[1], chosen[0]) >= 1.5
    assert contrast(QColor(theme.current().on_accent), chosen[0]) >= 4.5, "the label of the choice is readable"
    theme.apply(qapp, "dark")


def test_a_widget_that_is_there_takes_the_theme_that_a_new_one_has(qapp: QApplication, qtbot: Any) -> None:
    def make() -> QWidget:
        holder = theme.role(QWidget(), "panel")
        holder.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        rows = QVBoxLayout(holder)
        stop = button("Stop")
        stop.setEnabled(False)
        for widget in (button("Make", "primary"), stop, text("Beside", "secondary"), text("Wrong", "bad")):
            rows.addWidget(widget)
        qtbot.addWidget(holder)
        return holder

    theme.apply(qapp, "dark")
    shown, hidden = make(), make()
    for holder in (shown, hidden):
        holder.show()
        qtbot.waitExposed(holder)
    hidden.hide()
    dark = shown.grab().toImage()
    dressing = theme.change(qapp, "light")
    assert dressing is not None
    with theme.draw_at_once(qapp):
        assert not shown.updatesEnabled(), "until all that is visible has it"
        for _ in dressing.dress_visible():
            pass
    assert shown.updatesEnabled()
    light = make().grab().toImage()
    assert light != dark
    assert shown.grab().toImage() == light
    for _ in dressing.dress_rest():
        pass
    assert hidden.grab().toImage() == light
    theme.apply(qapp, "dark")
    assert shown.grab().toImage() == dark


def test_a_workspace_that_comes_to_the_front_while_the_theme_changes_has_it(
    window: MainWindow, qtbot: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    polished: list[Any] = []
    polish_anew = theme._polish_anew

    def polish(widget: QWidget) -> None:
        polished.append(widget)
        polish_anew(widget)

    monkeypatch.setattr(theme, "_polish_anew", polish)
    window.show_workspace("view")
    window.set_theme("dark")
    qtbot.waitUntil(lambda: not window.is_dressing, timeout=30_000)
    window.show_workspace("brdf")
    polished.clear()
    window.set_theme("light")
    window.show_workspace("view")
    assert window.is_dressing
    assert not window.updatesEnabled(), "the screen shows the theme before"
    qtbot.waitUntil(window.updatesEnabled, timeout=30_000)
    assert window.is_dressing
    shown = window.view.model.grab().toImage()
    qtbot.waitUntil(lambda: not window.is_dressing, timeout=30_000)
    assert window.view.model.grab().toImage() == shown
    dressed = [widget for widget in polished if widget is window.view.model]
    assert len(dressed) == 1, "no widget is dressed twice"


@pytest.mark.parametrize("name", ["light", "dark"])
def test_icons_of_all_buttons_can_be_told_from_what_is_behind_them(window: MainWindow, qtbot: Any, name: str) -> None:
    window.set_theme("dark" if name == "light" else "light")
    window.set_theme(name)
    qtbot.waitUntil(lambda: not window.is_dressing, timeout=30_000)
    faint = []
    for each in window.findChildren(QAbstractButton):
        if each.icon().isNull() or isinstance(each.parent(), (QLineEdit, QMenuBar)):
            continue  # none, or one of Qt's own
        if each.property("role") == "swatch":
            continue  # a colour of the user's
        behind = theme.current().accent if each.property("role") == "primary" else theme.current().field
        if contrast(ink(each.icon()), QColor(behind)) < 2.5:
            faint.append((each.accessibleName() or each.text() or each.toolTip(), ink(each.icon()).name()))
    assert faint == []
    window.set_theme("dark")


def ink(icon: QIcon) -> QColor:
    """The colour of an icon where it is opaque."""
    image = icon.pixmap(theme.LARGE).toImage()
    points = ((x, y) for y in range(image.height()) for x in range(image.width()))
    x, y = max(points, key=lambda at: image.pixelColor(*at).alpha())
    return image.pixelColor(x, y)


def contrast(one: QColor, other: QColor) -> float:
    """The contrast of two colours as WCAG 2.1 defines it, 1 … 21."""
    lighter, darker = sorted((luminance(one), luminance(other)), reverse=True)
    return (lighter + 0.05) / (darker + 0.05)


def luminance(colour: QColor) -> float:
    def linear(value: float) -> float:
        return value / 12.92 if value <= 0.03928 else float(((value + 0.055) / 1.055) ** 2.4)

    return 0.2126 * linear(colour.redF()) + 0.7152 * linear(colour.greenF()) + 0.0722 * linear(colour.blueF())


def test_the_window_fits_into_its_smallest_size(window: MainWindow) -> None:
    for name in WORKSPACES:
        window.show_workspace(name)
        inside = window.tabs[name].minimumSizeHint()
        assert (inside.width() <= 1024, inside.height() <= 700 - 72) == (True, True), (name, inside)


@pytest.mark.parametrize(
    ("side", "forward"), [("Top", (0.0, -1.0, 0.0)), pytest.param("Right", (-1.0, 0.0, 0.0), marks=pytest.mark.long)]
)
def test_the_model_is_seen_from_a_side_that_the_menu_names(
    viewing: MainWindow, side: str, forward: tuple[float, float, float]
) -> None:
    next(action for action in viewing.view.views.actions() if action.text() == side).trigger()
    camera = viewing.view.viewport.camera
    assert camera is not None
    assert tuple(camera.forward) == pytest.approx(forward, abs=1e-9)


def test_a_budget_that_is_none_is_marked_and_says_what_is(viewing: MainWindow) -> None:
    accuracy = viewing.docks.accuracy
    accuracy.budget.setText("much")
    assert accuracy.budget.property("invalid") == "Enter it as '8 ms and 100 MB' or '1 %'."
    accuracy.budget.setText("0,5 %")
    assert accuracy.budget.property("invalid") == ""
