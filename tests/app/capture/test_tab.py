"""The Capture workspace: handles in the plot and on the photograph, calibration, and what an import is asked for."""

from __future__ import annotations

import os
import shutil
from pathlib import Path
from typing import Any

import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtTest import QTest

from app.document.document import ImportChoices
from app.window.main_window import MainWindow
from engine.capture.stack import RADIANCE, RECORD, open_stack
from engine.storage.file_array import FileArray
from tests.app.captures import choices, drag, open_path, pick
from tests.present import present


@pytest.fixture
def imported(window: MainWindow, qtbot: Any, photographs: Path) -> MainWindow:
    return open_path(window, qtbot, photographs)


def test_the_handle_below_a_point_excludes_its_photograph(imported: MainWindow, qtbot: Any) -> None:
    plot, document = imported.capture.plot.inside, imported.bench.document
    handle = plot.handles.points()[1]
    qtbot.wait(100)
    place = plot.mapFromScene(plot.getPlotItem().getViewBox().mapViewToScene(handle.pos()))
    for expected in ({"felt_30deg.png"}, set()):
        QTest.mouseClick(plot.viewport(), Qt.MouseButton.LeftButton, pos=QPoint(int(place.x()), int(place.y())))
        assert document.project.excluded == expected
        qtbot.wait(600)


def test_four_corners_are_dragged_in_one_step_and_cut_the_image(imported: MainWindow, qtbot: Any) -> None:
    tab, document = imported.capture, imported.bench.document
    assert not tab.options.width_field.isEnabled()
    pick(imported, "framing", "corners")
    qtbot.waitUntil(lambda: choices(imported).framing is not None and not imported.bench.jobs.active, timeout=60_000)
    assert tab.when.value == "before"
    before, steps = choices(imported).framing, document.undo_stack.count()
    drag(tab.image, tab.image.handle(2), tab.image.handle(2) - QPointF(40, 30))
    framing = choices(imported).framing
    assert document.undo_stack.count() == steps + 1
    assert framing is not None
    assert framing.corners[:2] == present(before).corners[:2]
    assert framing.corners[2][0] == pytest.approx(
        present(before).corners[2][0] - 40 / tab.image.zoom, abs=1.5 / tab.image.zoom
    )
    assert tab.again.isEnabled()
    qtbot.mouseClick(tab.again, Qt.MouseButton.LeftButton)
    qtbot.waitUntil(lambda: not imported.bench.jobs.active, timeout=240_000)
    assert document.project.stack is not None
    assert document.project.stack.radiance.shape[1:3] == (framing.height_px, framing.width_px)
    assert document.project.name == "Felt sample"
    assert tab.when.value == "after"
    assert tab.again.toolTip() == "Nothing was changed"


def test_a_crop_stays_upright(imported: MainWindow, qtbot: Any) -> None:
    tab = imported.capture
    pick(imported, "framing", "crop")
    qtbot.waitUntil(lambda: choices(imported).framing is not None and not imported.bench.jobs.active, timeout=60_000)
    drag(tab.image, tab.image.handle(0), tab.image.handle(0) + QPointF(30, 20))
    framing = choices(imported).framing
    assert framing is not None
    (left, top), (right, upper), (_, bottom), (lower, _) = framing.corners
    assert (upper, lower) == (top, left)
    assert (framing.width_px, framing.height_px) == (right - left, bottom - top)
    assert tab.options.framing.currentData() == "crop"


def test_a_grey_patch_is_drawn_and_decides_the_white_balance(imported: MainWindow, qtbot: Any) -> None:
    tab = imported.capture
    pick(imported, "white_balance", "patch")
    qtbot.waitUntil(lambda: not imported.bench.jobs.active, timeout=60_000)
    middle = QPointF(tab.image.width() / 2, tab.image.height() / 2)
    drag(tab.image, middle, middle + QPointF(20, 10) * tab.image.zoom)
    assert present(choices(imported).patch)[2:] == pytest.approx((20, 10), abs=1)
    assert tab.options.boxes["white_balance"].currentData() == "patch"
    imported.undo.trigger()
    assert choices(imported).patch is None


@pytest.mark.dressed
def test_dark_frame_lamp_and_sphere_are_asked_for(
    imported: MainWindow, qtbot: Any, photographs: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    panel, dark = imported.capture.options, photographs / "felt_10deg.png"
    monkeypatch.setattr("app.capture.import_panel.QFileDialog.getOpenFileName", lambda *_: (str(dark), ""))
    assert not panel.lamp.isVisible()
    qtbot.mouseClick(panel.fold.head, Qt.MouseButton.LeftButton)
    assert panel.lamp.isVisible()
    pick(imported, "dark", "choose")
    assert choices(imported).dark == dark
    assert panel.boxes["dark"].currentText() == "felt_10deg.png"
    assert not panel.distance.isEnabled()
    qtbot.mouseClick(panel.lamp.buttons["near"], Qt.MouseButton.LeftButton)
    panel.distance.edited.emit(2.0, True)
    assert choices(imported).lamp_distance == 2.0
    qtbot.mouseClick(panel.sphere.buttons["sphere"], Qt.MouseButton.LeftButton)
    assert choices(imported).sphere
    assert imported.bench.document.undo_stack.undoText() == "Lights"


def test_places_in_one_capture_do_not_cut_the_next(imported: MainWindow, qtbot: Any, photographs: Path) -> None:
    document = imported.bench.document
    asked = ImportChoices(motion="none", patch=(1, 2, 30, 40), lamp_distance=2.0, sphere=True)
    document.change("Ask", import_choices=asked)
    stack = document.project.stack
    imported.bench.open_photographs([photographs])  # as the answer "Replace" does
    qtbot.waitUntil(
        lambda: document.project.stack is not stack and not imported.bench.jobs.active,
        timeout=240_000,
    )
    assert choices(imported) == document.project.imported_with == ImportChoices(motion="none")


def test_pixels_of_the_cache_that_are_cut_short_are_read_again(imported: MainWindow, qtbot: Any) -> None:
    """The next photograph is asked for, and a texel under the pointer; then a material."""
    tab, bench = imported.capture, imported.bench
    qtbot.waitUntil(lambda: not bench.jobs.active, timeout=60_000)
    stack = present(bench.document.project.stack)
    assert isinstance(stack.radiance, FileArray)
    assert isinstance(stack.saturated, FileArray)
    files = (stack.radiance.path, stack.saturated.path)
    before = [file.read_bytes() for file in files]
    os.truncate(files[0], 0)
    tab.image.pointed.emit(3, 4)
    assert tab.bar.readout.text() == "is damaged"
    tab.list.choose(0)
    qtbot.waitUntil(lambda: files[0].stat().st_size > 0 and not bench.jobs.active, timeout=60_000)
    shape = stack.radiance.shape[2], stack.radiance.shape[1]
    qtbot.waitUntil(lambda: present(tab.image.image).size == shape, timeout=60_000)
    assert [file.read_bytes() for file in files] == before
    os.truncate(files[1], 200)
    built = bench.document.project.material
    bench.document.change("Slices", slices=bench.document.project.slices + 1)  # else the material is found again
    bench.build_material()
    qtbot.waitUntil(lambda: bench.document.project.material is not built and not bench.jobs.active, timeout=60_000)
    assert [file.read_bytes() for file in files] == before
    assert bench.document.project.stack is stack
    assert not imported.failures.open_dialogs


def test_a_stack_that_is_cut_short_while_it_is_open_is_named_and_the_window_stays(
    imported: MainWindow, qtbot: Any, tmp_path: Path
) -> None:
    """A stack of its own, which nothing makes again; a mapped file would end it all."""
    tab, bench = imported.capture, imported.bench
    qtbot.waitUntil(lambda: not bench.jobs.active, timeout=60_000)
    old = present(bench.document.project.stack)
    assert old.folder is not None
    assert isinstance(old.radiance, FileArray)
    folder = shutil.copytree(old.radiance.path.parent, tmp_path / "stack")
    shutil.copyfile(old.folder / RECORD, folder / RECORD)
    stack = open_stack(folder)
    bench.document.change("Another", stack=stack, sources=None, imported_with=None, excluded=frozenset())
    tab.list.choose(1)
    qtbot.waitUntil(lambda: not bench.jobs.active, timeout=60_000)
    project = bench.document.project
    os.truncate(folder / RADIANCE, 0)
    tab.list.choose(0)
    bench.build_material()
    qtbot.waitUntil(lambda: len(imported.failures.open_dialogs) == 1 and not bench.jobs.active, timeout=60_000)
    (box,) = imported.failures.open_dialogs.values()
    assert "was cut short while it was open" in box.informativeText()
    assert "radiance.npy" in box.informativeText()
    tab.image.pointed.emit(3, 4)
    assert tab.bar.readout.text() == "was cut short while it was open"
    assert bench.document.project is project


def test_the_photograph_that_was_chosen_is_chosen_again_after_undo_and_redo(imported: MainWindow) -> None:
    tab, history = imported.capture, imported.bench.document.undo_stack
    tab.list.choose(0)
    chosen, steps = tab.current, history.index()
    assert chosen == tab.list.photographs.rows[0].name
    history.setIndex(0)
    assert tab.current is None
    history.setIndex(steps)
    assert tab.current == chosen
    assert tab.list.currentIndex().row() == 0
