"""A folder of photographs that is dropped on a window with a capture: a person says where it belongs."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, cast

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QMessageBox, QPushButton, QWidget

from app.project.project_file import read
from app.window.arriving import ask_for_consent
from app.window.main_window import MainWindow
from engine.capture.doubts import Doubtful

if TYPE_CHECKING:
    from app.commands.workbench import Workbench


def at_rest(window: MainWindow) -> bool:
    return window.bench.document.project.has_map and not window.bench.jobs.active


def question(window: MainWindow, qtbot: Any) -> QMessageBox:
    qtbot.waitUntil(lambda: any(box.isVisible() for box in window.findChildren(QMessageBox)), timeout=60_000)
    return next(box for box in window.findChildren(QMessageBox) if box.isVisible())


def answer(box: QMessageBox, qtbot: Any, words: str) -> None:
    chosen = next(each for each in box.findChildren(QPushButton) if each.text().replace("&", "") == words)
    qtbot.mouseClick(chosen, Qt.MouseButton.LeftButton)


@pytest.fixture
def halves(photographs: Path, tmp_path: Path) -> list[Path]:
    """The capture in two folders, with the lights at 10, 50, 90 and at 30, 70 degrees."""
    folders = [tmp_path / "First", tmp_path / "Second"]
    for at, path in enumerate(sorted(photographs.iterdir())):
        folders[at % 2].mkdir(exist_ok=True)
        (folders[at % 2] / path.name).write_bytes(path.read_bytes())
    return folders


def test_photographs_for_a_window_with_a_capture_become_what_a_person_says(
    window: MainWindow, qtbot: Any, drop: Any, halves: list[Path]
) -> None:
    document, first = window.bench.document, window.projects.path
    drop(window, halves[:1])
    qtbot.waitUntil(lambda: at_rest(window), timeout=60_000)
    before = document.project

    drop(window, halves[1:])
    answer(question(window, qtbot), qtbot, "Cancel")
    assert document.project is before

    drop(window, halves[1:])
    answer(question(window, qtbot), qtbot, "Add")
    qtbot.waitUntil(lambda: document.project.stack is not before.stack and at_rest(window), timeout=60_000)
    added = document.project
    assert added.stack is not None
    assert [round(float(each)) for each in added.stack.elevation_deg] == [10, 30, 50, 70, 90]
    assert added.name == "First"

    drop(window, halves[1:])
    answer(question(window, qtbot), qtbot, "Replace")
    qtbot.waitUntil(lambda: document.project.stack is not added.stack and at_rest(window), timeout=60_000)
    assert document.project.stack is not None
    assert len(document.project.stack.sources) == 2
    assert window.projects.path == first

    drop(window, halves[:1])
    answer(question(window, qtbot), qtbot, "New project")
    qtbot.waitUntil(lambda: window.projects.path != first and at_rest(window), timeout=60_000)
    assert document.project.stack is not None
    assert len(document.project.stack.sources) == 3
    kept = read(first).current
    assert kept.stack is not None
    assert len(kept.stack.sources) == 2


def test_photographs_that_cannot_be_imported_leave_the_document_as_it_was(
    window: MainWindow, qtbot: Any, drop: Any, halves: list[Path], tmp_path: Path
) -> None:
    document = window.bench.document
    drop(window, halves[:1])
    qtbot.waitUntil(lambda: at_rest(window), timeout=60_000)
    points = {"felt_10deg.png": ((1.0, 2.0, 3.0, 4.0),)}
    choices = dataclasses.replace(document.project.import_choices, control_points=points)
    document.change("Set a point", import_choices=choices)
    before, steps = document.project, document.undo_stack.count()
    broken = tmp_path / "Broken"
    broken.mkdir()
    for path in halves[1].iterdir():
        (broken / path.name).write_bytes(path.read_bytes()[:200])
    drop(window, [broken])
    answer(question(window, qtbot), qtbot, "Replace")
    qtbot.waitUntil(lambda: bool(window.failures.open_dialogs) and not window.bench.jobs.active, timeout=60_000)
    assert document.project is before
    assert document.undo_stack.count() == steps
    next(iter(window.failures.open_dialogs.values())).close()


def test_a_project_and_files_are_opened_together(
    window: MainWindow, qtbot: Any, mesh: Path, photographs: Path, tmp_path: Path
) -> None:
    window.bench.document.change("Name", name="Felt")
    window.projects.copy_to(tmp_path / "Felt.lap")
    qtbot.waitUntil(lambda: window.projects.path == tmp_path / "Felt.lap", timeout=60_000)
    window.new()
    window.open([tmp_path / "Felt.lap", mesh])
    qtbot.waitUntil(lambda: window.bench.document.project.mesh is not None, timeout=60_000)
    assert window.projects.path == tmp_path / "Felt.lap"


def test_angles_that_the_light_contradicts_wait_for_a_person(
    window: MainWindow, qtbot: Any, drop: Any, photographs: Path, tmp_path: Path
) -> None:
    folder = tmp_path / "Frames"
    folder.mkdir()
    for name, path in zip("cadbe", sorted(photographs.iterdir()), strict=True):
        (folder / f"{name}.png").write_bytes(path.read_bytes())
    drop(window, [folder])
    asked = question(window, qtbot)
    assert "Nothing says where the lamp stood" in asked.text()
    answer(asked, qtbot, "Cancel")
    document, rows = window.bench.document, window.capture.list.photographs
    assert document.project.stack is None
    assert rows.angles_editable
    assert rows.setData(rows.index(0), "35 / 90")
    qtbot.waitUntil(lambda: at_rest(window), timeout=60_000)
    stack = document.project.stack
    assert stack is not None
    assert stack.azimuth is not None
    assert stack.azimuth.tolist() == pytest.approx([1.5707963] * 5)
    assert [row.azimuth_deg for row in rows.rows] == [90.0] * 5
    assert "35 / 90" in [rows.data(rows.index(place), Qt.ItemDataRole.EditRole) for place in range(5)]
    for wrong in ("91", "30 / 400", "1 / 2 / 3", "30 /", "x"):
        assert not rows.setData(rows.index(0), wrong)


def test_a_photograph_that_cannot_be_read_is_left_out_where_a_person_says_so(
    window: MainWindow, qtbot: Any, drop: Any, photographs: Path, tmp_path: Path
) -> None:
    folder = tmp_path / "One broken"
    folder.mkdir()
    for path in photographs.iterdir():
        content = path.read_bytes()
        (folder / path.name).write_bytes(content[: len(content) // 2] if "50" in path.name else content)
    drop(window, [folder])
    asked = question(window, qtbot)
    assert asked.text().startswith("felt_50deg.png is ")
    assert asked.defaultButton().text() == "Leave it out"
    answer(asked, qtbot, "Leave it out")
    qtbot.waitUntil(lambda: at_rest(window), timeout=60_000)
    stack = window.bench.document.project.stack
    assert stack is not None
    assert [round(float(each)) for each in stack.elevation_deg] == [10, 30, 70, 90]


@pytest.mark.parametrize(("words", "consent"), [("Leave it out", "leave_out"), ("Use it all the same", "use_all")])
def test_a_person_says_what_becomes_of_a_photograph_that_shows_nothing(qtbot: Any, words: str, consent: str) -> None:
    parent, agreed = QWidget(), list[str]()
    qtbot.addWidget(parent)
    doubt = Doubtful("/a/felt.png", "is black", "Check that its lamp lit", "leave_out", "use_all")
    box = ask_for_consent(parent, cast("Workbench", SimpleNamespace(import_all_the_same=agreed.append)), doubt)
    assert box.text().startswith("felt.png is black")
    assert box.defaultButton().text() == "Leave it out"
    answer(box, qtbot, words)
    assert agreed == [consent]
