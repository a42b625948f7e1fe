"""Images and films that the View workspace saves: those that the engine draws of the same scene."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import OpenEXR
import pytest
from PIL import Image
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QFileDialog

from app.commands.images import Saving, save
from app.document.modes import mode_named
from app.project.places import file_name
from app.view.save_dialog import SaveDialog, free
from app.window.main_window import MainWindow
from engine.brdf.analysis import albedo
from engine.brdf.brdf import brdf_from_text
from engine.core.steps import drain
from engine.geometry.camera import frame
from engine.geometry.shapes import shape
from engine.images.decode import read_image
from engine.light.environment_file import open_environment
from engine.render.background import in_front_of
from engine.render.direct import radiance
from engine.render.display import Display, display
from engine.scene.scene import Scene

SIZE = (48, 36)


def scene() -> Scene:
    sphere = shape("sphere")
    brdf = brdf_from_text("lambert:albedo=0.6")
    return Scene(mesh=sphere, camera=frame(sphere.positions, 4 / 3), brdf=brdf, environment=open_environment("sky"))


def test_the_focus_is_on_the_kind_that_was_asked_for(window: MainWindow, qtbot: Any) -> None:
    window.show_workspace("view")
    qtbot.waitUntil(lambda: window.view.default_mesh is not None, timeout=60_000)
    window.view.save_image("turntable")
    (dialog,) = [each for each in window.findChildren(SaveDialog) if each.isVisible()]
    assert dialog.focusWidget() is dialog.kind.buttons["turntable"]
    dialog.close()


def test_a_image_is_that_of_the_renderer_in_front_of_the_environment(tmp_path: Path) -> None:
    saving = Saving(tmp_path / "a.png", SIZE, "environment", samples=1)
    said = drain(save(scene(), saving, Display(), mode_named("direct")))
    assert said == "a.png saved: 48 × 36 pixels"
    of = scene()
    assert of.environment is not None
    expected = in_front_of(drain(radiance(of, SIZE, samples=1)), of.camera, of.environment)
    with Image.open(tmp_path / "a.png") as read:
        off = np.abs(np.asarray(read).astype(int) - display(expected, Display()).astype(int))
    assert off.max() <= 1


def test_the_reference_has_its_error_and_all_layers(tmp_path: Path) -> None:
    saving = Saving(tmp_path / "a.exr", SIZE, "transparent", paths=4, layers=True)
    drain(save(scene(), saving, Display(), mode_named("reference")))
    channels = OpenEXR.File(str(tmp_path / "a.exr")).channels()
    found = {name: np.asarray(channels[name].pixels, np.float64) for name in channels}
    assert {"standard_error", "albedo", "normal"} <= set(found)
    middle = (SIZE[1] // 2, SIZE[0] // 2)
    assert found["normal"][middle] @ scene().camera.forward == pytest.approx(-1.0, abs=0.02)
    assert np.linalg.norm(found["normal"][middle]) == pytest.approx(1.0, abs=1e-5)
    exact = albedo(scene().brdf, np.array([0.0, 0.0, 1.0]))
    assert found["albedo"][middle] == pytest.approx(np.broadcast_to(exact, 3), abs=0.01)
    assert (found["albedo"][0, 0] == 0.0).all()


def test_a_film_turns_and_one_that_is_stopped_leaves_nothing(tmp_path: Path) -> None:
    saving = Saving(tmp_path / "a.webp", SIZE, "transparent", frames=4, turns="light", samples=1)
    of = dataclasses.replace(scene(), environment=None, brdf=brdf_from_text("phong:exponent=9"))
    drain(save(of, saving, Display(), mode_named("direct")))
    with Image.open(tmp_path / "a.webp") as read:
        frames = []
        for number in range(4):
            read.seek(number)
            frames.append(np.asarray(read.convert("RGBA")).astype(int))
    assert np.abs(frames[0] - frames[2]).max() > 40
    assert frames[0][0, 0, 3] == 0
    steps = save(
        of, dataclasses.replace(saving, path=tmp_path / "b.mp4", background="plain"), Display(), mode_named("direct")
    )
    for _ in range(4):
        next(steps)
    steps.close()
    assert [path.name for path in tmp_path.iterdir()] == ["a.webp"]


@pytest.mark.parametrize(
    ("parts", "why"),
    [
        ({"path": Path("a.gif")}, "An image is"),
        ({"path": Path("a.mp4"), "frames": 9, "background": "transparent"}, "no transparency"),
        ({"size": (1, 5)}, "not possible"),
        ({"path": Path("a.mp4"), "frames": 9, "size": (20000, 100)}, "at most"),
    ],
)
def test_what_cannot_be_is_said(parts: dict[str, Any], why: str) -> None:
    assert why in dataclasses.replace(Saving(Path("a.png")), **parts).why_not


def test_a_user_saves_a_image_from_the_view_workspace(
    window: MainWindow, qtbot: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    window.activateWindow()
    window.show_workspace("view")
    qtbot.waitUntil(lambda: window.view.default_mesh is not None and window.isActiveWindow(), timeout=60_000)
    QTest.keyClick(window.view.tone_map, Qt.Key.Key_P, Qt.KeyboardModifier.ControlModifier)
    dialog = window.view.dialog
    assert isinstance(dialog, SaveDialog)
    assert dialog.saving(tmp_path).size == window.view.viewport.screen_px()
    assert not dialog.blur.isEnabled()
    for field, words in ((dialog.width_field, "40"), (dialog.height_field, "30")):
        field.selectAll()
        QTest.keyClicks(field, words)
        QTest.keyClick(field, Qt.Key.Key_Return)
    place, proposals = str(tmp_path / "mine"), list[str]()

    def answer(_dialog: Any, _title: str, proposal: str, _endings: str) -> tuple[str, str]:
        proposals.append(proposal)
        return place, "PNG (*.png)"

    monkeypatch.setattr(QFileDialog, "getSaveFileName", answer)
    qtbot.mouseClick(dialog.go, Qt.MouseButton.LeftButton)
    qtbot.waitUntil((tmp_path / "mine.png").exists, timeout=60_000)
    assert read_image(tmp_path / "mine.png").pixels.shape[:2] == (30, 40)
    assert Path(proposals[0]).parent != tmp_path
    window.view.save_image("turntable")
    assert isinstance(window.view.dialog, SaveDialog)
    window.view.dialog.go.click()
    assert Path(proposals[1]) == tmp_path / f"{window.projects.shown_name}.mp4"
    assert (window.settings.now.output_folder, window.bench.output_folder) == (str(tmp_path), tmp_path)


def test_a_name_is_proposed_that_is_free_and_that_every_system_takes(tmp_path: Path) -> None:
    place = tmp_path / file_name("Felt: 3/4 ", "picture")
    assert free(place, ".png") == tmp_path / "Felt 3 4.png"
    (tmp_path / "Felt 3 4.png").touch()
    assert free(place, ".png") == tmp_path / "Felt 3 4 2.png"
    assert file_name("…", "picture") == "picture"
    assert not free(tmp_path / file_name("ü" * 300, "picture"), ".webp").exists()
