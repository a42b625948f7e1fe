from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, cast

import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QWheelEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QDialog, QLabel, QPushButton, QScrollArea, QVBoxLayout, QWidget

from app.document.document import Look
from app.widgets.controls import TICKS, ComboBox, Slider
from app.widgets.number_field import NumberField, number_from_text, plain
from app.widgets.panels import Panel
from app.widgets.param_form import ElevationEditor, ParamForm
from engine.brdf.models.lafortune import LafortuneThreeLobes
from engine.brdf.models.phong import Phong
from engine.core.figure_text import format_fixed, number, percent, size_text, write_with
from engine.factor.settings import FactorSettings


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("3", "", 3.0),
        ("2*3.5", "", 7.0),
        ("-(1+2)/4", "", -0.75),
        ("45°", "°", 45.0),
        ("1,5 EV", "EV", 1.5),
        ("2×3", "", 6.0),
    ],
)
def test_numbers_expressions_and_units(text: str, unit: str, value: float) -> None:
    assert number_from_text(text, unit) == value


@pytest.mark.parametrize(
    "text",
    ["", "nan", "inf", "1e400", "1/0", "__import__('os')", "9**9**9", "a", "1;2", "(" * 50, "True", "2*" * 40 + "2"],
)
def test_fault_25_what_is_no_finite_number_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match=r"."):
        number_from_text(text)


@pytest.mark.parametrize("typed", ["nan", "1e400", "-1", "11", "words", ""])
def test_fault_25_the_field_keeps_the_previous_value(qtbot: Any, typed: str) -> None:
    field = NumberField(4.0, 0.0, 10.0, unit="px")
    qtbot.addWidget(field)
    edited: list[float] = []
    field.edited.connect(lambda value, _final: edited.append(value))
    field.show()
    field.selectAll()
    QTest.keyClicks(field, typed)
    if not typed:
        QTest.keyClick(field, Qt.Key.Key_Backspace)
    QTest.keyClick(field, Qt.Key.Key_Return)
    assert (field.value, field.text(), edited) == (4.0, typed, [])


def test_typing_dragging_and_resetting_change_the_value(qtbot: Any) -> None:
    field = NumberField(4.0, 0.0, 10.0)
    qtbot.addWidget(field)
    edited: list[tuple[float, bool]] = []
    field.edited.connect(lambda value, final: edited.append((value, final)))
    field.show()
    field.selectAll()
    QTest.keyClicks(field, "2*3")
    QTest.keyClick(field, Qt.Key.Key_Return)
    assert edited == [(6.0, True)]
    QTest.mouseClick(field, Qt.MouseButton.LeftButton, Qt.KeyboardModifier.ControlModifier, QPoint(5, 5))
    assert edited[-1] == (4.0, True)


def test_figures_are_short_and_without_needless_zeros() -> None:
    shown = [plain(value) for value in (0.0, 1.0, 0.3352, 1e-7, 1234567.0, 12.5)]
    assert shown == ["0", "1", "0.3352", "1e-07", "1.23e+06", "12.5"]
    assert all(math.isfinite(float(text)) for text in shown)


def test_a_form_has_a_row_for_each_declared_parameter_and_stays_in_range(qtbot: Any) -> None:
    form = ParamForm(Phong())
    qtbot.addWidget(form)
    assert list(form.editors) == ["kd", "ks", "exponent"]
    changed: list[Phong] = []
    form.edited.connect(lambda instance, _final: changed.append(instance))
    exponent: Any = form.editors["exponent"]
    exponent.slider.setValue(exponent.slider.maximum())
    assert changed[-1].exponent == 1000.0
    exponent.slider.setValue(0)
    assert changed[-1].exponent == 1.0
    exponent.slider.setValue(500)
    assert changed[-1].exponent == pytest.approx(math.sqrt(1000), rel=0.01)
    cast(Any, form.editors["kd"]).strength.slider.setValue(0)
    assert changed[-1].kd == (0.0, 0.0, 0.0)
    cast(Any, form.editors["kd"]).strength.slider.setValue(1000)
    assert changed[-1].kd == (1.0, 1.0, 1.0)


def test_a_form_scales_weights_that_are_negative(qtbot: Any) -> None:
    form = ParamForm(LafortuneThreeLobes(cxy1=(-1.0, -0.5, 0.25)))
    qtbot.addWidget(form)
    changed: list[LafortuneThreeLobes] = []
    form.edited.connect(lambda instance, _final: changed.append(instance))
    editor = form.editors["cxy1"]
    assert cast(Any, editor).strength.field.value == -1.0
    cast(Any, editor).strength.field.edited.emit(-2.0, True)
    assert changed[-1].cxy1 == (-2.0, -1.0, 0.5)


@pytest.mark.parametrize(
    ("control", "value"),
    [
        (lambda: _combo(), lambda combo: combo.currentIndex()),
        (lambda: Slider(), lambda slider: slider.value()),
        (lambda: NumberField(4.0, 0.0, 10.0), lambda field: field.value),
    ],
)
def test_the_wheel_changes_a_control_only_after_a_click_put_the_focus_there(
    qtbot: Any, control: Callable[[], Any], value: Callable[[Any], float]
) -> None:
    panel = Panel()
    made = control()
    panel.column.addWidget(made)
    for _ in range(40):
        panel.column.addWidget(QLabel("row"))
    panel.finish()
    qtbot.addWidget(panel)
    panel.resize(panel.width(), 200)
    panel.show()
    before = value(made)
    scrolled = cast(QScrollArea, panel.findChild(QScrollArea)).verticalScrollBar()
    panel.activateWindow()
    qtbot.waitUntil(lambda: scrolled.maximum() > 0 and panel.isActiveWindow())
    _wheel(made)
    assert (value(made), scrolled.value() > 0) == (before, True)
    made.setFocus(Qt.FocusReason.TabFocusReason)
    _wheel(made)
    assert value(made) == before
    QTest.mouseClick(made, Qt.MouseButton.LeftButton)
    if isinstance(made, ComboBox):
        made.hidePopup()
        qtbot.waitUntil(lambda: not made.view().isVisible())
    made.setFocus(Qt.FocusReason.PopupFocusReason)
    qtbot.waitUntil(made.hasFocus)
    clicked, at = value(made), scrolled.value()
    _wheel(made)
    assert value(made) != clicked
    assert scrolled.value() == at


def _combo() -> ComboBox:
    combo = ComboBox()
    combo.addItems(["one", "two", "three"])
    return combo


def _wheel(widget: QWidget) -> None:
    """One notch down over a widget; what it ignores goes on to the widgets around it, as a user's does."""
    middle = QPointF(widget.rect().center())
    buttons, keys, phase = Qt.MouseButton.NoButton, Qt.KeyboardModifier.NoModifier, Qt.ScrollPhase.NoScrollPhase
    around: QWidget | None = widget
    while around is not None:
        notch = QWheelEvent(
            middle, widget.mapToGlobal(middle), QPoint(0, -15), QPoint(0, -120), buttons, keys, phase, False
        )
        QApplication.sendEvent(around, notch)
        if notch.isAccepted():
            return
        around = around.parentWidget()


def test_what_is_invalid_stays_marked_until_it_is_mended_or_left_with_escape(qtbot: Any) -> None:
    field = NumberField(4.0, 0.0, 10.0, unit="px")
    field.setToolTip("Width of a line")
    qtbot.addWidget(field)
    field.show()
    field.selectAll()
    QTest.keyClicks(field, "11")
    QTest.keyClick(field, Qt.Key.Key_Return)
    assert field.text() == "11"
    assert field.toolTip() == "Enter a number from 0 px to 10 px, such as 2*3."
    assert field.property("invalid") == field.toolTip()
    field.show_value(4.0)
    assert field.text() == "11"
    QTest.keyClick(field, Qt.Key.Key_Escape)
    assert (field.text(), field.toolTip(), field.property("invalid")) == ("4 px", "Width of a line", "")


@pytest.fixture
def _with_comma() -> None:
    write_with(",")


def test_controls_are_called_what_is_written_beside_them(qtbot: Any) -> None:
    form = ParamForm(LafortuneThreeLobes(), {"kd": "Diffuse", "exponent1": "Sharpness"})
    qtbot.addWidget(form)
    names = [stop.accessibleName() for editor in form.editors.values() for stop in editor.stops]
    assert names == [f"{name}{part}" for name in ("Diffuse", "Sharpness") for part in (": colour", "", "")]


def test_enter_takes_what_was_typed_and_then_presses_the_main_button_of_a_dialog(qtbot: Any) -> None:
    dialog = QDialog()
    qtbot.addWidget(dialog)
    field, main = NumberField(4.0, 0.1, 300.0, unit="s"), QPushButton("Save…")
    main.setDefault(True)
    pressed: list[str] = []
    main.clicked.connect(lambda _checked=False: pressed.append(main.text()))
    column = QVBoxLayout(dialog)
    for widget in (field, main):
        column.addWidget(widget)
    dialog.show()
    field.setFocus()
    field.selectAll()
    QTest.keyClicks(field, "0.5")
    QTest.keyClick(field, Qt.Key.Key_Return)
    assert (field.value, pressed) == (0.5, [])
    QTest.keyClick(field, Qt.Key.Key_Return)
    assert pressed == ["Save…"]


@pytest.mark.usefixtures("_with_comma")
def test_numbers_are_shown_in_the_form_of_the_language_and_read_in_both(qtbot: Any) -> None:
    field = NumberField(0.5, 0.0, 1e5, unit="EV")
    qtbot.addWidget(field)
    assert field.text() == "0,5 EV"
    for typed, value in (("1.25", 1.25), ("1,75", 1.75)):
        field.setText(typed)
        field.setModified(True)
        QTest.keyClick(field, Qt.Key.Key_Return)
        assert field.value == value
    assert (percent(0.0123), size_text(1.5e6), number(12345.0, 5)) == ("1,2 %", "1,5 MB", "12\u202f345")
    assert number_from_text(number(12345.0, 5)) == 12345.0


def test_negative_numbers_have_a_true_minus_sign_and_are_read_with_both(qtbot: Any) -> None:
    write_with(".", minus="−")
    field = NumberField(-30.0, -180.0, 180.0, unit="°")
    qtbot.addWidget(field)
    assert (field.text(), number(-0.25), format_fixed(-12.04, 1), format_fixed(-0.01, 1)) == (
        "−30°",
        "−0.25",
        "−12.0",
        "0.0",
    )
    assert number(3e-7) == "3e-7"
    for typed, value in (("−45°", -45.0), ("-60", -60.0)):
        field.setText(typed)
        field.setModified(True)
        QTest.keyClick(field, Qt.Key.Key_Return)
        assert field.value == value


@pytest.mark.parametrize(
    ("typed", "value", "shown"), [("", 0.0, "not known"), ("0", 0.0, "not known"), ("3", 3.0, "3 mm")]
)
def test_nothing_has_a_word_and_is_typed_by_emptying_the_field(
    qtbot: Any, typed: str, value: float, shown: str
) -> None:
    field = NumberField(5.0, 0.0, 9.0, unit="mm", nothing="not known")
    qtbot.addWidget(field)
    field.setText(typed)
    field.setModified(True)
    QTest.keyClick(field, Qt.Key.Key_Return)
    assert (field.value, field.text()) == (value, shown)
    assert field.takes.startswith("Enter a number from 0 mm to 9 mm")


def test_an_angle_from_straight_up_is_shown_and_set_as_elevation(qtbot: Any) -> None:
    form = ParamForm(Look(light_theta_deg=56.7), {"light_theta_deg": "Elevation"})
    qtbot.addWidget(form)
    editor, heard = form.editors["light_theta_deg"], []
    assert isinstance(editor, ElevationEditor)
    form.edited.connect(lambda look, final: heard.append((look.light_theta_deg, final)))
    assert (editor.field.text(), editor.field.low, editor.field.high) == ("33.3°", -90.0, 90.0)
    editor.field.edited.emit(80.0, True)
    assert heard == [(10.0, True)]
    assert editor.slider.value() > TICKS // 2, "a high light is at the right"
    editor.slider.reset.emit()
    assert heard[-1] == (Look().light_theta_deg, True)
    limit = ParamForm(FactorSettings(), {"max_theta_deg": "Max. angle"})
    qtbot.addWidget(limit)
    assert cast(Any, limit.editors["max_theta_deg"]).field.text() == "88°", "from the normal, as its name says"
