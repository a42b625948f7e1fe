"""What is saved is there whatever runs, and nothing ends a window before it is."""

from __future__ import annotations

import dataclasses
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QAction, QCloseEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QFileDialog

from app.jobs.jobs import Job
from app.project import copying
from app.project.project_file import data_folder, read
from app.view.baking import RESUMED
from app.window.leaving import LeavingDialog
from app.window.main_window import MainWindow
from engine.core.errors import InputError, OutputError
from engine.core.steps import Step, Steps
from engine.storage import atomic

LONG = 60_000


class Gate:
    """Lets copies begin, but for the one to `held`; the copies that wait for it so far."""

    def __init__(self) -> None:
        self.go, self.waiting, self.held = threading.Event(), 0, ""

    def copy(self, source: Path, target: Path, **options: Any) -> Steps[Path]:
        self.waiting += 1
        while not self.go.is_set() or target.name == self.held:
            time.sleep(0.002)
            yield Step(0.4, "copying")
        return (yield from copying.copy(source, target, **options))


@pytest.fixture
def gate(monkeypatch: pytest.MonkeyPatch) -> Iterator[Gate]:
    """Copies of projects wait for this."""
    made = Gate()
    monkeypatch.setattr("app.window.projects.copy", made.copy)
    yield made
    made.go.set()


@pytest.fixture
def closed(window: MainWindow) -> Iterator[list[bool]]:
    """True for each time that the window closes itself."""
    found: list[bool] = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(window, "close", lambda: found.append(True))
        yield found


def endless() -> Steps[None]:
    while True:
        time.sleep(0.002)
        yield Step(0.5, "working")


def quit_(window: MainWindow) -> bool:
    """Ask the window to close, as Ctrl+Q and the button of its frame do; whether it does so at once."""
    event = QCloseEvent()
    if window.files.leaving.is_held:
        window.closeEvent(event)
        return event.isAccepted()
    return True


def words_of(dialog: LeavingDialog) -> list[str]:
    """The line of each job in the dialog."""
    return [row.words.text() for row in dialog.rows.values()]


def gain(window: MainWindow, value: float) -> None:
    look = window.bench.document.project.look
    window.bench.document.change("Gain", look=dataclasses.replace(look, gain=value))


def test_beside_an_endless_computation_a_project_is_saved_at_once_and_quit_brings_it_up_to_date(
    window: MainWindow, qtbot: Any, tmp_path: Path, closed: list[bool]
) -> None:
    projects, target, untitled = window.projects, tmp_path / "Felt.lap", window.projects.path
    job = window.bench.jobs.submit("Working", endless, lane="compute")
    gain(window, 2.0)
    projects.copy_to(target)
    qtbot.waitUntil(lambda: projects.waits_for == "Working", timeout=LONG)
    assert (read(target).current.look.gain, projects.path, job.state) == (2.0, untitled, "running")
    assert window.banners.words["saved-as"].startswith("Felt.lap is saved")
    gain(window, 3.0)
    assert not quit_(window)
    qtbot.waitUntil(lambda: closed == [True], timeout=LONG)
    assert (read(target).current.look.gain, projects.path) == (3.0, target)
    assert len(read(target).steps) == 2
    assert not untitled.exists()
    assert not data_folder(untitled).exists(), "an untitled project moves"
    assert "saved-as" not in window.banners.words


def test_the_window_goes_on_in_the_saved_project_when_the_computation_has_ended(
    window: MainWindow, qtbot: Any, tmp_path: Path
) -> None:
    ends = threading.Event()

    def computing() -> Steps[float]:
        while not ends.is_set():
            time.sleep(0.002)
            yield Step(0.5, "working")
        return 4.0

    job = window.bench.jobs.submit("Working", computing, lane="compute")
    job.succeeded.connect(lambda found: gain(window, found))
    window.projects.copy_to(tmp_path / "Felt.lap")
    qtbot.waitUntil(lambda: window.projects.waits_for == "Working", timeout=LONG)
    ends.set()
    qtbot.waitUntil(lambda: window.projects.path == tmp_path / "Felt.lap", timeout=LONG)
    assert read(tmp_path / "Felt.lap").current.look.gain == window.bench.document.project.look.gain == 4.0
    assert window.status.words.text().startswith("Saved as Felt.lap")


def test_quit_waits_for_a_save_unless_the_user_says_otherwise(
    window: MainWindow, qtbot: Any, tmp_path: Path, closed: list[bool], gate: Gate
) -> None:
    target, leaving = tmp_path / "Felt.lap", window.files.leaving
    gain(window, 2.0)
    window.projects.copy_to(target)
    qtbot.waitUntil(lambda: gate.waiting == 1, timeout=LONG)
    assert not quit_(window)
    dialog = leaving.dialog
    assert dialog is not None
    qtbot.waitUntil(lambda: words_of(dialog)[0].startswith("Saving as Felt.lap… 40 %"), timeout=LONG)
    assert dialog.go.text() == "Quit without saving"
    QTest.keyClick(dialog, Qt.Key.Key_Escape)
    assert (leaving.dialog, closed) == (None, [])
    assert not quit_(window)
    window.undo.trigger()
    gate.go.set()
    qtbot.waitUntil(lambda: closed == [True], timeout=LONG)
    assert read(target).current.look.gain == 1.0, "what is undone meanwhile is undone in the copy"
    assert len(read(target).steps) == 1


def test_quit_without_saving_leaves_the_target_as_it_was(
    window: MainWindow, qtbot: Any, tmp_path: Path, closed: list[bool], gate: Gate
) -> None:
    gain(window, 2.0)
    window.projects.copy_to(tmp_path / "Felt.lap")
    assert not quit_(window)
    assert window.files.leaving.dialog is not None
    qtbot.mouseClick(window.files.leaving.dialog.go, Qt.MouseButton.LeftButton)
    qtbot.waitUntil(lambda: closed == [True], timeout=LONG)
    assert [path.name for path in tmp_path.iterdir() if "Felt" in path.name] == []
    qtbot.waitUntil(lambda: window.projects.is_saved, timeout=LONG)
    assert read(window.projects.path).current.look.gain == 2.0


def test_what_ends_while_the_window_closes_changes_nothing_any_more(window: MainWindow, qtbot: Any) -> None:
    """It came after the last write, and the process ended before it was written."""
    go = threading.Event()

    def open_slowly() -> Steps[str]:
        while not go.is_set():
            time.sleep(0.002)
            yield Step(0.5, "reading")
        return "sphere"

    job = window.bench.jobs.submit("Opening", open_slowly, lane="open")
    job.succeeded.connect(window.bench.load_model)
    window.bench.document.change("Notes", notes="worth keeping")
    window.projects.write()
    go.set()
    qtbot.waitUntil(lambda: job.over, timeout=LONG)
    assert job.state == "cancelled"
    assert window.bench.document.project.mesh is None
    assert read(window.projects.path).current.notes == "worth keeping"


@pytest.mark.parametrize("operation", ["mkdir", "link", "rename"])
def test_where_a_save_fails_the_window_stays_open_and_says_so(
    window: MainWindow,
    qtbot: Any,
    tmp_path: Path,
    closed: list[bool],
    gate: Gate,
    monkeypatch: pytest.MonkeyPatch,
    operation: str,
) -> None:
    """A disk that is full, or a folder that takes nothing; a link that cannot be made is a copy."""
    folder = tmp_path / "full"
    folder.mkdir()

    def full(asked: str, path: Path) -> None:
        if asked == operation and path.is_relative_to(folder):
            raise OSError(28, "No space left on device")

    gain(window, 2.0)
    window.bench.load_model("sphere")
    qtbot.waitUntil(lambda: window.projects.is_saved and not window.bench.jobs.active, timeout=LONG)
    window.projects.copy_to(folder / "Felt.lap")
    assert not quit_(window)
    monkeypatch.setattr(atomic, "fault", full)
    gate.go.set()
    if operation == "link":
        qtbot.waitUntil(lambda: closed == [True], timeout=LONG)
        assert read(folder / "Felt.lap").current.mesh is not None
        return
    qtbot.waitUntil(
        lambda: bool(window.failures.open_dialogs) or "disk is full" in window.status.words.text(), timeout=LONG
    )
    monkeypatch.setattr(atomic, "fault", None)
    assert (closed, window.files.leaving.dialog, window.projects.is_saving) == ([], None, False)
    assert [path.name for path in folder.iterdir()] == []
    assert window.projects.path != folder / "Felt.lap"


def test_of_two_places_both_are_saved_and_the_window_goes_on_in_the_last(
    window: MainWindow, qtbot: Any, tmp_path: Path, gate: Gate, monkeypatch: pytest.MonkeyPatch
) -> None:
    first, last = tmp_path / "First.lap", tmp_path / "Last.lap"
    gain(window, 2.0)
    window.projects.copy_to(first)
    qtbot.waitUntil(lambda: gate.waiting == 1, timeout=LONG)
    window.projects.copy_to(last)
    window.projects.copy_to(last)
    qtbot.waitUntil(lambda: gate.waiting == 2, timeout=LONG)
    reported: list[str] = []
    monkeypatch.setattr(window.failures, "report", lambda title, _error: reported.append(title))
    gate.held = first.name
    gate.go.set()
    qtbot.waitUntil(lambda: [job.title for job in window.bench.jobs.active] == ["Saving as First.lap"], timeout=LONG)
    assert window.projects.path not in (first, last), "the first is copied of a project that would move"
    gate.held = ""
    qtbot.waitUntil(lambda: window.projects.path == last and not window.projects.is_saving, timeout=LONG)
    assert reported == []
    assert [read(path).current.look.gain for path in (first, last)] == [2.0, 2.0]
    assert sorted(path.name for path in tmp_path.glob("*.lap*")) == [
        "First.lap",
        "First.lap-data",
        "Last.lap",
        "Last.lap-data",
    ]


def test_quit_lists_what_it_would_stop_and_stops_it_only_when_told_so(
    window: MainWindow, qtbot: Any, tmp_path: Path, closed: list[bool], gate: Gate
) -> None:
    """An export and a bake beside a save: first the user stops the two, then the window waits for the save."""
    jobs, leaving, ends = window.bench.jobs, window.files.leaving, threading.Event()

    def exporting() -> Steps[None]:
        while not ends.is_set():
            time.sleep(0.002)
            yield Step(0.25, "measuring")

    def begin(title: str, on_stop: str) -> Job:
        return jobs.submit(title, exporting, lane="compute", on_stop=on_stop)

    jobs.submit("Nobody asks about this", endless, lane="compute")
    jobs.max_compute = 3
    jobs_asked = begin("Exporting to cloth", "Nothing is written if you stop it."), begin("Baking wavelets", RESUMED)
    qtbot.waitUntil(lambda: all(job.step.done > 0 for job in jobs_asked), timeout=LONG)
    assert not quit_(window)
    dialog = leaving.dialog
    assert dialog is not None
    assert words_of(dialog) == ["Exporting to cloth… 25 %", "Baking wavelets… 25 %"]
    assert [row.on_stop.text() for row in dialog.rows.values()] == ["Nothing is written if you stop it.", RESUMED]
    assert dialog.go.text() == "Quit and stop them"
    QTest.keyClick(dialog, Qt.Key.Key_Return)
    assert (leaving.dialog, closed, [job.stopping for job in jobs_asked]) == (None, [], [False, False])

    gain(window, 2.0)
    window.projects.copy_to(tmp_path / "Felt.lap")
    qtbot.waitUntil(lambda: gate.waiting == 1, timeout=LONG)
    assert not quit_(window)
    dialog = leaving.dialog
    assert dialog is not None
    assert len(words_of(dialog)) == 3
    qtbot.mouseClick(dialog.go, Qt.MouseButton.LeftButton)
    qtbot.waitUntil(lambda: all(job.over for job in jobs_asked), timeout=LONG)
    qtbot.waitUntil(lambda: words_of(dialog) == ["Saving as Felt.lap… 40 %"], timeout=LONG)
    assert dialog.go.text() == "Quit without saving"
    qtbot.mouseClick(dialog.go, Qt.MouseButton.LeftButton)
    assert not closed, "the second of two clicks answers no question that nobody has read"
    gate.go.set()
    qtbot.waitUntil(lambda: closed == [True], timeout=LONG)
    assert read(tmp_path / "Felt.lap").current.look.gain == 2.0


def test_another_project_waits_for_an_export_and_stays_away_where_that_fails(
    window: MainWindow, qtbot: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    jobs, leaving, path = window.bench.jobs, window.files.leaving, window.projects.path
    monkeypatch.setattr("app.window.leaving.RESTS_MS", 0)
    ends, fails, reported = threading.Event(), [True], list[str]()
    monkeypatch.setattr(window.failures, "report", lambda title, _error: reported.append(title))

    def exporting() -> Steps[None]:
        while not ends.is_set():
            time.sleep(0.002)
            yield Step(0.25, "measuring")
        if fails:
            raise OutputError(Path("cloth"), "the disk is full", "Free some space")

    gain(window, 2.0)
    window.bench.document.change("Notes", notes="worth keeping")
    for action in (window.new, window.new):
        ends.clear()
        job = jobs.submit("Exporting to cloth", exporting, lane="compute", on_stop="Nothing is written if you stop it.")
        action()
        dialog = leaving.dialog
        assert dialog is not None
        assert (dialog.go.text(), window.projects.path) == ("Leave and stop it", path)
        ends.set()
        qtbot.waitUntil(lambda job=job: job.over and leaving.dialog is None, timeout=LONG)
        qtbot.waitUntil(lambda: (window.projects.path == path) is bool(fails), timeout=LONG)
        assert bool(reported) is bool(fails)
        fails.clear()
        reported.clear()


def test_a_save_over_a_project_that_is_being_opened_takes_its_place(
    window: MainWindow, qtbot: Any, tmp_path: Path
) -> None:
    """Its history would be read from the file that is no longer there."""
    target = tmp_path / "Felt.lap"
    window.bench.document.change("Notes", notes="replaced")
    window.projects.copy_to(target)
    qtbot.waitUntil(lambda: window.projects.path == target, timeout=LONG)
    gain(window, 2.0)
    window.new()
    window.bench.document.change("Notes", notes="kept")
    window.projects.open(target)
    window.projects.copy_to(target)
    qtbot.waitUntil(lambda: window.projects.path == target and not window.bench.jobs.active, timeout=LONG)
    assert window.bench.document.project.notes == "kept"
    window.undo.trigger()
    assert window.bench.document.project.notes == ""
    window.projects.write()
    assert [read(target).state(str(step.old)).notes for step in read(target).steps] == [""]


def test_a_project_that_is_read_waits_for_a_save_that_began_meanwhile(
    window: MainWindow, qtbot: Any, tmp_path: Path, gate: Gate
) -> None:
    """An untitled project in which nothing was brought goes when it is left, and the save read it."""
    gate.go.set()
    first, target = tmp_path / "First.lap", tmp_path / "Felt.lap"
    window.projects.copy_to(first)
    qtbot.waitUntil(lambda: window.projects.path == first and not window.bench.jobs.active, timeout=LONG)
    window.new()
    gate.go.clear()
    gain(window, 2.0)
    window.projects.open(first)
    (opening,) = [job for job in window.bench.jobs.active if job.lane == "open"]
    window.projects.copy_to(target)
    qtbot.waitUntil(lambda: opening.over, timeout=LONG)
    assert window.projects.is_opening
    gate.go.set()
    qtbot.waitUntil(lambda: window.projects.path == first and not window.bench.jobs.active, timeout=LONG)
    assert read(target).current.look.gain == 2.0


def test_another_project_is_opened_when_this_one_is_saved(
    window: MainWindow, qtbot: Any, tmp_path: Path, gate: Gate
) -> None:
    gate.go.set()
    gain(window, 5.0)
    window.projects.copy_to(tmp_path / "Other.lap")
    qtbot.waitUntil(lambda: window.projects.path == tmp_path / "Other.lap", timeout=LONG)
    window.new()
    gate.go.clear()
    gain(window, 2.0)
    window.projects.copy_to(tmp_path / "Felt.lap")
    window.open([tmp_path / "Other.lap"])
    assert window.bench.document.project.look.gain == 2.0
    gate.go.set()
    qtbot.waitUntil(lambda: window.projects.path == tmp_path / "Other.lap", timeout=LONG)
    assert window.bench.document.project.look.gain == 5.0
    assert read(tmp_path / "Felt.lap").current.look.gain == 2.0


def test_save_confirms_that_all_is_on_disk_and_asks_for_a_place_where_there_is_none(
    window: MainWindow, qtbot: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    target, asked = tmp_path / "Felt.lap", list[str]()

    def answer(_window: object, title: str, *_: object) -> tuple[str, str]:
        asked.append(title)
        return str(target), ""

    monkeypatch.setattr(QFileDialog, "getSaveFileName", answer)
    save = next(action for action in window.menus.findChildren(QAction) if action.text() == "Save")
    assert save.shortcut().toString() == "Ctrl+S"
    gain(window, 2.0)
    save.trigger()
    qtbot.waitUntil(lambda: window.projects.path == target and not window.projects.is_saving, timeout=LONG)
    assert asked == ["Save as"]
    job = window.bench.jobs.submit("Working", endless, lane="compute")
    gain(window, 3.0)
    save.trigger()
    qtbot.waitUntil(lambda: window.status.words.text() == f"Saved {time.strftime('%H:%M')}", timeout=LONG)
    assert read(target).current.look.gain == 3.0
    assert asked == ["Save as"]
    window.status._end_confirming()
    assert window.status.words.text() == "Working"
    window.bench.jobs.cancel(job)


def test_a_project_is_collected_with_what_was_not_on_disk_yet(window: MainWindow, qtbot: Any, tmp_path: Path) -> None:
    window.bench.jobs.submit("Working", endless, lane="compute")
    gain(window, 2.0)
    window.projects.collect_to(tmp_path / "Felt.lap")
    qtbot.waitUntil(lambda: not window.projects.is_saving, timeout=LONG)
    assert read(tmp_path / "Felt.lap").current.look.gain == 2.0


def test_a_project_that_cannot_be_written_is_not_collected(
    window: MainWindow, qtbot: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from app.project.recording import Recording
    from app.window.projects import _collect
    from engine.core.steps import drain

    qtbot.waitUntil(lambda: window.projects.is_saved, timeout=LONG)
    recording: Any = window.projects._recording
    assert isinstance(recording, Recording)
    monkeypatch.setattr(recording, "has_written", lambda _seconds: False)
    recording._is_failing = True
    with pytest.raises(InputError, match="latest changes"):
        drain(_collect(recording, window.projects.path, tmp_path / "Felt.lap", True))
    recording._is_failing = False
