"""The View workspace: modes, the reference that refines at rest, wipe and difference, lamps, ground, and the mesh."""

from __future__ import annotations

import dataclasses
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QImage, QKeySequence
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QWidget

from app.document.modes import modes
from app.view.images import reference_size
from app.viewport.gl_surface import GlSurface
from app.widgets.fitting import Fitting
from app.window.main_window import MainWindow
from engine.core.colour import srgb_encode
from engine.geometry.brushing import Brushing
from engine.geometry.shapes import shape
from engine.light.lamps import LampSettings
from engine.render.display import diverging
from engine.shading.shading_map import ShadingMap
from tests.engine.scenes import weave
from tests.present import present

LONG = 90_000


@pytest.fixture
def view(window: MainWindow, qtbot: Any) -> MainWindow:
    """A plane that faces the viewer, in the View workspace, with a BRDF of its own and a material."""
    window.resize(1120, 700)
    document = window.bench.document
    look = dataclasses.replace(document.project.look, light_theta_deg=90.0, light_phi_deg=0.0, tone_map="none")
    material = dataclasses.replace(weave(16), brdf="lambert:albedo=0.5")
    document.change("Plane", mesh=shape("plane"), look=look, material=material)
    window.show_workspace("view")
    wait(qtbot, lambda: window.view.viewport.surface.is_finished)
    return window


def wait(qtbot: Any, done: Callable[[], bool]) -> None:
    qtbot.waitUntil(done, timeout=LONG)


def show(window: MainWindow) -> QImage:
    return cast(Any, window.view.viewport.surface).grabFramebuffer()


def pixel(image: QImage, share_x: float, share_y: float) -> np.ndarray:
    colour = image.pixelColor(int(image.width() * share_x), int(image.height() * share_y))
    return np.array([colour.red(), colour.green(), colour.blue()])


def press(window: MainWindow, key: str) -> None:
    """Without a window manager no window is active and no key arrives: the action that the key belongs to is run."""
    (action,) = (
        action
        for action in (*window.view.actions(), *window.view.viewport.actions())
        if action.shortcut() == QKeySequence(key)
    )
    action.trigger()


def change(window: MainWindow, **parts: Any) -> None:
    document = window.bench.document
    document.change("Look", look=dataclasses.replace(document.project.look, **parts))


def look(window: MainWindow) -> Any:
    return window.bench.document.project.look


def code(radiance: float) -> float:
    return 255.0 * float(srgb_encode(radiance))


def test_modes_have_keys_of_their_own_and_a_lit_segment(view: MainWindow, qtbot: Any) -> None:
    assert len({mode.key for mode in modes()}) == len(modes())
    count = view.bench.document.undo_stack.count()
    by_value = {mode.value: mode for mode in modes()}
    for mode in (by_value[value] for value in ("direct", "reference", "shading-map", "direct")):
        press(view, mode.key)
        assert look(view).mode == mode.value
        assert view.view.mode.value == mode.value
    assert view.bench.document.undo_stack.count() == count + 1, "one step for all that was tried"
    wait(qtbot, lambda: view.view.viewport.surface.is_finished)
    expected = code(0.5 / np.pi * look(view).irradiance)
    assert np.abs(pixel(show(view), 0.5, 0.45) - expected).max() <= 2, "the reflectance without the map"
    view.undo.trigger()
    assert view.view.mode.value == "shading-map"


def test_a_mode_that_cannot_be_shown_says_why_and_another_is_shown(view: MainWindow) -> None:
    material = dataclasses.replace(view.bench.document.project.material, shading_map=None, power_law=None)
    view.bench.document.change("No map", material=material)
    button = view.view.mode.buttons["shading-map"]
    assert not button.isEnabled()
    assert "material" in button.toolTip()
    assert view.view.mode.value == "direct"
    press(view, "M")
    assert view.view.mode.value == "direct"
    change(view, mode="direct", against="shading-map", comparing="wipe")
    assert view.view.viewport.other is None
    assert not view.view.compare.shown.buttons["wipe"].isEnabled()


def test_the_reference_refines_at_rest_and_gives_way_at_once(view: MainWindow, qtbot: Any) -> None:
    images, surface = view.view.images, view.view.viewport.surface
    change(view, mode="direct", against="shading-map")
    press(view, "R")
    assert cast(Any, surface).scene is not None, "what stands for it is drawn meanwhile"
    wait(qtbot, lambda: images.reference.found is not None and images.reference.found.variance is not None)
    assert "samples" in view.view.images.progress
    assert "±" in view.view.images.progress
    wait(qtbot, lambda: cast(Any, present(surface._over[0])).pixels is not None)
    assert images.reference.found is not None
    image = images.reference.found.image
    assert (image.shape[1], image.shape[0]) == reference_size(view.view.viewport.screen_px())
    qtbot.wait(100)
    expected = code_colour(image[image.shape[0] // 2, image.shape[1] // 2, :3])
    assert np.abs(pixel(show(view), 0.5, 0.5) - expected).max() <= 3
    job = images.reference._job
    view.view.viewport.turn(0.1, 0.0)
    assert images.reference.found is None
    assert present(surface._over[0]).pixels is None
    assert job is None or job.stopping or job.over
    wait(qtbot, lambda: images.reference.running)
    view.view.stop.trigger()
    assert not images.reference.running
    assert "stopped" in view.view.images.progress
    view.view.stop.trigger()
    assert images.reference.running
    view.show_workspace("capture")
    assert not images.reference.running
    view.show_workspace("view")
    wait(qtbot, lambda: images.reference.running)


def test_the_reference_lies_over_no_mode_but_its_own(view: MainWindow, qtbot: Any) -> None:
    """The same scene stands for the reference and is the other mode: what covered it goes when the modes change."""
    surface = view.view.viewport.surface
    change(view, mode="shading-map")
    wait(qtbot, lambda: surface.is_finished)
    whole = pixels_of(show(view))
    press(view, "R")
    wait(qtbot, lambda: cast(Any, present(surface._over[0])).pixels is not None)
    change(view, mode="shading-map", against="reference", comparing="wipe")
    wait(qtbot, lambda: cast(Any, present(surface._over[1])).pixels is not None and surface.is_finished)
    qtbot.wait(100)
    image = pixels_of(show(view))
    left = image.shape[1] // 3
    assert np.array_equal(image[:, :left], whole[:, :left])
    assert not np.array_equal(image[:, -left:], whole[:, -left:]), "the reference is another image"


def code_colour(colour: np.ndarray) -> np.ndarray:
    return 255.0 * np.asarray(srgb_encode(np.clip(colour, 0.0, 1.0)))


def test_a_change_of_light_restarts_the_reference_and_one_of_exposure_does_not(view: MainWindow, qtbot: Any) -> None:
    reference = view.view.images.reference
    press(view, "R")
    wait(qtbot, lambda: reference.found is not None)
    found = reference.found
    change(view, exposure_ev=1.0)
    assert reference.found is not None
    assert found is not None
    assert reference.found.samples >= found.samples
    change(view, irradiance=5.0)
    assert reference.found is None
    wait(qtbot, lambda: reference.running)


def test_a_computation_makes_the_reference_wait(view: MainWindow, qtbot: Any) -> None:
    from engine.core.steps import Step

    go: list[Any] = []

    def computing() -> Any:
        while not go:
            yield Step(0.0, "working")

    press(view, "R")
    wait(qtbot, lambda: view.view.images.reference.running)
    job = view.bench.jobs.submit("Working", computing, lane="compute")
    wait(qtbot, lambda: present(view.view.images.reference._job).state == "queued")
    go.append(True)
    wait(qtbot, lambda: job.over)
    wait(qtbot, lambda: view.view.images.reference._job is None or view.view.images.reference._job.state == "running")


def test_the_wipe_shows_each_mode_on_its_side_and_is_dragged(view: MainWindow, qtbot: Any) -> None:
    viewport = view.view.viewport
    change(view, mode="direct", against="shading-map", comparing="wipe", irradiance=1.0)
    wait(qtbot, lambda: viewport.surface.is_finished)
    whole = {}
    for mode in ("direct", "shading-map"):
        change(view, mode=mode, comparing="")
        wait(qtbot, lambda: viewport.surface.is_finished)
        whole[mode] = pixels_of(show(view))
    change(view, mode="direct", against="shading-map", comparing="wipe")
    wait(qtbot, lambda: viewport.surface.is_finished)
    line = QPoint(viewport.width() // 2, viewport.height() - 30)
    for share in (0.5, 0.25):
        drag(
            viewport,
            QPoint(round(view.view.images.wipe * viewport.width()), line.y()),
            QPoint(round(share * viewport.width()), line.y()),
        )
        assert view.view.images.wipe == pytest.approx(share, abs=0.01)
        image = pixels_of(show(view))
        middle = round(view.view.images.wipe * image.shape[1])
        assert np.array_equal(image[:, :middle], whole["direct"][:, :middle])
        assert np.array_equal(image[:, middle:], whole["shading-map"][:, middle:])
    press(view, "Tab")
    assert (look(view).mode, look(view).against) == ("shading-map", "direct")
    wait(qtbot, lambda: viewport.surface.is_finished)
    assert np.array_equal(pixels_of(show(view))[:, :20], whole["shading-map"][:, :20])
    press(view, "B")
    assert look(view).comparing == ""
    assert viewport.overlay.wipe is None


def pixels_of(image: QImage) -> np.ndarray:
    image = image.convertToFormat(QImage.Format.Format_RGB888)
    rows = np.frombuffer(image.constBits(), np.uint8).reshape(image.height(), image.bytesPerLine())
    return rows[:, : 3 * image.width()].reshape(image.height(), image.width(), 3).copy()


def drag(widget: QWidget, start: QPoint, end: QPoint) -> None:
    keys = Qt.KeyboardModifier.NoModifier
    QTest.mousePress(widget, Qt.MouseButton.LeftButton, keys, start)
    for step in range(1, 6):
        QTest.mouseMove(widget, start + (end - start) * step / 5)
    QTest.mouseRelease(widget, Qt.MouseButton.LeftButton, keys, end)


def test_the_error_of_two_modes_is_that_of_their_images(view: MainWindow, qtbot: Any) -> None:
    """A flat material of radiance 0.1 against a BRDF of 0.5 / π, both even: the error is their ratio less 1."""
    material = view.bench.document.project.material
    even = ShadingMap(np.full((2, 4, 4, 3), 0.1, np.float32), 1.0, np.full(2, 0.1))
    flat = dataclasses.replace(material, shading_map=even, power_law=None, sigma=1.0)
    view.bench.document.change("Even", material=flat)
    change(view, mode="shading-map", against="direct", irradiance=1.0, comparing="difference")
    wait(qtbot, lambda: view.view.images.error is not None and view.view.images.error.flip is not None)
    error, reflectance = view.view.images.error, 0.5 / np.pi
    assert error is not None
    assert error.rmse_rel == pytest.approx(1.0 - 0.1 / reflectance, rel=1e-3)
    assert error.max_abs == pytest.approx(reflectance - 0.1, rel=1e-3)
    assert error.uncertainty == 0.0
    assert view.view.compare.error.text() == error.text
    assert view.status.error.text() == f"error {view.view.compare.error.text()} (Material against Direct)"
    assert "Material against Direct" in view.status.error.toolTip()
    assert float(view.view.compare.flip.text().strip("≈ ")) > 0.01
    qtbot.wait(100)
    assert view.view.viewport.overlay.scale == error.scale
    expected = diverging(np.array((0.1 - reflectance) / error.scale)).astype(int)
    assert np.abs(pixel(show(view), 0.5, 0.45) - expected).max() <= 2
    view.view.viewport.turn(0.2, 0.0)
    assert view.view.images.error is None
    assert view.view.compare.error.text() == "–"
    view.view.images.measure(True)
    change(view, comparing="")
    assert view.status.error.toolTip().startswith("Measured against a reference")
    view.show_workspace("material")
    assert view.status.error.toolTip().startswith("Error of the compressed")


def test_the_error_against_the_reference_states_its_uncertainty_and_it_falls(
    view: MainWindow, qtbot: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("app.view.images.FINE_ENOUGH", 0.0)
    change(view, mode="direct", against="reference", comparing="wipe")
    lamp = LampSettings(theta_deg=80.0, phi_deg=30.0, radius_deg=3.0)
    change(view, lamps=(lamp,), mode="shading-map")
    images = view.view.images
    wait(qtbot, lambda: images.error is not None)
    first = images.error
    assert first is not None
    assert first.uncertainty > 0.0
    assert "±" in view.status.error.text()
    wait(qtbot, lambda: images.error is not None and images.error.uncertainty < present(first).uncertainty)
    assert images.error is not None
    assert images.error.rmse_rel < 0.05, "nothing shadows a plane: both are the same light"


def test_lamps_are_added_dragged_changed_and_removed_one_step_each(view: MainWindow, qtbot: Any) -> None:
    lights, viewport, stack = view.view.lights, view.view.viewport, view.bench.document.undo_stack
    assert lights.lamps.remove.toolTip() == "There are no extra lights yet"
    count = stack.count()
    qtbot.mouseClick(lights.lamps.add, Qt.MouseButton.LeftButton)
    qtbot.mouseClick(lights.lamps.add, Qt.MouseButton.LeftButton)
    assert stack.count() == count + 2
    assert viewport.scene is not None
    assert len(viewport.scene.lamps) == 2
    assert len({lamp.direction for lamp in viewport.scene.lamps}) == 2
    assert [handle.lamp for handle in viewport.overlay.handles] == [None, 0, 1]
    place = present(viewport.overlay.handle(1)).toPoint()
    drag(viewport, place, place + QPoint(-60, 30))
    assert stack.count() == count + 3
    assert lights.lamps.chosen == 1
    assert (
        np.hypot(*(lambda p: (p.x(), p.y()))(present(viewport.overlay.handle(1)) - QPointF(place + QPoint(-60, 30))))
        < 3
    )
    assert lights.lamps.form.instance == look(view).lamps[1]
    cast(Any, lights.lamps.form.editors["radius_deg"]).field.edited.emit(12.0, True)
    assert look(view).lamps[1].radius_deg == 12.0
    assert viewport.scene.lamps[1].radius == pytest.approx(np.radians(12.0))
    assert stack.count() == count + 4
    qtbot.mouseClick(lights.lamps.remove, Qt.MouseButton.LeftButton)
    assert len(look(view).lamps) == 1
    for _ in range(5):
        view.undo.trigger()
    assert look(view).lamps == ()
    assert viewport.scene.lamps == ()


def test_a_near_lamp_is_added_dragged_changed_and_removed_one_step_each(view: MainWindow, qtbot: Any) -> None:
    near, viewport, stack = view.view.lights.near, view.view.viewport, view.bench.document.undo_stack
    assert near.remove.toolTip() == "There are no near lights yet"
    count = stack.count()
    qtbot.mouseClick(near.add, Qt.MouseButton.LeftButton)
    assert stack.count() == count + 1
    lamp = look(view).near_lamps[0]
    assert present(viewport.scene).near_lamps == (lamp.lamp,)
    change(view, mode="sh")
    assert "does not show near lights" not in view.view.hint.text()
    assert not view.view.images.why_no_error
    change(view, comparing="wipe", against="wavelet")
    assert "Wavelets does not show near lights" in view.view.hint.text()
    assert "does not show the near lights, which the reference shows" in view.view.images.why_no_error
    view.undo.trigger()
    view.undo.trigger()
    assert "does not show near lights" not in view.view.hint.text()
    assert not view.view.images.why_no_error
    place = present(viewport.overlay.handle(0, near=True)).toPoint()
    drag(viewport, place, place + QPoint(-30, 40))
    assert stack.count() == count + 2
    moved = look(view).near_lamps[0]
    camera = present(viewport.camera)
    step = camera.camera_from_world @ (np.array([moved.x, moved.y, moved.z]) - (lamp.x, lamp.y, lamp.z))
    assert step[0] < 0.0
    assert step[1] < 0.0
    assert abs(step[2]) < 0.01 * np.hypot(step[0], step[1]), "as far from the viewer as before"
    reached = present(viewport.overlay.handle(0, near=True)) - QPointF(place + QPoint(-30, 40))
    assert np.hypot(reached.x(), reached.y()) < 3
    cast(Any, near.form.editors["power"]).field.edited.emit(7.0, True)
    assert look(view).near_lamps == (dataclasses.replace(moved, power=7.0),)
    assert stack.count() == count + 3
    shape = cast(Any, near.form.editors["shape"])
    shape.setCurrentIndex(shape.findData("rectangle"))
    shape.activated.emit(shape.currentIndex())
    assert present(viewport.scene).near_lamps[0].shape == "rectangle"
    [handle] = [each for each in viewport.overlay.handles if each.place is not None]
    assert np.mean(handle.outline, axis=0) == pytest.approx(handle.place)
    assert len(handle.outline) == 4
    assert near.form.editors["height"].isVisibleTo(near)
    assert not near.form.editors["radius"].isVisibleTo(near)
    qtbot.mouseClick(near.remove, Qt.MouseButton.LeftButton)
    assert look(view).near_lamps == ()
    for _ in range(5):
        view.undo.trigger()
    assert stack.index() == count
    assert look(view).near_lamps == ()


def test_lamps_alone_light_the_model(view: MainWindow, qtbot: Any) -> None:
    lamp = LampSettings(theta_deg=90.0, phi_deg=0.0, irradiance=0.8, colour=(1.0, 0.5, 0.25))
    change(view, mode="direct", lamps=(lamp,))
    box = view.view.lights.lighting
    box.setCurrentIndex(box.findText("Extra lights only"))
    box.activated.emit(box.currentIndex())
    assert look(view).only_lamps
    assert not view.view.lights.light.isVisible()
    wait(qtbot, lambda: view.view.viewport.surface.is_finished)
    expected = code_colour(0.5 / np.pi * 0.8 * np.array(lamp.colour))
    assert np.abs(pixel(show(view), 0.5, 0.45) - expected).max() <= 2
    view.undo.trigger()
    assert not look(view).only_lamps


def test_every_built_in_sky_is_offered_by_its_label(view: MainWindow) -> None:
    from engine.light.sky import SKIES

    box = view.view.lights.lighting
    offered = {box.itemData(place): box.itemText(place) for place in range(box.count())}
    assert {name: offered[name] for name in SKIES} == {name: sky.label for name, sky in SKIES.items()}


def test_the_ground_is_part_of_the_project_and_of_the_image(view: MainWindow, qtbot: Any) -> None:
    view.bench.document.change("Sphere", mesh=shape("sphere"))
    change(view, light_theta_deg=0.0, irradiance=1.0, mode="direct")
    count = view.bench.document.undo_stack.count()
    qtbot.mouseClick(view.view.model.ground, Qt.MouseButton.LeftButton, pos=QPoint(8, 12))
    assert look(view).has_ground
    assert view.view.model.albedo.isVisible()
    assert view.bench.document.undo_stack.count() == count + 1
    wait(qtbot, lambda: view.view.viewport.surface.is_finished)
    assert np.abs(pixel(show(view), 0.02, 0.98) - code(0.5 / np.pi)).max() <= 2
    view.undo.trigger()
    wait(qtbot, lambda: view.view.viewport.surface.is_finished)
    assert np.abs(pixel(show(view), 0.02, 0.98) - 0x18).max() <= 1


def test_an_anisotropic_brdf_is_brushed_in_another_direction(view: MainWindow, qtbot: Any) -> None:
    panel, document = view.view.model, view.bench.document
    assert not panel.brushing.isVisible()
    plain = dataclasses.replace(document.project.material, brdf="ggx:alpha_x=0.1,alpha_y=0.5,f0=0.9")
    document.change("Anisotropic", material=plain)
    assert panel.brushing.isVisible()
    count = document.undo_stack.count()
    panel.brushing.setCurrentIndex(panel.brushing.findText("Along Y"))
    panel.brushing.activated.emit(panel.brushing.currentIndex())
    wait(qtbot, lambda: document.undo_stack.count() == count + 1)
    assert present(document.project.mesh).brushing == Brushing((0.0, 1.0, 0.0))
    for angle_deg, is_final in ((10.0, False), (20.0, False), (30.0, True)):
        panel.angle.edited.emit(dataclasses.replace(panel.angle.instance, angle_deg=angle_deg), is_final)
    wait(qtbot, lambda: present(document.project.mesh).brushing == Brushing((0.0, 1.0, 0.0), 30.0))
    assert document.undo_stack.count() == count + 2
    view.undo.trigger()
    assert panel.brushing.currentText() == "Along Y"
    assert present(document.project.mesh).brushing.angle_deg == 0.0
    view.undo.trigger()
    assert panel.brushing.currentText() == "Along the texture"
    panel.angle.edited.emit(Brushing((0.0, 1.0, 0.0), 45.0), True)
    document.change("Another model", mesh=shape("sphere"))  # while the plane is being brushed
    wait(qtbot, lambda: not panel.brushed.busy)
    assert document.project.mesh is shape("sphere")


def test_what_is_doubtful_about_a_mesh_is_shown_and_it_is_flipped_in_one_step(
    view: MainWindow, qtbot: Any, tmp_path: Path
) -> None:
    sphere = shape("sphere")
    lines = [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in sphere.positions]
    lines += [f"f {a} {c} {b}" for a, b, c in sphere.faces + 1]
    (tmp_path / "inside-out.obj").write_text("\n".join(lines))
    view.bench.load_model(str(tmp_path / "inside-out.obj"))
    wait(qtbot, lambda: present(view.bench.document.project.mesh).name == "inside-out")
    panel = view.view.model
    assert panel.report.health is not None
    assert [text for text in panel.report.health.warnings if "faces were turned" in text]
    assert panel.report.isVisible()
    assert panel.flip.isVisible()
    count = view.bench.document.undo_stack.count()
    qtbot.mouseClick(panel.flip, Qt.MouseButton.LeftButton)
    wait(qtbot, lambda: view.bench.document.undo_stack.count() == count + 1)
    mesh = view.bench.document.project.mesh
    assert mesh is not None
    assert np.mean(np.sum(mesh.normals * mesh.positions, axis=1) < 0) > 0.99
    view.undo.trigger()
    assert panel.flip.isVisible()
    view.bench.document.change("Sphere", mesh=sphere)
    assert not panel.flip.isVisible()


def test_GL5_without_opengl_two_modes_are_computed_and_compared(
    qapp: QApplication, qtbot: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("app.viewport.viewport.why_no_gl", lambda: "OpenGL is not available")
    window = MainWindow(None)
    window.resize(1120, 700)
    window.show()
    qtbot.waitExposed(window)
    window.bench.document.change("Plane", mesh=shape("plane"), material=weave(16))
    window.show_workspace("view")
    change(window, mode="shading-map", against="direct", comparing="wipe")
    assert "OpenGL is not available" in window.view.viewport.banner.words.text()
    wait(qtbot, lambda: window.view.images.error is not None)
    assert window.view.images.error is not None
    assert window.view.images.error.rmse_rel > 0.05
    assert len(cast(Any, window.view.viewport.surface)._images) == 2
    change(window, comparing="difference")
    wait(qtbot, lambda: len(cast(Any, window.view.viewport.surface)._images) == 1)
    window.close()
    window.deleteLater()


def test_a_quiet_line_says_what_there_is_room_for(qapp: QApplication) -> None:
    line, forms = Fitting(), ("reference 64 samples, ± 0.8 %", "64 samples, ± 0.8 %", "± 0.8 %")
    line.show()
    line.say(*forms)
    metrics = line.fontMetrics()
    for form in forms:
        line.resize(metrics.horizontalAdvance(form) + 3, 20)
        assert line.text() == form
    line.resize(4, 20)
    assert line.text() == ""
    assert line.toolTip() == forms[0]
    line.close()


@pytest.mark.parametrize("size", [(1280, 800), pytest.param((2560, 1440), marks=pytest.mark.long)])
def test_no_words_of_the_view_are_cut_off(view: MainWindow, qtbot: Any, size: tuple[int, int]) -> None:
    lamps = (LampSettings(), LampSettings(phi_deg=70.0, radius_deg=5.0))
    change(view, mode="direct", comparing="wipe", lamps=lamps, has_ground=True)
    view.resize(*size)
    qtbot.wait(200)
    tab = view.view
    for button in (*tab.mode.buttons.values(), *tab.compare.shown.buttons.values()):
        wide = button.fontMetrics().horizontalAdvance(button.text())
        assert button.width() >= wide + 12, button.text()
    for panel in (tab.model, tab.lights, tab.brdf_panel, tab.lookup, tab.compare):
        area = present(panel.parentWidget()).parentWidget()
        assert area is not None
        assert panel.mapTo(area, QPoint(panel.width(), 0)).x() <= area.width(), "nothing reaches beyond its panel"
    assert tab.caption.width() >= tab.caption.fontMetrics().horizontalAdvance(tab.caption.text())


def test_GL6_a_lost_context_is_replaced_and_the_image_is_the_same_to_the_bit(view: MainWindow, qtbot: Any) -> None:
    """Moving the viewport to another window gives it another context, as a driver that was reset does."""
    viewport = view.view.viewport
    assert isinstance(viewport.surface, GlSurface)
    change(view, mode="direct", against="shading-map", comparing="wipe")
    wait(qtbot, lambda: viewport.surface.is_finished)
    before, context = pixels_of(show(view)), viewport.surface.gl
    viewport.surface.setParent(None)
    viewport.surface.show()
    qtbot.wait(50)
    viewport.surface.setParent(viewport)
    viewport.surface.lower()
    viewport.surface.show()
    viewport._place()
    viewport.redraw()
    wait(qtbot, lambda: viewport.surface.is_finished)
    assert viewport.surface.gl is not context
    assert np.array_equal(pixels_of(show(view)), before)


HIDPI = """
import sys
from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QApplication
from app.jobs.jobs import Jobs
from app.viewport.gl_surface import request_format
from app.viewport.viewport import Viewport
from tests.engine.scenes import head_on
request_format()
application = QApplication([])
viewport = Viewport(Jobs())
viewport.resize(203, 151)
viewport.show()
viewport.show_scene(head_on(), 0.0, "none", (90.0, 0.0))
watch = QTimer()
watch.timeout.connect(lambda: application.exit() if viewport.surface.is_finished else None)
watch.start(20)
QTimer.singleShot(60_000, application.exit)
application.exec()
drawn = viewport.surface._sides[0]
image = viewport.surface.grabFramebuffer()
print(viewport.devicePixelRatioF(), *drawn.image.size, *viewport.screen_px(), image.width(), image.height(),
      image.pixelColor(image.width() // 2, image.height() // 2).red())
"""


@pytest.mark.parametrize("scale", ["1.25", pytest.param("1.5", marks=pytest.mark.long), "2"])
def test_GL7_every_pixel_of_a_dense_screen_is_drawn(qapp: QApplication, scale: str) -> None:
    environment = {**os.environ, "QT_SCALE_FACTOR": scale, "PYTHONPATH": str(Path(__file__).resolve().parents[3])}
    done = subprocess.run(
        [sys.executable, "-c", HIDPI], capture_output=True, text=True, timeout=120, check=False, env=environment
    )
    assert done.returncode == 0, done.stderr
    ratio, *sizes, red = map(float, done.stdout.split())
    assert ratio == float(scale)
    expected = [int(203 * ratio + 0.5), int(151 * ratio + 0.5)]
    assert sizes == expected * 3
    assert red == pytest.approx(code(0.5 / np.pi), abs=2)
