"""The Material workspace of lamps on several sides: choice and errors, the dragged light, and the project's file."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt

from app.commands.bundle_view import settings_of_bundle
from app.material.candidates import verdict
from app.window.main_window import MainWindow
from engine.core.colour import srgb_encode
from engine.core.figure_text import number
from engine.scene.material import error_figures
from engine.shading.directional.planes import DirectionalMap
from tests.engine.domes import dome
from tests.present import present


@pytest.fixture
def filled(window: MainWindow, qtbot: Any) -> MainWindow:
    """A dome in the document, and the material that the window makes of it by itself."""
    window.bench.document.change("Import dome", stack=dome())
    window.show_workspace("material")
    window.bench.build_material()
    qtbot.waitUntil(lambda: window.bench.document.project.has_map, timeout=240_000)
    qtbot.waitUntil(lambda: not window.bench.jobs.active, timeout=60_000)
    return window


def planes_of(window: MainWindow) -> DirectionalMap:
    found = window.bench.document.project.material.directional
    assert found is not None
    return found


def test_a_dome_becomes_a_directional_material_with_its_errors(filled: MainWindow) -> None:
    page, found = filled.material.directional, planes_of(filled)
    assert filled.material.pages.currentWidget() is page
    shown = [[cell.text() for cell in line] for line in page.candidates.lines]
    assert [line[0] for line in shown] == ["Directional map", "Shading map", "Mean image"]
    assert shown[0][1:] == [number(found.leave_one_out, 3), number(found.in_sample, 3), str(len(found.planes))]
    assert shown[1][3] == str(12 * filled.bench.document.project.slices)
    assert shown[2][1] == number(found.mean_picture, 3)
    assert page.candidates.verdict.text() == verdict(page.candidates.rows)[0]
    assert page.planes.text() == str(len(found.planes))
    assert len(page.pad.lamps) == 12
    assert page.image.image is not None
    assert not page.build.isEnabled()
    assert "up to date" in page.build.toolTip()


def test_a_capture_from_a_dome_is_shown_flat_once_and_from_the_front(filled: MainWindow, qtbot: Any) -> None:
    view, document = filled.view, filled.bench.document
    rows, columns = document.project.material.size
    filled.show_workspace("view")
    qtbot.waitUntil(lambda: view.viewport.scene is not None, timeout=60_000)
    mesh = document.project.mesh
    assert mesh is not None
    width, height, depth = np.ptp(mesh.positions, axis=0)
    assert (width / height, depth) == (pytest.approx(columns / rows), 0.0)
    assert document.project.look.repeats == 1.0
    assert present(view.viewport.camera).forward == pytest.approx([0.0, 0.0, -1.0])
    assert view.model.model.currentText() == "Flat, once"
    assert view.model.repeats.isHidden()
    assert view.model.ground.isHidden()
    assert view.lookup.source.isHidden()
    assert view.varying.isHidden()
    assert not view.lights.near.isHidden()  # direct light shows them, also on a flat sample
    assert not view.mode.buttons["sh"].isEnabled()
    view.model.model.setCurrentIndex(view.model.model.findData("sphere"))
    view.model.model.activated.emit(view.model.model.currentIndex())
    qtbot.waitUntil(lambda: present(document.project.mesh).name == "sphere", timeout=60_000)
    assert document.project.look.repeats == 3.0
    assert not view.model.repeats.isHidden()
    assert view.mode.buttons["sh"].isEnabled()
    assert document.project.without_capture.get("mesh", "kept") == "kept"
    filled.undo.trigger()
    assert document.project.without_capture["mesh"] is None


def test_dragging_the_light_relights_the_image(filled: MainWindow, qtbot: Any) -> None:
    page = filled.material.directional
    before = page.image.image
    middle = QPoint(page.pad.width() // 2, page.pad.height() // 2)
    qtbot.mousePress(page.pad, Qt.MouseButton.LeftButton, pos=middle + QPoint(40, 0))
    assert page.pad.direction[0] > 0.3
    assert page.angles.text().startswith("Elevation ")
    assert page.angles.text().endswith("°, azimuth 0°")
    qtbot.waitUntil(lambda: page.image.image is not before, timeout=60_000)
    qtbot.keyClick(page.pad, Qt.Key.Key_Up)
    assert page.pad.direction[1] == pytest.approx(0.05)
    page.pad.move_to(3.0, 0.0)
    assert page.pad.direction == pytest.approx([1.0, 0.0, 0.0])


def test_exposure_brightens_the_image_alone(filled: MainWindow, qtbot: Any) -> None:
    page, steps = filled.material.directional, filled.bench.document.undo_stack.count()
    before = present(page.image.image)
    page.exposure.setFocus()
    page.exposure.selectAll()
    qtbot.keyClicks(page.exposure, "2")
    qtbot.keyClick(page.exposure, Qt.Key.Key_Return)
    qtbot.waitUntil(lambda: page.image.image is not before, timeout=60_000)
    qtbot.waitUntil(lambda: not filled.bench.jobs.active, timeout=60_000)
    found, height = planes_of(filled), before.size[1]
    wanted = np.clip(255.0 * srgb_encode(4.0 * found.image(page.pad.direction)), 0.0, 255.0)
    shown = [present(page.image.image).levels[0].pixelColor(3, row).green() for row in range(height)]
    assert np.abs(wanted[:, 3, 1] - shown).max() <= 1.0
    assert filled.bench.document.undo_stack.count() == steps


def test_a_shading_map_can_be_wished_for_and_the_wish_undone(filled: MainWindow, qtbot: Any) -> None:
    page, before = filled.material.directional, planes_of(filled)
    page.representation.setCurrentIndex(page.representation.findData("shading-map"))
    page.representation.activated.emit(page.representation.currentIndex())
    assert filled.bench.document.project.representation == "shading-map"
    qtbot.mouseClick(page.build, Qt.MouseButton.LeftButton)
    qtbot.waitUntil(lambda: filled.bench.document.project.material.shading_map is not None, timeout=240_000)
    assert filled.material.pages.currentIndex() == 1
    warnings = filled.bench.document.project.material.health.warnings
    assert any("brightness alone does not distinguish" in each for each in warnings)
    assert [each.name for each in filled.material.candidates.rows] == ["Shading map", "Mean image"]
    assert filled.material.candidates.verdict.text().startswith("Worse than the mean image")
    filled.undo.trigger()
    filled.undo.trigger()
    assert planes_of(filled) is before
    assert filled.bench.document.project.representation == "auto"
    assert filled.material.pages.currentWidget() is page


def test_planes_are_evened_and_cut_into_a_tile(window: MainWindow, qtbot: Any) -> None:
    window.bench.document.change("Import dome", stack=dome(height=24, width=28), tileable=True)
    window.show_workspace("material")
    window.bench.build_material()
    qtbot.waitUntil(lambda: window.bench.document.project.has_map, timeout=240_000)
    page, material = window.material.directional, window.bench.document.project.material
    assert window.material.pages.currentWidget() is page
    assert page.tiling.edges.value == "tileable"
    assert all(tile < whole for tile, whole in zip(material.size, (24, 28), strict=True))
    assert material.health.figures["unevenness"] > 0.0
    seams = material.health.figures["seam_error"]
    assert page.tiling.seams.text() == f"{number(seams, 3)} × inside"
    figures = error_figures(material)
    assert (figures["seam_error"], figures["tile_height_px"], figures["tile_width_px"]) == (seams, *material.size)
    assert settings_of_bundle(material, {})["tileable"]
    assert page.tiling.brightness.isEnabled()
    qtbot.mouseClick(page.tiling.edges.buttons["plain"], Qt.MouseButton.LeftButton)
    assert not window.bench.document.project.tileable
    assert not page.tiling.brightness.isEnabled()
    assert page.build.isEnabled()


def test_the_view_shows_planes_and_offers_no_slices(filled: MainWindow, qtbot: Any) -> None:
    filled.show_workspace("view")
    panel = filled.view.lookup
    assert not panel.source.buttons["slices"].isEnabled()
    assert "planes" in panel.source.buttons["slices"].toolTip()
    qtbot.waitUntil(lambda: filled.view.scene(filled.bench.document.project) is not None, timeout=60_000)
    scene = filled.view.scene(filled.bench.document.project)
    assert scene is not None
    assert scene.shading is planes_of(filled)


def test_planes_are_exported_and_opened_again(filled: MainWindow, qtbot: Any, tmp_path: Any) -> None:
    before = planes_of(filled)
    job = filled.bench.export(tmp_path / "dome.lightarc", frozenset({"planes"}), None)
    with qtbot.waitSignal(job.succeeded, timeout=120_000) as done:
        pass
    assert done.args[0].problems == ()
    from engine.bundle.bundle import open_bundle

    found = open_bundle(tmp_path / "dome.lightarc").directional
    assert found is not None
    assert np.array_equal(found.planes, before.planes)
