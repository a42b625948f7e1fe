"""The Health dock: what every result says of its numbers, and the self-test of this machine.

The health of every result in the window: its name, its figures in words, its findings and a verdict.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from math import isfinite
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import QModelIndex, QPersistentModelIndex, QRect, QSize, Qt, Signal
from PySide6.QtGui import QColor
from PySide6.QtWidgets import (
    QAbstractItemView,
    QDockWidget,
    QHBoxLayout,
    QHeaderView,
    QStyledItemDelegate,
    QStyleOptionViewItem,
    QTreeWidget,
    QTreeWidgetItem,
    QWidget,
)

from app.commands.workbench import Workbench
from app.document.document import Project
from app.jobs.jobs import Job
from app.view.tab import ViewTab
from app.widgets import theme
from app.widgets import theme as icons
from app.widgets.panels import button, sheet, text
from app.widgets.status_bar import VERDICTS
from engine.core.figure_text import number, size_text
from engine.core.health import Health, Verdict
from engine.core.steps import Step, Steps
from engine.storage.untrusted import protection

if TYPE_CHECKING:
    from engine.brdf.brdf import Brdf
    from engine.selftest.case import Case

#: Units at the end of a figure's name, and how they are written; the longest that fits is taken.
UNITS = (
    ("_bytes", "B"),
    ("_deg", "°"),
    ("_px", "px"),
    ("_ms", "ms"),
    ("_s", "s"),
    ("_rel", "%"),
    ("_percent", "%"),
)

#: Figures that count what is wrong: any of them is worth a look.
COUNTS = re.compile(r"clamp|mask|fill|invalid|non_?finite|reject|negative|degenerate|dropped|clipped|missing")


@dataclass(frozen=True)
class Part:
    """One result and the health of its numbers."""

    name: str
    health: Health

    @property
    def summary(self) -> str:
        """The worst finding; empty where there is none, which the verdict beside it says."""
        worst = [each.sentence for each in self.health.summary if each.verdict == self.health.verdict]
        if worst and self.health.verdict > Verdict.GOOD:
            return worst[0] + (f" (and {len(worst) - 1} more)" if len(worst) > 1 else "")
        return ""


def parts_of(project: Project, brdf: Brdf | None, bakings: Iterable[tuple[str, Any]]) -> list[Part]:
    """Every result of `project` that has a health, the drawn `brdf`, and the bakes (label, bake).

    How files are decoded stands at their end, once one has been.
    """
    material = project.material
    offered: list[tuple[str, Any]] = [
        ("Photographs", project.stack),
        ("Shading map", material.shading_map),
        ("Power law", material.power_law),
        ("Material", None if project.stack is not None else material if project.has_map else None),
        ("Directional map", material if material.directional is not None else None),
        ("Model", project.mesh),
        ("Light", project.environment),
        ("Measured BRDF", material.measured),
        ("BRDF", brdf),
    ]
    for label, made in bakings:
        if made is not None:
            offered += [(label, made), (f"{label}: BRDF", getattr(made.transport, "table", None))]
    found: list[Part] = []
    for name, value in offered:
        health = getattr(value, "health", None)
        if isinstance(health, Health) and not any(health is part.health for part in found):
            found.append(Part(name, health))
    if found and (confined := protection()) is not None:
        found.append(Part("Reading of files", confined.health))
    return found


def worst_of(parts: Iterable[Part]) -> Health:
    """All of them together, for one verdict."""
    whole = Health()
    for part in parts:
        whole = whole.merge(part.health)
    return whole


def figures_of(health: Health) -> Iterator[tuple[str, str, bool]]:
    """Each figure for the user: its name, its value with the unit, and True if it counts defects."""
    for name, value in sorted(health.figures.items()):
        words, unit = _split_name(name)
        is_doubtful = bool(COUNTS.search(name)) and value > 0
        yield words, _format_value(100.0 * value if name.endswith("_rel") else value, unit), is_doubtful


def _format_value(value: float, unit: str) -> str:
    """A number with its unit, in digits that are read at a glance."""
    if unit == "B":
        return size_text(value)
    return f"{number(value, 4)} {unit}".strip() if isfinite(value) else number(value)


def _split_name(name: str) -> tuple[str, str]:
    """'edge_error_px' → 'Edge error', 'px'."""
    ending, unit = next(((ending, unit) for ending, unit in UNITS if name.endswith(ending)), ("", ""))
    words = name.removesuffix(ending).replace("_", " ").strip() or name
    return f"{words[:1].upper()}{words[1:]}", unit


#: Width of a verdict's icon with its gap, and pixels beside and around words of a row.
MARK, BESIDE, AROUND = 20, 8, 8

#: Height of a line, and width of the dock below which its words would be cut, in pixels.
LINE, NARROWEST = 24, 380

WORDS = {Verdict.GOOD: "good", Verdict.NOTE: "note", Verdict.WARNING: "check", Verdict.BAD: "problem"}


class _Wrapped(QStyledItemDelegate):
    """Sentences in the column that stretches, on as many lines as its width takes."""

    def sizeHint(self, option: QStyleOptionViewItem, index: QModelIndex | QPersistentModelIndex) -> QSize:
        tree = self.parent()
        assert isinstance(tree, QTreeWidget)
        mark = MARK if index.data(Qt.ItemDataRole.DecorationRole) is not None else 0
        room = QRect(0, 0, max(1, tree.columnWidth(index.column()) - mark - BESIDE), 1 << 20)
        words = str(index.data(Qt.ItemDataRole.DisplayRole) or "")
        high = tree.fontMetrics().boundingRect(room, Qt.TextFlag.TextWordWrap, words).height()
        return QSize(0, max(LINE, high + AROUND))


class HealthDock(QDockWidget):
    """`reported(Health)`: all findings together, whenever they change."""

    reported = Signal(object)

    def __init__(self, bench: Workbench, view: ViewTab, parent: QWidget) -> None:
        super().__init__("Health", parent)
        self.setObjectName("health")
        self.bench, self.view = bench, view
        self.parts: list[Part] = []
        self.job: Job | None = None
        self._report: Sequence[Case] | None = None
        self.setWidget(self._inside())
        bench.document.changed.connect(lambda _old, _new: self.refresh())
        view.model_ready.connect(self.refresh)
        for baking in view.bakings.values():
            baking.relit_changed.connect(self.refresh)
        self.refresh()

    def sizeHint(self) -> QSize:
        return QSize(320, 200)

    def _inside(self) -> QWidget:
        holder, column = sheet()
        holder.setMinimumWidth(NARROWEST)
        self.tree = QTreeWidget()
        self.tree.setColumnCount(3)
        self.tree.setHeaderHidden(True)
        self.tree.setAccessibleName("Health of every result")
        self.tree.setSelectionMode(QAbstractItemView.SelectionMode.NoSelection)
        self.tree.setWordWrap(True)
        self.tree.setItemDelegateForColumn(1, _Wrapped(self.tree))
        header = self.tree.header()
        header.sectionResized.connect(lambda *_sizes: self.tree.scheduleDelayedItemsLayout())
        header.setStretchLastSection(False)
        header.setSectionResizeMode(0, QHeaderView.ResizeMode.ResizeToContents)
        header.setSectionResizeMode(1, QHeaderView.ResizeMode.Stretch)
        header.setSectionResizeMode(2, QHeaderView.ResizeMode.ResizeToContents)
        column.addWidget(self.tree, 1)
        foot = QHBoxLayout()
        self.words = text("", "secondary", wrap=True)
        foot.addWidget(self.words, 1)
        self.test = button("Self-test", hint="Run the hard numerical cases on this machine; less than a minute")
        self.test.clicked.connect(self.test_or_stop)
        foot.addWidget(self.test, 0, Qt.AlignmentFlag.AlignTop)
        column.addLayout(foot)
        return holder

    def refresh(self) -> None:
        """Ask all results again."""
        bakings = [(f"Baked {baking.method.noun}", baking.made) for baking in self.view.bakings.values()]
        parts = parts_of(self.bench.document.project, self.view.brdf, bakings)
        alike = [(part.name, id(part.health)) for part in parts] == [
            (part.name, id(part.health)) for part in self.parts
        ]
        self.parts = parts
        if not alike or self.tree.topLevelItemCount() == 0:
            self._show()
            self.reported.emit(self.health)

    @property
    def health(self) -> Health | None:
        """All of it; None where there is nothing yet."""
        return worst_of(self.parts) if self.parts else None

    def _show(self) -> None:
        is_open = {self.tree.topLevelItem(at).text(0): self.tree.topLevelItem(at).isExpanded() for at in self._rows()}  # type: ignore[union-attr]
        self.tree.clear()
        for part in self.parts:
            self._add(part, is_open.get(part.name))
        if self._report is not None:
            self._add_report(self._report)
        if not self.parts:
            self.words.setText("Nothing has been opened or built yet.")
        elif self.job is None and self._report is None:
            count = sum(len(part.health.figures) for part in self.parts)
            self.words.setText(f"{len(self.parts)} results, {count} figures.")

    def _rows(self) -> range:
        return range(self.tree.topLevelItemCount())

    def _add(self, part: Part, is_open: bool | None) -> None:
        top = self._line(None, part.name, part.summary, WORDS[part.health.verdict], part.health.verdict)
        for finding in part.health.summary:
            self._line(top, "", finding.sentence, WORDS[finding.verdict], finding.verdict)
        for name, value, is_doubtful in figures_of(part.health):
            self._line(top, "", name, value, Verdict.NOTE if is_doubtful else None)
        top.setExpanded(part.health.verdict >= Verdict.WARNING if is_open is None else is_open)

    def _line(self, above: QTreeWidgetItem | None, *words: Any) -> QTreeWidgetItem:
        """Three columns, and the verdict as an icon."""
        name, middle, value, verdict = words
        item = QTreeWidgetItem(above or self.tree, [name, middle, value])
        item.setTextAlignment(2, Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
        item.setToolTip(1, middle)
        colours = theme.current()
        item.setForeground(1, QColor(colours.secondary))
        if verdict is not None:
            icon, look, _ = VERDICTS[verdict]
            item.setIcon(0 if above is None else 1, icons.icon(icon, getattr(colours, look)))
            item.setForeground(2, QColor(getattr(colours, look)))
        return item

    def test_or_stop(self) -> None:
        """Run the self-test, or stop it."""
        if self.job is not None:
            self.bench.jobs.cancel(self.job)
            return
        self.job = self.bench.jobs.submit("Self-test", _on_tested, lane="compute")
        self.job.progressed.connect(lambda step: self.words.setText(f"{step.note[:1].upper()}{step.note[1:]}"))
        self.job.succeeded.connect(self._on_tested)
        for ended in (self.job.failed, self.job.cancelled):
            ended.connect(lambda *_error: self._on_tested(None))
        self.test.setText("Stop")

    def _on_tested(self, report: Sequence[Case] | None) -> None:
        self.job = None
        self.test.setText("Self-test")
        self._report = report
        self._show()
        self.words.setText("The self-test was stopped." if report is None else report_text(report))

    def _add_report(self, cases: Sequence[Case]) -> None:
        failed = [case for case in cases if not case.passed]
        words = f"{len(failed)} of {len(cases)} cases fail" if failed else f"All {len(cases)} cases pass"
        verdict = Verdict.BAD if failed else Verdict.GOOD
        top = self._line(None, "Self-test", words, WORDS[verdict], verdict)
        for case in cases:
            own = Verdict.GOOD if case.passed else Verdict.BAD
            value = case.problem or case.skipped or f"{number(case.measured, 3)} ≤ {number(case.bound, 3)}"
            self._line(top, "", f"{case.id}  {case.text}", value[:60], own)
        top.setExpanded(bool(failed))

    def apply_theme(self) -> None:
        """Draw in the colours of the current theme."""
        self._show()


def report_text(cases: Sequence[Case]) -> str:
    """The result of the self-test, in a sentence."""
    failed = [case.id for case in cases if not case.passed]
    if not failed:
        return f"All {len(cases)} cases of the self-test pass."
    return f"{len(failed)} of {len(cases)} cases of the self-test fail: {', '.join(failed)}."


def _on_tested() -> Steps[Any]:
    yield Step(0.0, "compiling (first use only)")
    from engine.selftest.run import selftest

    return (yield from selftest())
