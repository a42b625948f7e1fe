"""A folder of photographs that is dropped on a window with a capture: a user says where it belongs."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, cast

import numpy as np
import pytest
import shiboken6
from PySide6.QtCore import Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QMessageBox, QPushButton, QWidget

from app.project.project_file import read
from app.window.arriving import ask_for_consent
from app.window.main_window import MainWindow
from engine.bundle.bundle import save_bundle
from engine.capture.doubts import Doubtful
from engine.core.steps import drain
from engine.images.encode import encode_png, rgb_channels, write_exr

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


def test_photographs_for_a_window_with_a_capture_become_what_a_user_says(
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

    document.change("Set for this sample", white=0.5, excluded=frozenset({"felt_30deg.png"}), tileable=True)
    own, panel = document.project, window.capture.panel
    assert panel.options.size_figure.text().endswith(" px")
    drop(window, halves[1:])
    answer(question(window, qtbot), qtbot, "Replace")
    qtbot.waitUntil(lambda: document.project.name == "Second", timeout=60_000)
    begun = document.project
    assert begun.stack is None, "the import has not ended"
    assert (begun.white, begun.excluded, begun.tileable, begun.has_map) == (None, frozenset(), False, False)
    assert (panel.options.size_figure.text(), panel.options.width_field.text()) == ("–", "–")
    assert panel.resolution.text() == "–"
    qtbot.waitUntil(lambda: at_rest(window), timeout=60_000)
    assert document.project.stack is not None
    assert len(document.project.stack.sources) == 2
    assert panel.options.size_figure.text().endswith(" px")
    assert window.projects.path == first
    while document.project is not own:
        window.undo.trigger()
    while document.undo_stack.canRedo():
        window.redo.trigger()

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


def test_everything_that_replaces_work_asks_first(
    window: MainWindow, qtbot: Any, drop: Any, halves: list[Path], tmp_path: Path
) -> None:
    bench, document = window.bench, window.bench.document
    drop(window, halves[:1])
    qtbot.waitUntil(lambda: at_rest(window), timeout=60_000)
    before = document.project
    assert before.stack is not None
    bundle = tmp_path / "Felt.lightarc"
    drain(save_bundle(bundle, before.material))
    textures = [tmp_path / "Rock_Color.png", tmp_path / "Rock_Roughness.png"]
    for path in textures:
        path.write_bytes(encode_png(np.full((8, 8, 3), 30_000, np.uint16)))
    stack = before.stack.folder
    assert stack is not None
    commands = {entry.text(): entry for entry in window.menus.findChildren(QAction)}
    for name, ask in (
        ("Woven sample", commands["Rebuild sample"].trigger),
        ("Felt.lightarc", lambda: drop(window, [bundle])),
        (stack.name, lambda: drop(window, [stack])),
        ("2 files", lambda: drop(window, textures)),
    ):
        ask()
        asked = question(window, qtbot)
        labels = [each.text() for each in asked.buttons()]
        assert sorted(labels) == ["Cancel", "New project", "Replace"], name
        assert f"Where does {name} belong?" in asked.informativeText()
        answer(asked, qtbot, "Cancel")
        qtbot.waitUntil(lambda asked=asked: not shiboken6.isValid(asked) and not bench.jobs.active, timeout=60_000)
        assert document.project is before
    drop(window, [bundle, tmp_path / "gone"])
    answer(question(window, qtbot), qtbot, "Replace")
    qtbot.waitUntil(lambda: document.project.stack is None, timeout=60_000)
    assert document.project.name == "Felt"
    assert list(window.failures.open_dialogs) == [
        f"gone does not exist.\nCheck the path, or whether its drive is connected.\n\n{tmp_path / 'gone'}"
    ]
    next(iter(window.failures.open_dialogs.values())).close()


def test_files_of_all_kinds_open_in_any_workspace(
    window: MainWindow, qtbot: Any, drop: Any, mesh: Path, photographs: Path, tmp_path: Path
) -> None:
    sky, notes = tmp_path / "sky.exr", tmp_path / "notes.txt"
    write_exr(sky, rgb_channels(np.ones((4, 8, 3), np.float32)))
    notes.write_text("nothing of the kind")
    document = window.bench.document
    window.show_workspace("factor")
    drop(window, [notes, mesh, photographs, sky, mesh.with_name("gone.ply")])
    jobs = window.bench.jobs  # a plan of the scene goes on in the background
    qtbot.waitUntil(
        lambda: document.project.has_map and not any(job.is_asked_for for job in jobs.active), timeout=60_000
    )
    qtbot.waitUntil(lambda: bool(window.failures.open_dialogs), timeout=60_000)
    project = document.project
    assert project.mesh is not None
    assert project.environment is not None
    assert project.stack is not None
    assert len(project.stack.sources) == 5
    (said,) = window.failures.open_dialogs
    assert "notes.txt is not a kind of file that Lightarc opens." in said
    assert "gone.ply does not exist." in said
    window.failures.open_dialogs[said].close()
    window.show_workspace("brdf")
    document.change("No light", environment=None)
    drop(window, [sky])
    qtbot.waitUntil(lambda: document.project.environment is not None, timeout=60_000)
    assert window.stack.currentWidget() is window.view
    assert document.project.stack is project.stack, "an environment replaces no capture"


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


def test_angles_that_the_light_contradicts_wait_for_a_user(
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


def test_a_photograph_that_cannot_be_read_is_left_out_where_a_user_says_so(
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
    assert asked.defaultButton().text() == "Exclude it"
    answer(asked, qtbot, "Exclude it")
    qtbot.waitUntil(lambda: at_rest(window), timeout=60_000)
    stack = window.bench.document.project.stack
    assert stack is not None
    assert [round(float(each)) for each in stack.elevation_deg] == [10, 30, 70, 90]


@pytest.mark.parametrize(("words", "consent"), [("Exclude it", "leave_out"), ("Use it all the same", "use_all")])
def test_a_user_says_what_becomes_of_a_photograph_that_shows_nothing(qtbot: Any, words: str, consent: str) -> None:
    parent, agreed = QWidget(), list[str]()
    qtbot.addWidget(parent)
    doubt = Doubtful("/a/felt.png", "is black", "Check that its lamp lit", "leave_out", "use_all")
    box = ask_for_consent(parent, cast("Workbench", SimpleNamespace(import_all_the_same=agreed.append)), doubt)
    assert box.text().startswith("felt.png is black")
    assert box.defaultButton().text() == "Exclude it"
    answer(box, qtbot, words)
    assert agreed == [consent]
