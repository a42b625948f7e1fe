"""The list of photographs: filters, keys and the menu of those that are selected."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtGui import QAction
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QMenu

from app.capture.photograph_list import PhotographColumn, Row
from app.capture.photograph_menu import menu_of
from app.window.main_window import MainWindow
from engine.core.health import Verdict
from engine.images.encode import encode_png
from tests.app.captures import PATIENCE_MS, open_path, quiet
from tests.present import present

ROWS = (
    Row("a.png", 10.0),
    Row("b.png", 20.0, excluded=True),
    Row("c.png", 30.0, verdict=Verdict.WARNING, finding="2 % clipped"),
    Row("d.png", 40.0, verdict=Verdict.NOTE),
    Row("e.png", 50.0, excluded=True, verdict=Verdict.BAD),
)


@pytest.fixture
def column(qapp: object, qtbot: Any) -> PhotographColumn:
    made = PhotographColumn()
    qtbot.addWidget(made)
    made.show_rows(ROWS)
    made.resize(made.width(), 400)
    made.show()
    return made


def show(column: PhotographColumn, name: str) -> None:
    column.filter.setCurrentIndex(column.filter.findData(name))
    column.filter.activated.emit(column.filter.currentIndex())


@pytest.mark.parametrize(
    ("name", "shown"), [("all", [0, 1, 2, 3, 4]), ("used", [0, 2, 3]), ("excluded", [1, 4]), ("warnings", [2, 4])]
)
def test_a_filter_shows_what_it_names_and_how_many_that_are(
    column: PhotographColumn, name: str, shown: list[int]
) -> None:
    show(column, name)
    assert column.list.shown == shown
    assert column.filter.currentText().endswith(f"({len(shown)})")
    assert column.count.text() == "3 of 5"


def test_steps_and_select_all_pass_over_hidden_rows(column: PhotographColumn) -> None:
    photographs = column.list
    photographs.choose(0)
    show(column, "used")
    photographs.step(1)
    assert photographs.currentIndex().row() == 2
    photographs.selectAll()
    assert photographs.selection == [0, 2, 3]
    photographs.step(-1)
    assert photographs.currentIndex().row() == 0
    photographs.step(-1)
    assert photographs.currentIndex().row() == 0


def test_nothing_hidden_stays_selected_when_it_comes_back(column: PhotographColumn) -> None:
    photographs = column.list
    photographs.pick([0, 1, 3])
    photographs.choose(0)
    photographs.pick([0, 1, 3])
    show(column, "used")
    assert photographs.selection == [0, 3]
    show(column, "all")
    assert photographs.selection == [0, 3]


def test_a_photograph_that_leaves_the_filter_gives_way_to_the_next(column: PhotographColumn) -> None:
    photographs = column.list
    show(column, "used")
    photographs.choose(2)
    column.show_rows([*ROWS[:2], Row("c.png", 30.0, excluded=True), *ROWS[3:]])
    assert photographs.currentIndex().row() == 3
    assert photographs.selection == [3]


def test_whoever_asks_for_a_hidden_photograph_sees_all(column: PhotographColumn) -> None:
    show(column, "used")
    column.list.choose(1)
    assert column.list.currentIndex().row() == 1
    assert column.list.filter == column.filter.currentData() == "all"


def test_an_empty_filter_says_so_and_keeps_the_photograph(column: PhotographColumn, qtbot: Any) -> None:
    column.list.choose(2)
    column.show_rows([Row("a.png", 10.0), Row("b.png", 20.0)])
    column.list.choose(1)
    show(column, "warnings")
    assert column.list.shown == []
    assert column.list.selection == []
    assert column.list.currentIndex().row() == 1
    assert not column.grab().isNull()


def test_the_space_bar_asks_for_use(column: PhotographColumn, qtbot: Any) -> None:
    with qtbot.waitSignal(column.list.use_toggled):
        qtbot.keyClick(column.list, Qt.Key.Key_Space)


@pytest.fixture
def capture(window: MainWindow, qtbot: Any, photographs: Path) -> MainWindow:
    return open_path(window, qtbot, photographs, motion="none")


def items(menu: QMenu) -> Iterator[QAction]:
    for action in menu.actions():
        inner = action.menu()
        yield from items(inner) if isinstance(inner, QMenu) else [action]


def item(window: MainWindow, words: str) -> QAction:
    """The entry of the menu that begins so; the menu lives as long as the window."""
    tab = window.capture
    return next(
        each
        for each in items(menu_of(tab, window.bench, tab.list, (tab.magnify,)))
        if each.text().split("\t")[0] == words
    )


def test_several_are_left_out_and_used_in_one_step_each(capture: MainWindow, qtbot: Any) -> None:
    tab, document = capture.capture, capture.bench.document
    names = present(document.project.stack).sources
    tab.list.pick([1, 3])
    steps = document.undo_stack.count()
    assert not item(capture, "Use 2 photographs").isEnabled()
    item(capture, "Exclude 2 photographs").trigger()
    assert document.project.excluded == {names[1], names[3]}
    assert document.undo_stack.count() == steps + 1
    tab.list.pick([0, 1])
    item(capture, "Use 2 photographs").trigger()
    assert document.project.excluded == {names[3]}
    item(capture, "Use only these").trigger()
    assert document.project.excluded == set(names[2:])
    item(capture, "Invert selection").trigger()
    assert tab.list.selection == [2, 3, 4]
    qtbot.keyClick(tab.list, Qt.Key.Key_Space)
    assert not document.project.excluded
    capture.undo.trigger()
    assert document.project.excluded == set(names[2:])
    place = tab.list.visualRect(tab.list.photographs.index(1)).center()
    QTest.mouseClick(tab.list.viewport(), Qt.MouseButton.RightButton, pos=place)
    tab.list.customContextMenuRequested.emit(QPoint(place))
    shown = [menu for menu in tab.findChildren(QMenu) if menu.isVisible()]
    assert len(shown) == 1
    assert tab.list.selection == [1]
    shown[0].close()


def test_a_file_takes_the_place_of_another_in_one_step(
    capture: MainWindow, qtbot: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    tab, document = capture.capture, capture.bench.document
    sources, before = present(document.project.sources), present(document.project.stack)
    tab.list.pick([0, 1])
    for words in ("Replace file…", "Show file", "Dark frame"):
        assert item(capture, words).toolTip() == "Select one photograph"
    tab.list.choose(1)
    opened_at: list[str] = []
    show_url = "app.capture.photograph_menu.QDesktopServices.openUrl"
    monkeypatch.setattr(show_url, lambda url: opened_at.append(url.toLocalFile()))
    item(capture, "Show file").trigger()
    assert opened_at == [str(sources.photographs[1].parent)]
    other, ask = tmp_path / "again.png", "app.capture.photograph_menu.QFileDialog.getOpenFileName"
    other.write_bytes(encode_png(np.full((96, 128, 3), 9000, np.uint16)))
    monkeypatch.setattr(ask, lambda *_arguments: (str(other), ""))
    capture.bench.set_excluded({sources.photographs[1].name}, True)
    item(capture, "Replace file…").trigger()
    qtbot.waitUntil(lambda: document.project.stack is not before and quiet(capture), timeout=PATIENCE_MS)
    stack = present(document.project.stack)
    assert stack.sources == (before.sources[0], "again.png", *before.sources[2:])
    assert stack.elevation_deg.tolist() == before.elevation_deg.tolist()
    assert not document.project.excluded
    texts = [document.undo_stack.text(at) for at in range(document.undo_stack.count())]
    assert texts[-2:] == [f"Replace {sources.photographs[1].name}", "Build material"]
    capture.undo.trigger()
    capture.undo.trigger()
    assert document.project.stack is before
    assert document.project.sources is sources


def test_a_photograph_has_a_purpose(capture: MainWindow, qtbot: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    tab, document = capture.capture, capture.bench.document
    sources = present(document.project.sources)
    first = sources.photographs[0]
    tab.list.choose(0)
    item(capture, "Reference of the alignment").trigger()
    assert document.project.import_choices.reference == first.name
    assert item(capture, "Reference of the alignment").toolTip() == "All are aligned to it already"
    asked: list[tuple[Any, ...]] = []
    monkeypatch.setattr(capture.bench, "import_photographs", lambda *arguments: asked.append(arguments))
    for words, name in (("Dark frame", "dark"), ("Flat field", "flat")):
        item(capture, words).trigger()
        qtbot.waitUntil(lambda: bool(asked), timeout=PATIENCE_MS)
        changed, choices, _, step = asked.pop()
        assert changed.photographs == sources.photographs[1:]
        assert getattr(choices, name) == first
        assert choices.reference is None
        assert step == f"{words}: {first.name}"
