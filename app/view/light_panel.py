"""The lights of the View workspace: one light or an environment, and lamps beside it, each with its own settings."""

from __future__ import annotations

import dataclasses
from typing import Any

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QComboBox, QFileDialog, QHBoxLayout, QWidget

from app.commands.workbench import Workbench
from app.document.document import Behind, Look, Project
from app.viewport.overlay import SUN, Handle
from app.widgets import theme
from app.widgets.controls import ComboBox
from app.widgets.panels import Rows, enable, small_button
from app.widgets.param_form import ParamForm, display_colour
from app.widgets.theme import STEP
from engine.light.environment import EnvironmentMap
from engine.light.lamps import LampSettings
from engine.light.sky import SKIES
from engine.scene.scene import MOST_LAMPS

LIGHT_FIELDS = ("light_theta_deg", "light_phi_deg", "irradiance", "rotation_deg", "gain")
DIRECTIONS = (16, 32, 64, 128, 256, 512)

#: Words for what stands behind the model, and its blur in degrees.
BEHIND: dict[Behind, tuple[str, float]] = {
    "": ("Plain canvas", 0.0),
    "sharp": ("Environment", 0.0),
    "soft": ("Blurred a little", 4.0),
    "blurred": ("Blurred", 16.0),
}

#: Values of the menu that are no environment.
ONE_LIGHT, ONLY_LAMPS, OPEN = "", "only lamps", "open"

LAMP_LABELS = {
    "theta_deg": "Theta",
    "phi_deg": "Phi",
    "irradiance": "Irradiance",
    "radius_deg": "Radius",
    "colour": "Colour",
}

#: A new lamp: a soft key from the left, rotated further for each lamp that exists.
NEW_LAMP = LampSettings(theta_deg=50.0, phi_deg=-60.0, irradiance=1.0, radius_deg=5.0)


class LightPanel(Rows):
    """Shows and changes the lights of a project. `edited(look, final)` and `set_look(words, look)` ask for changes."""

    edited = Signal(object, bool)
    set_look = Signal(str, object)

    def __init__(self, bench: Workbench) -> None:
        super().__init__("Light")
        self.bench = bench
        self.own_environment: EnvironmentMap | None = None
        self.chosen_lamp = 0
        look = Look()
        self.lighting = ComboBox()
        self.lighting.activated.connect(self._lighting_chosen)
        self.row("From", self.lighting, "One light, or an environment; .hdr and .exr files can be dropped here")
        self.light = ParamForm(look, {"light_theta_deg": "Theta", "light_phi_deg": "Phi", "irradiance": "Irradiance"})
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
            "Error", "Error of these directions against the whole environment, on this picture"
        )
        for form in (self.light, self.surround):
            form.edited.connect(self.edited)
            self.wide(form)
        self._make_lamps()

    def apply_theme(self) -> None:
        """Draw the icons in the colour of the current theme."""
        self.add.setIcon(theme.icon("add"))
        self.remove.setIcon(theme.icon("remove"))

    def _make_lamps(self) -> None:
        self.lamps = ComboBox()
        self.lamps.activated.connect(self._lamp_chosen)
        self.add = small_button("add", "Add a lamp: directional, or a disc with soft shadows")
        self.add.clicked.connect(self.add_lamp)
        self.remove = small_button("remove", "Remove this lamp")
        self.remove.clicked.connect(self.remove_lamp)
        holder = QWidget()
        row = QHBoxLayout(holder)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(STEP)
        row.addWidget(self.lamps, 1)
        row.addWidget(self.add)
        row.addWidget(self.remove)
        self.row("Lamps", holder, "Lights beside the one above; drag their suns in the picture")
        self.lamps.setAccessibleName("Lamp")
        self.lamps.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon)
        self.lamps.setMinimumContentsLength(4)
        self.lamp = ParamForm(NEW_LAMP, LAMP_LABELS)
        self.lamp.edited.connect(self._lamp_edited)
        self.wide(self.lamp)

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
        self.lighting.addItem("Lamps only", ONLY_LAMPS)
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
        self._show_lamps(look)

    def _show_lamps(self, look: Look) -> None:
        count = len(look.lamps)
        self.chosen_lamp = min(self.chosen_lamp, max(0, count - 1))
        self.lamps.clear()
        for number in range(count):
            self.lamps.addItem(f"Lamp {number + 1}", number)
        if not count:
            self.lamps.addItem("None")
        self.lamps.setCurrentIndex(self.chosen_lamp)
        nothing = "" if count else "There are no lamps yet"
        enable(self.lamps, nothing)
        enable(self.remove, nothing)
        enable(self.add, "" if count < MOST_LAMPS else f"There are {MOST_LAMPS} lamps already")
        self.lamp.setVisible(count > 0)
        if count:
            self.lamp.show_instance(look.lamps[self.chosen_lamp])

    def handles(self, project: Project) -> tuple[Handle, ...]:
        """The light handles that can be dragged in the picture."""
        look = project.look
        one = project.environment is None and not look.only_lamps
        handles = [Handle(None, look.light_theta_deg, look.light_phi_deg)] if one else []
        for number, lamp in enumerate(look.lamps):
            phi_deg = (lamp.phi_deg + 180.0) % 360.0 - 180.0
            chosen = number == self.chosen_lamp
            handles.append(Handle(number, lamp.theta_deg, phi_deg, lamp.radius_deg, _ink(lamp), chosen))
        return tuple(handles)

    def add_lamp(self) -> None:
        """One more lamp, in another direction than those that are there."""
        lamps = self.look.lamps
        phi_deg = (NEW_LAMP.phi_deg + 100.0 * len(lamps) + 180.0) % 360.0 - 180.0
        self.chosen_lamp = len(lamps)
        self._set_lamps("Add a lamp", (*lamps, dataclasses.replace(NEW_LAMP, phi_deg=phi_deg)))

    def remove_lamp(self) -> None:
        """Remove the chosen lamp."""
        lamps = self.look.lamps
        self._set_lamps("Remove a lamp", lamps[: self.chosen_lamp] + lamps[self.chosen_lamp + 1 :])

    def move_lamp(self, number: int, theta_deg: float, phi_deg: float, final: bool) -> None:
        """Point lamp `number` elsewhere, as a drag in the picture does."""
        if number < len(self.look.lamps):
            self.chosen_lamp = number
            moved = dataclasses.replace(self.look.lamps[number], theta_deg=theta_deg, phi_deg=phi_deg)
            self._lamp_edited(moved, final)

    def _lamp_edited(self, lamp: LampSettings, final: bool) -> None:
        lamps = list(self.look.lamps)
        lamps[self.chosen_lamp] = lamp
        self.edited.emit(dataclasses.replace(self.look, lamps=tuple(lamps)), final)

    def _lamp_chosen(self, place: int) -> None:
        self.chosen_lamp = place
        self.lamp.show_instance(self.look.lamps[place])

    def _set_lamps(self, words: str, lamps: tuple[LampSettings, ...]) -> None:
        self.set_look.emit(words, dataclasses.replace(self.look, lamps=lamps))

    def _directions_chosen(self, _index: int) -> None:
        self.set_look.emit("Directions", dataclasses.replace(self.look, directions=self.directions.currentData()))

    def _behind_chosen(self, _index: int) -> None:
        self.set_look.emit("Behind the model", dataclasses.replace(self.look, behind=self.behind.currentData()))

    def _lighting_chosen(self, _index: int) -> None:
        chosen, document = self.lighting.currentData(), self.bench.document
        if chosen == OPEN:
            self.show_project(document.project)
            path, _ = QFileDialog.getOpenFileName(self, "Open an environment", "", "Environments (*.hdr *.exr)")
            if path:
                self.bench.load_environment(path)
        elif chosen in (ONE_LIGHT, ONLY_LAMPS):
            look: Any = dataclasses.replace(self.look, only_lamps=chosen == ONLY_LAMPS)
            if document.project.environment is not None or look != self.look:
                document.change("One light" if chosen == ONE_LIGHT else "Lamps only", environment=None, look=look)
        elif chosen in SKIES:
            self.bench.load_environment(chosen)
        elif document.project.environment is not self.own_environment:
            document.change(f"Light from {chosen}", environment=self.own_environment)


def _ink(lamp: LampSettings) -> tuple[int, int, int]:
    """The colour of a lamp's handle; that of the sun where the lamp is white or black."""
    largest = max(lamp.colour)
    if largest <= 0.0 or min(lamp.colour) == largest:
        return SUN
    red, green, blue = (channel / largest for channel in lamp.colour)
    colour = display_colour((red, green, blue))
    return colour.red(), colour.green(), colour.blue()
