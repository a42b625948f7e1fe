"""The Effects dock: needed effects, the error and saving of leaving each out, and the plan within a budget."""

from __future__ import annotations

import dataclasses
from itertools import pairwise
from typing import TYPE_CHECKING

from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtGui import QColor, QResizeEvent
from PySide6.QtWidgets import (
    QAbstractItemView,
    QComboBox,
    QDockWidget,
    QHBoxLayout,
    QHeaderView,
    QLineEdit,
    QTableWidget,
    QTableWidgetItem,
    QWidget,
)

from app.commands.workbench import Workbench
from app.document.document import Look
from app.document.measured import setting_text
from app.view.tab import ViewTab
from app.widgets import theme
from app.widgets.controls import ComboBox
from app.widgets.labels import MIN_ERROR, NAMES
from app.widgets.number_field import NUMERIC
from app.widgets.panels import button, enable, sheet, text
from app.widgets.theme import ROW, STEP
from engine.core.figure_text import percent, percent_range, size_text, time_text

if TYPE_CHECKING:
    from engine.planning.plan import Beyond, Effect, EffectsPlan

#: Requests that a user can make for an effect, and their labels.
WISHES = (("", "Auto"), ("on", "On"), ("off", "Off"))

#: Seconds and bytes below these are not worth a word.
MIN_S, MIN_BYTES = 0.05, 1e5

#: Pixels between the words of a row and the edge of their column.
CELL = 12

#: Width of the dock below which the shortest words would be cut.
NARROWEST = 352


class EffectsDock(QDockWidget):
    """Shows the plan of `view`, and changes the requests. `applied(Setting)` asks for the plan's setting."""

    applied = Signal(object)

    def __init__(self, bench: Workbench, view: ViewTab, parent: QWidget) -> None:
        super().__init__("Effects", parent)
        self.setObjectName("effects")
        self.bench, self.view = bench, view
        self.planning = view.planning
        self.wishes: dict[str, QComboBox] = {}
        self.setWidget(self._inside())
        self.applied.connect(view.apply_setting)
        bench.document.changed.connect(lambda _old, _new: self._show_budget())
        self.planning.changed.connect(self._show)
        view.setting_changed.connect(self._show_choice)
        self.visibilityChanged.connect(lambda _visible: self.planning.watch("dock", self.isVisible()))
        self._show()

    @property
    def plan(self) -> EffectsPlan | None:
        """The plan of the scene as it is."""
        return self.planning.plan

    def sizeHint(self) -> QSize:
        return QSize(320, 300)

    def _inside(self) -> QWidget:
        holder, column = sheet()
        holder.setMinimumWidth(NARROWEST)
        self.table = _Table(0, 3)
        self.table.setAccessibleName("Effects that the scene needs")
        self.table.horizontalHeader().hide()
        self.table.verticalHeader().hide()
        self.table.verticalHeader().setDefaultSectionSize(ROW)
        self.table.setShowGrid(False)
        self.table.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        self.table.setSelectionMode(QAbstractItemView.SelectionMode.NoSelection)
        self.table.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.table.setWordWrap(False)
        header = self.table.horizontalHeader()
        header.setSectionResizeMode(0, QHeaderView.ResizeMode.ResizeToContents)
        header.setSectionResizeMode(1, QHeaderView.ResizeMode.Stretch)
        header.setSectionResizeMode(2, QHeaderView.ResizeMode.Fixed)
        header.resizeSection(2, 88)
        header.sectionResized.connect(lambda *_sizes: self._fit_words())
        self.table.resized.connect(self._fit_words)
        column.addWidget(self.table, 1)
        self.budget = QLineEdit()
        self.budget.setProperty(NUMERIC, True)
        self.budget.setText(self.bench.document.project.look.plan_budget)
        self.budget.editingFinished.connect(self._budget_edited)
        self.budget.setFixedWidth(88)
        caption = text("Budget", "secondary")
        caption.setBuddy(self.budget)
        self.budget.setAccessibleName("Budget of the plan")
        for widget in (caption, self.budget):
            widget.setToolTip("Largest error of an image, '1 %', or longest time of a frame, '8 ms'")
        self.apply = button("Use this plan", hint="Show the mode with the settings that the plan has chosen")
        self.apply.clicked.connect(self._apply)
        foot = QHBoxLayout()
        foot.setSpacing(2 * STEP)
        foot.addWidget(caption)
        foot.addWidget(self.budget)
        foot.addStretch(1)
        foot.addWidget(self.apply)
        self.words = text("", "secondary", wrap=True)
        column.addSpacing(STEP)
        column.addWidget(self.words)
        column.addLayout(foot)
        column.addStretch()  # without effects the sentence that says what is missing stands at the top
        return holder

    def _show_budget(self) -> None:
        words = self.bench.document.project.look.plan_budget
        if self.budget.text() != words and not self.budget.hasFocus():
            self.budget.setText(words)

    def _show(self) -> None:
        plan = self.planning.plan or self.planning.before
        effects = plan.effects if plan is not None else ()
        if [*self.wishes] != [effect.effect for effect in effects]:
            self._make_rows(effects)
        for place, effect in enumerate(effects):
            self._show_row(place, effect)
        self.table.setVisible(bool(effects))
        self._fit_words()
        self._show_choice()

    def _make_rows(self, effects: tuple[Effect, ...]) -> None:
        self.table.setRowCount(len(effects))
        self.wishes = {}
        for place, effect in enumerate(effects):
            for column in range(2):
                self.table.setItem(place, column, QTableWidgetItem())
            wish = ComboBox()
            for value, words in WISHES:
                wish.addItem(words, value)
            wish.setAccessibleName(NAMES.get(effect.effect, effect.effect))
            wish.setToolTip("As planned, always on, or always off")
            wish.activated.connect(lambda _index, name=effect.effect: self._wish(name))
            self.table.setCellWidget(place, 2, wish)
            self.wishes[effect.effect] = wish
        for before, behind in pairwise((*self.wishes.values(), self.budget, self.apply)):
            QWidget.setTabOrder(before, behind)

    def _show_row(self, place: int, effect: Effect) -> None:
        colours, look = theme.current(), self.bench.document.project.look
        quiet = colours.secondary if self.plan is not None else colours.disabled
        name, words = self.table.item(place, 0), self.table.item(place, 1)
        assert name is not None
        assert words is not None
        name.setText(f"{'●' if effect.on else '○'}  {NAMES.get(effect.effect, effect.effect)}")
        name.setForeground(QColor(colours.text if effect.on and self.plan is not None else quiet))
        words.setData(Qt.ItemDataRole.UserRole, row_forms(effect))
        words.setForeground(QColor(quiet))
        for item in (name, words):
            about = f"{effect.decision}: {effect.reason}\n{row_text(effect)}"
            item.setToolTip(about if self.plan is not None else f"Of the previous scene. {about}")
        wish = self.wishes[effect.effect]
        value = "on" if effect.effect in look.forced else "off" if effect.effect in look.skipped else ""
        wish.setCurrentIndex(wish.findData(value))

    def _fit_words(self) -> None:
        """As much in every row as there is room for."""
        taken = self.table.columnWidth(0) + self.table.columnWidth(2) + 2 * CELL
        metrics, room = self.table.fontMetrics(), self.table.viewport().width() - taken
        for place in range(self.table.rowCount()):
            words = self.table.item(place, 1)
            forms = (words.data(Qt.ItemDataRole.UserRole) if words is not None else None) or ("",)
            fitting = next((form for form in forms if metrics.horizontalAdvance(form) <= room), forms[-1])
            if words is not None and words.text() != fitting:
                words.setText(fitting)

    def _show_choice(self) -> None:
        plan = self.plan
        if plan is None:
            self.words.setText(self.planning.words)
            enable(self.apply, self.planning.words or "There is no plan yet")
            return
        figures = percent(plan.predicted_error_rel), time_text(plan.predicted_frame_s)
        error, frame = (figure.replace(" ", "\u00a0") for figure in figures)
        choice = f"{setting_text(plan.setting)}: about {error} and {frame}."
        self.words.setText(
            choice if plan.satisfied else f"Nothing keeps within the budget. Best for its cost is {choice}"
        )
        interval = percent_range(*plan.error_interval_rel)
        expected = f"From where it was planned, the error is {interval} in 95 of 100 scenes that are predicted so."
        if plan.probability is not None:
            expected += f" The budget is met with a probability of {percent(plan.probability)}."
        self.words.setToolTip(expected if plan.beyond is None else f"{expected}\n{_beyond_text(plan.beyond)}")
        is_shown = plan.setting == self.view.setting
        enable(self.apply, "The plan is what is shown" if is_shown else "")

    def _apply(self) -> None:
        if self.plan is not None:
            self.applied.emit(self.plan.setting)

    def _wish(self, name: str) -> None:
        """Force an effect, leave it out, or let the plan decide."""
        look, value = self.bench.document.project.look, self.wishes[name].currentData()
        forced = tuple(each for each in look.forced if each != name) + ((name,) if value == "on" else ())
        skipped = tuple(each for each in look.skipped if each != name) + ((name,) if value == "off" else ())
        self._change(f"{NAMES.get(name, name)} {self.wishes[name].currentText().lower()}", look, forced, skipped)

    def _budget_edited(self) -> None:
        words, look = self.budget.text().strip(), self.bench.document.project.look
        if words != look.plan_budget:
            self._change("Budget", dataclasses.replace(look, plan_budget=words), look.forced, look.skipped)

    def _change(self, words: str, look: Look, forced: tuple[str, ...], skipped: tuple[str, ...]) -> None:
        changed = dataclasses.replace(look, forced=forced, skipped=skipped)
        if changed != self.bench.document.project.look:
            self.bench.document.change(words, look=changed)

    def apply_theme(self) -> None:
        """Draw in the colours of the current theme."""
        self._show()


class _Table(QTableWidget):
    """`resized` follows when there is another width for its words."""

    resized = Signal()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self.resized.emit()


def _beyond_text(beyond: Beyond) -> str:
    """The setting that keeps within the budget beyond the ceilings of a plan, and its cost."""
    cost = beyond.cost
    takes = [f"{time_text(cost.frame_s)} an image"]
    takes += (
        [f"{time_text(cost.bake_s)} to bake", f"{size_text(cost.memory_bytes)} of memory"] if cost.bake_s > 0.0 else []
    )
    return f"{setting_text(beyond.setting)} keeps within it, but takes {', '.join(takes)}."


def row_text(effect: Effect) -> str:
    """'needed, 12 % without it' or 'skipped, 0.2 % for 41 s'."""
    return row_forms(effect)[0]


def row_forms(effect: Effect) -> tuple[str, ...]:
    """The same and shorter, the longest first."""
    error = percent(effect.estimated_error_rel) if effect.estimated_error_rel >= MIN_ERROR else "no loss"
    short = (f"{effect.decision}, {error}", error)
    if effect.on:
        return (f"{effect.decision}, {error} without it", *short)
    saved = []
    if effect.saves_s >= MIN_S:
        saved.append(time_text(effect.saves_s))
    if effect.saves_bytes >= MIN_BYTES:
        saved.append(size_text(effect.saves_bytes))
    longer = [" and ".join(saved[:count]) for count in range(len(saved), 0, -1)]
    return (*(f"{effect.decision}, {error} for {words}" for words in longer), *short)
