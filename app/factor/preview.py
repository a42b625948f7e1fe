"""The factors and the BRDF itself on a model, side by side under one light and one camera, and the difference.

The two are drawn by the renderer of the View workspace; the difference is computed on the CPU in a job, once the
image has come to rest, from the values themselves.
"""

from __future__ import annotations

from math import radians
from typing import TYPE_CHECKING

import numpy as np
from PySide6.QtCore import Qt, QTimer, Signal
from PySide6.QtGui import QAccessible, QImage, QPaintEvent, QShowEvent
from PySide6.QtWidgets import QHBoxLayout, QVBoxLayout, QWidget

from app.commands.drawable import Drawable
from app.commands.factor import Difference, difference
from app.commands.opening import load_shape
from app.jobs.jobs import Jobs
from app.jobs.newest import Latest
from app.viewport.viewport import Viewport
from app.widgets.fitting import Fitting
from app.widgets.image_view import paint_whole
from app.widgets.number_field import plain
from app.widgets.panels import text
from app.widgets.theme import STEP, role
from engine.core.directions import world_direction
from engine.core.figure_text import number
from engine.geometry.camera import frame
from engine.geometry.mesh import Mesh
from engine.scene.scene import Scene

if TYPE_CHECKING:
    from engine.brdf.brdf import Brdf
    from engine.factor.errors import Factors

IRRADIANCE = 2.6

#: Pause after the last change before the difference is computed, and its longest side in pixels.
AT_REST_MS, LONGEST_PX = 250, 320


class FactorPreview(QWidget):
    """`say(words)` of each image goes into the line above it; the light is dragged in either image."""

    drawn = Signal(float)
    broken = Signal(object)

    def __init__(self, jobs: Jobs) -> None:
        super().__init__()
        self.jobs = jobs
        self.light_deg = (50.0, -40.0)
        self.sphere: Mesh | None = None
        self.mesh: Mesh | None = None
        self.factors: Factors | None = None
        self.brdf: Brdf | None = None
        self.shown: Difference | None = None
        self._loading = False
        self.drawable = Drawable(jobs)
        self.drawable.ready.connect(self._draw)
        self.comparing = Latest(jobs, "Comparing images")
        self.at_rest = QTimer(self)
        self.at_rest.setSingleShot(True)
        self.at_rest.setInterval(AT_REST_MS)
        self.at_rest.timeout.connect(self._compare)
        self.views = {side: Viewport(jobs) for side in ("factored", "unfactored")}
        self.difference = DifferenceView()
        self.captions: dict[str, Fitting] = {}
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(1)
        titles = {"factored": "Factored", "unfactored": "Unfactored", "difference": "Difference"}
        parts: dict[str, QWidget] = {**self.views, "difference": self.difference}
        for side, title in titles.items():
            self.captions[side] = Fitting()
            row.addWidget(_title(title, self.captions[side], parts[side]), 1)
        for side, view in self.views.items():
            view.setAccessibleName(f"Model, {titles[side].lower()}")
            policy = view.sizePolicy()
            policy.setRetainSizeWhenHidden(True)
            view.setSizePolicy(policy)
            view.setToolTip("Drag to rotate, Ctrl+drag or drag the sun to move the light")
            view.light_moved.connect(self._light_moved)
            view.camera_moved.connect(lambda side=side: self._follow(side))
            view.drawn.connect(self.drawn)
            view.broken.connect(self.broken)

    def show_pair(self, factors: Factors | None, brdf: Brdf | None) -> None:
        """Show `factors` beside `brdf`; None for either shows nothing there."""
        if (factors, brdf) == (self.factors, self.brdf):
            return
        self.factors, self.brdf = factors, brdf
        self.say("factored", *(() if factors is not None else ("nothing found yet", "nothing yet")))
        if factors is None:
            self.show_difference(None)
        self.refresh()

    def show_mesh(self, mesh: Mesh | None) -> None:
        """Show another model; None for the sphere."""
        if mesh is not self.mesh:
            self.mesh = mesh
            self.refresh()

    def refresh(self) -> None:
        """Draw the present images, and request the missing ones. A hidden preview does nothing."""
        if not self.isVisible():
            return
        if self.mesh is None and self.sphere is None:
            if not self._loading:
                self._loading = True
                job = self.jobs.submit("Loading the sphere", lambda: load_shape("sphere"), lane="screen")
                job.succeeded.connect(self._on_loaded)
            return
        self._draw()
        self.at_rest.start()

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
        self.refresh()

    def _on_loaded(self, mesh: Mesh) -> None:
        self.sphere = mesh
        self.refresh()

    def say(self, side: str, *forms: str) -> None:
        """Set the caption of an image to the first of `forms` that there is room for."""
        self.captions[side].say(*forms)

    def scene(self, brdf: Brdf | None) -> Scene | None:
        """The model under the light with another BRDF."""
        mesh = self.mesh or self.sphere
        if mesh is None or brdf is None:
            return None
        x, y, z = (float(component) for component in world_direction(*map(radians, self.light_deg)))
        camera = self.views["factored"].camera or self.views["unfactored"].camera or frame(mesh.positions)
        return Scene(mesh, camera, brdf, light=(x, y, z), irradiance=IRRADIANCE)

    def _draw(self) -> None:
        """Both images; while a measurement becomes a table, the last one of it stays."""
        unfactored = self.drawable.of(self.brdf) if self.brdf is not None else None
        self.say("unfactored", self.drawable.note)
        for side, brdf in (("factored", self.factors), ("unfactored", unfactored)):
            scene = self.scene(brdf)
            self.views[side].setVisible(scene is not None)
            if scene is not None:
                self.views[side].show_scene(scene, 0.0, "neutral", self.light_deg)

    def _light_moved(self, theta_deg: float, phi_deg: float, _final: bool) -> None:
        self.light_deg = (theta_deg, phi_deg)
        self._draw()
        self.at_rest.start()

    def _follow(self, side: str) -> None:
        """Look at the other image from the same place."""
        other = self.views["unfactored" if side == "factored" else "factored"]
        if self.views[side].camera != other.camera and other.scene is not None:
            other.camera = self.views[side].camera
            other.redraw()
        self.at_rest.start()

    def _compare(self) -> None:
        factored, unfactored = self.scene(self.factors), self.scene(self.brdf)
        if not self.isVisible() or factored is None or unfactored is None:
            self.show_difference(None)
            return
        width, height = max(1, self.difference.width()), max(1, self.difference.height())
        share = min(1.0, LONGEST_PX / max(width, height))
        size = (max(1, round(width * share)), max(1, round(height * share)))
        pair = (self.factors, self.brdf)

        def show(found: Difference) -> None:
            if pair == (self.factors, self.brdf):
                self.show_difference(found)

        self.comparing.ask(lambda: difference(factored, unfactored, size), show)

    def show_difference(self, found: Difference | None) -> None:
        """The image of the difference, with its scale."""
        self.shown = found
        self.difference.show_difference(found)
        forms: tuple[str, ...] = ()
        if found is not None:
            scale = f"±{plain(found.scale)}"
            forms = (f"{scale}, RMS {number(found.rms)}", scale)
        self.say("difference", *forms)


def _title(title: str, caption: QWidget, view: QWidget) -> QWidget:
    holder = role(QWidget(), "panel")
    holder.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
    head = QHBoxLayout()
    head.setContentsMargins(2 * STEP, 2, STEP, 2)
    head.setSpacing(2 * STEP)
    head.addWidget(text(title))
    head.addWidget(caption, 1)
    column = QVBoxLayout(holder)
    column.setContentsMargins(0, 0, 0, 0)
    column.setSpacing(0)
    column.addLayout(head)
    column.addWidget(view, 1)
    return holder


class DifferenceView(QWidget):
    """The last difference, as large as there is room."""

    accessible_role = QAccessible.Role.Graphic

    def __init__(self) -> None:
        super().__init__()
        self.image: QImage | None = None
        self.setMinimumSize(120, 100)
        self.setAccessibleName("Difference of the two images")
        self.setToolTip(
            "Luminance, factored minus unfactored: orange where the factors are too bright, blue where too dark"
        )

    def show_difference(self, found: Difference | None) -> None:
        """Show the image, or nothing."""
        if found is None:
            self.image = None
        else:
            pixels = np.ascontiguousarray(found.pixels)
            height, width = pixels.shape[:2]
            self.image = QImage(pixels.tobytes(), width, height, 4 * width, QImage.Format.Format_RGBA8888).copy()
        self.update()

    def paintEvent(self, _event: QPaintEvent) -> None:
        paint_whole(self, self.image)
