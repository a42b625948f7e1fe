"""Kernels that are made ready while photographs are awaited: those that an import and a material then call."""

from __future__ import annotations

import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

import app.watch.kernels as module
from app.watch.kernels import load_kernels, load_kernels_beside
from engine.capture.arriving import Arrived, Capture
from engine.capture.import_plan import ImportSettings
from engine.core.steps import Step, Steps, drain
from tests.engine.capture.calibration.generated import Capture as Generated
from tests.engine.capture.calibration.generated import render, write

ROOT = Path(__file__).parents[3]

#: Prints the kernels that numba is asked for while a capture is imported and its material made, though others have been
#: made ready.
PROGRAM = """
import sys
from pathlib import Path
from engine.core import kernels
asked, make, begun = [], kernels._njit, False
def make_noted(function, **options):
    made = make(function, **options)
    load = made._cache.load_overload
    def note(types, target):
        if begun:
            asked.append(function.__name__)
        return load(types, target)
    made._cache.load_overload = note
    return made
kernels._njit = make_noted
from app.commands.making import material_of
from app.document.document import Project
from app.watch.kernels import load_kernels
from engine.capture.import_plan import ImportSettings
from engine.capture.import_stack import import_stack
from engine.capture.lights.sources import find
from engine.core.steps import drain
load_kernels(ImportSettings())
begun = True
stack = drain(import_stack(find([Path(sys.argv[1])]), ImportSettings(), Path(sys.argv[2])))
drain(material_of(Project(name="kernels", stack=stack)))
print(*sorted(set(asked)))
"""


def test_an_import_and_a_material_call_no_kernel_that_is_not_ready(tmp_path: Path) -> None:
    made = Generated(seed=3, material="satin metal", file_format="jpg", lamps=12, height=64, width=72)
    folder = write(render(made), tmp_path / "taken")
    command = [sys.executable, "-c", PROGRAM, str(folder), str(tmp_path / "stack")]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False, cwd=ROOT)
    assert done.returncode == 0, done.stderr
    assert set(done.stdout.split()) <= {"decode_codes", "_sum", "_count"}, "what photographs need as they come"


def _arrive(*counts: int) -> Steps[Capture]:
    photographs = tuple(Arrived(Path(f"{at}.jpg"), None, None, ()) for at in range(max(counts)))
    capture = Capture()
    for count in counts:
        capture = Capture(photographs[:count])
        yield Step(0.0, "", capture)
        yield Step(0.0, "")
    return capture


@pytest.fixture
def loaded(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[str]]:
    """Names of the threads on which kernels were made ready, by captures in which each photograph counts."""
    found: list[str] = []
    monkeypatch.setattr(Capture, "count", property(lambda capture: len(capture.photographs)))
    for name in ("_decode_codes", "_make_maps"):
        monkeypatch.setattr(module, name, lambda: found.append(threading.current_thread().name))
    yield found
    assert not [each for each in threading.enumerate() if each.name == "kernels"]


def _wait_for_threads() -> None:
    for thread in threading.enumerate():
        if thread.name == "kernels":
            thread.join(60.0)


def test_they_are_made_ready_once_when_two_photographs_are_there(loaded: list[str]) -> None:
    settings = ImportSettings(calibrate="none")
    assert len(drain(load_kernels_beside(_arrive(0, 1), settings)).photographs) == 1
    _wait_for_threads()
    assert not loaded
    steps = load_kernels_beside(_arrive(1, 2, 3), settings)
    for step in steps:
        if step.partial is not None and step.partial.count == 3:
            _wait_for_threads()
    assert loaded == ["kernels", "kernels"]


def test_nothing_more_is_begun_when_the_photographs_have_ended(
    loaded: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    begun, ended = threading.Event(), threading.Event()

    def last() -> None:
        begun.set()
        ended.wait(60.0)

    monkeypatch.setattr(module, "_decode_codes", last)

    def arrive() -> Steps[Capture]:
        yield from _arrive(2)
        assert begun.wait(60.0)
        return Capture()

    drain(load_kernels_beside(arrive(), ImportSettings(calibrate="none")))
    ended.set()
    _wait_for_threads()
    assert not loaded


@pytest.mark.parametrize("reason", ["has_memory_limit", "threads_are_shared"])
def test_kernels_are_left_to_their_callers_where_memory_or_threads_are_limited(
    loaded: list[str], monkeypatch: pytest.MonkeyPatch, reason: str
) -> None:
    monkeypatch.setattr(module, reason, lambda: reason == "has_memory_limit")
    load_kernels(ImportSettings(calibrate="none"))
    assert not loaded
