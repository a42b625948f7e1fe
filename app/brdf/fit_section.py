"""The section that fits a model to a BRDF: its target and settings, the error while it runs, and the result.

The ranking of all models for one BRDF: each fitted, with its error in two norms, and any of them to be compared.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QDialog, QHBoxLayout, QVBoxLayout, QWidget

from app.brdf.plots import ResidualPlot
from app.commands.brdf import FULL, FitSoFar, add, fit
from app.commands.workbench import Workbench
from app.document.comparison import Comparison, Entry, Fitted
from app.jobs.jobs import Job
from app.widgets import theme
from app.widgets.controls import ComboBox
from app.widgets.figure_table import FigureTable
from app.widgets.panels import Rows, button, enable, text
from app.widgets.theme import STEP
from engine.brdf.brdf import MODELS, Brdf, label_of, model_name
from engine.brdf.fit import WEIGHTINGS as NORMS
from engine.brdf.fit import Weighting, fit_data
from engine.brdf.ranking import rank
from engine.core.figure_text import number, percent
from engine.core.steps import Step, Steps

if TYPE_CHECKING:
    from engine.brdf.ranking import Offer

HEADINGS = ("Model", "Error", "Log error")

#: Width and height of the dialog.
SIZE_PX = (420, 420)


class Ranking(QDialog):
    """`wanted(offer)`: one of the fits is to become an entry of the list."""

    wanted = Signal(object)

    def __init__(self, window: QWidget, name: str, offers: Sequence[Offer]) -> None:
        super().__init__(window)
        self.offers = tuple(offers)
        self.setWindowTitle(f"All models for {name}")
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.resize(*SIZE_PX)
        self.table = FigureTable("Models by their error", HEADINGS)
        rows = [(label_of(model_name(each.brdf)), percent(each.linear, 3), number(each.log, 3)) for each in self.offers]
        self.table.show_rows(rows, 0 if rows else None)
        self.table.itemActivated.connect(lambda _item: self._add())
        words = text(
            "Error: RMS of BRDF × cosine relative to that of the data, which highlights outweigh. "
            "Log error: of the logarithms, where dim values count as much; the least is on top.",
            "secondary",
            wrap=True,
        )
        self.add = button("Add to the list", "primary")
        self.add.clicked.connect(self._add)
        close = button("Close")
        close.clicked.connect(self.close)
        foot = QHBoxLayout()
        foot.setSpacing(2 * STEP)
        foot.addStretch(1)
        foot.addWidget(close)
        foot.addWidget(self.add)
        column = QVBoxLayout(self)
        column.setSpacing(2 * STEP)
        column.addWidget(words)
        column.addWidget(self.table, 1)
        column.addLayout(foot)

    def _add(self) -> None:
        place = self.table.currentRow()
        if place >= 0:
            self.wanted.emit(self.offers[place])


def all_models(brdf: Brdf, weighting: Weighting) -> Steps[list[Offer]]:
    """Every model fitted to `brdf`, the best first; some seconds to a minute."""
    yield Step(0.0, "taking samples")
    return (yield from rank(fit_data(brdf), [model() for model in MODELS.values()], weighting=weighting))


WEIGHTINGS = (
    ("joint", "Parts and light", "Relative errors, and for each colour as much light as the data reflect"),
    ("log", "All parts", "Relative errors: dim parts weigh as much as the highlight"),
    ("cosine", "Energy", "Errors weighted by energy: a highlight outweighs all else"),
)


class FitSection(Rows):
    """Fits to the current entry. `changed` says that a better fit is known, or that none is under way any more."""

    changed = Signal()

    def __init__(self, bench: Workbench) -> None:
        super().__init__("Fit a model")
        self.bench = bench
        self.entry: Entry | None = None
        self.job: Job | None = None
        self.so_far: FitSoFar | None = None
        self._of: Entry | None = None
        self._asked: tuple[str, Weighting] = ("", "joint")
        self.model = ComboBox()
        for name in MODELS:
            self.model.addItem(label_of(name), name)
        self.model.setCurrentIndex(self.model.findData("ggx"))
        self.row("Model", self.model, "The model to fit")
        self.weighting = ComboBox()
        for place, (name, words, hint) in enumerate(WEIGHTINGS):
            self.weighting.addItem(words, name)
            self.weighting.setItemData(place, hint, Qt.ItemDataRole.ToolTipRole)
        self.row("Counts", self.weighting, "Weight of each error in the fit")
        self.start = button("Fit")
        self.start.clicked.connect(self.begin)
        self.stop = button("Stop and keep", hint="The best parameters so far become an entry of the list")
        self.stop.clicked.connect(self.end)
        self.stop.hide()
        self.rank = button("Rank all models", hint="Fit every model, and list them by their errors")
        self.rank.clicked.connect(self.rank_all)
        self.ranking: Ranking | None = None
        holder = QWidget()
        row = QHBoxLayout(holder)
        row.setContentsMargins(0, 0, 0, 0)
        row.addWidget(self.start, 1)
        row.addWidget(self.rank, 1)
        row.addWidget(self.stop, 1)
        self.wide(holder)
        self.error = text("", "secondary")
        self.error.setToolTip("RMS of BRDF × cosine relative to that of the data: at the start → now")
        self.wide(self.error)
        self.error.hide()
        self.plot = ResidualPlot()
        self.wide(self.plot)
        self.plot.hide()

    @property
    def running(self) -> bool:
        """True while a fit runs."""
        return self.job is not None

    def show_entry(self, entry: Entry | None, comparison: Comparison) -> None:
        """Set the entry that the next fit approximates."""
        self.entry = entry
        nothing = "" if entry is not None else "Add a BRDF to the list first"
        full = FULL if comparison.free_identity is None else ""
        busy = "A fit is running" if self.running else ""
        hint = f"Find the parameters that bring the model nearest to {entry.name}" if entry is not None else ""
        enable(self.start, nothing or full or busy, hint)
        enable(self.rank, nothing or busy)
        enable(self.model, busy)
        enable(self.weighting, busy)

    @property
    def chosen_weighting(self) -> Weighting:
        return next(name for name in NORMS if name == self.weighting.currentData())

    def begin(self) -> None:
        """Fit the chosen model to the current entry."""
        if self.entry is None or self.running:
            return
        entry, model, weighting = self.entry, str(self.model.currentData()), self.chosen_weighting
        self._of, self._asked, self.so_far = entry, (model, weighting), None
        title = f"Fitting {label_of(model)} to {entry.name}"
        job = self.bench.jobs.submit(title, lambda: fit(entry.brdf, model, weighting), lane="compute")
        self.job = job
        self.stop.show()
        job.progressed.connect(self._on_progressed)
        job.succeeded.connect(self._finish)
        job.cancelled.connect(lambda: self._finish(self.so_far))
        job.failed.connect(lambda _error: self._finish(None))
        self.changed.emit()

    def rank_all(self) -> None:
        """Fit every model to the current entry, and list them by their errors."""
        if self.entry is None or self.running:
            return
        entry, weighting = self.entry, self.chosen_weighting
        self.job = self.bench.jobs.submit(
            f"Fitting all models to {entry.name}", lambda: all_models(entry.brdf, weighting), lane="compute"
        )
        self.job.succeeded.connect(lambda offers: self._show_ranking(entry, weighting, offers))
        for ended in (self.job.succeeded, self.job.failed, self.job.cancelled):
            ended.connect(lambda *_what: self._finish(None))
        self.changed.emit()

    def _show_ranking(self, entry: Entry, weighting: Weighting, offers: Sequence[Offer]) -> None:
        self.ranking = Ranking(self.window(), entry.name, offers)
        self.ranking.wanted.connect(lambda offer: self._add_offer(entry, weighting, offer))
        self.ranking.open()

    def _add_offer(self, entry: Entry, weighting: Weighting, offer: Offer) -> None:
        name = label_of(model_name(offer.brdf))
        note = Fitted(entry.name, weighting, offer.linear, offer.linear)
        add(self.bench, f"{name} to {entry.name}", offer.brdf, fitted=note)

    def end(self) -> None:
        """Stop and keep the best result."""
        if self.job is not None:
            self.bench.jobs.cancel(self.job)

    def _on_progressed(self, step: Step) -> None:
        if step.partial is not None:
            self.so_far = step.partial
            self._show_errors(step.partial)
            self.changed.emit()

    def _show_errors(self, now: FitSoFar) -> None:
        self.error.show()
        self.error.setText(f"Error {percent(now.before.rmse_rel, 3)} → {percent(now.after.rmse_rel, 3)}")
        self.plot.show()
        self.plot.show_errors(now.now.edges, now.start.rms, now.now.rms, theme.current().accent)

    def _finish(self, found: FitSoFar | None) -> None:
        of, (model, weighting) = self._of, self._asked
        self.job = self.so_far = self._of = None
        self.stop.hide()
        still_there = of is not None and self.bench.document.project.comparison.find(of.identity) is not None
        if found is not None and of is not None and still_there:
            self._show_errors(found)
            note = Fitted(of.name, weighting, found.before.rmse_rel, found.after.rmse_rel)
            add(self.bench, f"{label_of(model)} to {of.name}", found.brdf, fitted=note)
        self.changed.emit()
