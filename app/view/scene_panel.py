"""The scene of the View workspace: the model with its doubtful parts, and the ground below."""

from __future__ import annotations

import dataclasses
from pathlib import Path

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QCheckBox, QFileDialog

from app.commands.workbench import Workbench
from app.document.document import Look, Project
from app.document.scene import DEFAULT_MODEL
from app.jobs.newest import Latest
from app.widgets.controls import ComboBox
from app.widgets.panels import Rows, Segments, button
from app.widgets.param_form import ParamForm
from app.widgets.report import Report
from engine.core.steps import Step, Steps
from engine.geometry.brushing import AXES, Brushing
from engine.geometry.mesh import Mesh
from engine.geometry.mesh_repair import INSIDE_OUT
from engine.geometry.shapes import FLAT, SHAPES, shape
from engine.storage.readers import dialog_filter, suffixes

MODEL_NAMES = {
    "sphere": "Sphere",
    "plane": "Plane",
    "torus-knot": "Torus knot",
    "cloth": "Draped cloth",
    "blob": "Abstract bust",
    FLAT: "Flat, once",
}


#: Words for directions of brushing, and their vectors; None for the texture's.
BRUSHINGS: dict[str, tuple[float, float, float] | None] = {
    "Along the texture": None,
    **{f"Along {axis.upper()}": vector for axis, vector in AXES.items()},
}


class ScenePanel(Rows):
    """`edited(look, final)` and `set_look(words, look)` ask for changes."""

    edited = Signal(object, bool)
    set_look = Signal(str, object)

    def __init__(self, bench: Workbench) -> None:
        super().__init__("Scene")
        self.bench = bench
        self.mesh: Mesh | None = None
        look = Look()
        self.model = ComboBox()
        self.model.activated.connect(self._model_chosen)
        self.row("Model", self.model, "A built-in model, or a mesh of your own")
        self.report = Report()
        self.wide(self.report)
        self.flip = button("Flip it", "link", hint="Flip the faces, so that the surface faces outwards")
        self.flip.clicked.connect(self._flip)
        self.wide(self.flip)
        self.repeats = ParamForm(look, {"repeats": "Tiling"})
        self.wide(self.repeats)
        self.cells = Segments(
            (
                ("grid", "Grid", "Each repeat of the maps is the same"),
                (
                    "hex",
                    "Hexagonal",
                    "In hexagonal cells without a visible period, for materials without a regular pattern",
                ),
            )
        )
        self.cells.chosen.connect(self._cells_chosen)
        self.row("Tiling mode", self.cells, "How the material repeats over the model")
        self.brushing = ComboBox()
        for words, along in BRUSHINGS.items():
            self.brushing.addItem(words, along)
        self.brushing.activated.connect(lambda _: self._brush(self._brushing_chosen(), final=True))
        self.row("Brushing", self.brushing, "The direction along which an anisotropic BRDF runs")
        self.angle = ParamForm(Brushing(), {"angle_deg": "Angle"})
        self.angle.edited.connect(self._brush)
        self.wide(self.angle)
        self.brushed = Latest(bench.jobs, "Brushing the model")
        self.ground = QCheckBox("Ground")
        self.ground.setToolTip("A level diffuse surface under the model")
        self.ground.clicked.connect(self._ground_clicked)
        self.wide(self.ground)
        self.albedo = ParamForm(look, {"ground_albedo": "Albedo"})
        self.wide(self.albedo)
        for form in (self.repeats, self.albedo):
            form.edited.connect(self.edited)

    def show_project(self, project: Project) -> None:
        """Show the model, the findings about its file, and the ground."""
        for form in (self.repeats, self.albedo):
            form.show_instance(project.look)
        self.ground.setChecked(project.look.has_ground)
        self._show_models(project)
        self._show_brushing(project)
        for widget in (self.repeats, self.ground):
            widget.setHidden(project.is_flat)
        self.cells.choose(project.look.tiling_mode)
        self.show_row(self.cells, project.has_map and not project.is_flat)
        self.albedo.setHidden(project.is_flat or not project.look.has_ground)
        if project.mesh is not self.mesh or project.mesh is None:
            self.mesh = project.mesh
            self._show_health(project.mesh)

    def _show_brushing(self, project: Project) -> None:
        """The direction of the brushing, where the BRDF has one."""
        brushing = project.mesh.brushing if project.mesh is not None else Brushing()
        is_brushed = not project.material.reflectance.isotropic
        self.show_row(self.brushing, is_brushed)
        self.angle.setVisible(is_brushed)
        self.angle.show_instance(brushing)
        while self.brushing.count() > len(BRUSHINGS):
            self.brushing.removeItem(len(BRUSHINGS))
        known = list(BRUSHINGS.values())
        if brushing.along not in known:
            self.brushing.addItem(f"Along {Brushing(brushing.along)}", brushing.along)
        self.brushing.setCurrentIndex(known.index(brushing.along) if brushing.along in known else len(known))

    def _brushing_chosen(self) -> Brushing:
        along = self.brushing.currentData()
        return dataclasses.replace(self.angle.instance, along=None if along is None else tuple(along))

    def _brush(self, brushing: Brushing, final: bool) -> None:
        document = self.bench.document
        mesh = document.project.mesh

        def show(brushed: Mesh) -> None:
            now = document.project.mesh
            if now is mesh or (now is not None and now.faces is brushed.faces):  # brushed meanwhile, and no other model
                document.change("Brushing", gesture="brushing", mesh=brushed)
                if final:
                    document.end_gesture()

        self.brushed.ask(lambda: _brush_mesh(mesh, brushing), show)

    def _show_health(self, mesh: Mesh | None) -> None:
        findings = mesh.health.findings if mesh is not None else ()
        self.report.setVisible(bool(findings))
        if mesh is not None and findings:
            self.report.show_health(mesh.health)
        turned = mesh is not None and mesh.health.figures.get("faces_turned", 0.0) > 0.0
        self.flip.setVisible(turned or any(finding.text == INSIDE_OUT for finding in findings))

    def _show_models(self, project: Project) -> None:
        mesh = project.mesh
        self.model.clear()
        for name in (*SHAPES, *((FLAT,) if project.has_map else ())):
            self.model.addItem(MODEL_NAMES.get(name, name), name)
        current = mesh.name if mesh is not None else DEFAULT_MODEL
        if mesh is not None and self.model.findData(mesh.name) < 0:
            self.model.addItem(mesh.name, "")
            self.model.setCurrentIndex(self.model.count() - 1)
        else:
            self.model.setCurrentIndex(max(0, self.model.findData(current)))
        self.model.setToolTip(self.model.currentText())
        self.model.addItem("Open a mesh…", "open")

    def _model_chosen(self, _index: int) -> None:
        chosen = self.model.currentData()
        if chosen == "open":
            self._show_models(self.bench.document.project)
            meshes = dialog_filter("Meshes", suffixes("mesh"))
            path, _ = QFileDialog.getOpenFileName(self, "Open a mesh", "", meshes)
            if path:
                self.bench.open([Path(path)])
        elif chosen == FLAT:
            self.bench.show_flat()
        elif chosen:
            self.bench.load_model(chosen)

    def _flip(self) -> None:
        mesh = self.mesh
        if mesh is not None:
            job = self.bench.jobs.submit("Flipping the model", lambda: _flip_mesh(mesh), lane="screen")
            job.succeeded.connect(lambda flipped: self._on_flipped(mesh, flipped))

    def _on_flipped(self, mesh: Mesh, flipped: Mesh) -> None:
        if self.bench.document.project.mesh is mesh:
            self.bench.document.change("Flip the model", mesh=flipped)

    def _cells_chosen(self, mode: str) -> None:
        look = self.bench.document.project.look
        self.set_look.emit("Tiling mode", dataclasses.replace(look, tiling_mode="hex" if mode == "hex" else "grid"))

    def _ground_clicked(self, on: bool) -> None:
        look = self.bench.document.project.look
        self.set_look.emit("Ground", dataclasses.replace(look, has_ground=on))


def _brush_mesh(mesh: Mesh | None, brushing: Brushing) -> Steps[Mesh]:
    """`mesh`, or the model of projects without one, brushed in another direction, with its tangents."""
    yield Step(0.0, "brushing the model")
    brushed = (mesh or shape(DEFAULT_MODEL)).brush(brushing)
    brushed.tangents.flags.writeable = False
    return brushed


def _flip_mesh(mesh: Mesh) -> Steps[Mesh]:
    """The other side of `mesh`, with the tangents that drawing would otherwise wait for."""
    yield Step(0.0, "flipping the model")
    flipped = mesh.flipped()
    flipped.tangents.flags.writeable = False
    return flipped
