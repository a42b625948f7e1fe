"""The Material workspace of the surface behind the photographs: its maps, how uncertain they are, and their error.

A map of a surface, or its uncertainty, as an image with a scale, and its error in words.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from PySide6.QtWidgets import QFileDialog, QHBoxLayout, QVBoxLayout, QWidget

from app.commands import surface as commands
from app.commands.workbench import Workbench
from app.document.document import Project
from app.jobs.jobs import Job
from app.jobs.newest import Latest
from app.widgets.empty_state import EmptyState
from app.widgets.image_view import Image, ImageView, pixels_image, scalar_pixels
from app.widgets.number_field import NumberField
from app.widgets.panels import Pages, Panel, Segments, button, enable, text
from app.widgets.plots import ColourBar, colour_table
from app.widgets.report import Report
from app.widgets.workspace import bar_of_choices, beside, side_by_side, under
from engine.capture.scale import EXTENT_HINT, extent_text, mm_per_texel
from engine.core.figure_text import number, percent
from engine.core.steps import Step, Steps
from engine.surface.pbr_maps import ObservedSlopes

if TYPE_CHECKING:
    from engine.surface.recover import Surface

#: Maps in the order in which they are offered: a name, its label, and what it is.
MAPS = (
    ("normal", "Normals", "Directions of the surface: red to the right, green up, blue out of the image"),
    ("height", "Height", "Height of the surface in texels, from its lowest to its highest"),
    ("base_colour", "Base colour", "Colour of the surface without light: of diffuse reflection, or of metal"),
    ("roughness", "Roughness", "Roughness of the surface: 0 reflects like a mirror, 1 has the broadest highlights"),
    ("specular", "Specular", "F0 of a non-metal, its reflectance at normal incidence; plastic has 0.04"),
    ("metallic", "Metallic", "1 where highlights have the colour of metal"),
    ("occlusion", "Sky visibility", "Share of the light of an even sky that relief leaves"),
)

#: Name of the values of a map, their unit, and the factor from the unit of the map to that one.
UNITS = {
    "normal": ("normal", "°", math.degrees(1.0)),
    "height": ("height", " texel", 1.0),
    "height_mm": ("height", " mm", 1.0),
    "base_colour": ("colour", " of full white", 1.0),
    "roughness": ("roughness", "", 1.0),
    "specular": ("F0", "", 1.0),
    "metallic": ("metallic", "", 1.0),
    "occlusion": ("occlusion", "", 1.0),
}

#: Texels at most of which shares are taken.
SAMPLED = 1 << 18

#: Colours of texels of unknown height, and of background.
UNKNOWN, BACKGROUND = (230, 166, 60), (48, 52, 58)

GREY = np.repeat(np.arange(256, dtype=np.uint8)[:, None], 3, axis=1)

Values = NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class Shown:
    """An image, its colours from `low` to `high` (equal: no scale), a caption, the values of the map and its error."""

    image: Image
    table: NDArray[np.uint8]
    low: float
    high: float
    caption: str
    values: str
    error: str


def show(surface: Surface, name: str, of_error: bool, texel_mm: float | None = None) -> Steps[Shown]:
    """The map `name`, or its standard deviation; heights in millimetres where the size of a texel is known."""
    yield Step(0.0, "preparing the map")
    from engine.surface.write import find_known_maps, preview  # with scipy, 40 MB

    known = find_known_maps(surface.maps)
    values, sigma = known[name], known[f"{name}_sigma"]
    key = name
    if name == "height" and texel_mm is not None:
        key, values, sigma = "height_mm", np.float32(texel_mm) * values, np.float32(texel_mm) * sigma
    _, unit, factor = UNITS[key]
    mask = surface.maps.mask
    inside = np.s_[:] if mask is None or not mask.any() else mask > 0.0
    known_values, known_sigma = (each if mask is None else each[inside][None] for each in (values, sigma))
    regions = _explain_regions(name, surface.maps.region)
    said = (_range(key, known_values), " ".join([error_words(key, known_sigma), *regions]))
    if of_error:
        spread = factor * (sigma.mean(axis=2) if sigma.ndim == 3 else sigma)
        sample = _sample(spread if mask is None else spread[inside][None])
        high = max(float(np.quantile(sample[np.isfinite(sample)], 0.99)), 1e-6) if np.isfinite(sample).any() else 1e-6
        image = pixels_image(_hide(scalar_pixels(spread, high, colour_table()), mask))
        return Shown(image, colour_table(), 0.0, high, f"± {unit.split()[-1]}" if unit.strip() else "±", *said)
    if values.ndim == 3:
        return Shown(pixels_image(_hide(preview(name, values), mask)), GREY, 0.0, 0.0, "", *said)
    low, high = 0.0, 1.0
    if name == "height":
        sample = _sample(known_values)
        low, high = (float(each) for each in np.quantile(sample, (0.001, 0.999)))
    elif name == "specular":
        high = max(float(np.quantile(_sample(values), 0.995)), 1e-3)
    span = max(high - low, 1e-6)
    pixels = scalar_pixels(np.asarray(values - np.float32(low), np.float32), span, GREY)
    if name == "height":
        pixels[~np.isfinite(sigma)] = UNKNOWN  # on depth edges
    caption = "" if name != "height" else "texels" if key == name else "mm"
    return Shown(pixels_image(_hide(pixels, mask)), GREY, low, low + span, caption, *said)


def _hide(pixels: NDArray[np.uint8], mask: Values | None) -> NDArray[np.uint8]:
    """Pixels (H, W, 3) in which background, where the mask (H, W) is 0, has one colour."""
    return pixels if mask is None else np.where((mask > 0.0)[..., None], pixels, np.array(BACKGROUND, np.uint8))


def error_words(name: str, sigma: Values) -> str:
    """Median and 95th percentile of the standard deviations of a map, as a sentence."""
    what, unit, factor = UNITS[name]
    sample = factor * _sample(sigma)
    half, most = (float(each) for each in np.quantile(np.minimum(sample, 1e9), (0.5, 0.95)))
    if half >= 1e9:
        return f"The {what} is unknown at most texels."
    further = f"95\u00a0% below {number(most)}{unit}" if most < 1e9 else "unknown at more than 5\u00a0% of the texels"
    return f"Median {what} uncertainty {number(half)}{unit} (1 sigma), {further}."


def _explain_regions(name: str, region: Values | None) -> list[str]:
    """What the uncertainty of a height with depth edges is relative to; empty for other maps."""
    if name != "height" or region is None:
        return []
    count = int(region.max()) + 1
    return [f"Each of {count} regions counts from its own mean: the steps between them, along the lines, are unknown."]


def _range(name: str, values: Values) -> str:
    """The values that all but two in a thousand texels have."""
    if name == "normal":
        tilt = np.degrees(np.arccos(np.clip(_sample(values[..., 2]), -1.0, 1.0)))
        return f"tilted by {number(float(np.median(tilt)))}° (median)"
    if name == "base_colour":
        return f"{percent(float(values.mean(dtype=np.float64)))} on average"
    low, high = (float(each) for each in np.quantile(_sample(values), (0.001, 0.999)))
    return f"{number(low)} to {number(high)}"


def _sample(values: Values) -> NDArray[np.float64]:
    """Texels on a regular grid, as one row."""
    step = max(1, math.isqrt(values.shape[0] * values.shape[1] // SAMPLED))
    return np.asarray(values[::step, ::step], np.float64).ravel()


#: Pages of the workspace.
PAGES = (
    ("material", "Material", "The material as it is drawn under light"),
    ("surface", "Surface maps", "Normals, height, base colour, roughness and specular, found from the photographs"),
)

#: Images of a map.
SHOWS = (
    ("map", "Map", "The map itself"),
    ("error", "Uncertainty", "One standard deviation of the map in each texel"),
)

#: Sources of the radiance of the white reference.
WHITES = (
    ("found", "Found", "The white level of the photographs, or more where texels are brighter"),
    ("known", "Measured", "The radiance of a white reference that faces a lamp, as you measured it in a photograph"),
)

#: Words for the slopes that lamps tell.
SLOPES = {"both": "both directions", "along the arc": "along the arc", "none": "none"}


class SurfacePage(QWidget):
    """Shows the maps of the project. `switch` chooses between this page and the material."""

    def __init__(self, bench: Workbench) -> None:
        super().__init__()
        self.bench = bench
        self.latest = Latest(bench.jobs, "Preparing the map")
        self.surface: Surface | None = None
        self.texel_mm: float | None = None
        self.making: Job | None = None
        self.saving: Job | None = None
        self.image = ImageView()
        self.bar = ColourBar(GREY)
        outer = QHBoxLayout(self)
        outer.setContentsMargins(0, 0, 0, 0)
        outer.addWidget(side_by_side(self._make_centre(), self._make_right(), stretch=0))
        self._show_nothing()

    def _make_centre(self) -> QWidget:
        self.which = Segments(MAPS, {"base_colour": "Colour", "occlusion": "Sky"})
        self.which.choose("normal")
        self.which.chosen.connect(lambda _value: self._load())
        top, row = bar_of_choices()
        row.addWidget(self.which)
        row.addStretch(1)
        self.empty = EmptyState(
            "material",
            "No surface maps yet",
            "Photographs under lamps on several sides give the normals, the height and the reflectance of the surface, "
            "each map with its uncertainty. Make surface maps, on the right.",
            (),
        )
        self.pages = Pages()
        self.pages.addWidget(self.empty)
        self.pages.addWidget(under(top, beside(self.image, self.bar)))
        return self.pages

    def _make_right(self) -> QWidget:
        panel = Panel()
        self.switch = page_switch("surface")
        panel.column.addWidget(self.switch)
        chosen = panel.section("Map")
        self.show_what = Segments(SHOWS)
        self.show_what.choose("map")
        self.show_what.chosen.connect(lambda _value: self._load())
        chosen.row("Show", self.show_what)
        self.values = chosen.figure("Values", "Those of all but two in a thousand texels")
        self.error = text("", wrap=True)
        chosen.wide(self.error)
        seen = panel.section("Surface")
        self.resolution = seen.figure("Size")
        self.extent, self.figures = seen.figure("Extent", EXTENT_HINT), seen
        self.lamps = seen.figure("Photographs")
        self.slopes = seen.figure("Slopes", "The slopes that the lamps of the capture determine")
        self.whites = Segments(WHITES)
        self.whites.chosen.connect(self._white_chosen)
        seen.row("White", self.whites, "The white reference, of which reflectance is a share")
        self.white = NumberField(1.0, 1e-3, 1e3, log=True)
        self.white.edited.connect(self._white_edited)
        seen.row("Radiance", self.white)
        self.one_arc = text("", "warning", wrap=True)
        seen.wide(self.one_arc)
        errors = panel.section("Error (8-bit levels)")
        errors.wide(text("Of photographs as the maps show them", "secondary", wrap=True))
        self.left_out = errors.figure("Held out", "Photographs that the maps were made without, each in turn")
        self.in_sample = errors.figure("Training", "Photographs that the maps were made of")
        self.mean = errors.figure("Mean image", "The mean of the other photographs in place of each")
        report = panel.section("Report")
        self.report = Report("Follows the maps.")
        report.wide(self.report)
        self.save = button("Save maps…")
        self.save.clicked.connect(self._choose_folder)
        self.make = button("Make surface maps", "primary")
        self.make.clicked.connect(self._make)
        foot = QWidget()
        column = QVBoxLayout(foot)
        column.setContentsMargins(0, 0, 0, 0)
        column.addWidget(self.save)
        column.addWidget(self.make)
        panel.finish(foot)
        return panel

    def show_project(self, project: Project) -> None:
        """Show the maps of `project`, or that there are none."""
        found = project.surface
        self.whites.choose("found" if project.white is None else "known")
        if project.white is not None:
            self.white.show_value(project.white)
        self.pages.setCurrentIndex(0 if found is None else 1)
        stack = project.surface_from[0] if project.surface_from else None
        texel_mm = mm_per_texel(stack.provenance) if stack is not None else None
        if found is self.surface and texel_mm == self.texel_mm:
            return
        self.surface, self.texel_mm = found, texel_mm
        if found is None:
            self._show_nothing()
            return
        maps, errors = found.maps, found.maps.errors
        height, width = maps.size
        extent = "" if stack is None else extent_text(stack.provenance, width, height)
        self.resolution.setText(f"{width} × {height} px")
        self.extent.setText(extent)
        self.figures.show_row(self.extent, bool(extent))
        self.lamps.setText(str(len(found.lamps.direction)))
        self.slopes.setText(SLOPES[maps.observed.kind])
        self.one_arc.setText(arc_words(maps.observed))
        self.one_arc.setVisible(bool(self.one_arc.text()))
        for label, value in ((self.left_out, errors.left_out), (self.in_sample, errors.in_sample)):
            label.setText(number(value) if math.isfinite(value) else "–")
        self.mean.setText(number(errors.mean_picture) if math.isfinite(errors.mean_picture) else "–")
        self.report.show_health(found.health)
        why = arc_words(maps.observed)
        for name, values in (("height", maps.height), ("occlusion", maps.occlusion)):
            self.which.disable(name, why if values is None else "")
        if not self.which.buttons[self.which.value].isEnabled():
            self.which.choose("normal")
        self._load()

    def _show_nothing(self) -> None:
        self.latest.drop()
        self.image.show_image(None)
        labels = (self.values, self.resolution, self.lamps, self.slopes, self.left_out, self.in_sample, self.mean)
        for label in labels:
            label.setText("–")
        self.figures.show_row(self.extent, False)
        self.error.hide()
        self.one_arc.hide()
        self.report.show_health(None)

    def _load(self) -> None:
        found, name, of_error = self.surface, self.which.value, self.show_what.value == "error"
        if found is not None:
            texel_mm = self.texel_mm
            self.latest.ask(lambda: show(found, name, of_error, texel_mm), self._show)

    def _show(self, made: Shown) -> None:
        self.image.show_image(made.image)
        self.bar.table = made.table
        self.bar.setVisible(made.high > made.low)
        self.bar.show_scale(made.high, made.caption, made.low)
        self.values.setText(made.values)
        self.error.setText(made.error)
        self.error.show()

    def _white_chosen(self, how: str) -> None:
        commands.set_white(self.bench, self.white.value if how == "known" else None)

    def _white_edited(self, value: float, final: bool) -> None:
        if final:
            commands.set_white(self.bench, value)

    def _make(self) -> None:
        self.making = commands.make_maps(self.bench)
        self.update_buttons(self.bench.document.project)

    def _choose_folder(self) -> None:
        proposed = self.bench.propose(f"{self.bench.document.project.name} maps")
        chosen, _ = QFileDialog.getSaveFileName(self, "Save maps in a new folder", str(proposed))
        if chosen:
            self.bench.write_into(Path(chosen).parent)
            self.saving = commands.save_maps(self.bench, Path(chosen))

    def update_buttons(self, project: Project) -> None:
        """Disable what cannot be done now, and say why."""
        why_not = ""
        if project.stack is None:
            why_not = "Needs the photographs of the capture"
        elif self.making is not None and not self.making.over:
            why_not = "The maps are being made"
        elif project.surface is not None and project.surface_from == project.surface_recipe:
            why_not = "The maps are up to date"
        enable(self.make, why_not, "Find the surface behind the photographs that are in use (Ctrl+Enter)")
        no_stack = "Needs the photographs of the capture" if project.stack is None else ""
        enable(self.whites, no_stack)
        known = "" if project.white is not None else "The white reference is estimated from the photographs"
        enable(self.white, no_stack or known, "1 is the white level of the photographs; colours are shares of it")
        self.make.setText("Make surface maps" if project.surface is None else "Make them again")
        enable(self.save, "" if project.surface is not None else "There are no maps yet", "As EXR and PNG, with errors")

    def fit(self) -> None:
        """Show the whole image."""
        self.image.fit()

    def apply_theme(self) -> None:
        """Redraw what does not follow the palette by itself."""
        self.empty.apply_theme()
        self.report.show_health(self.report.health)


def page_switch(page: str) -> Segments:
    """The choice between the pages of the workspace, as it stands on `page`."""
    switch = Segments(PAGES)
    switch.choose(page)
    return switch


def arc_words(observed: ObservedSlopes) -> str:
    """A sentence on the slope that lamps of one arc leave unknown; empty where they stood on several sides."""
    if observed.azimuth is None:
        return ""
    azimuth = number(math.degrees(observed.azimuth))
    return f"The lamps stand on one arc: only the slope along {azimuth}° is observed, so there is no height."
