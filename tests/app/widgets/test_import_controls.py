"""Messages of the engine name controls of the window in place of options of the command line."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
from PySide6.QtWidgets import QAbstractButton, QComboBox, QLabel

from app.capture.import_panel import ImportPanel
from app.widgets import language
from app.widgets.import_controls import FORMS, _controls, name_controls


@pytest.fixture
def german() -> Iterator[None]:
    language._load("de")
    yield
    language._load("en")


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("import again with --lights-form turned, or correct the list",
         "import again with “Light list: Turned by 180°”, or correct the list"),
        ("unless imported with --working-space rec2020", "unless imported with “Maps in: Rec.2020”"),
        ("Give another, or import with --no-flat", "Give another, or import with “Flat field: None”"),
        ("name that photograph with --chart", "name that photograph with “Colour chart”"),
        ("Give a white patch (--equalise LEFT,TOP,WIDTH,HEIGHT), or 9 lamps",
         "Give a white patch (“Intensity”), or 9 lamps"),
        ("Measure it and give it with --scale exif=MM", "Measure it and give it with “Scale: Estimate by distance”"),
        ("--scale exif takes this estimate", "“Scale: Estimate by the camera” takes this estimate"),
        ("by hand, or give --sphere COLUMN,ROW,RADIUS or [sphere]", "by hand, or give “Lights: Sphere” or [sphere]"),
        ("measure them (--sphere auto)", "measure them (“Lights: Sphere”)"),
        ("one for all with --white-balance", "one for all with “White bal.”"),
        ("Write it again with --write-lens", "Write it again with --write-lens"),
        ("rows -- and --", "rows -- and --"),
        ("/photographs/a--dark/--flat/--mask_2.png is damaged", "/photographs/a--dark/--flat/--mask_2.png is damaged"),
    ],
)  # fmt: skip
def test_controls_stand_in_place_of_options(text: str, expected: str) -> None:
    assert name_controls(text) == expected


def test_they_have_their_names_in_german(german: None) -> None:
    assert name_controls("import again with --lights-form turned").endswith("“Lichtliste: Um 180° gedreht”")


def test_every_control_that_is_named_is_there(qtbot: Any) -> None:
    panel = ImportPanel()
    qtbot.addWidget(panel)
    shown = {label.text() for label in panel.findChildren(QLabel)}
    shown |= {button.text() for button in panel.findChildren(QAbstractButton)}
    shown |= {box.itemText(at) for box in panel.findChildren(QComboBox) for at in range(box.count())}
    for label, values in _controls().values():
        assert {label, *values.values()} <= {*shown, *FORMS.values()}, label
