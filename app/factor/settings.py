"""The left side of the Factor workspace: the source, the settings, and the buttons that start a run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QCheckBox, QComboBox, QCompleter, QHBoxLayout, QWidget

from app.document.factoring import (
    MAPS,
    METHOD_HINTS,
    METHODS,
    METRICS,
    PARAMETRISATIONS,
    PRESETS,
    SEARCHED,
    SHORT_METRICS,
    Factoring,
)
from app.factor.runs import FULL
from app.widgets.controls import ComboBox
from app.widgets.panels import Panel, Rows, button, enable, text
from app.widgets.param_form import ParamForm
from app.widgets.theme import STEP
from engine.brdf.brdf import MODELS, label_of
from engine.brdf.models.presets import PRESETS as PUBLISHED
from engine.factor.settings import FactorSettings

WIDTH = 264

SOURCE_HINT = "What the BRDF workspace compares, its files, models and published materials; type to find one"

SEPARABLE = {"side": "Size", "products": "Terms"}
HOMOMORPHIC = {"size": "Size", "textures": "Textures"}
SEARCH = {"restarts": "Restarts", "together": "Together"}
SAMPLES = {"samples": "Samples", "max_theta_deg": "Max. angle", "seed": "Seed"}


class FactorSettingsPanel(Panel):
    """`source_wanted(source)`, `edited(choices, final)`; the buttons ask for what their names say."""

    source_wanted = Signal(str)
    edited = Signal(object, bool)
    start_wanted = Signal()
    open_wanted = Signal()

    def __init__(self) -> None:
        super().__init__(WIDTH)
        self.choices = FactorSettings()
        self._make_source()
        self._make_method()
        self.start = button("Factor", "primary")
        self.start.clicked.connect(self.start_wanted)
        self.open = button("Open factors…", hint="A folder of factors that was exported here or by lightarc factor")
        self.open.clicked.connect(self.open_wanted)
        foot = QWidget()
        row = QHBoxLayout(foot)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(2 * STEP)
        row.addWidget(self.start, 1)
        row.addWidget(self.open, 1)
        self.finish(foot)

    def _make_source(self) -> None:
        rows = self.section("BRDF")
        self.source = ComboBox()
        self.source.setAccessibleName("BRDF to factor")
        self.source.setEditable(True)
        self.source.setInsertPolicy(QComboBox.InsertPolicy.NoInsert)
        self.source.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon)
        self.source.setMaxVisibleItems(24)
        completer = self.source.completer()
        assert completer is not None
        completer.setFilterMode(Qt.MatchFlag.MatchContains)
        completer.setCompletionMode(QCompleter.CompletionMode.PopupCompletion)
        self.source.activated.connect(self._source_chosen)
        line = self.source.lineEdit()
        assert line is not None
        line.editingFinished.connect(self._source_typed)
        rows.wide(self.source)

    def _make_method(self) -> None:
        rows = self.section("Factors")
        self.method = self._combo(rows, "method", "Method", METHODS, METHOD_HINTS["search"])
        for place, name in enumerate(METHODS):
            self.method.setItemData(place, METHOD_HINTS[name], Qt.ItemDataRole.ToolTipRole)
        self.about = text("", "secondary", wrap=True)
        rows.wide(self.about)
        self.parametrisation = self._combo(
            rows, "parametrisation", "Directions", PARAMETRISATIONS, "The two directions that index the textures"
        )
        self.separable = self._part({})
        self.map = self._combo(self.separable, "map", "Map", MAPS, "Map from the hemisphere to a square of texels")
        self.separable.wide(self._form(SEPARABLE))
        self.homomorphic = self._part(HOMOMORPHIC)
        self.reciprocal = QCheckBox("Enforced")
        self.reciprocal.clicked.connect(lambda on: self._on_edited(replace(self.choices, reciprocal=on), True))
        self.homomorphic.row(
            "Reciprocal",
            self.reciprocal,
            "Enforces reciprocity exactly: each texture is read for both orders of light and view",
        )
        self.search = self._part(SEARCH)
        self.measure = self._combo(
            self.search,
            "metric",
            "Minimises",
            {name: SHORT_METRICS[name] for name in METRICS if name in SEARCHED},
            "The error by which the search chooses projections. Logarithms count dark and bright alike, and the "
            "cosine-weighted RMS, which bright values dominate, can rise with them; Mean² weighs bright values most",
        )
        for place in range(self.measure.count()):
            words, _ = METRICS[self.measure.itemData(place)]
            self.measure.setItemData(place, words, Qt.ItemDataRole.ToolTipRole)
        self.preset = self._combo(
            self.search,
            "preset",
            "Preset",
            PRESETS,
            "Ours adds guesses, fixed projections and a final fit of all textures to what the thesis did",
        )
        rows.wide(self.separable)
        rows.wide(self.homomorphic)
        rows.wide(self.search)
        self.why_not = text("", "warning", wrap=True)
        rows.wide(self.why_not)
        samples = self.section("Samples")
        samples.wide(self._form(SAMPLES))

    def _part(self, labels: Mapping[str, str]) -> Rows:
        rows = Rows()
        if labels:
            rows.wide(self._form(labels))
        return rows

    def _form(self, labels: Mapping[str, str]) -> ParamForm:
        form = ParamForm(self.choices, labels)
        form.edited.connect(self._form_edited)
        self.forms: list[ParamForm] = [*getattr(self, "forms", []), form]
        return form

    def _combo(self, rows: Rows, name: str, label: str, choices: Mapping[str, str], hint: str) -> QComboBox:
        made = ComboBox()
        for value, words in choices.items():
            made.addItem(words, value)
        made.activated.connect(lambda _at: self._on_edited(replace(self.choices, **{name: made.currentData()}), True))
        rows.row(label, made, hint)
        made.setProperty("choice", name)
        return made

    def _form_edited(self, choices: FactorSettings, final: bool) -> None:
        self._on_edited(choices, final)

    def _on_edited(self, choices: FactorSettings, final: bool) -> None:
        self.edited.emit(choices, final)

    def show_sources(self, own: Sequence[tuple[str, str]], files: Sequence[Path], current: str, name: str) -> None:
        """The sources to choose from: what the project holds, files of the library, models, published materials."""
        wanted = [
            *own,
            *((f"file:{path}", path.name) for path in files),
            *((f"model:{model}", label_of(model)) for model in MODELS),
            *((f"model:{preset.text}", preset.name.replace("-", " ").capitalize()) for preset in PUBLISHED),
        ]
        if self.source.property("sources") != wanted:
            self.source.setProperty("sources", wanted)
            self.source.clear()
            for source, words in wanted:
                self.source.addItem(words, source)
            self.source.insertSeparator(len(own))
        place = self.source.findData(current)
        self.source.setCurrentIndex(place)
        words = self.source.itemText(place) if place >= 0 else name
        self.source.setEditText(words)
        line = self.source.lineEdit()
        if line is not None and not line.hasFocus():
            line.setCursorPosition(0)  # a long name is seen from its beginning
        self.source.setToolTip(f"{words}\n{SOURCE_HINT}")

    def _source_chosen(self, place: int) -> None:
        source = self.source.itemData(place)
        if source is not None:
            self.source_wanted.emit(source)

    def _source_typed(self) -> None:
        """Choose the first source whose name contains the typed text, or none."""
        words = self.source.currentText().strip().casefold()
        names = [(self.source.itemText(at), self.source.itemData(at)) for at in range(self.source.count())]
        found = [source for name, source in names if source is not None and words == name.casefold()]
        found = found or [source for name, source in names if source is not None and words and words in name.casefold()]
        if found and found[0] != self.source.currentData():
            self.source_wanted.emit(found[0])
        else:
            self.source.setEditText(self.source.itemText(self.source.currentIndex()))

    def show_factoring(self, factoring: Factoring, why_no_source: str) -> None:
        """Show the choices without emitting, and say why a run cannot begin."""
        choices = self.choices = factoring.choices
        for made in (self.method, self.parametrisation, self.map, self.measure, self.preset):
            made.setCurrentIndex(made.findData(getattr(choices, str(made.property("choice")))))
        self.reciprocal.setChecked(choices.reciprocal)
        for form in self.forms:
            form.show_instance(choices)
        self.about.setText(METHOD_HINTS[choices.method])
        self.separable.setVisible(choices.separable)
        self.homomorphic.setVisible(not choices.separable)
        self.search.setVisible(choices.method == "search")
        self.why_not.setText(choices.why_not)
        self.why_not.setVisible(bool(choices.why_not))
        full = FULL if factoring.free_identity is None else ""
        enable(self.start, why_no_source or choices.why_not or full, "Begin with these settings (Ctrl+Enter)")
        enable(self.open, full)
