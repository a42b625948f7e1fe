"""The right side of the BRDF workspace: the compared BRDFs, parameters or facts of the current one, fit, and use."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import (
    QAbstractItemView,
    QHBoxLayout,
    QLabel,
    QListWidget,
    QListWidgetItem,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from app.brdf.fit_section import FitSection
from app.brdf.plots import marker_icon
from app.brdf.written_form import WrittenForm
from app.commands.brdf import is_model
from app.commands.brdf_figures import Facts
from app.commands.workbench import Workbench
from app.document.comparison import Comparison, Entry
from app.widgets import theme as icons
from app.widgets.labels import BRDF_LABELS
from app.widgets.panels import Panel, button, enable, text
from app.widgets.param_form import ParamForm
from app.widgets.theme import ROW, STEP, role
from engine.brdf.brdf import label_of, model_name
from engine.brdf.models.model import Model
from engine.brdf.readers.read import is_measured
from engine.brdf.written import WrittenBrdf
from engine.core.figure_text import number, percent
from engine.core.params import parameters

IDENTITY = Qt.ItemDataRole.UserRole


class Inspector(Panel):
    """Signals request the action in their names; `edited(brdf, final)`: new parameters of the current entry."""

    current_wanted = Signal(int)
    visible_wanted = Signal(int, bool)
    remove_wanted = Signal()
    edited = Signal(object, bool)
    use_wanted = Signal()
    copy_wanted = Signal()
    save_wanted = Signal()
    text_wanted = Signal()

    def __init__(self, bench: Workbench) -> None:
        super().__init__()
        self.entry: Entry | None = None
        self._filling = False
        self._make_list()
        self._make_about(bench)
        self.fit = FitSection(bench)
        self.column.addSpacing(2 * STEP)
        self.column.addWidget(self.fit)
        self.use = button("Use for the material", "primary")
        self.use.clicked.connect(self.use_wanted)
        self.finish(self.use)

    def _make_list(self) -> None:
        rows = self.section("Compared")
        self.list = EntryList()
        self.list.setAccessibleName("Compared BRDFs")
        self.list.setIconSize(QSize(22, 16))
        self.list.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        self.list.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.list.setToolTip("Tick the entries to show (Space); Del removes one")
        self.list.currentItemChanged.connect(self._row_changed)
        self.list.itemChanged.connect(self._on_ticked)
        rows.wide(self.list)
        self.list.remove_wanted.connect(self.remove_wanted)
        self.remove = QToolButton()
        self.remove.setIconSize(QSize(16, 16))
        self.remove.setAccessibleName("Remove from the list")
        self.remove.clicked.connect(self.remove_wanted)
        self.copy = button("Copy as text")
        self.copy.clicked.connect(self.copy_wanted)
        self.save = button("Save table…")
        self.save.clicked.connect(self.save_wanted)
        holder = QWidget()
        row = QHBoxLayout(holder)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(STEP)
        row.addWidget(self.copy, 1)
        row.addWidget(self.save, 1)
        row.addWidget(self.remove)
        rows.wide(holder)

    def _make_about(self, bench: Workbench) -> None:
        self.about = self.section("BRDF")
        self.kind = self.about.figure("Kind")
        self.samples = self.about.figure("Samples", "Measured directions, and the number of unusable ones")
        self.forms = QVBoxLayout()
        self.forms.setContentsMargins(0, STEP, 0, STEP)
        holder = QWidget()
        holder.setLayout(self.forms)
        self.about.wide(holder)
        self.written = WrittenForm(bench, self.edited)
        self.about.wide(self.written)
        self.edit_text = button("Edit text…", hint="Its GLSL in a window of its own; the views follow what is typed")
        self.edit_text.clicked.connect(self.text_wanted)
        self.about.wide(self.edit_text)
        self.holder = holder
        self.form: ParamForm | None = None
        self.largest = self.about.figure(
            "Max. albedo", "Largest reflected share of light in any channel, and its viewing angle"
        )
        self.reciprocity = self.about.figure(
            "Reciprocity", "RMS change if light and viewer are exchanged, relative to the RMS of all values"
        )
        self.condition = self.about.figure("Condition", "Condition number of the smoothing of scattered samples")
        self.left_out = self.about.figure("Held out", "RMS error at samples held out of the fit, relative to the RMS")
        self.fitted = self.about.figure("Fit error", "Before and after the fit of this model")
        self.warnings = text("", "warning", wrap=True)
        self.about.wide(self.warnings)

    def show_comparison(self, comparison: Comparison, current: Entry | None) -> None:
        """Show the list, with `current` chosen, and the rows about it."""
        self._filling = True
        self.list.setFixedHeight(ROW * min(6, max(2, len(comparison.entries))) + 2)
        while self.list.count() > len(comparison.entries):
            self.list.takeItem(self.list.count() - 1)
        for place, entry in enumerate(comparison.entries):
            item = self.list.item(place)
            if item is None:
                item = QListWidgetItem()
                item.setSizeHint(QSize(0, ROW))
                self.list.addItem(item)
            if item.data(IDENTITY) != entry.identity:
                item.setData(IDENTITY, entry.identity)
                item.setIcon(marker_icon(entry.colour, entry.marker))
            item.setText(entry.name)
            item.setToolTip(f"{entry.name}\n{entry.path or 'Analytic model'}")
            item.setCheckState(Qt.CheckState.Checked if entry.visible else Qt.CheckState.Unchecked)
            if entry is current:
                self.list.setCurrentItem(item)
        if current is None:
            self.list.setCurrentRow(-1)
        self._filling = False
        self._show_entry(current)
        self.fit.show_entry(current, comparison)

    def _show_entry(self, entry: Entry | None) -> None:
        new = entry is None or self.entry is None or entry.brdf != self.entry.brdf
        self.entry = entry
        nothing = "" if entry is not None else "Add a BRDF to the list first"
        model = entry is not None and is_model(entry.brdf)
        is_written = entry is not None and isinstance(entry.brdf, WrittenBrdf)
        enable(self.remove, nothing, "Remove it from the list (Del)")
        enable(
            self.copy,
            nothing or ("" if model or is_written else "A measurement has no formula; fit a model first"),
            "Its text in GLSL" if is_written else "The text that names it on the command line",
        )
        enable(self.save, nothing, "As a MERL .binary or as a Lightarc table (.exr)")
        enable(self.use, nothing, "Make it the BRDF of the View workspace and of the exported bundle")
        if entry is None:
            self.kind.setText("–")
        elif is_model(entry.brdf):
            self.kind.setText(label_of(model_name(entry.brdf)))
        elif is_measured(entry.brdf):
            self.kind.setText(entry.brdf.kind)
        self._show_form(entry.brdf if entry is not None and is_model(entry.brdf) else None)
        self._show_measured(entry if not model else None)
        self.written.show_entry(entry)
        self.edit_text.setVisible(is_written)
        fitted = entry.fitted if entry is not None else None
        self._row(self.fitted, f"{percent(fitted.before, 3)} → {percent(fitted.after, 3)}" if fitted else None)
        if new:
            self.show_facts(None)

    def _show_form(self, brdf: Model | None) -> None:
        if self.form is not None and type(self.form.instance) is not type(brdf):
            self.form.hide()
            self.form.deleteLater()
            self.form = None
        self.holder.setVisible(brdf is not None)
        if brdf is None:
            return
        if self.form is None:
            self.form = ParamForm(brdf, {p.name: BRDF_LABELS.get(p.name, p.label) for p in parameters(brdf)})
            self.form.edited.connect(self.edited)
            self.forms.addWidget(self.form)
            self.form.follow(self.remove)
        self.form.show_instance(brdf)

    def _show_measured(self, entry: Entry | None) -> None:
        brdf = entry.brdf if entry is not None and is_measured(entry.brdf) else None
        samples = None
        if brdf is not None and brdf.samples:
            samples = _count(brdf.samples)
            samples += f", {_count(brdf.invalid_samples)} unusable" if brdf.invalid_samples else ""
        self._row(self.samples, samples)
        condition, left_out = getattr(brdf, "condition_number", None), getattr(brdf, "leave_one_out", None)
        self._row(self.condition, None if condition is None else number(condition))
        self._row(self.left_out, None if left_out is None else percent(left_out, 3))
        warnings = brdf.health.warnings if brdf is not None else []
        self.warnings.setText("\n".join(warnings))
        self.warnings.setVisible(bool(warnings))

    def show_facts(self, facts: Facts | None) -> None:
        """Show the computed facts of the current entry; None while they are computed."""
        if facts is None:
            self.largest.setText("–")
            role(self.largest, "")
            self.reciprocity.setText("–")
            return
        largest = facts.largest
        self.largest.setText(f"{number(max(largest.albedo), 3)} at {number(float(np.degrees(largest.theta)), 3)}°")
        role(self.largest, "warning" if max(largest.albedo) > 1.005 else "")
        self.reciprocity.setText(reciprocity_text(facts.reciprocity.rms))

    def _row(self, figure: QLabel, words: str | None) -> None:
        """Show a figure and its caption, or hide both."""
        figure.setText(words or "–")
        place = self.about.grid.getItemPosition(self.about.grid.indexOf(figure))[0]  # type: ignore[index]
        beside = self.about.grid.itemAtPosition(place, 0)
        caption = beside.widget() if beside is not None else None
        assert caption is not None
        for widget in (caption, figure):
            widget.setVisible(words is not None)
        self.about.grid.setRowMinimumHeight(place, ROW if words is not None else 0)

    def _row_changed(self, item: QListWidgetItem | None, _before: QListWidgetItem | None) -> None:
        if not self._filling and item is not None:
            self.current_wanted.emit(item.data(IDENTITY))

    def _on_ticked(self, item: QListWidgetItem) -> None:
        if not self._filling:
            self.visible_wanted.emit(item.data(IDENTITY), item.checkState() == Qt.CheckState.Checked)

    def apply_theme(self) -> None:
        """Draw the markers against the current theme."""
        self._filling = True
        self.list.clear()
        self._filling = False
        self.remove.setIcon(icons.icon("cancel"))
        self.fit.plot.apply_theme()


class EntryList(QListWidget):
    """A list whose current row Del asks to remove."""

    remove_wanted = Signal()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.key() == Qt.Key.Key_Delete:
            self.remove_wanted.emit()
        else:
            super().keyPressEvent(event)


def reciprocity_text(rms: float) -> str:
    """The reciprocity of a BRDF that changes by `rms`: 'exact', 'holds within 0.01 %' or 'off by 3.2 %'."""
    if rms < 1e-12:
        return "exact"
    return "holds within 0.01 %" if rms < 1e-4 else f"off by {percent(rms)}"


def _count(number: int) -> str:
    return f"{number:,}".replace(",", " ")
