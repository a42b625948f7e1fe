"""The View workspace: the material on a model under lights, in one mode or two, with every choice of the renderer."""

from __future__ import annotations

import dataclasses
from math import radians
from typing import Any

from PySide6.QtCore import Qt, QTimer, Signal
from PySide6.QtGui import QAction, QKeySequence
from PySide6.QtWidgets import (
    QApplication,
    QLineEdit,
    QSizePolicy,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from app.commands.images import Saving
from app.commands.images import save as save_image
from app.commands.opening import load_shape
from app.commands.workbench import Workbench
from app.document.document import Behind, Look, Project
from app.document.measured import choices_with, look_with, setting_of
from app.document.modes import Mode, exchange_modes, mode_of, modes, scene_of, shows_near_lamps, why_not
from app.document.scene import DEFAULT_MODEL, scene_of_project
from app.document.variation import words_on_left_out
from app.jobs.jobs import Job
from app.jobs.newest import Latest
from app.varying.panel import VaryingPanel
from app.view.bake_panel import BakePanel
from app.view.baking import Baking
from app.view.brdf_panel import BrdfPanel, LookupPanel
from app.view.compare_panel import ComparePanel
from app.view.image_error import ImageError
from app.view.images import ViewImages
from app.view.light_panel import BEHIND, LIGHT_FIELDS, LightPanel
from app.view.planning import Planning
from app.view.save_dialog import SaveDialog
from app.view.save_dialog import ask as ask_to_save
from app.view.scene_panel import ScenePanel
from app.view.views_menu import ViewsMenu
from app.viewport.gl_surface import display_of
from app.viewport.refining import same
from app.viewport.viewport import Viewport
from app.widgets import theme
from app.widgets.controls import ComboBox
from app.widgets.fitting import Fitting
from app.widgets.panels import Panel, Segments, enable, text, tool
from app.widgets.param_form import ParamForm
from app.widgets.theme import STEP
from app.widgets.workspace import bar_of_choices, side_by_side, under
from engine.brdf.brdf import Brdf
from engine.core.figure_text import percent
from engine.core.steps import Step, Steps
from engine.geometry.camera import Camera
from engine.geometry.mesh import Mesh
from engine.geometry.shapes import frame_mesh
from engine.light.environment import EnvironmentMap
from engine.planning.costs.setting import Setting
from engine.render.background import blur
from engine.render.environment_error import environment_error
from engine.scene.scene import Scene
from engine.transport import method as transport

TONE_MAPS = (("neutral", "Neutral (Khronos)"), ("aces", "ACES"), ("none", "None"))

#: Said of modes that sum over lights without looking what hides them, where a ground is seen.
NO_SHADOW = "No shadows on the ground in this mode and light: baked modes and the reference show them."

#: Said where lamps stand near the model and the mode does not show them.
NO_NEAR_LAMPS = "{} does not show near lights: choose Direct, the reference or spherical harmonics."

#: Pause after the last change before the error of the directions is measured, and the size of the image it is for.
AT_REST_MS = 800
MEASURED_PX = (640, 480)

#: Pause after the last movement of the camera until the project keeps it.
KEPT_AFTER_MS = 250

#: A bake that takes no longer begins by itself where a setting is applied that needs it.
AT_ONCE_S = 60.0


class ViewTab(QWidget):
    """Shows the project's material and changes how it looks. `error_found`: the error of A against B, or None.

    `setting_changed` follows when the mode on screen or a parameter of it is another one. `name` is proposed for
    images.
    """

    drawn = Signal(float)
    model_ready = Signal()
    error_found = Signal(object)
    setting_changed = Signal()

    def __init__(self, bench: Workbench) -> None:
        super().__init__()
        self.bench = bench
        self.default_mesh: Mesh | None = None
        self._framed: tuple[Mesh, Camera] | None = None
        self.latest = Latest(bench.jobs, "Measuring the light's error", lane="background")
        self.blurring = Latest(bench.jobs, "Blurring the environment")
        self._behind: tuple[EnvironmentMap | None, str] = (None, "")
        self.at_rest = QTimer(self)
        self.at_rest.setSingleShot(True)
        self.at_rest.setInterval(AT_REST_MS)
        self.at_rest.timeout.connect(self._measure)
        self.camera_at_rest = QTimer(self)
        self.camera_at_rest.setSingleShot(True)
        self.camera_at_rest.setInterval(KEPT_AFTER_MS)
        self.camera_at_rest.timeout.connect(self._keep_camera)
        self._camera: Camera | None = None
        self._seen: Mesh | None = None
        self._loading: Job | None = None
        self._setting: Setting | None = None
        self._to_bake = ""
        self.dialog: SaveDialog | None = None
        self.name = ""
        self.viewport = Viewport(bench.jobs)
        self.images = ViewImages(self.viewport, bench.jobs)
        self.bakings: dict[str, Baking] = {method.name: Baking(bench, method) for method in transport.METHODS}
        self.planning = Planning(bench, self.scene, self.viewport.screen_px, self)
        self.images.relit_of = lambda mode, scene: self.bakings[mode].relit(scene) if mode in self.bakings else None
        self._make_actions()
        work = side_by_side(self._make_left(), self._make_centre(), self._make_right(), stretch=1)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.addWidget(work)
        self._connect()
        self._show(bench.document.project)

    @property
    def work(self) -> QWidget:
        """The widget that gets the keys once a field is left."""
        return self.viewport

    def _make_actions(self) -> None:
        self.frame_action = self._action("Frame the model", "F", self.viewport.frame, "fit")
        for mode in modes():
            self._action(mode.label, mode.key, lambda value=mode.value: self.choose_mode(value))
        self._action("Wipe", "B", lambda: self.compare.toggle("wipe"))
        self._action("Difference", "E", lambda: self.compare.toggle("difference"))
        self._action("Save an image", "Ctrl+P", lambda: self.save_image("picture"))
        self._action("Save a turntable", "Ctrl+Shift+P", lambda: self.save_image("turntable"))
        self._action("Bake", "Ctrl+Return", self._bake_or_stop)
        self.flip_action = self._action("Swap the two modes", "Tab", self._flip_or_move_on)

    def _action(self, words: str, keys: str, run: object, icon: str = "") -> QAction:
        """Something that a key does while this workspace is in front, whatever panel has the focus."""
        action = QAction(theme.icon(icon), words, self) if icon else QAction(words, self)
        action.setShortcut(QKeySequence(keys))
        action.setShortcutContext(Qt.ShortcutContext.WindowShortcut)
        action.triggered.connect(lambda _checked=False: run())  # type: ignore[operator]
        self.addAction(action)
        return action

    def _make_left(self) -> QWidget:
        panel = Panel()
        self.model = ScenePanel(self.bench)
        panel.add(self.model)
        self.lights = LightPanel(self.bench)
        panel.add(self.lights)
        image = panel.section("Image")
        self.exposure = ParamForm(Look(), {"exposure_ev": "Exposure"})
        image.wide(self.exposure)
        self.tone_map = ComboBox()
        for value, words in TONE_MAPS:
            self.tone_map.addItem(words, value)
        self.tone_map.activated.connect(lambda _index: self._set_look("Tone map", tone_map=self.tone_map.currentData()))
        image.row("Tone map", self.tone_map, "Tone mapping of radiance above white")
        panel.finish()
        return panel

    def _make_centre(self) -> QWidget:
        labels = [(mode.value, mode.label, f"{mode.hint} ({mode.key})") for mode in modes()]
        self.mode = Segments(labels, {mode.value: mode.abbreviation for mode in modes()})
        self.mode.setSizePolicy(QSizePolicy.Policy.Maximum, QSizePolicy.Policy.Fixed)
        self.mode.chosen.connect(self.choose_mode)
        bar, row = bar_of_choices(STEP)
        row.addWidget(self.mode)
        framing = tool(self.frame_action)
        self.views = ViewsMenu(self.bench.document, self.viewport, framing)
        framing.setMenu(self.views)
        framing.setPopupMode(QToolButton.ToolButtonPopupMode.MenuButtonPopup)
        row.addWidget(framing)
        self.caption = Fitting()
        row.addWidget(self.caption, 1)
        self.stop = QAction(theme.icon("cancel"), "Stop refining the reference", self)
        self.stop.triggered.connect(lambda _checked=False: self._stop_or_go())
        self.stop_button = tool(self.stop)
        keeps_room = self.stop_button.sizePolicy()
        keeps_room.setRetainSizeWhenHidden(True)  # or else the image changes its width as the button comes and goes
        self.stop_button.setSizePolicy(keeps_room)
        row.addWidget(self.stop_button)
        return under(bar, self.viewport)

    def _make_right(self) -> QWidget:
        panel = self.right = Panel()
        self.bake_panels = {method: BakePanel(baking) for method, baking in self.bakings.items()}
        self.brdf_panel = BrdfPanel(self.bench)
        self.lookup = LookupPanel()
        self.compare = ComparePanel()
        for bake_panel in self.bake_panels.values():
            panel.column.addWidget(bake_panel)
            bake_panel.hide()
        self.hint = text("", "secondary", wrap=True)
        self.hint.setContentsMargins(0, 0, 0, 3 * STEP)
        panel.column.addWidget(self.hint)
        panel.column.addWidget(self.brdf_panel)
        self.varying = VaryingPanel(self.bench)
        for rows in (self.varying, self.lookup, self.compare):
            panel.add(rows)
        panel.finish()
        return panel

    def _connect(self) -> None:
        document, viewport = self.bench.document, self.viewport
        viewport.light_moved.connect(self._light_moved)
        viewport.lamp_moved.connect(self.lights.move_lamp)
        viewport.near_lamp_moved.connect(self.lights.move_near_lamp)
        viewport.environment_rotated.connect(self._environment_rotated)
        viewport.drawn.connect(self.drawn)
        viewport.camera_moved.connect(self._error_is_stale)
        viewport.camera_moved.connect(self.camera_at_rest.start)
        for baking in self.bakings.values():
            baking.relit_changed.connect(self._relit)
            baking.changed.connect(self._setting_may_have_changed)
            baking.changed.connect(self._hurry_plan)
        self.images.progressed.connect(self._show_caption)
        self.planning.changed.connect(self._on_planned)
        self.images.error_found.connect(self._show_compared)
        self.images.error_found.connect(self.error_found)
        self.brdf_panel.ready.connect(lambda: self._show(document.project))
        for form in (self.model, self.lights, self.exposure):
            form.edited.connect(self._look_edited)
        for panel in (self.model, self.lights, self.lookup, self.compare):
            panel.set_look.connect(self._change_look)
        document.changed.connect(lambda _old, new: self._show(new))

    @property
    def brdf(self) -> Brdf | None:
        """The BRDF of the model, in the form that is drawn."""
        return self.brdf_panel.brdf

    def showEvent(self, event: object) -> None:
        super().showEvent(event)  # type: ignore[arg-type]
        self.want_model()
        self.viewport.setFocus()
        self._show(self.bench.document.project)

    def hideEvent(self, event: object) -> None:
        super().hideEvent(event)  # type: ignore[arg-type]
        self.images.give_up()
        self.planning.watch("bake", False)

    def want_model(self) -> None:
        """Load the model that a new project is shown on, the first time that somebody asks; `model_ready` follows."""
        if self.default_mesh is None and (self._loading is None or self._loading.over):
            title = "Loading the model"
            self._loading = self.bench.jobs.submit(title, lambda: load_shape(DEFAULT_MODEL), lane="screen")
            self._loading.succeeded.connect(self._default_ready)
            self._loading.cancelled.connect(lambda: self.want_model() if self.isVisible() else None)

    def _default_ready(self, mesh: Mesh) -> None:
        self.default_mesh = mesh
        self._show(self.bench.document.project)
        self.model_ready.emit()

    def fit(self) -> None:
        """Frame the model."""
        self.viewport.frame()

    def _show(self, project: Project) -> None:
        look, material = project.look, project.material
        self.exposure.show_instance(look)
        self.tone_map.setCurrentIndex(max(0, self.tone_map.findData(look.tone_map)))
        self._error_is_stale()
        self._show_modes(project)
        self._setting_may_have_changed()
        for panel in (self.model, self.lights, self.brdf_panel, self.varying, self.lookup, self.compare):
            panel.show_project(project)
        is_varying = bool(project.variations) or not project.is_flat  # only baked modes show variations
        self.right.show_group(self.varying, is_varying)
        mesh = project.mesh or self.default_mesh
        if mesh is not None:
            self.lights.show_size(mesh)
        self._want_behind(project.environment if project.look.behind else None, project.look.behind)
        scene = self.scene(project)
        if scene is None:
            self.camera_at_rest.stop()  # what is on screen is of another project
            return
        self.lookup.show_scene(project, scene)
        alone = "" if project.has_map else "No material yet: the model shows the BRDF alone."
        if material.pbr is not None and not mode_of(look.mode, project).shows_texels:
            alone = "Direct light shows the BRDF at the mean of the PBR maps."
        note = self.brdf_panel.drawable.note if material.measured is not None else ""
        ground = NO_SHADOW if look.has_ground and not _casts_shadows(mode_of(look.mode, project), scene) else ""
        near = _without_near_lamps(project)
        varied = _without_variations(project, scene)
        said = "\n".join(filter(None, (alone, ground, near, varied, note and f"Measured BRDF: {note}")))
        self.hint.setText(said)
        self.hint.setVisible(bool(said))
        self.planning.refresh()
        self._want_baked(project, scene)
        self.images.show(project, scene, self.lights.handles(project))
        self._see(project, scene.mesh)

    def _want_behind(self, environment: EnvironmentMap | None, behind: Behind) -> None:
        """Have the environment behind the model, blurred in a job; until then there is what was there before."""
        if (environment, behind) == self._behind:
            return
        self._behind, blur = (environment, behind), radians(BEHIND[behind][1])
        if environment is None or not blur:
            self.viewport.show_behind(environment)
        else:
            self.blurring.ask(
                lambda: _blur(environment, blur),
                lambda found: self.viewport.show_behind(found) if self._behind == (environment, behind) else None,
            )

    def _see(self, project: Project, mesh: Mesh) -> None:
        """See the model as a project has it that was opened; a camera that moves meanwhile is left alone.

        Another mesh has been framed by the viewport, also where it is that of the same camera: flipped, or late.
        """
        is_elsewhere, is_framed = project.camera is not self._camera, mesh is not self._seen
        self._camera, self._seen = project.camera, mesh
        if project.camera is not None and (is_elsewhere or is_framed):
            self.viewport.look_from(project.camera)
        elif is_elsewhere:
            self.viewport.frame()

    def come_to_rest(self) -> None:
        """The project keeps the camera now, where it still moves."""
        if self.camera_at_rest.isActive():
            self.camera_at_rest.stop()
            self._keep_camera()

    def _keep_camera(self) -> None:
        """The camera has come to rest: the project keeps it."""
        self._camera = self.viewport.placed
        self.bench.document.look_from(self._camera)

    def _want_baked(self, project: Project, scene: Scene) -> None:
        """Have the light of those modes on screen that are baked."""
        look, planning = project.look, self.planning
        shown = {mode_of(value, project).value for value in (look.mode, *([look.against] if look.comparing else []))}
        planning.watch("bake", self.isVisible() and not shown.isdisjoint(self.bakings))
        for method, baking in self.bakings.items():
            self.bake_panels[method].setVisible(method in shown)
            if method in shown:
                baking.want(scene, planning.plan, is_planning=planning.is_coming)

    def _on_planned(self) -> None:
        """Bakes follow the new plan."""
        project = self.bench.document.project
        scene = self.scene(project)
        if scene is not None:
            self._want_baked(project, scene)

    def _show_compared(self, error: ImageError | None) -> None:
        self.compare.show_error(error if len(self.images.modes) > 1 else None)

    def _relit(self) -> None:
        self.images.relit()
        self._show(self.bench.document.project)

    def _show_modes(self, project: Project) -> None:
        self.mode.choose(mode_of(project.look.mode, project).value)
        self.flip_action.setEnabled(bool(project.look.comparing))  # or else Tab moves the focus
        for mode in modes():
            self.mode.disable(mode.value, why_not(mode, project))

    def _show_caption(self) -> None:
        """Show the progress of the reference, or the size of the model."""
        mesh = self.bench.document.project.mesh or self.default_mesh
        triangles = f"{len(mesh.faces):,} triangles".replace(",", " ") if mesh is not None else ""
        words = self.images.progress or triangles
        short = words.removeprefix("reference ")
        self.caption.say(words, short, short.split(",")[0], short.rpartition(", ")[2])
        reference = self.images.reference
        self.stop_button.setVisible(self.images.progressive is not None)
        self.stop.setIcon(theme.icon("reset" if reference.stopped else "cancel"))
        self.stop.setToolTip("Refine the reference again" if reference.stopped else "Stop refining the reference")
        enable(self.stop_button, "" if reference.running or reference.stopped else "The reference is not being refined")

    def _stop_or_go(self) -> None:
        reference = self.images.reference
        if reference.stopped:
            reference.again()
        else:
            reference.stop()
        self._show_caption()

    def scene(self, project: Project) -> Scene | None:
        """The scene of the project; None until a model is loaded. The viewport puts in its own camera."""
        mesh = project.mesh or self.default_mesh
        if mesh is None or self.brdf is None:
            return None
        return scene_of_project(project, mesh, self.brdf, self.viewport.camera or self._first_camera(mesh))

    def _first_camera(self, mesh: Mesh) -> Camera:
        """The camera that shows `mesh` until the viewport has one; found once, because it looks at all vertices."""
        if self._framed is None or self._framed[0] is not mesh:
            self._framed = mesh, frame_mesh(mesh)
        return self._framed[1]

    def _error_is_stale(self) -> None:
        """The image is another one: its error is measured once it has come to rest."""
        self.lights.error.setText("–")
        if self.bench.document.project.environment is not None:
            self.at_rest.start()

    def _measure(self) -> None:
        """Measure the error of the directions against the whole environment, once the image rests."""
        project = self.bench.document.project
        scene = self.scene(project)
        if scene is not None and scene.environment is not None and self.isVisible():
            self.latest.ask(lambda: _directions_error(scene), lambda error: self._show_error(scene, error))

    def _show_error(self, scene: Scene, error: float) -> None:
        now = self.scene(self.bench.document.project)
        if now is not None and same(now, scene):
            self.lights.error.setText(f"{percent(error, 3)}" if error > 0.00095 else "< 0.1 %")

    def choose_mode(self, value: str) -> None:
        """Show another mode; where it is the one compared with, the two change places."""
        look, project = self.bench.document.project.look, self.bench.document.project
        if next((why_not(mode, project) for mode in modes() if mode.value == value), ""):
            return
        before = mode_of(look.mode, project).value
        against = before if value == look.against else look.against
        self._set_look("Mode", gesture="mode", mode=value, against=against)

    @property
    def setting(self) -> Setting:
        """The mode on screen with its parameters."""
        project = self.bench.document.project
        return self.setting_of(mode_of(project.look.mode, project).value)

    def setting_of(self, mode: str) -> Setting:
        """The setting of a mode."""
        baking = self.bakings.get(mode)
        return setting_of(mode, self.bench.document.project.look, baking.chosen if baking is not None else None)

    def apply_setting(self, setting: Setting) -> None:
        """Show a mode with these parameters; a bake that it calls for begins as soon as what it takes is known."""
        project = self.bench.document.project
        if next((why_not(mode, project) for mode in modes() if mode.value == setting.mode), "unknown"):
            return
        parts: dict[str, Any] = {"look": dataclasses.replace(project.look, **look_with(setting, project.look))}
        baking = self.bakings.get(setting.mode)
        if baking is not None:
            parts["bakes"] = baking.with_choices(choices_with(setting, baking.choices))
            self._to_bake = setting.mode
        if any(getattr(project, name) != part for name, part in parts.items()):
            self.bench.document.change(f"Use {setting}", **parts)
        self._setting_may_have_changed()

    def _bake_or_stop(self) -> None:
        """Press the button of the baked mode on screen."""
        project = self.bench.document.project
        panels = [self.bake_panels[mode.value] for mode in _on_screen(project) if mode.baked]
        if panels and not panels[0].go.isHidden():
            panels[0].go.click()

    def bake_again(self, method: str) -> None:
        """Show a method, and bake it unless that is done; a bake that was interrupted goes on."""
        if method in self.bakings:
            self.choose_mode(method)
            self.bakings[method].go_on()

    def _hurry_plan(self) -> None:
        """A bake that the user asked for waits for the plan."""
        if any(baking.is_awaited and baking.is_planning for baking in self.bakings.values()):
            self.planning.hurry()

    def _setting_may_have_changed(self) -> None:
        baking = self.bakings.get(self._to_bake)
        if baking is not None and (baking.is_made or baking.job is not None):
            self._to_bake = ""
        elif baking is not None and baking.ready is not None:
            self._to_bake = ""
            if baking.ready.bake_s <= AT_ONCE_S:
                baking.bake()
        setting = self.setting
        if setting != self._setting:
            self._setting = setting
            for panel in self.bake_panels.values():
                panel.refresh()
            self.setting_changed.emit()

    def _flip_or_move_on(self) -> None:
        """Tab exchanges the two images, but leads on from a field that is being typed in, as everywhere."""
        if isinstance(QApplication.focusWidget(), QLineEdit):
            self.focusNextChild()
        else:
            self.flip()

    def flip(self) -> None:
        """Exchange the mode that is shown and the one it is compared with."""
        self._change_look("Mode", exchange_modes(self.bench.document.project.look), gesture="mode")

    def _environment_rotated(self, angle_deg: float, final: bool) -> None:
        self._set_look("Rotate the environment", gesture="rotation_deg", rotation_deg=angle_deg)
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
            words = "Change the light" if changed in LIGHT_FIELDS else "Change the image"
            words = "Change a light" if changed in ("lamps", "near_lamps") else words
            document.change(words, gesture=changed, look=look)
        if final:
            document.end_gesture()

    def _set_look(self, words: str, *, gesture: str = "", **parts: object) -> None:
        look = dataclasses.replace(self.bench.document.project.look, **parts)  # type: ignore[arg-type]
        self._change_look(words, look, gesture=gesture)

    def _change_look(self, words: str, look: Look, gesture: str = "") -> None:
        if look != self.bench.document.project.look:
            self.bench.document.change(words, gesture=gesture, look=look)

    def _light_moved(self, theta_deg: float, phi_deg: float, final: bool) -> None:
        self._set_look("Move the light", gesture="light", light_theta_deg=theta_deg, light_phi_deg=phi_deg)
        if final:
            self.bench.document.end_gesture()

    def save_image(self, kind: str) -> None:
        """Ask for the size of a 'picture' or a 'turntable' of the mode on screen, and for its place."""
        project = self.bench.document.project
        mode = mode_of(project.look.mode, project)
        why_no_sky = "" if project.environment is not None else "There is no environment: choose one under Light"
        place = self.bench.propose(self.name, "picture")
        about = {"screen_px": self.viewport.screen_px(), "mode": mode, "why_no_sky": why_no_sky, "place": place}
        self.dialog = ask_to_save(self, kind, self.save, **about)

    def save(self, saving: Saving) -> None:
        """Draw what is on screen and write it, in a job."""
        project = self.bench.document.project
        scene, mode = self.scene(project), mode_of(project.look.mode, project)
        if scene is None:
            return
        self.bench.write_into(saving.path.parent)
        if not mode.baked:
            scene = scene_of(mode, scene)
        baking = self.bakings.get(mode.value)
        relighting = baking.relighting if baking is not None else None
        display = display_of(project.look.exposure_ev, project.look.tone_map)
        job = self.bench.jobs.submit(
            f"Saving {saving.path.name}",
            lambda: save_image(scene, saving, display, mode, relighting, project.look.bounces),
            lane="compute",
            resource=str(saving.path),
            on_stop="Nothing is written if you stop it.",
        )
        job.succeeded.connect(self.bench.said.emit)

    def apply_theme(self) -> None:
        """Redraw what does not follow the palette by itself."""
        self.frame_action.setIcon(theme.icon("fit"))
        self.lights.apply_theme()
        self.varying.apply_theme()
        self._show_caption()
        self.viewport.redraw()


def _on_screen(project: Project) -> list[Mode]:
    """The modes on screen."""
    look = project.look
    return [mode_of(value, project) for value in (look.mode, *([look.against] if look.comparing else []))]


def _without_variations(project: Project, scene: Scene) -> str:
    """A sentence on the first mode on screen that leaves out what varies over the model; empty where none does."""
    said = (words_on_left_out(m.label, m.value, scene.brdf, project.variations) for m in _on_screen(project))
    return next(filter(None, said), "")


def _casts_shadows(mode: Mode, scene: Scene) -> bool:
    """True if images of the scene in `mode` have shadows; sums over lights have those of sharp lights alone."""
    if mode.baked or not mode.casts_shadows or mode.progressive:
        return mode.casts_shadows
    drawn = scene_of(mode, scene)
    return bool(drawn.near_lamps or len(drawn.sharp_lights.direction))


def _without_near_lamps(project: Project) -> str:
    """A sentence on the first mode on screen that leaves out the lamps near the model; empty where none does."""
    look, shown = project.look, _on_screen(project)
    without = [mode.label for mode in shown if look.near_lamps and not shows_near_lamps(mode)]
    return NO_NEAR_LAMPS.format(without[0]) if without else ""


def _blur(environment: EnvironmentMap, radius: float) -> Steps[EnvironmentMap]:
    yield Step(0.0, "blurring")
    return blur(environment, radius)


def _directions_error(scene: Scene) -> Steps[float]:
    yield Step(0.0, "compiling (first use only)")

    return (yield from environment_error(scene, MEASURED_PX)).rmse_rel
