"""Sliders for the parameters that a BRDF written in GLSL declares; each value becomes the default in its text."""

from __future__ import annotations

from typing import Any

from PySide6.QtCore import Signal, SignalInstance
from PySide6.QtWidgets import QCheckBox

from app.commands.workbench import Workbench
from app.document.comparison import Entry
from app.jobs.newest import Latest
from app.widgets.panels import Rows
from app.widgets.param_form import ColourEditor, NumberEditor
from engine.brdf.written import Declared, WrittenBrdf, with_value, write
from engine.core.errors import FileError, MissingCapability
from engine.core.params import Colour, Parameter
from engine.core.steps import Step, Steps


class WrittenForm(Rows):
    """One row for each parameter of an entry. `edited(brdf, final)` follows when a value has been evaluated."""

    edited = Signal(object, bool)

    def __init__(self, bench: Workbench, edited: SignalInstance) -> None:
        super().__init__()
        self.editors: dict[str, NumberEditor | ColourEditor | QCheckBox] = {}
        self.latest = Latest(bench.jobs, "Evaluating GLSL")
        self.edited.connect(edited)
        self._identity = -1
        self._text = self._name = ""
        self._declared: list[tuple[Any, ...]] = []

    def show_entry(self, entry: Entry | None) -> None:
        """Show the parameters of an entry that is written in GLSL; nothing for any other."""
        brdf = entry.brdf if entry is not None and isinstance(entry.brdf, WrittenBrdf) else None
        self.setVisible(brdf is not None)
        identity = entry.identity if entry is not None and brdf is not None else -1
        if identity == self._identity and (self.latest.busy or brdf is None or brdf.text == self._text):
            return
        self.latest.drop()
        self._identity = identity
        if brdf is None:
            return
        self._text, self._name = brdf.text, brdf.name
        parameters = brdf.source.parameters
        declared: list[tuple[Any, ...]] = [(each.kind, each.name, each.low, each.high) for each in parameters]
        if declared != self._declared:
            self._declared = declared
            self._make(parameters)
        for each in parameters:
            editor = self.editors[each.name]
            editor.blockSignals(True)
            if isinstance(editor, QCheckBox):
                editor.setChecked(bool(each.value))
            else:
                editor.show_value(each.value)  # type: ignore[arg-type]  # the editor is that of the kind
            editor.blockSignals(False)

    def _make(self, parameters: tuple[Declared, ...]) -> None:
        while self.grid.count():
            item = self.grid.takeAt(0)
            old = item.widget() if item is not None else None
            if old is not None:
                old.hide()
                old.deleteLater()
        self.editors = {}
        for each in parameters:
            editor = _editor(each)
            if isinstance(editor, QCheckBox):
                editor.toggled.connect(lambda on, name=each.name: self._on_edited(name, on, True))
            else:
                editor.edited.connect(lambda value, final, name=each.name: self._on_edited(name, value, final))
            self.editors[each.name] = editor
            self.row(each.name, editor, f"Parameter {each.name} of the text")

    def _on_edited(self, name: str, value: float | bool | Colour, final: bool) -> None:
        text = self._text = with_value(self._text, name, value)
        self.latest.ask(lambda: _evaluate(text, self._name), lambda brdf: self.edited.emit(brdf, final))


def _editor(declared: Declared) -> NumberEditor | ColourEditor | QCheckBox:
    if declared.kind == "bool":
        box = QCheckBox()
        box.setAccessibleName(declared.name)
        return box
    value: Any = declared.value
    low, high = (declared.low, declared.high) if declared.kind == "float" else (min(0.0, *value), max(1.0, *value))
    parameter = Parameter(declared.name, value, low, high, (low, high), "", declared.name, log=False)
    return ColourEditor(parameter) if parameter.is_colour else NumberEditor(parameter)


def _evaluate(text: str, name: str) -> Steps[WrittenBrdf]:
    yield Step(0.0, "compiling")
    return write(text, name)


def compile_text(text: str, name: str) -> Steps[WrittenBrdf | FileError | MissingCapability]:
    """The BRDF of a text, or what is wrong with it: whoever types is told beside the text, not in a dialog."""
    yield Step(0.0, "compiling")
    try:
        return write(text, name)
    except (FileError, MissingCapability) as error:
        return error
