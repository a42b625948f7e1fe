"""Opening a project in a window and waiting until it is open or refused: it is read on the thread of a job."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from app.window.main_window import MainWindow


def open_project(window: MainWindow, qtbot: Any, path: Path) -> None:
    """Open the project at `path` as File > Open project does."""
    window.open_project(path)
    qtbot.waitUntil(lambda: not window.projects.is_opening, timeout=60_000)
