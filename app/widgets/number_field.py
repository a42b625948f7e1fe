"""A field for one number: typed with a unit or as an expression, dragged, or reset with Ctrl+click.

What is not a number inside the range stays as it was typed, marked, and the field says what it takes; the previous
value holds meanwhile, and Esc brings it back. A decimal comma is read like a point.
"""

from __future__ import annotations

import ast
import math
import operator
from collections.abc import Callable

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QKeyEvent, QMouseEvent, QWheelEvent
from PySide6.QtWidgets import QLineEdit, QToolTip, QWidget

from app.widgets.controls import ClickFirst
from app.widgets.language import translate
from app.widgets.theme import role
from engine.core.errors import UsageError
from engine.core.figure_text import local

#: Property of text fields whose valid texts begin like a number.
NUMERIC = "numeric"

OPERATIONS: dict[type, Callable[..., float]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.USub: operator.neg,
    ast.UAdd: operator.pos,
}


def number_from_text(text: str, unit: str = "") -> float:
    """The value of `text`: a number or an expression of + − × ÷ and brackets, with or without its unit.

    UsageError for anything else, also for what overflows or is not a number.
    """
    cleaned = text.strip().replace("×", "*").replace("÷", "/").replace("−", "-").replace(",", ".")
    cleaned = cleaned.replace("\u202f", "").replace("\u00a0", " ")
    cleaned = cleaned.removesuffix(unit).strip() if unit else cleaned
    if len(cleaned) > 60:
        raise UsageError("too long for a number")
    try:
        value = _evaluate(ast.parse(cleaned, mode="eval").body)
    except (SyntaxError, ZeroDivisionError, OverflowError, RecursionError, MemoryError) as error:
        raise UsageError(f"{text!r} is not a number") from error
    if not math.isfinite(value):
        raise UsageError(f"{text!r} is not a finite number")
    return value


def _evaluate(node: ast.expr) -> float:
    if isinstance(node, ast.Constant) and isinstance(node.value, (int, float)) and not isinstance(node.value, bool):
        return float(node.value)
    if isinstance(node, ast.BinOp) and type(node.op) in OPERATIONS:
        return OPERATIONS[type(node.op)](_evaluate(node.left), _evaluate(node.right))
    if isinstance(node, ast.UnaryOp) and type(node.op) in OPERATIONS:
        return OPERATIONS[type(node.op)](_evaluate(node.operand))
    raise UsageError("not a number or a sum, product or quotient of numbers")


class NumberField(ClickFirst, QLineEdit):
    """Shows `value` with its unit. `edited(value, final)`: `final` is False while a drag goes on.

    With a word for `nothing`, 0 is shown as that, and an emptied field is 0.
    """

    edited = Signal(float, bool)

    def __init__(
        self,
        value: float,
        low: float,
        high: float,
        *,
        unit: str = "",
        default: float | None = None,
        log: bool = False,
        nothing: str = "",
    ) -> None:
        super().__init__()
        self.value, self.low, self.high, self.unit, self.log = value, low, high, translate(unit), log
        self.nothing = translate(nothing)
        self.default = value if default is None else default
        self._pressed_at: float | None = None
        self._from = value
        self._dragged = False
        role(self, "number")
        self.setProperty(NUMERIC, True)
        self.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
        self.setCursor(Qt.CursorShape.SizeHorCursor)
        self.editingFinished.connect(self._on_typed)
        self.show_value(value)

    def show_value(self, value: float) -> None:
        """Show `value` without emitting; a field that is being typed in is left alone, and so is an invalid text."""
        is_other = value != self.value
        self.value = value
        if is_other or not self.isModified():
            self.setModified(False)
            mark(self, "")
            self.setText(self.nothing if self.nothing and value == 0.0 else self._with_unit(value))

    def show_unknown(self) -> None:
        """Show that there is no value yet; a field that is being typed in is left alone."""
        if not self.isModified():
            mark(self, "")
            self.setText("–")

    def _with_unit(self, value: float) -> str:
        return f"{plain(value)}{' ' * bool(self.unit and self.unit != '°')}{self.unit}"

    @property
    def takes(self) -> str:
        """The sentence that says what is valid here."""
        return f"Enter a number from {self._with_unit(self.low)} to {self._with_unit(self.high)}, such as 2*3."

    def _on_typed(self) -> None:
        if not self.isModified():
            return
        try:
            is_nothing = self.nothing and self.text().strip() in ("", self.nothing)
            value = 0.0 if is_nothing else number_from_text(self.text(), self.unit)
        except UsageError:
            value = math.nan
        if self.low <= value <= self.high:
            self.setModified(False)
            self._set(value, final=True)
        else:
            mark(self, self.takes)

    def _set(self, value: float, *, final: bool) -> None:
        changed = value != self.value
        self.setModified(False)
        self.show_value(value)
        if changed or final:
            self.edited.emit(value, final)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.key() == Qt.Key.Key_Escape:
            self.setModified(False)
            self.show_value(self.value)
            self.clearFocus()
            return
        if event.key() in (Qt.Key.Key_Up, Qt.Key.Key_Down):
            self._from = self.value
            self._set(self._move_by(10 if event.key() == Qt.Key.Key_Up else -10), final=True)
            return
        is_typed = self.isModified()
        super().keyPressEvent(event)
        if is_typed and event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
            event.accept()  # what was typed is taken; without it, Enter presses the main button of a dialog

    def wheelEvent(self, event: QWheelEvent) -> None:
        """A notch is a press of an arrow key, but only after a click: or else the panel scrolls."""
        if self.takes_wheel and event.angleDelta().y():
            self._from = self.value
            self._set(self._move_by(math.copysign(10.0, event.angleDelta().y())), final=True)
        else:
            event.ignore()

    def mousePressEvent(self, event: QMouseEvent) -> None:
        self.clicked = True
        if event.modifiers() & Qt.KeyboardModifier.ControlModifier:
            self._set(self.default, final=True)
            return
        self._pressed_at, self._from, self._dragged = event.position().x(), self.value, False
        super().mousePressEvent(event)

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        if self._pressed_at is None or self.isModified():
            super().mouseMoveEvent(event)
            return
        distance = event.position().x() - self._pressed_at
        self._dragged = self._dragged or abs(distance) > 3
        if self._dragged:
            self.deselect()
            self._set(self._move_by(distance), final=False)

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        self._pressed_at = None
        if self._dragged:
            self._dragged = False
            self.clearFocus()
            self.edited.emit(self.value, True)
            return
        if not self.hasSelectedText() and not self.isModified():
            self.selectAll()
        super().mouseReleaseEvent(event)

    def _move_by(self, pixels: float) -> float:
        if self.log and self._from > 0:
            value = self._from * math.exp(pixels * 0.01)
        else:
            value = self._from + pixels * (min(self.high, 1e3) - max(self.low, -1e3)) / 400.0
        if not self._dragged:
            self._from = min(max(value, self.low), self.high)
        return min(max(value, self.low), self.high)


def mark(field: QWidget, why: str) -> None:
    """Mark what stands in `field` as invalid, and say what is valid, there and where the mouse rests; '' unmarks it."""
    if why == (field.property("invalid") or ""):
        return
    field.setProperty("invalid", why)
    if why:
        field.setProperty("before", field.toolTip())
    field.setToolTip(why or str(field.property("before") or ""))
    field.setAccessibleDescription(why)
    field.style().unpolish(field)
    field.style().polish(field)
    if not why:
        QToolTip.hideText()
    elif field.isVisible():
        QToolTip.showText(field.mapToGlobal(field.rect().bottomLeft()), why, field)


def plain(value: float) -> str:
    """At most four significant digits, without exponents for everyday sizes, with the decimal mark of the language."""
    if value and not 1e-4 <= abs(value) < 1e6:
        return local(f"{value:.3g}")
    digits = max(0, 3 - (math.floor(math.log10(abs(value))) if value else 0))
    shown = f"{value:.{min(digits, 6)}f}"
    return local(shown.rstrip("0").rstrip(".") if "." in shown else shown)
