"""A field for one number: typed with a unit or as an expression, dragged, or reset with Ctrl+click.

What is not a number inside the range is refused at the field, and the previous value stays.
"""

from __future__ import annotations

import ast
import math
import operator
from collections.abc import Callable

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QKeyEvent, QMouseEvent
from PySide6.QtWidgets import QLineEdit

from app.widgets.theme import role
from engine.core.errors import UsageError

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


class NumberField(QLineEdit):
    """Shows `value` with its unit. `edited(value, final)`: `final` is False while a drag goes on."""

    edited = Signal(float, bool)

    def __init__(
        self, value: float, low: float, high: float, *, unit: str = "", default: float | None = None, log: bool = False
    ) -> None:
        super().__init__()
        self.value, self.low, self.high, self.unit, self.log = value, low, high, unit, log
        self.default = value if default is None else default
        self._pressed_at: float | None = None
        self._from = value
        self._dragged = False
        role(self, "number")
        self.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
        self.setCursor(Qt.CursorShape.SizeHorCursor)
        self.editingFinished.connect(self._typed)
        self.show_value(value)

    def show_value(self, value: float) -> None:
        """Show `value` without emitting; a field that is being typed in is left alone."""
        self.value = value
        if not (self.hasFocus() and self.isModified()):
            self.setText(f"{plain(value)}{' ' * bool(self.unit and self.unit != '°')}{self.unit}")

    def _typed(self) -> None:
        if not self.isModified():
            return
        try:
            value = number_from_text(self.text(), self.unit)
        except UsageError:
            value = math.nan
        self.setModified(False)
        if self.low <= value <= self.high:
            self._set(value, final=True)
        else:
            self.show_value(self.value)

    def _set(self, value: float, *, final: bool) -> None:
        changed = value != self.value
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
            self._set(self._moved(10 if event.key() == Qt.Key.Key_Up else -10), final=True)
            return
        super().keyPressEvent(event)

    def mousePressEvent(self, event: QMouseEvent) -> None:
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
            self._set(self._moved(distance), final=False)

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

    def _moved(self, pixels: float) -> float:
        if self.log and self._from > 0:
            value = self._from * math.exp(pixels * 0.01)
        else:
            value = self._from + pixels * (min(self.high, 1e3) - max(self.low, -1e3)) / 400.0
        if not self._dragged:
            self._from = min(max(value, self.low), self.high)
        return min(max(value, self.low), self.high)


def plain(value: float) -> str:
    """At most four significant digits, without exponents for everyday sizes."""
    if value and not 1e-4 <= abs(value) < 1e6:
        return f"{value:.3g}"
    digits = max(0, 3 - (math.floor(math.log10(abs(value))) if value else 0))
    shown = f"{value:.{min(digits, 6)}f}"
    return shown.rstrip("0").rstrip(".") if "." in shown else shown
