"""Copies that take the place of another project: the old one or the new one at any moment, and never half of either."""

from __future__ import annotations

import dataclasses
import errno
import os
import re
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from app.document.document import Look, Project, Step
from app.project.copying import UNFINISHED, collect, copy, in_memory
from app.project.places import claim, release, remove
from app.project.project_file import WAITING, History, Writer, data_folder, read
from engine.capture.stack import ImageStack
from engine.core.errors import FileError, OutputError
from engine.core.steps import drain
from engine.geometry.shapes import shape
from engine.storage import atomic
from engine.storage.partial_names import partial_name
from engine.storage.writer import writer
from tests.app.command import Command


def save(path: Path, name: str, model: str) -> Path:
    """A project with one step and an array beside it."""
    first = Project(mesh=shape(model), name=name)
    second = dataclasses.replace(first, look=Look(gain=2.0))
    writer = Writer(path)
    writer.write(History(second, (Step("Gain", "", first, second),), 1))
    writer.close()
    return path


@pytest.fixture
def new(tmp_path: Path) -> Path:
    return save(tmp_path / "New.lap", "new", "sphere")


@pytest.fixture
def old(tmp_path: Path) -> Path:
    (tmp_path / "there").mkdir()
    return save(tmp_path / "there" / "Old.lap", "old", "plane")


def whole(path: Path) -> str:
    """The name of the project at `path`, all of whose data are there."""
    opened = read(path)
    assert not opened.missing
    state = opened.state(str(opened.steps[0].old))
    assert state.mesh is not None
    assert opened.current.mesh is not None
    assert len(opened.current.mesh.positions) == len(shape({"new": "sphere", "old": "plane"}[state.name]).positions)
    return state.name


def test_a_copy_replaces_a_project_with_its_data(new: Path, old: Path) -> None:
    drain(copy(new, old))
    assert whole(old) == whole(new) == "new"
    assert sorted(path.name for path in old.parent.iterdir()) == ["Old.lap", "Old.lap-data"]
    files = [sorted(each.name for each in data_folder(path).rglob("arrays/*")) for path in (old, new)]
    assert files[0] == files[1]


def test_a_copy_of_links_is_as_independent_as_any_other_and_leaves_out_what_is_being_written(
    new: Path, tmp_path: Path
) -> None:
    data = data_folder(new)
    (data / f".bake-1{UNFINISHED}").write_bytes(b"in place")
    (data / f"open-{writer()}").write_bytes(b"")
    (data / partial_name(data / "stack-1")).mkdir()
    target = tmp_path / "elsewhere" / "Linked.lap"
    drain(copy(new, target, with_links=True))
    arrays = [min(data_folder(path).glob("arrays/*")) for path in (new, target)]
    assert arrays[0].stat().st_ino == arrays[1].stat().st_ino
    assert sorted(path.name for path in data_folder(target).iterdir()) == [f".bake-1{UNFINISHED}", "arrays"]
    (data / f".bake-1{UNFINISHED}").write_bytes(b"goes on")
    remove(new)
    assert (data_folder(target) / f".bake-1{UNFINISHED}").read_bytes() == b"in place"
    assert whole(target) == "new"


@pytest.mark.parametrize("with_links", [True, False])
def test_a_file_that_goes_while_the_project_is_copied_is_not_missed(
    new: Path, tmp_path: Path, with_links: bool
) -> None:
    for name in ("a", "b"):
        (data_folder(new) / f"bake-{name}.transport").write_bytes(b"made")
    steps = copy(new, tmp_path / "Copy.lap", with_links=with_links)
    next(steps)
    for path in data_folder(new).glob("bake-*"):
        path.unlink()
    drain(steps)
    assert whole(tmp_path / "Copy.lap") == "new"


def test_what_else_is_written_into_the_folder_leaves_a_copy_under_way_alone(new: Path, tmp_path: Path) -> None:
    steps = copy(new, tmp_path / "Copy.lap")
    next(steps)
    (partial,) = tmp_path.glob(".Copy.*.lap")
    journal = partial.with_name(f"{partial.name}-journal")  # as SQLite has it while it writes
    journal.touch()
    killed = tmp_path / re.sub(r"-\d+-", "-999999999-", partial.name)
    killed.touch()
    atomic.write_bytes(tmp_path / "export.csv", b"1")
    assert (journal.exists(), killed.exists()) == (True, False)
    journal.unlink()
    killed.touch()
    drain(steps)
    assert whole(tmp_path / "Copy.lap") == "new"
    steps = copy(new, tmp_path / "Again.lap")
    next(steps)
    assert not killed.exists(), "a copy removes what killed ones left"
    atomic.remove_own_partials()  # the process ends hard
    assert sorted(path.name for path in tmp_path.iterdir() if path.name.startswith(".")) == []
    with pytest.raises(FileError):
        drain(steps)
    assert not (tmp_path / "Again.lap").exists()


def test_a_data_folder_that_waits_for_its_name_survives_whatever_is_written_beside_it(
    new: Path, old: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("app.project.copying.settle", lambda _path: None)  # killed just before
    drain(copy(new, old))
    monkeypatch.undo()
    atomic.write_bytes(old.parent / "export.csv", b"1")
    assert whole(old) == "new"


def failing(number: int, act: object) -> list[int]:
    """Let `act` happen at the `number`th operation on a file; the count of them so far."""
    count = [0]

    def fault(_operation: str, _path: Path) -> None:
        count[0] += 1
        if count[0] == number:
            act()  # type: ignore[operator]

    atomic.fault = fault
    return count


def test_where_any_operation_fails_the_old_project_stays_or_the_new_is_there(
    new: Path, old: Path, tmp_path: Path
) -> None:
    def fail() -> None:
        raise OSError(28, "No space left on device")

    outcomes = []
    try:
        for number in range(1, 200, 2):
            count = failing(number, fail)
            try:
                drain(copy(new, old))
                outcomes.append("new")
            except OutputError:
                outcomes.append(whole(old))
            atomic.fault = None
            assert whole(old) == outcomes[-1]
            if count[0] < number:
                break
            shutil.rmtree(old.parent)
            old.parent.mkdir()
            save(old, "old", "plane")
    finally:
        atomic.fault = None
    assert set(outcomes) == {"old", "new"}
    assert outcomes[0] == "old"
    assert outcomes[-1] == "new"


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
def test_killed_at_any_operation_the_project_is_the_old_one_or_the_new_one(new: Path, old: Path) -> None:
    program = (
        "import os, signal, sys; from pathlib import Path; from app.project.copying import copy\n"
        "from engine.core.steps import drain; from engine.storage import atomic\n"
        "number, seen = int(sys.argv[3]), [0]\n"
        "def fault(operation, path):\n"
        "    seen[0] += 1\n"
        "    if seen[0] == number: os.kill(os.getpid(), signal.SIGKILL)\n"
        "def main():\n"
        "    for number_ in range(1, 300, 3):\n"
        "        globals()['number'] = number_; seen[0] = 0\n"
        "        child = os.fork()\n"
        "        if child == 0:\n"
        "            atomic.fault = fault; drain(copy(Path(sys.argv[1]), Path(sys.argv[2]))); os._exit(0)\n"
        "        ended = os.waitpid(child, 0)[1]\n"
        "        print(ended, flush=True)\n"
        "        if sys.stdin.readline() == '' or ended == 0: return\n"
        "main()\n"
    )
    outcomes = []
    with subprocess.Popen(
        [sys.executable, "-c", program, str(new), str(old), "0"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    ) as copying:
        assert copying.stdin is not None
        assert copying.stdout is not None
        while True:
            ended = int(copying.stdout.readline())
            outcomes.append(whole(old))
            if ended == 0:
                break
            assert os.WTERMSIG(ended) == signal.SIGKILL
            shutil.rmtree(old.parent)
            old.parent.mkdir()
            save(old, "old", "plane")
            copying.stdin.write("next\n")
            copying.stdin.flush()
    assert outcomes[0] == "old"
    assert outcomes[-1] == "new"
    assert len(outcomes) > 10


def test_a_row_that_names_another_folder_moves_nothing(new: Path, tmp_path: Path) -> None:
    import sqlite3

    (tmp_path / "mine").mkdir()
    with sqlite3.connect(new) as connection:
        connection.execute("INSERT INTO meta VALUES (?, 'mine')", (WAITING,))
    connection.close()
    assert whole(new) == "new"
    assert (tmp_path / "mine").is_dir()


def test_an_open_project_and_a_foreign_folder_are_not_replaced(new: Path, old: Path, tmp_path: Path) -> None:
    program = f"from pathlib import Path; from app.project.places import claim; claim(Path({str(old)!r}))"
    with subprocess.Popen(
        [sys.executable, "-c", f"{program}; print(flush=True); input()"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
    ) as other:
        assert other.stdout is not None
        other.stdout.readline()
        with pytest.raises(OutputError, match="open in another window"):
            drain(copy(new, old))
        other.kill()
    assert whole(old) == "old"
    (tmp_path / "Third.lap-data").mkdir()
    with pytest.raises(OutputError, match="exists already"):
        drain(copy(new, tmp_path / "Third.lap"))


def test_a_document_that_could_not_be_written_is_in_the_copy(new: Path, tmp_path: Path) -> None:
    opened = read(new)
    current = dataclasses.replace(opened.current, name="later")
    steps = (*opened.steps, Step("Name", "", opened.current, current))
    own = tmp_path / "own"
    stack = own / "stack-1"
    stack.mkdir(parents=True)
    (stack / "file").write_bytes(b"made in a window that was read-only")
    array = np.zeros((2, 2, 2, 3), np.float32)
    made = ImageStack(array, array[..., 0] > 1, np.zeros(2), None, np.zeros(2), ("a", "b"), "user", folder=stack)
    current = dataclasses.replace(current, stack=made)
    steps = (*steps, Step("Import", "", steps[-1].new, current))
    drain(copy(new, tmp_path / "Copy.lap", now=History(current, steps, 3), own=own))
    found = read(tmp_path / "Copy.lap")
    assert (found.current.name, len(found.steps), found.position) == ("later", 3, 3)
    assert found.state(str(found.steps[0].old)).name == "new"
    assert (data_folder(tmp_path / "Copy.lap") / "stack-1" / "file").is_file()
    new.write_bytes(b"gone")
    shutil.rmtree(data_folder(new))
    drain(
        copy(
            new,
            tmp_path / "Again.lap",
            now=History(dataclasses.replace(current, stack=None), steps[:2], 2),
            is_unreadable=True,
        )
    )
    rescued = read(tmp_path / "Again.lap")
    assert rescued.current.name == "later"
    assert rescued.current.mesh is not None
    assert all(rescued.state(str(step.old)) for step in rescued.steps)


def test_steps_that_only_the_file_knows_are_left_out_where_it_is_gone() -> None:
    one, other = Project(name="one"), Project(name="other")
    steps = (Step("a", "", "state", "state"), Step("b", "", "state", one), Step("c", "", one, other))
    kept = in_memory(History(other, steps, 3))
    assert [step.text for step in kept.steps] == ["c"]
    assert kept.position == 1
    assert in_memory(History(one, steps, 1)).steps == ()


def test_the_verb_replaces_a_collected_project(new: Path, old: Path, lightarc: Command) -> None:
    assert lightarc("project", "collect", new, "-o", old).code != 0
    assert whole(old) == "old"
    assert claim(old)
    release(old)
    assert lightarc("project", "collect", new, "-o", old, "--overwrite").code == 0
    assert whole(old) == "new"
    drain(collect(new, old))
    assert whole(old) == "new"


@pytest.mark.parametrize("name", ['it\'s "quoted"', "two\nlines", "🧵", "a%20b?#c", "e\u0301\u202e", " ", "x" * 240])
def test_a_copy_has_any_name_that_its_folder_can_hold(new: Path, tmp_path: Path, name: str) -> None:
    """The longest leaves room for what SQLite writes beside it."""
    target = tmp_path / "folder" / f"{name}.lap"
    drain(copy(new, target))
    assert whole(target) == "new"
    drain(copy(new, target))
    assert len(list(target.parent.iterdir())) == 2


@pytest.mark.parametrize("length", [244, 250, 300])
def test_a_name_that_is_too_long_is_said_before_anything_is_written(new: Path, tmp_path: Path, length: int) -> None:
    (tmp_path / "long").mkdir()
    with pytest.raises(OutputError, match="too long"):
        drain(copy(new, tmp_path / "long" / f"{'y' * length}.lap"))
    assert not list((tmp_path / "long").iterdir())


def test_a_path_that_sqlite_cannot_hold_is_said(new: Path, tmp_path: Path) -> None:
    folder = tmp_path / ("x" * 240) / ("y" * 240)
    with pytest.raises(OutputError, match="path is too long"):
        drain(copy(new, folder / "Felt.lap"))
    assert not list(folder.iterdir())


def test_data_that_cannot_be_listed_are_not_left_out_without_a_word(
    new: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scandir = os.scandir

    def refuse(place: str) -> object:
        if str(place).endswith("arrays"):
            raise PermissionError(errno.EACCES, "Permission denied", str(place))
        return scandir(place)

    monkeypatch.setattr(os, "scandir", refuse)
    with pytest.raises(FileError, match=r"arrays: cannot be read \(Permission denied\)"):
        drain(copy(new, tmp_path / "c.lap"))
    assert not (tmp_path / "c.lap").exists()
