"""The menu of what was opened lately: on disk at once, with images, and marked where it is gone."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PySide6.QtWidgets import QApplication, QMenu

from app.document.document import Project
from app.project.project_file import History, Writer
from app.project.thumbnail import SIZE, image_of, thumbnail_of
from app.session import settings
from app.window.main_window import MainWindow
from app.window.recent import fill
from engine.images.decode import read_image
from engine.scene.material import Material
from engine.shading.shading_map import ShadingMap


def save(path: Path, name: str) -> Path:
    writer = Writer(path)
    writer.write(History(Project(name=name)))
    writer.close()
    return path


def test_what_is_opened_is_remembered_at_once_and_survives_a_kill(tmp_path: Path) -> None:
    path = save(tmp_path / "Felt.lap", "Felt")
    program = (
        "import sys; from pathlib import Path; from app.window.application import start\n"
        "from app.window.main_window import MainWindow\n"
        "application = start(); window = MainWindow(Path(sys.argv[1]))\n"
        "window.files.open_project(Path(sys.argv[2]), lambda: print('open', flush=True))\n"
        "application.exec()\n"
    )
    words = [sys.executable, "-c", program, str(tmp_path / "config"), str(path)]
    with subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as window:
        assert window.stdout is not None
        assert window.stdout.readline().strip() == "open"
        os.kill(window.pid, signal.SIGKILL)
    assert settings.load(tmp_path / "config").recent_projects == (str(path),)


def test_two_windows_remember_both_of_what_they_open(tmp_path: Path) -> None:
    one, other = settings.Remembered(tmp_path), settings.Remembered(tmp_path)
    one.opened(tmp_path / "one.lap", tmp_path)
    other.opened(tmp_path / "other.lap", tmp_path)
    assert [Path(text).stem for text in settings.load(tmp_path).recent_projects] == ["other", "one"]
    assert one.now.recent_projects == (str(tmp_path / "one.lap"),)
    one.keep(theme="light")
    assert [Path(text).stem for text in settings.load(tmp_path).recent_projects] == ["other", "one"]


def test_projects_have_a_image_and_what_is_gone_is_marked(
    qapp: QApplication, qtbot: Any, photographs: Path, tmp_path: Path
) -> None:
    window = MainWindow(tmp_path / "config")
    window.show()
    window.open([photographs])
    qtbot.waitUntil(lambda: window.bench.document.project.has_map, timeout=240_000)
    path = window.projects.path
    qtbot.waitUntil(lambda: thumbnail_of(path).is_file() and not window.bench.jobs.active, timeout=60_000)
    qtbot.waitUntil(lambda: window.projects.is_saved, timeout=60_000)
    pixels = read_image(thumbnail_of(path)).pixels
    assert pixels.shape == (SIZE[1], SIZE[0], 3)
    assert np.asarray(pixels).std() > 0.02
    assert settings.load(tmp_path / "config").recent_projects[0] == str(path)
    save(tmp_path / "A & B.lap", "A")
    opened: list[Path] = []
    menu = QMenu()
    now = window.settings.now
    projects = (str(tmp_path / "gone" / "Old.lap"), str(tmp_path / "A & B.lap"), *now.recent_projects)
    fill(menu, projects, now.recent_files, opened.append)
    assert [entry.isSeparator() for entry in menu.actions()] == [False, False, False, True, False]
    entries = [entry for entry in menu.actions() if not entry.isSeparator()]
    assert [entry.isEnabled() for entry in entries] == [False, True, True, True]
    assert "(missing)" in entries[0].text()
    assert entries[1].text().startswith("A && B\t")
    assert entries[2].text().startswith("Felt sample\tUntitled")
    shown = entries[2].icon().pixmap(SIZE[0], SIZE[1]).toImage()
    assert shown.width() == SIZE[0]
    entries[1].trigger()
    assert opened == [tmp_path / "A & B.lap"]
    window.close()


def test_a_file_that_fails_to_open_is_not_remembered(window: MainWindow, qtbot: Any, tmp_path: Path) -> None:
    whole, damaged = tmp_path / "whole.obj", tmp_path / "damaged.obj"
    whole.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    damaged.write_text("v 0 0 nonsense\n")
    for path in (whole, damaged):
        window.open([path])
        qtbot.waitUntil(lambda: not window.bench.jobs.active, timeout=60_000)
    assert window.settings.now.recent_files == (str(whole),)


def test_the_image_is_of_the_brightest_slice_whatever_its_size() -> None:
    assert image_of(Project()) is None
    for height, width in ((4, 5), (72, 96), (300, 1000)):
        slices = np.zeros((2, height, width, 3), np.float32)
        slices[-1, :, : width // 2] = (4.0, 0.0, 0.0)
        material = Material(ShadingMap(slices, 1.0, np.array([0.5, 1.0])), None, brdf="lambert")
        image = image_of(Project(material=material))
        assert image is not None
        assert image.shape == (SIZE[1], SIZE[0], 3)
        assert tuple(image[36, 46]) == (255, 0, 0)
        assert not image[36, 52].any()
        assert not image[..., 1:].any()


@pytest.mark.parametrize("content", [b"", b"no image", b"x" * (2 << 20)])
def test_a_damaged_image_is_replaced_by_an_icon(qapp: QApplication, tmp_path: Path, content: bytes) -> None:
    path = save(tmp_path / "Felt.lap", "Felt")
    thumbnail_of(path).write_bytes(content)
    menu = QMenu()
    fill(menu, (str(path),), (), print)
    assert not menu.actions()[0].icon().isNull()
