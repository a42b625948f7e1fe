"""The right side of the Factor workspace: the runs, what the chosen factors achieve and serve, and their export."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtGui import QKeySequence, QMouseEvent, QShortcut
from PySide6.QtWidgets import QAbstractItemView, QHBoxLayout, QListWidget, QListWidgetItem, QToolButton, QWidget

from app.brdf.plots import marker_icon
from app.document.factoring import (
    MAPS,
    METHODS,
    METRICS,
    PARAMETRISATIONS,
    PRESETS,
    SHORT_METRICS,
    Factoring,
    Run,
)
from app.factor.runs import Live
from app.widgets import theme
from app.widgets.fitting import breakable
from app.widgets.number_field import NumberField
from app.widgets.panels import Panel, button, enable, text
from app.widgets.plots import Plot
from app.widgets.status_bar import waiting_text
from app.widgets.theme import ROW, STEP
from engine.core.figure_text import number, size_text, time_text
from engine.core.steps import time_left
from engine.factor.settings import MAX_PRODUCTS, MAX_TEXTURES

if TYPE_CHECKING:
    from engine.factor.errors import Factorisation

NUMBER = Qt.ItemDataRole.UserRole
NOTHING = "Start a run first"
#: Most terms of sums of products and of one product.
MAXIMUM = {True: MAX_PRODUCTS, False: MAX_TEXTURES}


class FactorInspector(Panel):
    """Signals ask for what their names say; `more_wanted(terms)` for a run with so many terms."""

    run_wanted = Signal(int)
    pause_wanted = Signal()
    stop_wanted = Signal()
    remove_wanted = Signal()
    more_wanted = Signal(int)
    export_wanted = Signal()
    use_wanted = Signal()

    def __init__(self) -> None:
        super().__init__()
        self._filling = False
        self._offered = (0, 0)
        self._make_runs()
        self._make_chosen()
        foot = QWidget()
        row = QHBoxLayout(foot)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(2 * STEP)
        self.export = button("Export…", "primary")
        self.export.clicked.connect(self.export_wanted)
        self.use = button("Use in View")
        self.use.clicked.connect(self.use_wanted)
        row.addWidget(self.export, 1)
        row.addWidget(self.use, 1)
        self.finish(foot)

    def _make_runs(self) -> None:
        rows = self.section("Runs")
        self.list = QListWidget()
        self.list.setAccessibleName("Runs")
        self.list.setIconSize(QSize(22, 16))
        self.list.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        self.list.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.list.setToolTip("The chosen run is previewed and exported; Del removes it")
        self.list.currentItemChanged.connect(self._row_changed)
        rows.wide(self.list)
        for keys, wanted in (("Del", self.remove_wanted), ("Space", self.pause_wanted)):
            shortcut = QShortcut(QKeySequence(keys), self.list, context=Qt.ShortcutContext.WidgetShortcut)
            shortcut.activated.connect(wanted)
        self.pause = button("Pause")
        self.pause.clicked.connect(self.pause_wanted)
        self.stop = button("Stop")
        self.stop.clicked.connect(self.stop_wanted)
        self.remove = QToolButton()
        self.remove.setIconSize(QSize(16, 16))
        self.remove.setAccessibleName("Remove the run")
        self.remove.clicked.connect(self.remove_wanted)
        rows.wide(_row((self.pause, 1), (self.stop, 1), (self.remove, 0)))
        self.terms = NumberField(2.0, 1.0, 64.0)
        self.terms.setAccessibleName("Terms to go on to")
        self.terms.setFixedWidth(56)
        self.more = button("Continue")
        self.more.clicked.connect(lambda: self.more_wanted.emit(round(self.terms.value)))
        rows.row(
            "Up to terms", _row((self.terms, 0), (self.more, 1)), "Add terms; a search continues from its last state"
        )

    def _make_chosen(self) -> None:
        chosen = self.section("Chosen factors")
        self.failed = text("", "warning", wrap=True)
        chosen.wide(self.failed)
        self.of = chosen.figure("Source", "The run and the method")
        self.of.setWordWrap(True)
        self.many = chosen.figure("Terms", "Click a point of the plot for others; and how many textures these are")
        self.fewer = text("", "secondary", wrap=True)
        chosen.wide(self.fewer)
        self.bytes = chosen.figure("Size", "Of all textures, as 32-bit floats")
        self.time = chosen.figure(
            "Time", "From the start to this term, without pauses; the products of a sum are all found at once"
        )
        self.errors = {
            name: chosen.figure(SHORT_METRICS[name], f"{words}, {_where(name)}") for name, (words, _) in METRICS.items()
        }
        self.remark = text("", "secondary", wrap=True)
        chosen.wide(self.remark)
        bands = self.section("Error by the viewer's elevation")
        self.bands = BandPlot()
        bands.wide(self.bands)
        good = self.section("Good for")
        self.uses = text("–", "", wrap=True)
        good.wide(self.uses)

    def show_runs(self, factoring: Factoring, live: Sequence[Live]) -> None:
        """Show the runs with their states, and the buttons of the chosen run."""
        self._filling = True
        runs = factoring.runs
        self.list.setFixedHeight(2 * ROW * min(4, max(2, len(runs))) + 2)
        while self.list.count() > len(runs):
            self.list.takeItem(self.list.count() - 1)
        for place, (run, known) in enumerate(zip(runs, live, strict=True)):
            item = self.list.item(place)
            if item is None:
                item = QListWidgetItem()
                item.setSizeHint(QSize(0, 2 * ROW - 4))
                self.list.addItem(item)
            if item.data(NUMBER) != run.number:
                item.setData(NUMBER, run.number)
                item.setIcon(marker_icon(run.colour, run.marker))
            words = f"{run.name} · {state_of(known)}\n{method_of(run, known)}{_form_of(run)}"
            if item.text() != words:
                item.setText(words)
                queued = known.job is not None and known.job.state == "queued"
                why = waiting_text(known.job).capitalize() if queued and known.job is not None else known.why
                item.setToolTip("\n".join(filter(None, (words, settings_of(run), why))))
            if run.number == factoring.current and self.list.currentItem() is not item:
                self.list.setCurrentItem(item)
        if factoring.run is None:
            self.list.setCurrentRow(-1)
        self._filling = False
        self._enable(factoring.run, live[runs.index(factoring.run)] if factoring.run is not None else None)

    def _enable(self, run: Run | None, live: Live | None) -> None:
        nothing = NOTHING if run is None else ""
        job = live.job if live is not None else None
        over = "" if job is not None and not job.stopping else "It has ended"
        paused = job is not None and job.state == "paused"
        again = run is not None and run.choices is not None and live is not None and live.may_go_on
        anew = again and live is not None and not live.term_errors
        self.pause.setText("Factor again" if anew else "Resume" if paused or again else "Pause")
        hint = "Pause and let other jobs run, or resume (Space in the list)"
        enable(
            self.pause, nothing or ("" if again else over), "Factor with the settings of this run" if again else hint
        )
        enable(self.stop, nothing or over, "End now and keep the best so far")
        enable(self.remove, nothing, "Remove the run from the list (Del); undo restores it")
        why = nothing
        if run is not None and live is not None:
            if job is not None:
                why = "It is still running"
            elif run.choices is None:
                why = "These factors come from a file; start a run for more terms"
            elif run.choices.method in ("homomorphic", "normalised"):
                why = f"{METHODS[run.choices.method]} has no further terms"
            elif live.brdf is None or (live.why and not live.term_errors):
                why = live.why or "It ended before it began"
            most = MAXIMUM[
                live.is_sum if live.factorisation is not None or run.choices is None else run.choices.separable
            ]
            have = live.term_errors[-1].terms if live.term_errors else 0
            self.terms.high = float(most)
            if not why and have >= most and not (live.factorisation is not None and live.factorisation.searching):
                why = f"{most} terms are the most"
            if (run.number, have) != self._offered:
                self._offered = (run.number, have)
                self.terms.show_value(float(min(most, have + (1 if most == MAXIMUM[False] else 8))))
        enable(self.more, why, "Continue up to this number of terms")
        enable(self.terms, why)

    def show_chosen(self, run: Run | None, live: Live | None, terms: int | None) -> None:
        """The figures of the chosen run at so many terms."""
        term_error = live.term_error(terms) if live is not None else None
        failed = live.why if live is not None else ""
        why_not = NOTHING if run is None else "" if term_error is not None else failed or "Nothing has been found yet"
        self.failed.setText(failed)
        self.failed.setVisible(bool(failed))
        enable(self.export, why_not, "Write the textures as EXR and their description as JSON, into a folder")
        enable(self.use, why_not, "Use these factors as the BRDF of the material in the View workspace")
        if run is None or live is None or term_error is None or live.factorisation is None:
            for figure in (self.of, self.many, self.bytes, self.time, *self.errors.values()):
                figure.setText("–")
            self.remark.setText("")
            self.bands.show_bands((), "")
            self.uses.setText("–")
            return
        self.of.setText(breakable(f"{run.name}, {method_of(run, live)}"))
        self.of.setToolTip(f"{run.name}, {method_of(run, live)}")
        self.many.setText(
            f"{term_error.terms} of {live.term_errors[-1].terms} · "
            f"{term_error.textures} texture{'s'[: term_error.textures != 1]}"
        )
        fewer = why_fewer(run, live)
        self.fewer.setText(fewer)
        self.fewer.setVisible(bool(fewer))
        self.bytes.setText(size_text(term_error.size_bytes))
        self.time.setText(time_text(term_error.time_s, 3))
        for name, figure in self.errors.items():
            value, unit = term_error.error(name), METRICS[name][1]
            figure.setText("–" if value is None else f"{number(value, 3)} {unit}".strip())
        self.remark.setText(remark_of(live.factorisation))
        self.bands.show_bands(term_error.rms_by_elevation_band, run.colour)

    def show_uses(self, sentences: Sequence[str]) -> None:
        """Show the sentences on the possible uses of the chosen factors."""
        self.uses.setText("\n\n".join(sentences) if sentences else "–")

    def _row_changed(self, item: QListWidgetItem | None, _before: QListWidgetItem | None) -> None:
        if not self._filling and item is not None:
            self.run_wanted.emit(item.data(NUMBER))

    def apply_theme(self) -> None:
        """Draw the markers against the current theme."""
        self._filling = True
        self.list.clear()
        self._filling = False
        self.remove.setIcon(theme.icon("cancel"))
        self.bands.apply_theme()


class BandPlot(Plot):
    """The cosine-weighted error in nine bands of the viewer's elevation."""

    def __init__(self) -> None:
        super().__init__("Elevation / °", "RMS / sr⁻¹")
        self.setAccessibleName("Error by the viewer's elevation")
        self.setToolTip("Cosine-weighted RMS at this elevation of the viewer")
        self.setFixedHeight(118)
        self.bars = pg.BarGraphItem(x=[], height=[], width=8.0)
        self.addItem(self.bars)
        self.setXRange(0.0, 90.0, padding=0.01)
        self.getPlotItem().getAxis("bottom").setTickSpacing(30, 30)

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        event.accept()

    def show_bands(self, errors: Sequence[float], colour: str) -> None:
        """`errors` from the horizon upwards, in sr⁻¹."""
        self.bars.setVisible(bool(errors))
        if errors:
            wide = 90.0 / len(errors)
            middles = (np.arange(len(errors)) + 0.5) * wide
            self.bars.setOpts(x=middles, height=np.array(errors), width=0.8 * wide, brush=colour, pen=None)
            self.setYRange(0.0, 1.1 * max(max(errors), 1e-12), padding=0)


def method_of(run: Run, live: Live) -> str:
    """The name of the method; of 'auto' the chosen method, once that is known."""
    found = live.factorisation.method if live.factorisation is not None else ""
    if run.choices is None:
        return METHODS.get(found, found or "Factors")
    words = METHODS[run.choices.method]
    if run.choices.method == "auto" and found in METHODS:
        return METHODS[found]
    return words


def _form_of(run: Run) -> str:
    """The settings in which runs of the same method differ, in short."""
    if run.choices is None:
        return " from a file"
    choices = run.choices
    form = {"in-out": "", "half-diff": ", half/difference", "auto": ", any"}[choices.parametrisation]
    return f"{form}, {choices.texels}²"


def settings_of(run: Run) -> str:
    """All settings that a run read, in two lines; nothing for factors of a file."""
    choices = run.choices
    if choices is None:
        return ""
    words = [PARAMETRISATIONS[choices.parametrisation]]
    if choices.separable:
        words += [f"{MAPS[choices.map].lower()} map"]
    elif choices.reciprocal:
        words += ["reciprocal"]
    if choices.method == "search":
        words += [f"{PRESETS[choices.preset].lower()}, {choices.restarts} restarts, {choices.together} together"]
        words += [f"makes {METRICS[choices.metric][0].lower()} small"]
    samples = f"{choices.samples} samples up to {choices.max_theta_deg:g}°, seed {choices.seed}"
    return f"{', '.join(words)}\n{samples}"


def state_of(live: Live) -> str:
    """The state of a run, in a few words with its time."""
    job = live.job
    if job is None:
        last = live.term_errors[-1] if live.term_errors else None
        if last is None:
            return live.state or "nothing found"
        return f"{live.state}, {time_text(last.time_s)}" if live.state != "opened" else live.state
    if job.stopping:
        return "stopping…"
    if job.state in ("queued", "paused"):
        share = f", {100 * job.step.done:.0f} %" if job.begun else ""
        return f"{'waiting' if job.state == 'queued' else 'paused'}{share}"
    left = job.left_s
    more = f", {time_left(left)}" if left is not None and left >= 1 else ""
    return f"{100 * job.step.done:.0f} %{more}"


def why_fewer(run: Run, live: Live) -> str:
    """Why a run that has ended has fewer terms than were asked for; empty where it has as many."""
    found, choices = live.factorisation, run.choices
    if found is None or choices is None or live.job is not None or not found.term_errors:
        return ""
    from engine.factor.errors import stop_reason  # loaded with the first result

    have = found.term_errors[-1].terms
    limit = choices.products if live.is_sum else choices.textures
    wanted = choices.products if choices.method == "auto" else limit
    reason = stop_reason(found) if have < limit else "a search makes no more textures" if have < wanted else ""
    return f"{have} of {wanted} terms: {reason}." if reason else ""


def remark_of(factorisation: Factorisation) -> str:
    """Further properties of a factorisation, in one line each."""
    lines = []
    if factorisation.optimum_ratio:
        lines.append(f"Error over the optimum of Eckart and Young: {number(factorisation.optimum_ratio, 6)}")
    if hasattr(factorisation.factors, "hemisphere_map"):
        lines.append(f"Asymmetry of the matrix: {number(factorisation.asymmetry)}")
    if factorisation.condition_number > 1.0:
        lines.append(f"Condition number: {number(factorisation.condition_number)}")
    if factorisation.evaluations:
        tried = f"{factorisation.evaluations:,}".replace(",", " ")
        lines.append(f"{tried} projections tried")
    term_errors = factorisation.term_errors
    lowest = min(term_errors, key=lambda term_error: term_error.rms_cosine_weighted) if term_errors else None
    if lowest is not None and lowest.terms < term_errors[-1].terms:
        lines.append(f"RMS × cos is lowest with {lowest.terms} term{'s'[: lowest.terms != 1]}")
    best = factorisation.best_terms
    if best is not None:
        further = "; more make it worse and are not stored" if factorisation.left_out else ""
        lines.append(f"Held-out errors are best with {best} term{'s'[: best != 1]}{further}")
    if factorisation.choice:
        lines.append(factorisation.choice)
    if factorisation.unmeasured:
        lines.append(factorisation.unmeasured)
    return "\n".join(lines)


def _row(*parts: tuple[QWidget, int]) -> QWidget:
    holder = QWidget()
    row = QHBoxLayout(holder)
    row.setContentsMargins(0, 0, 0, 0)
    row.setSpacing(STEP)
    for widget, stretch in parts:
        row.addWidget(widget, stretch)
    return holder


def _where(name: str) -> str:
    if name.startswith("held_out"):
        return "at samples of regions of directions held out in turn, or between texels"
    return "over random pairs of directions" if name == "rms_cosine_weighted" else "over the samples and channels"
