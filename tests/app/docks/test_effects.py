"""The Effects dock: the plan of the scene on screen, what is forced or left out, and its budget."""

from __future__ import annotations

import dataclasses
from typing import Any

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication

from app.docks.effects import CELL, row_forms, row_text
from app.widgets.labels import NAMES
from app.window.main_window import MainWindow
from engine.planning.effects.estimates import EFFECTS
from engine.planning.plan import Effect
from tests.app.view.test_baking import LONG, ball, built_in


@pytest.fixture
def planned(window: MainWindow, qtbot: Any) -> MainWindow:
    """The plan of a diffuse ball under a sky."""
    document = window.bench.document
    material = dataclasses.replace(document.project.material, brdf="lambert:albedo=0.5")
    document.change("Ball", mesh=ball(), environment=built_in("sky"), material=material)
    window.show_workspace("view")
    qtbot.waitUntil(lambda: window.docks.effects.plan is not None, timeout=LONG)
    return window


def row(window: MainWindow, effect: str) -> str:
    place = EFFECTS.index(effect)
    items = (window.docks.effects.table.item(place, column) for column in range(2))
    return " ".join(item.text() for item in items if item is not None)


def test_every_effect_has_a_name() -> None:
    assert set(NAMES) == set(EFFECTS)


def test_the_plan_is_shown_forced_and_undone(planned: MainWindow, qtbot: Any) -> None:
    dock = planned.docks.effects
    assert dock.table.rowCount() == len(EFFECTS)
    assert row(planned, "self-shadowing").startswith("○")
    assert "skipped" in row(planned, "self-shadowing")
    wish = dock.wishes["self-shadowing"]
    wish.setCurrentIndex(wish.findData("on"))
    wish.activated.emit(0)
    assert planned.bench.document.project.look.forced == ("self-shadowing",)
    qtbot.waitUntil(lambda: "forced on" in row(planned, "self-shadowing"), timeout=LONG)
    wish.setCurrentIndex(wish.findData("off"))
    wish.activated.emit(0)
    look = planned.bench.document.project.look
    assert (look.forced, look.skipped) == ((), ("self-shadowing",))
    planned.bench.document.undo_stack.undo()
    planned.bench.document.undo_stack.undo()
    assert planned.bench.document.project.look.skipped == ()


def test_the_plan_is_applied_to_the_mode(planned: MainWindow) -> None:
    dock = planned.docks.effects
    assert dock.plan is not None
    dock.apply.click()
    assert planned.view.setting.mode == dock.plan.mode


def test_a_budget_is_read_and_refused(planned: MainWindow, qtbot: Any) -> None:
    dock = planned.docks.effects
    before = dock.plan
    dock.budget.setText("8 ms")
    dock.budget.editingFinished.emit()
    qtbot.waitUntil(lambda: dock.plan is not before and dock.plan is not None, timeout=LONG)
    dock.budget.setText("soon")
    dock.budget.editingFinished.emit()
    assert "Enter the budget" in dock.words.text()
    assert not dock.apply.isEnabled()
    assert planned.bench.document.project.look.plan_budget == "soon"


def test_without_an_environment_it_says_what_is_needed(planned: MainWindow) -> None:
    planned.bench.document.change("One light", environment=None)
    assert "needs an environment" in planned.docks.effects.words.text()
    assert planned.docks.effects.plan is None
    assert planned.docks.effects.table.isHidden()  # an empty one would put the words far below


@pytest.mark.parametrize(
    ("effect", "words"),
    [
        (Effect("glossy", "needed", "", 0.12, 3.0, 10**7), "needed, 12 % without it"),
        (Effect("glossy", "skipped", "", 0.002, 41.0, 0), "skipped, 0.2 % for 41 s"),
        (Effect("glossy", "skipped", "", 0.0, 0.0, 0), "skipped, no loss"),
        (Effect("glossy", "forced off", "", 0.5, 250.0, 2 * 10**6), "forced off, 50 % for 4.2 min and 2 MB"),
    ],
)
def test_rows_say_what_is_lost_and_saved(effect: Effect, words: str) -> None:
    assert row_text(effect) == words


def test_rows_have_shorter_forms_for_narrow_docks() -> None:
    effect = Effect("glossy", "skipped", "", 0.002, 41.0, 0)
    assert row_forms(effect) == ("skipped, 0.2 % for 41 s", "skipped, 0.2 %", "0.2 %")


@pytest.mark.dressed
def test_a_narrow_dock_cuts_no_words(planned: MainWindow) -> None:
    dock = planned.docks.effects
    for width in (300, 420, 640):
        dock.setFloating(True)
        dock.resize(width, 300)
        QApplication.processEvents()
        room = dock.table.columnWidth(1) - 2 * CELL
        shown = [dock.table.item(place, 1) for place in range(dock.table.rowCount())]
        assert all(
            dock.table.fontMetrics().horizontalAdvance(item.text()) <= room for item in shown if item is not None
        )
        assert all(item.text() in item.data(Qt.ItemDataRole.UserRole) for item in shown if item is not None)
