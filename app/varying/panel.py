"""Variations over the model: a list of them, buttons that add and remove, and the settings of the chosen one.

A mode on screen that leaves one out says so beside the image (`app.document.variation.words_on_left_out`).
"""

from __future__ import annotations

from functools import partial
from typing import Any

from PySide6.QtWidgets import QComboBox, QMenu, QWidget

from app.commands.workbench import Workbench
from app.document.document import Project
from app.document.variation import Blend, Colours, Variation, VariedParameter
from app.varying.forms import VariationForm, ask_image, kind_of
from app.widgets import theme
from app.widgets.controls import ComboBox
from app.widgets.labels import BRDF_LABELS
from app.widgets.panels import Rows, enable, scroll_to, small_button, with_buttons
from engine.brdf.brdf import MODELS, brdf_from_text, brdf_to_text
from engine.core.params import Parameter, parameters

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
            document.change("Change what varies", gesture=f"varying {self.chosen}", variations=changed)
        if final:
            document.end_gesture()


def parameters_of(project: Project) -> tuple[Parameter, ...]:
    """The parameters of the BRDF of a project; a measurement has none."""
    material = project.material
    return () if material.measured is not None else parameters(brdf_from_text(material.brdf))
