"""Safety S7: memory, threads and processes run out; each ends in exit code 6 and one sentence, and nothing is left."""

from __future__ import annotations

import subprocess
import sys
import threading
from pathlib import Path
from typing import Any, cast

import pytest

from app.jobs.jobs import Jobs, _Thread
from app.window.failures import explain
from engine.core.errors import OutOfMemory
from engine.core.steps import Step
from engine.images.encode import encode_png
from engine.storage import untrusted
from tests.app.command import Command
from tests.engine.storage.test_damage import NOISE

PROJECT = Path(__file__).resolve().parents[2]
LINUX = pytest.mark.skipif(sys.platform != "linux", reason="limits of the address space are kept on Linux alone")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Two tiny photographs."""
    folder = tmp_path / "photographs"
    folder.mkdir()
    for angle in (30, 60):
        (folder / f"cloth_{angle}deg.png").write_bytes(encode_png(NOISE // (90 // angle)))
    return folder


@LINUX
def test_a_image_for_which_there_is_no_memory_is_refused_with_what_it_needs(tmp_path: Path) -> None:
    """8000 × 8000 pixels in 2 GiB of address space; LLVM and Mesa alone take the first."""
    words = ["render", "sphere", "--width", "8000", "--height", "8000", "--mode", "reference", "-o", tmp_path / "a.exr"]
    limited = (
        "import resource, sys; resource.setrlimit(resource.RLIMIT_AS, (2 << 30, 2 << 30)); "
        "from app.__main__ import main; main()"
    )
    done = subprocess.run(
        [sys.executable, "-c", limited, *cast(Any, words)], cwd=PROJECT, capture_output=True, text=True
    )
    assert done.returncode == 6, done.stderr
    assert done.stderr.startswith("There is not enough memory: ")
    assert done.stderr.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


@LINUX
def test_cpp_that_finds_no_memory_says_so_and_ends_with_the_same_code(tmp_path: Path) -> None:
    """An exception of C++ that nobody catches ends in std::terminate, which is called here by itself."""
    code = (
        "import ctypes; from app.process import last_words; last_words.leave_last_words('No memory.', 6); "
        "ctypes.CDLL('libstdc++.so.6')['_ZSt9terminatev']()"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=PROJECT, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (6, "No memory.\n")


@pytest.mark.parametrize("allowed", [0, *(pytest.param(count, marks=pytest.mark.long) for count in (1, 2)), 3])
def test_an_import_ends_whichever_thread_cannot_be_started(
    lightarc: Command, folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, allowed: int
) -> None:
    untrusted.stop_children()
    before, started = threading.Thread.start, 0

    def start(thread: threading.Thread) -> None:
        nonlocal started
        started += 1
        if started > allowed:
            raise RuntimeError("can't start new thread")
        before(thread)

    monkeypatch.setattr(threading.Thread, "start", start)
    monkeypatch.setattr(untrusted, "_ahead", cast(Any, untrusted).futures.ThreadPoolExecutor(untrusted.CHILDREN))
    ended = lightarc("import", folder, "-o", tmp_path / "stack", "--no-align")
    assert started > allowed
    assert (ended.code, ended.err) == (6, f"{OutOfMemory('No further thread can be started')}\n")
    monkeypatch.undo()
    assert not (tmp_path / "stack").exists()
    assert lightarc("import", folder, "-o", tmp_path / "stack", "--no-align").code == 0


def test_a_decoder_that_cannot_be_started_ends_the_import(
    lightarc: Command, folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fork(*_: Any, **__: Any) -> Any:
        raise BlockingIOError(11, "Resource temporarily unavailable")

    untrusted.stop_children()
    monkeypatch.setattr(cast(Any, untrusted).subprocess, "Popen", fork)
    ended = lightarc("import", folder, "-o", tmp_path / "stack", "--no-align")
    assert (ended.code, ended.err) == (6, f"{OutOfMemory('No further process can be started')}\n")
    assert not (tmp_path / "stack").exists()


def test_a_job_whose_thread_cannot_be_started_fails_and_the_next_one_runs(
    qtbot: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    def work() -> Any:
        yield Step(0.5, "at work")

    jobs = Jobs()
    monkeypatch.setattr(_Thread, "start", lambda _thread: None)
    failed = jobs.submit("Work", work, lane="compute")
    reasons: list[BaseException] = []
    failed.failed.connect(reasons.append)
    qtbot.waitUntil(lambda: failed.over)
    assert [str(reason) for reason in reasons] == [str(OutOfMemory("No further thread can be started"))]
    monkeypatch.undo()
    second = jobs.submit("Work", work, lane="compute")
    qtbot.waitUntil(lambda: second.over)
    assert second.state == "succeeded"


def test_the_window_says_that_memory_is_short_and_that_the_work_is_there() -> None:
    for error in (MemoryError(), RuntimeError("can't start new thread")):
        message, detail = explain(error)
        assert "Your work is still here. Close other programs" in message
        assert detail == ""
