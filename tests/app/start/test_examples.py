"""The shipped examples: whole, of this schema, small, and each opens as a new untitled project."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO

import pytest
from PySide6.QtGui import QImageReader

from app.docks.health import parts_of, worst_of
from app.project.database import SCHEMA, connect, schema_of
from app.project.factors import place_of
from app.project.pixels import are_there
from app.project.places import is_untitled, projects_folder
from app.project.project_file import data_folder, read
from app.project.thumbnail import thumbnail_of, title_of
from app.start import examples
from app.start.examples import EXAMPLES, Example, unpack
from app.window.main_window import MainWindow
from engine.core.errors import OutputError
from engine.core.health import Verdict
from engine.core.steps import drain
from engine.storage.atomic import atomic_file

#: Bytes of an installed program that all examples may take.
MAX_BYTES = 12e6


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda example: example.name)
def test_an_example_opens_whole_as_an_untitled_project(example: Example, tmp_path: Path) -> None:
    path = drain(unpack(example, projects_folder()))
    assert is_untitled(path)
    with connect(path) as connection:
        assert schema_of(connection, path) == SCHEMA, "run packaging/make_gallery.py"
    found = read(path)
    project = found.current
    assert not found.missing
    assert not found.steps
    assert project.has_map or project.material.measured is not None
    assert project.camera is not None
    assert title_of(path) == project.name
    assert thumbnail_of(path).is_file()
    assert all(photograph.is_file() for photograph in project.sources.photographs) if project.sources else True
    assert QImageReader(str(example.image)).size().width() >= 900
    kept = {path.name for path in data_folder(path).glob("factors-*")}
    assert kept == {place_of(run, data_folder(path)).name for run in project.factoring.runs}
    again = drain(unpack(example, projects_folder()))
    assert again != path


def test_all_examples_together_are_small() -> None:
    assert sum(each.archive.stat().st_size + each.image.stat().st_size for each in EXAMPLES) < MAX_BYTES


def test_an_interrupted_example_leaves_no_project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    written: list[Path] = []

    @contextmanager
    def full(path: Path, size_bytes: int) -> Iterator[BinaryIO]:
        written.append(path)
        if len(written) == 3:
            raise OutputError(path, "the disk is full", "Free some space")
        with atomic_file(path, size_bytes) as file:
            yield file

    monkeypatch.setattr(examples, "atomic_file", full)
    with pytest.raises(OutputError):
        drain(unpack(EXAMPLES[0], tmp_path))
    assert len(written) == 3
    assert not list(tmp_path.iterdir())


def test_examples_open_beside_the_open_project_and_go_when_nothing_was_done(window: MainWindow, qtbot: Any) -> None:
    window.show_start()
    assert not any(each.isChecked() for each in window.bar.buttons.buttons())
    document, own = window.bench.document, window.projects.folder
    document.change("Name", name="My own", notes="kept")
    own_path = window.projects.path
    cards = {card.example.name: card for card in window.starting.page.cards}
    window._expects_work = False
    cards["woven"].approached.emit()
    assert window._expects_work  # what an example needs loads before the click
    cards["woven"].click()
    qtbot.waitUntil(lambda: document.project.name == "Woven cloth", timeout=60_000)
    qtbot.waitUntil(lambda: window.stack.currentWidget() is window.view)
    first = window.projects.path
    assert first.parent == own
    stack = document.project.stack
    assert stack is not None
    assert worst_of(parts_of(document.project, None, [])).verdict < Verdict.WARNING
    qtbot.wait(50)
    assert window.restoring._job is None  # nobody looks at its photographs
    assert not are_there(stack)
    window.show_workspace("capture")
    qtbot.waitUntil(lambda: are_there(stack), timeout=60_000)
    window.show_start()
    cards["medal"].click()
    qtbot.waitUntil(lambda: document.project.name == "Bronze medal", timeout=60_000)
    assert worst_of(parts_of(document.project, None, [])).verdict < Verdict.WARNING
    assert not first.exists()  # nothing was done in it
    assert not data_folder(first).exists()
    second = window.projects.path
    document.change("Notes", notes="mine now")
    qtbot.waitUntil(lambda: window.settings.now.recent_projects[:1] == (str(second),), timeout=60_000)
    assert window.settings.now.last_folder == str(Path.home())  # a dialog begins there, not among unnamed projects
    window.new()
    assert second.exists()
    assert own_path.exists()
