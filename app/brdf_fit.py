"""The section that fits a model: what is fitted and how, the error while it runs, and what is kept of it."""

from __future__ import annotations

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QComboBox, QHBoxLayout, QWidget

from app import theme
from app.brdf_names import BRDF_NAMES
from app.brdf_plots import ResidualPlot
from app.brdf_verbs import FULL, FitSoFar, add, fitted
from app.comparison import Comparison, Entry, Fitted
from app.jobs import Job
from app.panels import Rows, Segments, button, enable, text
from app.workbench import Workbench
from engine.brdf.brdf import MODELS
from engine.steps import Step

WEIGHTINGS = (
    ("log", "All parts", "Every part counts, the dim ones as much as the highlight"),
    ("cosine", "Energy", "What light carries counts; a highlight outweighs all else"),
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
        self._asked: tuple[str, str] = ("", "")
        self.model = QComboBox()
        for name in MODELS:
            self.model.addItem(BRDF_NAMES.get(name, name), name)
        self.model.setCurrentIndex(self.model.findData("ggx"))
        self.row("Model", self.model, "The model whose parameters are found")
        self.weighting = Segments(WEIGHTINGS)
        self.weighting.choose("log")
        self.weighting.setMinimumHeight(self.weighting.sizeHint().height())
        self.row("Counts", self.weighting, "What a difference weighs")
        self.start = button("Fit")
        self.start.clicked.connect(self.begin)
        self.stop = button("Stop and keep", hint="The best parameters so far become an entry of the list")
        self.stop.clicked.connect(self.end)
        self.stop.hide()
        holder = QWidget()
        row = QHBoxLayout(holder)
        row.setContentsMargins(0, 0, 0, 0)
        row.addWidget(self.start, 1)
        row.addWidget(self.stop, 1)
        self.wide(holder)
        self.error = text("", "secondary")
        self.error.setToolTip("RMS of BRDF × cosine relative to that of the data: where it began → now")
        self.wide(self.error)
        self.error.hide()
        self.plot = ResidualPlot()
        self.wide(self.plot)
        self.plot.hide()

    @property
    def running(self) -> bool:
        """Whether a fit is under way."""
        return self.job is not None

    def show_entry(self, entry: Entry | None, comparison: Comparison) -> None:
        """What the next fit is for."""
        self.entry = entry
        nothing = "" if entry is not None else "Add a reflectance to the list first"
        full = FULL if comparison.free_identity is None else ""
        busy = "A fit is running" if self.running else ""
        hint = f"Find the parameters with which the model comes nearest to {entry.name}" if entry is not None else ""
        enable(self.start, nothing or full or busy, hint)
        enable(self.model, busy)
        enable(self.weighting, busy)

    def begin(self) -> None:
        """Fit the chosen model to the current entry."""
        if self.entry is None or self.running:
            return
        entry, model, weighting = self.entry, str(self.model.currentData()), self.weighting.value
        self._of, self._asked, self.so_far = entry, (model, weighting), None
        title = f"Fitting {BRDF_NAMES.get(model, model)} to {entry.name}"
        job = self.bench.jobs.submit(title, lambda: fitted(entry.brdf, model, weighting))
        self.job = job
        self.stop.show()
        job.progressed.connect(self._progressed)
        job.succeeded.connect(self._finish)
        job.cancelled.connect(lambda: self._finish(self.so_far))
        job.failed.connect(lambda _error: self._finish(None))
        self.changed.emit()

    def end(self) -> None:
        """Stop and keep what there is."""
        if self.job is not None:
            self.bench.jobs.cancel(self.job)

    def _progressed(self, step: Step) -> None:
        if step.partial is not None:
            self.so_far = step.partial
            self._show_errors(step.partial)
            self.changed.emit()

    def _show_errors(self, now: FitSoFar) -> None:
        self.error.show()
        self.error.setText(f"Error {percent(now.before.rmse_rel)} → {percent(now.after.rmse_rel)}")
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
            add(self.bench, f"{BRDF_NAMES.get(model, model)} to {of.name}", found.brdf, fitted=note)
        self.changed.emit()


def percent(share: float) -> str:
    """A relative error in words."""
    return f"{100.0 * share:.3g} %"
