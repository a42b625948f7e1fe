"""Choices of an import: alignment, colours, calibration frames, the lamp, and the framing."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
from PySide6.QtCore import Signal
from PySide6.QtWidgets import QCheckBox, QComboBox, QFileDialog

from app.document.document import ImportChoices
from app.widgets.controls import ComboBox
from app.widgets.import_controls import FORMS, FRAMES, IMPORT_CHOICES, LIGHT_LIST, LISTS, WITHOUT_FILE
from app.widgets.number_field import NumberField
from app.widgets.panels import Fold, Rows, Segments, button, enable, keep_hint, text
from engine.capture.calibration.separation import MIN_GAIN, gain_text
from engine.capture.object_outline import ObjectOutline
from engine.capture.scale import KnownLength, size_text
from engine.core.errors import UsageError
from engine.core.figure_text import number

if TYPE_CHECKING:
    from engine.capture.registration.framing import Framing

#: What is estimated from the photographs themselves, with its label and what that means.
ESTIMATES = {
    "distance": ("Near lamps", "How far away the lamps are, whose light falls off over the sample"),
    "gains": ("Intensities", "How much the lamps differ in intensity"),
    "ambient": ("Room light", "Light that is there whichever lamp is on"),
    "motion": ("Camera", "Small shifts of the camera between photographs of lights all around"),
    "lights": ("List check", "Whether the list of lights belongs to the photographs"),
}

CALIBRATION = (
    *(
        "second_sphere",
        "equalise",
        "dark",
        "flat",
        "chart",
        "lens",
        "mask",
        "outline_px",
        "pair_gain",
        "scale_mm",
        "chart_pitch_mm",
        "known_length",
        "scale_by_camera",
        "lamp_distance",
        "sphere",
        "without_estimates",
        "lights_form",
    ),
)
POINTS_HINT = "In the reference and in a photograph that is not aligned correctly"
PAIR_HINT = "Brightness of a matte white patch in the crossed photographs over that in the parallel ones"

#: Ways to a scale: its label, and the length that it needs with the first value and the range of that, or None.
SCALES: dict[str, tuple[str, str | None, float, tuple[float, float]]] = {
    "unknown": ("Unknown", None, 0.1, (1e-4, 100.0)),
    "pixel": ("Per pixel", "Size of a pixel of the photographs", 0.1, (1e-4, 100.0)),
    "length": ("Between two points", "Distance of the two points: drag from the one to the other", 10.0, (1e-3, 1e5)),
    "chart": ("By the colour chart", "From the middle of one patch of the chart to that of the next", 40.0, (0.1, 1e3)),
    "camera": ("Estimate by the camera", None, 0.1, (1e-4, 100.0)),
    "distance": (
        "Estimate by distance",
        "From the sample to the sensor of the camera, as measured",
        600.0,
        (10.0, 1e5),
    ),
}
SPHERE_HINT = "Its outline, and the lamp's reflection in each photograph"
FRAMINGS = (("all", "All that they share"), ("crop", "Crop"), ("corners", "Four corners"))


class ImportPanel(Rows):
    """Rows of the Capture panel. `chosen(words, parts)` asks for a change of these parts of `ImportChoices`.

    `framing_wanted(how, width)` asks for 'all', 'crop' or 'corners', `patch_wanted` to draw the grey patch,
    `length_wanted` to mark a known length, `outline_wanted` to draw around the object, `tool_wanted` for 'points' or
    'sphere' to be set by hand.
    """

    chosen = Signal(str, object)
    framing_wanted = Signal(str, object)
    patch_wanted = Signal()
    tool_wanted = Signal(str)
    length_wanted = Signal()
    outline_wanted = Signal()

    def __init__(self) -> None:
        super().__init__()
        self.choices = ImportChoices()
        self.imported_size: tuple[int, int] | None = None
        self.provenance: Mapping[str, Any] = {}
        self.suggested_form = ""
        self.boxes: dict[str, QComboBox] = {}
        for name, (label, choices, hint) in IMPORT_CHOICES.items():
            box = self._box(name, label, hint, self)
            for value, words in choices:
                box.addItem(words, value)
        self.points = button("Mark points…", hint=POINTS_HINT)
        self.points.clicked.connect(lambda: self.tool_wanted.emit("points"))
        self.row("Points", self.points)
        self.lost = text("", "warning", wrap=True)
        self.wide(self.lost)
        self.fold = Fold("Calibration")
        self.wide(self.fold)
        calibration = self.fold.rows
        for name, (label, hint) in FRAMES.items():
            self._box(name, label, hint, calibration)
        self.chart = text("", "secondary", wrap=True)
        calibration.wide(self.chart)
        self.scale = ComboBox()
        for how, (label, *_) in SCALES.items():
            self.scale.addItem(label, how)
        self.scale.activated.connect(lambda _: self._scale_chosen(self.scale.currentData()))
        calibration.row("Scale", self.scale, "Size of the sample, for heights and exports in millimetres")
        self.millimetres = NumberField(0.1, 1e-4, 100.0, unit="mm", log=True)
        self.millimetres.edited.connect(self._millimetres_edited)
        calibration.row("Length", self.millimetres)
        self.mark_length = button("Mark the length…", hint="Drag from one end of a known length to the other")
        self.mark_length.clicked.connect(lambda: self.length_wanted.emit())
        calibration.row("Ends", self.mark_length)
        self.scale_text = text("", "secondary", wrap=True)
        calibration.wide(self.scale_text)
        self.pair = Segments(
            (
                ("estimated", "Estimated", "From the pairs themselves"),
                ("stated", "Stated", "As measured on a matte white patch"),
            )
        )
        self.pair.chosen.connect(self._pair_chosen)
        calibration.row(
            "Polarisers", self.pair, "How the crossed photographs of the pairs compare with the parallel ones"
        )
        self.pair_gain = NumberField(0.5, MIN_GAIN, 1.0 / MIN_GAIN, log=True)
        self.pair_gain.edited.connect(self._pair_gain_edited)
        calibration.row("Gain", self.pair_gain, PAIR_HINT)
        self.pair_text = text("", "secondary", wrap=True)
        calibration.wide(self.pair_text)
        for name, (label, choices, hint) in LISTS.items():
            box = self._box(name, label, hint, calibration)
            for value, words in choices:
                box.addItem(words, value)
        self.sphere = Segments(
            (
                ("stated", "As stated", "From capture.toml, an .lp file, the file names, or entered"),
                ("sphere", "Sphere", "Measured on a mirror sphere that is seen in the image"),
            )
        )
        self.sphere.chosen.connect(self._lights_chosen)
        calibration.row("Lights", self.sphere)
        self.spheres = Segments(
            (
                ("one", "One", "Gives the direction of each lamp"),
                ("two", "Two", "Give the positions of near lamps; the second is found in the image"),
            )
        )
        self.spheres.chosen.connect(lambda value: self.chosen.emit("Mirror spheres", {"second_sphere": value == "two"}))
        calibration.row("Spheres", self.spheres)
        self.correct = button("Correct by hand…")
        self.correct.clicked.connect(lambda: self.tool_wanted.emit("sphere"))
        calibration.row("Sphere", self.correct)
        self.lamp = Segments(
            (
                ("stated", "As stated", "Distant, unless capture.toml says how near"),
                ("near", "Near", "The fall-off of its light over the sample is corrected"),
            )
        )
        self.lamp.chosen.connect(self._lamp_chosen)
        calibration.row("Lamp", self.lamp)
        self.distance = NumberField(1.5, 0.51, 1000.0, unit="widths", log=True)
        self.distance.edited.connect(self._lamp_at)
        calibration.row("Distance", self.distance)
        calibration.wide(text("Estimated from the photographs", "secondary"))
        self.estimates: dict[str, QCheckBox] = {}
        for name, (label, hint) in ESTIMATES.items():
            self.estimates[name] = QCheckBox()
            self.estimates[name].clicked.connect(self._estimates_chosen)
            calibration.row(label, self.estimates[name], hint)
        self.form = ComboBox()
        self.form.activated.connect(self._form_chosen)
        calibration.row(LIGHT_LIST, self.form, "The order and the axes in which the list of lights is taken")
        self.take = button("", hint="The photographs fit the list clearly better in this form")
        self.take.clicked.connect(lambda: self.chosen.emit("Light list", {"lights_form": self.suggested_form}))
        self.take.hide()
        calibration.wide(self.take)
        self.framing = ComboBox()
        for value, words in FRAMINGS:
            self.framing.addItem(words, value)
        self.framing.activated.connect(lambda _index: self.framing_wanted.emit(self.framing.currentData(), None))
        self.row("Framing", self.framing)
        self.width_field = NumberField(1024.0, 1.0, 32768.0, unit="px", log=True)
        self.width_field.edited.connect(self._width_edited)
        self.row("Width", self.width_field)
        self.size_figure = self.figure("Size", "Of the image that is made")

    def _box(self, name: str, label: str, hint: str, rows: Rows) -> QComboBox:
        box = ComboBox()
        box.activated.connect(lambda _index: self._box_chosen(name))
        rows.row(label, box, hint)
        self.boxes[name] = box
        return box

    def show_choices(
        self,
        choices: ImportChoices,
        size: tuple[int, int] | None,
        provenance: Mapping[str, Any] = MappingProxyType({}),
        has_pairs: bool = False,
    ) -> None:
        """Show `choices` without emitting, and what the import of this `provenance` estimated.

        `size` is that of the imported image, None where there is none. `has_pairs` is True for photographs in pairs
        under polarisers.
        """
        self.choices, self.imported_size, self.provenance = choices, size, provenance
        plain = ImportChoices()
        if any(getattr(choices, name) != getattr(plain, name) for name in CALIBRATION):
            self.fold.head.setChecked(True)
        for name in FRAMES:
            self._fill_frame(name)
        for name, box in self.boxes.items():
            if name not in FRAMES:
                box.setCurrentIndex(max(0, box.findData(getattr(choices, name))))
        if choices.patch is not None:
            box = self.boxes["white_balance"]
            box.setCurrentIndex(box.findData("patch"))
        self.sphere.choose("sphere" if choices.sphere else "stated")
        self.spheres.choose("two" if choices.second_sphere else "one")
        self.lamp.choose("stated" if choices.lamp_distance is None else "near")
        if choices.lamp_distance is not None:
            self.distance.show_value(choices.lamp_distance)
        self._show_chart()
        self._show_pairs(has_pairs)
        how, value = self._scale_shown()
        self.scale.setCurrentIndex(self.scale.findData(how))
        self.millimetres.low, self.millimetres.high = SCALES[how][3]
        if value is not None:
            self.millimetres.show_value(value)
        else:
            self.millimetres.show_unknown()
        self.fold.rows.show_row(self.mark_length, how == "length")
        self._show_scale()
        self._show_estimates()
        framing = choices.framing
        how = "all" if framing is None else "crop" if is_upright(framing) else "corners"
        self.framing.setCurrentIndex(self.framing.findData(how))
        if framing is not None:
            size = (framing.width_px, framing.height_px)
        if size is not None:
            self.width_field.show_value(float(size[0]))
            self.size_figure.setText(f"{size[0]} × {size[1]} px")
        else:
            self.width_field.show_unknown()
            self.size_figure.setText("–")

    def _show_chart(self) -> None:
        """Say how far colours were from those of the chart before and after the last import."""
        words = ""
        with contextlib.suppress(KeyError, TypeError, ValueError):  # a record of a stack that is none
            before, after = (self.provenance["chart"]["summary"][name] for name in ("before", "after"))
            means = f"ΔE2000 {number(before['mean'])} → {number(after['mean'])}"
            words = f"{means}, largest {number(after['largest'])}"
        self.chart.setText(words)
        self.chart.setVisible(bool(words))

    def _show_pairs(self, has_pairs: bool) -> None:
        """Say what the last import found of the pairs under polarisers."""
        rows, stated = self.fold.rows, self.choices.pair_gain
        rows.show_row(self.pair, has_pairs)
        rows.show_row(self.pair_gain, has_pairs)
        self.pair.choose("estimated" if stated is None else "stated")
        label = ""
        with contextlib.suppress(KeyError, TypeError, ValueError):  # a record of a stack that is none
            label = gain_text(self.provenance["polarisation"])
            self.pair_gain.show_value(float(np.mean(self.provenance["polarisation"]["gain"])))
        if stated is not None:
            self.pair_gain.show_value(stated)
        self.pair_text.setText(label)
        self.pair_text.setVisible(bool(label) and has_pairs)

    def _scale_shown(self) -> tuple[str, float | None]:
        """The way to the scale that is chosen, and its length in millimetres."""
        choices = self.choices
        if choices.scale_by_camera:
            return ("camera", None) if choices.camera_distance_mm is None else ("distance", choices.camera_distance_mm)
        if choices.known_length is not None:
            return "length", choices.known_length[4]
        if choices.chart_pitch_mm is not None:
            return "chart", choices.chart_pitch_mm
        return ("unknown", None) if choices.scale_mm is None else ("pixel", choices.scale_mm)

    def _show_scale(self) -> None:
        """Say what the last import found the size of a texel to be."""
        label = ""
        with contextlib.suppress(KeyError, TypeError, ValueError):  # a record of a stack that is none
            label = size_text(self.provenance["scale"])
        self.scale_text.setText(label)
        self.scale_text.setVisible(bool(label))

    def _show_estimates(self) -> None:
        """Say what the last import found in the photographs, and which list of lights fits."""
        listed, suggested = (self.provenance.get(name) for name in ("calibration", "suggested_lights_form"))
        self.suggested_form = suggested if isinstance(suggested, str) else ""
        terms = [term for term in listed if isinstance(term, dict)] if isinstance(listed, list) else []
        found = {str(term.get("name")): term for term in terms}
        for name, box in self.estimates.items():
            term = found.get(name, {})
            outcome = "" if not term else "Used" if term.get("accepted") else "Unknown"
            box.setText("Does not fit" if name == "lights" and self.suggested_form else outcome)
            box.setChecked(name not in self.choices.without_estimates)
            keep_hint(box, f"{ESTIMATES[name][1]}\n{term.get('text', '')}".strip())
        self._fill_forms()
        if self.suggested_form:
            self.fold.head.setChecked(True)

    def show_points(self, counts: Mapping[str, int], lost: Sequence[str]) -> None:
        """Say how many points are marked in how many photographs, and which photographs were not aligned."""
        count = sum(counts.values())
        self.points.setText(f"{count} point{'s' * (count > 1)}…" if count else "Mark points…")
        marked = "\n".join(f"{name}: {number}" for name, number in counts.items())
        enable(self.points, "", f"{POINTS_HINT}\n{marked}".strip())
        waiting = [name for name in lost if name not in counts]
        self.lost.setVisible(bool(waiting))
        more = f" and {len(waiting) - 2} more" if len(waiting) > 2 else ""
        pronoun = "it" if len(waiting) == 1 else "them"
        self.lost.setText(
            f"{', '.join(waiting[:2])}{more} could not be aligned. Points marked by hand place {pronoun}."
        )

    def disable(self, why_not: str, *, measured: bool, one_sided: bool = False) -> None:
        """Disable everything and say why, or, for an empty `why_not`, what has nothing to act on.

        `measured` is True if the lights are measured on a mirror sphere, `one_sided` if all lamps stood on one side.
        """
        enable(self.points, why_not)
        enable(self.correct, why_not or ("" if measured else "The lights are not measured on a sphere"), SPHERE_HINT)
        for name, box in self.boxes.items():
            enable(box, why_not, _words(name)[-1])
        enable(self.spheres, why_not or ("" if measured else "The lights are not measured on a sphere"))
        stated = "" if self.choices.pair_gain is not None else "The gain is estimated from the pairs"
        enable(self.pair_gain, why_not or stated, PAIR_HINT)
        hint = SCALES[self._scale_shown()[0]][1]
        enable(self.millimetres, why_not or ("" if hint else "This scale needs no length"), hint or "")
        enable(self.mark_length, why_not)
        for segments in (self.sphere, self.lamp, self.pair, self.scale):
            enable(segments, why_not)
        for widget in (self.form, *self.estimates.values()):
            enable(widget, why_not or ("Needs lamps on several sides" if one_sided else ""))
        enable(self.framing, why_not, "What becomes the image: drag the handles on the photograph")
        distant = "" if self.choices.lamp_distance is not None else "Only a near lamp has a distance"
        enable(self.distance, why_not or distant, "From the middle of the sample to the lamp, in widths of the image")
        whole = "" if self.choices.framing is not None else "Only a framed image has a size of its own"
        enable(self.width_field, why_not or whole, "Of the image that is made; its height follows")

    def _fill_frame(self, name: str) -> None:
        box, value = self.boxes[name], getattr(self.choices, name)
        box.clear()
        for words, choice in WITHOUT_FILE[name]:
            box.addItem(words, choice)
        if isinstance(value, Path):
            box.addItem(value.name, value)
        if name == "mask":
            box.addItem("Draw an outline…", "draw")
            if self.choices.outline_px:
                box.insertItem(0, "Drawn outline", "outline")
        box.addItem("Choose a file…", "choose")
        if name == "mask" and self.choices.outline_px:
            box.setCurrentIndex(0)
            return
        box.setCurrentIndex(len(WITHOUT_FILE[name]) if isinstance(value, Path) else box.findData(value))

    def _fill_forms(self) -> None:
        current, suggested = self.choices.lights_form, self.suggested_form
        self.form.clear()
        for form in dict.fromkeys((*FORMS, current, suggested or current)):
            label = FORMS.get(form, form)
            self.form.addItem(f"{label} (fits better)" if form == suggested else label, form)
        self.form.setCurrentIndex(self.form.findData(current))
        label = FORMS.get(suggested, suggested)
        self.take.setText(f"Take the list {label[:1].lower()}{label[1:]}")
        self.take.setVisible(suggested not in ("", current))

    def _box_chosen(self, name: str) -> None:
        value, label = self.boxes[name].currentData(), str(_words(name)[0])
        if value == "choose":
            path, _ = QFileDialog.getOpenFileName(self, label)
            value = Path(path) if path else getattr(self.choices, name)
        if name == "mask":
            if value == "draw":
                self.outline_wanted.emit()
            elif value != "outline":
                self.chosen.emit(label, {"mask": value, "outline_px": ()})
        elif value == "patch" and name == "white_balance":
            self.patch_wanted.emit()
        elif name == "white_balance":
            by_patch = {"equalise": ""} if self.choices.equalise == "patch" else {}
            self.chosen.emit("White balance", {"white_balance": value, "patch": None, **by_patch})
        elif value == "patch" and self.choices.patch is None:
            self.chosen.emit(label, {name: value})
            self.patch_wanted.emit()
        else:
            self.chosen.emit(label, {name: value})
        self.show_choices(self.choices, self.imported_size, self.provenance)

    def _lights_chosen(self, how: str) -> None:
        alone = {} if how == "sphere" else {"second_sphere": False}
        self.chosen.emit("Lights", {"sphere": how == "sphere", **alone})

    def _scale_chosen(self, how: str) -> None:
        if how == "length" and self.choices.known_length is None:
            self.scale.setCurrentIndex(self.scale.findData(self._scale_shown()[0]))
            self.length_wanted.emit()
            return
        self._emit_scale(how, SCALES[how][2])

    def _millimetres_edited(self, value: float, final: bool) -> None:
        if final:
            how, known = self._scale_shown()[0], self.choices.known_length
            if how == "length" and known is not None:
                try:
                    KnownLength(known[:2], known[2:4], value)
                except UsageError as error:
                    self.show_choices(self.choices, self.imported_size, self.provenance)
                    self.scale_text.setText(f"{error}")
                    self.scale_text.show()
                    return
            self._emit_scale(how, value)

    def _emit_scale(self, how: str, value: float) -> None:
        parts: dict[str, Any] = {
            "scale_mm": value if how == "pixel" else None,
            "chart_pitch_mm": value if how == "chart" else None,
            "known_length": None,
            "scale_by_camera": how in ("camera", "distance"),
            "camera_distance_mm": value if how == "distance" else None,
        }
        if how == "length" and self.choices.known_length is not None:
            parts["known_length"] = (*self.choices.known_length[:4], value)
        if how == "chart" and self.choices.chart == "none":
            parts["chart"] = "auto"
        self.chosen.emit("Scale", parts)

    def take_length(self, ends: tuple[float, float, float, float]) -> None:
        """Ask for the scale by a length between two points (x, y, x, y), of as many millimetres as before."""
        known = self.choices.known_length
        length_mm = SCALES["length"][2] if known is None else known[4]
        alone = {"scale_mm": None, "chart_pitch_mm": None, "scale_by_camera": False, "camera_distance_mm": None}
        self.chosen.emit("Known length", {**alone, "known_length": (*ends, length_mm)})

    def take_outline(self, outline: ObjectOutline) -> None:
        """Ask for the object inside an outline that was drawn."""
        self.chosen.emit("Object mask", {"mask": "none", "outline_px": outline.points})

    def _pair_chosen(self, how: str) -> None:
        self.chosen.emit("Gain of pairs", {"pair_gain": self.pair_gain.value if how == "stated" else None})

    def _pair_gain_edited(self, gain: float, final: bool) -> None:
        if final:
            self.chosen.emit("Gain of pairs", {"pair_gain": gain})

    def _lamp_chosen(self, how: str) -> None:
        self.chosen.emit("Lamp", {"lamp_distance": self.distance.value if how == "near" else None})

    def _lamp_at(self, distance: float, final: bool) -> None:
        if final:
            self.chosen.emit("Distance of the lamp", {"lamp_distance": distance})

    def _estimates_chosen(self) -> None:
        left_out = tuple(name for name, box in self.estimates.items() if not box.isChecked())
        self.chosen.emit("Estimates", {"without_estimates": left_out})

    def _form_chosen(self) -> None:
        self.chosen.emit("Light list", {"lights_form": self.form.currentData()})

    def _width_edited(self, width: float, final: bool) -> None:
        if final:
            self.framing_wanted.emit(self.framing.currentData(), max(1, round(width)))


def _words(name: str) -> tuple[Any, ...]:
    """Label and hint of a list, the hint last."""
    return IMPORT_CHOICES.get(name) or LISTS.get(name) or FRAMES[name]


def is_upright(framing: Framing | None) -> bool:
    """True if the corners form a rectangle along the edges of the photograph."""
    if framing is None:
        return False
    (x0, y0), (x1, y1), (x2, y2), (x3, y3) = framing.corners
    return (x0, y0, x1, y2) == (x3, y1, x2, y3)
