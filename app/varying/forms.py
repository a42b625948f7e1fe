"""The settings of one variation: of a parameter, of a BRDF that is mixed in, of colours.

Each form is for variations of one kind: with the same parameter, or the same model mixed in.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QFileDialog, QWidget

from app.document.variation import Blend, Colours, Variation, VariedParameter
from app.widgets.controls import ComboBox
from app.widgets.labels import BRDF_LABELS
from app.widgets.panels import Rows
from app.widgets.param_form import NumberEditor, ParamForm
from engine.brdf.brdf import MODELS, brdf_from_text, brdf_to_text, label_of, model_name
from engine.capture.photograph.kinds import photograph_suffixes
from engine.core.params import Parameter, parameters
from engine.storage.readers import dialog_filter

AXES = {"x": "Left to right (x)", "y": "Bottom to top (y)", "z": "Back to front (z)"}

#: The value of a menu that asks for a file.
OPEN = "open"


def ask_image(parent: QWidget) -> Path | None:
    """The image that a user chooses; None where they choose none."""
    images = dialog_filter("Images", sorted(photograph_suffixes()))
    path, _ = QFileDialog.getOpenFileName(parent, "Open an image", "", images)
    return Path(path) if path else None


def ask_brdf(parent: QWidget) -> Path | None:
    """The file of a BRDF that a user chooses; None where they choose none."""
    path, _ = QFileDialog.getOpenFileName(parent, "Open a BRDF", "", "BRDFs (*)")
    return Path(path) if path else None


class VariationForm(Rows):
    """Edits one variation. `edited(variation, final)`: `final` is False while dragging.

    `stops` are its widgets in the order of the Tab key.
    """

    edited = Signal(object, bool)

    def __init__(self, variation: Variation, parameter: Parameter | None) -> None:
        """`parameter` is the one that varies; None where the BRDF has none of that name, and for other kinds."""
        super().__init__()
        self.variation = variation
        self.stops: list[QWidget] = []
        self.editors: dict[str, NumberEditor] = {}
        self.model: ParamForm | None = None
        self.menus: dict[str, ComboBox] = {}
        if parameter is not None:
            self._add_ends(parameter)
        if isinstance(variation, Blend):
            self._add_menu("brdf", "Mixed in", "The other BRDF; the one above has the rest of the weight")
            self._add_model(variation)
        if isinstance(variation, Colours):
            self._add_menu("picture", "Image", "Multiplies the radiance, at the texture coordinates of the model")
        else:
            self._add_menu("source", "Along", "Across the box about the model, or by an image at its coordinates")
        self.show_variation(variation)

    def _add_ends(self, parameter: Parameter) -> None:
        """Two values of a parameter; those of a colour are grey."""
        grey = max(parameter.default) if isinstance(parameter.default, tuple) else parameter.default
        for part, label in (("start", "From"), ("stop", "To")):
            editor = NumberEditor(dataclasses.replace(parameter, name=label, default=grey))
            editor.edited.connect(lambda value, final, part=part: self._change(final, **{part: value}))
            self.row(label, editor, parameter.doc)
            self.editors[part] = editor
            self.stops += editor.stops

    def _add_menu(self, part: str, label: str, hint: str) -> None:
        menu = ComboBox()
        menu.activated.connect(lambda _index: self._on_chosen(part))
        self.row(label, menu, hint)
        self.menus[part] = menu
        self.stops.append(menu)

    def _add_model(self, variation: Blend) -> None:
        """The parameters of the model that is mixed in; a file has none."""
        if isinstance(variation.brdf, str):
            own = brdf_from_text(variation.brdf)
            self.model = ParamForm(own, {each.name: BRDF_LABELS.get(each.name, each.label) for each in parameters(own)})
            self.model.edited.connect(lambda brdf, final: self._change(final, brdf=brdf_to_text(brdf)))
            self.wide(self.model)
            self.stops += [stop for editor in self.model.editors.values() for stop in editor.stops]

    def show_variation(self, variation: Variation) -> None:
        """Show the values of a variation of the same kind, without emitting."""
        self.variation = variation
        for part, editor in self.editors.items():
            editor.show_value(getattr(variation, part))
        if isinstance(variation, Blend):
            own = None if isinstance(variation.brdf, Path) else brdf_from_text(variation.brdf)
            named = model_name(own) if own is not None else None
            _fill(self.menus["brdf"], {name: label_of(name) for name in MODELS}, named, variation.brdf, "Open a file…")
            if self.model is not None and own is not None:
                self.model.show_instance(own)
        if isinstance(variation, Colours):
            _fill(self.menus["picture"], {}, None, variation.image, "Another image…")
        else:
            source = variation.source
            _fill(self.menus["source"], AXES, None if isinstance(source, Path) else source, source, "By an image…")

    def _on_chosen(self, part: str) -> None:
        value: Any = self.menus[part].currentData()
        if value == OPEN:
            value = (ask_brdf if part == "brdf" else ask_image)(self)
        elif part == "brdf" and isinstance(value, str):
            own = brdf_from_text(str(self.variation.brdf)) if self.model is not None else None  # type: ignore[union-attr]
            is_other = own is None or model_name(own) != value
            value = brdf_to_text(MODELS[value]()) if is_other else self.variation.brdf  # type: ignore[union-attr]
        self.show_variation(self.variation)
        if value is not None:
            self._change(True, **{part: value})

    def _change(self, final: bool, **parts: Any) -> None:
        self.variation = dataclasses.replace(self.variation, **parts)
        self.edited.emit(self.variation, final)


def _fill(menu: ComboBox, known: Mapping[str, str], chosen: str | None, given: Any, opening: str) -> None:
    """Show what there is to choose, and what is chosen: one of the `known`, or the file `given`."""
    menu.clear()
    for value, words in known.items():
        menu.addItem(words, value)
    if chosen is None:
        menu.addItem(given.name, given)
    menu.setCurrentIndex(menu.count() - 1 if chosen is None else menu.findData(chosen))
    menu.setToolTip(menu.currentText())
    menu.addItem(opening, OPEN)


def kind_of(variation: Variation | None, parameter: Parameter | None) -> tuple[Any, ...]:
    """Equal for variations that one form serves."""
    model = None
    if isinstance(variation, Blend) and isinstance(variation.brdf, str):
        model = model_name(brdf_from_text(variation.brdf))
    name = variation.parameter if isinstance(variation, VariedParameter) else None
    return type(variation), name, parameter, model
