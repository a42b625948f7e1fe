"""The measure of projects: what it reports, and that its sessions are real ones."""

from __future__ import annotations

from pathlib import Path

import pytest

from app.project.project_file import KEPT_STEPS, read
from benchmarks.app import project
from benchmarks.command import ACCURACIES, LARGE
from engine.core.steps import drain


def test_it_reports_each_promise_with_its_bound(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    figures = {
        "gestures": {"worst_ms": 3.0, "median_ms": 1.0},
        "session": {"size_mb": 0.9},
        "open": {"open_s": 0.1},
        "window": {"open_s": 0.5},
    }
    monkeypatch.setattr(project, "_measure", lambda what, _folder: figures[what])
    monkeypatch.setattr(project, "_large", lambda folder: iter(()) if folder else None)
    monkeypatch.setenv("DISPLAY", ":0")
    found = {each.name: (each.error, each.bound) for each in drain(project.project(tmp_path))}
    assert found == {
        "project-gesture": (3.0, 20.0),
        "project-file": (0.9, 5.0),
        "project-open-long": (0.1, 1.0),
        "project-open-24mp": (0.5, 1.5),
    }
    assert "project" in ACCURACIES
    assert "project" in LARGE


def test_a_long_session_is_written_and_opened(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(project, "LONG", KEPT_STEPS + 20)
    assert project.session(tmp_path)["size_mb"] < project.FILE_MB
    assert project.open_path(tmp_path)["open_s"] > 0.0
    steps = read(tmp_path / "long.lap")
    assert (len(steps.steps), steps.position) == (KEPT_STEPS, KEPT_STEPS)
