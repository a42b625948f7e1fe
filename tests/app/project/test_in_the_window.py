"""The project of a window: on disk at once, opened again as it was, copied and renamed without a question."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from app.project.project_file import data_folder, read
from app.project.recording import DELAY_MS
from app.window.banner import short_path
from app.window.main_window import MainWindow
from tests.app.opening import open_project


def test_a_project_is_left_and_opened_again_as_it_was(
    window: MainWindow, qtbot: Any, drop: Any, photographs: Path, tmp_path: Path
) -> None:
    document, projects = window.bench.document, window.projects
    drop(window, [photographs])
    qtbot.waitUntil(lambda: document.project.has_map, timeout=120_000)
    document.change("Gain", look=document.project.look.__class__(gain=2.0))
    steps, first = document.undo_stack.count(), projects.path
    qtbot.waitUntil(lambda: projects.is_saved, timeout=60_000)
    window.new()
    assert projects.path != first
    assert document.project.stack is None
    open_project(window, qtbot, first)
    assert document.undo_stack.count() == document.undo_stack.index() == steps
    assert document.project.look.gain == 2.0
    assert document.project.stack is not None
    assert document.project.recipe == document.project.built_from
    names = set(document.project.stack.sources)
    qtbot.waitUntil(lambda: set(window.capture.list.photographs.thumbnails) == names, timeout=60_000)
    window.undo.trigger()
    assert document.project.look.gain == 1.0
    projects.copy_to(tmp_path / "Felt.lap")
    qtbot.waitUntil(lambda: projects.path == tmp_path / "Felt.lap", timeout=60_000)
    assert read(tmp_path / "Felt.lap").current.look.gain == 1.0
    assert "Felt" in window.windowTitle()
    window.redo.trigger()
    qtbot.waitUntil(lambda: projects.is_saved, timeout=60_000)
    assert read(tmp_path / "Felt.lap").current.look.gain == 2.0
    assert not first.exists(), "an untitled project moves"
    projects.copy_to(tmp_path / "Other.lap")
    qtbot.waitUntil(lambda: projects.path == tmp_path / "Other.lap", timeout=60_000)
    assert read(tmp_path / "Felt.lap").current.look.gain == 2.0, "one with a name is copied"


def test_a_gesture_is_handed_over_within_a_second_however_long_it_goes_on(window: MainWindow, qtbot: Any) -> None:
    """The clock is moved by hand: what the writer is given when it strikes is on disk before anything else happens."""
    document, projects = window.bench.document, window.projects
    qtbot.waitUntil(lambda: projects.is_saved, timeout=60_000)
    recording = projects._recording
    assert recording is not None
    assert DELAY_MS <= 500, "half a second is left for writing"
    recording._delay.setInterval(1_000_000)
    document.change("Gain", gesture="gain", look=document.project.look.__class__(gain=2.0))
    clock = recording._delay.timerId()
    assert not projects.is_saved
    document.change("Gain", gesture="gain", look=document.project.look.__class__(gain=3.0))
    assert recording._delay.timerId() == clock, "a drag does not put off its writing"
    assert read(projects.path).current.look.gain == 1.0
    with qtbot.waitSignal(recording.written, timeout=60_000):
        recording._delay.timeout.emit()
    assert read(projects.path).current.look.gain == 3.0
    assert projects.is_saved
    recording._delay.setInterval(DELAY_MS)


def test_a_project_that_cannot_be_written_is_said_kept_and_written_later(
    window: MainWindow, qtbot: Any, tmp_path: Path, monkeypatch: Any
) -> None:
    from engine.storage import atomic

    def full(operation: str, _path: Path) -> None:
        if operation == "create":
            raise OSError(28, "No space left on device")

    document, projects = window.bench.document, window.projects
    qtbot.waitUntil(lambda: projects.is_saved, timeout=60_000)
    monkeypatch.setattr("app.project.recording.AGAIN_S", 0.05)
    monkeypatch.setattr(atomic, "fault", full)
    window.bench.load_model("sphere")
    qtbot.waitUntil(lambda: projects.problem != "", timeout=60_000)
    assert "not saved" in window.bar.title.text()
    said = window.banners.words["saving"]
    assert said.startswith(f"{short_path(projects.path)} is not saved: the disk is full")
    assert said.endswith(". All changes stay in memory until they can be written.")
    assert str(data_folder(projects.path)) in window.banners.of["saving"].words.toolTip()
    monkeypatch.setattr(atomic, "fault", None)
    qtbot.waitUntil(lambda: projects.problem == "" and projects.is_saved, timeout=60_000)
    assert read(projects.path).current.mesh is not None
    assert any((data_folder(projects.path) / "arrays").iterdir())
    assert document.project.mesh is not None


def test_without_a_folder_for_projects_the_window_opens_and_keeps_them_elsewhere(
    window: MainWindow, tmp_path: Path
) -> None:
    (tmp_path / "file").write_bytes(b"")
    window.projects.folder = tmp_path / "file"
    window.projects.begin()
    assert not window.projects.path.is_relative_to(tmp_path / "file")
    window.bench.document.change("Name", name="Kept")
    path = window.projects.path
    assert window.projects._recording is not None
    assert window.projects._recording.wait(30.0)
    assert read(path).current.name == "Kept"
