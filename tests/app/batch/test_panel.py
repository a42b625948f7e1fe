"""The batch in the window: started, paused, stopped and gone on with; its captures open as projects."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QWidget

from app.batch.panel import BatchDialog
from app.document.document import Project
from app.help.manual import headings
from app.jobs.jobs import Jobs
from app.project.project_file import read
from app.widgets.panels import Rows


@pytest.fixture
def dialog(qtbot: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[BatchDialog]:
    monkeypatch.setattr("app.batch.run.MAKE", "tests.app.batch.fast:make")
    for name in ("fine", "refuse"):
        (tmp_path / "captures" / name).mkdir(parents=True)
        (tmp_path / "captures" / name / "a.png").write_bytes(b"a")
    window = QWidget()
    qtbot.addWidget(window)
    jobs = Jobs(window)
    dialog = BatchDialog(window, jobs, lambda: Project(slices=5))
    yield dialog
    jobs.close()


def list_rows(dialog: BatchDialog) -> list[list[str]]:
    table = dialog.table
    items = [[table.item(row, column) for column in range(2)] for row in range(table.rowCount())]
    return [[item.text() for item in row if item is not None] for row in items]


def test_f1_asks_for_the_page_of_batches(dialog: BatchDialog, qtbot: Any) -> None:
    """It has a section for each group of choices."""
    dialog.show()
    with qtbot.waitSignal(dialog.help_wanted, timeout=5_000):
        qtbot.keyClick(dialog.table, Qt.Key.Key_F1)
    assert headings("batch") == [rows.title for rows in dialog.findChildren(Rows)]


def test_a_batch_runs_in_the_window(dialog: BatchDialog, qtbot: Any, tmp_path: Path) -> None:
    dialog.show()
    assert not dialog.start.isEnabled()
    dialog.take_output(tmp_path / "results")
    assert dialog.start.toolTip() == "Choose captures"
    dialog.take_sources(str(tmp_path / "captures"))
    assert (dialog.start.text(), dialog.start.isEnabled(), dialog.report.isEnabled()) == ("Start", True, False)
    qtbot.mouseClick(dialog.start, Qt.MouseButton.LeftButton)
    qtbot.mouseClick(dialog.pause, Qt.MouseButton.LeftButton)
    assert dialog.pause.text() == "Resume"
    qtbot.mouseClick(dialog.pause, Qt.MouseButton.LeftButton)
    qtbot.waitUntil(lambda: not dialog.is_running, timeout=60_000)
    assert list_rows(dialog) == [["fine", "Done"], ["refuse", "Failed"]]
    assert dialog.words.text() == "1 of 2 captures are done"
    assert dialog.start.text() == "Go on"
    assert dialog.report.isEnabled()
    assert read(tmp_path / "results" / "template.lap").current.slices == 5
    dialog.table.setCurrentCell(1, 0)
    assert "is <b>no</b> capture" in dialog.words.text()
    opened: list[Path] = []
    dialog.project_wanted.connect(opened.append)
    dialog.rows["fine"].record["project"] = "../../fine.lap"
    dialog.table.cellDoubleClicked.emit(0, 0)
    dialog.table.cellDoubleClicked.emit(1, 0)
    assert opened == [tmp_path / "results" / "fine" / "fine.lap"]


def test_a_folder_of_another_batch_goes_on(dialog: BatchDialog, tmp_path: Path) -> None:
    (tmp_path / "results").mkdir()
    (tmp_path / "results" / "batch.sqlite").write_bytes(b"nothing")
    dialog.take_output(tmp_path / "results")
    assert "is damaged" in dialog.words.text()
    assert list_rows(dialog) == []
