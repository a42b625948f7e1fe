"""Control points marked by hand in the Capture workspace, up to the import that follows them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import QPointF, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from app.capture.panel import find_unaligned
from app.capture.points_tool import PointsTool
from app.window.main_window import MainWindow
from tests.app.captures import capture as capture_tab
from tests.app.captures import choices, click, drag, import_again, open_path, pick
from tests.present import present

SPOTS = ((20.0, 18.0), (80.0, 24.0), (74.0, 79.0), (15.0, 66.0), (48.0, 45.0))


@pytest.fixture(scope="module")
def capture(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Any]]:
    """Woven cloth whose photographs were moved by several pixels."""
    folder = tmp_path_factory.mktemp("points") / "Moved cloth"
    return folder, capture_tab(folder, misalignment_px=4.0, sample="hammered")[1]


@pytest.fixture
def marking(window: MainWindow, qtbot: Any, capture: tuple[Path, dict[str, Any]]) -> MainWindow:
    """The window with the tool open, on a photograph that is not the reference."""
    open_path(window, qtbot, capture[0], motion="none")
    qtbot.mouseClick(window.capture.options.points, Qt.MouseButton.LeftButton)
    load(window, qtbot)
    return window


def load(window: MainWindow, qtbot: Any) -> None:
    views = window.capture.points.views
    qtbot.waitUntil(lambda: all(view.image is not None for view in views), timeout=60_000)


def points(window: MainWindow) -> PointsTool:
    return window.capture.points


def motion(truth: dict[str, Any], reference: str, name: str) -> np.ndarray:
    """(3, 3) from pixels of the reference to pixels of the photograph, as it was simulated."""
    of = {file: np.vstack([truth[file]["alignment_matrix"], [0, 0, 1]]) for file in (reference, name)}
    return np.asarray(of[name] @ np.linalg.inv(of[reference]))


def mark(window: MainWindow, spot: tuple[float, float], there: tuple[float, float], first: int = 0) -> None:
    """Click the same spot in both images, in image number `first` first."""
    tool = points(window)
    for side in (first, 1 - first):
        view = tool.views[side]
        click(view, view.on_screen(there if side else spot))


def mark_truly(window: MainWindow, truth: dict[str, Any], spots: Any) -> np.ndarray:
    """Mark `spots` of the reference where they truly are in the photograph; the motion that was simulated."""
    tool = points(window)
    matrix = motion(truth, tool.reference.currentData(), str(tool.name))
    for number, spot in enumerate(spots):
        x, y, _ = matrix @ [*spot, 1.0]
        mark(window, spot, (float(x), float(y)), first=number % 2)
    return matrix


def test_points_marked_in_both_images_move_the_photograph_where_it_was(
    marking: MainWindow, qtbot: Any, capture: tuple[Path, dict[str, Any]]
) -> None:
    """A click is known to half a pixel of the screen, which is about 0.15 px of these photographs."""
    tool, document = points(marking), marking.bench.document
    pick(marking, "motion", "translation")
    steps = document.undo_stack.count()
    truth = mark_truly(marking, capture[1], SPOTS)
    assert document.undo_stack.count() == steps + len(SPOTS)
    assert tool.name is not None
    assert len(choices(marking).control_points[tool.name]) == len(SPOTS)
    assert choices(marking).reference == tool.reference.currentData()
    assert "For the next import: a shift from 5 points" in tool.status.text()
    name = str(tool.name)
    stack = import_again(marking, qtbot)
    place = stack.sources.index(name)
    found = np.reshape(stack.provenance["photographs"][place]["alignment_matrix"], (3, 3))
    assert np.abs(found - truth).max() < 0.3
    assert np.abs(truth[:2, 2]).max() > 1.0
    assert stack.provenance["aligned_to"] == choices(marking).reference
    assert "Imported: a shift from 5 points" in tool.status.text()
    missed = [float(present(tool.table.item(row, 3)).text().removesuffix(" px")) for row in range(len(SPOTS))]
    expected = stack.quality[place].alignment_residual_px
    assert np.sqrt(np.mean(np.square(missed))) == pytest.approx(expected, abs=0.01)


def test_a_point_is_dragged_moved_by_keys_and_deleted_in_one_step_each(marking: MainWindow, qtbot: Any) -> None:
    tool, undo = points(marking), marking.bench.document.undo_stack
    for spot in SPOTS[:3]:
        mark(marking, spot, spot)
    assert tool.name is not None
    before, steps = choices(marking).control_points[tool.name], undo.count()
    view = tool.views[1]
    drag(view, view.on_screen(view.markers[1]), view.on_screen(view.markers[1]) + QPointF(30, -20))
    after = choices(marking).control_points[tool.name]
    assert undo.count() == steps + 1
    assert (after[0], after[2], after[1][:2]) == (before[0], before[2], before[1][:2])
    way = np.subtract(after[1][2:], before[1][2:]) * view.zoom
    assert way == pytest.approx([30, -20], abs=1.5)
    view.setFocus()
    for _ in range(3):
        QTest.keyPress(view, Qt.Key.Key_Right)
    QTest.keyRelease(view, Qt.Key.Key_Right)
    assert undo.count() == steps + 2
    assert choices(marking).control_points[tool.name][1][2] == pytest.approx(after[1][2] + 3)
    assert marking.capture.current == tool.name, "the arrow keys moved the point, not the selection"
    QTest.keyClick(view, Qt.Key.Key_Delete)
    assert choices(marking).control_points[tool.name] == (before[0], before[2])
    assert undo.count() == steps + 3
    for expected in (3, 3, 3, 2, 1, 0):
        marking.undo.trigger()
        assert len(choices(marking).control_points.get(tool.name, ())) == expected
        assert tool.table.rowCount() == expected
    for _ in range(6):
        marking.redo.trigger()
    assert choices(marking).control_points[tool.name] == (before[0], before[2])


def test_half_a_pair_waits_moves_and_is_forgotten(marking: MainWindow) -> None:
    tool, undo = points(marking), marking.bench.document.undo_stack
    steps, left = undo.count(), tool.views[0]
    click(left, left.on_screen((30, 30)))
    assert f"the same spot in {tool.name}" in tool.status.text()
    click(left, left.on_screen((50, 40)))
    assert left.pending == pytest.approx((50, 40), abs=0.5)
    QTest.keyClick(left, Qt.Key.Key_Escape)
    assert (tool.waiting, left.pending) == (None, None)
    assert undo.count() == steps
    assert marking.capture.tools.currentWidget() is tool
    QTest.keyClick(left, Qt.Key.Key_Escape)
    assert marking.capture.tools.currentIndex() == 0


def test_another_photograph_while_marking_forgets_the_half_pair_and_keeps_the_points(
    marking: MainWindow, qtbot: Any
) -> None:
    tool, tab = points(marking), marking.capture
    name = str(tool.name)
    mark(marking, SPOTS[0], SPOTS[0])
    left = tool.views[0]
    click(left, left.on_screen(SPOTS[1]))
    rows = [row.name for row in tab.list.photographs.rows]
    reference = str(tool.reference.currentData())
    tab.list.choose(rows.index(reference))
    assert tool.waiting is None
    assert tool.right.currentWidget() is tool.itself
    assert reference in tool.itself.text()
    assert not tool.add.isEnabled()
    click(left, left.on_screen((10, 10)))
    assert tool.waiting is None
    other = next(one for one in rows if one not in (reference, name))
    tab.list.choose(rows.index(other))
    load(marking, qtbot)
    assert tool.table.rowCount() == 0
    mark(marking, SPOTS[2], SPOTS[2])
    assert {one: len(pairs) for one, pairs in choices(marking).control_points.items()} == {name: 1, other: 1}
    assert tab.options.points.text() == "2 points…"


def test_too_few_points_and_points_on_one_line_are_said_to_be_so(marking: MainWindow, qtbot: Any) -> None:
    tool = points(marking)
    pick(marking, "motion", "affine")
    assert "3 points give an affine motion" in tool.status.text()
    for number, x in enumerate((10.0, 40.0, 80.0), start=1):
        mark(marking, (x, 40.0), (x, 40.0))
        if number < 3:
            assert f"{number} of the 3 points" in tool.status.text()
    assert "do not determine an affine motion" in tool.status.text()
    stack = import_again(marking, qtbot)
    assert any("do not determine" in finding.text for finding in stack.health.findings if finding.source == tool.name)
    pick(marking, "motion", "none")
    assert "3 of the 4 points that a perspective motion needs" in tool.status.text()


def test_the_middle_serves_users_without_a_mouse_and_all_points_can_be_removed(marking: MainWindow) -> None:
    tool, undo = points(marking), marking.bench.document.undo_stack
    for view in tool.views:
        assert view.focusPolicy() == Qt.FocusPolicy.StrongFocus
        assert view.accessibleName()
    tool.add.click()
    tool.add.click()
    assert tool.name is not None
    assert len(choices(marking).control_points[tool.name]) == 2
    x, y, *_ = choices(marking).control_points[tool.name][0]
    assert (x, y) == pytest.approx((47.5, 47.5), abs=1)
    steps = undo.count()
    tool.reset.click()
    assert undo.count() == steps + 1
    assert (choices(marking).control_points, choices(marking).reference) == ({}, None)
    assert not tool.reset.isEnabled()
    marking.undo.trigger()
    assert len(choices(marking).control_points[tool.name]) == 2


def test_another_reference_takes_the_points_of_the_old_one_away_in_one_step(marking: MainWindow, qtbot: Any) -> None:
    tool = points(marking)
    mark(marking, SPOTS[0], SPOTS[0])
    old, new = str(tool.reference.currentData()), str(tool.name)
    tool.reference.setCurrentIndex(tool.reference.findData(new))
    tool.reference.activated.emit(tool.reference.currentIndex())
    assert (choices(marking).reference, dict(choices(marking).control_points)) == (new, {})
    assert tool.right.currentWidget() is tool.itself
    marking.undo.trigger()
    assert choices(marking).reference == old
    load(marking, qtbot)
    assert tool.table.rowCount() == 1


def test_points_that_tear_the_photographs_apart_leave_everything_as_it_was(marking: MainWindow, qtbot: Any) -> None:
    tool, project = points(marking), marking.bench.document.project
    mark(marking, (1.0, 1.0), (94.0, 94.0))
    mark(marking, (1.0, 94.0), (94.0, 1.0))
    pick(marking, "motion", "translation")
    far = {str(tool.name): ((0.0, 0.0, 95.0, 95.0), (0.5, 0.0, 95.5, 95.0))}
    from app.document.import_choices import choose

    choose(marking.bench.document, "Move a point", control_points=far)
    marking.capture.again.click()
    qtbot.waitUntil(lambda: bool(marking.failures.open_dialogs), timeout=60_000)
    (box,) = marking.failures.open_dialogs.values()
    assert "no pixel is seen by all" in box.text() + box.informativeText()
    box.close()
    assert marking.bench.document.project.stack is project.stack
    assert marking.capture.tools.currentWidget() is tool
    assert marking.capture.again.isEnabled()


def test_cancelling_the_import_keeps_the_points_and_the_old_stack(marking: MainWindow, qtbot: Any) -> None:
    tool, document = points(marking), marking.bench.document
    stack = document.project.stack
    for spot in SPOTS[:4]:
        mark(marking, spot, spot)
    marking.capture.again.click()
    assert marking.bench.importing is not None
    marking.bench.jobs.cancel(marking.bench.importing)
    qtbot.waitUntil(lambda: not marking.bench.jobs.active, timeout=60_000)
    assert document.project.stack is stack
    assert marking.capture.again.isEnabled()
    assert tool.table.rowCount() == 4


def test_a_storm_of_undo_and_redo_leaves_view_and_project_of_one_mind(marking: MainWindow, qtbot: Any) -> None:
    tool = points(marking)
    for spot in SPOTS:
        mark(marking, spot, spot)
    view = tool.views[0]
    QTest.mousePress(view, Qt.MouseButton.LeftButton, pos=view.on_screen(view.markers[4]).toPoint())
    QTest.mouseMove(view, (view.on_screen(view.markers[4]) + QPointF(20, 20)).toPoint())
    for _ in range(40):
        marking.undo.trigger()
    QTest.mouseMove(view, (view.on_screen((30, 30))).toPoint())
    QTest.mouseRelease(view, Qt.MouseButton.LeftButton, pos=view.on_screen((30, 30)).toPoint())
    for _ in range(40):
        marking.redo.trigger()
    QApplication.processEvents()
    assert marking.bench.document.project.stack is not None
    ((name, pairs),) = choices(marking).control_points.items()
    assert len(pairs) == len(SPOTS)
    marking.capture._show_source(name)  # undoing the opening of the photographs left the tool and chose none of them
    qtbot.mouseClick(marking.capture.options.points, Qt.MouseButton.LeftButton)
    load(marking, qtbot)
    assert tool.name == name
    assert tool.table.rowCount() == len(tool.views[0].markers) == len(SPOTS)


def test_what_could_not_be_aligned_leads_to_the_points(
    window: MainWindow, qtbot: Any, tmp_path: Path, capture: tuple[Path, dict[str, Any]]
) -> None:
    """One photograph of another thing: alignment refuses it, and the panel says where to go."""
    import shutil

    folder = tmp_path / "c"
    shutil.copytree(capture[0], folder)
    other = folder.parent / "other"
    capture_tab(other, sample="leather", seed=9)
    victim = sorted(folder.glob("*.tif"))[0]
    shutil.copyfile(sorted(other.glob("*.tif"))[0], victim)
    open_path(window, qtbot, folder, motion="translation")
    assert find_unaligned(window.bench.document.project.stack) == (victim.name,)
    panel = window.capture.options
    assert panel.lost.isVisible()
    assert victim.name in panel.lost.text()
    qtbot.mouseClick(panel.points, Qt.MouseButton.LeftButton)
    load(window, qtbot)
    assert points(window).name == victim.name
    mark(window, (50.0, 50.0), (52.0, 51.0))
    assert not panel.lost.isVisible()
    stack = import_again(window, qtbot)
    assert find_unaligned(stack) == ()
    matrix = np.reshape(stack.provenance["photographs"][0]["alignment_matrix"], (3, 3))
    assert matrix[:2, 2] == pytest.approx([2, 1], abs=0.4)
