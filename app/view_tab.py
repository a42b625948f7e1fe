"""The View workspace: the material on a model under a light, with every choice that the renderer offers."""

from __future__ import annotations

import dataclasses
from math import radians
from pathlib import Path

from PySide6.QtCore import Qt, QTimer, Signal
from PySide6.QtGui import QAction, QKeySequence
from PySide6.QtWidgets import QComboBox, QFileDialog, QHBoxLayout, QVBoxLayout, QWidget

from app import brdf_verbs, icons
from app.brdf_names import BRDF_LABELS, BRDF_NAMES
from app.comparison import Entry
from app.document import Look, Project
from app.drawable import Drawable
from app.latest import Latest
from app.number_field import plain
from app.panels import Panel, Segments, side_by_side, text, tool
from app.param_form import ParamForm
from app.theme import PADDING, STEP, role
from app.viewport import Viewport
from app.workbench import Workbench, load_shape
from engine.brdf.brdf import MODELS, Brdf, brdf_from_text, brdf_to_text, model_name
from engine.camera import frame
from engine.environment import EnvironmentMap
from engine.mesh import SUFFIXES, Mesh
from engine.params import parameters
from engine.scene import Scene
from engine.shapes import SHAPES
from engine.steps import Step, Steps

DEFAULT_MODEL = "cloth"

MODEL_NAMES = {
    "sphere": "Sphere",
    "plane": "Plane",
    "torus-knot": "Torus knot",
    "cloth": "Draped cloth",
    "blob": "Bust",
}
LOOKUPS = (
    ("radiance", "Inside the integral", "The slice is looked up with r = BRDF × cosine: the method itself"),
    ("texture", "Lit texture", "The brightest slice, lit like a texture"),
    ("outgoing", "By outgoing radiance", "The slice is looked up with the light that leaves the surface"),
    ("angle", "By angle", "The slice is chosen by the angle of the light alone"),
)
TONE_MAPS = (("neutral", "Neutral (Khronos)"), ("aces", "ACES"), ("none", "None"))

ENVIRONMENT_NAMES = {"studio": "Studio", "sky": "Sky"}
LIGHT_FIELDS = ("light_theta_deg", "light_phi_deg", "irradiance", "rotation_deg", "gain")
DIRECTIONS = (16, 32, 64, 128, 256, 512)

#: Pause after the last change before the error of the directions is measured, and the size of the picture it is for.
AT_REST_MS = 800
MEASURED_PX = (640, 480)


class ViewTab(QWidget):
    """Shows the project's material and changes how it looks."""

    drawn = Signal(float)
    model_ready = Signal()

    def __init__(self, bench: Workbench) -> None:
        super().__init__()
        self.bench = bench
        self.default_mesh: Mesh | None = None
        self.own_environment: EnvironmentMap | None = None
        self.latest = Latest(bench.jobs, "Measuring the light's error")
        self.at_rest = QTimer(self)
        self.at_rest.setSingleShot(True)
        self.at_rest.setInterval(AT_REST_MS)
        self.at_rest.timeout.connect(self._measure)
        self.brdf: Brdf | None = None
        self.drawable = Drawable(bench.jobs)
        self.drawable.ready.connect(lambda: self._show(bench.document.project))
        self.viewport = Viewport(bench.jobs)
        self.viewport.light_moved.connect(self._light_moved)
        self.viewport.environment_turned.connect(self._environment_turned)
        self.viewport.drawn.connect(self.drawn)
        self.viewport.camera_moved.connect(self._error_is_stale)
        self.frame_action = QAction(icons.icon("fit"), "Frame the model", self)
        self.frame_action.setShortcut(QKeySequence("F"))
        self.frame_action.setShortcutContext(Qt.ShortcutContext.WidgetWithChildrenShortcut)
        self.frame_action.triggered.connect(self.viewport.frame)
        self.addAction(self.frame_action)
        work = side_by_side(self._make_left(), self._make_centre(), self._make_right(), stretch=1)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.addWidget(work)
        bench.document.changed.connect(lambda _old, new: self._show(new))
        self._show(bench.document.project)

    def _make_left(self) -> QWidget:
        panel = Panel()
        scene = panel.section("Scene")
        self.model = QComboBox()
        self.model.activated.connect(self._model_chosen)
        scene.row("Model", self.model, "A built-in model, or a mesh of your own")
        look = Look()
        self.repeats = ParamForm(look, {"repeats": "Repeats"})
        self.light = ParamForm(look, {"light_theta_deg": "Theta", "light_phi_deg": "Phi", "irradiance": "Irradiance"})
        self.surround = ParamForm(look, {"rotation_deg": "Rotation", "gain": "Strength"})
        self.exposure = ParamForm(look, {"exposure_ev": "Exposure"})
        scene.wide(self.repeats)
        light = panel.section("Light")
        self.lighting = QComboBox()
        self.lighting.activated.connect(self._lighting_chosen)
        light.row("From", self.lighting, "One light, or light from all around; .hdr and .exr files can be dropped here")
        light.wide(self.light)
        light.wide(self.surround)
        self.directions = QComboBox()
        for count in DIRECTIONS:
            self.directions.addItem(str(count), count)
        self.directions.activated.connect(
            lambda _index: self._set_look("Directions", directions=self.directions.currentData())
        )
        self.surround.row(
            "Directions", self.directions, "How many lights stand for the environment: more are truer and slower"
        )
        self.light_error = self.surround.figure(
            "Error", "Of these directions against the whole environment, on this picture"
        )
        picture = panel.section("Picture")
        picture.wide(self.exposure)
        self.tone_map = QComboBox()
        for value, words in TONE_MAPS:
            self.tone_map.addItem(words, value)
        self.tone_map.activated.connect(lambda _index: self._set_look("Tone map", tone_map=self.tone_map.currentData()))
        picture.row("Tone map", self.tone_map, "How radiance above white is brought onto the screen")
        for form in (self.repeats, self.light, self.surround, self.exposure):
            form.edited.connect(self._look_edited)
        panel.finish()
        return panel

    def _make_centre(self) -> QWidget:
        self.source = Segments(
            (
                ("slices", "Slices", "Look up the slices of the shading map"),
                ("power-law", "Power law", "Look up the compressed pair, six numbers per texel"),
            )
        )
        self.source.chosen.connect(lambda value: self._set_look("Show from", source=value))
        bar = role(QWidget(), "bar")
        bar.setFixedHeight(36)
        row = QHBoxLayout(bar)
        row.setContentsMargins(PADDING, 0, PADDING, 0)
        row.setSpacing(2 * STEP)
        row.addWidget(self.source)
        row.addWidget(tool(self.frame_action))
        row.addStretch(1)
        self.caption = text("", "secondary")
        row.addWidget(self.caption)
        centre = QWidget()
        column = QVBoxLayout(centre)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        column.addWidget(bar)
        column.addWidget(self.viewport, 1)
        return centre

    def _make_right(self) -> QWidget:
        panel = Panel()
        reflectance = panel.section("Reflectance")
        self.brdf_choice = QComboBox()
        self.brdf_choice.activated.connect(self._brdf_chosen)
        reflectance.row("Model", self.brdf_choice, "A model, or what the BRDF workspace compares")
        self.brdf_rows = QVBoxLayout()
        self.brdf_rows.setContentsMargins(0, 0, 0, 0)
        holder = QWidget()
        holder.setLayout(self.brdf_rows)
        reflectance.wide(holder)
        self.brdf_form: ParamForm | None = None
        lookup = panel.section("Look-up")
        self.lookup = QComboBox()
        for value, words, hint in LOOKUPS:
            self.lookup.addItem(words, value)
            self.lookup.setItemData(self.lookup.count() - 1, hint, Qt.ItemDataRole.ToolTipRole)
        self.lookup.activated.connect(lambda _index: self._set_look("Look-up", lookup=self.lookup.currentData()))
        lookup.row("Method", self.lookup, "The four look-ups of Kautz et al. 2004, figure 6")
        self.above = Segments(
            (
                ("clamp", "Clamp", "Brighter than the brightest photograph: that photograph"),
                ("scale", "Scale", "Brighter than the brightest photograph: scaled up"),
            )
        )
        self.above.chosen.connect(lambda value: self._set_look("Above the largest r", above=value))
        lookup.row("Above", self.above, "What happens above the largest r of the capture")
        self.sigma = lookup.figure("Scale σ", "Automatic: model and photographs agree on the capture's own lights")
        self.r_max = lookup.figure("Largest r")
        self.hint = text("", "secondary", wrap=True)
        panel.column.addSpacing(2 * STEP)
        panel.column.addWidget(self.hint)
        panel.finish()
        return panel

    def showEvent(self, event: object) -> None:
        super().showEvent(event)  # type: ignore[arg-type]
        self.want_model()

    def want_model(self) -> None:
        """Load the model that a new project is shown on, the first time that somebody asks; `model_ready` follows."""
        if self.default_mesh is None:
            job = self.bench.jobs.submit("Loading the model", lambda: load_shape(DEFAULT_MODEL), heavy=False)
            job.succeeded.connect(self._default_ready)

    def _default_ready(self, mesh: Mesh) -> None:
        self.default_mesh = mesh
        self._show(self.bench.document.project)
        self.model_ready.emit()

    def fit(self) -> None:
        """Frame the model."""
        self.viewport.frame()

    def _show(self, project: Project) -> None:
        look, material = project.look, project.material
        for form in (self.repeats, self.light, self.surround, self.exposure):
            form.show_instance(look)
        for box, value in (
            (self.tone_map, look.tone_map),
            (self.lookup, look.lookup),
            (self.directions, look.directions),
        ):
            box.setCurrentIndex(max(0, box.findData(value)))
        self._show_lighting(project)
        self.above.choose(look.above)
        self._show_source(project)
        self._show_models(project)
        self._show_brdf(project)
        scene = self.scene(project)
        if scene is None:
            return
        shading = scene.shading
        self.sigma.setText(f"{plain(scene.sigma)} auto" if material.sigma is None else plain(scene.sigma))
        self.r_max.setText(plain(shading.r_max) if shading is not None else "–")
        faces = f"{len(scene.mesh.faces):,}".replace(",", " ")
        self.caption.setText(f"{faces} triangles")
        alone = "" if project.has_map else "No material yet: the model shows the reflectance alone."
        note = self.drawable.note if material.measured is not None else ""
        self.hint.setText("\n".join(filter(None, (alone, note and f"Measured reflectance: {note}"))))
        self.viewport.show_scene(scene, look.exposure_ev, look.tone_map, (look.light_theta_deg, look.light_phi_deg))

    def scene(self, project: Project) -> Scene | None:
        """What the project shows; None until a model is loaded. The viewport puts in its own camera."""
        mesh = project.mesh or self.default_mesh
        if mesh is None or self.brdf is None:
            return None
        look = project.look
        return Scene(
            mesh=mesh,
            camera=self.viewport.camera or frame(mesh.positions),
            brdf=self.brdf,
            material=project.material if project.has_map else None,
            light=tuple(look.light),
            irradiance=look.irradiance if project.environment is None else look.gain,
            environment=project.environment,
            environment_rotation=radians(look.rotation_deg),
            directions=look.directions,
            source=look.source,
            lookup=look.lookup,
            above=look.above,
            repeats=look.repeats,
        )

    def _show_lighting(self, project: Project) -> None:
        """The choices of light, and the rows of the one that is active."""
        environment = project.environment
        if environment is not None and environment.name not in ENVIRONMENT_NAMES:
            self.own_environment = environment
        self.lighting.clear()
        self.lighting.addItem("One light", "")
        for name, words in ENVIRONMENT_NAMES.items():
            self.lighting.addItem(words, name)
        if self.own_environment is not None:
            self.lighting.addItem(self.own_environment.name, self.own_environment.name)
        self.lighting.addItem("Open an environment…", "open")
        current = "" if environment is None else environment.name
        self.lighting.setCurrentIndex(self.lighting.findData(current))
        self.lighting.setToolTip(current)
        self._error_is_stale()
        self.light.setVisible(environment is None)
        self.surround.setVisible(environment is not None)

    def _lighting_chosen(self, _index: int) -> None:
        chosen, document = self.lighting.currentData(), self.bench.document
        if chosen == "open":
            self._show_lighting(document.project)
            path, _ = QFileDialog.getOpenFileName(self, "Open an environment", "", "Environments (*.hdr *.exr)")
            if path:
                self.bench.load_environment(path)
        elif not chosen:
            if document.project.environment is not None:
                document.change("One light", environment=None)
        elif chosen in ENVIRONMENT_NAMES:
            self.bench.load_environment(chosen)
        elif document.project.environment is not self.own_environment:
            document.change(f"Light from {chosen}", environment=self.own_environment)

    def _error_is_stale(self) -> None:
        """The picture is another one: its error is measured once it has come to rest."""
        self.light_error.setText("–")
        if self.bench.document.project.environment is not None:
            self.at_rest.start()

    def _measure(self) -> None:
        """How far the directions are from the whole environment, where the picture has come to rest."""
        project = self.bench.document.project
        scene = self.scene(project)
        if scene is not None and scene.environment is not None and self.isVisible():
            self.latest.ask(lambda: _directions_error(scene), lambda error: self._show_error(project, scene, error))

    def _show_error(self, project: Project, scene: Scene, error: float) -> None:
        if self.bench.document.project is project and self.viewport.camera == scene.camera:
            self.light_error.setText(f"{100 * error:.1f} %" if error > 0.00095 else "< 0.1 %")

    def _show_source(self, project: Project) -> None:
        material = project.material
        self.source.choose(project.look.source)
        nothing = "Build or open a material first"
        self.source.disable("slices", "" if material.shading_map is not None else nothing)
        self.source.disable("power-law", "" if material.power_law is not None else nothing)

    def _show_models(self, project: Project) -> None:
        self.model.clear()
        for name in SHAPES:
            self.model.addItem(MODEL_NAMES.get(name, name), name)
        mesh = project.mesh
        current = mesh.name if mesh is not None else DEFAULT_MODEL
        if mesh is not None and mesh.name not in SHAPES:
            self.model.addItem(mesh.name, "")
            self.model.setCurrentIndex(self.model.count() - 1)
        else:
            self.model.setCurrentIndex(max(0, self.model.findData(current)))
        self.model.addItem("Open a mesh…", "open")

    def _show_brdf(self, project: Project) -> None:
        """The choices of reflectance, and the parameters of the model that is chosen; what was measured has none."""
        measured = project.material.measured
        brdf = brdf_from_text(project.material.brdf)
        self.brdf_choice.clear()
        for name in MODELS:
            self.brdf_choice.addItem(BRDF_NAMES.get(name, name), name)
        for entry in project.comparison.entries:
            self.brdf_choice.addItem(entry.name, entry)
        if measured is not None:
            is_table = not brdf_verbs.has_shader(measured)
            self.brdf_choice.addItem(f"{measured.name} ({'measured' if is_table else 'factors'})", measured)
        current = measured if measured is not None else model_name(brdf)
        places = range(self.brdf_choice.count())
        self.brdf_choice.setCurrentIndex(next(at for at in places if self.brdf_choice.itemData(at) == current))
        self.brdf = brdf if measured is None else self.drawable.of(measured) or brdf
        if self.brdf_form is None or type(self.brdf_form.instance) is not type(brdf):
            if self.brdf_form is not None:
                self.brdf_form.hide()
                self.brdf_form.deleteLater()
            self.brdf_form = ParamForm(brdf, {p.name: BRDF_LABELS.get(p.name, p.label) for p in parameters(brdf)})
            self.brdf_form.edited.connect(self._brdf_edited)
            self.brdf_rows.addWidget(self.brdf_form)
        self.brdf_form.show_instance(brdf)
        self.brdf_form.setVisible(measured is None)

    def _model_chosen(self, _index: int) -> None:
        chosen = self.model.currentData()
        if chosen == "open":
            self._show_models(self.bench.document.project)
            endings = " ".join(f"*{suffix}" for suffix in SUFFIXES)
            path, _ = QFileDialog.getOpenFileName(self, "Open a mesh", "", f"Meshes ({endings})")
            if path:
                self.bench.open([Path(path)])
        elif chosen:
            self.bench.load_model(chosen)

    def _brdf_chosen(self, _index: int) -> None:
        name = self.brdf_choice.currentData()
        if isinstance(name, Entry):
            self._show_brdf(self.bench.document.project)
            brdf_verbs.use(self.bench, name)
        elif isinstance(name, str) and (self._is_measured or type(self.brdf) is not MODELS[name]):
            self._set_brdf(MODELS[name](), f"Reflectance {BRDF_NAMES.get(name, name)}", "")

    @property
    def _is_measured(self) -> bool:
        return self.bench.document.project.material.measured is not None

    def _brdf_edited(self, brdf: Brdf, final: bool) -> None:
        self._set_brdf(brdf, "Change reflectance", "brdf")
        if final:
            self.bench.document.end_gesture()

    def _set_brdf(self, brdf: Brdf, words: str, gesture: str) -> None:
        words_of_brdf = brdf_to_text(brdf)
        document = self.bench.document
        material = document.project.material
        if words_of_brdf != material.brdf or material.measured is not None:
            material = dataclasses.replace(material, brdf=words_of_brdf, measured=None)
            document.change(words, gesture=gesture, material=material)

    def _environment_turned(self, angle_deg: float, final: bool) -> None:
        look = dataclasses.replace(self.bench.document.project.look, rotation_deg=angle_deg)
        if look != self.bench.document.project.look:
            self.bench.document.change("Turn the environment", gesture="rotation_deg", look=look)
        if final:
            self.bench.document.end_gesture()

    def _look_edited(self, look: Look, final: bool) -> None:
        document = self.bench.document
        if look != document.project.look:
            changed = next(
                field.name
                for field in dataclasses.fields(Look)
                if getattr(look, field.name) != getattr(document.project.look, field.name)
            )
            document.change(
                "Change the light" if changed in LIGHT_FIELDS else "Change the picture", gesture=changed, look=look
            )
        if final:
            document.end_gesture()

    def _set_look(self, words: str, **parts: object) -> None:
        document = self.bench.document
        look = dataclasses.replace(document.project.look, **parts)  # type: ignore[arg-type]
        if look != document.project.look:
            document.change(words, look=look)

    def _light_moved(self, theta_deg: float, phi_deg: float, final: bool) -> None:
        look = dataclasses.replace(self.bench.document.project.look, light_theta_deg=theta_deg, light_phi_deg=phi_deg)
        if look != self.bench.document.project.look:
            self.bench.document.change("Move the light", gesture="light", look=look)
        if final:
            self.bench.document.end_gesture()

    def apply_theme(self) -> None:
        """Redraw what does not follow the palette by itself."""
        self.frame_action.setIcon(icons.icon("fit"))
        self.viewport.redraw()


def _directions_error(scene: Scene) -> Steps[float]:
    yield Step(0.0, "preparing kernels")
    from engine.render.environment_error import environment_error

    return (yield from environment_error(scene, MEASURED_PX)).rmse_rel
