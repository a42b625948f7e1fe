"""The Material workspace: the slices of the shading map, their compression, and where the compression fails."""

from __future__ import annotations

from collections.abc import Generator, Iterator
from functools import reduce
from typing import Any

import numpy as np
from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QKeySequence, QShortcut
from PySide6.QtWidgets import QPushButton, QSplitter, QWidget

from app.commands.workbench import Workbench
from app.document.document import Project
from app.document.following import Following
from app.jobs.newest import Latest
from app.material.candidates import Candidates
from app.material.directional_page import PAIRS_HINT, DirectionalPage, part_segments, representation_box
from app.material.maps_page import MapsPage
from app.material.surface_page import SurfacePage, page_switch
from app.material.texel_panel import TexelFigures, WorstTexels, worst
from app.material.tiling import Tiling
from app.widgets.controls import ComboBox, Slider
from app.widgets.empty_state import EmptyState, with_empty_state
from app.widgets.image_view import Image, ImageView, photograph, scalar_map
from app.widgets.number_field import NumberField
from app.widgets.panels import Panel, Segments, button, enable, text
from app.widgets.plots import ColourBar, RadiancePlot, TexelPlot, colour_table
from app.widgets.report import Report
from app.widgets.theme import STEP
from app.widgets.workspace import bar_of_choices, beside, side_by_side, under
from engine.core.figure_text import number, percent, size_text
from engine.core.health import Health
from engine.core.steps import Step, Steps
from engine.scene.material import Material
from engine.shading.power_law import PowerLawMap

SLICE_CHOICES = (4, 6, 8, 12, 16, 24, 32)
#: Abscissae of the curve of a texel, as shares of the largest r: denser where a power law bends.
CURVE_SHARES = np.linspace(0.0, 1.0, 97) ** 2

#: A warning where tiles keep so many slices that nothing is saved.
COSTS_MORE = (
    "This takes no less room than the slices alone. Raise the error bound, or use the power law for all texels."
)

EXPONENT_BITS = ((32, "32 bits"), (16, "16 bits"), (8, "8 bits"))

SHOWS = (
    ("slices", "Slices", "The shading map at the chosen r, interpolated between two slices"),
    ("power-law", "Power law", "The compressed pair at the chosen r"),
    ("error", "Error", "Root mean square difference of the two over all slices, per texel"),
    ("tiles", "3 × 3", "The material, repeated"),
)


class MaterialTab(QWidget):
    """Shows the material of the project, once `fill` has been through."""

    capture_wanted = Signal()
    sample_wanted = Signal()

    def __init__(self, bench: Workbench) -> None:
        super().__init__()
        self.bench = bench
        self.latest = Latest(bench.jobs, "Preparing the image")
        self.share = 1.0
        self.place: tuple[int, int] | None = None
        self.page = "material"

    def fill(self) -> Iterator[None]:
        """Make what is in it, a part with each step, and each at once where it stays: moving widgets costs time."""
        self.image = ImageView()
        self.image.picked.connect(self._on_picked)
        self.bar = ColourBar(colour_table())
        self.radiance = RadiancePlot()
        yield
        self.texel = TexelPlot()
        yield
        self.texel_figures = TexelFigures()
        self.worst_texels = WorstTexels()
        self.worst_texels.chosen.connect(self._go_to)
        self.finding = Latest(self.bench.jobs, "Finding the worst texels")
        self.report = Report()
        self.empty = self._make_empty()
        self.pages = with_empty_state(self, self.empty, self._make_work())
        yield
        self.directional = DirectionalPage(self.bench.jobs)
        self.directional.part.chosen.connect(lambda value: self._set("Light of pairs", part_of_light=value))
        self.directional.tiling.chosen.connect(lambda words, name, value: self._set(words, **{name: value}))
        self.directional.chosen.connect(self._represent)
        self.directional.build.clicked.connect(self.bench.build_material)
        self.pages.addWidget(self.directional)
        yield
        self.maps = MapsPage(self.bench.jobs)
        self.pages.addWidget(self.maps)
        yield
        self.surface = SurfacePage(self.bench)
        self.pages.addWidget(self.surface)
        yield
        self.switches = (self.switch, self.directional.switch, self.surface.switch)
        for switch in self.switches:
            switch.chosen.connect(self.show_page)
        begin = QShortcut(QKeySequence("Ctrl+Return"), self, context=Qt.ShortcutContext.WindowShortcut)
        begin.activated.connect(lambda: self.main_button.click())
        self.following = Following(self.bench.document, self, self._follow)
        self.bench.jobs.changed.connect(lambda _job: self._update_buttons())
        yield from self._follow(Project(), self.bench.document.project)

    def _make_empty(self) -> EmptyState:
        return EmptyState(
            "material",
            "No material yet",
            "Photographs become slices whose mean radiance grows evenly, and a power law compresses them to six "
            "numbers per texel. Import photographs first, or drop a .lightarc bundle, a folder of PBR "
            "textures or a MaterialX document.",
            (("Go to Capture", "", self.capture_wanted), ("Try the sample capture", "sample", self.sample_wanted)),
        )

    def _make_work(self) -> QWidget:
        return side_by_side(self._make_centre(), self._make_right(), stretch=0)

    def _make_centre(self) -> QWidget:
        self.show_what = Segments(SHOWS)
        self.show_what.choose("slices")
        self.show_what.chosen.connect(lambda _value: self._load_image())
        self.slider = Slider()
        self.slider.setAccessibleName("r, BRDF times cosine")
        self.slider.setValue(self.slider.maximum())
        self.slider.valueChanged.connect(self._slid)
        self.slider.reset.connect(lambda: self.slider.setValue(self.slider.maximum()))
        self.r_label = text("r", "secondary")
        self.r_figure = text("", "")
        self.r_figure.setMinimumWidth(116)
        self.r_figure.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
        bar, row = bar_of_choices()
        row.addWidget(self.show_what)
        row.addSpacing(2 * STEP)
        row.addWidget(self.r_label)
        row.addWidget(self.slider, 1)
        row.addWidget(self.r_figure)
        top = under(bar, beside(self.image, self.bar))
        plots = QSplitter(Qt.Orientation.Horizontal)
        plots.setHandleWidth(1)
        plots.addWidget(self.radiance)
        plots.addWidget(self.texel)
        plots.setSizes([1, 1])
        centre = QSplitter(Qt.Orientation.Vertical)
        centre.setHandleWidth(1)
        centre.addWidget(top)
        centre.addWidget(plots)
        centre.setStretchFactor(0, 1)
        centre.setSizes([540, 210])
        centre.setChildrenCollapsible(False)
        return centre

    def _make_right(self) -> QWidget:
        panel = Panel()
        self.switch = page_switch("material")
        panel.column.addWidget(self.switch)
        settings = panel.section("Shading map")
        self.representation = representation_box()
        self.representation.activated.connect(lambda _index: self._represent(self.representation.currentData()))
        settings.row("Kind", self.representation, "Automatic: the one with the smaller error of held-out photographs")
        self.part, self.settings = part_segments(), settings
        settings.row("Pairs", self.part, PAIRS_HINT)
        self.part.chosen.connect(lambda value: self._set("Light of pairs", part_of_light=value))
        self.slices = ComboBox()
        for count in SLICE_CHOICES:
            self.slices.addItem(str(count), count)
        self.slices.activated.connect(self._slices_chosen)
        settings.row("Slices", self.slices, "Number of slices that the photographs are resampled to")
        self.tiling = Tiling(settings)
        self.tiling.chosen.connect(lambda words, name, value: self._set(words, **{name: value}))
        self.resolution = settings.figure("Size")
        self.r_max = settings.figure("Largest r", "Mean luminance of the brightest photograph, a_max")
        self.deviation = settings.figure("Evenness", "Largest distance of a slice's mean from its target")
        compression = panel.section("Compression")
        self.scale = ComboBox()
        self.scale.addItem("Last slice", "last-slice")
        self.scale.addItem("Least squares", "least-squares")
        self.scale.activated.connect(self._scale_chosen)
        compression.row(
            "Scale",
            self.scale,
            "Last slice: as in the paper, exact at the largest r. Least squares: never worse",
        )
        self.bits = ComboBox()
        for bits, words in EXPONENT_BITS:
            self.bits.addItem(words, bits)
        self.bits.activated.connect(
            lambda _index: self._set("Bits of the exponent", exponent_bits=self.bits.currentData())
        )
        compression.row("Exponent", self.bits, "Bits of a stored exponent; with 8 or 16 the scale takes 16 too")
        self.rounding = compression.figure("Rounding", "Largest change of a texel by fewer bits, in units of radiance")
        self.mode = Segments(
            (
                ("power-law", "Power law", "Six numbers for every texel"),
                ("mixed", "Mixed", "Tiles in which a texel's error reaches the bound keep their slices"),
            )
        )
        self.mode.chosen.connect(lambda value: self._set("Compression", mixed=value == "mixed"))
        compression.row("Mode", self.mode)
        self.bound = NumberField(5.0, 0.0, 100.0, unit="%")
        self.bound.edited.connect(self._on_bound_edited)
        compression.row("Error bound", self.bound)
        self.kept = compression.figure("Kept tiles", "Share of the tiles that keep their slices")
        self.rms = compression.figure("RMS error", "Over all texels, slices and channels, in units of radiance")
        self.relative = compression.figure("Of largest r")
        self.worst = compression.figure("Worst texel")
        sizes = panel.section("Bytes")
        self.size_slices = sizes.figure("Slices")
        self.size_pair = sizes.figure("Power law")
        self.saved = sizes.figure("Saved")
        self.costs_more = text("", "warning", wrap=True)
        sizes.wide(self.costs_more)
        self.candidates = Candidates()
        panel.add(self.candidates)
        panel.section("Texel").wide(self.texel_figures)
        panel.section("Worst texels").wide(self.worst_texels)
        report = panel.section("Report")
        report.wide(self.report)
        self.build = button("Rebuild material", "primary")
        self.build.clicked.connect(self.bench.build_material)
        panel.finish(self.build)
        return panel

    def fit(self) -> None:
        """Show the whole image."""
        shown = self.pages.currentWidget()
        (shown.image if isinstance(shown, DirectionalPage | MapsPage | SurfacePage) else self.image).fit()

    @property
    def main_button(self) -> QPushButton:
        """The button of the page in front: it builds the material, or finds its surface."""
        shown = self.pages.currentWidget()
        return (
            shown.make if isinstance(shown, SurfacePage) else shown.build if shown is self.directional else self.build
        )

    def show_page(self, page: str) -> None:
        """Show the 'material' or the maps of its 'surface'."""
        self.page = page
        self._turn_to_page(self.bench.document.project)

    def _turn_to_page(self, project: Project) -> None:
        material = project.material
        is_pbr = material.pbr is not None
        if is_pbr or not (project.has_map or project.surface is not None):
            self.page = "material"
        made = 3 if is_pbr else 2 if material.directional is not None else 1 if project.has_map else 0
        self.pages.setCurrentIndex(4 if self.page == "surface" else made)
        for switch in self.switches:
            switch.choose(self.page)

    def _follow(self, old: Project, new: Project) -> Generator[None]:
        is_directional = new.material.directional is not None
        is_pbr = new.material.pbr is not None
        self._turn_to_page(new)
        self.surface.show_project(new)
        self.representation.setCurrentIndex(max(0, self.representation.findData(new.representation)))
        self.part.choose(new.part_of_light)
        self.settings.show_row(self.part, new.stack is not None and new.stack.diffuse is not None)
        if self.slices.findData(new.slices) < 0:
            self.slices.addItem(str(new.slices), new.slices)
        self.slices.setCurrentIndex(self.slices.findData(new.slices))
        self.scale.setCurrentIndex(max(0, self.scale.findData(new.scale)))
        self.bits.setCurrentIndex(self.bits.findData(new.exponent_bits))
        self.tiling.show_project(new)
        self.mode.choose("mixed" if new.mixed else "power-law")
        self.bound.show_value(new.error_bound_percent)
        if is_pbr:
            self.maps.show_project(new)
        elif is_directional:
            self.directional.show_project(new)
        elif old.material.maps != new.material.maps:
            self._show_figures(new)
            self.candidates.show_material(new.material)
            yield
            self._show_plots(new)
            yield
            self._load_image()
            self.finding.ask(lambda: worst(new.material.power_law), self.worst_texels.show_texels)
        self._update_buttons()

    def _show_figures(self, project: Project) -> None:
        shading_map, power_law = project.material.shading_map, project.material.power_law
        either = shading_map or power_law
        parts = [part.health for part in (shading_map, power_law) if part is not None]
        self.report.show_health(reduce(Health.merge, parts) if parts else None)
        if either is None:
            return
        height, width = (power_law.scale if power_law is not None else shading_map.slices[0]).shape[:2]  # type: ignore[union-attr]
        self.resolution.setText(f"{width} × {height} px")
        self.r_max.setText(number(either.r_max, 4))
        pair_bytes = power_law.size_bytes if power_law is not None else 0
        self._show_compression(power_law)
        self.tiling.show_seams(shading_map.health if shading_map is not None else None)
        self.size_pair.setText(size_text(pair_bytes) if power_law is not None else "–")
        self.size_slices.setText(size_text(shading_map.slices.nbytes) if shading_map is not None else "–")
        both = shading_map is not None and power_law is not None
        self.saved.setText(percent(1 - pair_bytes / shading_map.slices.nbytes) if both else "–")  # type: ignore[union-attr]
        costs_more = both and pair_bytes >= shading_map.slices.nbytes  # type: ignore[union-attr]
        self.costs_more.setVisible(costs_more)
        self.costs_more.setText(COSTS_MORE if costs_more else "")
        if shading_map is not None:
            deviation = np.abs(shading_map.mean_radiance - shading_map.target_radiance).max() / shading_map.r_max
            self.deviation.setText(percent(deviation) if deviation > 5e-7 else "exact")
        else:
            self.deviation.setText("–")
        self.rms.setText(number(power_law.rms, 3) if power_law is not None else "–")
        self.relative.setText(percent(power_law.rms / power_law.r_max, 3) if power_law is not None else "–")
        self.worst.setText(number(float(power_law.error_map.max()), 3) if power_law is not None else "–")
        self.show_what.disable("slices", "" if shading_map is not None else "The bundle holds no slices")
        for value in ("power-law", "error"):
            self.show_what.disable(value, "" if power_law is not None else "The bundle holds no power law")
        if not self.show_what.buttons[self.show_what.value or "slices"].isEnabled():
            self.show_what.choose("slices" if shading_map is not None else "power-law")

    def _show_compression(self, power_law: PowerLawMap | None) -> None:
        storage = power_law.storage if power_law is not None else None
        rounded = storage is not None and storage.exponent_bits < 32
        self.rounding.setText(f"≤ {number(storage.bound)}" if storage is not None and rounded else "none")
        kept = power_law.kept if power_law is not None else None
        self.kept.setText("none" if kept is None else percent(float((kept.place >= 0).mean()), 3))

    def _show_plots(self, project: Project) -> None:
        shading_map = project.material.shading_map
        if shading_map is not None:
            self.radiance.show_slices(shading_map.target_radiance, shading_map.mean_radiance)
        if project.has_map:
            height, width = _shape(project)
            place = self.place
            if place is None or place[0] >= width or place[1] >= height:
                place = (width // 2, height // 2)
            self._plot(project.material, *place)

    def _pick(self, column: int, row: int) -> None:
        """Plot one texel of the project over r."""
        self._plot(self.bench.document.project.material, column, row)

    def _plot(self, material: Material, column: int, row: int) -> None:
        """Plot one texel of `material`, which the project may have changed for another since it was told to show it."""
        self.place = (column, row)
        self._show_place()
        either = material.shading_map or material.power_law
        if either is None:
            return
        fitted = None
        if material.power_law is not None:
            fitted = material.power_law.lookup(row + 0.5, column + 0.5, CURVE_SHARES * either.r_max).astype(float)
        slices = material.shading_map
        r = slices.target_radiance if slices is not None else np.array([0.0, either.r_max])
        values = np.asarray(slices.slices[:, row, column], float) if slices is not None else None
        self.texel.show_texel(r, values, fitted, CURVE_SHARES * either.r_max)
        self.texel_figures.show_texel(material, column, row)

    def _on_picked(self, column: int, row: int) -> None:
        if self.show_what.value != "tiles":
            self._pick(column, row)

    def _show_place(self) -> None:
        """Mark the picked texel, but not where images are repeated and smaller."""
        self.image.show_probe(self.place if self.show_what.value != "tiles" else None)

    def _go_to(self, column: int, row: int) -> None:
        """Bring a texel of the list to the middle, in the map of errors unless another whole image is shown."""
        if self.show_what.value == "tiles":
            self.show_what.choose("error")
            self._load_image()
        self._pick(column, row)
        self.image.look_at(column, row)

    def _slid(self, ticks: int) -> None:
        self.share = ticks / self.slider.maximum()
        if self.show_what.value != "error":
            self._load_image()

    def _load_image(self) -> None:
        project, what = self.bench.document.project, self.show_what.value
        self.bar.setVisible(what == "error")
        for widget in (self.slider, self.r_label, self.r_figure):
            widget.setEnabled(what != "error")
        if project.material.shading_map is None and project.material.power_law is None:
            self.latest.drop()
            self.image.show_image(None)
            return
        either = project.material.shading_map or project.material.power_law
        assert either is not None
        r = self.share * either.r_max
        self.radiance.show_current(r if what != "error" else None)
        self._show_place()
        self.r_figure.setText(f"{number(r, 4)} of {number(either.r_max, 4)}")
        high = _error_scale(project) if what == "error" else 0.0
        self.bar.show_scale(high, "RMS error")
        self.latest.ask(lambda: _image(project, what, r, high), self.image.show_image)

    def _slices_chosen(self, _index: int) -> None:
        count = int(self.slices.currentData())
        if count != self.bench.document.project.slices:
            self.bench.document.change(f"{count} slices", slices=count)

    def _scale_chosen(self, _index: int) -> None:
        scale = str(self.scale.currentData())
        if scale != self.bench.document.project.scale:
            self.bench.document.change(f"Scale from {self.scale.currentText().lower()}", scale=scale)

    def _represent(self, value: str) -> None:
        words = {"auto": "Representation by itself", "shading-map": "Shading map", "directional": "Directional map"}
        self._set(words[value], representation=value)

    def _on_bound_edited(self, percent: float, final: bool) -> None:
        document = self.bench.document
        if percent != document.project.error_bound_percent:
            document.change("Error bound", gesture="error bound", error_bound_percent=percent)
        if final:
            document.end_gesture()

    def _set(self, words: str, **parts: Any) -> None:
        document = self.bench.document
        if any(getattr(document.project, name) != value for name, value in parts.items()):
            document.change(words, **parts)

    def _update_buttons(self) -> None:
        project, building = self.bench.document.project, self.bench.building
        why_not = ""
        if project.stack is None:
            why_not = "The material came from a bundle; building again needs the photographs"
        elif building is not None and not building.over:
            why_not = "The material is being built"
        elif project.has_map and project.built_from == project.recipe:
            why_not = "The material is up to date"
        self.surface.update_buttons(project)
        for each in (self.build, self.directional.build):
            enable(each, why_not, "Make the material again with these settings (Ctrl+Enter)")
        no_stack = "Needs the photographs of the capture" if project.stack is None else ""
        boxes = (self.representation, self.directional.representation)
        for box in (*boxes, self.slices, self.scale, self.bits, self.mode):
            enable(box, no_stack)
        for tiling in (self.tiling, self.directional.tiling):
            tiling.update_buttons(project)
        enable(
            self.bound,
            no_stack or ("" if project.mixed else "Only the mixed mode has a bound"),
            "Of the largest r: tiles in which a texel's error reaches it keep their slices",
        )

    def apply_theme(self) -> None:
        """Redraw what does not follow the palette by itself."""
        self.empty.apply_theme()
        self.directional.apply_theme()
        self.maps.apply_theme()
        self.surface.apply_theme()
        self.report.show_health(self.report.health)
        for plot in (self.radiance, self.texel):
            plot.apply_theme()


def _shape(project: Project) -> tuple[int, int]:
    material = project.material
    if material.power_law is not None:
        return material.power_law.scale.shape[:2]
    assert material.shading_map is not None
    return material.shading_map.slices.shape[1:3]


def _error_scale(project: Project) -> float:
    """The error that all but the worst half per cent of the texels stay below: one bad texel must not hide the rest."""
    power_law = project.material.power_law
    return float(np.quantile(power_law.error_map[::4, ::4], 0.995)) if power_law is not None else 0.0


def _image(project: Project, what: str, r: float, high: float) -> Steps[Image]:
    yield Step(0.0, "preparing the image")
    material = project.material
    if what == "error":
        assert material.power_law is not None
        return (yield from scalar_map(material.power_law.error_map, high, colour_table()))
    chosen = material.power_law if what == "power-law" else material.shading_map or material.power_law
    assert chosen is not None
    image = chosen.slice_image(r)
    if what == "tiles":
        from engine.figures.contact_sheet import repeat  # with OpenCV, 20 MB

        image = repeat(image)
    return (yield from photograph(image))
