"""The docks are usable without a mouse and without sight: names of what can be reached, and an order that reads."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from itertools import pairwise
from typing import Any

import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtWidgets import QAbstractButton, QApplication, QComboBox, QDockWidget, QWidget

from app.docks.jobs_and_log import JobsDock
from app.document.bake_request import choices_for, setting_for
from app.view.bake_panel import choices_of
from app.widgets.theme import ROW
from app.window.main_window import MainWindow
from engine.core.steps import Step, Steps
from engine.transport.method import METHODS
from tests.app.view.test_baking import LONG, ball, built_in


@pytest.fixture
def view(window: MainWindow, qtbot: Any) -> MainWindow:
    """All docks of a ball under the studio, planned, with a job that runs."""
    document = window.bench.document
    material = dataclasses.replace(document.project.material, brdf="phong:exponent=5")
    document.change("Ball", mesh=ball(), environment=built_in("studio"), material=material)
    window.show_workspace("view")
    qtbot.waitUntil(lambda: window.docks.effects.plan is not None, timeout=LONG)
    window.bench.jobs.submit("Waiting", _waiting, lane="compute")
    return window


def _waiting() -> Steps[None]:
    for _ in range(10_000):
        yield Step(0.5, "waiting")


def reach(dock: QDockWidget) -> Iterator[QWidget]:
    """The widgets that the key Tab reaches inside a dock, in its order."""
    start = dock.widget()
    assert start is not None
    at = start.nextInFocusChain()
    while at is not None and at is not start:
        takes = at.focusPolicy() & Qt.FocusPolicy.TabFocus
        if start.isAncestorOf(at) and takes and at.isVisible() and at.isEnabled() and at.focusProxy() is None:
            yield at
        at = at.nextInFocusChain()


def docks_of(window: MainWindow) -> list[QDockWidget]:
    return [*window.docks.of_view.docks, *window.docks.others]


def test_everything_in_a_dock_that_takes_the_keyboard_has_a_name(view: MainWindow) -> None:
    named = 0
    for dock in docks_of(view):
        dock.show()
        dock.raise_()
        QApplication.processEvents()
        for widget in reach(dock):
            words = widget.text() if isinstance(widget, QAbstractButton) else ""
            assert widget.accessibleName() or words, f"{dock.windowTitle()}: {widget} has no name"
            named += 1
    assert named >= 15


@pytest.mark.parametrize("size", [(1280, 800), pytest.param((1920, 1080), marks=pytest.mark.long)])
def test_tab_goes_through_docks_as_they_are_read(view: MainWindow, size: tuple[int, int]) -> None:
    view.resize(*size)
    for dock in docks_of(view):
        dock.show()
        dock.raise_()
        QApplication.processEvents()
        seen = (widget for widget in reach(dock) if not widget.visibleRegion().isEmpty())
        places = [(widget.mapTo(dock, QPoint(0, 0)), widget) for widget in seen]
        for (before, one), (behind, other) in pairwise(places):
            is_below = behind.y() >= before.y() - ROW // 2
            is_right_of = behind.x() >= before.x() + one.width()
            assert is_below or is_right_of, f"{dock.windowTitle()}: {other.accessibleName()} comes too late"


def test_effects_are_reached_from_the_first_to_the_plan(view: MainWindow) -> None:
    dock = view.docks.effects
    names = [widget.accessibleName() or widget.text() for widget in reach(dock)]  # type: ignore[attr-defined]
    assert names[0] == "Shadows"
    assert names[-2:] == ["Budget of the plan", "Use this plan"] or names[-1] == "Budget of the plan"
    assert all(isinstance(wish, QComboBox) for wish in dock.wishes.values())


def test_every_choice_of_a_bake_is_a_setting() -> None:
    for method in METHODS:
        for parameter in choices_of(method):
            for value, _words in parameter.offered:
                setting_for(choices_for(method.name, **{parameter.name: value}))


def test_long_names_of_jobs_wrap(view: MainWindow, qtbot: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    dock = view.docks.jobs
    fitted: list[int] = []
    monkeypatch.setattr(dock.table, "resizeRowToContents", fitted.append)
    view.bench.jobs.submit("Factoring the blue paint of the material: singular values", _waiting, lane="compute")
    assert not fitted, "nothing is laid out in a dock that nobody sees"
    dock.show()
    qtbot.waitUntil(lambda: dock.table.rowHeight(0) > dock.table.rowHeight(1), timeout=LONG)


def test_jobs_say_what_will_stand_there(window: MainWindow, qtbot: Any) -> None:
    dock = JobsDock(window.bench.jobs, window)
    nothing, table = (dock.pages.widget(at) for at in range(2))
    assert dock.pages.currentWidget() is nothing
    job = window.bench.jobs.submit("Waiting", _waiting, lane="compute")
    qtbot.waitUntil(lambda: dock.pages.currentWidget() is table, timeout=LONG)
    window.bench.jobs.cancel(job)
