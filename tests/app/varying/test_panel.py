"""Variations over the model, set in the window: one step a gesture, kept, and drawn as the command line draws it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from pytestqt.qtbot import QtBot

from app.commands.images import Saving
from app.document.document import Project
from app.document.variation import Blend, Colours, VariedParameter
from app.project.project_file import History, Writer, read
from app.window.main_window import MainWindow
from engine.geometry.camera import Camera
from engine.images.decode import read_image
from engine.images.encode import rgb_channels, write_exr
from tests.app.command import Command
from tests.app.view.test_baking import LONG, bake, draw, view
from tests.present import present

__all__ = ["view"]

CAMERA = Camera((0.0, 0.5, 4.0), (0.0, 0.0, 0.0), fov_deg=40.0)
SIZE = ("--width", "48", "--height", "36")


def choose(window: MainWindow, words: str) -> None:
    """Choose an entry of the menu that adds something."""
    panel = window.view.varying
    panel.fill_menu()
    next(action for action in panel.menu.actions() if action.text() == words).trigger()


def variations(window: MainWindow) -> Any:
    return window.bench.document.project.variations


def test_what_varies_is_one_step_a_gesture(view: MainWindow) -> None:
    stack, panel = view.bench.document.undo_stack, view.view.varying
    count = stack.count()
    choose(view, "Roughness α")
    (first,) = variations(view)
    assert (first.parameter, first.source) == ("alpha", "y")
    assert stack.count() == count + 1
    field = present(panel.form).editors["stop"].field
    field.setFocus()
    field.selectAll()
    QTest.keyClicks(field, "0.4")
    QTest.keyClick(field, Qt.Key.Key_Return)
    source = present(panel.form).menus["source"]
    source.setCurrentIndex(source.findData("x"))
    source.activated.emit(0)
    assert variations(view) == (VariedParameter("alpha", first.start, 0.4, "x"),)
    slider = present(panel.form).editors["start"].slider
    slider.setSliderDown(True)
    for ticks in (10, 20, 30):
        slider.setValue(ticks)
    slider.setSliderDown(False)
    assert stack.count() == count + 4, "a drag is one step"
    assert "Material" not in view.view.hint.text()
    assert "Direct leaves out what varies over the model, ‘Roughness α’" in view.view.hint.text()
    panel.fill_menu()
    assert [action.text() for action in panel.menu.actions()][:2] == ["Diffuse", "F0"]
    for _ in range(3):
        stack.undo()
    assert variations(view) == (first,)
    panel.remove.click()
    assert variations(view) == ()
    assert panel.form is None


def test_another_brdf_and_colours_are_chosen(view: MainWindow, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    panel, image = view.view.varying, tmp_path / "cloth.png"
    choose(view, "Mix in another BRDF")
    menu = present(panel.form).menus["brdf"]
    menu.setCurrentIndex(menu.findData("ward"))
    menu.activated.emit(0)
    assert variations(view)[0].brdf.startswith("ward:")
    monkeypatch.setattr("app.varying.panel.ask_image", lambda _parent: image)
    choose(view, "Colours of an image…")
    assert variations(view)[1] == Colours(image)
    monkeypatch.setattr("app.varying.panel.ask_image", lambda _parent: None)
    menu = present(panel.form).menus["picture"]
    menu.setCurrentIndex(1)
    menu.activated.emit(1)
    assert variations(view)[1] == Colours(image), "nothing was chosen"
    panel.list.activated.emit(0)
    assert "ward" in str(present(panel.form).menus["brdf"].currentData())


def test_what_varies_is_kept_with_the_project(tmp_path: Path) -> None:
    mask = tmp_path / "mask.png"
    mask.touch()
    said = (VariedParameter("alpha", 0.1, 0.5, mask), Blend("phong:exponent=30"), Colours(mask))
    writer = Writer(tmp_path / "a.lap")
    writer.write(History(Project(variations=said)))
    writer.close()
    assert read(tmp_path / "a.lap").current.variations == said
    (tmp_path / "elsewhere").mkdir()
    for path in [*tmp_path.iterdir()]:
        if path.name != "elsewhere":
            path.rename(tmp_path / "elsewhere" / path.name)
    found = read(tmp_path / "elsewhere" / "a.lap").current.variations[0]
    assert isinstance(found, VariedParameter)
    assert found.source == tmp_path / "elsewhere" / "mask.png"


@pytest.mark.parametrize("method", [pytest.param("sh", marks=pytest.mark.long), "wavelet"])
def test_the_image_is_the_one_that_the_command_line_renders(
    view: MainWindow, qtbot: QtBot, lightarc: Command, tmp_path: Path, method: str
) -> None:
    """A variation that is put on a finished bake gives the image of one that was made with it."""
    baking, document = bake(view, qtbot, method), view.bench.document
    document.look_from(CAMERA)
    before = present(draw(view))
    view.view.save(Saving(tmp_path / "plain.exr", (48, 36)))
    qtbot.waitUntil(lambda: (tmp_path / "plain.exr").exists(), timeout=LONG)
    colours = np.zeros((2, 2, 3), np.float32) + np.array([0.9, 0.5, 0.1], np.float32)
    write_exr(tmp_path / "colours.exr", rgb_channels(colours), half=False)
    varied = VariedParameter("alpha", 0.2, 0.6) if method == "sh" else Colours(tmp_path / "colours.exr")
    document.change("Vary", variations=(varied,))
    qtbot.waitUntil(lambda: draw(view) is not None and draw(view) is not before, timeout=LONG)
    assert baking.is_made, "no other bake is needed"
    view.view.save(Saving(tmp_path / "window.exr", (48, 36)))
    qtbot.waitUntil(lambda: (tmp_path / "window.exr").exists(), timeout=LONG)
    qtbot.waitUntil(lambda: view.projects.is_saved, timeout=LONG)
    arguments = ("--mode", method, "--renderer", "gl", "-o", tmp_path / "said.exr")  # as the window draws
    found = lightarc("render", view.projects.path, *arguments, *SIZE)
    assert found.code == 0, found.err
    window, said = (read_image(tmp_path / f"{name}.exr").pixels for name in ("window", "said"))
    assert np.abs(window - said).max() < 2e-3 * window.max()
    assert np.abs(window - read_image(tmp_path / "plain.exr").pixels).max() > 0.02 * window.max()


def test_a_image_that_is_gone_is_named(view: MainWindow, qtbot: QtBot, tmp_path: Path) -> None:
    view.view.choose_mode("sh")
    view.bench.document.change("Vary", variations=(VariedParameter("alpha", 0.2, 0.6, tmp_path / "gone.png"),))
    words = view.view.bake_panels["sh"].words
    qtbot.waitUntil(lambda: "gone.png" in words.text(), timeout=LONG)
