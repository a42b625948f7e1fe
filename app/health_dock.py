"""The Health dock: what every result says of its numbers, and the self-test of this machine."""

from __future__ import annotations

from typing import Any

from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtGui import QColor
from PySide6.QtWidgets import (
    QAbstractItemView,
    QDockWidget,
    QHBoxLayout,
    QHeaderView,
    QTreeWidget,
    QTreeWidgetItem,
    QWidget,
)

from app import icons, theme
from app.healths import Part, figures_of, parts_of, worst_of
from app.jobs import Job
from app.panels import button, sheet, text
from app.status_bar import VERDICTS
from app.view_tab import ViewTab
from app.workbench import Workbench
from engine.health import Health, Verdict
from engine.steps import Step, Steps

#: Height of a line in pixels.
LINE = 24

WORDS = {Verdict.GOOD: "good", Verdict.NOTE: "note", Verdict.WARNING: "check", Verdict.BAD: "problem"}


class HealthDock(QDockWidget):
    """`told(Health)`: all findings together, whenever they are others."""

    told = Signal(object)

    def __init__(self, bench: Workbench, view: ViewTab, parent: QWidget) -> None:
        super().__init__("Health", parent)
        self.setObjectName("health")
        self.bench, self.view = bench, view
        self.parts: list[Part] = []
        self.job: Job | None = None
        self._report: Any = None
        self.setWidget(self._inside())
        bench.document.changed.connect(lambda _old, _new: self.refresh())
        view.model_ready.connect(self.refresh)
        for baking in view.bakings.values():
            baking.lit_changed.connect(self.refresh)
        self.refresh()

    def sizeHint(self) -> QSize:
        return QSize(320, 200)

    def _inside(self) -> QWidget:
        holder, column = sheet()
        self.tree = QTreeWidget()
        self.tree.setColumnCount(3)
        self.tree.setHeaderHidden(True)
        self.tree.setAccessibleName("Health of every result")
        self.tree.setSelectionMode(QAbstractItemView.SelectionMode.NoSelection)
        self.tree.setUniformRowHeights(True)
        header = self.tree.header()
        header.setStretchLastSection(False)
        header.setSectionResizeMode(0, QHeaderView.ResizeMode.ResizeToContents)
        header.setSectionResizeMode(1, QHeaderView.ResizeMode.Stretch)
        header.setSectionResizeMode(2, QHeaderView.ResizeMode.ResizeToContents)
        column.addWidget(self.tree, 1)
        foot = QHBoxLayout()
        self.words = text("", "secondary", wrap=True)
        foot.addWidget(self.words, 1)
        self.test = button("Self-test", hint="Try the hard cases of the numerics on this machine; less than a minute")
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
            self.told.emit(self.health)

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
        for finding in part.health.findings:
            words = f"{finding.source}: {finding.text}" if finding.source else finding.text
            self._line(top, "", words, WORDS[finding.verdict], finding.verdict)
        for name, value, is_doubtful in figures_of(part.health):
            self._line(top, "", name, value, Verdict.NOTE if is_doubtful else None)
        top.setExpanded(part.health.verdict >= Verdict.WARNING if is_open is None else is_open)

    def _line(self, above: QTreeWidgetItem | None, *words: Any) -> QTreeWidgetItem:
        """Three columns, and the verdict as an icon."""
        name, middle, value, verdict = words
        item = QTreeWidgetItem(above or self.tree, [name, middle, value])
        item.setSizeHint(1, QSize(0, LINE))  # of the column that stretches: its width is not the text's
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
        self.job = self.bench.jobs.submit("Self-test", _tested)
        self.job.progressed.connect(lambda step: self.words.setText(f"{step.note[:1].upper()}{step.note[1:]}"))
        self.job.succeeded.connect(self._tested)
        for ended in (self.job.failed, self.job.cancelled):
            ended.connect(lambda *_error: self._tested(None))
        self.test.setText("Stop")

    def _tested(self, report: Any) -> None:
        self.job = None
        self.test.setText("Self-test")
        self._report = report
        self._show()
        self.words.setText("The self-test was stopped." if report is None else report_text(report))

    def _add_report(self, cases: Any) -> None:
        failed = [case for case in cases if not case.passed]
        words = f"{len(failed)} of {len(cases)} cases fail" if failed else f"All {len(cases)} cases pass"
        verdict = Verdict.BAD if failed else Verdict.GOOD
        top = self._line(None, "Self-test", words, WORDS[verdict], verdict)
        for case in cases:
            own = Verdict.GOOD if case.passed else Verdict.BAD
            value = case.problem or case.skipped or f"{case.measured:.3g} ≤ {case.bound:.3g}"
            self._line(top, "", f"{case.id}  {case.text}", value[:60], own)
        top.setExpanded(bool(failed))

    def apply_theme(self) -> None:
        """Draw in the colours of the current theme."""
        self._show()


def report_text(cases: Any) -> str:
    """How the self-test ended, in a sentence."""
    failed = [case.id for case in cases if not case.passed]
    if not failed:
        return f"All {len(cases)} cases of the self-test pass."
    return f"{len(failed)} of {len(cases)} cases of the self-test fail: {', '.join(failed)}."


def _tested() -> Steps[Any]:
    yield Step(0.0, "preparing kernels")
    from engine.selftest.run import selftest

    return (yield from selftest())
