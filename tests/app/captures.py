"""Small captures on the virtual light arc for tests of the window, and what is done to them there."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

from PySide6.QtCore import QPointF, Qt
from PySide6.QtTest import QTest

from app.document.document import ImportChoices
from app.window.main_window import MainWindow
from engine.core.steps import drain
from engine.simulate.arc import LightArc
from engine.simulate.simulate import simulate

PATIENCE_MS = 240_000


def capture(folder: Path, **settings: Any) -> tuple[LightArc, dict[str, Any]]:
    """A capture in `folder`, and what is known of each photograph by file name."""
    elevation = tuple(math.radians(angle) for angle in (30, 50, 70))
    arc = LightArc(**{"size": 96, "misalignment_px": 0.0, "elevation": elevation, **settings})
    drain(simulate(arc, folder))
    records = json.loads((folder / "truth" / "truth.json").read_text())["photographs"]
    return arc, {record["file"]: record for record in records}


def open_path(window: MainWindow, qtbot: Any, folder: Path, **choices: Any) -> MainWindow:
    """The window with the capture imported by `choices`, of which those for another capture hold."""
    if choices:
        window.bench.document.change("Choose", import_choices=ImportChoices(**choices))
    window.open([folder])
    qtbot.waitUntil(lambda: window.bench.document.project.has_map and quiet(window), timeout=PATIENCE_MS)
    return window


def import_again(window: MainWindow, qtbot: Any) -> Any:
    """The stack after "Import again" was clicked, which is what Ctrl+Enter does until the next change."""
    old = window.bench.document.project.stack
    assert window.capture.again.isEnabled(), window.capture.again.toolTip()
    assert window.capture.panel.main_button is window.capture.again
    qtbot.mouseClick(window.capture.again, Qt.MouseButton.LeftButton)
    qtbot.waitUntil(
        lambda: window.bench.document.project.stack is not old and quiet(window),
        timeout=PATIENCE_MS,
    )
    assert window.capture.panel.main_button is window.capture.build
    return window.bench.document.project.stack


def quiet(window: MainWindow) -> bool:
    return not window.bench.jobs.active


def choices(window: MainWindow) -> ImportChoices:
    return window.bench.document.project.import_choices


def pick(window: MainWindow, name: str, value: str) -> None:
    """Choose `value` in the box `name` of the import panel."""
    panel = window.capture.options
    box = panel.framing if name == "framing" else panel.boxes[name]
    box.setCurrentIndex(box.findData(value))
    box.activated.emit(box.currentIndex())


def click(widget: Any, place: QPointF) -> None:
    QTest.mouseClick(widget, Qt.MouseButton.LeftButton, Qt.KeyboardModifier.NoModifier, place.toPoint())


def drag(widget: Any, start: QPointF, end: QPointF) -> None:
    QTest.mousePress(widget, Qt.MouseButton.LeftButton, Qt.KeyboardModifier.NoModifier, start.toPoint())
    for step in range(1, 6):
        QTest.mouseMove(widget, (start + (end - start) * step / 5).toPoint())
    QTest.mouseRelease(widget, Qt.MouseButton.LeftButton, Qt.KeyboardModifier.NoModifier, end.toPoint())
