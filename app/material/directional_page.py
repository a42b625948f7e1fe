"""The Material workspace of a directional map: the image under a light that is dragged, and what was chosen why."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import Signal
from PySide6.QtWidgets import QHBoxLayout, QWidget

from app.document.document import Project
from app.jobs.jobs import Jobs
from app.jobs.newest import Latest
from app.material.candidates import Candidates
from app.material.light_pad import LightPad
from app.material.surface_page import page_switch
from app.material.tiling import Tiling
from app.widgets.controls import ComboBox
from app.widgets.image_view import Image, ImageView, photograph
from app.widgets.number_field import NumberField
from app.widgets.panels import Panel, button
from app.widgets.report import Report
from app.widgets.workspace import side_by_side
from engine.core.figure_text import size_text
from engine.core.steps import Step, Steps
from engine.shading.directional.planes import DirectionalMap

#: Representations that a user may choose, with their words.
REPRESENTATIONS = (("auto", "Automatic"), ("shading-map", "Shading map"), ("directional", "Directional map"))


def representation_box() -> ComboBox:
    """A list of representations."""
    box = ComboBox()
    for value, words in REPRESENTATIONS:
        box.addItem(words, value)
    box.setAccessibleName("Representation")
    return box


class DirectionalPage(QWidget):
    """Shows a directional material. `chosen(representation)` asks for another, `build` is its button."""

    chosen = Signal(str)

    def __init__(self, jobs: Jobs) -> None:
        super().__init__()
        self.latest = Latest(jobs, "Relighting the material")
        self.directional: DirectionalMap | None = None
        self.image = ImageView()
        self.pad = LightPad()
        self.pad.moved.connect(lambda _x, _y: self._relight())
        outer = QHBoxLayout(self)
        outer.setContentsMargins(0, 0, 0, 0)
        outer.addWidget(side_by_side(self.image, self._make_right(), stretch=0))

    def _make_right(self) -> QWidget:
        panel = Panel()
        self.switch = page_switch("material")
        panel.column.addWidget(self.switch)
        light = panel.section("Light")
        light.wide(self.pad)
        self.angles = light.figure("Direction", "Elevation and azimuth of the light; dots are the lamps of the capture")
        self.exposure = NumberField(0.0, -10.0, 10.0, unit="EV")
        self.exposure.edited.connect(lambda _value, _final: self._relight())
        light.row("Exposure", self.exposure, "Brightness of this image alone; the material stays as it is")
        self.candidates = Candidates()
        panel.add(self.candidates)
        settings = panel.section("Directional map")
        self.representation = representation_box()
        self.representation.activated.connect(lambda _index: self.chosen.emit(self.representation.currentData()))
        settings.row("Kind", self.representation, "Automatic: the one that shows photographs better that are left out")
        self.tiling = Tiling(settings)
        self.resolution = settings.figure("Size")
        self.planes = settings.figure("Planes", "Images in 8 bits, whose weighted sum is the image under a light")
        self.lamps = settings.figure("Photographs")
        self.byte_count = settings.figure("Bytes")
        report = panel.section("Report")
        self.report = Report()
        report.wide(self.report)
        self.build = button("Rebuild material", "primary")
        panel.finish(self.build)
        return panel

    def show_project(self, project: Project) -> None:
        """Show the material of `project`, which has a directional map."""
        material, found = project.material, project.material.directional
        assert found is not None
        self.representation.setCurrentIndex(max(0, self.representation.findData(project.representation)))
        self.tiling.show_project(project)
        self.tiling.show_seams(material.health)
        self.report.show_health(material.health)
        if found is self.directional:
            return
        self.directional = found
        count, height, width = found.planes.shape
        self.resolution.setText(f"{width} × {height} px")
        self.planes.setText(str(count))
        self.lamps.setText(str(len(found.lights)))
        self.byte_count.setText(f"{size_text(found.planes.nbytes)}, {count} a texel")
        self.candidates.show_material(material)
        self.pad.show_lamps(found.lights)
        self._relight()

    def _relight(self) -> None:
        found, light, exposure_ev = self.directional, self.pad.direction, self.exposure.value
        elevation, azimuth = np.degrees([np.arcsin(light[2]), np.arctan2(light[1], light[0])])
        self.angles.setText(f"Elevation {elevation:.0f}°, azimuth {azimuth % 360.0:.0f}°")
        if found is not None:
            self.latest.ask(lambda: _relight_planes(found, light, exposure_ev), self.image.show_image)

    def apply_theme(self) -> None:
        """Redraw what does not follow the palette by itself."""
        self.report.show_health(self.report.health)
        self.pad.update()


def _relight_planes(directional: DirectionalMap, light: NDArray[np.float64], exposure_ev: float) -> Steps[Image]:
    yield Step(0.0, "relighting the material")
    return (yield from photograph(directional.image(light), exposure_ev=exposure_ev))
