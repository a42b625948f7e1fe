"""The mirror sphere corrected by hand in the Capture workspace, up to the import that measures lights on it."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import QPointF, Qt
from PySide6.QtTest import QTest

from app.capture.sphere_tool import SphereTool
from app.document.import_choices import choose
from app.window.main_window import MainWindow
from engine.simulate.arc import sphere
from tests.app.captures import capture as capture_tab
from tests.app.captures import choices, click, drag, import_again, open_path
from tests.present import present

SIZE = 256


@pytest.fixture(scope="module")
def capture(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Any, dict[str, Any]]:
    """A capture with a sphere of which nothing is stated, the lamp at 30°, 50° and 70° in the azimuth of 115°."""
    folder = tmp_path_factory.mktemp("sphere") / "With a ball"
    arc, truth = capture_tab(folder, sphere=True, size=SIZE, azimuth=(2.0,))
    (folder / "capture.toml").unlink()
    return folder, arc, truth


@pytest.fixture
def measuring(window: MainWindow, qtbot: Any, capture: tuple[Path, Any, dict[str, Any]]) -> MainWindow:
    """The window with the lights to be measured on the sphere, and its tool open."""
    open_path(window, qtbot, capture[0], motion="none")
    panel = window.capture.options
    assert not panel.correct.isEnabled()
    assert "not measured" in panel.correct.toolTip()
    panel.fold.head.setChecked(True)
    qtbot.mouseClick(panel.sphere.buttons["sphere"], Qt.MouseButton.LeftButton)
    qtbot.mouseClick(panel.correct, Qt.MouseButton.LeftButton)
    settle(window, qtbot)
    return window


def settle(window: MainWindow, qtbot: Any) -> None:
    tool = window.capture.sphere
    qtbot.waitUntil(
        lambda: tool.looked is not None and tool.view.image is not None and not window.bench.jobs.active,
        timeout=60_000,
    )


def lights(tool: SphereTool) -> dict[str, tuple[float, float]]:
    """Elevation and azimuth in degrees by name, as the table shows them."""
    rows = [
        [present(tool.table.item(row, column)).text() for column in range(5)] for row in range(tool.table.rowCount())
    ]
    numbers = lambda text: float(text.removesuffix("°").replace("−", "-"))  # noqa: E731
    return {row[0]: (numbers(row[2]), numbers(row[3])) for row in rows if row[2] != "–"}


def direction(elevation_deg: float, azimuth_deg: float) -> np.ndarray:
    elevation, azimuth = math.radians(elevation_deg), math.radians(azimuth_deg)
    across = math.cos(elevation)
    return np.array([across * math.cos(azimuth), across * math.sin(azimuth), math.sin(elevation)])


def off_deg(shown: tuple[float, float], truth: Any) -> float:
    return math.degrees(math.acos(min(1.0, float(direction(*shown) @ np.asarray(truth)))))


def test_an_outline_dragged_onto_the_sphere_shows_the_lights_at_once_and_is_imported(
    measuring: MainWindow, qtbot: Any, capture: tuple[Path, Any, dict[str, Any]]
) -> None:
    """The circle is put beside the sphere and dragged back: one step each, lights within 3° as a pixel allows."""
    _, arc, truth = capture
    tool, document, ball = measuring.capture.sphere, measuring.bench.document, sphere(arc)
    choose(document, "Beside it", outline=(ball.column + 40, ball.row - 30, 0.5 * ball.radius))
    settle(measuring, qtbot)
    tool.view.fit()
    view, steps = tool.view, document.undo_stack.count()
    start = QPointF(view.middle().x() - 4, view.middle().y() + 6)
    drag(view, start, start + QPointF(-40, 30) * view.zoom)
    assert present(choices(measuring).outline)[:2] == pytest.approx((ball.column, ball.row), abs=1.0 / view.zoom + 0.1)
    drag(view, view.rim(), view.middle() + QPointF(ball.radius * view.zoom, 0))
    assert document.undo_stack.count() == steps + 2
    assert choices(measuring).outline == pytest.approx((ball.column, ball.row, ball.radius), abs=1.0)
    settle(measuring, qtbot)
    shown = lights(tool)
    assert len(shown) == len(truth)
    assert max(off_deg(shown[name], truth[name]["sphere_light"]) for name in truth) < 5.0
    tool.fields["Column"].edited.emit(ball.column, True)
    tool.fields["Row"].edited.emit(ball.row, True)
    tool.fields["Radius"].edited.emit(ball.radius, True)
    settle(measuring, qtbot)
    shown = lights(tool)
    assert max(off_deg(shown[name], truth[name]["sphere_light"]) for name in truth) < 1.0
    stack = import_again(measuring, qtbot)
    assert stack.angle_source == "mirror sphere"
    assert measuring.capture.panel.angles.text() == "mirror sphere"
    assert stack.provenance["sphere_px"] == [ball.column, ball.row, ball.radius]
    for name, elevation, azimuth in zip(stack.sources, stack.elevation_deg, np.degrees(stack.azimuth), strict=True):
        assert (elevation, azimuth) == pytest.approx(shown[name], abs=0.06)


def test_a_reflection_moved_by_hand_turns_the_light_as_the_mirror_law_says(
    measuring: MainWindow, qtbot: Any, capture: tuple[Path, Any, dict[str, Any]]
) -> None:
    """At 0.4 of the radius to the right the normal leans by asin 0.4, and the lamp by twice that towards 0°."""
    arc, tool, document = capture[1], measuring.capture.sphere, measuring.bench.document
    ball = sphere(arc)
    choose(document, "Outline", outline=(ball.column, ball.row, ball.radius))
    settle(measuring, qtbot)
    name, view = str(tool.name), tool.view
    view.look_near(present(choices(measuring).outline))
    others = {one: light for one, light in lights(tool).items() if one != name}
    steps = document.undo_stack.count()
    drag(view, view.spot(), view.middle() + QPointF(0.4 * ball.radius * view.zoom, 0))
    assert document.undo_stack.count() == steps + 1
    expected = 90 - 2 * math.degrees(math.asin(0.4))
    assert lights(tool)[name] == pytest.approx((expected, 0.0), abs=2.0)
    assert {one: light for one, light in lights(tool).items() if one != name} == others
    QTest.keyPress(view, Qt.Key.Key_Up)
    QTest.keyRelease(view, Qt.Key.Key_Up)
    assert document.undo_stack.count() == steps + 2
    choose(document, "Exactly", highlights={name: (ball.column + 0.4 * ball.radius, ball.row)})
    stack = import_again(measuring, qtbot)
    assert stack.elevation_deg[stack.sources.index(name)] == pytest.approx(expected, abs=1e-6)
    tool.again.click()
    settle(measuring, qtbot)
    assert (choices(measuring).highlights, choices(measuring).outline) == ({}, None)
    measuring.undo.trigger()
    assert name in choices(measuring).highlights


def test_a_click_sets_a_reflection_that_was_not_found_and_none_is_below_the_sample(
    measuring: MainWindow, qtbot: Any, capture: tuple[Path, Any, dict[str, Any]]
) -> None:
    """The lamp stood up and left, so nothing shines in the lower part of the dark middle of the sphere."""
    tool, document, ball = measuring.capture.sphere, measuring.bench.document, sphere(capture[1])
    outline = (ball.column + 0.1 * ball.radius, ball.row + 0.35 * ball.radius, 0.2 * ball.radius)
    choose(document, "In the dark", outline=outline, highlights={})
    settle(measuring, qtbot)
    tool.view.look_near(outline)
    lost = [name for name in tool._names() if name not in lights(tool)]
    assert lost
    assert "click the lamp's reflection" in tool.status.text()
    measuring.capture._show_source(lost[0])
    settle(measuring, qtbot)
    click(tool.view, tool.view.middle() + QPointF(3, -8))
    elevation, _ = lights(tool)[lost[0]]
    assert elevation > 60
    drag(tool.view, tool.view.spot(), tool.view.middle() + QPointF(0.9 * outline[2] * tool.view.zoom, 0))
    assert lost[0] not in lights(tool), "a lamp below the sample is none"


def test_photographs_are_changed_and_undone_while_the_sphere_is_held(measuring: MainWindow, qtbot: Any) -> None:
    tool, tab = measuring.capture.sphere, measuring.capture
    names = [row.name for row in tab.list.photographs.rows]
    view = tool.view
    QTest.mousePress(view, Qt.MouseButton.LeftButton, pos=view.middle().toPoint())
    QTest.mouseMove(view, (view.middle() + QPointF(30, 10)).toPoint())
    tab.list.choose((names.index(str(tool.name)) + 1) % len(names))
    QTest.mouseMove(view, (QPointF(60, 60)).toPoint())
    QTest.mouseRelease(view, Qt.MouseButton.LeftButton, pos=QPointF(60, 60).toPoint())
    for _ in range(30):
        measuring.undo.trigger()
    for _ in range(30):
        measuring.redo.trigger()
    qtbot.waitUntil(lambda: not measuring.bench.jobs.active, timeout=60_000)
    assert not tool.isVisible(), "undoing the opening of the photographs leaves the tool"
    tab.open_tool("sphere")
    for row in (0, 2):
        tool.table.setCurrentCell(row, 0)
        assert tab.current == tool.name == names[row]


def test_without_a_sphere_a_circle_waits_to_be_dragged(window: MainWindow, qtbot: Any, photographs: Path) -> None:
    open_path(window, qtbot, photographs)
    choose(window.bench.document, "Lights", sphere=True)
    window.capture.open_tool("sphere")
    settle(window, qtbot)
    tool = window.capture.sphere
    assert "No sphere was found" in tool.status.text()
    assert not tool.view.sure
    assert choices(window).outline is None
    drag(tool.view, tool.view.middle(), tool.view.middle() + QPointF(10, 10))
    assert choices(window).outline is not None
    assert tool.view.sure
