"""Sliders and number fields made from declared parameters (`engine.core.params`), one row each.

A slider runs over the parameter's everyday range, logarithmically where it is declared so; the field beside it takes
every allowed value. Ctrl+click on either goes back to the default.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QColor, QIcon, QPixmap
from PySide6.QtWidgets import QColorDialog, QHBoxLayout, QPushButton, QWidget

from app.widgets import theme
from app.widgets.controls import TICKS, ComboBox, Slider
from app.widgets.number_field import NumberField
from app.widgets.panels import Rows
from app.widgets.theme import ROW, STEP
from engine.core.colour import srgb_decode, srgb_encode
from engine.core.params import Colour, Parameter, parameters

if TYPE_CHECKING:
    pass

#: Angles from straight up that are shown as elevations, and the hints of these.
ELEVATIONS = {
    "theta_deg": "Angle of the light above the horizon",
    "light_theta_deg": "Angle of the light above the horizon",
    "facing_theta_deg": "Elevation of the direction that the light faces; −90° is straight down",
}

#: Widths of a number field, as it is and where its panel is narrow.
FIELD_WIDTH, NARROW_FIELD = 72, 56


class ParamForm(Rows):
    """Edits one frozen dataclass of parameters. `edited(instance, final)`: `final` is False while dragging."""

    edited = Signal(object, bool)

    def __init__(self, instance: Any, labels: Mapping[str, str] | None = None) -> None:
        """`labels` names the parameters to show and their words; without it all are shown under their own names."""
        super().__init__()
        self.instance = instance
        self.editors: dict[str, Editor] = {}
        for parameter in parameters(instance):
            if labels is not None and parameter.name not in labels:
                continue
            if labels:
                parameter = dataclasses.replace(parameter, words=labels[parameter.name])
            editor = _editor(parameter)
            editor.edited.connect(lambda value, final, name=parameter.name: self._on_edited(name, value, final))
            self.editors[parameter.name] = editor
            hint = ELEVATIONS[parameter.name] if isinstance(editor, ElevationEditor) else parameter.doc
            self.row(labels[parameter.name] if labels else parameter.label, editor, hint)
        self.show_instance(instance)

    def follow(self, before: QWidget) -> None:
        """Come after `before` in the order of the Tab key, as on screen, although it may be made later."""
        for editor in self.editors.values():
            for stop in editor.stops:
                QWidget.setTabOrder(before, stop)
                before = stop

    def reach(self, name: str, slider: tuple[float, float]) -> None:
        """Let the slider of a number run over another range, as that of a length does for another model."""
        editor = self.editors[name]
        assert isinstance(editor, NumberEditor)
        editor.parameter = dataclasses.replace(editor.parameter, slider=slider)
        editor.show_value(editor.field.value)

    def show_instance(self, instance: Any) -> None:
        """Show the values of `instance` without emitting."""
        self.instance = instance
        for name, editor in self.editors.items():
            editor.show_value(getattr(instance, name))

    def _on_edited(self, name: str, value: str | float | Colour, final: bool) -> None:
        self.instance = dataclasses.replace(self.instance, **{name: value})
        self.edited.emit(self.instance, final)


class NumberEditor(QWidget):
    """Slider and field of one number."""

    edited = Signal(float, bool)

    def __init__(self, parameter: Parameter) -> None:
        super().__init__()
        self.parameter = parameter
        assert isinstance(parameter.default, int | float)
        self.slider = Slider()
        self.slider.setAccessibleName(parameter.label)
        self.field = NumberField(
            float(parameter.default), parameter.low, parameter.high, unit=parameter.unit, log=parameter.log
        )
        self.field.setAccessibleName(parameter.label)
        self.field.setMinimumWidth(NARROW_FIELD)
        self.field.setMaximumWidth(FIELD_WIDTH)
        layout = QHBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(2 * STEP)
        layout.addWidget(self.slider, 1)
        layout.addWidget(self.field)
        self.stops: tuple[QWidget, ...] = (self.slider, self.field)
        self.slider.valueChanged.connect(self._slid)
        self.slider.sliderReleased.connect(lambda: self.edited.emit(self.field.value, True))
        self.slider.reset.connect(lambda: self._set(self.field.default, True))
        self.field.edited.connect(self._set)

    def show_value(self, value: float) -> None:
        """Show `value` without emitting."""
        self.field.show_value(value)
        self.slider.blockSignals(True)
        self.slider.setValue(round(TICKS * self._place(value)))
        self.slider.blockSignals(False)

    def _slid(self, ticks: int) -> None:
        value = self._round(self._value(ticks / TICKS))
        self.field.show_value(value)
        self.edited.emit(value, not self.slider.isSliderDown())

    def _set(self, value: float, final: bool) -> None:
        value = self._round(value)
        self.show_value(value)
        self.edited.emit(value, final)

    def _round(self, value: float) -> float:
        return float(round(value)) if self.parameter.kind == "whole" else value

    def _place(self, value: float) -> float:
        low, high = self.parameter.slider
        value = min(max(value, low), high)
        if self.parameter.log and low > 0:
            return math.log(value / low) / math.log(high / low)
        return (value - low) / (high - low)

    def _value(self, place: float) -> float:
        low, high = self.parameter.slider
        value = low * (high / low) ** place if self.parameter.log and low > 0 else low + (high - low) * place
        return float(f"{value:.3g}")


class ElevationEditor(QWidget):
    """Slider and field of an angle from straight up (theta), shown as the elevation above the horizon, 90° − theta."""

    edited = Signal(float, bool)

    def __init__(self, parameter: Parameter) -> None:
        super().__init__()
        assert isinstance(parameter.default, int | float)
        low, high = parameter.slider
        as_shown = dataclasses.replace(
            parameter,
            default=complement_deg(parameter.default),
            low=complement_deg(parameter.high),
            high=complement_deg(parameter.low),
            slider=(complement_deg(high), complement_deg(low)),
        )
        self.shown = NumberEditor(as_shown)
        self.slider, self.field, self.stops = self.shown.slider, self.shown.field, self.shown.stops
        layout = QHBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(self.shown)
        self.shown.edited.connect(lambda elevation, final: self.edited.emit(complement_deg(elevation), final))

    def show_value(self, theta_deg: float) -> None:
        """Show the elevation of `theta_deg` without emitting."""
        self.shown.show_value(complement_deg(theta_deg))


def complement_deg(angle_deg: float) -> float:
    """90° − `angle_deg`: theta of an elevation, and the elevation of a theta; decimals of binary fractions are left."""
    return round(90.0 - angle_deg, 9)


def _editor(parameter: Parameter) -> Editor:
    if parameter.kind == "choice":
        return ChoiceEditor(parameter)
    if parameter.is_colour:
        return ColourEditor(parameter)
    is_of_light = parameter.name in ELEVATIONS  # limits, as max_theta_deg, are from the normal
    return ElevationEditor(parameter) if is_of_light else NumberEditor(parameter)


class ChoiceEditor(ComboBox):
    """A list of the values of a parameter that is one of several."""

    edited = Signal(str, bool)

    def __init__(self, parameter: Parameter) -> None:
        super().__init__()
        for value, label in parameter.offered:
            self.addItem(label, value)
        self.stops: tuple[QWidget, ...] = (self,)
        self.activated.connect(lambda _index: self.edited.emit(self.currentData(), True))

    def show_value(self, value: str) -> None:
        """Show `value` without emitting."""
        self.setCurrentIndex(self.findData(value))


class ColourEditor(QWidget):
    """Strength of a colour as slider and field (its largest channel), and a swatch that opens the colour dialog.

    Weights that are declared as colours may be negative; the largest is then the one furthest from 0.
    """

    edited = Signal(object, bool)

    def __init__(self, parameter: Parameter) -> None:
        super().__init__()
        assert isinstance(parameter.default, tuple)
        self.colour: Colour = parameter.default
        strength = dataclasses.replace(parameter, default=max(parameter.default, key=abs))
        self.strength = NumberEditor(strength)
        self.swatch = QPushButton()
        self.swatch.setFixedSize(ROW, ROW)
        theme.role(self.swatch, "swatch")
        self.swatch.setAccessibleName(f"{parameter.label}: colour")
        layout = QHBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(2 * STEP)
        layout.addWidget(self.swatch)
        layout.addWidget(self.strength, 1)
        self.stops: tuple[QWidget, ...] = (self.swatch, *self.strength.stops)
        self.strength.edited.connect(self._scaled)
        self.swatch.clicked.connect(self._ask)

    def show_value(self, value: Colour) -> None:
        """Show `value` without emitting."""
        self.colour = value
        self.strength.show_value(max(value, key=abs))
        self._paint()

    def _scaled(self, strength: float, final: bool) -> None:
        largest = max(self.colour, key=abs)
        red, green, blue = (channel / largest if largest else 1.0 for channel in self.colour)
        self.colour = (red * strength, green * strength, blue * strength)
        self._paint()
        self.edited.emit(self.colour, final)

    def _ask(self) -> None:
        dialog = QColorDialog(display_colour(self.colour), self)
        dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        dialog.colorSelected.connect(self._on_picked)
        dialog.open()

    def _on_picked(self, colour: QColor) -> None:
        red, green, blue = (float(channel) for channel in srgb_decode([colour.redF(), colour.greenF(), colour.blueF()]))
        self.show_value((red, green, blue))
        self.edited.emit(self.colour, True)

    def _paint(self) -> None:
        self.swatch.setIcon(swatch(display_colour(self.colour)))


def display_colour(linear: Colour) -> QColor:
    """The screen's colour of linear sRGB, clipped."""
    red, green, blue = (min(1.0, max(0.0, float(channel))) for channel in srgb_encode(list(linear)))
    return QColor.fromRgbF(red, green, blue)


def swatch(colour: QColor) -> QIcon:
    """A filled square as an icon."""
    square = QPixmap(16, 16)
    square.fill(colour)
    return QIcon(square)


Editor = NumberEditor | ElevationEditor | ColourEditor | ChoiceEditor
