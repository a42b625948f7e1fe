"""A crash leaves one report, of which the next start tells once; an ordinary end leaves none."""

from __future__ import annotations

import faulthandler
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from app.process import crash
from app.process.crash import make_handler
from engine.storage.writer import writer
from tests.processes import is_gone

PROJECT = Path(__file__).resolve().parents[3]

FALLS = """
import faulthandler
from app.process import crash
crash.begin()
def the_place():
    faulthandler._sigsegv()
the_place()
"""


@pytest.fixture
def logs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(crash, "report_folder", lambda: tmp_path)
    return tmp_path


def test_a_crash_is_reported_once_and_an_ordinary_end_leaves_nothing(logs: Path) -> None:
    program = FALLS.replace(
        "crash.begin()", f"import pathlib; crash.report_folder = lambda: pathlib.Path({str(logs)!r})\ncrash.begin()"
    )
    fallen = subprocess.run([sys.executable, "-c", program], cwd=PROJECT, capture_output=True)
    assert fallen.returncode != 0
    reported = crash.begin()
    crash.end()
    (report,) = logs.iterdir()
    assert str(report) in reported
    assert "the_place" in report.read_text()
    assert crash.begin() == ""
    crash.end()
    assert list(logs.iterdir()) == [report]


def test_a_report_says_what_was_done_with_what_and_where_in_the_native_stack(logs: Path) -> None:
    program = f"""
import ctypes, pathlib
from app.process import crash
crash.report_folder = lambda: pathlib.Path({str(logs)!r})
crash.begin()
crash.state("OpenGL", "a driver, version 3")
for at in range(5000):
    crash.did(f"did {{at}}: Change the light " + "x" * 100)
crash.with_native_stack()
crash.did("warning: the last line")
ctypes.string_at(8)
"""
    fallen = subprocess.run([sys.executable, "-c", program], cwd=PROJECT, capture_output=True)
    assert fallen.returncode == -signal.SIGSEGV
    assert crash.begin()
    crash.end()
    (report,) = logs.iterdir()
    words = report.read_text()
    assert words.startswith("Lightarc: ")
    assert "OpenGL: a driver, version 3\n" in words
    assert words.index("did 4999: Change the light") < words.index("the last line") < words.index("string_at")
    assert "did 10:" not in words
    assert len(words) < 2 * crash.MAX_TRACE
    if sys.platform.startswith("linux"):
        native = words[words.index("string_at") :]
        assert "_ctypes" in native[native.index("Extension modules") :]
        assert "libc.so" in native


def test_what_was_done_goes_with_an_ordinary_end(logs: Path) -> None:
    crash.begin()
    crash.did("did 1: Change the light")
    crash.with_native_stack()
    assert len(list(logs.iterdir())) == 2
    crash.end()
    assert list(logs.iterdir()) == []


def test_an_end_while_native_stacks_are_prepared_stays_quiet(logs: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def make_until_the_end(descriptor: int) -> object:
        handler = make_handler(descriptor)
        crash.end()
        return handler

    monkeypatch.setattr(crash, "make_handler", make_until_the_end)
    crash.begin()
    crash.with_native_stack()
    assert not faulthandler.is_enabled()
    assert list(logs.iterdir()) == []


def test_a_fault_of_python_code_stays_in_a_report_of_bounded_size(logs: Path) -> None:
    crash.begin()
    for _ in range(crash.MAX_BYTES // 1000 + 100):
        crash.note("x" * 1000)
    crash.end()
    report = logs / f"running-{writer()}.txt"
    assert report.with_suffix(".log").is_file()
    assert 0.9 * crash.MAX_BYTES < report.stat().st_size <= crash.MAX_BYTES
    assert str(os.getpid()) in crash.begin()
    crash.end()


def test_few_reports_are_kept_and_empty_ones_vanish(logs: Path) -> None:
    for number in range(30):
        (logs / f"crash-2020-01-01-0000{number:02}-1.txt").write_text("old")
    (logs / f"running-{is_gone()}.txt").touch()
    assert crash.begin() == ""
    crash.end()
    kept = sorted(path.name for path in logs.iterdir())
    assert kept == [f"crash-2020-01-01-0000{number:02}-1.txt" for number in range(20, 30)]


def test_a_folder_that_cannot_be_made_is_no_failure(logs: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (logs / "file").touch()
    monkeypatch.setattr(crash, "report_folder", lambda: logs / "file" / "log")
    assert crash.begin() == ""
    crash.end()
