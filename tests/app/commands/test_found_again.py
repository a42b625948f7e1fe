"""Stacks and materials of settings that were there before: found by the hash of what they were made from."""

from __future__ import annotations

import dataclasses
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app.commands import making
from app.commands.making import keep_stack
from app.document.document import ImportChoices
from app.document.import_choices import choose
from app.project import tidying
from app.project.made import list_notes
from app.project.photographs import take_marks
from app.project.project_file import data_folder, read
from app.window.main_window import MainWindow
from engine.capture.lights.sources import find
from engine.capture.stack import ImageStack
from engine.core.errors import InputError
from engine.core.steps import drain
from engine.storage.file_array import FileArray
from tests.app.opening import open_project


def nothing_made(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> None:
        raise InputError("stack", "was made again", "Find it")

    monkeypatch.setattr(making, "stack_of", refuse)
    monkeypatch.setattr(making, "material_of", refuse)


def import_capture(window: MainWindow, qtbot: Any, drop: Any, photographs: Path) -> MainWindow:
    drop(window, [photographs])
    qtbot.waitUntil(lambda: window.bench.document.project.has_map, timeout=120_000)
    return window


def build(window: MainWindow, qtbot: Any) -> Any:
    """Press the button, wait for the material and its way to the disk."""
    bench = window.bench
    bench.build_material()
    assert bench.building is not None
    with qtbot.waitSignal(bench.building.succeeded, timeout=120_000):
        pass
    qtbot.waitUntil(lambda: window.projects.is_saved, timeout=60_000)
    return bench.document.project


def import_again(window: MainWindow, qtbot: Any) -> Any:
    bench = window.bench
    sources = bench.document.project.sources
    assert sources is not None
    bench.import_photographs(sources)
    assert bench.importing is not None
    with qtbot.waitSignal(bench.importing.succeeded, timeout=120_000):
        pass
    assert bench.building is not None
    with qtbot.waitSignal(bench.building.succeeded, timeout=120_000):
        pass
    qtbot.waitUntil(lambda: window.projects.is_saved, timeout=60_000)
    return bench.document.project


def test_choices_that_are_set_back_find_stack_and_material_also_after_a_restart(
    window: MainWindow, qtbot: Any, drop: Any, photographs: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import_capture(window, qtbot, drop, photographs)
    document, path = window.bench.document, window.projects.path
    first: Any = document.project
    choose(document, "No alignment", motion="none")
    second = import_again(window, qtbot)
    assert second.stack.folder != first.stack.folder
    window.new()
    open_project(window, qtbot, path)
    nothing_made(monkeypatch)
    choose(document, "Alignment", motion="auto")
    third = import_again(window, qtbot)
    assert third.stack.folder == first.stack.folder
    assert np.array_equal(third.material.shading_map.slices, first.material.shading_map.slices)
    assert third.recipe == third.built_from
    assert len(list(data_folder(path).glob("stack-*"))) == 2


def test_a_material_whose_steps_were_undone_and_done_otherwise_is_found(
    window: MainWindow, qtbot: Any, drop: Any, photographs: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import_capture(window, qtbot, drop, photographs)
    document, path = window.bench.document, window.projects.path
    document.change("6 slices", slices=6)
    six = build(window, qtbot).material
    window.undo.trigger()
    window.undo.trigger()
    assert document.project.slices == 8
    document.change("Name", name="Another")
    qtbot.waitUntil(lambda: window.projects.is_saved, timeout=60_000)
    window.new()
    open_project(window, qtbot, path)
    nothing_made(monkeypatch)
    document.change("6 slices", slices=6)
    again = build(window, qtbot).material
    assert np.array_equal(again.shading_map.slices, six.shading_map.slices)
    assert again.name == "Another"
    assert again.brdf == document.project.material.brdf


def test_a_material_whose_data_are_gone_is_built(window: MainWindow, qtbot: Any, drop: Any, photographs: Path) -> None:
    import_capture(window, qtbot, drop, photographs)
    document, path = window.bench.document, window.projects.path
    document.change("6 slices", slices=6)
    six = build(window, qtbot).material
    document.change("8 slices", slices=8)
    build(window, qtbot)
    window.new()
    shutil.rmtree(data_folder(path) / "arrays")
    open_project(window, qtbot, path)
    document.change("6 slices", slices=6)
    assert np.array_equal(build(window, qtbot).material.shading_map.slices, six.shading_map.slices)


def test_a_stack_is_known_by_content_wherever_the_photographs_lie(tmp_path: Path, photographs: Path) -> None:
    choices, folder = ImportChoices(motion="none"), tmp_path / "a.lap-data"
    folder.mkdir()

    def stack(place: Path, choices: ImportChoices) -> ImageStack:
        sources = find([place])
        return drain(keep_stack(sources, choices, drain(take_marks(sources.photographs)), [folder]))

    first = stack(photographs, choices)
    assert isinstance(first.radiance, FileArray)
    pixels, content = first.radiance.path, first.radiance[:].tobytes()
    made = pixels.stat().st_ino
    moved = shutil.copytree(photographs, tmp_path / "moved")
    assert stack(moved, choices).folder == first.folder
    assert pixels.stat().st_ino == made
    other = stack(moved, dataclasses.replace(choices, white_balance="none"))
    assert other.folder != first.folder
    assert isinstance(other.radiance, FileArray)
    assert other.radiance.path == pixels  # which are equal, and lie on the disk once
    with pixels.open("r+b") as file:
        file.seek(200)
        file.write(b"\xff")
    assert stack(moved, choices).folder == first.folder
    assert first.radiance[:].tobytes() == content  # damaged, and made again
    one = sorted(moved.glob("*.png"))[0]
    one.write_bytes((moved / one.name).read_bytes() + b"\0")  # another content, the same image
    assert stack(moved, choices).folder != first.folder


def test_stacks_that_nothing_leads_to_go_when_the_project_is_closed(
    window: MainWindow, qtbot: Any, drop: Any, photographs: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tidying, "KEPT_MATERIALS", 0)
    import_capture(window, qtbot, drop, photographs)
    document, path = window.bench.document, window.projects.path
    first: Any = document.project.stack
    choose(document, "No alignment", motion="none")
    second = import_again(window, qtbot).stack
    assert {second.folder, first.folder} == set(data_folder(path).glob("stack-*"))
    while document.project.stack is second:
        window.undo.trigger()
    document.change("Name", name="Another")
    qtbot.waitUntil(lambda: window.projects.is_saved, timeout=60_000)
    window.new()
    assert list(data_folder(path).glob("stack-*")) == [first.folder]
    assert read(path).current.stack is not None
    assert all(each.present for each in list_notes(path) if each.name == first.folder.name)
