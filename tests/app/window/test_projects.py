"""Projects of a window that are saved elsewhere, read-only, full, removed or on a drive that went."""

from __future__ import annotations

import contextlib
import dataclasses
import sqlite3
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from PySide6.QtCore import Qt

from app.commands.rebuilding import lacks_material
from app.document.document import Project
from app.project import database, recording
from app.project.made import size_of
from app.project.pixels import are_there
from app.project.places import claim, interrupt, projects_folder, release
from app.project.project_file import History, Writer, data_folder, read
from app.window.banner import short_path
from app.window.main_window import MainWindow
from app.window.projects import Projects
from engine.geometry.shapes import shape
from engine.storage import atomic
from tests.app.opening import open_project


def save(path: Path, name: str, **parts: Any) -> Path:
    path.parent.mkdir(exist_ok=True)
    writer = Writer(path)
    writer.write(History(Project(name=name, **parts)))
    writer.close()
    return path


def wait_saved(window: MainWindow, qtbot: Any) -> None:
    qtbot.waitUntil(lambda: window.projects.is_saved, timeout=60_000)


def gain(window: MainWindow, value: float) -> None:
    document = window.bench.document
    document.change("Gain", look=dataclasses.replace(document.project.look, gain=value))


@pytest.fixture
def full(monkeypatch: pytest.MonkeyPatch) -> Iterator[Any]:
    """A disk that can be made full in one folder."""
    places: list[Path] = []

    def fault(operation: str, path: Path) -> None:
        if operation == "create" and any(path.is_relative_to(place) for place in places):
            raise OSError(28, "No space left on device")

    monkeypatch.setattr(recording, "AGAIN_S", 0.05)
    monkeypatch.setattr(atomic, "fault", fault)
    yield places
    monkeypatch.setattr(atomic, "fault", None)


def test_save_as_takes_the_place_of_another_project(window: MainWindow, qtbot: Any, tmp_path: Path) -> None:
    target = save(tmp_path / "a" / "Felt.lap", "old", mesh=shape("plane"))
    window.bench.load_model("sphere")
    qtbot.waitUntil(lambda: window.bench.document.project.mesh is not None, timeout=60_000)
    gain(window, 2.0)
    window.projects.copy_to(target)
    qtbot.waitUntil(lambda: window.projects.path == target, timeout=60_000)
    gain(window, 3.0)
    wait_saved(window, qtbot)
    found = read(target)
    assert (found.current.look.gain, len(found.steps)) == (3.0, 3)
    assert found.current.mesh is not None
    assert len(found.current.mesh.positions) == len(shape("sphere").positions)
    assert [path.name for path in target.parent.glob("*.lap")] == ["Felt.lap"]


def test_changes_that_are_made_while_a_copy_is_made_are_in_it(window: MainWindow, qtbot: Any, tmp_path: Path) -> None:
    gain(window, 2.0)
    window.projects.copy_to(tmp_path / "Felt.lap")
    gain(window, 4.0)
    qtbot.waitUntil(lambda: window.projects.path == tmp_path / "Felt.lap", timeout=60_000)
    assert window.bench.document.project.look.gain == 4.0
    wait_saved(window, qtbot)
    assert read(tmp_path / "Felt.lap").current.look.gain == 4.0


@pytest.fixture
def elsewhere(tmp_path: Path) -> Iterator[Path]:
    """A project that another process has open."""
    path = save(tmp_path / "b" / "Felt.lap", "Felt", mesh=shape("sphere"))
    words = f"from pathlib import Path; from app.project.places import claim; claim(Path({str(path)!r}))"
    pipes: dict[str, Any] = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
    with subprocess.Popen([sys.executable, "-c", f"{words}; print(flush=True); input()"], **pipes) as other:
        assert other.stdout is not None
        other.stdout.readline()
        yield path
        other.kill()


def test_a_second_window_is_read_only_says_so_and_saves_its_changes_elsewhere(
    window: MainWindow, qtbot: Any, elsewhere: Path, tmp_path: Path
) -> None:
    before = elsewhere.read_bytes()
    open_project(window, qtbot, elsewhere)
    assert "is open in another window" in window.banners.words["read-only"]
    assert "read-only" in window.bar.title.text()
    gain(window, 5.0)
    qtbot.wait(300)
    assert window.bench.own != data_folder(elsewhere)
    window.projects.copy_to(tmp_path / "Mine.lap")
    qtbot.waitUntil(lambda: window.projects.path == tmp_path / "Mine.lap", timeout=60_000)
    assert "read-only" not in window.banners.words
    assert (read(tmp_path / "Mine.lap").current.look.gain, window.bench.own) == (5.0, window.bench.folder)
    assert read(tmp_path / "Mine.lap").current.mesh is not None
    assert elsewhere.read_bytes() == before
    assert not list(data_folder(elsewhere).glob("stack-*"))


def test_a_project_that_cannot_be_written_opens_read_only_and_its_changes_are_saved_elsewhere(
    window: MainWindow, qtbot: Any, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """A disk that is read-only, or a file that another program holds: SQLite says no to the first who would write."""
    path = save(tmp_path / "medium" / "Felt.lap", "Felt", mesh=shape("sphere"))
    monkeypatch.setattr(database, "LOCK_S", 0.05)
    with contextlib.closing(sqlite3.connect(path, isolation_level=None)) as other:
        other.execute("BEGIN IMMEDIATE")
        open_project(window, qtbot, path)
        assert window.projects.path == path
        assert window.banners.words["read-only"].startswith(f"{short_path(path)} cannot be written.")
        assert window.banners.of["read-only"].buttons[0].text() == "Save as…"
        assert window.bench.document.project.mesh is not None
        gain(window, 5.0)
        window.projects.copy_to(tmp_path / "Mine.lap")
        qtbot.waitUntil(lambda: window.projects.path == tmp_path / "Mine.lap", timeout=60_000)
    assert "read-only" not in window.banners.words
    wait_saved(window, qtbot)
    assert read(tmp_path / "Mine.lap").current.look.gain == 5.0
    assert read(path).current.look.gain == 1.0


def test_a_newer_project_is_refused_with_its_version(window: MainWindow, qtbot: Any, tmp_path: Path) -> None:
    path, here = save(tmp_path / "c" / "Felt.lap", "Felt"), window.projects.path
    with sqlite3.connect(path) as connection:
        connection.execute("UPDATE meta SET value = '77' WHERE name = 'schema'")
    connection.close()
    before = path.read_bytes()
    open_project(window, qtbot, path)
    qtbot.waitUntil(lambda: bool(window.failures.open_dialogs), timeout=10_000)
    (box,) = window.failures.open_dialogs.values()
    assert "schema 77" in box.informativeText()
    assert window.projects.path == here
    assert path.read_bytes() == before


def test_a_full_disk_is_said_in_a_banner_that_stays_until_it_has_room(
    window: MainWindow, qtbot: Any, full: list[Path], tmp_path: Path
) -> None:
    wait_saved(window, qtbot)
    full.append(window.projects.path.parent)
    window.bench.load_model("sphere")
    qtbot.waitUntil(lambda: "saving" in window.banners.words, timeout=60_000)
    assert "full" in window.banners.words["saving"]
    qtbot.wait(200)
    assert "saving" in window.banners.words
    window.projects.copy_to(tmp_path / "Saved.lap")
    qtbot.waitUntil(lambda: window.projects.path == tmp_path / "Saved.lap", timeout=60_000)
    assert read(tmp_path / "Saved.lap").current.mesh is not None
    assert "saving" not in window.banners.words


def test_closing_does_not_wait_for_a_disk_that_takes_nothing_and_keeps_all_elsewhere(
    window: MainWindow, qtbot: Any, full: list[Path], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    path = save(tmp_path / "full" / "Felt.lap", "Felt")
    open_project(window, qtbot, path)
    wait_saved(window, qtbot)
    monkeypatch.undo()  # the fixture's own rescue, and a shorter pause
    monkeypatch.setattr(atomic, "fault", lambda *_: None)
    full_disk = threading.Event()

    def fault(operation: str, place: Path) -> None:
        if operation == "create" and place.is_relative_to(path.parent):
            full_disk.set()
            raise OSError(28, "No space left on device")

    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    monkeypatch.setattr(atomic, "fault", fault)
    window.bench.document.change("Model", mesh=shape("sphere"))
    watch = threading.Timer(30.0, lambda: monkeypatch.setattr(atomic, "fault", None))
    watch.start()
    Projects.finish(window.projects)
    assert watch.is_alive(), "closing waited"
    watch.cancel()
    assert full_disk.is_set()
    monkeypatch.setattr(atomic, "fault", None)
    (rescued,) = [each for each in projects_folder().glob("*.lap") if read(each).current.mesh is not None]
    assert read(rescued).current.name == "Felt"
    release(rescued)
    assert claim(rescued)
    assert interrupt(projects_folder()) == []
    release(rescued)
    window.projects.begin()


def test_a_project_that_is_removed_is_written_again_without_another_change(
    window: MainWindow, qtbot: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(recording, "AGAIN_S", 0.05)
    window.bench.load_model("sphere")
    qtbot.waitUntil(lambda: window.bench.document.project.mesh is not None, timeout=60_000)
    gain(window, 6.0)
    wait_saved(window, qtbot)
    path = window.projects.path
    path.unlink()
    with qtbot.waitSignal(window.projects._recording.restored, timeout=60_000):  # type: ignore[union-attr]
        pass
    assert read(path).current.look.gain == 6.0
    assert len(read(path).steps) == window.bench.document.undo_stack.count()


def test_a_drive_that_goes_is_not_made_anew_and_is_written_when_it_is_back(
    window: MainWindow, qtbot: Any, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(recording, "AGAIN_S", 0.05)
    path = save(tmp_path / "drive" / "Felt.lap", "Felt")
    open_project(window, qtbot, path)
    wait_saved(window, qtbot)
    path.parent.rename(tmp_path / "gone")
    gain(window, 7.0)
    qtbot.waitUntil(lambda: "saving" in window.banners.words, timeout=60_000)
    assert not path.parent.exists()
    (tmp_path / "gone").rename(path.parent)
    qtbot.waitUntil(lambda: "saving" not in window.banners.words, timeout=60_000)
    wait_saved(window, qtbot)
    assert read(path).current.look.gain == 7.0


def test_a_locked_file_keeps_closing_waiting_once_and_loses_nothing(
    window: MainWindow, qtbot: Any, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    path = save(tmp_path / "locked" / "Felt.lap", "Felt")
    open_project(window, qtbot, path)
    monkeypatch.undo()
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    waits: list[float] = []
    wait = recording.Recording.wait
    monkeypatch.setattr(recording.Recording, "wait", lambda one, s: waits.append(s) or wait(one, s))  # type: ignore[func-returns-value]
    with contextlib.closing(sqlite3.connect(path, isolation_level=None)) as other:
        other.execute("BEGIN EXCLUSIVE")
        window.bench.document.change("Name", name="Kept")
        window.projects.write()
        Projects.finish(window.projects)
        assert waits[1:] == [0.0]
    (rescued,) = [each for each in projects_folder().glob("*.lap") if read(each).current.name == "Kept"]
    release(rescued)
    window.projects.begin()


def test_a_project_that_is_being_read_while_the_window_closes_is_let_go(window: MainWindow, tmp_path: Path) -> None:
    path, here = save(tmp_path / "late" / "Felt.lap", "Felt"), window.projects.path
    window.open_project(path)
    assert window.projects.is_opening
    window.bench.jobs.close()
    assert not window.projects.is_opening
    assert window.projects.path == here
    assert not list(data_folder(path).glob("open-*"))


def test_a_project_without_a_name_is_offered_one_until_later(
    window: MainWindow, qtbot: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("app.window.naming.is_untitled", lambda path: path == window.projects.path)
    document = window.bench.document
    document.change("Light", look=dataclasses.replace(document.project.look, gain=2.0))
    wait_saved(window, qtbot)
    assert "name" not in window.banners.words, "a light is not worth keeping"
    document.change("Model", mesh=shape("plane"), name="Grey felt")
    qtbot.waitUntil(lambda: "name" in window.banners.words, timeout=60_000)
    (keep, later) = window.banners.of["name"].buttons
    assert keep.text() == "Save as Grey felt…"
    qtbot.mouseClick(later, Qt.MouseButton.LeftButton)
    gain(window, 3.0)
    wait_saved(window, qtbot)
    assert "name" not in window.banners.words


def test_a_window_whose_jobs_do_not_stop_has_closed_its_project_all_the_same(window: MainWindow) -> None:
    from app.project.places import was_interrupted

    gain(window, 2.0)
    path = window.projects.path
    window.projects.write()
    assert read(path).current.look.gain == 2.0
    assert not list(data_folder(path).glob("open-*"))
    assert not was_interrupted(path)


def test_a_project_that_was_cleaned_up_gets_its_results_back_without_a_step(
    window: MainWindow, qtbot: Any, tmp_path: Path, photographs: Path
) -> None:
    path = tmp_path / "Felt.lap"
    window.bench.open_photographs([photographs])
    qtbot.waitUntil(lambda: window.bench.document.project.has_map, timeout=60_000)
    built = window.bench.document.project.material.shading_map
    assert built is not None
    slices, steps = built.slices.tobytes(), len(window.bench.document.steps)
    window.projects.copy_to(path)
    qtbot.waitUntil(lambda: window.projects.path == path, timeout=60_000)
    before = size_of(data_folder(path))
    with qtbot.waitSignal(window.bench.said, timeout=60_000) as said:
        window.starting.page.clean_wanted.emit()
        assert window.stack.currentWidget() is window.starting.page
    assert said.args[0].startswith("Felt: ")
    assert "freed" in said.args[0]
    assert window.projects.path != path
    assert not list(data_folder(path).glob("open-*"))
    assert size_of(data_folder(path)) < before / 2
    assert lacks_material(read(path).current)
    empty = window.projects.path
    with qtbot.waitSignal(window.bench.said) as said:
        window.files.clean_up()
    assert said.args == ["There is nothing to clean up in this project yet"]
    assert window.projects.path == empty
    open_project(window, qtbot, path)
    qtbot.waitUntil(lambda: window.bench.document.project.has_map, timeout=60_000)
    again = window.bench.document.project.material.shading_map
    assert again is not None
    assert again.slices.tobytes() == slices
    assert len(window.bench.document.steps) == steps
    stack = window.bench.document.project.stack
    assert stack is not None
    assert are_there(stack)
    window.bench.document.undo_stack.undo()
    assert not window.bench.document.project.has_map
    window.bench.document.undo_stack.redo()
    assert window.bench.document.project.has_map
    wait_saved(window, qtbot)
    assert not read(path).missing
