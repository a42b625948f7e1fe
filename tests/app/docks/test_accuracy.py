"""The Accuracy dock: measuring, the plot, a click that applies a setting, and budgets."""

from __future__ import annotations

import dataclasses
import time
from typing import Any

import pytest
from PySide6.QtCore import QPoint, Qt

from app.docks import accuracy
from app.document.bake_request import choices_for
from app.document.document import Look
from app.document.measured import (
    AXES,
    Accuracy,
    choices_with,
    describe,
    look_with,
    same_key,
    scene_key,
    setting_of,
    setting_text,
)
from app.document.variation import VariedParameter
from app.view.baking import Baking
from app.window.main_window import MainWindow
from engine.brdf.brdf import brdf_from_text
from engine.core.figure_text import time_text
from engine.core.steps import Step, Steps
from engine.geometry.camera import frame
from engine.light.environment_file import open_environment
from engine.planning.costs.setting import Setting
from engine.scene.scene import Scene
from engine.tradeoff.point import COSTS, Point
from tests.app.view.test_baking import LONG, ball, built_in, sphere
from tests.engine.scenes import weave

POINTS = (
    Point(Setting("direct", {"directions": 16}), 0.2, 0.2, 0.001, 0.004, 1e-5, 0.0, 100, 0),
    Point(Setting("direct", {"directions": 256}), 0.15, 0.15, 0.001, 0.05, 1e-5, 0.0, 4000, 0),
    Point(Setting("sh", {"order": 3}), 0.05, 0.05, 0.001, 0.006, 0.002, 4.0, 2_000_000, 2_000_000),
    Point(Setting("wavelet", {"terms": 2, "cube": 16}), 0.02, 0.02, 0.001, 0.008, 0.01, 9.0, 9_000_000, 9_000_000),
    Point(Setting("reference", {"samples": 4}), 0.1, 0.1, 0.001, 1.0, 0.0, 0.0, 10_000_000, 0),
)


@pytest.fixture
def view(window: MainWindow, qtbot: Any) -> MainWindow:
    """A ball under the studio in the View workspace."""
    document = window.bench.document
    material = dataclasses.replace(document.project.material, brdf="phong:exponent=5")
    document.change("Ball", mesh=ball(), environment=built_in("studio"), material=material)
    window.show_workspace("view")
    dock = window.docks.accuracy
    qtbot.waitUntil(lambda: window.view.scene(document.project) is not None and dock.isVisible(), timeout=LONG)
    qtbot.waitUntil(lambda: dock.plot.width() > 200, timeout=LONG)
    return window


def measure(window: MainWindow) -> Accuracy:
    scene = window.view.scene(window.bench.document.project)
    assert scene is not None
    found = Accuracy(POINTS, scene_key(scene, 0), (64, 48), 16, "test")
    window.bench.document.change("Measure accuracy", accuracy=found)
    return found


def click(window: MainWindow, qtbot: Any, setting: Setting) -> None:
    plot, places = window.docks.accuracy.plot, list[Any]()

    def stays() -> bool:
        places.append(plot.place_of(setting))
        return places[-1] is not None and places[-5:] == [places[-1]] * 5

    qtbot.waitUntil(stays, timeout=LONG)
    place = places[-1]
    qtbot.mouseMove(plot.viewport(), QPoint(2, 2))
    qtbot.mouseClick(plot.viewport(), Qt.MouseButton.LeftButton, pos=place.toPoint())


def test_all_axes_of_the_engine_are_there() -> None:
    assert set(AXES) == set(COSTS)


def test_points_are_shown_kept_and_undone(view: MainWindow) -> None:
    dock = view.docks.accuracy
    assert "Nothing measured yet" in dock.words.text()
    found = measure(view)
    assert dock.accuracy is found
    assert {point.setting for point in dock.plot.shown} == {point.setting for point in POINTS}
    dock.axis.setCurrentIndex(dock.axis.findData("bake"))
    dock.axis.activated.emit(0)
    assert {point.mode for point in dock.plot.shown} == {"sh", "wavelet"}
    assert "3 take none" in dock.words.text()
    view.bench.document.undo_stack.undo()
    assert dock.accuracy is None


def test_a_click_applies_mode_and_parameters(view: MainWindow, qtbot: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Baking, "_ask", lambda _self, _wanted: None)
    measure(view)
    click(view, qtbot, POINTS[1].setting)
    look = view.bench.document.project.look
    assert (look.mode, look.directions) == ("direct", 256)
    assert view.view.setting == POINTS[1].setting
    assert view.docks.accuracy.plot.current == POINTS[1].setting
    click(view, qtbot, POINTS[3].setting)
    assert view.bench.document.project.look.mode == "wavelet"
    assert (
        view.view.bakings["wavelet"].choices.value("terms"),
        view.view.bakings["wavelet"].choices.value("cube"),
    ) == (2, 16)
    view.docks.accuracy.budget.setText("3 %")
    assert "It is on screen" in view.docks.accuracy.words.text()


def test_arrow_keys_reach_points_and_enter_applies_one(view: MainWindow, qtbot: Any) -> None:
    measure(view)
    plot = view.docks.accuracy.plot
    with qtbot.waitSignal(plot.picked) as picked:
        for key in (Qt.Key.Key_Right, Qt.Key.Key_Right, Qt.Key.Key_Left, Qt.Key.Key_Return):
            qtbot.keyClick(plot, key)
    assert picked.args == [POINTS[0].setting]


@pytest.mark.parametrize(
    ("words", "setting"),
    [("10 ms and 5 MB", POINTS[2].setting), ("3 %", POINTS[3].setting), ("20 ms", POINTS[3].setting)],
)
def test_a_budget_names_the_best_setting(view: MainWindow, qtbot: Any, words: str, setting: Setting) -> None:
    measure(view)
    dock = view.docks.accuracy
    dock.applied.disconnect(view.view.apply_setting)
    dock.budget.setText(words)
    assert setting_text(setting) in dock.words.text()
    with qtbot.waitSignal(dock.applied) as applied:
        qtbot.keyClick(dock.budget, Qt.Key.Key_Return)
    assert applied.args == [setting]


def test_it_says_when_none_does_and_what_a_budget_is(view: MainWindow) -> None:
    measure(view)
    dock = view.docks.accuracy
    dock.budget.setText("0.1 %")
    assert "No measured setting keeps within it" in dock.words.text()
    dock.budget.setText("fast")
    assert "8 ms and 100 MB" in dock.words.text()
    dock._apply_choice()


def test_another_light_makes_points_stale(view: MainWindow) -> None:
    measure(view)
    dock = view.docks.accuracy
    assert not dock.is_stale
    view.bench.document.change("Light", environment=open_environment("sky"))
    assert dock.is_stale
    assert "another scene" in dock.words.text()
    assert "varies" not in dock.words.text()
    view.bench.document.change("Vary", variations=(VariedParameter("alpha", 0.2, 0.6),))
    assert "Spatial variation is not included." in dock.words.text()


def test_measuring_fills_the_plot(view: MainWindow, qtbot: Any) -> None:
    dock = view.docks.accuracy
    dock.modes.setCurrentIndex(dock.modes.findData("direct"))
    dock.time.addItem("a moment", 2)
    dock.time.setCurrentIndex(dock.time.findData(2))
    dock.go.click()
    assert dock.go.text() == "Stop measuring"
    qtbot.waitUntil(lambda: dock.job is None, timeout=LONG)
    assert dock.accuracy is view.bench.document.project.accuracy
    assert dock.accuracy is not None
    assert {point.mode for point in dock.accuracy.points} == {"direct"}


def waiting(*_about: Any) -> Steps[Any]:
    """A sweep that measures nothing until it is stopped."""
    while True:
        yield Step(0.0, "waiting")
        time.sleep(0.01)


def test_enter_in_the_budget_measures_first_and_then_applies(
    view: MainWindow, qtbot: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    dock, found = view.docks.accuracy, Accuracy(POINTS, (), (64, 48), 16, "test")
    monkeypatch.setattr(accuracy, "measured", waiting)
    dock.budget.setText("3 %")
    assert "Enter measures" in dock.words.text()
    qtbot.keyClick(dock.budget, Qt.Key.Key_Return)
    assert "applied then" in dock.words.text()
    assert dock.job is not None
    dock.job.cancelled.disconnect()  # which would come after the end
    scene = view.view.scene(view.bench.document.project)
    assert scene is not None
    dock.applied.disconnect(view.view.apply_setting)
    with qtbot.waitSignal(dock.applied) as applied:
        dock._keep(dataclasses.replace(found, of=scene_key(scene, 0)))
    assert applied.args == [POINTS[3].setting]
    assert dock.job is None


def test_a_sweep_that_is_stopped_applies_nothing(view: MainWindow, qtbot: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    dock = view.docks.accuracy
    monkeypatch.setattr(accuracy, "measured", waiting)
    dock.budget.setText("3 %")
    qtbot.keyClick(dock.budget, Qt.Key.Key_Return)
    assert dock.job is not None
    dock.go.click()
    qtbot.waitUntil(lambda: dock.job is None, timeout=LONG)
    assert not dock._is_to_apply


def test_docks_of_the_view_come_and_go_with_it(window: MainWindow, qtbot: Any) -> None:
    docks = (window.docks.accuracy, window.docks.effects)
    assert not any(dock.isVisible() for dock in docks)
    window.show_workspace("view")
    qtbot.waitUntil(lambda: all(dock.isVisible() for dock in docks), timeout=LONG)
    window.docks.accuracy.close()
    window.show_workspace("brdf")
    assert not any(dock.isVisible() for dock in docks)
    window.show_workspace("view")
    assert [dock.isVisible() for dock in docks] == [False, True]
    window._keep_settings()
    assert window.docks.of_view.closed == ("accuracy",)
    window.docks.of_view.actions[1].trigger()
    assert window.docks.accuracy.isVisible()


@pytest.mark.dressed
def test_docks_come_back_as_wide_as_they_were(view: MainWindow, qtbot: Any) -> None:
    docks = list(view.docks.of_view.docks)
    view.resizeDocks(docks, [480, 780], Qt.Orientation.Horizontal)
    qtbot.waitUntil(lambda: abs(docks[0].width() - 480) < 20, timeout=LONG)
    sizes = view.docks.sizes
    view.show_workspace("capture")
    assert view.docks.sizes == sizes
    view._keep_settings()
    assert view.settings.now.dock_sizes == sizes
    view.show_workspace("view")
    qtbot.waitUntil(lambda: [dock.width() for dock in docks] == [*sizes[::2]], timeout=LONG)


def test_settings_go_to_the_window_and_back() -> None:
    look, wanted = Look(), Setting("wavelet", {"terms": 2, "cube": 16})
    assert setting_of("wavelet", look, choices_with(wanted, choices_for("wavelet"))) == wanted
    for setting in (Setting("direct", {"directions": 16}), Setting("shading-map", {"directions": 4, "power_law": 1})):
        assert setting_of(setting.mode, dataclasses.replace(look, **look_with(setting, look)), None) == setting
    assert "20.0 ± 0.1 %" in describe(POINTS[0])
    assert "predicted" not in describe(POINTS[0])
    point = dataclasses.replace(POINTS[2], predicted={"frame_s": 0.0082, "bake_s": 4.1, "size_bytes": 2e6})
    assert "predicted: frame 8.2 ms, bake 4.1 s" in describe(point)


@pytest.mark.parametrize(
    ("seconds", "words"),
    [(0.0082, "8.2 ms"), (0.1309, "131 ms"), (0.9949, "995 ms"), (1.26, "1.3 s"), (250.0, "4.2 min")],
)
def test_frames_of_all_lengths_are_reported_in_plain_digits(seconds: float, words: str) -> None:
    assert time_text(seconds) == words


def test_settings_are_reported_in_words() -> None:
    assert setting_text(Setting("sh", {"order": 15, "interreflection": 1})) == "SH, order 15, interreflection"
    assert setting_text(Setting("shading-map", {"directions": 16})) == "Material, directions 16"


def test_before_anything_is_measured_the_axes_have_no_numbers(view: MainWindow) -> None:
    axes = [view.docks.accuracy.plot.getPlotItem().getAxis(side) for side in ("bottom", "left")]
    assert all(axis._tickLevels == [] for axis in axes)
    measure(view)
    assert all(axis._tickLevels != [] for axis in axes)


@pytest.mark.dressed
def test_what_lies_below_shares_the_place_of_accuracy_in_a_narrow_window(
    view: MainWindow, monkeypatch: pytest.MonkeyPatch
) -> None:
    for dock in view.docks.others:
        dock.show()
    view.resize(1280, 800)
    assert set(view.docks.others) <= set(view.tabifiedDockWidgets(view.docks.accuracy))
    moved: list[Any] = []
    monkeypatch.setattr(view, "tabifyDockWidget", lambda _before, behind: moved.append(behind))
    view.resize(1920, 1000)
    assert not set(view.docks.others) & set(view.tabifiedDockWidgets(view.docks.accuracy))
    assert not moved, "they are beside each other already"


def test_points_come_back_with_the_scene_that_they_are_of(view: MainWindow) -> None:
    """Another scene makes them stale, taking that back makes them good again, and so it does with the sweep itself."""
    found, stack, dock = measure(view), view.bench.document.undo_stack, view.docks.accuracy
    view.bench.document.change("Another", mesh=sphere())
    assert dock.is_stale
    stack.undo()
    assert not dock.is_stale
    assert dock.accuracy is found
    stack.undo()
    assert dock.accuracy is None
    assert dock.plot.shown == []
    stack.redo()
    assert {point.setting for point in dock.plot.shown} == {point.setting for point in POINTS}


def test_what_was_measured_belongs_to_its_tiling() -> None:
    """Repeats and cells of a material change its errors; of one BRDF they change nothing."""
    mesh = ball()
    plain = Scene(mesh, frame(mesh.positions, 1.0), brdf_from_text("phong"))
    textured = dataclasses.replace(plain, material=weave(32))
    for scene, is_same in ((plain, True), (textured, False)):
        key = scene_key(scene, 0)
        assert same_key(key, scene_key(dataclasses.replace(scene, repeats=7.0), 0)) is is_same
        assert same_key(key, scene_key(scene, 0))
