"""A sphere that reflects as the current BRDF, drawn by the renderer of the View workspace; its light can be dragged."""

from __future__ import annotations

from math import radians
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QVBoxLayout, QWidget

from app.commands.drawable import Drawable
from app.commands.opening import load_shape
from app.jobs.jobs import Jobs
from app.viewport.viewport import Viewport
from engine.core.directions import world_direction
from engine.geometry.camera import frame
from engine.geometry.mesh import Mesh
from engine.scene.scene import Scene

if TYPE_CHECKING:
    from engine.brdf.brdf import Brdf

IRRADIANCE = 2.6


class SpherePreview(QWidget):
    """Shows one BRDF. One without a shader becomes a table first, in a job.

    `said` reports the error of the table, in words and in fewer.
    """

    said = Signal(str, str)

    def __init__(self, jobs: Jobs) -> None:
        super().__init__()
        self.jobs = jobs
        self.drawable = Drawable(jobs)
        self.drawable.ready.connect(self._prepare)
        self.viewport = Viewport(jobs)
        self.viewport.setAccessibleName("Sphere with this BRDF")
        self.viewport.setToolTip("Drag to rotate, Ctrl+drag or drag the sun to move the light")
        self.viewport.light_moved.connect(self._light_moved)
        self.light_deg = (50.0, -40.0)
        self.mesh: Mesh | None = None
        self.brdf: Brdf | None = None
        self._drawn: Any = None
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.addWidget(self.viewport)

    def show_brdf(self, brdf: Brdf | None) -> None:
        """Show `brdf`, or go on showing the last one where it is None."""
        if brdf is None or (brdf is self.brdf and self._drawn is not None):
            return
        self.brdf = brdf
        if self.mesh is None:
            job = self.jobs.submit("Loading the sphere", lambda: load_shape("sphere"), lane="screen")
            job.succeeded.connect(self._on_loaded)
            return
        self._prepare()

    def _on_loaded(self, mesh: Mesh) -> None:
        self.mesh = mesh
        self.show_brdf(self.brdf)

    def _prepare(self) -> None:
        if self.brdf is None:
            return
        self._drawn = self.drawable.of(self.brdf)
        self.said.emit(self.drawable.note, self.drawable.shorter)
        self._draw()

    def _light_moved(self, theta_deg: float, phi_deg: float, _final: bool) -> None:
        self.light_deg = (theta_deg, phi_deg)
        self._draw()

    def _draw(self) -> None:
        if self.mesh is None or self._drawn is None:
            return
        light = world_direction(*map(radians, self.light_deg))
        x, y, z = (float(component) for component in light)
        camera = self.viewport.camera or frame(self.mesh.positions)
        scene = Scene(self.mesh, camera, self._drawn, light=(x, y, z), irradiance=IRRADIANCE)
        self.viewport.show_scene(scene, 0.0, "neutral", self.light_deg)
