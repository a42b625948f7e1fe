"""The window as a user uses it: drop, look, build, view, export; and what must not end it."""

from __future__ import annotations

import dataclasses
import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
from PySide6.QtCore import QEvent, QPoint, QPointF, QSize, Qt
from PySide6.QtGui import QImage
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QLabel, QPushButton, QToolButton, QWidget

from app.jobs.jobs import Job
from app.viewport.gl_surface import GlSurface
from app.window.main_window import FRAME, MainWindow, failed_title, first_size
from app.window.top_bar import WORKSPACES
from benchmarks.app.faults import cut
from engine.brdf.brdf import brdf_from_text
from engine.capture.stack import ImageStack
from engine.core.colour import srgb_encode, to_display8, tone_map
from engine.core.errors import InputError
from engine.core.health import Finding, Health, Verdict
from engine.geometry.mesh import Mesh
from engine.geometry.shapes import shape

Drop = Callable[[QWidget, list[Path]], None]


def test_opening_the_window_loads_no_compiler_and_no_heavy_library() -> None:
    program = (
        "import sys, app.window.application\n"
        "print(*sorted({'numba', 'scipy', 'trimesh', 'rawpy', 'tifffile', 'OpenEXR', 'embreex'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60, check=False)
    assert (done.returncode, done.stdout.strip()) == (0, ""), done.stderr


def is_quiet(window: MainWindow) -> bool:
    """Nothing runs or waits; the reference that tells the error of an image may rest, half refined."""
    return all(job.state == "paused" for job in window.bench.jobs.active)


def at_rest(window: MainWindow) -> bool:
    return window.bench.document.project.has_map and is_quiet(window)


def wait(qtbot: Any, done: Callable[[], bool], timeout: int = 240_000) -> None:
    qtbot.waitUntil(done, timeout=timeout)


def dialogs(window: MainWindow) -> list[str]:
    return [f"{box.text()}\n{box.informativeText()}" for box in window.failures.open_dialogs.values()]


def make_whole(window: MainWindow) -> None:
    """All workspaces are there, and follow the document."""
    for name in WORKSPACES:
        getattr(window, name)
    assert window.is_whole


def pixel(image: QImage, share_x: float, share_y: float) -> np.ndarray:
    colour = image.pixelColor(int(image.width() * share_x), int(image.height() * share_y))
    return np.array([colour.red(), colour.green(), colour.blue()])


def test_drop_a_folder_look_build_view_and_export(
    window: MainWindow, qtbot: Any, drop: Drop, photographs: Path, tmp_path: Path
) -> None:
    make_whole(window)
    drop(window, [photographs])
    wait(qtbot, lambda: at_rest(window))
    project = window.bench.document.project
    assert dialogs(window) == []
    assert [row.elevation_deg for row in window.capture.list.photographs.rows] == pytest.approx([10, 30, 50, 70, 90])
    assert project.stack is not None
    assert set(window.capture.list.photographs.thumbnails) == set(project.stack.sources)
    assert project.name == "Felt sample"
    assert project.material.power_law is not None
    wait(qtbot, lambda: window.capture.image.image is not None)

    window.show_workspace("material")
    wait(qtbot, lambda: window.material.image.image is not None and is_quiet(window))
    assert window.material.image.image is not None
    shown = window.material.image.image.levels[0]
    shading_map = project.material.shading_map
    assert shading_map is not None
    expected = to_display8(tone_map(shading_map.slices[-1], 0.0, "none"))
    assert np.abs(pixel(shown, 0.5, 0.5) - expected[shown.height() // 2, shown.width() // 2].astype(int)).max() <= 1

    window.show_workspace("view")
    wait(qtbot, lambda: window.view.default_mesh is not None and window.view.viewport.scene is not None)

    window.show_workspace("export")
    window.bench.write_into(tmp_path)
    window.export.name.setText("felt.lightarc")
    qtbot.mouseClick(window.export.export, Qt.MouseButton.LeftButton)
    wait(qtbot, lambda: "verified" in window.export.verdict.text())
    assert (tmp_path / "felt.lightarc").is_file()
    assert dialogs(window) == []

    window.new()
    drop(window, [tmp_path / "felt.lightarc"])
    wait(qtbot, lambda: at_rest(window))
    restored = window.bench.document.project.material
    assert restored.shading_map is not None
    assert np.array_equal(restored.shading_map.slices, shading_map.slices)
    assert restored.power_law is not None
    assert np.array_equal(restored.power_law.exponent, project.material.power_law.exponent)


def test_undo_goes_back_before_the_material_and_redo_brings_it_again(
    window: MainWindow, qtbot: Any, drop: Drop, photographs: Path
) -> None:
    make_whole(window)
    drop(window, [photographs])
    wait(qtbot, lambda: at_rest(window))
    built = window.bench.document.project.material
    window.undo.trigger()
    assert not window.bench.document.project.has_map
    wait(qtbot, lambda: window.material.pages.currentWidget() is window.material.empty)
    window.redo.trigger()
    assert window.bench.document.project.material is built


def test_an_excluded_photograph_is_left_out_of_the_material(
    window: MainWindow, qtbot: Any, drop: Drop, photographs: Path
) -> None:
    drop(window, [photographs])
    wait(qtbot, lambda: at_rest(window))
    assert not window.capture.build.isEnabled()
    assert window.capture.build.toolTip() == "The material is up to date"
    window.capture.list.choose(4)
    window.capture.exclude.trigger()
    assert window.bench.document.project.excluded == {"felt_90deg.png"}
    assert window.capture.build.isEnabled()
    qtbot.mouseClick(window.capture.build, Qt.MouseButton.LeftButton)
    wait(qtbot, lambda: is_quiet(window) and not window.capture.build.isEnabled())
    project = window.bench.document.project
    assert project.material.shading_map is not None
    assert project.stack is not None
    assert project.material.shading_map.r_max == pytest.approx(project.stack.mean_radiance[3], rel=1e-5)


def test_a_bad_folder_says_what_is_wrong_and_the_program_goes_on(
    window: MainWindow, qtbot: Any, drop: Drop, photographs: Path, tmp_path: Path
) -> None:
    bad = tmp_path / "broken"
    bad.mkdir()
    whole = next(photographs.glob("*.png")).read_bytes()
    (bad / "a_10deg.png").write_bytes(whole[: len(whole) // 2])
    (bad / "b_20deg.png").write_bytes(whole)
    drop(window, [bad])
    wait(qtbot, lambda: len(dialogs(window)) == 1)
    assert "a_10deg.png" in dialogs(window)[0]
    assert "Traceback" not in dialogs(window)[0]
    drop(window, [photographs])
    wait(qtbot, lambda: at_rest(window))


def test_what_is_no_capture_is_refused_in_words(window: MainWindow, qtbot: Any, drop: Drop, tmp_path: Path) -> None:
    (tmp_path / "empty folder").mkdir()
    (tmp_path / "text").write_text("no image")
    for name in ("empty folder", "text", "missing"):
        drop(window, [tmp_path / name])
        wait(qtbot, lambda: len(dialogs(window)) == 1)
        assert name in dialogs(window)[0]
        assert window.bench.document.project.sources is None
        for box in tuple(window.failures.open_dialogs.values()):
            box.close()


def test_fault_19_an_exception_in_a_slot_opens_one_dialog_and_the_program_goes_on(
    window: MainWindow, qtbot: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    for hook in ("excepthook", "unraisablehook"):
        monkeypatch.setattr(sys, hook, getattr(sys, hook))
    monkeypatch.setattr(threading, "excepthook", threading.excepthook)
    window.failures.install()

    def faulty() -> None:
        raise ZeroDivisionError("a fault of ours")

    for _ in range(5):
        try:
            faulty()
        except ZeroDivisionError as error:
            sys.excepthook(type(error), error, error.__traceback__)
    thread = threading.Thread(target=faulty)
    thread.start()
    thread.join()
    wait(qtbot, lambda: len(dialogs(window)) == 1)
    assert "fault in Lightarc" in dialogs(window)[0]
    assert "ZeroDivisionError" in window.docks.log.words.toPlainText()
    window.show_workspace("view")
    assert window.isVisible()


def test_fault_19_an_error_while_painting_opens_one_dialog_and_the_next_scene_is_drawn(
    window: MainWindow, qtbot: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    def find_broken(*_arguments: object, **_options: object) -> None:
        raise RuntimeError("the driver is in a bad mood")

    with monkeypatch.context() as patch:
        patch.setattr("engine.gl.direct.DirectRenderer.bands", find_broken)
        flat_material(window, 2.0)
        window.show_workspace("view")
        for phi in range(3):
            turn_light(window, float(phi))
            qtbot.wait(40)
        wait(qtbot, lambda: len(dialogs(window)) == 1)
    assert "cannot be drawn" in dialogs(window)[0]
    turn_light(window, 0.0)
    qtbot.wait(100)
    assert pixel(cast(Any, window.view.viewport.surface).grabFramebuffer(), 0.5, 0.45).min() > 100


def turn_light(window: MainWindow, phi_deg: float) -> None:
    document = window.bench.document
    document.change("Light", look=dataclasses.replace(document.project.look, light_phi_deg=phi_deg))


def flat_material(window: MainWindow, radiance: float) -> None:
    """A plane with a Lambertian BRDF under a light from the front, and no shading map."""
    document = window.bench.document
    look = dataclasses.replace(
        document.project.look,
        light_theta_deg=90.0,
        light_phi_deg=0.0,
        irradiance=radiance,
        tone_map="none",
    )
    material = dataclasses.replace(document.project.material, brdf="lambert:albedo=0.5")
    document.change("Flat", mesh=shape("plane"), look=look, material=material)


@pytest.mark.parametrize("light_deg", [pytest.param(0.0, marks=pytest.mark.long), 60.0])
def test_the_viewport_shows_what_the_numbers_predict(window: MainWindow, qtbot: Any, light_deg: float) -> None:
    flat_material(window, 2.0)
    turn_light(window, light_deg)
    window.show_workspace("view")
    surface = window.view.viewport.surface
    assert isinstance(surface, GlSurface), "the window found no OpenGL 3.3"
    wait(qtbot, lambda: window.view.viewport.camera is not None)
    qtbot.wait(100)
    expected = 255 * float(srgb_encode(0.5 / np.pi * np.cos(np.radians(light_deg)) * 2.0))
    image = surface.grabFramebuffer()
    middle = pixel(image, 0.5, 0.45)
    assert np.abs(middle - expected).max() <= 2, (middle, expected)
    corner = pixel(image, 0.01, 0.01)
    assert np.abs(corner - 0x18).max() <= 1


def test_orbit_light_drag_and_frame(window: MainWindow, qtbot: Any) -> None:
    flat_material(window, 1.0)
    window.show_workspace("view")
    viewport = window.view.viewport
    qtbot.wait(50)
    start, count = viewport.camera, window.bench.document.undo_stack.count()
    assert start is not None
    drag(viewport, QPoint(200, 300), QPoint(260, 310))
    assert viewport.camera != start
    assert viewport.camera is not None
    assert viewport.camera.up == (0.0, 1.0, 0.0)
    assert window.bench.document.undo_stack.count() == count
    window.view.frame_action.trigger()
    assert viewport.camera == start
    drag(viewport, QPoint(200, 300), QPoint(260, 310), Qt.KeyboardModifier.ControlModifier)
    look = window.bench.document.project.look
    assert look.light_phi_deg == pytest.approx(180.0 * 60 / viewport.height(), abs=0.5)
    assert window.bench.document.undo_stack.count() == count + 1
    handle = viewport.overlay.handle()
    assert handle is not None
    drag(viewport, handle.toPoint(), (handle + QPointF(-40, 20)).toPoint())
    assert window.bench.document.undo_stack.count() == count + 2
    window.undo.trigger()
    assert window.bench.document.project.look == look


def drag(
    widget: QWidget, start: QPoint, end: QPoint, keys: Qt.KeyboardModifier = Qt.KeyboardModifier.NoModifier
) -> None:
    QTest.mousePress(widget, Qt.MouseButton.LeftButton, keys, start)
    for step in range(1, 11):
        QTest.mouseMove(widget, start + (end - start) * step / 10)
    QTest.mouseRelease(widget, Qt.MouseButton.LeftButton, keys, end)


def test_GL7_the_viewport_survives_any_size(window: MainWindow, qtbot: Any) -> None:
    flat_material(window, 1.0)
    window.show_workspace("view")
    viewport = window.view.viewport
    qtbot.wait(50)
    for width, height in ((0, 0), (1, 1), (3, 400), (640, 480)):
        viewport.setMinimumSize(0, 0)
        viewport.resize(width, height)
        viewport.surface.repaint()
        QApplication.processEvents()
    assert viewport.camera is not None
    assert dialogs(window) == []


def test_GL9_changes_of_brdf_leave_no_widgets_behind(window: MainWindow, qtbot: Any) -> None:
    flat_material(window, 1.0)
    window.show_workspace("view")
    models = ("phong", "ggx", "lambert", "blinn-phong")
    for name in models:
        window.view.brdf_panel.set_brdf(brdf_from_text(name), name, "")
        qtbot.wait(20)
    before = len(window.view.findChildren(QWidget))
    for turn in range(12):
        window.view.brdf_panel.set_brdf(brdf_from_text(models[turn % 4]), "change", "")
        QApplication.processEvents()
    qtbot.wait(20)
    assert abs(len(window.view.findChildren(QWidget)) - before) <= 20


def test_GL5_without_opengl_a_banner_says_so_and_the_cpu_draws(
    qapp: QApplication, qtbot: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("app.viewport.viewport.why_no_gl", lambda: "OpenGL is 2.1, and 3.3 is needed")
    window = MainWindow(None)
    window.show()
    window.resize(1120, 700)
    flat_material(window, 2.0)
    window.show_workspace("view")
    viewport = window.view.viewport
    assert not viewport.banner.isHidden()
    assert "2.1" in viewport.banner.words.text()
    wait(qtbot, lambda: len(cast(Any, viewport.surface)._images) > 0)
    wait(qtbot, lambda: is_quiet(window))
    qtbot.wait(100)
    wait(qtbot, lambda: is_quiet(window))
    expected = 255 * float(srgb_encode(0.5 / np.pi * 2.0))
    assert np.abs(pixel(cast(Any, viewport.surface)._images[0], 0.5, 0.45) - expected).max() <= 2
    window.close()
    remove(window)


def remove(*windows: MainWindow) -> None:
    """Delete windows that are closed: those that stay would be dressed again with each theme of the tests after."""
    for window in windows:
        window.deleteLater()
    QApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete)


def fill(window: MainWindow) -> None:
    """A small stack with findings of every kind and its material, put into the document as jobs would."""
    from engine.core.steps import drain
    from engine.scene.material import Material
    from engine.shading.power_law import fit
    from engine.shading.shading_map import build

    share = np.sin(np.radians([10.0, 30.0, 50.0, 70.0, 90.0]))
    pattern = np.random.default_rng(3).uniform(0.2, 0.9, (48, 64, 3))
    radiance = (share[:, None, None, None] * pattern).astype(np.float32)
    from engine.core.colour import luminance

    names = tuple(f"a rather long name of a photograph {angle}.tif" for angle in (10, 30, 50, 70, 90))
    findings = tuple(Finding(verdict, "has something to say about itself", names[0]) for verdict in Verdict)
    stack = ImageStack(
        radiance=radiance,
        saturated=radiance[..., 0] > 0.85,
        elevation=np.radians([10.0, 30.0, 50.0, 70.0, 90.0]),
        azimuth=None,
        mean_radiance=luminance(radiance).mean(axis=(1, 2), dtype=np.float64),
        sources=names,
        angle_source="assumed",
        health=Health(findings=findings),
    )
    shading_map = drain(build(stack, 4))
    material = Material(shading_map, drain(fit(shading_map)), elevation_deg=(10.0, 90.0), name="Test")
    window.bench.document.change("Fill", stack=stack, material=material, name="Test", mesh=shape("sphere"))


@pytest.mark.parametrize(
    ("size", "filled"),
    [
        ((1280, 720), False),
        ((1120, 700), True),
        *(
            pytest.param(size, filled, marks=pytest.mark.long)
            for size, filled in (((1280, 720), True), ((1120, 700), False))
        ),
    ],
)
def test_no_words_are_cut_off(window: MainWindow, qtbot: Any, filled: bool, size: tuple[int, int]) -> None:
    if filled:
        fill(window)
    window.resize(*size)
    for name in WORKSPACES:
        window.show_workspace(name)
        wait(qtbot, lambda: is_quiet(window))
        qtbot.wait(60)
        for kind in (QLabel, QPushButton, QToolButton):
            for widget in window.findChildren(kind):
                if widget.isVisible() and cast(Any, widget).text():
                    assert_readable(widget, name)
        assert cut(window) == [], name  # fields as well, and what lies beside a scroll bar
    window.export.show_form("elsewhere")
    wait(qtbot, lambda: is_quiet(window))
    qtbot.wait(60)
    assert cut(window) == []


def assert_readable(widget: Any, workspace: str) -> None:
    what = f"{workspace}: {widget.text()!r}"
    if isinstance(widget, QLabel) and widget.wordWrap():
        assert widget.height() >= widget.heightForWidth(widget.width()), what
    else:
        assert widget.width() >= widget.sizeHint().width() - 1, what
        assert widget.height() >= widget.sizeHint().height() - 1, what
    parent = widget.parentWidget()
    while parent is not None and not parent.isWindow():
        place = widget.mapTo(parent, QPoint(0, 0))
        assert place.x() >= 0, what
        assert place.x() + widget.width() <= parent.width(), what
        parent = parent.parentWidget()


def test_every_disabled_button_says_why(window: MainWindow, qtbot: Any) -> None:
    fill(window)
    for name in WORKSPACES:
        window.show_workspace(name)
        for button in window.findChildren(QPushButton):
            if button.isVisible() and not button.isEnabled():
                assert len(button.toolTip()) > 10, button.text()


def test_a_finding_leads_to_its_photograph(window: MainWindow, qtbot: Any) -> None:
    fill(window)
    window.capture.list.choose(3)
    assert window.bench.document.project.stack is not None
    window.capture.report.show_source.emit(window.bench.document.project.stack.sources[0])
    assert window.capture.list.currentIndex().row() == 0


def test_recent_files_and_theme_are_remembered(
    qapp: QApplication, qtbot: Any, photographs: Path, tmp_path: Path
) -> None:
    from app.widgets import theme

    window = MainWindow(tmp_path)
    window.show()
    window.open([photographs])
    window.set_theme("light")
    window.close()
    again = MainWindow(tmp_path)
    assert again.settings.now.recent_files == (str(photographs),)
    assert again.settings.now.theme == "light"
    again.close()
    remove(window, again)
    theme.apply(qapp, "dark")


def test_a_project_has_the_name_of_its_capture_before_that_is_read(
    window: MainWindow, qtbot: Any, photographs: Path
) -> None:
    """So that a crash in the middle of the import leaves one that a user knows again."""
    names = []
    window.bench.document.changed.connect(lambda _old, new: names.append((new.name, new.stack is None)))
    window.open([photographs])
    wait(qtbot, lambda: bool(names))
    assert names[0] == ("Felt sample", True)


def test_closing_while_a_job_runs_removes_the_working_folder(window: MainWindow, qtbot: Any, photographs: Path) -> None:
    window.open([photographs])
    wait(qtbot, lambda: window.bench.importing is not None)
    folder = window.bench.folder
    assert folder.is_dir()
    window.close()
    assert not folder.exists()


def test_keys_reach_the_workspace_that_comes_to_the_front(window: MainWindow) -> None:
    """Shortcuts of a workspace hold where the focus is in it; the one that had it before gets it back."""
    for name in [*WORKSPACES, "capture"]:
        window.show_workspace(name)
        tab, focus = window.tabs[name], window.focusWidget()
        assert focus is tab or tab.isAncestorOf(focus), name
    window.capture.list.setFocus()
    window.show_workspace("view")
    window.show_workspace("capture")
    assert window.focusWidget() is window.capture.list


def test_a_mesh_is_recognised_and_shown(window: MainWindow, qtbot: Any, drop: Drop, tmp_path: Path) -> None:
    path = tmp_path / "triangle.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    make_whole(window)
    drop(window, [path])
    wait(qtbot, lambda: isinstance(window.bench.document.project.mesh, Mesh))
    assert window.stack.currentWidget() is window.view
    assert window.view.viewport.scene is not None
    assert len(window.view.viewport.scene.mesh.faces) == 1


@pytest.mark.parametrize(
    ("name", "state"), [("Woven sample", "read-only"), ("Linen " * 12, "not saved"), ("A" * 60, "")]
)
def test_a_long_title_yields_to_the_workspaces(window: MainWindow, qtbot: Any, name: str, state: str) -> None:
    window.resize(1024, 700)
    bar = window.bar
    qtbot.waitUntil(lambda: bar.width() == 1024)
    wide = [button.sizeHint().width() for button in bar.buttons.buttons()]
    bar.show_title(name, state)
    buttons = bar.buttons.buttons()
    assert all(button.width() >= room for button, room in zip(buttons, wide, strict=True))
    assert bar.title.text().startswith(name[:3])
    assert bar.title.text().endswith(state or "…")
    assert bar.title.fontMetrics().horizontalAdvance(bar.title.text()) <= bar.title.width()


@pytest.mark.parametrize("screen", [(1280, 720), (1366, 768), (1920, 1080), (3840, 2160)])
def test_a_first_window_with_its_frame_is_no_larger_than_the_screen(screen: tuple[int, int]) -> None:
    size = first_size(QSize(*screen))
    assert size.width() <= screen[0]
    assert size.height() + FRAME <= screen[1]


def test_the_title_of_a_failure_names_the_file_that_was_opened_or_saved() -> None:
    error = InputError(Path("felt.obj"), "is damaged", "Export it again")
    opening = Job("Looking for its material", lambda: None, lane="open")  # type: ignore[arg-type,return-value]
    baking = Job("Baking wavelets", lambda: None, lane="compute")  # type: ignore[arg-type,return-value]
    assert failed_title(opening, error) == 'Couldn\'t open "felt.obj"'
    assert failed_title(baking, error) == "Baking wavelets failed"
    assert failed_title(opening, MemoryError()) == "Looking for its material failed"
