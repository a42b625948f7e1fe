"""An archive of photographs that is dropped on the window is imported as its folder would be."""

from __future__ import annotations

import dataclasses
import shutil
from pathlib import Path
from typing import Any

from app.window.main_window import MainWindow


def test_a_dropped_archive_becomes_a_material_and_can_be_imported_again(
    window: MainWindow, qtbot: Any, drop: Any, photographs: Path, tmp_path: Path
) -> None:
    archive = Path(shutil.make_archive(str(tmp_path / "Red felt"), "zip", photographs))
    document = window.bench.document
    drop(window, [archive])
    qtbot.waitUntil(lambda: document.project.has_map, timeout=240_000)
    assert document.project.name == "Red felt"
    assert document.project.stack is not None
    assert document.project.stack.provenance["archive"] == "Red felt.zip"
    first = document.project.stack
    assert document.project.sources is not None
    otherwise = dataclasses.replace(document.project.import_choices, motion="none")
    window.bench.import_photographs(document.project.sources, otherwise)
    qtbot.waitUntil(lambda: document.project.stack is not first, timeout=240_000)
    assert not window.failures.open_dialogs
    qtbot.waitUntil(lambda: not window.bench.jobs.active, timeout=240_000)
