"""The right side of the View workspace: the BRDF of the model, and the lookup in the shading map."""

from __future__ import annotations

import dataclasses
from typing import Any

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QCheckBox, QVBoxLayout, QWidget

from app.commands import brdf as commands_brdf
from app.commands.drawable import Drawable
from app.commands.workbench import Workbench
from app.document.comparison import Entry
from app.document.document import Look, Project
from app.widgets.controls import ComboBox
from app.widgets.labels import BRDF_LABELS
from app.widgets.number_field import plain
from app.widgets.panels import Rows, Segments
from app.widgets.param_form import ParamForm
from engine.brdf.brdf import MODELS, Brdf, brdf_from_text, brdf_to_text, label_of, model_name
from engine.core.params import parameters
from engine.scene.material import set_multiple_scattering
from engine.scene.scene import Scene

LOOKUPS = (
    ("radiance", "In the integral", "The slice is sampled at r = BRDF × cosine, as the method defines it"),
    ("texture", "Texture", "The brightest slice, used as a texture"),
    ("outgoing", "By outgoing radiance", "The slice is sampled at the outgoing radiance"),
    ("angle", "By angle", "The slice is sampled at the angle of the light alone"),
)


#: Parameter of a BRDF that maps have as well.
AGAIN = "multiple_scattering"


class BrdfPanel(Rows):
    """`brdf` can be drawn at once; `ready` follows when a measurement has become a table."""

    ready = Signal()

    def __init__(self, bench: Workbench) -> None:
        super().__init__("BRDF")
        self.bench = bench
        self.brdf: Brdf | None = None
        self.form: ParamForm | None = None
        self.drawable = Drawable(bench.jobs)
        self.drawable.ready.connect(self.ready)
        self.choice = ComboBox()
        self.choice.activated.connect(self._on_chosen)
        self.row("Model", self.choice, "A model, or a BRDF from the BRDF workspace")
        self.forms = QVBoxLayout()
        self.forms.setContentsMargins(0, 0, 0, 0)
        holder = QWidget()
        holder.setLayout(self.forms)
        self.wide(holder)
        self.again = QCheckBox("Multiple scattering")
        self.again.setToolTip("Add the light that rough facets of the PBR maps scatter more than once")
        self.again.clicked.connect(self._set_multiple_scattering)
        self.wide(self.again)

    @property
    def is_measured(self) -> bool:
        return self.bench.document.project.material.measured is not None

    def show_project(self, project: Project) -> None:
        """The choices of BRDF, and the parameters of the chosen model; a measurement has none."""
        measured = project.material.measured
        brdf = brdf_from_text(project.material.brdf)
        self.choice.clear()
        for name in MODELS:
            self.choice.addItem(label_of(name), name)
        for entry in project.comparison.entries:
            self.choice.addItem(entry.name, entry)
        if measured is not None:
            is_table = not commands_brdf.has_shader(measured)
            self.choice.addItem(f"{measured.name} ({'measured' if is_table else 'factors'})", measured)
        current = measured if measured is not None else model_name(brdf)
        places = range(self.choice.count())
        self.choice.setCurrentIndex(next(at for at in places if self.choice.itemData(at) == current))
        self.brdf = brdf if measured is None else self.drawable.of(measured) or brdf
        if self.form is None or type(self.form.instance) is not type(brdf):
            if self.form is not None:
                self.form.hide()
                self.form.deleteLater()
            self.form = ParamForm(brdf, {p.name: BRDF_LABELS.get(p.name, p.label) for p in parameters(brdf)})
            self.form.edited.connect(self._on_edited)
            self.forms.addWidget(self.form)
            self.form.follow(self.choice)
        self.form.show_instance(brdf)
        self.form.setVisible(measured is None)
        is_of_maps = project.material.pbr is not None and project.material.pbr.openpbr is None
        self.again.setVisible(is_of_maps)
        if AGAIN in self.form.editors:  # the BRDF at the mean of maps follows these
            self.form.show_row(self.form.editors[AGAIN], not is_of_maps)
        self.again.setChecked(project.material.pbr is not None and project.material.pbr.multiple_scattering)

    def _set_multiple_scattering(self, on: bool) -> None:
        document = self.bench.document
        document.change("Multiple scattering", material=set_multiple_scattering(document.project.material, on))

    def _on_chosen(self, _index: int) -> None:
        name = self.choice.currentData()
        if isinstance(name, Entry):
            self.show_project(self.bench.document.project)
            commands_brdf.use(self.bench, name)
        elif isinstance(name, str) and (self.is_measured or type(self.brdf) is not MODELS[name]):
            self.set_brdf(MODELS[name](), f"BRDF {label_of(name)}", "")

    def _on_edited(self, brdf: Brdf, final: bool) -> None:
        self.set_brdf(brdf, "Change BRDF", "brdf")
        if final:
            self.bench.document.end_gesture()

    def set_brdf(self, brdf: Brdf, words: str, gesture: str) -> None:
        """Give the material the model `brdf`, as a step called `words`."""
        words_of_brdf = brdf_to_text(brdf)
        document = self.bench.document
        material = document.project.material
        if words_of_brdf != material.brdf or material.measured is not None:
            material = dataclasses.replace(material, brdf=words_of_brdf, measured=None)
            document.change(words, gesture=gesture, material=material)


class LookupPanel(Rows):
    """Settings of the lookup in the shading map. `set_look(words, look)` asks for a change."""

    set_look = Signal(str, object)

    def __init__(self) -> None:
        super().__init__("Sampling")
        self.look = Look()
        self.source = Segments(
            (
                ("slices", "Slices", "Sample the slices of the shading map"),
                ("power-law", "Power law", "Sample the compressed pair, six numbers per texel"),
            ),
            {"power-law": "P. law"},
        )
        self.source.chosen.connect(lambda value: self._set("Show from", source=value))
        self.row("Source", self.source)
        self.method = ComboBox()
        for value, words, hint in LOOKUPS:
            self.method.addItem(words, value)
            self.method.setItemData(self.method.count() - 1, hint, Qt.ItemDataRole.ToolTipRole)
        self.method.activated.connect(lambda _index: self._set("Sampling", lookup=self.method.currentData()))
        self.row("Method", self.method, "The four ways of sampling of Kautz et al. 2004, figure 6")
        self.above = Segments(
            (
                ("clamp", "Clamp", "Brighter than the brightest photograph: that photograph"),
                ("scale", "Scale", "Brighter than the brightest photograph: scaled up"),
            )
        )
        self.above.chosen.connect(lambda value: self._set("Above the largest r", above=value))
        self.row("Above", self.above, "Sampling above the largest r of the capture")
        self.sigma = self.figure("Scale σ", "Automatic: model and photographs agree on the capture's own lights")
        self.r_max = self.figure("Largest r")

    def _set(self, words: str, **parts: Any) -> None:
        self.set_look.emit(words, dataclasses.replace(self.look, **parts))

    def show_project(self, project: Project) -> None:
        """The choices of the project, and which of them there are."""
        look, material = project.look, project.material
        self.look = look
        self.method.setCurrentIndex(max(0, self.method.findData(look.lookup)))
        self.above.choose(look.above)
        self.source.choose(look.source)
        planes = material.directional is not None
        self.show_row(self.source, not planes)
        nothing = "A directional map is shown by its planes" if planes else "Build or open a material first"
        nothing = nothing if material.pbr is None else "PBR maps have a BRDF at each texel and no slices"
        self.source.disable("slices", "" if material.shading_map is not None else nothing)
        self.source.disable("power-law", "" if material.power_law is not None else nothing)

    def show_scene(self, project: Project, scene: Scene) -> None:
        """Show the figures of the lookup."""
        auto = f"{plain(scene.sigma)} auto" if project.material.sigma is None else plain(scene.sigma)
        self.sigma.setText(auto)
        self.r_max.setText(plain(scene.shading.r_max) if scene.shading is not None else "–")
