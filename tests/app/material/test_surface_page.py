"""Surface maps in the window: made, looked at with their uncertainty, kept in the project, written to a folder."""

from __future__ import annotations

import dataclasses
import json
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QFileDialog

from app.commands.surface import surface_of
from app.document.document import Project
from app.material.surface_page import UNKNOWN, error_words, show
from app.project.project_file import History, Writer, read
from app.window.main_window import MainWindow
from engine.capture.stack import ImageStack
from engine.core.directions import surface_direction
from engine.core.figure_text import number
from engine.core.steps import drain
from engine.surface.recover import Surface, recover
from engine.surface.write import find_known_maps
from tests.app.project.test_project_file import shading_map
from tests.engine.domes import dome
from tests.present import present


def arc() -> ImageStack:
    """A slope that rises to the right, under lamps of one arc from the right to the left."""
    stack = dome(6)
    elevation, azimuth = np.radians([30.0, 50.0, 70.0, 80.0, 60.0, 40.0]), np.radians([0.0] * 3 + [180.0] * 3)
    normal = np.array([-0.3, 0.0, 1.0]) / np.hypot(0.3, 1.0)
    shaded = surface_direction(0.5 * np.pi - elevation, azimuth) @ normal
    radiance = np.broadcast_to(0.5 * shaded[:, None, None, None], stack.radiance.shape).astype(np.float32)
    return dataclasses.replace(stack, radiance=radiance, elevation=elevation, azimuth=azimuth)


def find(window: MainWindow) -> Surface:
    return present(window.bench.document.project.surface)


def fill_in(window: MainWindow, stack: ImageStack) -> None:
    """A capture with a material in the document, and the Material workspace in front."""
    material = dataclasses.replace(window.bench.document.project.material, shading_map=shading_map())
    window.bench.document.change("Import", stack=stack, material=material)
    window.show_workspace("material")


@cache
def make_dome() -> tuple[ImageStack, Surface]:
    """A dome and its maps."""
    stack = dome()
    return stack, drain(recover(stack, np.arange(len(stack.sources))))


def divide(surface: Surface) -> Surface:
    """The surface with its left part as a region of its own, beyond a column of unknown height."""
    maps = surface.maps
    region, sigma = np.zeros(maps.size, np.float32), np.ones(maps.size, np.float32)
    region[:, :3], sigma[:, 3] = 1.0, np.inf
    uncertainty = dataclasses.replace(present(maps.uncertainty), height=sigma)
    return dataclasses.replace(surface, maps=dataclasses.replace(maps, uncertainty=uncertainty, region=region))


def list_given(window: MainWindow, qtbot: Any) -> None:
    """A dome and its maps in the document, on screen."""
    stack, surface = make_dome()
    fill_in(window, stack)
    window.bench.document.change("Maps", surface=surface, surface_from=(stack, frozenset()))
    qtbot.mouseClick(window.material.switch.buttons["surface"], Qt.MouseButton.LeftButton)
    qtbot.waitUntil(lambda: window.material.surface.image.image is not None, timeout=60_000)


def make(window: MainWindow, qtbot: Any) -> None:
    qtbot.mouseClick(window.material.switch.buttons["surface"], Qt.MouseButton.LeftButton)
    with qtbot.waitSignal(window.bench.document.changed, timeout=240_000):
        qtbot.mouseClick(window.material.surface.make, Qt.MouseButton.LeftButton)
        assert not window.material.surface.make.isEnabled()
    qtbot.waitUntil(lambda: not window.bench.jobs.active, timeout=60_000)


def test_maps_are_made_and_shown_with_their_errors(window: MainWindow, qtbot: Any) -> None:
    fill_in(window, dome())
    page = window.material.surface
    assert not page.save.isEnabled()
    make(window, qtbot)
    assert window.material.pages.currentWidget() is page
    assert window.bench.document.undo_stack.undoText() == "Make surface maps"
    maps = find(window).maps
    assert page.left_out.text() == number(maps.errors.left_out)
    assert page.slopes.text() == "both directions"
    assert not page.one_arc.isVisible()
    assert "up to date" in page.make.toolTip()
    for name, button in page.which.buttons.items():
        for what in ("map", "error"):
            before = page.image.image
            qtbot.mouseClick(button, Qt.MouseButton.LeftButton)
            qtbot.mouseClick(page.show_what.buttons[what], Qt.MouseButton.LeftButton)
            qtbot.waitUntil(lambda before=before: page.image.image is not before, timeout=60_000)
            qtbot.waitUntil(lambda: not window.bench.jobs.active, timeout=60_000)
            assert page.bar.isVisible() == (what == "error" or name not in ("normal", "base_colour"))
            assert page.error.text() == error_words(name, find_known_maps(maps)[f"{name}_sigma"])
    window.undo.trigger()
    assert window.bench.document.project.surface is None
    assert page.pages.currentWidget() is page.empty
    window.redo.trigger()
    assert find(window).maps is maps


def test_what_a_normal_map_shows_is_the_normal(window: MainWindow, qtbot: Any) -> None:
    list_given(window, qtbot)
    normal = find(window).maps.normal
    shown = present(window.material.surface.image.image).levels[0].pixelColor(3, 2)
    wanted = np.rint(255.0 * (0.5 + 0.5 * normal[2, 3]))
    assert np.abs(np.array([shown.red(), shown.green(), shown.blue()]) - wanted).max() <= 1.0


def test_lamps_of_one_arc_tell_one_slope_and_no_height(window: MainWindow, qtbot: Any) -> None:
    fill_in(window, arc())
    make(window, qtbot)
    page = window.material.surface
    assert page.slopes.text() == "along the arc"
    assert "only the slope along 0° is observed" in page.one_arc.text()
    assert not page.which.buttons["height"].isEnabled()
    assert "no height" in page.which.buttons["height"].toolTip()


def test_maps_are_out_of_date_when_a_photograph_is_left_out(window: MainWindow, qtbot: Any) -> None:
    list_given(window, qtbot)
    window.bench.set_excluded(["3"], True)
    page = window.material.surface
    assert page.make.isEnabled()
    assert page.make.text() == "Make them again"
    window.bench.document.change("No photographs", stack=None)
    assert "Needs the photographs" in page.make.toolTip()


def test_a_white_card_that_is_known_is_a_step_and_puts_maps_out_of_date(window: MainWindow, qtbot: Any) -> None:
    list_given(window, qtbot)
    page, document = window.material.surface, window.bench.document
    assert not page.white.isEnabled()
    qtbot.mouseClick(page.whites.buttons["known"], Qt.MouseButton.LeftButton)
    assert document.project.white == page.white.value == 1.0
    page.white.setFocus()
    page.white.selectAll()
    qtbot.keyClicks(page.white, "0.5")
    qtbot.keyClick(page.white, Qt.Key.Key_Return)
    assert (document.project.white, document.undo_stack.undoText()) == (0.5, "White reference")
    assert page.make.text() == "Make them again"
    assert page.make.isEnabled()
    assert drain(surface_of(document.project)).white == 0.5
    window.undo.trigger()
    assert page.white.value == 1.0
    window.undo.trigger()
    assert document.project.white is None
    assert page.whites.value == "found"
    assert "up to date" in page.make.toolTip()


def test_cancelled_maps_leave_nothing(window: MainWindow, qtbot: Any) -> None:
    fill_in(window, dome())
    window.material.show_page("surface")
    page = window.material.surface
    qtbot.mouseClick(page.make, Qt.MouseButton.LeftButton)
    job = present(page.making)
    with qtbot.waitSignal(job.cancelled, timeout=120_000):
        window.bench.jobs.cancel(job)
    assert window.bench.document.project.surface is None
    assert page.make.isEnabled()


def test_maps_are_written_to_a_folder(
    window: MainWindow, qtbot: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    list_given(window, qtbot)
    folder = tmp_path / "dome maps"
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: (str(folder), ""))
    page = window.material.surface
    qtbot.mouseClick(page.save, Qt.MouseButton.LeftButton)
    with qtbot.waitSignal(present(page.saving).succeeded, timeout=60_000):
        pass
    record = json.loads((folder / "surface.json").read_text())
    assert record["leave_one_out_rmse_srgb8"] == pytest.approx(find(window).maps.errors.left_out)
    assert (folder / "normal.exr").is_file()
    assert (folder / "height_sigma.png").is_file()


def test_maps_are_read_from_a_project_as_they_were_written(tmp_path: Path) -> None:
    surface = divide(make_dome()[1])
    path = tmp_path / "dome.lap"
    writer = Writer(path)
    writer.write(History(Project(surface=surface, name="Coin")))
    writer.close()
    opened = read(path)
    again = present(opened.current.surface)
    assert not opened.missing
    assert (again.white, again.health.findings) == (surface.white, surface.health.findings)
    assert again.maps.errors == surface.maps.errors
    before, after = find_known_maps(surface.maps), find_known_maps(again.maps)
    assert before.keys() == after.keys()
    assert all(np.array_equal(before[name], after[name]) for name in before)


def test_heights_have_their_scale_and_regions_are_explained() -> None:
    surface = divide(make_dome()[1])
    rows, columns = np.indices(surface.maps.size)
    height = (rows - 3.0 * columns - 5.0).astype(np.float32)
    surface = dataclasses.replace(surface, maps=dataclasses.replace(surface.maps, height=height))
    shown = drain(show(surface, "height", of_error=False))
    assert (shown.low, shown.high) == pytest.approx(np.quantile(height.astype(float), (0.001, 0.999)))
    assert shown.values == f"{number(shown.low)} to {number(shown.high)}"
    assert "2 regions counts from its own mean" in shown.error
    image = present(shown.image).levels[0]
    unknown, known = image.pixelColor(3, 2), image.pixelColor(4, 2)
    assert (unknown.red(), unknown.green(), unknown.blue()) == UNKNOWN
    assert known.red() == known.blue()
    assert np.isfinite(drain(show(surface, "height", of_error=True)).high)
    assert "regions" not in drain(show(surface, "normal", of_error=False)).error


def test_errors_are_said_in_words() -> None:
    sigma = np.full((10, 10), np.radians(2.0), np.float32)
    assert error_words("normal", sigma).startswith("Median normal uncertainty 2° (1 sigma), 95\u00a0% below 2°")
    sigma[0] = np.inf
    assert "unknown at more than 5\u00a0% of the texels" in error_words("normal", sigma)
    sigma[:6] = np.inf
    assert error_words("normal", sigma) == "The normal is unknown at most texels."
