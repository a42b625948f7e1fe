"""Dialogs about the project: what is collected, the history and a user's notes; and commands of the menus."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QAction, QDesktopServices
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QDialog, QDialogButtonBox, QMessageBox, QPlainTextEdit, QUndoView

from app.document.document import Look
from app.project.project_file import read
from app.project.report import describe
from app.window.main_window import CRASHED, MainWindow
from tests.app.opening import open_project
from tests.app.window.test_arriving import answer, at_rest, question


def command(window: MainWindow, words: str) -> None:
    """Choose a command of the menus."""
    menus = [action.menu() for action in window.menus.actions()]
    next(action for menu in menus for action in menu.actions() if action.text() == words).trigger()  # type: ignore[attr-defined]


def dialog(window: MainWindow, title: str) -> QDialog:
    return next(each for each in window.findChildren(QDialog) if each.windowTitle() == title and each.isVisible())


@pytest.mark.parametrize("with_results", [True, pytest.param(False, marks=pytest.mark.long)])
def test_a_collected_project_holds_its_photographs_and_the_results_that_are_wanted(
    window: MainWindow,
    qtbot: Any,
    drop: Any,
    photographs: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    with_results: bool,
) -> None:
    """It opens in the window when the photographs of the original are gone, from another folder."""
    capture = tmp_path / "here" / "Felt"
    shutil.copytree(photographs, capture)
    drop(window, [capture])
    qtbot.waitUntil(lambda: at_rest(window), timeout=60_000)
    target = tmp_path / "collected" / "Felt.lap"
    monkeypatch.setattr("app.window.files.ask_for_place", lambda *_: target)
    command(window, "Collect…")
    answer(question(window, qtbot), qtbot, "With results" if with_results else "Without")
    qtbot.waitUntil(lambda: target.is_file() and not window.bench.jobs.active, timeout=60_000)
    before = window.bench.document.project

    window.new()
    shutil.rmtree(capture.parent)
    (tmp_path / "collected").rename(tmp_path / "elsewhere")
    open_project(window, qtbot, tmp_path / "elsewhere" / "Felt.lap")
    qtbot.waitUntil(lambda: not window.bench.jobs.active, timeout=60_000)
    found = window.bench.document.project
    assert found.sources is not None
    assert all(path.is_file() and path.is_relative_to(tmp_path / "elsewhere") for path in found.sources.photographs)
    assert "missing" not in window.banners.words
    assert found.has_map == with_results
    if with_results:
        assert found.stack is not None
        assert before.stack is not None
        assert np.array_equal(found.stack.radiance[:], before.stack.radiance[:])
        return
    window.bench.import_photographs(found.sources, name=found.name)
    qtbot.waitUntil(lambda: at_rest(window), timeout=60_000)


def test_notes_are_a_step_of_the_history_and_part_of_the_project(window: MainWindow, qtbot: Any) -> None:
    command(window, "Notes…")
    notes = dialog(window, "Notes")
    words = notes.findChild(QPlainTextEdit)
    assert words is not None
    QTest.keyClicks(words, "Linen, Ghent, about 1480")
    buttons = notes.findChild(QDialogButtonBox)
    assert buttons is not None
    qtbot.mouseClick(buttons.button(QDialogButtonBox.StandardButton.Ok), Qt.MouseButton.LeftButton)
    qtbot.waitUntil(lambda: window.projects.is_saved, timeout=60_000)
    assert describe(window.projects.path)["notes"] == "Linen, Ghent, about 1480"
    assert "name" not in window.banners.words or window.projects.is_worth_keeping()
    window.undo.trigger()
    assert window.bench.document.project.notes == ""
    command(window, "Notes…")
    dialog(window, "Notes").reject()
    assert not window.undo.isEnabled()


def test_the_history_leads_back_to_any_step(window: MainWindow, qtbot: Any) -> None:
    document = window.bench.document
    for gain in (1.5, 2.0, 2.5):
        document.change(f"Gain {gain}", look=Look(gain=gain))
    command(window, "History…")
    history = dialog(window, "History").findChild(QUndoView)
    assert history is not None
    history.setCurrentIndex(history.model().index(1, 0))
    assert document.project.look.gain == 1.5
    history.setCurrentIndex(history.model().index(3, 0))
    assert document.project.look.gain == 2.5
    history.setCurrentIndex(history.model().index(0, 0))
    assert document.project.look.gain == 1.0


def test_the_help_menu_opens_the_folder_of_crash_reports(
    window: MainWindow, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    opened: list[str] = []
    monkeypatch.setattr("app.process.crash.report_folder", lambda: tmp_path / "reports")
    monkeypatch.setattr(QDesktopServices, "openUrl", lambda url: opened.append(url.toLocalFile()) or True)  # type: ignore[func-returns-value]
    command(window, "Crash reports…")
    assert opened == [str(tmp_path / "reports")]
    assert (tmp_path / "reports").is_dir()


def test_a_crash_before_is_told_in_whole_until_a_user_has_seen_it(window: MainWindow) -> None:
    window.tell_of_crash("crash-7.txt says where")
    assert window.banners.words["crashed"] == CRASHED
    banner = window.banners.of["crashed"]
    assert banner.words.toolTip() == "crash-7.txt says where"
    banner.buttons[-1].click()
    assert "crashed" not in window.banners.words


@pytest.mark.parametrize("words", ["New project", "Close project"])
def test_a_project_that_is_closed_stays_on_disk_without_a_question(window: MainWindow, qtbot: Any, words: str) -> None:
    window.bench.document.change("Note", notes="kept")
    before = window.projects.path
    command(window, words)
    assert not window.findChildren(QMessageBox)
    assert window.projects.path != before
    assert window.bench.document.project.notes == ""
    assert read(before).current.notes == "kept"


def test_every_command_on_projects_is_in_the_file_menu(window: MainWindow) -> None:
    words = [action.text() for action in window.menus.actions()[0].menu().actions()]  # type: ignore[attr-defined]
    wanted = ["New project", "Open project…", "Open recent", "Save as…", "Collect…", "Notes…", "Close project"]
    wanted += ["Close and clean up"]
    assert [each for each in wanted if each not in words] == []
    keys = [
        action.shortcut().toString() for action in window.menus.findChildren(QAction) if not action.shortcut().isEmpty()
    ]
    assert len(keys) == len(set(keys)), "no two commands of the window have the same keys"
