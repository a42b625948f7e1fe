from __future__ import annotations

import math
from typing import Any, cast

import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest

from app.widgets.number_field import NumberField, number_from_text, plain
from app.widgets.param_form import ParamForm
from engine.brdf.models.lafortune import LafortuneThreeLobes
from engine.brdf.models.phong import Phong


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
    assert (field.value, field.text(), edited) == (4.0, "4 px", [])


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
