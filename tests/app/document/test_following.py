"""Workspaces follow the document: the one on screen at once, hidden ones part by part, or when they are shown."""

from __future__ import annotations

from collections.abc import Generator
from typing import Any

import pytest
import shiboken6
from PySide6.QtWidgets import QStackedWidget, QWidget

from app.document.document import Project
from app.document.following import Following
from app.document.open_document import Document


class Follower(QWidget):
    """Notes what it is told, in two parts."""

    def __init__(self, document: Document) -> None:
        super().__init__()
        self.told: list[tuple[str, str, str]] = []
        self.following = Following(document, self, self.follow)

    def follow(self, old: Project, new: Project) -> Generator[None]:
        self.told.append(("first", old.name, new.name))
        yield
        self.told.append(("second", old.name, new.name))


Window = tuple[Document, QStackedWidget, Follower, Follower]


def both(old: str, new: str) -> list[tuple[str, str, str]]:
    return [("first", old, new), ("second", old, new)]


@pytest.fixture
def window(qtbot: Any) -> Window:
    document, stack = Document(), QStackedWidget()
    in_front, behind = Follower(document), Follower(document)
    stack.addWidget(in_front)
    stack.addWidget(behind)
    qtbot.addWidget(stack)
    return document, stack, in_front, behind


def test_in_a_window_that_is_not_on_screen_all_are_told_at_once(window: Window) -> None:
    document, _, in_front, behind = window
    name = document.project.name
    document.change("Name", name="oak")
    assert in_front.told == behind.told == both(name, "oak")


def test_what_is_hidden_is_told_later_and_several_changes_as_one(window: Window, qtbot: Any) -> None:
    document, stack, in_front, behind = window
    name = document.project.name
    stack.show()
    document.change("Name", name="oak")
    document.change("Name", name="ash")
    assert in_front.told == both(name, "oak") + both("oak", "ash")
    assert behind.told == []
    qtbot.waitUntil(lambda: len(behind.told) == 2)
    assert behind.told == both(name, "ash")


def test_what_is_shown_has_been_told_everything(window: Window) -> None:
    document, stack, _, behind = window
    name = document.project.name
    stack.show()
    document.change("Name", name="oak")
    assert behind.following.tell_a_part()
    document.change("Name", name="ash")
    stack.setCurrentWidget(behind)
    assert behind.told == both(name, "oak") + both("oak", "ash")
    assert not behind.following.tell_a_part()


def test_one_that_is_gone_is_passed_over(window: Window, qtbot: Any) -> None:
    document, stack, _, behind = window
    last = Follower(document)
    stack.addWidget(last)
    stack.show()
    document.change("Name", name="oak")
    shiboken6.delete(behind)
    qtbot.waitUntil(lambda: len(last.told) == 2)
    assert behind.told == []
