"""The Accuracy dock: error against cost as a plot of all modes, its measurement, and the choice by a budget."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from PySide6.QtCore import QSize, Qt, QTimer, Signal
from PySide6.QtGui import QResizeEvent, QShowEvent
from PySide6.QtWidgets import (
    QBoxLayout,
    QDockWidget,
    QFrame,
    QLabel,
    QLineEdit,
    QVBoxLayout,
    QWidget,
)

from app.commands.workbench import Workbench
from app.document.document import Project
from app.document.measured import (
    AXES,
    Accuracy,
    accuracy_of,
    same_key,
    scene_key,
    setting_text,
    size_of,
)
from app.document.measured import (
    measure as measured,
)
from app.document.modes import mode_named, modes, why_not
from app.jobs.jobs import Job
from app.view.tab import ViewTab
from app.widgets import theme
from app.widgets.controls import ComboBox
from app.widgets.language import translate
from app.widgets.number_field import NUMERIC, mark
from app.widgets.panels import SCROLL_BAR, Rows, Scrolled, button, enable, text, with_buttons
from app.widgets.theme import PADDING, STEP, role
from engine.core.cached import cached_property
from engine.core.errors import UsageError
from engine.core.figure_text import percent, time_text
from engine.core.steps import Step
from engine.tradeoff.front import Choice, budget_from_text, choose

if TYPE_CHECKING:
    from app.docks.tradeoff_plot import TradeoffPlot

BUDGET = "Enter it as '8 ms and 100 MB' or '1 %'."

#: Time limits of a sweep, in seconds, and their labels.
TIMES = ((30, "30 s"), (60, "1 min"), (120, "2 min"), (300, "5 min"), (900, "15 min"), (3600, "1 h"))

#: From this width on the plot stands beside the controls instead of above them.
WIDE = 480

CONTROLS = 300

#: Width of the dock below which its controls would be cut.
NARROWEST = 332

#: Least height of the plot, and while there is nothing in it.
PLOT_PX, EMPTY_PX = 120, 40


class AccuracyDock(QDockWidget):
    """Keeps what it measures in the project. `applied(Setting)` asks the View workspace for a setting."""

    applied = Signal(object)

    def __init__(self, bench: Workbench, view: ViewTab, parent: QWidget) -> None:
        super().__init__("Accuracy", parent)
        self.setObjectName("accuracy")
        self.bench, self.view = bench, view
        self.job: Job | None = None
        self.live: Accuracy | None = None
        self.choice: Choice | None = None
        self._is_to_apply = False
        self.legend = Legend()
        scroll = Scrolled()  # rather than squeezes its rows where the dock is low
        scroll.setWidgetResizable(True)
        scroll.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        scroll.setFrameShape(QFrame.Shape.NoFrame)
        scroll.setWidget(self._inside())
        scroll.setMinimumWidth(NARROWEST + SCROLL_BAR)
        self.setWidget(scroll)
        self.applied.connect(view.apply_setting)
        bench.document.changed.connect(self._on_changed)
        for changed in (view.setting_changed, view.model_ready, view.brdf_panel.ready):
            changed.connect(self._show)
        self._show()

    @cached_property
    def plot(self) -> TradeoffPlot:
        """The plot, which is made when it is first seen: its library takes longer than the rest of the window."""
        from app.docks.tradeoff_plot import TradeoffPlot

        plot = TradeoffPlot()
        plot.picked.connect(self.applied)
        self.left.addWidget(plot, 1)
        return plot

    @property
    def _has_plot(self) -> bool:
        return "plot" in vars(self)

    def _make_plot(self) -> None:
        """Make the plot on its own: with the work of the event that shows the dock it would hold up the window."""
        if self.isVisible() and not self._has_plot:
            self.plot  # noqa: B018 - made when it is first asked for
            self._show()

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
        self._show()

    def sizeHint(self) -> QSize:
        return QSize(320, 300)

    def _inside(self) -> QWidget:
        holder = role(QWidget(), "panel")
        holder.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self.layout_ = QBoxLayout(QBoxLayout.Direction.TopToBottom, holder)
        self.layout_.setContentsMargins(PADDING, STEP, PADDING, STEP)
        self.layout_.setSpacing(2 * STEP)
        self.left = QVBoxLayout()
        self.left.setSpacing(0)
        self.left.addWidget(self.legend)
        self.layout_.addLayout(self.left, 1)
        self.controls = Rows()
        self._fill(self.controls)
        self.layout_.addWidget(self.controls, 0, Qt.AlignmentFlag.AlignTop)
        return holder

    def _fill(self, rows: Rows) -> None:
        self.axis = ComboBox()
        for value, (words, _) in AXES.items():
            self.axis.addItem(words, value)
        self.axis.activated.connect(lambda _index: self._show())
        rows.row("Against", self.axis, "Cost on the horizontal axis")
        self.budget = QLineEdit()
        self.budget.setProperty(NUMERIC, True)
        self.budget.setPlaceholderText("1 % or 8 ms, 100 MB")
        self.budget.setClearButtonEnabled(True)
        self.budget.textChanged.connect(lambda _words: self._show_choice())
        self.budget.returnPressed.connect(self._apply_choice)
        rows.row(
            "Budget",
            self.budget,
            "Largest error, time or memory: the best setting within it is named. Enter applies it, and measures before "
            "where nothing is measured yet",
        )
        self.modes = ComboBox()
        self.time = ComboBox()
        for seconds, words in TIMES:
            self.time.addItem(words, seconds)
        self.time.setCurrentIndex(2)  # as long as `lightarc tradeoff` takes
        both = with_buttons(self.modes, self.time)
        self.modes.setAccessibleName("Modes to measure")
        self.time.setAccessibleName("Time to measure for")
        self.time.setToolTip("Time limit; settings that do not fit into it are skipped")
        rows.row("Measure", both)
        self._fill_modes(self.bench.document.project)
        self.go = button(
            "Measure", "primary", hint="Draw with all settings and compare with the reference, in the background"
        )
        self.go.clicked.connect(self._start_or_stop)
        rows.wide(self.go)
        self.words = text("", "secondary", wrap=True)
        rows.wide(self.words)

    def _fill_modes(self, project: Project) -> None:
        chosen = self.modes.currentData()
        self.modes.clear()
        self.modes.addItem("All modes", "")
        for mode in modes():
            if not why_not(mode, project):
                self.modes.addItem(mode.label, mode.value)
        self.modes.setCurrentIndex(max(0, self.modes.findData(chosen)))

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        is_wide = self.width() >= WIDE
        self.layout_.setDirection(QBoxLayout.Direction.LeftToRight if is_wide else QBoxLayout.Direction.TopToBottom)
        self.controls.setMaximumWidth(CONTROLS if is_wide else 1 << 20)
        self.controls.setMinimumWidth(CONTROLS if is_wide else 0)

    def _on_changed(self, old: Project, new: Project) -> None:
        if old.has_map != new.has_map or old.look.lookup != new.look.lookup:
            self._fill_modes(new)
        self._show()

    @property
    def accuracy(self) -> Accuracy | None:
        """The shown sweep: the one that runs, otherwise the one that the project keeps."""
        return self.live or self.bench.document.project.accuracy

    @property
    def is_stale(self) -> bool:
        """True if the points belong to another scene than the one on screen."""
        scene, accuracy = self.view.scene(self.bench.document.project), self.accuracy
        bounces = self.bench.document.project.look.bounces
        return accuracy is not None and scene is not None and not same_key(accuracy.of, scene_key(scene, bounces))

    def _show(self) -> None:
        accuracy = self.accuracy
        if self.isVisible() and not self._has_plot:
            QTimer.singleShot(0, self, self._make_plot)
        if self._has_plot:
            self.plot.show_points(accuracy, self.axis.currentData(), self.view.setting)
            self.plot.setEnabled(accuracy is not None)
            self.plot.setMinimumHeight(PLOT_PX if accuracy is not None else EMPTY_PX)
        self.legend.show_modes(
            [mode.value for mode in modes() if accuracy and any(p.mode == mode.value for p in accuracy.points)]
        )
        running = self.job is not None
        self.go.setText("Stop measuring" if running else "Measure")
        scene = self.view.scene(self.bench.document.project)
        enable(self.go, "" if running or scene is not None else "There is no model yet")
        for choice in (self.modes, self.time):
            choice.setEnabled(not running)
        self._show_choice()

    def _show_choice(self) -> None:
        """Show the setting that the budget chooses, or the state of the sweep."""
        self.choice = None
        accuracy, words = self.accuracy, self.budget.text().strip()
        mark(self.budget, why_no_budget(words))
        if words and accuracy is not None and not (self.is_stale or self._is_to_apply):
            try:
                self.choice = choose(accuracy.points, budget_from_text(words), self.axis.currentData())
            except UsageError:
                self.words.setText(BUDGET)
                return
            point = self.choice.point
            if point is None:
                left = len(accuracy.unmeasured)
                were = "1 was" if left == 1 else f"{left} were"
                self.words.setText(f"{self.choice.reason}." + (f" {were} skipped: measure for longer." if left else ""))
            else:
                error = f"{percent(point.error_rmse_rel)} in {time_text(point.frame_s)}"
                then = "It is on screen." if point.setting == self.view.setting else "Enter applies it."
                self.words.setText(f"{setting_text(point.setting)}: {error}. {then}")
            return
        varied = " Spatial variation is not included." if self.bench.document.project.variations else ""
        self.words.setText(f"{self._state()}{varied}")

    def _state(self) -> str:
        accuracy = self.accuracy
        if self.job is not None:
            done = len(accuracy.points) if accuracy is not None and self.live is not None else 0
            then = " The best within the budget is applied then." if self._is_to_apply else ""
            return f"{done} setting{'s' * (done != 1)} measured so far.{then}"
        if accuracy is None and self.budget.text().strip():
            return "Nothing measured yet. Enter measures and uses the best."
        if accuracy is None:
            return "Nothing measured yet on this scene."
        if self.is_stale:
            return "Measured on another scene: measure again."
        left, count = len(accuracy.unmeasured), len(accuracy.points)
        words = f"{count} setting{'s' * (count != 1)} at {accuracy.size[0]} × {accuracy.size[1]}"
        words += f", {left} skipped" if left else ""
        words += f", {self.plot.free} take none" if self.plot.free else ""
        return f"{words}. Click a point to use it."

    def _apply_choice(self) -> None:
        """Apply what the budget chooses; where nothing of this scene was measured, measure first."""
        words = self.budget.text().strip()
        if self.choice is not None:
            if self.choice.point is not None:
                self.applied.emit(self.choice.point.setting)
        elif words and not why_no_budget(words):
            self._is_to_apply = True
            if self.job is None:
                self._start_or_stop()
            self._show()

    def measure(self) -> None:
        """Measure all modes, unless something is being measured."""
        if self.job is None:
            self.modes.setCurrentIndex(0)
            self._start_or_stop()

    def _start_or_stop(self) -> None:
        if self.job is not None:
            self.bench.jobs.cancel(self.job)
            return
        project = self.bench.document.project
        scene = self.view.scene(project)
        if scene is None:
            self._is_to_apply = False
            return
        chosen = self.modes.currentData()
        offered = [mode for mode in modes() if not why_not(mode, project)]
        whole = [mode.value for mode in offered if not (project.has_map and mode.baked)]
        wanted = [chosen] if chosen else whole
        bases = [setting for mode in wanted if (setting := self.view.setting_of(mode)).mode == mode]
        size, bounces = size_of(self.view.viewport.screen_px()), project.look.bounces
        seconds, of = float(self.time.currentData()), scene_key(scene, bounces)
        job = self.bench.jobs.submit(
            "Measuring accuracy",
            lambda: measured(scene, wanted, bases, size, seconds, bounces),
            lane="compute",
            alone=True,
        )
        self.job = job
        job.progressed.connect(lambda step: self._on_progressed(step, of))
        job.succeeded.connect(lambda found: self._keep(accuracy_of(found, of)))
        job.cancelled.connect(self._on_stopped)
        job.failed.connect(lambda _error: self._on_stopped())
        self._show()

    def _on_progressed(self, step: Step, of: tuple[Any, ...]) -> None:
        if step.partial is not None:
            before = self.bench.document.project.accuracy
            self.live = accuracy_of(step.partial, of).with_before(before)
            self._show()

    def _on_stopped(self) -> None:
        """Keep what was measured, and apply nothing."""
        self._is_to_apply = False
        self._keep(self.live)

    def _keep(self, found: Accuracy | None) -> None:
        """Keep the measured points in the project, also those of a stopped sweep."""
        self.job = self.live = None
        is_to_apply, self._is_to_apply = self._is_to_apply, False
        if found is not None and found.points:
            before = self.bench.document.project.accuracy
            self.bench.document.change("Measure accuracy", accuracy=found.with_before(before))
            count = len(found.points)
            self.bench.said.emit(f"{count} setting{'s' * (count != 1)} measured")
        self._show()
        if is_to_apply and self.choice is not None and self.choice.point is not None:
            self.applied.emit(self.choice.point.setting)

    def apply_theme(self) -> None:
        """Draw in the colours of the current theme."""
        if self._has_plot:
            self.plot.apply_theme()
        self.legend.apply_theme()


class Legend(QLabel):
    """The modes on the plot, each with its mark; takes two lines where one is too narrow."""

    def __init__(self) -> None:
        super().__init__()
        role(self, "secondary")
        self.modes: list[str] = []
        self.setTextFormat(Qt.TextFormat.RichText)
        self.setWordWrap(True)

    def show_modes(self, modes: list[str]) -> None:
        """Name these."""
        self.modes = modes
        shown = [mode_named(mode) for mode in modes]
        words = (
            f'<span style="color:{theme.line(m.colour)}">{m.mark[1]}</span>&nbsp;{translate(m.label)}' for m in shown
        )
        self.setText(" &nbsp; ".join(word.replace(" map", "&nbsp;map") for word in words))
        self.setVisible(bool(modes))

    def apply_theme(self) -> None:
        """Take the colours of the current theme."""
        self.show_modes(self.modes)


def why_no_budget(words: str) -> str:
    """The sentence that says what a budget is, where `words` are none; else empty."""
    try:
        if words:
            budget_from_text(words)
    except UsageError:
        return BUDGET
    return ""
