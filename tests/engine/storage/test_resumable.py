"""Resumable files: one writer at a time, kept only where something is worth it, whatever fails."""

from __future__ import annotations

import contextlib
import errno
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from engine.core.errors import OutputError
from engine.storage import atomic
from engine.storage.resumable import discard_unfinished, find_unfinished, resumable_file

ROOT = Path(__file__).resolve().parents[3]

#: Opens the unfinished file of its argument, and waits for a line on standard input before it locks it.
LATECOMER = """
import sys
from engine.storage import atomic
from engine.storage.resumable import resumable_file

def fault(operation, path):
    if operation == "lock" and atomic.fault is fault:
        atomic.fault = None
        print("opened", flush=True)
        sys.stdin.readline()

atomic.fault = fault
with resumable_file(sys.argv[1], 6, b"second") as output:
    print("resumed" if output.resumed else "anew", flush=True)
"""


@pytest.fixture(autouse=True)
def no_fault_stays() -> Iterator[None]:
    yield
    atomic.fault = None


def names(folder: Path) -> list[str]:
    return sorted(entry.name for entry in folder.iterdir())


@pytest.mark.skipif(sys.platform == "win32", reason="an open file cannot be renamed there")
@pytest.mark.parametrize("first", ["finishes", "gives up"])
def test_who_opens_the_file_of_another_writer_late_does_not_write_into_its_result(tmp_path: Path, first: str) -> None:
    path = tmp_path / "a"
    with contextlib.suppress(KeyboardInterrupt), resumable_file(path, 5, b"first"):
        words = [sys.executable, "-c", LATECOMER, str(path)]
        late = subprocess.Popen(words, cwd=ROOT, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        assert late.stdout is not None
        assert late.stdout.readline() == "opened\n"
        if first == "gives up":
            raise KeyboardInterrupt
    result = path.open("rb") if first == "finishes" else contextlib.nullcontext()
    with result as held:
        assert late.communicate("\n")[0] == "anew\n"
        assert held is None or held.read() == b"first"
    assert (path.read_bytes(), names(tmp_path)) == (b"second", ["a"])


def test_the_unfinished_file_of_a_running_writer_is_not_removed(tmp_path: Path) -> None:
    with resumable_file(tmp_path / "a", 5, b"first"):
        with pytest.raises(OutputError, match="a: another run is writing it"):
            discard_unfinished(tmp_path / "a")
        assert find_unfinished(tmp_path / "a") is not None
    assert (tmp_path / "a").read_bytes() == b"first"


def test_a_working_file_that_became_another_one_vanishes(tmp_path: Path) -> None:
    with resumable_file(tmp_path / "a", 100, b"begins") as output:
        output.write_at(6, b"more")
        atomic.write_bytes(tmp_path / "a", b"the result")
        output.discard()
    assert (tmp_path / "a").read_bytes() == b"the result"
    assert names(tmp_path) == ["a"]


@pytest.mark.parametrize("code", [errno.ENOSPC, errno.EIO])
def test_every_operation_fails_and_only_what_is_worth_it_stays(tmp_path: Path, code: int) -> None:
    (tmp_path / "a").write_bytes(b"old")
    for at in range(1, 50):
        count = iter(range(1, 1000))

        def fault(_operation: str, _path: Path, count: Iterator[int] = count, at: int = at) -> None:
            if next(count) == at:
                raise OSError(code, os.strerror(code))

        atomic.fault = fault
        kept = complained = False
        try:
            with resumable_file(tmp_path / "a", 100, b"begins") as output:
                output.write_at(50, b"a chunk")
                kept = output.worth_keeping = True
        except OutputError as error:
            complained = "unfinished" not in str(error)
        atomic.fault = None
        new = (tmp_path / "a").read_bytes() != b"old"
        assert names(tmp_path) == (["a"] if new or not kept else [".a.unfinished", "a"])
        assert new or complained
        discard_unfinished(tmp_path / "a")
        if not complained:
            return
        (tmp_path / "a").write_bytes(b"old")
    pytest.fail("the loop never reached the end of the work")


def test_a_full_disk_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(atomic, "free_bytes", lambda _folder: 99)
    with (
        pytest.raises(OutputError, match=r"a: the disk is full \(100 bytes needed, 99 bytes free\)"),
        resumable_file(tmp_path / "a", 100, b"begins"),
    ):
        pytest.fail("the block must not be entered")
    assert names(tmp_path) == []


def test_strange_files_under_the_hidden_name_stay(tmp_path: Path) -> None:
    (tmp_path / "mine").write_bytes(b"precious")
    for make in (
        lambda place: place.symlink_to("mine"),
        os.mkfifo,
        os.mkdir,
    ):
        place = tmp_path / ".a.unfinished"
        make(place)
        with pytest.raises(OutputError), resumable_file(tmp_path / "a", 100, b"begins"):
            pytest.fail("the block must not be entered")
        assert names(tmp_path) == [".a.unfinished", "mine"]
        place.rmdir() if place.is_dir() else place.unlink()
    assert (tmp_path / "mine").read_bytes() == b"precious"
