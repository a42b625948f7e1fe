"""The mode chooser shows what was measured of each mode, and uses the one that is chosen."""

from __future__ import annotations

import dataclasses
from typing import Any

from app.document.document import Project
from app.document.measured import Accuracy
from app.document.modes import modes
from app.help.mode_chooser import ModeChooser
from app.window.main_window import MainWindow
from tests.app.docks.test_accuracy import POINTS
from tests.present import present


def test_each_mode_has_the_measurement_with_the_least_error(window: MainWindow, qtbot: Any) -> None:
    of_direct = tuple(each for each in POINTS if each.mode == "direct")
    assert len(of_direct) == 2
    project = dataclasses.replace(Project(), accuracy=Accuracy(of_direct, (), (32, 32), 4, "this machine"))
    chooser = ModeChooser(window, project)
    rows = {mode.value: at for at, mode in enumerate(modes())}
    assert present(chooser.table.item(rows["direct"], 2)).text().startswith("15")
    assert present(chooser.table.item(rows["sh"], 2)).text() == "–"
    assert "this machine" in chooser.words.text()
    chooser.table.setCurrentCell(rows["sh"], 0)
    with qtbot.waitSignal(chooser.mode_wanted) as wanted:
        chooser.use.click()
    assert wanted.args == ["sh"]
