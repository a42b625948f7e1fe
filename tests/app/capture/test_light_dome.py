"""The lamps of a dome as dots: where they lie, how they are picked, and what is left of the capture then."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QFileDialog

from app.capture.light_dome import DOT, DomeImage, Lamp, LightDome, dot_colour, lamps_of
from app.widgets import theme
from app.window.main_window import MainWindow
from engine.capture.lights.light_file import read_lights
from tests.app.captures import open_path
from tests.present import present

LEFT, CONTROL = Qt.MouseButton.LeftButton, Qt.KeyboardModifier.ControlModifier


@pytest.fixture
def dome(window: MainWindow, qtbot: Any, photographs: Path) -> MainWindow:
    """The capture with its lamps on several sides."""
    made = open_path(window, qtbot, photographs)
    document = made.bench.document
    stack = present(document.project.stack)
    azimuth = np.radians(np.linspace(0.0, 270.0, len(stack.sources)))
    document.change("Turn the lamps", stack=dataclasses.replace(stack, azimuth=azimuth))
    qtbot.wait(50)
    return made


def lasso(window: MainWindow, corners: list[QPointF]) -> None:
    image = window.capture.dome.image
    points = [corner.toPoint() for corner in corners]
    QTest.mousePress(image, LEFT, pos=points[0])
    for point in points[1:]:
        QTest.mouseMove(image, point)
    QTest.mouseRelease(image, LEFT, pos=points[-1])


def test_the_lights_are_saved_as_the_ending_says(
    dome: MainWindow, qtbot: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    stack = present(dome.bench.document.project.stack)
    for name, kind in (("dome.lights", ""), ("dome", "Directions alone (*.lp)"), ("nowhere/dome.lights", "")):
        monkeypatch.setattr(
            QFileDialog, "getSaveFileName", lambda *_, name=name, kind=kind: (str(tmp_path / name), kind)
        )
        QTest.mouseClick(dome.capture.dome.save, LEFT)
        qtbot.waitUntil(lambda: not any(job.lane == "save" for job in dome.bench.jobs.active), timeout=10_000)
    assert [light.name for light in read_lights(tmp_path / "dome.lights").lights] == sorted(stack.sources)
    assert (tmp_path / "dome.lp").read_text().startswith(f"{len(stack.sources)}\n")
    assert not (tmp_path / "nowhere").exists()


def test_lamps_lie_as_seen_from_above() -> None:
    assert Lamp("zenith", 90.0, 77.0, None, False).place == pytest.approx((0.0, 0.0), abs=1e-12)
    assert Lamp("right", 0.0, 0.0, None, False).place == pytest.approx((1.0, 0.0))
    assert Lamp("top", 60.0, 90.0, None, False).place == pytest.approx((0.0, 0.5))


def test_a_range_of_azimuths_goes_round_the_circle() -> None:
    lamp = Lamp("a", 30.0, 355.0, None, False)
    assert lamp.is_within(2.0, 8.0, (0.0, 90.0))
    assert not lamp.is_within(2.0, 6.0, (0.0, 90.0))
    assert not lamp.is_within(2.0, 8.0, (40.0, 90.0))


def test_colours_tell_how_well_a_photograph_is_predicted() -> None:
    first, last = (theme.LINES[place].lstrip("#") for place in (0, 4))
    assert bytes(dot_colour(0.0)).hex() == first
    assert bytes(dot_colour(1.0)).hex() == last


def test_one_arc_has_no_dome(window: MainWindow, qtbot: Any, photographs: Path) -> None:
    made = open_path(window, qtbot, photographs)
    stack = present(made.bench.document.project.stack)
    assert lamps_of(stack, frozenset()) == ()
    assert lamps_of(dataclasses.replace(stack, azimuth=np.zeros(len(stack.sources))), frozenset()) == ()
    assert made.capture.dome.isHidden()


def test_a_click_shows_a_photograph_and_with_control_picks_another(dome: MainWindow) -> None:
    tab = dome.capture
    image = tab.dome.image
    for place, keys, selected in ((1, Qt.KeyboardModifier.NoModifier, {1}), (3, CONTROL, {1, 3}), (1, CONTROL, {3})):
        QTest.mouseClick(image, LEFT, keys, image.position(place).toPoint())
        assert image.selection == selected
    QTest.mouseClick(image, LEFT, Qt.KeyboardModifier.NoModifier, image.position(0).toPoint() + QPoint(int(DOT), 0))
    assert tab.current == present(dome.bench.document.project.stack).sources[0]


def test_lamps_within_a_line_can_alone_be_used_in_one_step(dome: MainWindow) -> None:
    tab, document = dome.capture, dome.bench.document
    image, names = tab.dome.image, present(document.project.stack).sources
    first, second = image.position(0), image.position(1)
    edge = QPointF(14.0, 14.0)
    low = QPointF(min(first.x(), second.x()), min(first.y(), second.y())) - edge
    high = QPointF(max(first.x(), second.x()), max(first.y(), second.y())) + edge
    lasso(dome, [low, QPointF(high.x(), low.y()), high, QPointF(low.x(), high.y()), low + QPointF(0, 5)])
    inside = {
        place
        for place in range(len(names))
        if low.x() < image.position(place).x() < high.x() and low.y() < image.position(place).y() < high.y()
    }
    assert image.selection == inside >= {0, 1}
    steps = document.undo_stack.count()
    tab.dome.only.click()
    assert document.project.excluded == {name for place, name in enumerate(names) if place not in inside}
    assert document.undo_stack.count() == steps + 1
    assert not tab.dome.only.isEnabled()
    tab.dome.every.click()
    assert not document.project.excluded


def test_an_arc_is_picked_by_its_azimuth_and_left_out_with_a_key(dome: MainWindow, qtbot: Any) -> None:
    tab, document = dome.capture, dome.bench.document
    names = present(document.project.stack).sources
    azimuths = [lamp.azimuth_deg for lamp in tab.dome.image.lamps]
    tab.dome.azimuth.setFocus()
    tab.dome.azimuth.selectAll()
    qtbot.keyClicks(tab.dome.azimuth, f"{azimuths[2]:.0f}")
    qtbot.keyClick(tab.dome.azimuth, Qt.Key.Key_Return)
    wanted = [place for place, azimuth in enumerate(azimuths) if abs(azimuth - azimuths[2]) <= 10.0]
    assert tab.list.selection == wanted
    tab.exclude.trigger()
    assert document.project.excluded == {names[place] for place in wanted}


def test_the_selection_of_another_capture_is_that_of_its_list(dome: MainWindow, qtbot: Any) -> None:
    tab, document = dome.capture, dome.bench.document
    stack = present(document.project.stack)
    document.change("Leave", stack=None, sources=None)
    document.change("Come", stack=dataclasses.replace(stack, sources=tuple(f"new {name}" for name in stack.sources)))
    qtbot.wait(50)
    assert tab.list.selection
    assert tab.dome.image.selection == frozenset(tab.list.selection)
    assert tab.dome.count.text() == f"1 of {len(stack.sources)} selected"


def test_without_lamps_nothing_can_be_done(qtbot: Any) -> None:
    empty = LightDome()
    qtbot.addWidget(empty)
    empty.show_lamps((), None)
    assert not empty.only.isEnabled()
    assert not empty.every.isEnabled()


def test_lamps_are_chosen_and_selected_by_keys(qtbot: Any) -> None:
    image = DomeImage()
    chosen: list[int] = []
    picked: list[list[int]] = []
    qtbot.addWidget(image)
    image.chosen.connect(chosen.append)
    image.picked.connect(picked.append)
    image.lamps = tuple(Lamp(f"{number}.png", 45.0, 90.0 * number, None, False) for number in range(3))
    image.current = 2
    for key in (Qt.Key.Key_Right, Qt.Key.Key_Left, Qt.Key.Key_Space):
        QTest.keyClick(image, key)
    assert (chosen, picked) == ([0, 1], [[2]])
