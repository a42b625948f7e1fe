"""Controls of an import in Capture: their labels and the names of their values, which messages name as well.

The engine names options of the command line in its messages ("import again with --transfer linear"). In the window
`name_controls` puts the control in their place that does the same; options without one stay as they are.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import cache

from app.widgets.language import translate

IMPORT_CHOICES = {
    "motion": (
        "Alignment",
        (
            ("auto", "Automatic"),
            ("none", "Off"),
            ("translation", "Shift"),
            ("euclidean", "Shift and turn"),
            ("affine", "Affine"),
            ("homography", "Perspective"),
        ),
        "Allowed motion between photographs",
    ),
    "white_balance": (
        "White bal.",
        (("camera", "As shot"), ("none", "None"), ("patch", "Grey patch…")),
        "White balance of RAW files; a grey patch balances all files",
    ),
    "transfer": (
        "Encoding",
        (("auto", "Automatic"), ("srgb", "sRGB"), ("linear", "Linear")),
        "Transfer function of 8- and 16-bit files; automatic: that of their colour profile, without one sRGB unless "
        "capture.toml says linear",
    ),
    "working_space": (
        "Maps in",
        (("rec709", "Rec.709"), ("auto", "Rec.2020 if needed"), ("rec2020", "Rec.2020"), ("acescg", "ACEScg")),
        "Colour space in which maps of the surface are made: colours beyond it do not fit between 0 and 1. Images are "
        "shown in that of the screen",
    ),
}

FRAMES = {
    "lens": ("Lens", "A .lens file that an import has written, by which the distortion of the lens is taken off"),
    "mask": ("Object mask", "What of the photographs is the object; the background counts in no map and no figure"),
    "dark": ("Dark frame", "A photograph without light, which is subtracted"),
    "flat": ("Flat field", "A photograph of an even white surface, which is divided out"),
    "chart": (
        "Colour chart",
        "A classic chart of 24 patches, by which colours are corrected: in a photograph of the capture, in a file of "
        "its own under the same lamps, or a .chart file that was saved",
    ),
}

#: Choices of a frame that no file is chosen for.
WITHOUT_FILE = {
    "lens": (("As it is", "none"),),
    "mask": (("None", "none"), ("Alpha channel", "alpha")),
    "dark": (("As found", "auto"), ("None", "none")),
    "flat": (("As found", "auto"), ("None", "none")),
    "chart": (("None", "none"), ("In a photograph", "auto")),
}

#: Rows of the calibration that are lists.
LISTS = {
    "equalise": (
        "Intensity",
        (("", "Lamps as they are"), ("object", "Equal, by the object"), ("patch", "Equal, by grey patch")),
        "Lamps of a dome differ in intensity, which is divided out: by the smooth change of the object over the lamps, "
        "or by a white or grey patch, the one of the white balance",
    ),
}

FORMS = {
    "listed": "As it is",
    "mirrored-x": "Left and right exchanged",
    "mirrored-y": "Top and bottom exchanged",
    "swapped-xy": "x and y exchanged",
    "turned": "Turned by 180°",
    "reversed": "In reverse order",
    "shifted+1": "Moved on by one",
    "shifted-1": "Moved back by one",
}

#: The label of the forms of a list of lights.
LIGHT_LIST = "Light list"

#: Options whose control has another name or declares its values elsewhere: its label, and the names of its values, the
#: one of no value first where that has a name.
_OTHERS: dict[str, tuple[str, Mapping[str, str]]] = {
    "lights-form": (LIGHT_LIST, FORMS),
    "no-align": ("Alignment", {"": "Off"}),
    "no-flat": ("Flat field", {"": "None"}),
    "sphere": ("Lights", {"": "Sphere", "auto": "Sphere"}),
    "second-sphere": ("Spheres", {"": "Two"}),
    "lamp-distance": ("Lamp", {"": "Near"}),
    "pair-gain": ("Polarisers", {"": "Stated"}),
    "scale": ("Scale", {"exif": "Estimate by the camera", "exif=MM": "Estimate by distance"}),
}

#: An option that stands by itself, and not in the name of a file.
_OPTION = re.compile(r"(?<![^\s(])--([a-z]{2}[a-z-]{1,30}+)(?![\w/])(?: ([A-Za-z0-9+=,-]{1,40}+))?")


def name_controls(text: str) -> str:
    """`text` in the language of the window, with controls of Capture in place of options of `lightarc import`."""
    return _OPTION.sub(_name_control, translate(text))


def _name_control(found: re.Match[str]) -> str:
    option, word = found[1], found[2] or ""
    value = word.rstrip(",")
    if option not in _controls():
        return found[0]
    label, values = _controls()[option]
    is_known = value in values or value.upper() == value  # COLUMN,ROW stands for a value
    chosen = values.get(value) or values.get("")
    control = f"“{translate(label)}: {translate(chosen)}”" if chosen else f"“{translate(label)}”"
    return control + word[len(value) :] if is_known else f"{control} {word}"


@cache
def _controls() -> dict[str, tuple[str, Mapping[str, str]]]:
    listed = {**IMPORT_CHOICES, **LISTS}
    found = {
        name.replace("_", "-"): (label, {value: words for value, words in choices if value})
        for name, (label, choices, _) in listed.items()
    }
    return {**found, **{name: (label, {}) for name, (label, _) in FRAMES.items()}, **_OTHERS}
