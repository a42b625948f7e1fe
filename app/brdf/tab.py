"""The BRDF workspace: BRDFs of every kind beside each other, their parameters, and fits of models to them."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator
from math import radians
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from PySide6.QtCore import Qt, QTimer, Signal
from PySide6.QtGui import QAction, QKeyEvent, QKeySequence, QShortcut
from PySide6.QtWidgets import QStackedWidget, QVBoxLayout, QWidget

from app.brdf import dialogs
from app.brdf.inspector import Inspector
from app.brdf.library import Library, missing_files
from app.brdf.lobe_view import Lobe, LobeView, lengths, surfaces
from app.brdf.plots import AlbedoPlot, HalfDifferencePlot, Line, PolarPlot
from app.brdf.sphere_preview import SpherePreview
from app.brdf.text_editor import TextEditor
from app.commands import brdf as commands_brdf
from app.commands.brdf_figures import ALBEDO_DEG, LIGHT_PHI, Curves, Facts, albedos, curves, facts
from app.commands.workbench import Workbench
from app.document.comparison import Comparison, Entry
from app.document.document import Project
from app.document.factoring import MATERIAL
from app.document.following import Following
from app.jobs.jobs import Job
from app.jobs.newest import Latest
from app.viewport.gl_surface import why_no_gl
from app.widgets import theme
from app.widgets.empty_state import EmptyState
from app.widgets.panels import Segments, text, tool
from app.widgets.param_form import NumberEditor
from app.widgets.plot_files import distinct, grid, save, svg, table
from app.widgets.theme import PADDING
from app.widgets.tiles import Tile, Tiles
from app.widgets.workspace import bar_of_choices, put_beside, side_by_side, under
from engine.brdf.written import WrittenBrdf
from engine.core.errors import MissingCapability
from engine.core.figure_text import number
from engine.core.params import Parameter

if TYPE_CHECKING:
    from engine.brdf.brdf import Brdf

LIGHT_DEG = 45.0
LIGHT = Parameter("light_deg", LIGHT_DEG, 0.0, 89.0, (0.0, 89.0), "°", "Angle of the light from the normal.", log=False)

#: Opacity of the lobes other than the current one.
OTHERS = 0.3

#: Pause after the last change before what takes longer is integrated.
AT_REST_MS = 200


@dataclasses.dataclass(frozen=True, eq=False)
class Shown:
    """One BRDF on screen: an entry of the list, or what a running fit has found so far."""

    number: int
    brdf: Brdf
    colour: str
    marker: str
    live: bool = False


class BrdfTab(QWidget):
    """Compares the project's BRDFs, once `fill` has been through.

    The current entry and the direction of the light are the tab's own.
    """

    drawn = Signal(float)
    broken = Signal(object)

    def __init__(self, bench: Workbench) -> None:
        super().__init__()
        self.bench = bench
        self.current: int | None = None
        self.light_deg = LIGHT_DEG
        self.known: dict[int, Curves] = {}
        self.albedos: dict[int, tuple[Any, Any]] = {}
        self.facts: Facts | None = None
        self.evaluating = Latest(bench.jobs, "Evaluating BRDFs")
        self.integrating = Latest(bench.jobs, "Integrating albedos")
        self.judging = Latest(bench.jobs, "Checking a BRDF")
        self.looking = Latest(bench.jobs, "Looking for files")
        self.at_rest = QTimer(self)
        self.at_rest.setSingleShot(True)
        self.at_rest.setInterval(AT_REST_MS)
        self.at_rest.timeout.connect(self._integrate)
        self._stale = True
        self._state: object = None
        self._on_screen: object = None
        self._albedos_shown: object = None

    def fill(self) -> Iterator[None]:
        """Make what is in it, a part with each step, and each at once where it stays: moving widgets costs time."""
        work = side_by_side()
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.addWidget(work)
        self.library = Library(self.bench)
        put_beside(work, self.library)
        yield
        self.polar = PolarPlot()
        yield
        self.slice = HalfDifferencePlot()
        yield
        self.albedo = AlbedoPlot()
        yield
        self.sphere = SpherePreview(self.bench.jobs)
        yield
        put_beside(work, self._make_centre(), takes_room=True)
        yield
        self.inspector = Inspector(self.bench)
        put_beside(work, self.inspector)
        yield
        self._connect()
        self._on_changed(Project(), self.bench.document.project)

    def _make_centre(self) -> QWidget:
        self.light = NumberEditor(LIGHT)
        self.light.slider.setAccessibleName("Angle of the light")
        self.light.setMaximumWidth(260)
        self.light.show_value(LIGHT_DEG)
        self.light.setToolTip("Angle of the light from the normal, in the plane of incidence")
        self.scale = Segments(
            (
                ("log", "Logarithmic", "Logarithmic length: shows dim parts and narrow highlights together (L)"),
                ("linear", "Linear", "Length in proportion to the value (L)"),
            )
        )
        self.scale.choose("log")
        self.view_action = QAction(theme.icon("fit"), "Reset the camera", self)
        self.view_action.setShortcut(QKeySequence("F"))
        self.view_action.setShortcutContext(Qt.ShortcutContext.WindowShortcut)
        self.view_action.triggered.connect(self.fit)
        self.addAction(self.view_action)
        bar, row = bar_of_choices()
        row.addWidget(text("Light", "secondary"))
        row.addWidget(self.light, 1)
        row.addWidget(self.scale)
        row.addWidget(tool(self.view_action))
        self.save_action = QAction(theme.icon("export"), "Save the plots as SVG and CSV…", self)
        self.save_action.triggered.connect(lambda _on=False: dialogs.save_plots(self, self.bench, self.save_plots))
        row.addWidget(tool(self.save_action))
        row.addStretch(1)
        self.space = QStackedWidget()
        self.lobes: LobeView | None = None
        self._make_lobes(why_no_gl())
        self.tile_of = {
            "lobe": Tile("Lobes", self.space),
            "sphere": Tile("Sphere", self.sphere),
            "polar": Tile("Plane of incidence", self.polar),
            "slice": Tile("θh × θd", self.slice),
            "albedo": Tile("Albedo", self.albedo),
        }
        places = {
            "lobe": (0, 0, 1, 4),
            "sphere": (0, 4, 1, 2),
            "polar": (1, 0, 1, 2),
            "slice": (1, 2, 1, 2),
            "albedo": (1, 4, 1, 2),
        }
        self.tiles = Tiles({self.tile_of[name]: place for name, place in places.items()})
        self.tiles.grid.setRowStretch(0, 6)
        self.tiles.grid.setRowStretch(1, 5)
        self.empty = EmptyState(
            "brdf",
            "Nothing to compare yet",
            "Double-click a model, a published material or a file of your own in the library, or drop measured "
            "BRDFs here: MERL, RGL, UTIA, Cornell, ASTM, CUReT, ALTA, CSV.",
            (("Open file…", "folder", self.library.browse_wanted),),
        )
        self.pages = QStackedWidget()
        self.pages.addWidget(self.empty)
        self.pages.addWidget(self.tiles)
        return under(bar, self.pages)

    def _make_lobes(self, why_not: str) -> None:
        """The view in space, or a sentence where there is no OpenGL; the other views do without."""
        while (old := self.space.widget(0)) is not None:
            self.space.removeWidget(old)
            old.deleteLater()
        if why_not:
            self.lobes = None
            said = f"{why_not}, and lobes in space need it. The other views work without."
            words = text(said, "secondary", wrap=True)
            words.setAlignment(Qt.AlignmentFlag.AlignCenter)
            words.setMargin(PADDING)
            self.space.addWidget(words)
            return
        self.lobes = LobeView()
        self.lobes.light_moved.connect(lambda angle, _final: self.set_light(angle))
        self.lobes.failed.connect(self._without_gl)
        self.space.addWidget(self.lobes)

    def _without_gl(self, error: MissingCapability) -> None:
        self._make_lobes(error.capability)

    def _connect(self) -> None:
        bench, library, inspector = self.bench, self.library, self.inspector
        library.model_wanted.connect(lambda words: commands_brdf.add_model(bench, words))
        library.file_wanted.connect(lambda path: commands_brdf.open_file(bench, path))
        library.relocate_wanted.connect(lambda lost: dialogs.relocate(self, bench, lost))
        library.browse_wanted.connect(lambda: dialogs.browse(self, bench))
        library.template_wanted.connect(self._write)
        inspector.text_wanted.connect(lambda: self._with_entry(self.open_text))
        inspector.current_wanted.connect(self.choose)
        inspector.visible_wanted.connect(self._set_visible)
        inspector.remove_wanted.connect(self.remove)
        inspector.edited.connect(self._on_edited)
        inspector.use_wanted.connect(lambda: self._with_entry(lambda entry: commands_brdf.use(bench, entry)))
        inspector.copy_wanted.connect(lambda: self._with_entry(lambda entry: dialogs.copy_text(bench, entry)))
        inspector.save_wanted.connect(lambda: self._with_entry(lambda entry: dialogs.save(self, bench, entry)))
        inspector.fit.changed.connect(self._refresh)
        self.light.edited.connect(lambda angle, _final: self.set_light(angle))
        self.scale.chosen.connect(lambda _value: self._show_curves())
        self.slice.read.connect(lambda words: self.tile_of["slice"].say(words, words.removesuffix(" sr⁻¹")))
        self.sphere.said.connect(self.tile_of["sphere"].say)
        self.sphere.viewport.drawn.connect(self.drawn)
        self.sphere.viewport.broken.connect(self.broken)
        for keys, work in (("L", self._next_scale), ("Ctrl+F", self.library.search.setFocus)):
            shortcut = QShortcut(QKeySequence(keys), self, context=Qt.ShortcutContext.WindowShortcut)
            shortcut.activated.connect(work)
        self.following = Following(bench.document, self, self._on_changed)

    @property
    def comparison(self) -> Comparison:
        """The BRDFs that the project compares."""
        return self.bench.document.project.comparison

    @property
    def entry(self) -> Entry | None:
        """The entry on which the user is."""
        return self.comparison.find(self.current)

    def _with_entry(self, work: Callable[[Entry], object]) -> None:
        entry = self.entry
        if entry is not None:
            work(entry)

    def _on_changed(self, old: Project, new: Project) -> None:
        before, now = old.comparison, new.comparison
        if before is now and self.pages.isVisible():
            return
        grown = {entry.identity for entry in now.entries} - {entry.identity for entry in before.entries}
        for identity in grown:
            self.known.pop(identity, None)
            self.albedos.pop(identity, None)
        if grown:
            self.current = max(grown, key=[entry.identity for entry in now.entries].index)
        elif now.find(self.current) is None:
            self.current = now.entries[-1].identity if now.entries else None
        self.pages.setCurrentIndex(1 if now.entries else 0)
        self.inspector.setVisible(bool(now.entries))
        if before.files != now.files:
            self._look_for_files()
        self._refresh()

    def choose(self, identity: int) -> None:
        """Make another entry the current one."""
        self.current = identity
        self._refresh()

    def set_light(self, angle_deg: float) -> None:
        """Let the light stand at an angle from the normal."""
        self.light_deg = round(min(LIGHT.high, max(LIGHT.low, angle_deg)), 2)
        self.light.show_value(self.light_deg)
        self._refresh()

    def remove(self) -> None:
        """Take the current entry out of the list; the one after it becomes current."""
        entry = self.entry
        if entry is None:
            return
        entries = self.comparison.entries
        place = entries.index(entry)
        others = (*entries[place + 1 :], *reversed(entries[:place]))
        self.current = others[0].identity if others else None
        factoring = self.bench.document.project.factoring
        if factoring.source == f"entry:{entry.identity}":  # or else another BRDF with its colour would be factored
            factoring = dataclasses.replace(factoring, source=MATERIAL)
        comparison = self.comparison.removed(entry.identity)
        self.bench.document.change(f"Remove {entry.name}", comparison=comparison, factoring=factoring)

    def _set_visible(self, identity: int, visible: bool) -> None:
        entry = self.comparison.find(identity)
        if entry is not None and entry.visible != visible:
            words = f"{'Show' if visible else 'Hide'} {entry.name}"
            self.bench.document.change(words, comparison=self.comparison.changed(identity, visible=visible))

    def _on_edited(self, brdf: Brdf, final: bool) -> None:
        entry, document = self.entry, self.bench.document
        if entry is not None and brdf != entry.brdf:
            changed = self.comparison.changed(entry.identity, brdf=brdf, fitted=None)
            document.change(f"Change {entry.name}", gesture=f"brdf {entry.identity}", comparison=changed)
        if final:
            document.end_gesture()

    def _write(self, template: str) -> None:
        """Begin a BRDF in GLSL, and open its text."""
        job = commands_brdf.add_written(self.bench, template)
        job.succeeded.connect(lambda _brdf: self._with_entry(self.open_text))

    def open_text(self, entry: Entry) -> TextEditor | None:
        """Show the text of an entry in GLSL in an editor beside the views; the one that is open comes to the front."""
        if not isinstance(entry.brdf, WrittenBrdf):
            return None
        known = [each for each in self.findChildren(TextEditor) if each.identity == entry.identity and each.isVisible()]
        editor = known[0] if known else TextEditor(self, self.bench, entry)
        if not known:
            editor.edited.connect(self._text_edited)
        editor.show()
        editor.raise_()
        editor.edit.setFocus()
        return editor

    def _text_edited(self, identity: int, brdf: WrittenBrdf) -> None:
        entry = self.comparison.find(identity)
        if entry is not None and brdf != entry.brdf:
            changed = self.comparison.changed(identity, brdf=brdf, fitted=None)
            self.bench.document.change(f"Write {entry.name}", comparison=changed)

    def _look_for_files(self) -> None:
        files = self.comparison.files
        self.looking.ask(lambda: missing_files(files), self.library.show_missing)

    def _next_scale(self) -> None:
        self.scale.choose("linear" if self.scale.value == "log" else "log")
        self._show_curves()

    def fit(self) -> None:
        """Reset the camera of the lobes."""
        if self.lobes is not None:
            self.lobes.reset()
        self.sphere.viewport.frame()

    def showEvent(self, event: object) -> None:
        super().showEvent(event)  # type: ignore[arg-type]
        self._look_for_files()
        if self._stale:
            self._refresh()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.key() == Qt.Key.Key_Escape and self.tiles.large is not None:
            self.tiles.enlarge(None)
        else:
            super().keyPressEvent(event)

    def shown(self) -> list[Shown]:
        """The entries on screen, the current one last, so that it is drawn over the others."""
        entries = [entry for entry in self.comparison.entries if entry.visible]
        entries.sort(key=lambda entry: entry.identity == self.current)
        found = [Shown(entry.identity, entry.brdf, entry.colour, entry.marker) for entry in entries]
        so_far, identity = self.inspector.fit.so_far, self.comparison.free_identity
        if so_far is not None and identity is not None:
            coming = Entry("", so_far.brdf, identity)
            found.append(Shown(-1, so_far.brdf, coming.colour, coming.marker, live=True))
        return found

    def _refresh(self) -> None:
        """Show all known figures, and request the missing ones."""
        self._stale = not self.isVisible()
        entry = self.entry
        state = (self.comparison, entry, self.inspector.fit.running)
        if state != self._state:
            self._state = state
            self.library.show_files(self.comparison.files, self.comparison.entries)
            self.inspector.show_comparison(self.comparison, entry)
            if self.facts is not None and entry is not None and self.facts.brdf == entry.brdf:
                self.inspector.show_facts(self.facts)
        if self._stale:
            return
        self.sphere.show_brdf(entry.brdf if entry is not None else None)
        if self.inspector.fit.so_far is None:
            self.known.pop(-1, None)
        theta = radians(self.light_deg)
        wanted = [(one.number, one.brdf) for one in self.shown()]
        if entry is not None and not entry.visible:
            wanted.append((entry.identity, entry.brdf))
        missing = []
        for identity, brdf in wanted:
            known = self.known.get(identity)
            if known is None or known.brdf != brdf or known.theta_i != theta:
                missing.append((identity, brdf, known))
        if missing:
            self.evaluating.ask(lambda: curves(missing, theta), self._on_evaluated)
        on_screen = (self.current, [(one.number, one.live) for one in self.shown()])
        if not missing or on_screen != self._on_screen:
            self._show_curves()
        self._on_screen = on_screen
        self.at_rest.start()

    def _on_evaluated(self, found: dict[int, Curves]) -> None:
        self.known |= found
        self._show_curves()

    def _integrate(self) -> None:
        """Integrate the slower figures, once nothing has changed for a while."""
        if not self.isVisible():
            self._stale = True
            return
        missing = [
            (one.number, one.brdf)
            for one in self.shown()
            if not one.live and (one.number not in self.albedos or self.albedos[one.number][0] != one.brdf)
        ]
        if missing:
            self.integrating.ask(lambda: albedos(missing), self._on_integrated)
        entry = self.entry
        if entry is not None and (self.facts is None or self.facts.brdf != entry.brdf):
            self.judging.ask(lambda: facts(entry.brdf), self._judged)

    def _on_integrated(self, found: dict[int, tuple[Any, Any]]) -> None:
        self.albedos |= found
        self._show_albedos()

    def _judged(self, found: Facts) -> None:
        """Show facts, unless another entry has become current: its own may have come before."""
        entry = self.entry
        if entry is not None and found.brdf == entry.brdf:
            self.facts = found
            self.inspector.show_facts(found)

    def _show_curves(self) -> None:
        """The lobes, the plane of incidence, and the half and difference angles of the current one."""
        pairs = [(one, self.known[one.number]) for one in self.shown() if one.number in self.known]
        highest = max((known.highest for _, known in pairs), default=0.0) or 1.0
        logarithmic = self.scale.value == "log"
        light = (radians(self.light_deg), LIGHT_PHI)
        if self.lobes is not None:
            drawn = [Lobe(known.wo, known.lobe, one.colour, one.marker) for one, known in pairs]
            made = surfaces(drawn, highest, logarithmic=logarithmic)
            made = [dataclasses.replace(each, opacity=OTHERS) for each in made[:-1]] + made[-1:]
            self.lobes.show_lobes(made, [one.marker for one, _ in pairs], light)
        lines = [
            Line(
                known.theta_o,
                lengths(known.polar, highest, logarithmic=logarithmic),
                one.colour,
                one.marker,
                one.live,
            )
            for one, known in pairs
        ]
        self.polar.show_lines(lines, light[0])
        entry = self.entry
        known = self.known.get(entry.identity) if entry is not None else None
        self.slice.show_values(known.half_difference if known is not None else None)
        words = f"{number(highest, 3)} sr⁻¹" if pairs else ""
        self.tile_of["polar"].say(words)
        self.tile_of["lobe"].say(f"light at {self.light_deg:.0f}°, longest {number(highest, 3)} sr⁻¹")
        self._show_albedos()

    def _show_albedos(self) -> None:
        found = [(one, self.albedos[one.number][1]) for one in self.shown() if one.number in self.albedos]
        shown = [(one.number, id(values)) for one, values in found]
        if shown == self._albedos_shown:
            return
        self._albedos_shown = shown
        x = np.array(ALBEDO_DEG)
        self.albedo.show_lines([Line(x, values, one.colour, one.marker) for one, values in found])

    def save_plots(self, folder: Path) -> Job:
        """Write the plots into `folder`: as SVG as they are on screen, as CSV with the values of all that is shown."""
        plots = {"plane-of-incidence": self.polar, "half-difference": self.slice, "albedo": self.albedo}
        files = {f"{name}.svg": svg(plot) for name, plot in plots.items()}
        entries = [entry for entry in self.comparison.entries if entry.visible and entry.identity in self.known]
        names = distinct([entry.name for entry in entries])
        known = {name: self.known[entry.identity] for name, entry in zip(names, entries, strict=True)}
        if known:
            theta_deg = np.degrees(next(iter(known.values())).theta_o)
            values = {name: each.polar for name, each in known.items()}
            files["plane-of-incidence.csv"] = table("theta_o / °", theta_deg, values)
            files |= {
                f"half-difference-{at}.csv": grid(each.half_difference) for at, each in enumerate(known.values(), 1)
            }
        pairs = zip(names, entries, strict=True)
        found = {name: self.albedos[entry.identity][1] for name, entry in pairs if entry.identity in self.albedos}
        if found:
            files["albedo.csv"] = table("theta_o / °", np.array(ALBEDO_DEG, np.float64), found)
        job = self.bench.jobs.submit(f"Saving plots to {folder.name}", lambda: save(folder, files), lane="save")
        job.succeeded.connect(self.bench.said.emit)
        return job

    def apply_theme(self) -> None:
        """Redraw what does not follow the palette by itself."""
        self.view_action.setIcon(theme.icon("fit"))
        self.save_action.setIcon(theme.icon("export"))
        for plot in (self.polar, self.slice, self.albedo):
            plot.apply_theme()
        for tile in self.tiles.places:
            tile.show_enlarged(tile is self.tiles.large)
        self.empty.apply_theme()
        self.library.apply_theme()
        self.inspector.apply_theme()
        self.sphere.viewport.redraw()
        self._state = self._on_screen = self._albedos_shown = None
        self._refresh()
