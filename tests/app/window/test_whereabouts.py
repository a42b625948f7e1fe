"""Photographs that moved or changed while their project was closed: said in a banner, found and kept on request."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app.document.document import Project
from app.project.photographs import marks_of, photographs
from app.project.project_file import data_folder, read
from app.window.main_window import MainWindow
from app.window.whereabouts import describe_contents
from engine.images.encode import encode_png
from tests.app.opening import open_project
from tests.engine.scenes import weave


@pytest.fixture
def images(tmp_path: Path, photographs: Path) -> Path:
    """Photographs of this test alone."""
    return Path(shutil.copytree(photographs, tmp_path / "pictures" / "Felt"))


def import_capture(window: MainWindow, qtbot: Any, paths: list[Path]) -> Path:
    """The path of a project with `paths` imported; the window shows another one then."""
    window.open(paths)
    qtbot.waitUntil(lambda: window.bench.document.project.has_map, timeout=240_000)
    path = window.projects.path
    # A small image is written beside a project that is saved, and tests remove that folder.
    qtbot.waitUntil(lambda: window.projects.is_saved and not window.bench.jobs.active, timeout=60_000)
    window.new()
    return path


def open_path(window: MainWindow, qtbot: Any, path: Path) -> None:
    open_project(window, qtbot, path)
    qtbot.waitUntil(lambda: not window.bench.jobs.active, timeout=60_000)


def test_what_is_there_of_all_that_was_made_is_said_and_no_more() -> None:
    stack: Any = object()
    assert describe_contents(Project(stack=stack), 2) == ". What was made of them is here"
    assert describe_contents(Project(material=weave(16)), 1) == ". The material made of it is here"
    assert describe_contents(Project(), 2) == ", and what was made of them as well"


def test_photographs_that_moved_are_named_and_found_all_at_once(
    window: MainWindow, qtbot: Any, images: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = import_capture(window, qtbot, [images])
    document = window.bench.document
    assert len(marks_of(path)) >= 5
    open_path(window, qtbot, path)
    assert window.banners.words == {}
    window.new()
    images.rename(images.parent / "elsewhere")
    open_path(window, qtbot, path)
    assert window.banners.words["missing"].startswith("5 photographs")
    assert document.project.has_map
    steps = document.undo_stack.count()
    monkeypatch.setattr("PySide6.QtWidgets.QFileDialog.getExistingDirectory", lambda *_: str(images.parent))
    window.banners.of["missing"].buttons[0].click()
    qtbot.waitUntil(lambda: window.banners.words == {}, timeout=60_000)
    assert all(each.parent == images.parent / "elsewhere" for each in photographs(document.project))
    assert document.undo_stack.count() == document.undo_stack.index() == steps
    assert document.project.recipe == document.project.built_from
    window.undo.trigger()
    assert all(each.is_file() for each in photographs(document.project))
    qtbot.waitUntil(lambda: window.projects.is_saved, timeout=60_000)


def test_a_project_that_moved_with_its_photographs_opens_without_a_word(
    window: MainWindow, qtbot: Any, images: Path
) -> None:
    window.open([images])
    qtbot.waitUntil(lambda: window.bench.document.project.has_map, timeout=240_000)
    window.projects.copy_to(images.parent / "Felt.lap")
    qtbot.waitUntil(lambda: window.projects.path == images.parent / "Felt.lap", timeout=60_000)
    qtbot.waitUntil(lambda: window.projects.is_saved and not window.bench.jobs.active, timeout=60_000)
    window.new()
    elsewhere = images.parent.rename(images.parent.with_name("elsewhere"))
    open_path(window, qtbot, elsewhere / "Felt.lap")
    found = window.bench.document.project
    assert window.banners.words == {}
    assert found.has_map
    assert len(photographs(found)) >= 5
    assert all(each.is_file() and each.is_relative_to(elsewhere) for each in photographs(found))


def test_what_is_gone_with_the_data_folder_is_made_again_at_a_button(
    window: MainWindow, qtbot: Any, images: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = import_capture(window, qtbot, [images])
    shutil.rmtree(data_folder(path))
    open_path(window, qtbot, path)
    project = window.bench.document.project
    assert (project.stack, project.has_map) == (None, False)
    assert "an import of photographs. Making that again takes about" in window.banners.words["lost"]
    assert window.capture.again.isEnabled()
    arrived: list[Any] = []
    monkeypatch.setattr("app.window.files.ask_where", lambda *said: arrived.append(said[-1]))
    window.open([images])
    qtbot.waitUntil(lambda: not window.bench.jobs.active, timeout=60_000)
    assert [arrival.name for arrival in arrived] == [images.name]
    window.banners.of["lost"].buttons[0].click()
    qtbot.waitUntil(lambda: window.bench.document.project.has_map, timeout=240_000)
    assert window.banners.words == {}
    assert window.bench.document.project.recipe == window.bench.document.project.built_from


def test_photographs_that_changed_are_named_and_nothing_is_made_anew(
    window: MainWindow, qtbot: Any, images: Path
) -> None:
    path = import_capture(window, qtbot, [images])
    changed = images / "felt_50deg.png"
    changed.write_bytes(encode_png(np.full((96, 128, 3), 30_000, np.uint16)))
    open_path(window, qtbot, path)
    document = window.bench.document
    stack = document.project.stack
    assert "felt_50deg.png is not as it was when it was imported" in window.banners.words["changed"]
    qtbot.wait(200)
    assert document.project.stack is stack
    again = next(each for each in window.banners.of["changed"].buttons if each.text() == "Import again")
    again.click()
    qtbot.waitUntil(lambda: document.project.stack is not stack, timeout=240_000)
    assert "changed" not in window.banners.words
    qtbot.waitUntil(lambda: not window.bench.jobs.active, timeout=240_000)
    assert marks_of(path)[changed].size == changed.stat().st_size


def test_photographs_of_an_archive_are_there_after_a_restart(
    window: MainWindow, qtbot: Any, photographs: Path, tmp_path: Path
) -> None:
    archive = Path(shutil.make_archive(str(tmp_path / "Red felt"), "zip", photographs))
    path = import_capture(window, qtbot, [archive])
    sources = read(path).current.sources
    assert sources is not None
    assert all(each.is_file() for each in sources.photographs)
    shutil.rmtree(data_folder(path) / "photographs")
    open_path(window, qtbot, path)
    assert window.banners.words == {}
    assert all(each.is_file() for each in sources.photographs)
    shutil.rmtree(data_folder(path) / "photographs")
    archive.unlink()
    window.new()
    open_path(window, qtbot, path)
    assert "missing" in window.banners.words
