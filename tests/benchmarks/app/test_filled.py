"""A window with work in it has no fault that the eye finds, in its smallest size and with docks at their lowest."""

from __future__ import annotations

from typing import Any

import pytest

from app.window.main_window import MainWindow
from benchmarks.app.faults import faults
from benchmarks.app.filled import fill, states
from tests.app.view.test_baking import sphere
from tests.app.window.test_main_window import fill as fill_capture


@pytest.mark.long
def test_no_state_of_a_filled_window_has_a_fault(window: MainWindow, qtbot: Any) -> None:
    fill_capture(window)
    window.bench.document.change("Ball", mesh=sphere())
    fill(window, lambda done: qtbot.waitUntil(done, timeout=240_000), method="sh", cheap=True)
    window.resize(1024, 700)
    found: dict[str, list[str]] = {}
    for state in states(window):
        qtbot.wait(40)
        if faults(window):
            qtbot.wait(600)  # the layout may not have come to rest
        found[state] = faults(window)
    assert {state: each for state, each in found.items() if each} == {}
