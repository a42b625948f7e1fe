"""The Material workspace of a directional map: the image under a light that is dragged, and what was chosen why.

A disk of directions from above, on which a light is dragged; dots are the lamps of the capture.

The middle is overhead, the rim the plane of the sample, azimuth 0° on the right and 90° on top as in the image.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QPointF, QSize, Qt, Signal
from PySide6.QtGui import QAccessible, QColor, QKeyEvent, QMouseEvent, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QHBoxLayout, QWidget

from app.document.document import Project
from app.jobs.jobs import Jobs
from app.jobs.newest import Latest
from app.material.candidates import Candidates
from app.material.surface_page import page_switch
from app.material.tiling import Tiling
from app.widgets import theme
from app.widgets.controls import ComboBox
from app.widgets.image_view import Image, ImageView, photograph
from app.widgets.number_field import NumberField
from app.widgets.panels import Panel, Segments, button
from app.widgets.report import Report
from app.widgets.theme import PADDING
from app.widgets.workspace import side_by_side
from engine.core.figure_text import size_text
from engine.core.steps import Step, Steps
from engine.shading.directional.planes import DirectionalMap

#: Radii of the light and of a lamp in pixels, and the step of an arrow key in the unit disk.
LIGHT, LAMP, KEY_STEP = 7.0, 2.5, 0.05

KEYS = {
    Qt.Key.Key_Left: (-1.0, 0.0),
    Qt.Key.Key_Right: (1.0, 0.0),
    Qt.Key.Key_Up: (0.0, 1.0),
    Qt.Key.Key_Down: (0.0, -1.0),
}


class LightPad(QWidget):
    """The disk; `moved(x, y)` follows the light, unit vectors seen from above."""

    accessible_role = QAccessible.Role.Dial

    moved = Signal(float, float)

    def __init__(self) -> None:
        super().__init__()
        self.place = (-0.5, 0.5)
        self.lamps: NDArray[np.float64] = np.zeros((0, 3))
        self.setMinimumSize(140, 140)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setCursor(Qt.CursorShape.CrossCursor)
        self.setAccessibleName("Direction of the light")
        self.setToolTip("Drag the light, or move it with the arrow keys")

    def sizeHint(self) -> QSize:
        return QSize(220, 220)

    @property
    def direction(self) -> NDArray[np.float64]:
        """(3,) unit vector towards the light: x to the right of the image, y up, z towards the camera."""
        x, y = self.place
        return np.array([x, y, math.sqrt(max(1.0 - x * x - y * y, 0.0))])

    def show_lamps(self, lamps: NDArray[np.float64]) -> None:
        """Show the lamps (N, 3), unit vectors."""
        self.lamps = lamps
        self.update()

    def move_to(self, x: float, y: float) -> None:
        """Put the light at (x, y), or where the line to it leaves the disk."""
        beyond = max(math.hypot(x, y), 1.0)
        self.place = (x / beyond, y / beyond)
        self.update()
        self.moved.emit(*self.place)

    @property
    def _middle(self) -> QPointF:
        return QPointF(0.5 * self.width(), 0.5 * self.height())

    @property
    def _radius(self) -> float:
        return 0.5 * min(self.width(), self.height()) - PADDING

    def mousePressEvent(self, event: QMouseEvent) -> None:
        if event.buttons() & Qt.MouseButton.LeftButton:
            apart = (event.position() - self._middle) / self._radius
            self.move_to(apart.x(), -apart.y())

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        self.mousePressEvent(event)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        step = KEYS.get(Qt.Key(event.key()))
        if step is None:
            super().keyPressEvent(event)
            return
        self.move_to(self.place[0] + KEY_STEP * step[0], self.place[1] + KEY_STEP * step[1])

    def paintEvent(self, _event: QPaintEvent) -> None:
        painter, colours = QPainter(self), theme.current()
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        middle, radius = self._middle, self._radius
        painter.setBrush(QColor(colours.field))
        painter.setPen(QPen(QColor(colours.accent if self.hasFocus() else colours.disabled), 1.0))
        painter.drawEllipse(middle, radius, radius)
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.setPen(QPen(QColor(colours.disabled), 1.0))
        for elevation_deg in (30.0, 60.0):
            ring = radius * math.cos(math.radians(elevation_deg))
            painter.drawEllipse(middle, ring, ring)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(QColor(colours.secondary))
        for x, y, _ in self.lamps:
            painter.drawEllipse(middle + QPointF(x, -y) * radius, LAMP, LAMP)
        painter.setBrush(QColor(colours.accent))
        painter.setPen(QPen(QColor(colours.text), 1.5))
        painter.drawEllipse(middle + QPointF(self.place[0], -self.place[1]) * radius, LIGHT, LIGHT)


#: Representations that a user may choose, with their words.
PAIRS_HINT = "The light of pairs under polarisers that the material is made of"

REPRESENTATIONS = (("auto", "Automatic"), ("shading-map", "Shading map"), ("directional", "Directional map"))


def part_segments() -> Segments:
    """A choice of the light of pairs under polarisers that a material is made of."""
    return Segments(
        (
            ("diffuse", "Diffuse", "Without highlights, which the BRDF adds"),
            ("whole", "Whole", "With the highlights of the photographs"),
        )
    )


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
        settings.row("Kind", self.representation, "Automatic: the one with the smaller error of held-out photographs")
        self.part, self.settings = part_segments(), settings
        settings.row("Pairs", self.part, PAIRS_HINT)
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
        self.part.choose(project.part_of_light)
        self.settings.show_row(self.part, project.stack is not None and project.stack.diffuse is not None)
        self.tiling.show_project(project)
        self.tiling.show_seams(material.health)
        self.report.show_health(material.health)
        if found is self.directional:
            return
        self.directional = found
        count, height, width = found.planes.shape
        self.resolution.setText(f"{width} × {height} px")
        self.planes.setText(str(count))
        lamps = found.lights if found.has_lamps else found.lights[:0]
        self.lamps.setText(str(len(lamps)) if len(lamps) else "–")
        self.byte_count.setText(f"{size_text(found.planes.nbytes)}, {count} a texel")
        self.candidates.show_material(material)
        self.pad.show_lamps(lamps)
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
