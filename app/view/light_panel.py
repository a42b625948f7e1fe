"""The lights of the View workspace: one light or an environment, and lamps beside it, each with its own settings."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from math import degrees, pi, radians
from typing import Any

import numpy as np
from PySide6.QtCore import Signal
from PySide6.QtWidgets import QComboBox, QFileDialog

from app.commands.workbench import Workbench
from app.document.document import Behind, Look, Project
from app.viewport.overlay import SUN, Handle
from app.widgets import theme
from app.widgets.controls import ComboBox
from app.widgets.panels import Rows, enable, scroll_to, small_button, with_buttons
from app.widgets.param_form import ParamForm, display_colour
from engine.core.directions import Vectors, world_angles, world_direction
from engine.core.params import Colour, parameters
from engine.geometry.mesh import Mesh
from engine.light.environment import EnvironmentMap
from engine.light.lamps import LampSettings, Triple
from engine.light.near_lamps import PARAMETERS, NearLamp, NearLampSettings
from engine.light.sky import SKIES
from engine.scene.scene import MAX_LAMPS
from engine.storage.readers import dialog_filter, radiance_suffixes

LIGHT_FIELDS = ("light_theta_deg", "light_phi_deg", "irradiance", "rotation_deg", "gain")
DIRECTIONS = (16, 32, 64, 128, 256, 512)

#: Words for what stands behind the model, and its blur in degrees.
BEHIND: dict[Behind, tuple[str, float]] = {
    "": ("Solid colour", 0.0),
    "sharp": ("Environment", 0.0),
    "soft": ("Blurred a little", 4.0),
    "blurred": ("Blurred", 16.0),
}

#: Labels of the angles of a light, as everywhere in the window.
ANGLES = {
    "theta_deg": "Elevation",
    "phi_deg": "Azimuth",
    "facing_theta_deg": "Facing elevation",
    "facing_phi_deg": "Facing azimuth",
}

#: Values of the menu that are not environment.
ONE_LIGHT, ONLY_LAMPS, OPEN = "", "only-lamps", "open"

#: A new lamp: a soft key from the left, rotated further for each lamp that exists.
NEW_LAMP = LampSettings(theta_deg=50.0, phi_deg=-60.0, irradiance=1.0, radius_deg=5.0)


#: Distance of a new near lamp from the middle of the model, in half diagonals of its box, and its angle from straight
#: up: outside the built-in models, and within the image however wide that is.
NEAR, NEAR_THETA_DEG = 0.65, 65.0


class LightPanel(Rows):
    """Shows and changes the lights of a project. `edited(look, final)` and `set_look(words, look)` ask for changes."""

    edited = Signal(object, bool)
    set_look = Signal(str, object)

    def __init__(self, bench: Workbench) -> None:
        super().__init__("Light")
        self.bench = bench
        self.own_environment: EnvironmentMap | None = None
        self._mesh: Mesh | None = None
        look = Look()
        self.lighting = ComboBox()
        self.lighting.activated.connect(self._lighting_chosen)
        self.row("Source", self.lighting, "One light, or an environment; .hdr and .exr files can be dropped here")
        self.light = ParamForm(
            look, {"light_theta_deg": "Elevation", "light_phi_deg": "Azimuth", "irradiance": "Irradiance"}
        )
        self.surround = ParamForm(look, {"rotation_deg": "Rotation", "gain": "Strength"})
        self.directions = ComboBox()
        for count in DIRECTIONS:
            self.directions.addItem(str(count), count)
        self.directions.activated.connect(self._directions_chosen)
        hint = "Number of lights that represent the environment: more are more accurate and slower"
        self.surround.row("Directions", self.directions, hint)
        self.behind = ComboBox()
        for value, (words, _blur_deg) in BEHIND.items():
            self.behind.addItem(words, value)
        self.behind.activated.connect(self._behind_chosen)
        self.surround.row("Behind", self.behind, "What is seen behind the model")
        self.error = self.surround.figure(
            "Error", "Error of these directions against the whole environment, on this image"
        )
        for form in (self.light, self.surround):
            form.edited.connect(self.edited)
            self.wide(form)
        self._make_lamps()

    def apply_theme(self) -> None:
        """Draw the icons in the colour of the current theme."""
        self.lamps.apply_theme()
        self.near.apply_theme()

    def _make_lamps(self) -> None:
        about = "More lights; drag their suns in the image"
        self.lamps = LampRows(
            "Extra lights", "Extra light", about, "a light: directional, or a disc with soft shadows", NEW_LAMP
        )
        about = "Spheres, rectangles and discs of light near the model; drag their rings in the image"
        self.near = LampRows("Near lights", "Near light", about, "a light near the model", NearLampSettings())
        for rows, add, remove, edited in (
            (self.lamps, self.add_lamp, self.remove_lamp, self._lamp_edited),
            (self.near, self.add_near_lamp, self.remove_near_lamp, self._near_lamp_edited),
        ):
            rows.add.clicked.connect(add)
            rows.remove.clicked.connect(remove)
            rows.form.edited.connect(edited)
            self.wide(rows)

    @property
    def look(self) -> Look:
        return self.bench.document.project.look

    def show_project(self, project: Project) -> None:
        """Show the choices of light, and the rows of the active one."""
        environment, look = project.environment, project.look
        if environment is not None and environment.name not in SKIES:
            self.own_environment = environment
        self.lighting.clear()
        self.lighting.addItem("One light", ONE_LIGHT)
        self.lighting.addItem("Extra lights only", ONLY_LAMPS)
        for name, sky in SKIES.items():
            self.lighting.addItem(sky.label, name)
        if self.own_environment is not None:
            self.lighting.addItem(self.own_environment.name, self.own_environment.name)
        self.lighting.addItem("Open an environment…", OPEN)
        none = ONLY_LAMPS if look.only_lamps else ONE_LIGHT
        current = none if environment is None else environment.name
        self.lighting.setCurrentIndex(self.lighting.findData(current))
        self.lighting.setToolTip(self.lighting.currentText())
        self.light.setVisible(environment is None and not look.only_lamps)
        self.surround.setVisible(environment is not None)
        for form in (self.light, self.surround):
            form.show_instance(look)
        self.directions.setCurrentIndex(max(0, self.directions.findData(look.directions)))
        self.behind.setCurrentIndex(self.behind.findData(look.behind))
        self.lamps.show_lamps(look.lamps)
        self.near.show_lamps(look.near_lamps)

    def handles(self, project: Project) -> tuple[Handle, ...]:
        """The light handles that can be dragged in the image."""
        look = project.look
        one = project.environment is None and not look.only_lamps
        handles = [Handle(None, look.light_theta_deg, look.light_phi_deg)] if one else []
        for number, lamp in enumerate(look.lamps):
            phi_deg = (lamp.phi_deg + 180.0) % 360.0 - 180.0
            chosen = number == self.lamps.chosen
            handles.append(Handle(number, lamp.theta_deg, phi_deg, lamp.radius_deg, _ink(lamp.colour), chosen))
        for number, near in enumerate(look.near_lamps):
            chosen, place = number == self.near.chosen, (near.x, near.y, near.z)
            outline, front = _outline(near.lamp)
            handles.append(
                Handle(number, colour=_ink(near.colour), chosen=chosen, place=place, outline=outline, front=front)
            )
        return tuple(handles)

    def show_size(self, mesh: Mesh) -> None:
        """Let the sliders of near lamps reach as far as lamps near `mesh` stand."""
        if mesh is self._mesh:
            return
        self._mesh = mesh
        middle, size = _middle_and_size(mesh)
        for axis, centre in zip("xyz", middle, strict=True):
            self.near.form.reach(axis, (float(f"{centre - 2 * size:.3g}"), float(f"{centre + 2 * size:.3g}")))
        for name, longest in (("radius", 0.5), ("width", 2.0), ("height", 2.0)):
            self.near.form.reach(name, (0.0, float(f"{longest * size:.3g}")))
        power = _power_at(size)
        self.near.form.reach("power", (float(f"{0.01 * power:.3g}"), float(f"{10.0 * power:.3g}")))

    def add_lamp(self) -> None:
        """One more lamp, in another direction than those that are there."""
        lamps = self.look.lamps
        phi_deg = (NEW_LAMP.phi_deg + 100.0 * len(lamps) + 180.0) % 360.0 - 180.0
        self.lamps.chosen = len(lamps)
        new = dataclasses.replace(NEW_LAMP, phi_deg=phi_deg)
        self._set("Add an extra light", lamps=(*lamps, new))
        scroll_to(self.lamps)

    def remove_lamp(self) -> None:
        """Remove the chosen lamp."""
        self._set("Remove an extra light", lamps=self.lamps.without_chosen(self.look.lamps))

    def add_near_lamp(self) -> None:
        """One more lamp near the model, above it and to another side than those that are there."""
        if self._mesh is None:
            return
        lamps = self.look.near_lamps
        middle, size = _middle_and_size(self._mesh)
        azimuth = radians(-70.0 + 100.0 * len(lamps))
        place = middle + NEAR * size * np.asarray(world_direction(radians(NEAR_THETA_DEG), azimuth))
        theta, phi = world_angles(middle - place)
        x, y, z, radius, side, power = (
            float(f"{value:.3g}") for value in (*place, 0.05 * size, 0.3 * size, _power_at(size))
        )
        new = NearLampSettings(
            x=x,
            y=y,
            z=z,
            radius=radius,
            width=side,
            height=side,
            power=power,
            facing_theta_deg=round(degrees(theta), 1),
            facing_phi_deg=round(degrees(phi), 1),
        )
        self.near.chosen = len(lamps)
        self._set("Add a near light", near_lamps=(*lamps, new))
        scroll_to(self.near)

    def remove_near_lamp(self) -> None:
        """Remove the chosen near lamp."""
        self._set("Remove a near light", near_lamps=self.near.without_chosen(self.look.near_lamps))

    def move_lamp(self, number: int, theta_deg: float, phi_deg: float, final: bool) -> None:
        """Point lamp `number` elsewhere, as a drag in the image does."""
        if number < len(self.look.lamps):
            self.lamps.chosen = number
            moved = dataclasses.replace(self.look.lamps[number], theta_deg=theta_deg, phi_deg=phi_deg)
            self._lamp_edited(moved, final)

    def move_near_lamp(self, number: int, place: tuple[float, float, float], final: bool) -> None:
        """Put near lamp `number` elsewhere, as a drag in the image does."""
        if number < len(self.look.near_lamps):
            self.near.chosen = number
            x, y, z = place
            self._near_lamp_edited(dataclasses.replace(self.look.near_lamps[number], x=x, y=y, z=z), final)

    def _lamp_edited(self, lamp: LampSettings, final: bool) -> None:
        lamps = self.lamps.with_chosen(self.look.lamps, lamp)
        self.edited.emit(dataclasses.replace(self.look, lamps=lamps), final)

    def _near_lamp_edited(self, lamp: NearLampSettings, final: bool) -> None:
        lamps = self.near.with_chosen(self.look.near_lamps, lamp)
        self.edited.emit(dataclasses.replace(self.look, near_lamps=lamps), final)

    def _set(self, words: str, **parts: Any) -> None:
        self.set_look.emit(words, dataclasses.replace(self.look, **parts))

    def _directions_chosen(self, _index: int) -> None:
        self.set_look.emit("Directions", dataclasses.replace(self.look, directions=self.directions.currentData()))

    def _behind_chosen(self, _index: int) -> None:
        self.set_look.emit("Behind the model", dataclasses.replace(self.look, behind=self.behind.currentData()))

    def _lighting_chosen(self, _index: int) -> None:
        chosen, document = self.lighting.currentData(), self.bench.document
        if chosen == OPEN:
            self.show_project(document.project)
            path, _ = QFileDialog.getOpenFileName(
                self, "Open an environment", "", dialog_filter("Environments", radiance_suffixes())
            )
            if path:
                self.bench.load_environment(path)
        elif chosen in (ONE_LIGHT, ONLY_LAMPS):
            look: Any = dataclasses.replace(self.look, only_lamps=chosen == ONLY_LAMPS)
            if document.project.environment is not None or look != self.look:
                document.change(
                    "One light" if chosen == ONE_LIGHT else "Extra lights only", environment=None, look=look
                )
        elif chosen in SKIES:
            self.bench.load_environment(chosen)
        elif document.project.environment is not self.own_environment:
            document.change(f"Light from {chosen}", environment=self.own_environment)


class LampRows(Rows):
    """Lamps of one kind: a list to choose one from, buttons that add and remove, and the settings of the chosen one.

    `name` is that of one lamp, `about` explains the list, `adds` what the button adds.
    """

    def __init__(self, label: str, name: str, about: str, adds: str, settings: Any) -> None:
        super().__init__()
        self.name = name
        self.chosen = 0
        self._lamps: tuple[Any, ...] = ()
        self.list = ComboBox()
        self.list.activated.connect(self._choose)
        self.add = small_button("add", f"Add {adds}")
        self.remove = small_button("remove", f"Remove this {name.lower()}")
        self.row(label, with_buttons(self.list, self.add, self.remove), about)
        self.list.setAccessibleName(name)
        self.list.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon)
        self.list.setMinimumContentsLength(4)
        labels = {each.name: ANGLES.get(each.name, each.label) for each in parameters(settings)}
        self.form = ParamForm(settings, labels)
        self.wide(self.form)

    def apply_theme(self) -> None:
        """Draw the icons in the colour of the current theme."""
        self.add.setIcon(theme.icon("add"))
        self.remove.setIcon(theme.icon("remove"))

    def show_lamps(self, lamps: Sequence[Any]) -> None:
        """Show how many there are, and the settings of the chosen one."""
        self._lamps, count = tuple(lamps), len(lamps)
        self.chosen = min(self.chosen, max(0, count - 1))
        self.list.clear()
        for number in range(count):
            self.list.addItem(f"{self.name} {number + 1}", number)
        if not count:
            self.list.addItem("None")
        self.list.setCurrentIndex(self.chosen)
        nothing = "" if count else f"There are no {self.name.lower()}s yet"
        enable(self.list, nothing)
        enable(self.remove, nothing)
        enable(self.add, "" if count < MAX_LAMPS else f"There are {MAX_LAMPS} {self.name.lower()}s already")
        self.form.setVisible(count > 0)
        if count:
            self._show_chosen()

    def _choose(self, place: int) -> None:
        self.chosen = place
        self._show_chosen()

    def _show_chosen(self) -> None:
        """Show the settings of the chosen lamp, and of these the ones that its shape has."""
        lamp = self._lamps[self.chosen]
        self.form.show_instance(lamp)
        if isinstance(lamp, NearLampSettings):
            for name in set().union(*PARAMETERS.values()):
                self.form.show_row(self.form.editors[name], name in PARAMETERS[lamp.shape])

    def with_chosen(self, lamps: Sequence[Any], lamp: Any) -> tuple[Any, ...]:
        """`lamps` with `lamp` in the place of the chosen one."""
        return tuple(lamp if number == self.chosen else each for number, each in enumerate(lamps))

    def without_chosen(self, lamps: Sequence[Any]) -> tuple[Any, ...]:
        """`lamps` without the chosen one."""
        return tuple(each for number, each in enumerate(lamps) if number != self.chosen)


def _middle_and_size(mesh: Mesh) -> tuple[Vectors, float]:
    """The middle of the box about a model, and half its diagonal."""
    low, high = mesh.positions.min(axis=0).astype(float), mesh.positions.max(axis=0).astype(float)
    return 0.5 * (low + high), max(0.5 * float(np.linalg.norm(high - low)), 1e-6)


def _outline(lamp: NearLamp) -> tuple[tuple[Triple, ...], Triple | None]:
    """The corners of a rectangle, or points on the edge of a disc, and a place before it; nothing of a sphere."""
    if lamp.shape == "sphere":
        return (), None
    angle = 2.0 * pi * (np.arange(32) + 0.5) / 32
    square = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])
    edge = square if lamp.shape == "rectangle" else np.column_stack([np.cos(angle), np.sin(angle)])
    corners = np.asarray(lamp.position) + edge @ lamp.half_sides
    x, y, z = (np.asarray(lamp.position) + 0.5 * lamp.extent * np.asarray(lamp.facing)).tolist()
    return tuple((float(a), float(b), float(c)) for a, b, c in corners), (x, y, z)


def _power_at(size: float) -> float:
    """The power of a lamp that brings the irradiance 1 to the middle of a model from a new lamp's distance."""
    return 4.0 * pi * (NEAR * size) ** 2


def _ink(colour: Colour) -> tuple[int, int, int]:
    """The colour of a lamp's handle; that of the sun where the lamp is white or black."""
    largest = max(colour)
    if largest <= 0.0 or min(colour) == largest:
        return SUN
    red, green, blue = (channel / largest for channel in colour)
    shown = display_colour((red, green, blue))
    return shown.red(), shown.green(), shown.blue()
