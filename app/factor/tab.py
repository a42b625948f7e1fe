"""The Factor workspace: a BRDF becomes textures, by several methods side by side, with their errors and costs."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator
from pathlib import Path

from PySide6.QtCore import Qt, QTimer, Signal
from PySide6.QtGui import QKeySequence, QShortcut
from PySide6.QtWidgets import QFileDialog, QStackedWidget, QVBoxLayout, QWidget

from app.commands import brdf as commands_brdf
from app.commands.factor import export as export_factors
from app.commands.factor import judge
from app.commands.workbench import Workbench
from app.document.comparison import Entry
from app.document.document import Project
from app.document.factoring import METRICS, Factoring, Run
from app.document.following import Following
from app.factor.images import ProjectionsView, TextureImage, TexturesView, texture_images
from app.factor.inspector import FactorInspector
from app.factor.plot import AGAINST, SAVE, ErrorPlot, errors_as_csv
from app.factor.preview import FactorPreview
from app.factor.runs import GONE, FactorRuns, Live, choices_of, files_of, name_of, source_of
from app.factor.settings import FactorSettingsPanel
from app.jobs.jobs import Job
from app.jobs.newest import Latest
from app.widgets import theme
from app.widgets.controls import ComboBox
from app.widgets.empty_state import EmptyState
from app.widgets.number_field import NumberField
from app.widgets.panels import Segments, small_button
from app.widgets.plot_files import png, save, svg
from app.widgets.tiles import Tile, Tiles
from app.widgets.workspace import bar_of_choices, put_beside, side_by_side, under
from engine.factor.separable_factors import SeparableFactors
from engine.factor.settings import FactorSettings

#: Least time between two updates of the results of a run, and of its preview on the model while the run goes on.
SHOW_EVERY_MS, PREVIEW_EVERY_MS = 120, 700


#: Files that the error plot is saved as.
FORMATS = (".png", ".svg", ".csv")
PLOT_FILES = "PNG image (*.png);;SVG drawing (*.svg);;Values as CSV (*.csv)"


class FactorTab(QWidget):
    """Shows the project's runs, once `fill` has been through.

    What is plotted, the exposure and the model of the preview are this tab's own.
    """

    drawn = Signal(float)
    broken = Signal(object)

    def __init__(self, bench: Workbench) -> None:
        super().__init__()
        self.bench = bench
        self.runs = FactorRuns(bench)
        self.picturing = Latest(bench.jobs, "Drawing textures")
        self.judging = Latest(bench.jobs, "Judging factors")
        self.exposure_ev = 0.0
        self.showing, self.previewing = QTimer(self), QTimer(self)
        for timer, shows in ((self.showing, self._show_live), (self.previewing, self._show_preview)):
            timer.setSingleShot(True)
            timer.timeout.connect(shows)
        self._imaged: tuple[object, float] = (None, 0.0)
        self._judged: tuple[object, int] = (None, 0)

    def fill(self) -> Iterator[None]:
        """Make what is in it, a part with each step, and each at once where it stays: moving widgets costs time."""
        work = side_by_side()
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.addWidget(work)
        self.settings = FactorSettingsPanel()
        put_beside(work, self.settings)
        yield
        self.plot = ErrorPlot()
        yield
        self.preview = FactorPreview(self.bench.jobs)
        yield
        put_beside(work, self._make_centre(), takes_room=True)
        yield
        self.inspector = FactorInspector()
        put_beside(work, self.inspector)
        yield
        self._connect()
        yield
        self._on_changed(Project(), self.bench.document.project)

    def _make_centre(self) -> QWidget:
        self.measure = ComboBox()
        for name, (words, _unit) in METRICS.items():
            self.measure.addItem(words, name)
        self.measure.setAccessibleName("Plotted error")
        self.measure.setMinimumContentsLength(14)
        self.measure.setToolTip("The error that the plot shows")
        self.measure.activated.connect(lambda _at: self._show_plot())
        self.against = Segments(
            (
                ("terms", "Terms", "Error against the number of terms"),
                ("time", "Time", "Error against time, with every intermediate result"),
                ("bytes", "Size", "Error against the bytes of the textures"),
            )
        )
        assert set(self.against.buttons) == set(AGAINST)
        self.against.choose("terms")
        self.against.setMinimumWidth(216)
        self.against.chosen.connect(lambda _value: self._show_plot())
        self.exposure = NumberField(0.0, -20.0, 20.0, unit="EV")
        self.exposure.setAccessibleName("Exposure of the textures")
        self.exposure.setToolTip("Brightness of the textures")
        self.exposure.setFixedWidth(64)
        self.exposure.edited.connect(lambda value, _final: self._set_exposure(value))
        self.model = Segments(
            (
                ("sphere", "Sphere", "Preview on a sphere"),
                ("view", "Model", "Preview on the model of the View workspace"),
            )
        )
        self.model.choose("sphere")
        self.model.setFixedWidth(160)
        self.model.chosen.connect(lambda _value: self._show_mesh())
        bar, row = bar_of_choices()
        row.addWidget(self.measure)
        row.addWidget(self.against)
        row.addStretch(1)
        self.save = small_button("export", SAVE)
        self.save.clicked.connect(self._save_plot)
        self.textures = TexturesView()
        self.projections = ProjectionsView()
        self.tile_of = {
            "plot": Tile("Error", self.plot, self.save),
            "projections": Tile("Projections", self.projections),
            "textures": Tile("Textures", self.textures, self.exposure),
            "preview": Tile("Preview", self.preview, self.model),
        }
        places = {
            "plot": (0, 0, 1, 3),
            "projections": (0, 3, 1, 2),
            "textures": (1, 0, 1, 5),
            "preview": (2, 0, 1, 5),
        }
        self.tiles = Tiles({self.tile_of[name]: place for name, place in places.items()})
        for place, stretch in enumerate((5, 4, 6)):
            self.tiles.grid.setRowStretch(place, stretch)
        self.empty = EmptyState(
            "factor",
            "Nothing factored yet",
            "Choose a BRDF and a method on the left and press Factor. Several methods can run side by side; "
            "their errors, textures and projections appear here while they run.",
            (("Factor", "factor", self.settings.start_wanted), ("Open factors…", "folder", self.settings.open_wanted)),
        )
        self.pages = QStackedWidget()
        self.pages.addWidget(self.empty)
        self.pages.addWidget(self.tiles)
        return under(bar, self.pages)

    def _connect(self) -> None:
        settings, inspector, runs = self.settings, self.inspector, self.runs
        settings.source_wanted.connect(self._set_source)
        settings.edited.connect(self._on_edited)
        settings.start_wanted.connect(self.start)
        settings.open_wanted.connect(self._browse)
        inspector.run_wanted.connect(lambda number: self.choose(number, None))
        inspector.pause_wanted.connect(lambda: self._with_run(self._pause_or_go_on))
        inspector.stop_wanted.connect(lambda: self._with_run(runs.cancel))
        inspector.remove_wanted.connect(lambda: self._with_run(self._remove))
        inspector.more_wanted.connect(lambda terms: self._with_run(lambda run: runs.more(run, terms)))
        inspector.export_wanted.connect(lambda: self._with_run(self._export))
        inspector.use_wanted.connect(lambda: self._with_run(self._use))
        self.plot.picked.connect(self.choose)
        self.plot.save_wanted.connect(self._save_plot)
        self.textures.picked.connect(lambda terms: self._with_run(lambda run: self.choose(run.number, terms)))
        self.preview.drawn.connect(self.drawn)
        self.preview.broken.connect(self.broken)
        runs.changed.connect(lambda _number: self._soon(self.showing, SHOW_EVERY_MS))
        runs.found.connect(lambda _number: self._soon(self.showing, SHOW_EVERY_MS))
        start = QShortcut(QKeySequence("Ctrl+Return"), self, context=Qt.ShortcutContext.WindowShortcut)
        start.activated.connect(self.start)
        self.bench.factors.connect(runs.open)
        self.following = Following(self.bench.document, self, self._on_changed)

    @property
    def factoring(self) -> Factoring:
        """The factor runs and settings of the project."""
        return self.bench.document.project.factoring

    @property
    def live(self) -> Live | None:
        """The state of the chosen run."""
        run = self.factoring.run
        return self.runs.of(run) if run is not None else None

    def _with_run(self, work: Callable[[Run], object]) -> None:
        run = self.factoring.run
        if run is not None:
            work(run)

    def start(self) -> None:
        """Start a run with the choices on the left."""
        self.runs.start()

    def choose(self, number: int, terms: int | None) -> None:
        """Preview and export so many terms of a run; None for all that it has."""
        factoring, run = self.factoring, self.factoring.find(number)
        if run is None or (factoring.current, factoring.terms) == (number, terms):
            return
        words = f"Choose {run.name}" if terms is None else f"Choose {terms} term{'s'[: terms != 1]} of {run.name}"
        self._change(words, current=number, terms=terms)

    def _change(self, words: str, gesture: str = "", **parts: object) -> None:
        factoring = dataclasses.replace(self.factoring, **parts)  # type: ignore[arg-type]
        self.bench.document.change(words, gesture=gesture, factoring=factoring)

    def _set_source(self, source: str) -> None:
        if source != self.factoring.source:
            self._change(f"Factor {name_of(self.bench.document.project, source)} next", source=source)

    def _on_edited(self, choices: FactorSettings, final: bool) -> None:
        if choices != self.factoring.choices:
            self._change("Change how to factor", gesture="factor choices", choices=choices)
        else:
            self._show_settings()
        if final:
            self.bench.document.end_gesture()

    def _pause_or_go_on(self, run: Run) -> None:
        job = self.runs.of(run).job
        if job is None:
            self.runs.again(run)
        elif job.state == "paused":
            self.runs.resume(run)
        else:
            self.runs.pause(run)

    def _remove(self, run: Run) -> None:
        self.bench.document.change(f"Remove a run of {run.name}", factoring=self.factoring.without(run.number))

    def _browse(self) -> None:
        chosen = QFileDialog.getExistingDirectory(self, "Open a folder of factors")
        if chosen:
            self.runs.open(Path(chosen))

    def _export(self, run: Run) -> None:
        proposed = self.bench.propose(f"{run.name} factors")
        chosen, _ = QFileDialog.getSaveFileName(self, "Export factors to a new folder", str(proposed))
        if chosen:
            self.bench.write_into(Path(chosen).parent)
            self.export(Path(chosen))

    def export(self, folder: Path) -> None:
        """Write the chosen factors to `folder`, in a job."""
        live = self.live
        term_error = live.term_error(self.factoring.terms) if live is not None else None
        if live is None or term_error is None or live.factorisation is None:
            return
        factorisation = live.factorisation
        job = self.bench.jobs.submit(
            f"Writing {folder.name}", lambda: export_factors(factorisation, term_error.terms, folder), lane="save"
        )
        job.succeeded.connect(self.bench.said.emit)

    def _use(self, run: Run) -> None:
        """The material reflects as the chosen factors do, and is seen in View."""
        factors = self.runs.of(run).factors(self.factoring.terms)
        if factors is not None:
            name = f"{run.name}, {factors.terms} term{'s'[: factors.terms != 1]}"
            commands_brdf.use(self.bench, Entry(name, dataclasses.replace(factors, name=name), run.identity))
            self.bench.wanted.emit("view")

    def _save_plot(self) -> None:
        """Ask for a file of the plot, whose ending says what it holds."""
        proposed = f"{self.bench.propose('factor-errors')}.png"
        chosen, kind = QFileDialog.getSaveFileName(self, "Save the error plot", proposed, PLOT_FILES)
        if chosen:
            path = Path(chosen)
            if path.suffix.lower() not in FORMATS:
                path = path.with_name(path.name + next(each for each in FORMATS if f"*{each}" in (kind or "*.png")))
            self.bench.write_into(path.parent)
            self.save_plot(path)

    def save_plot(self, path: Path) -> Job:
        """Write the plot as it is on screen, or the errors of all runs, as the ending of `path` says."""
        runs = [(run, self.runs.of(run)) for run in self.factoring.runs]
        make = {".png": lambda: png(self.plot), ".svg": lambda: svg(self.plot), ".csv": lambda: errors_as_csv(runs)}
        content = make[path.suffix.lower()]()
        job = self.bench.jobs.submit(
            f"Saving {path.name}", lambda: save(path.parent, {path.name: content}), lane="save"
        )
        job.succeeded.connect(self.bench.said.emit)
        return job

    def _set_exposure(self, value: float) -> None:
        self.exposure_ev = value
        self._show_textures()

    def _on_changed(self, old: Project, new: Project) -> None:
        if any(getattr(old, part) is not getattr(new, part) for part in ("factoring", "comparison", "material")):
            self._show_settings()
        if old.mesh is not new.mesh:
            self._show_mesh()
        if old.factoring is not new.factoring or not new.factoring.runs:
            self.pages.setCurrentIndex(1 if new.factoring.runs else 0)
            self.inspector.setVisible(bool(new.factoring.runs))
            self._show_runs()
            self._show_found()

    def _show_settings(self) -> None:
        project = self.bench.document.project
        factoring = project.factoring
        self.settings.show_sources(
            choices_of(project), files_of(project), factoring.source, name_of(project, factoring.source)
        )
        self.settings.show_factoring(factoring, "" if source_of(project, factoring.source) is not None else GONE)

    @staticmethod
    def _soon(timer: QTimer, pause_ms: int) -> None:
        if not timer.isActive():
            timer.start(pause_ms)

    def _show_live(self) -> None:
        """Show the states and results of the runs; the model follows more slowly."""
        self._show_runs()
        self._show_errors()
        live = self.live
        self._soon(self.previewing, PREVIEW_EVERY_MS if live is not None and live.job is not None else 0)

    def _show_runs(self) -> None:
        """The states of the runs, which change with every step."""
        factoring = self.factoring
        self.inspector.show_runs(factoring, [self.runs.of(run) for run in factoring.runs])

    def _show_found(self) -> None:
        """Everything that was found, at once."""
        self._show_errors()
        self._show_preview()

    def _show_errors(self) -> None:
        """Errors, textures, projections and figures."""
        if not self.isVisible():
            return
        factoring, live = self.factoring, self.live
        self._show_plot()
        factors = live.factors(factoring.terms) if live is not None else None
        self.inspector.show_chosen(factoring.run, live, factoring.terms)
        self.projections.show_factors(factors)
        self._show_textures()
        self._judge()

    def _show_preview(self) -> None:
        """The factors on the model, beside the BRDF itself."""
        if self.isVisible():
            live = self.live
            factors = live.factors(self.factoring.terms) if live is not None else None
            self._show_mesh()
            self.preview.show_pair(factors, live.brdf if live is not None else None)

    def _show_plot(self) -> None:
        factoring, live = self.factoring, self.live
        term_error = live.term_error(factoring.terms) if live is not None else None
        chosen = (
            (factoring.current, term_error.terms) if term_error is not None and factoring.current is not None else None
        )
        pairs = [(run, self.runs.of(run)) for run in factoring.runs]
        self.plot.show_errors(pairs, self.against.value, str(self.measure.currentData()), chosen)

    def _show_textures(self) -> None:
        """All textures of separable factors, the unused ones pale; of others those of the chosen number of terms."""
        factoring, live = self.factoring, self.live
        if live is None or live.factorisation is None:
            self._imaged = (None, 0.0)
            self.textures.show_images([], None)
            return
        chosen = live.factors(factoring.terms) or live.factorisation.factors
        shown = live.factorisation.factors if isinstance(chosen, SeparableFactors) else chosen
        terms = chosen.terms
        if self._imaged == (shown, self.exposure_ev):
            self.textures.show_images(self.textures.strip.images, terms)
            return
        exposure_ev = self.exposure_ev

        def show(images: list[TextureImage]) -> None:
            self._imaged = (shown, exposure_ev)
            self.textures.show_images(images, terms)

        self.picturing.ask(lambda: texture_images(shown, exposure_ev), show)

    def _show_mesh(self) -> None:
        self.preview.show_mesh(self.bench.document.project.mesh if self.model.value == "view" else None)
        nothing = "" if self.bench.document.project.mesh is not None else "Load a model in the View workspace first"
        self.model.disable("view", nothing)

    def _judge(self) -> None:
        """Judge the possible uses of the chosen factors, once no better ones are coming."""
        factoring, live = self.factoring, self.live
        term_error = live.term_error(factoring.terms) if live is not None else None
        if live is None or term_error is None or live.factorisation is None:
            self._judged = (None, 0)
            self.inspector.show_uses(())
            return
        factorisation, brdf = live.factorisation, live.brdf
        if self._judged != (factorisation, term_error.terms):
            self._judged = (factorisation, term_error.terms)
            self.judging.ask(lambda: judge(factorisation, term_error.terms, brdf), self.inspector.show_uses)

    def showEvent(self, event: object) -> None:
        super().showEvent(event)  # type: ignore[arg-type]
        self._show_runs()
        self._show_found()

    def apply_theme(self) -> None:
        """Redraw what does not follow the palette by itself."""
        self.plot.apply_theme()
        self.save.setIcon(theme.icon("export"))
        self.inspector.apply_theme()
        self.empty.apply_theme()
        for tile in self.tiles.places:
            tile.show_enlarged(tile is self.tiles.large)
        for view in self.preview.views.values():
            view.redraw()
        for painted in (self.textures.strip, self.projections.inside, self.preview.difference):
            painted.update()
        self._show_runs()
        self._show_found()
