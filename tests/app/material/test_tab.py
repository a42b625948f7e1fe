"""The Material workspace: compression with a bound, fewer bits, tiles, and texels to look at."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt

from app.material.texel_panel import WORST_SHOWN
from app.window.main_window import MainWindow
from engine.core.figure_text import number
from engine.shading.power_law_error import worst_texels
from tests.app.window.test_main_window import fill
from tests.engine.scenes import weave
from tests.present import present


@pytest.fixture
def filled(window: MainWindow) -> MainWindow:
    fill(window)
    window.show_workspace("material")
    return window


def rebuild(window: MainWindow, qtbot: Any) -> None:
    """Press Ctrl+Enter and wait for the material."""
    built = window.bench.document.project.material
    window.activateWindow()
    qtbot.waitUntil(window.isActiveWindow, timeout=30_000)
    qtbot.keyClick(window, Qt.Key.Key_Return, Qt.KeyboardModifier.ControlModifier)
    qtbot.waitUntil(lambda: window.bench.document.project.material is not built, timeout=240_000)
    qtbot.waitUntil(lambda: not window.bench.jobs.active, timeout=60_000)


def test_mixed_mode_keeps_slices_where_the_bound_is_reached(filled: MainWindow, qtbot: Any) -> None:
    tab = filled.material
    assert not tab.bound.isEnabled()
    assert "mixed" in tab.bound.toolTip()
    qtbot.mouseClick(tab.mode.buttons["mixed"], Qt.MouseButton.LeftButton)
    tab.bound.edited.emit(0.0, True)
    assert filled.bench.document.project.error_bound_percent == 0.0
    rebuild(filled, qtbot)
    power_law = filled.bench.document.project.material.power_law
    assert power_law is not None
    assert power_law.kept is not None
    assert tab.kept.text() == "100 %"
    assert power_law.error_map.max() == 0.0
    assert tab.texel_figures.residual.text() == "0, slices kept"
    assert "no less room" in tab.costs_more.text()
    filled.undo.trigger()
    assert tab.kept.text() == "none"
    assert tab.costs_more.text() == ""


def test_fewer_bits_take_fewer_bytes_and_say_how_far_they_round(filled: MainWindow, qtbot: Any) -> None:
    tab, before = filled.material, filled.material.size_pair.text()
    assert tab.rounding.text() == "none"
    tab.bits.setCurrentIndex(tab.bits.findData(8))
    tab.bits.activated.emit(tab.bits.currentIndex())
    rebuild(filled, qtbot)
    assert filled.bench.document.project.material.power_law is not None
    storage = filled.bench.document.project.material.power_law.storage
    assert storage.exponent_bits == 8
    assert tab.rounding.text() == f"≤ {number(storage.bound)}"
    assert tab.size_pair.text() != before


def test_a_tileable_material_repeats_and_its_seams_are_measured(filled: MainWindow, qtbot: Any) -> None:
    tab = filled.material
    assert tab.tiling.seams.text() == "not tileable"
    assert not tab.tiling.brightness.isEnabled()
    qtbot.mouseClick(tab.tiling.edges.buttons["tileable"], Qt.MouseButton.LeftButton)
    assert tab.tiling.brightness.value == "evened"
    rebuild(filled, qtbot)
    shading_map = filled.bench.document.project.material.shading_map
    assert shading_map is not None
    assert "unevenness" in shading_map.health.figures
    assert tab.tiling.seams.text() == f"{number(shading_map.health.figures['seam_error'], 3)} × inside"
    qtbot.mouseClick(tab.show_what.buttons["tiles"], Qt.MouseButton.LeftButton)
    height, width = shading_map.slices.shape[1:3]
    qtbot.waitUntil(lambda: present(tab.image.image).size == (3 * width, 3 * height), timeout=60_000)
    assert tab.image.probe is None
    assert tab.image.image is not None
    shown = tab.image.image.levels[0]
    assert shown.pixel(3, 5) == shown.pixel(3 + width, 5 + 2 * height)


def test_the_list_of_worst_texels_leads_to_them(filled: MainWindow, qtbot: Any) -> None:
    material = filled.bench.document.project.material
    rng = np.random.default_rng(1)
    assert material.power_law is not None
    errors = rng.uniform(0.0, 0.1, material.power_law.error_map.shape).astype(np.float32)
    import dataclasses

    power_law = dataclasses.replace(material.power_law, error_map=errors)
    filled.bench.document.change("Errors", material=dataclasses.replace(material, power_law=power_law))
    assert power_law is not None
    tab, expected = filled.material, worst_texels(power_law, WORST_SHOWN)
    qtbot.waitUntil(lambda: tab.worst_texels.texels == expected, timeout=60_000)
    worst = expected[2]
    qtbot.mouseClick(tab.worst_texels.links[2], Qt.MouseButton.LeftButton)
    assert tab.image.probe == (worst.column, worst.row)
    middle = QPoint(tab.image.width() // 2, tab.image.height() // 2)
    assert tab.image.texel_at(middle.toPointF()) == (worst.column, worst.row)
    assert tab.texel_figures.residual.text() == number(worst.error, 3)
    exponent = "   ".join(f"{value:.2f}" for value in power_law.exponent[worst.row, worst.column])
    assert tab.texel_figures.exponent.text() == exponent


def test_a_number_of_slices_that_is_not_on_the_list_is_shown_and_stays(filled: MainWindow) -> None:
    document = filled.bench.document
    count = document.undo_stack.count()
    document.change("From a bundle", slices=10)
    assert filled.material.slices.currentText() == "10"
    assert document.project.slices == 10
    assert document.undo_stack.count() == count + 1


def test_disabled_choices_say_why_and_find_their_words_again(filled: MainWindow) -> None:
    tab, stack = filled.material, filled.bench.document.project.stack
    choices = (tab.slices, tab.scale, tab.bits, *tab.mode.buttons.values(), *tab.tiling.edges.buttons.values())
    words = [box.toolTip() for box in choices]
    assert all(words)
    filled.bench.document.change("Bundle", stack=None)
    assert {box.toolTip() for box in choices} == {"Needs the photographs of the capture"}
    assert not any(box.isEnabled() for box in choices)
    filled.bench.document.change("Capture", stack=stack)
    assert [box.toolTip() for box in choices] == words


def test_the_curve_of_a_kept_texel_goes_through_its_slices(filled: MainWindow, qtbot: Any) -> None:
    filled.bench.document.change("Mixed", mixed=True, error_bound_percent=0.0)
    rebuild(filled, qtbot)
    tab, shading_map = filled.material, filled.bench.document.project.material.shading_map
    assert tab.place is not None
    column, row = tab.place
    r, curve = tab.texel.curves[0].getData()
    assert shading_map is not None
    expected = np.interp(r, shading_map.target_radiance, shading_map.slices[:, row, column, 0])
    assert np.abs(curve - expected).max() < 1e-6


def test_a_smaller_material_may_come_while_the_workspace_still_follows_the_last_one(filled: MainWindow) -> None:
    """Behind another workspace it is told part by part; the texel in the middle of the last one lies outside."""
    document, tab = filled.bench.document, filled.material
    filled.show_workspace("view")
    document.change("Weave", material=weave(32))
    assert tab.following.tell_a_part(), "figures, and not yet the plots"
    document.change("Weave", material=weave(8))
    tab.following.catch_up()
    assert tab.place == (4, 4)
    assert tab.resolution.text() == "8 × 8 px"
