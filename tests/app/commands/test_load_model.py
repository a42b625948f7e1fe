"""Of models that are asked for one after the other, the last is loaded and the others are cancelled."""

from __future__ import annotations

from pathlib import Path
from threading import Event
from typing import Any

import pytest

from app.commands import workbench
from app.commands.workbench import Workbench
from engine.core.steps import Step, Steps
from engine.geometry.mesh import Mesh
from engine.geometry.shapes import shape


def test_a_newer_model_cancels_those_that_are_still_loading(
    qtbot: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    opened = Event()

    def slow(name: str) -> Steps[Mesh]:
        yield Step(0.0, "opening")
        assert opened.wait(30.0)
        yield Step(0.5, "reading")
        return shape(name)

    monkeypatch.setattr(workbench, "load_shape", slow)
    bench = Workbench(tmp_path)
    asked = ["sphere", "plane", "sphere", "plane"]
    for name in asked:
        bench.load_model(name)
    jobs = bench.jobs.active
    assert len(jobs) == len(asked)
    opened.set()
    qtbot.waitUntil(lambda: all(job.over for job in jobs), timeout=30_000)
    assert [job.state for job in jobs] == ["cancelled"] * (len(asked) - 1) + ["succeeded"]
    mesh = bench.document.project.mesh
    assert mesh is not None
    assert mesh.name == asked[-1]
    assert bench.document.undo_stack.count() == 1
