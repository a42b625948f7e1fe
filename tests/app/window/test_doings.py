"""The doings of a user, noted for the report of a crash."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import shiboken6
from PySide6.QtWidgets import QApplication

from app.commands.workbench import Workbench
from app.process import crash
from app.window.doings import Doings


def test_steps_are_told_until_the_document_goes_also_where_nobody_closed_the_window(
    qapp: QApplication, qtbot: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    told: list[str] = []
    monkeypatch.setattr(crash, "did", told.append)
    bench = Workbench(tmp_path)
    doings = Doings(bench)
    bench.document.change("Name", name="Felt")
    bench.document.undo_stack.undo()
    assert told == ["did 1: Name", "undone to 0: the beginning"]
    shiboken6.delete(bench)  # the stack of its steps says that it is empty; an error in a slot fails the test
    assert told[2:] == []
    del doings
