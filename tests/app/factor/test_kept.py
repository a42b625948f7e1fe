"""Factor runs of a project that is opened again: listed with their results, read and not factored anew."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app.document.factoring import Run
from app.factor.runs import LOST, FactorRuns
from app.project.factors import Keeping, place_of, read_kept
from app.project.made import list_notes
from app.project.project_file import data_folder
from app.project.report import describe
from app.window.main_window import MainWindow
from engine.brdf.brdf import brdf_from_text
from engine.core.errors import InputError
from engine.core.steps import Steps, drain
from engine.factor.errors import Factorisation
from engine.factor.factor import factor
from engine.factor.settings import FactorSettings
from tests.app.factor.test_tab import QUICK, settle
from tests.app.opening import open_project


def reopen(window: MainWindow, qtbot: Any) -> Any:
    """Close the project and open it again; the folder of its data may be removed in between."""
    first = window.projects.path
    qtbot.waitUntil(lambda: window.projects.is_saved, timeout=60_000)
    window.new()
    assert not window.factor.factoring.runs
    return first


def factor_brdf(window: MainWindow, qtbot: Any, **choices: Any) -> tuple[Run, Any]:
    window.show_workspace("factor")
    window.factor._on_edited(replace(QUICK, **choices), True)
    run = window.factor.runs.start()
    assert run is not None
    settle(window.factor, qtbot)
    return run, window.factor.runs.of(run)


def test_a_sum_whose_errors_are_not_all_known_yet_is_not_kept(tmp_path: Path) -> None:
    """A slow machine comes to keep one in the middle, as does a user who stops."""
    choices = replace(QUICK, method="svd")
    run, folder = Run(1, 0, "Phong", "model:phong", choices, "phong"), tmp_path / "a.lap-data"
    folder.mkdir()
    keeping, unfinished = Keeping(run, folder), []

    def watch() -> Steps[Factorisation]:
        steps = factor(brdf_from_text("phong"), choices)
        while True:
            try:
                step = next(steps)
            except StopIteration as ended:
                return ended.value
            if step.partial is not None and 0 < len(step.partial.term_errors) < step.partial.factors.terms:
                unfinished.append(step.partial)
            yield step

    whole = drain(watch())
    assert unfinished
    for each in unfinished:
        keeping.keep(each)
        assert not list(folder.iterdir())
    keeping.keep(whole)
    kept = read_kept(run, folder)
    assert kept is not None
    assert kept.term_errors == whole.term_errors


@pytest.mark.parametrize("method", ["svd", pytest.param("search", marks=pytest.mark.long)])
def test_a_run_is_there_again_without_factoring(
    window: MainWindow, qtbot: Any, monkeypatch: pytest.MonkeyPatch, method: str
) -> None:
    small = {"textures": 1, "restarts": 0, "samples": 300} if method == "search" else {}
    run, live = factor_brdf(window, qtbot, method=method, **small)
    first = reopen(window, qtbot)
    monkeypatch.setattr("engine.factor.factor.factor", None)
    open_project(window, qtbot, first)
    window.show_workspace("factor")
    settle(window.factor, qtbot)
    runs = window.factor.factoring.runs
    assert [each.choices for each in runs] == [run.choices]
    qtbot.waitUntil(lambda: window.factor.runs.of(runs[0]).state == "done", timeout=60_000)
    again = window.factor.runs.of(runs[0])
    assert again.term_errors == live.term_errors
    textures = "first" if method == "svd" else "textures"
    for old, new in zip(getattr(live.factors(None), textures), getattr(again.factors(None), textures), strict=True):
        assert np.array_equal(old.astype(np.float32), new.astype(np.float32))
    qtbot.waitUntil(lambda: window.factor.preview.factors is not None, timeout=60_000)
    qtbot.waitUntil(lambda: len(window.factor.plot.shown) == 1, timeout=60_000)
    assert {each["kind"]: each["present"] for each in describe(first)["derived"]} == {"factors": True}
    later = FactorRuns(window.bench)  # as of a workspace that is made when the project is open already
    qtbot.waitUntil(lambda: later.of(runs[0]).state == "done", timeout=60_000)


def test_a_lost_result_is_said_with_its_cost_and_factored_again(window: MainWindow, qtbot: Any) -> None:
    _, live = factor_brdf(window, qtbot)
    first = reopen(window, qtbot)
    shutil.rmtree(data_folder(first))
    said: list[str] = []
    window.bench.said.connect(said.append)
    open_project(window, qtbot, first)
    assert "Gone from the data folder: a factor run. Making that again takes about" in said[0]
    (made,) = list_notes(first)
    assert (made.kind, made.present) == ("factors", False)
    assert made.seconds == pytest.approx(live.term_errors[-1].time_s, abs=1e-3)
    (run,) = window.factor.factoring.runs
    again = window.factor.runs.of(run)
    qtbot.waitUntil(lambda: again.why == LOST, timeout=60_000)
    window.factor._show_runs()
    assert window.factor.inspector.pause.text() == "Factor again"
    window.factor.inspector.pause.click()
    settle(window.factor, qtbot)
    assert (again.state, again.why) == ("done", "")
    assert [term_error.terms for term_error in again.term_errors] == [
        term_error.terms for term_error in live.term_errors
    ]
    assert list_notes(first)[0].present


def test_results_are_found_by_what_they_were_made_from(tmp_path: Path) -> None:
    """Another BRDF, another setting and another content of a file are other results; a number and a name are not."""
    table = tmp_path / "a.binary"
    table.write_bytes(b"one")
    brdf, choices = brdf_from_text("ggx:alpha=0.3"), FactorSettings()
    run = Run(1, 0, "One", "material", choices, brdf)
    place = place_of(run, tmp_path)
    same = Run(7, 3, "Other name", "model:ggx", choices, brdf_from_text("ggx:alpha=0.3"))
    assert place_of(same, tmp_path) == place
    others = [replace(run, given=brdf_from_text("ggx:alpha=0.31")), replace(run, choices=replace(choices, seed=2))]
    others.append(replace(run, given=table))
    places = {place, *(place_of(other, tmp_path) for other in others)}
    table.write_bytes(b"two")
    assert len({*places, place_of(others[-1], tmp_path)}) == 5


def test_a_damaged_result_is_named_and_a_missing_one_is_none(tmp_path: Path) -> None:
    run = Run(1, 0, "One", "material", FactorSettings(), brdf_from_text("lambert"))
    assert read_kept(run, tmp_path) is None
    place = place_of(run, tmp_path)
    place.mkdir()
    (place / "factors.json").write_text("{}")
    with pytest.raises(InputError, match="does not describe factors"):
        read_kept(run, tmp_path)
    assert read_kept(replace(run, given=tmp_path / "gone.binary"), tmp_path) is None
