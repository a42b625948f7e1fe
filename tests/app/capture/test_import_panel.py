"""Rows of the import panel as they are clicked: what they ask for, and the settings of an import that follow."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import QPointF, Qt

from app.capture.framing import FramingView
from app.capture.import_panel import ImportPanel
from app.document.document import ImportChoices
from app.document.import_choices import settings_of
from app.widgets.image_view import pixels_image
from engine.capture.import_plan import CALIBRATED
from engine.capture.lights.list_forms import check_form
from engine.capture.object_outline import ObjectOutline
from engine.capture.photograph.grey_patch import GreyPatch
from engine.capture.scale import CameraDistance, ChartPitch, KnownLength

PATCH = (4, 5, 20, 10)


@pytest.fixture
def panel(qtbot: Any) -> ImportPanel:
    """The panel on screen, which follows what it asks for."""
    made = ImportPanel()
    qtbot.addWidget(made)

    def follow(_words: str, parts: dict[str, Any]) -> None:
        made.show_choices(dataclasses.replace(made.choices, **parts), None, made.provenance)
        made.disable("", measured=made.choices.sphere)

    made.chosen.connect(follow)
    made.show_choices(ImportChoices(), None)
    made.disable("", measured=False)
    made.fold.head.setChecked(True)
    made.show()
    qtbot.waitExposed(made)
    return made


def pick(panel: ImportPanel, qtbot: Any, value: str) -> None:
    """Choose an intensity by keys, as a user does."""
    box = panel.boxes["equalise"]
    box.setFocus()
    while box.currentData() != value:
        before = box.currentIndex()
        qtbot.keyClick(box, Qt.Key.Key_Down if before < box.findData(value) else Qt.Key.Key_Up)
        assert box.currentIndex() != before


def test_lamps_are_equalised_by_the_object(panel: ImportPanel, qtbot: Any) -> None:
    assert settings_of(panel.choices).equalise is None
    pick(panel, qtbot, "object")
    assert panel.choices.equalise == "object"
    assert settings_of(panel.choices).equalise == "object"
    pick(panel, qtbot, "")
    assert settings_of(panel.choices).equalise is None


def test_lamps_are_equalised_by_the_grey_patch_which_is_asked_for(panel: ImportPanel, qtbot: Any) -> None:
    with qtbot.waitSignal(panel.patch_wanted):
        pick(panel, qtbot, "patch")
    assert settings_of(panel.choices).equalise is None
    panel.show_choices(dataclasses.replace(panel.choices, patch=PATCH), None)
    assert settings_of(panel.choices).equalise == GreyPatch(*PATCH)
    box = panel.boxes["white_balance"]
    box.setFocus()
    qtbot.keyClick(box, Qt.Key.Key_Home)
    assert panel.choices.patch is None
    assert panel.choices.equalise == ""


def test_a_second_sphere_needs_a_first(panel: ImportPanel, qtbot: Any) -> None:
    assert not panel.spheres.isEnabled()
    assert "not measured on a sphere" in panel.spheres.buttons["two"].toolTip()
    qtbot.mouseClick(panel.sphere.buttons["sphere"], Qt.MouseButton.LeftButton)
    qtbot.mouseClick(panel.spheres.buttons["two"], Qt.MouseButton.LeftButton)
    assert settings_of(panel.choices).second_sphere == "auto"
    qtbot.mouseClick(panel.sphere.buttons["stated"], Qt.MouseButton.LeftButton)
    assert settings_of(panel.choices).second_sphere is None


def test_each_estimate_can_be_left_out(panel: ImportPanel, qtbot: Any) -> None:
    assert set(panel.estimates) == set(CALIBRATED)
    assert settings_of(panel.choices).calibrate == CALIBRATED
    for name in ("ambient", "motion"):
        qtbot.keyClick(panel.estimates[name], Qt.Key.Key_Space)
    assert settings_of(panel.choices).calibrate == ("distance", "gains", "lights")
    qtbot.keyClick(panel.estimates["motion"], Qt.Key.Key_Space)
    assert settings_of(panel.choices).calibrate == ("distance", "gains", "motion", "lights")


def test_every_form_of_the_list_can_be_taken(panel: ImportPanel) -> None:
    for place in range(panel.form.count()):
        check_form(panel.form.itemData(place))


def test_lamps_on_one_side_tell_nothing(panel: ImportPanel) -> None:
    panel.disable("", measured=False, one_sided=True)
    assert not panel.form.isEnabled()
    assert not any(box.isEnabled() for box in panel.estimates.values())
    assert panel.estimates["gains"].toolTip() == "Needs lamps on several sides"


def test_what_was_estimated_is_said_beside_its_switch(panel: ImportPanel) -> None:
    found = [
        {"name": "distance", "accepted": True, "text": "The lamps are 1.9 image widths away"},
        {"name": "ambient", "accepted": False, "text": "No room light is seen"},
    ]
    panel.show_choices(panel.choices, None, {"calibration": found})
    assert panel.estimates["distance"].text() == "Used"
    assert "1.9 image widths" in panel.estimates["distance"].toolTip()
    assert panel.estimates["ambient"].text() == "Unknown"
    assert panel.estimates["gains"].text() == ""


def test_a_list_that_fits_better_is_offered_and_taken(panel: ImportPanel, qtbot: Any) -> None:
    panel.show_choices(panel.choices, None, {"suggested_lights_form": "shifted+3"})
    assert panel.estimates["lights"].text() == "Does not fit"
    place = panel.form.findData("shifted+3")
    assert panel.form.itemText(place) == "shifted+3 (fits better)"
    qtbot.mouseClick(panel.take, Qt.MouseButton.LeftButton)
    assert settings_of(panel.choices).lights_form == "shifted+3"
    assert not panel.take.isVisible()
    panel.form.setFocus()
    for _ in range(place):
        qtbot.keyClick(panel.form, Qt.Key.Key_Up)
    assert settings_of(panel.choices).lights_form == "listed"
    assert panel.take.isVisible()


def test_a_colour_chart_is_chosen_and_its_figures_are_said(panel: ImportPanel, qtbot: Any, tmp_path: Path) -> None:
    assert settings_of(panel.choices).chart is None
    box = panel.boxes["chart"]
    box.setFocus()
    qtbot.keyClick(box, Qt.Key.Key_Down)
    assert settings_of(panel.choices).chart == "auto"
    panel.show_choices(dataclasses.replace(panel.choices, chart=tmp_path / "lamps.chart"), None)
    assert box.currentText() == "lamps.chart"
    assert settings_of(panel.choices).chart == tmp_path / "lamps.chart"
    assert not panel.chart.isVisible()
    figures = {name: {"mean": mean, "largest": 4 * mean} for name, mean in (("before", 9.5), ("after", 0.5))}
    panel.show_choices(panel.choices, None, {"chart": {"summary": figures}})
    assert panel.chart.text() == "ΔE2000 9.5 → 0.5, largest 2"
    figures["after"] = {}
    for wrong in (3, {"summary": 3}, {"summary": figures}):
        panel.show_choices(panel.choices, None, {"chart": wrong})
        assert not panel.chart.isVisible()


@pytest.mark.parametrize("found", [3, [3, None, ["name"]], [{"name": []}], {"name": 1}])
def test_a_record_that_is_none_is_shown_as_nothing(panel: ImportPanel, found: Any) -> None:
    panel.show_choices(panel.choices, None, {"calibration": found, "suggested_lights_form": found})
    assert panel.estimates["gains"].text() == ""


@pytest.fixture
def view(qtbot: Any) -> FramingView:
    """A photograph of 40 x 30 pixels, black."""
    view = FramingView()
    qtbot.addWidget(view)
    view.resize(400, 300)
    view.show()
    qtbot.waitExposed(view)
    view.show_image(pixels_image(np.zeros((30, 40, 3), np.uint8)))
    return view


def test_the_object_is_drawn_around_in_one_step(panel: ImportPanel, view: FramingView, qtbot: Any) -> None:
    """A drag around it is an outline without the points on its straight parts; a click draws nothing."""
    panel.outline_wanted.connect(lambda: view.draw_outline(True))
    view.outline_drawn.connect(panel.take_outline)
    box, asked = panel.boxes["mask"], []
    panel.chosen.connect(lambda words, _parts: asked.append(words))

    def choose(value: str) -> None:
        box.setCurrentIndex(box.findData(value))
        box.activated.emit(box.currentIndex())

    def drag(*points: tuple[float, float]) -> None:
        first, *rest = (view.to_screen(QPointF(x + 0.5, y + 0.5)).toPoint() for x, y in points)
        qtbot.mousePress(view, Qt.MouseButton.LeftButton, pos=first)
        for point in rest:
            qtbot.mouseMove(view, point)
        qtbot.mouseRelease(view, Qt.MouseButton.LeftButton, pos=(rest or [first])[-1])

    choose("draw")
    assert (box.currentData(), view.drawing_outline) == ("none", True)
    drag((5.0, 5.0))
    assert (asked, view.drawing_outline) == ([], False)
    choose("draw")
    drag((5, 5), (10, 5), (20, 5), (30, 5), (30, 15), (30, 25), (18, 25), (5, 25), (5, 15))
    assert (box.currentText(), asked) == ("Drawn outline", ["Object mask"])
    mask = settings_of(panel.choices).mask
    assert isinstance(mask, ObjectOutline)
    assert len(mask.points) == 4
    np.testing.assert_allclose(sorted(mask.points), [(5, 5), (5, 25), (30, 5), (30, 25)], atol=0.3)
    choose("alpha")
    assert settings_of(panel.choices).mask == "alpha"
    assert box.findData("outline") < 0


def test_a_scale_is_stated_marked_or_estimated(panel: ImportPanel, view: FramingView, qtbot: Any) -> None:
    """A line is drawn on the photograph, its length typed; other ways to the scale take its place."""
    panel.length_wanted.connect(lambda: view.draw_length(True))
    view.length_drawn.connect(panel.take_length)

    def choose(how: str) -> None:
        panel.scale.setCurrentIndex(panel.scale.findData(how))
        panel.scale.activated.emit(panel.scale.currentIndex())

    choose("length")
    assert (panel.scale.currentData(), view.drawing_length) == ("unknown", True)
    first, last = (view.to_screen(QPointF(*point)).toPoint() for point in ((5.5, 10.5), (25.5, 10.5)))
    qtbot.mousePress(view, Qt.MouseButton.LeftButton, pos=first)
    qtbot.mouseMove(view, last)
    qtbot.mouseRelease(view, Qt.MouseButton.LeftButton, pos=last)
    assert (panel.scale.currentData(), view.drawing_length) == ("length", False)
    panel.millimetres.edited.emit(8.0, True)
    scale = settings_of(panel.choices).scale
    assert isinstance(scale, KnownLength)
    assert (scale.length_px, scale.length_mm) == (pytest.approx(20.0, abs=0.3), 8.0)
    panel.millimetres.edited.emit(9e4, True)
    assert panel.scale_text.text() == "a pixel of 4500 mm is not within 1e-05 to 100 mm"
    assert settings_of(panel.choices).scale == scale
    choose("distance")
    assert settings_of(panel.choices).scale == CameraDistance(600.0)
    choose("camera")
    assert settings_of(panel.choices).scale == CameraDistance()
    assert not panel.millimetres.isEnabled()
    choose("pixel")
    assert settings_of(panel.choices).scale == 0.1
    choose("chart")
    assert (settings_of(panel.choices).scale, panel.choices.chart) == (ChartPitch(40.0), "auto")
