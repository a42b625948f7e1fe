"""Variations over the model: a list of them, buttons that add and remove, and the settings of the chosen one.

A mode on screen that leaves one out says so beside the image (`app.document.variation.words_on_left_out`).

The settings of one variation: of a parameter, of a BRDF that is mixed in, of colours.

Each form is for variations of one kind: with the same parameter, or the same model mixed in.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QComboBox, QFileDialog, QMenu, QWidget

from app.commands.workbench import Workbench
from app.document.document import Project
from app.document.variation import Blend, Colours, Variation, VariedParameter
from app.widgets import theme
from app.widgets.controls import ComboBox
from app.widgets.labels import BRDF_LABELS
from app.widgets.panels import Rows, enable, scroll_to, small_button, with_buttons
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


#: The BRDF that is mixed in at first, and the part of its everyday range that a parameter goes through at first.
MIXED_IN, SHARE = "phong", (0.2, 0.8)

ABOUT = "Parameters that vary across the surface. Spherical harmonics and Gaussians vary parameters; wavelets mix BRDFs"


class VaryingPanel(Rows):
    """Shows and changes the variations of a project."""

    def __init__(self, bench: Workbench) -> None:
        super().__init__("Spatial variation")
        self.bench = bench
        self.chosen = 0
        self.list = ComboBox()
        self.list.activated.connect(self._choose)
        self.add = small_button("add", "Add a spatially varying parameter")
        self.add.clicked.connect(self._offer)
        self.menu = QMenu(self)
        self.remove = small_button("remove", "Let this vary no longer")
        self.remove.clicked.connect(self._remove)
        self.wide(with_buttons(self.list, self.add, self.remove))
        self.list.setToolTip(ABOUT)
        self.list.setAccessibleName("Varies")
        self.list.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon)
        self.list.setMinimumContentsLength(2)
        self.form: VariationForm | None = None
        self._kind: Any = None

    def apply_theme(self) -> None:
        """Draw the icons in the colour of the current theme."""
        self.add.setIcon(theme.icon("add"))
        self.remove.setIcon(theme.icon("remove"))

    @property
    def variations(self) -> tuple[Variation, ...]:
        return self.bench.document.project.variations

    def show_project(self, project: Project) -> None:
        """The variations of the project, and the settings of the chosen one."""
        variations = project.variations
        self.chosen = min(self.chosen, max(0, len(variations) - 1))
        self.list.clear()
        for each in variations:
            self.list.addItem(str(each))
        if not variations:
            self.list.addItem("Nothing")
        self.list.setCurrentIndex(self.chosen)
        nothing = "" if variations else "No spatially varying parameter yet"
        enable(self.list, nothing)
        enable(self.remove, nothing)
        self._show_form(project, variations[self.chosen] if variations else None)

    def _choose(self, place: int) -> None:
        self.chosen = place
        self.show_project(self.bench.document.project)

    def _show_form(self, project: Project, variation: Variation | None) -> None:
        """The settings of a variation, in a form that is made anew for one of another kind."""
        name = variation.parameter if isinstance(variation, VariedParameter) else ""
        parameter = next((each for each in parameters_of(project) if each.name == name), None)
        kind = kind_of(variation, parameter)
        if kind != self._kind:
            if self.form is not None:
                self.form.hide()
                self.form.deleteLater()
            self._kind, self.form = kind, None
            if variation is not None:
                self.form = VariationForm(variation, parameter)
                self.form.edited.connect(self._on_edited)
                self.wide(self.form)
                before: QWidget = self.remove
                for stop in self.form.stops:
                    QWidget.setTabOrder(before, stop)
                    before = stop
        elif self.form is not None and variation is not None:
            self.form.show_variation(variation)

    def _offer(self) -> None:
        """Open the menu below its button."""
        self.fill_menu()
        self.menu.popup(self.add.mapToGlobal(self.add.rect().bottomLeft()))

    def fill_menu(self) -> None:
        """Offer what can vary: the parameters that do not yet, another BRDF, and colours where there are none."""
        varied = {each.parameter for each in self.variations if isinstance(each, VariedParameter)}
        self.menu.clear()
        for each in parameters_of(self.bench.document.project):
            if each.name not in varied:
                label = BRDF_LABELS.get(each.name, each.label)
                self.menu.addAction(label, partial(self._add_parameter, each))
        self.menu.addSeparator()
        self.menu.addAction("Mix in another BRDF", self._add_blend)
        if not any(isinstance(each, Colours) for each in self.variations):
            self.menu.addAction("Colours of an image…", self._add_colours)

    def _add_parameter(self, parameter: Parameter) -> None:
        """Let a parameter go through most of its everyday range, from the bottom to the top."""
        low, high = parameter.slider
        start, stop = (float(f"{low + share * (high - low):.3g}") for share in SHARE)
        self._put("Let a parameter vary", VariedParameter(parameter.name, start, stop))

    def _add_blend(self) -> None:
        self._put("Mix in a BRDF", Blend(brdf_to_text(MODELS[MIXED_IN]())))

    def _add_colours(self) -> None:
        path = ask_image(self)
        if path is not None:
            self._put("Colours of an image", Colours(path))

    def _put(self, words: str, new: Variation) -> None:
        self.chosen = len(self.variations)
        self.bench.document.change(words, variations=(*self.variations, new))
        scroll_to(self)

    def _remove(self) -> None:
        kept = tuple(each for place, each in enumerate(self.variations) if place != self.chosen)
        self.bench.document.change("Let this vary no longer", variations=kept)

    def _on_edited(self, variation: Variation, final: bool) -> None:
        """The chosen variation is another one; a drag that goes on is one step."""
        document, own = self.bench.document, self.variations
        if variation != own[self.chosen]:
            changed = tuple(variation if place == self.chosen else each for place, each in enumerate(own))
            document.change("Change spatial variation", gesture=f"varying {self.chosen}", variations=changed)
        if final:
            document.end_gesture()


def parameters_of(project: Project) -> tuple[Parameter, ...]:
    """The parameters of the BRDF of a project; a measurement has none."""
    material = project.material
    return () if material.measured is not None else parameters(brdf_from_text(material.brdf))
