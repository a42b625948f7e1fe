"""The start page without a window: projects arrive in pieces, can be searched, and are managed in jobs."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import QEvent, QPoint, Qt
from PySide6.QtGui import QFocusEvent, QImage
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from app.commands.workbench import Workbench
from app.document.document import Project
from app.project.places import new_path, projects_folder
from app.project.project_file import History, Writer, data_folder
from app.project.thumbnail import SIZE, keep_thumbnail, thumbnail_of
from app.start import page as start_page
from app.start.page import StartPage
from app.window.recent import thumbnail
from engine.core.errors import InputError
from engine.core.steps import drain
from engine.images.encode import encode_png


def save(path: Path, name: str) -> Path:
    data_folder(path).mkdir(parents=True)
    writer = Writer(path)
    writer.write(History(Project(name=name)))
    writer.close()
    return path


@pytest.fixture
def page(qapp: QApplication, qtbot: Any, tmp_path: Path) -> Iterator[StartPage]:
    bench = Workbench(tmp_path)
    remembered = [tmp_path / "Linen.lap", tmp_path / "Bomb.lap", tmp_path / "gone.lap"]
    made = StartPage(
        bench, projects_folder(), lambda: remembered, lambda: tmp_path / "Open.lap", lambda: True, thumbnail
    )
    made.resize(1280, 680)
    made.show()
    yield made
    bench.jobs.close()
    made.close()
    made.deleteLater()
    QApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete)


def test_projects_are_listed_searched_renamed_cleaned_up_and_moved_to_the_trash(
    page: StartPage, qtbot: Any, tmp_path: Path
) -> None:
    untitled, linen, bomb = new_path(projects_folder()), tmp_path / "Linen.lap", tmp_path / "Bomb.lap"
    for path, name in ((untitled, "Felt"), (linen, "Linen"), (bomb, "Bomb")):
        save(path, name)
    drain(keep_thumbnail(untitled, Project(name="Felt")))
    thumbnail_of(linen).write_bytes(encode_png(np.full((SIZE[1], SIZE[0], 3), 200, np.uint8)))
    thumbnail_of(bomb).write_bytes(encode_png(np.zeros((2000, 2000, 3), np.uint8)))
    model = page.list.projects
    assert not page.projects.isVisible()  # a first start: examples alone
    page.read()
    qtbot.waitUntil(lambda: len(model.sizes) == 3 and not page.bench.jobs.active)
    assert page.projects.isVisible()
    assert {each.name for each in model.shown} == {"Felt", "Linen", "Bomb"}
    assert set(model.thumbnails) == {linen}  # an image that is larger than a thumbnail is not decoded
    assert page.count.text().startswith("3 projects, ")
    QTest.keyClicks(page.search, "LIN")
    assert [each.name for each in model.shown] == ["Linen"]
    page.search.setText("nothing like it")
    assert page.nothing.isVisible()
    assert not page.open_button.isEnabled()
    page.search.clear()
    page.list.select(untitled)
    opened: list[Path] = []
    page.open_wanted.connect(opened.append)
    QTest.keyClick(page.list, Qt.Key.Key_Return)
    assert opened == [untitled]
    page.renamed.connect(lambda _old, new: setattr(page, "remembered", lambda: [new, bomb]))
    with qtbot.waitSignal(page.renamed) as renamed:
        page.rename(linen, "Fine: linen")
    assert renamed.args == [linen, tmp_path / "Fine linen.lap"]
    qtbot.waitUntil(lambda: not page.bench.jobs.active)
    page.list.select(tmp_path / "Fine linen.lap")
    page.commands["clean"].click()
    qtbot.waitUntil(lambda: not page.bench.jobs.active)
    with qtbot.waitSignal(page.gone) as gone:
        page.commands["trash"].click()
    assert gone.args == [tmp_path / "Fine linen.lap"]
    qtbot.waitUntil(lambda: len(model.all) == 2 and not page.bench.jobs.active)
    assert page.list.project is None  # the next press of Delete meets no other project
    failures: list[object] = []
    page.bench.jobs.failed.connect(lambda _job, error: failures.append(error))
    page.rename(bomb, "Bomb")
    page.rename(linen, "Anything")  # it is gone
    qtbot.waitUntil(lambda: not page.bench.jobs.active)
    assert [type(each) for each in failures] == [InputError]


def test_the_open_project_can_be_opened_and_shown_but_not_moved_away(
    page: StartPage, qtbot: Any, tmp_path: Path
) -> None:
    path = save(tmp_path / "Open.lap", "Open")
    page.remembered = lambda: [path]
    page.read()
    qtbot.waitUntil(lambda: bool(page.list.projects.all) and not page.bench.jobs.active)
    page.list.select(path)
    enabled = {name for name, made in page.commands.items() if made.isEnabled()}
    assert enabled == {"show", "clean"}
    assert "open in this window" in page.commands["trash"].toolTip()
    with qtbot.waitSignal(page.clean_wanted):
        page.commands["clean"].click()
    assert not page.bench.jobs.active  # the window closes it first
    page.is_worth_keeping = lambda: False  # nothing was done in it: it is no project of the user yet
    page.read()
    qtbot.waitUntil(lambda: not page.bench.jobs.active)
    assert not page.list.projects.all


def test_a_pointer_or_a_focus_that_comes_to_a_card_or_a_project_is_told_of(
    page: StartPage, qtbot: Any, tmp_path: Path
) -> None:
    page.remembered = lambda: [save(tmp_path / "Open.lap", "Open")]
    page.read()
    qtbot.waitUntil(lambda: bool(page.list.projects.all) and not page.bench.jobs.active)
    told: list[int] = []
    page.approached.connect(lambda: told.append(0))
    page.setFocus()
    assert not told
    for place in (page.cards[0], page.points[1], page.list.viewport()):
        told.clear()
        QTest.mouseMove(place, QPoint(20, 20))
        qtbot.waitUntil(lambda: bool(told))
    told.clear()
    QApplication.sendEvent(page.points[0], QFocusEvent(QEvent.Type.FocusIn, Qt.FocusReason.TabFocusReason))
    assert told


def test_the_first_click_on_an_example_asks_for_it_once(page: StartPage, qtbot: Any) -> None:
    asked: list[object] = []
    page.example_wanted.connect(asked.append)
    card = page.cards[0]
    QTest.mouseClick(card, Qt.MouseButton.LeftButton, Qt.KeyboardModifier.NoModifier, QPoint(40, 40))
    page.show_opening(card.example)
    QTest.mouseClick(page.cards[-1], Qt.MouseButton.LeftButton)
    assert asked == [card.example]
    page.show_opening(None)
    card.setFocus()
    QTest.keyClick(card, Qt.Key.Key_Return)
    assert asked == [card.example] * 2
    started: list[str] = []
    page.start_wanted.connect(started.append)
    for point in page.points:
        point.click()
    assert started == ["photographs", "brdf", "model"]
    assert isinstance(start_page.ExampleCard(card.example).image, QImage)
