"""The Material workspace of PBR maps: each map as an image, and what was assumed when they were read."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from PySide6.QtWidgets import QHBoxLayout, QWidget

from app.document.document import Project
from app.jobs.jobs import Jobs
from app.jobs.newest import Latest
from app.widgets.controls import ComboBox
from app.widgets.image_view import Image, ImageView, photograph
from app.widgets.panels import Panel, text
from app.widgets.report import Report
from app.widgets.workspace import side_by_side
from engine.core.colour import srgb_decode
from engine.core.figure_text import format_fixed
from engine.core.steps import Step, Steps
from engine.surface.pbr_maps import PbrMaps

#: Maps in the order in which they are listed, with their words.
MAPS = (
    ("base_colour", "Base colour"),
    ("normal", "Normals"),
    ("roughness", "Roughness"),
    ("metallic", "Metallic"),
    ("f0", "Specular (f0)"),
    ("height", "Height"),
    ("occlusion", "Occlusion"),
)


class MapsPage(QWidget):
    """Shows a material that is a BRDF at each texel."""

    def __init__(self, jobs: Jobs) -> None:
        super().__init__()
        self.latest = Latest(jobs, "Preparing the map")
        self.maps: PbrMaps | None = None
        self.image = ImageView()
        outer = QHBoxLayout(self)
        outer.setContentsMargins(0, 0, 0, 0)
        outer.addWidget(side_by_side(self.image, self._make_right(), stretch=0))

    def _make_right(self) -> QWidget:
        panel = Panel()
        shown = panel.section("PBR maps")
        self.which = ComboBox()
        self.which.setAccessibleName("Map")
        self.which.activated.connect(lambda _index: self._show_map())
        shown.row("Map", self.which, "The map that is shown; numbers are shown as shades, normals as colours")
        self.resolution = shown.figure("Size")
        self.mean = shown.figure("Mean", "Over all texels; bakes are of the BRDF at the mean of all maps")
        words = "Every mode but Direct draws each texel. Bakes are of one BRDF, at the mean of the maps."
        shown.wide(text(words, "secondary", wrap=True))
        report = panel.section("Report")
        self.report = Report()
        report.wide(self.report)
        panel.finish()
        return panel

    def show_project(self, project: Project) -> None:
        """Show the material of `project`, which has PBR maps."""
        found = project.material.pbr
        assert found is not None
        self.report.show_health(project.material.health)
        if found is self.maps:
            return
        self.maps = found
        self.which.clear()
        for name, words in MAPS:
            if getattr(found, name) is not None:
                self.which.addItem(words, name)
        height, width = found.size
        self.resolution.setText(f"{width} × {height} px")
        self._show_map()

    def _show_map(self) -> None:
        if self.maps is None:
            return
        name: str = self.which.currentData()
        values = getattr(self.maps, name)
        mean = np.atleast_1d(values.mean(axis=(0, 1), dtype=np.float64))
        self.mean.setText(", ".join(format_fixed(each, 3) for each in mean))
        self.latest.ask(lambda: _image(name, values), self.image.show_image)

    def apply_theme(self) -> None:
        """Redraw what does not follow the palette by itself."""
        self.report.show_health(self.report.health)


def _image(name: str, values: NDArray[np.float32]) -> Steps[Image]:
    """A map as its textures show it: colours as light, all else as codes."""
    yield Step(0.0, "preparing the map")
    if name == "height":
        low, high = float(values.min()), float(values.max())
        values = (values - low) / ((high - low) or 1.0)
    shown = 0.5 + 0.5 * values if name == "normal" else values
    colours = np.repeat(shown[..., None], 3, axis=2) if shown.ndim == 2 else shown
    light = colours if name == "base_colour" else np.asarray(srgb_decode(colours), np.float32)
    return (yield from photograph(np.ascontiguousarray(light, np.float32)))
