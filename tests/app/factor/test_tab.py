"""The Factor workspace, by what it does to the document, to the runs and to folders."""

from __future__ import annotations

import csv
import io
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtGui import QImage, QPainter
from PySide6.QtSvg import QSvgRenderer

from app.commands import brdf as commands_brdf
from app.document.factoring import MATERIAL, Factoring, Run
from app.document.open_document import Document
from app.factor.images import ANGLES
from app.factor.inspector import state_of, why_fewer
from app.factor.plot import line_of, log_ticks
from app.factor.runs import Live
from app.widgets.labels import FIXED, projection_name, shares
from app.window.main_window import MainWindow
from benchmarks.app.faults import cut, pixels
from engine.brdf.models.phong import Phong
from engine.factor.errors import Factorisation, Metrics, TermError
from engine.factor.factor_file import read_factors
from engine.factor.projections import DIFFERENCE, FIRST, KINDS, SECOND, SUM, FixedProjection, linear
from engine.factor.settings import FactorSettings

IGNORED = Qt.AspectRatioMode.IgnoreAspectRatio
SMOOTH = Qt.TransformationMode.SmoothTransformation

#: So small that a run takes a fraction of a second.
QUICK = FactorSettings(side=10, products=3, size=8, textures=2, restarts=1, samples=800, method="svd")

#: Results of which the errors alone are asked.
NO_FACTORS: Any = None


@pytest.fixture
def factor(window: MainWindow) -> Any:
    """The workspace on screen, with small settings and no history."""
    window.show_workspace("factor")
    window.factor._on_edited(QUICK, True)
    window.bench.document.undo_stack.clear()
    return window.factor


def settle(factor: Any, qtbot: Any) -> None:
    """Let all work end but what is paused."""
    jobs = factor.bench.jobs
    qtbot.waitUntil(lambda: not any(job.is_asked_for and job.state != "paused" for job in jobs.active), timeout=60_000)
    qtbot.waitUntil(lambda: not factor.showing.isActive(), timeout=5_000)


def run_with(factor: Any, qtbot: Any, **choices: Any) -> Run:
    factor._on_edited(replace(factor.factoring.choices, **choices), True)
    factor.settings.start.click()
    settle(factor, qtbot)
    run = factor.factoring.run
    assert run is not None
    return run


def document_of(factor: Any) -> Document:
    return factor.bench.document


def test_nothing_is_there_at_first_and_what_cannot_be_done_says_why(factor: Any) -> None:
    assert factor.pages.currentIndex() == 0
    for widget in (factor.inspector.pause, factor.inspector.export, factor.inspector.use, factor.inspector.more):
        assert not widget.isEnabled()
        assert widget.toolTip() == "Start a run first"
    assert factor.settings.start.isEnabled()


def test_a_run_becomes_the_chosen_one_and_is_one_step_of_the_history(factor: Any, qtbot: Any) -> None:
    factor._set_source("model:lafortune:preset=blue-paint")
    run = run_with(factor, qtbot)
    live = factor.runs.of(run)
    assert (run.name, run.source, live.state) == ("Blue paint", "model:lafortune:preset=blue-paint", "done")
    assert [term_error.terms for term_error in live.term_errors] == [1, 2, 3]
    assert factor.pages.currentIndex() == 1
    assert len(factor.plot.shown) == 1
    assert "3 of 3" in factor.inspector.many.text()
    assert "Held-out errors are best with 3 terms" in factor.inspector.remark.text()
    held_out = factor.inspector.errors["held_out_sq_log"].text()
    assert float(held_out) == pytest.approx(live.term_errors[-1].held_out_sq_log, rel=5e-3)
    document_of(factor).undo_stack.undo()
    assert (factor.factoring.runs, factor.pages.currentIndex()) == ((), 0)
    document_of(factor).undo_stack.redo()
    assert factor.factoring.runs == (run,)
    assert factor.runs.of(run).factors(None).terms == 3


def test_a_click_on_a_point_chooses_so_many_terms_and_undo_takes_it_back(factor: Any, qtbot: Any) -> None:
    run = run_with(factor, qtbot)
    place = factor.plot.place_of(run.number, 2)
    qtbot.mouseClick(factor.plot.viewport(), Qt.MouseButton.LeftButton, pos=QPoint(round(place.x()), round(place.y())))
    assert (factor.factoring.current, factor.factoring.terms) == (run.number, 2)
    assert factor.preview.factors.terms == 2
    assert "2 of 3" in factor.inspector.many.text()
    assert document_of(factor).undo_stack.undoText() == f"Choose 2 terms of {run.name}"
    document_of(factor).undo_stack.undo()
    assert factor.factoring.terms is None


@pytest.mark.dressed
def test_the_error_plot_is_saved_as_images_and_values(factor: Any, qtbot: Any, tmp_path: Path) -> None:
    """The ending says in which form; both axes have a unit, also where room lacks."""
    first, second = run_with(factor, qtbot), run_with(factor, qtbot, method="homomorphic")
    for name in ("errors.png", "errors.svg", "errors.csv"):
        with qtbot.waitSignal(factor.save_plot(tmp_path / name).succeeded):
            pass
    image = QImage(str(tmp_path / "errors.png"))
    assert image.size() == 2 * factor.plot.size()
    on_screen, small = factor.plot.grab().toImage(), image.scaled(factor.plot.size(), IGNORED, SMOOTH)
    apart = np.abs(pixels(on_screen).astype(float) - pixels(small))
    assert apart.mean() < 1.5
    assert np.ptp(pixels(image)) > 100
    drawing = (tmp_path / "errors.svg").read_bytes()
    assert b"<image" not in drawing  # markers are shapes
    redrawn = QImage(factor.plot.size(), QImage.Format.Format_RGB32)
    painter = QPainter(redrawn)
    QSvgRenderer(drawing).render(painter)
    painter.end()
    assert np.abs(pixels(on_screen).astype(float) - pixels(redrawn)).mean() < 2.5
    rows = list(csv.DictReader(io.StringIO((tmp_path / "errors.csv").read_text(encoding="utf-8"))))
    term_errors = [(run, term_error) for run in (first, second) for term_error in factor.runs.of(run).term_errors]
    found = [(row["Run"], int(row["Number of terms"])) for row in rows]
    assert found == [(run.name, term_error.terms) for run, term_error in term_errors]
    for row, (_, term_error) in zip(rows, term_errors, strict=True):
        assert float(row["RMS, cosine-weighted / sr⁻¹"]) == term_error.rms_cosine_weighted
        assert float(row["Size / B"]) == term_error.size_bytes
        assert float(row["Mean relative (log) / 1"]) == term_error.error("abs_log")
    factor.plot.resize(400, 130)
    assert factor.plot.getPlotItem().getAxis("left").labelText == "RMS / sr⁻¹"
    assert factor.plot.getPlotItem().getAxis("bottom").labelText == "Number of terms"


@pytest.mark.dressed
def test_a_long_name_of_a_run_is_not_cut(factor: Any, qtbot: Any) -> None:
    """Such as that of a file, which has no spaces: it pushed the figures below the scroll bar."""
    run_with(factor, qtbot)
    name = "satin_rosaline_rgb_measured_again_and_again.bsdf.of-a-very-long-name"
    runs = tuple(replace(run, name=name) for run in factor.factoring.runs)
    document_of(factor).change("Rename", factoring=replace(factor.factoring, runs=runs))
    factor.inspector.setFixedWidth(factor.inspector.minimumSizeHint().width())
    factor.inspector.setFixedHeight(400)
    qtbot.waitUntil(lambda: name in factor.inspector.of.text().replace("\u200b", ""))
    qtbot.waitUntil(lambda: cut(factor.inspector) == [])  # the layout comes to rest a moment later


def test_methods_stand_side_by_side_each_in_a_colour_of_its_own(factor: Any, qtbot: Any) -> None:
    first, second = run_with(factor, qtbot), run_with(factor, qtbot, method="homomorphic")
    assert len({(run.colour, run.marker) for run in (first, second)}) == 2
    assert len(factor.plot.shown) == 2
    assert "800 samples up to 88°, seed 1" in factor.inspector.list.item(1).toolTip()
    factor.inspector.list.setCurrentRow(0)
    assert factor.factoring.run is first
    factor.inspector.remove.click()
    assert factor.factoring.runs == (second,)
    assert factor.factoring.run is second
    document_of(factor).undo_stack.undo()
    assert factor.factoring.runs == (first, second)
    assert factor.runs.of(first).factors(None) is not None


def test_a_search_pauses_goes_on_and_keeps_the_best_when_it_is_stopped(factor: Any, qtbot: Any) -> None:
    factor._on_edited(replace(QUICK, method="search", textures=4, restarts=40, samples=3000, size=16), True)
    factor.start()
    run = factor.factoring.run
    live = factor.runs.of(run)
    qtbot.waitUntil(lambda: bool(live.term_errors), timeout=60_000)
    factor.inspector.pause.click()
    assert live.job.state == "paused"
    qtbot.waitUntil(lambda: factor.inspector.pause.text() == "Resume")
    other = run_with(factor, qtbot, method="svd")
    assert factor.runs.of(other).state == "done"
    factor.choose(run.number, None)
    qtbot.wait(300)
    step = live.job.step
    qtbot.wait(200)
    assert live.job.step is step
    qtbot.waitUntil(lambda: factor.inspector.pause.text() == "Resume")
    factor.inspector.pause.click()
    qtbot.waitUntil(lambda: live.job.step is not step, timeout=60_000)
    qtbot.waitUntil(lambda: factor.inspector.stop.isEnabled())
    factor.inspector.stop.click()
    settle(factor, qtbot)
    assert (live.state, live.job) == ("stopped", None)
    assert live.factors(None).terms == live.term_errors[-1].terms
    assert state_of(live).startswith("stopped")
    qtbot.waitUntil(lambda: factor.inspector.export.isEnabled())


def test_a_search_goes_on_with_further_terms_from_where_it_was(factor: Any, qtbot: Any) -> None:
    run = run_with(factor, qtbot, method="search", textures=1, restarts=0, samples=300, size=4)
    live = factor.runs.of(run)
    first = live.term_errors[0]
    assert [term_error.terms for term_error in live.term_errors] == [1]
    factor.inspector.terms.show_value(2.0)
    factor.inspector.more.click()
    settle(factor, qtbot)
    assert [term_error.terms for term_error in live.term_errors] == [1, 2]
    assert live.term_errors[0] is first
    assert factor.factoring.run.choices.textures == 2


def test_what_a_method_refuses_is_said_in_a_sentence(factor: Any, qtbot: Any, window: MainWindow) -> None:
    factor._set_source("model:lambert:albedo=0")
    run = run_with(factor, qtbot, method="search")
    live = factor.runs.of(run)
    assert (live.state, live.term_errors) == ("failed", ())
    qtbot.waitUntil(lambda: bool(window.failures.open_dialogs))
    (words,) = window.failures.open_dialogs
    assert "0 everywhere" in words
    assert "another method" in words
    assert not factor.inspector.export.isEnabled()
    assert "0 everywhere" in factor.inspector.failed.text()
    assert "0 everywhere" in factor.inspector.more.toolTip()
    assert not factor.inspector.more.isEnabled()
    assert factor.preview.views["factored"].isHidden()
    assert factor.preview.shown is None
    qtbot.waitUntil(lambda: factor.preview.captions["factored"].text() == "nothing found yet", timeout=20_000)


def test_undoing_the_start_of_a_run_ends_it(factor: Any, qtbot: Any) -> None:
    factor._on_edited(replace(QUICK, method="search", textures=8, restarts=100, samples=3000), True)
    factor.start()
    live = factor.live
    qtbot.waitUntil(lambda: live.job.begun)
    document_of(factor).undo_stack.undo()
    settle(factor, qtbot)
    assert (live.state, factor.factoring.runs) == ("stopped", ())


def test_settings_are_one_step_per_gesture_and_say_why_they_do_not_fit(factor: Any) -> None:
    for samples in (900.0, 950.0, 1000.0):
        factor.settings.edited.emit(replace(factor.factoring.choices, samples=samples), samples == 1000.0)
    assert document_of(factor).undo_stack.count() == 1
    factor.settings.edited.emit(
        replace(factor.factoring.choices, method="symmetric", parametrisation="half-diff"), True
    )
    assert not factor.settings.start.isEnabled()
    assert "no matrix is symmetric" in factor.settings.start.toolTip()
    document_of(factor).undo_stack.undo()
    assert factor.settings.start.isEnabled()
    document_of(factor).undo_stack.undo()
    assert factor.factoring.choices == QUICK


def test_what_is_compared_can_be_factored_and_is_missed_when_it_is_gone(factor: Any, qtbot: Any) -> None:
    bench = factor.bench
    commands_brdf.add_model(bench, "lambert")
    entry = bench.document.project.comparison.entries[0]
    source = f"entry:{entry.identity}"
    box = factor.settings.source
    factor.settings._source_chosen(box.findData(source))
    assert factor.factoring.source == source
    run = run_with(factor, qtbot)
    assert run.name == "Lambert"
    assert factor.runs.of(run).brdf is entry.brdf
    bench.document.change("Remove", comparison=bench.document.project.comparison.removed(entry.identity))
    assert not factor.settings.start.isEnabled()
    factor.settings._source_chosen(box.findData(MATERIAL))
    assert factor.settings.start.isEnabled()


def test_a_brdf_from_a_file_is_what_is_factored_next_and_listed_once(factor: Any, window: MainWindow) -> None:
    bench, box = factor.bench, factor.settings.source
    for name in ("first", "second"):
        commands_brdf.add(bench, name.capitalize(), Phong(), Path(f"/measured/{name}.bsdf"))
    names = [box.itemText(at) for at in range(box.count())]
    assert box.currentText() == "Second"
    assert names[:2] == ["First", "Second"]
    assert not {"first.bsdf", "second.bsdf"} & set(names)
    window.brdf.current = bench.document.project.comparison.entries[1].identity
    window.brdf.remove()
    assert factor.factoring.source == MATERIAL
    assert "second.bsdf" in [box.itemText(at) for at in range(box.count())]


def test_a_run_with_fewer_terms_than_were_asked_for_says_why() -> None:
    values = Metrics(0.1, 0.2, 0.3, 0.4, 0.5, 0.6)
    errors = ((1, 0.3, 0.2), (2, 0.1, 0.1), (3, 0.2, 0.3), (4, 0.4, 0.3))
    term_errors = tuple(TermError(terms, 1, 0.7, (), values, 1.0, 100, rms, log) for terms, rms, log in errors)
    found = Factorisation(NO_FACTORS, "search", term_errors[:2], left_out=term_errors[2:], best_terms=2)
    run = Run(1, 1, "paint", MATERIAL, FactorSettings(products=8, textures=5))
    assert why_fewer(run, Live(factorisation=found)) == (
        "2 of 8 terms: one more raises the held-out RMS × cos from 0.1 to 0.2 sr⁻¹."
    )
    logarithm = replace(found, left_out=(replace(term_errors[2], held_out_rms_cosine_weighted=0.05),))
    assert "held-out squared logarithm from 0.1 to 0.3" in why_fewer(run, Live(factorisation=logarithm))
    last = replace(found, left_out=())
    assert why_fewer(run, Live(factorisation=last)) == "2 of 8 terms: no further term lowers the held-out errors."
    enough = replace(run, choices=FactorSettings(products=2, textures=2))
    assert why_fewer(enough, Live(factorisation=found)) == ""
    assert why_fewer(replace(run, choices=None), Live(factorisation=found)) == "", "factors from a file"


def test_typing_finds_a_published_material(factor: Any) -> None:
    line = factor.settings.source.lineEdit()
    line.setText("blue pai")
    line.editingFinished.emit()
    assert factor.factoring.source == "model:lafortune:preset=blue-paint"
    line.setText("nothing of that name")
    line.editingFinished.emit()
    assert factor.settings.source.currentText() == "Blue paint"


@pytest.mark.parametrize("method", ["svd", pytest.param("homomorphic", marks=pytest.mark.long)])
def test_factors_are_exported_and_opened_again(factor: Any, qtbot: Any, tmp_path: Path, method: str) -> None:
    run = run_with(factor, qtbot, method=method)
    factor.choose(run.number, 2)
    folder = tmp_path / "factors"
    factor.export(folder)
    settle(factor, qtbot)
    kept = read_factors(folder)
    assert kept.factors.terms == 2
    factor.bench.open([folder])
    qtbot.waitUntil(lambda: len(factor.factoring.runs) == 2, timeout=30_000)
    opened = factor.factoring.run
    assert (opened.name, opened.choices, factor.runs.of(opened).state) == ("factors", None, "opened")
    wi = wo = np.array([[0.3, 0.1, 0.9486833]])
    np.testing.assert_allclose(
        factor.runs.of(opened).factors(None).f(wi, wo), factor.runs.of(run).factors(2).f(wi, wo), rtol=1e-5
    )
    assert not factor.inspector.more.isEnabled()
    assert "from a file" in factor.inspector.more.toolTip()


def test_the_material_is_to_reflect_as_the_chosen_factors(
    factor: Any, qtbot: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = run_with(factor, qtbot)
    factor.choose(run.number, 2)
    used: list[Any] = []
    monkeypatch.setattr(commands_brdf, "use", lambda _bench, entry: used.append(entry))
    factor.inspector.use.click()
    assert [(entry.name, entry.brdf.terms) for entry in used] == [(f"{run.name}, 2 terms", 2)]


@pytest.mark.parametrize("method", [pytest.param("svd", marks=pytest.mark.long), "homomorphic"])
def test_factors_are_drawn_in_the_view_as_they_are(
    factor: Any, qtbot: Any, window: MainWindow, monkeypatch: pytest.MonkeyPatch, method: str
) -> None:
    monkeypatch.setattr("engine.brdf.readers.table_file.keep_table", None)
    run = run_with(factor, qtbot, method=method)
    factor.inspector.use.click()
    qtbot.waitUntil(lambda: document_of(factor).project.material.measured is not None, timeout=60_000)
    used = document_of(factor).project.material.measured
    wi, wo = np.array([[0.6, 0.0, 0.8]]), np.array([[0.0, 0.28, 0.96]])
    assert used is not None
    np.testing.assert_array_equal(used.f(wi, wo), factor.runs.of(run).factors(None).f(wi, wo))
    assert window.stack.currentWidget() is window.view
    assert window.view.brdf is used
    assert window.view.brdf_panel.choice.currentText().endswith("(factors)")
    assert "RMS off" not in window.view.hint.text()


def test_a_new_project_forgets_the_runs(factor: Any, qtbot: Any, window: MainWindow) -> None:
    run_with(factor, qtbot)
    window.new()
    assert document_of(factor).project.factoring.runs == ()


def test_the_light_and_the_camera_are_the_same_in_both_images(factor: Any, qtbot: Any) -> None:
    run_with(factor, qtbot)
    views = factor.preview.views
    qtbot.waitUntil(lambda: all(view.scene is not None for view in views.values()), timeout=20_000)
    views["factored"].light_moved.emit(30.0, 10.0, True)
    assert all(view.light_deg == (30.0, 10.0) for view in views.values())
    views["unfactored"].turn(0.4, 0.1)
    assert views["factored"].camera == views["unfactored"].camera
    qtbot.waitUntil(lambda: factor.preview.shown is not None, timeout=60_000)
    assert factor.preview.shown.scale >= factor.preview.shown.rms


@pytest.mark.parametrize(
    ("projection", "name"),
    [
        (FIRST, "light"),
        (SECOND, "view"),
        (SUM, "sum"),
        (DIFFERENCE, "difference"),
        (linear([[0.0, 1.0, 0.0, 1.0], [-1.0, 0.0, -1.0, 0.0]]), "sum"),
        (linear([[1.0, 0.0, 0.0, 1.0], [0.0, 1.0, -1.0, 0.0]]), "rotated sum"),
        (linear([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]), "mixture"),
        (FixedProjection("half"), "half vector"),
    ],
)
def test_projections_have_names_that_turning_the_texture_does_not_change(projection: Any, name: str) -> None:
    assert projection_name(projection, "in-out") == name
    if projection.name == "linear":
        assert sum(shares(projection)) == pytest.approx(1.0)


@pytest.mark.parametrize("kind", KINDS)
def test_every_fixed_projection_has_a_name_and_a_diagram(kind: str) -> None:
    projection = FixedProjection(kind)  # type: ignore[arg-type]
    words = projection_name(projection, "half-diff")
    assert words.endswith(FIXED[projection.angles or kind].removeprefix("angles"))
    assert kind in ("wi", "wo", "half") or len(ANGLES[projection.angles or kind]) == 2


def test_no_two_fixed_projections_share_a_name() -> None:
    names = [projection_name(FixedProjection(kind), "in-out") for kind in KINDS]
    assert len(set(names)) == len(KINDS)


@pytest.mark.parametrize(("low", "high"), [(-2.1, -1.9), (-1.98, -1.53), (-3.0, 0.5), (-12.0, 2.0)])
def test_a_logarithmic_axis_has_ticks_whatever_it_spans(low: float, high: float) -> None:
    ticks = log_ticks(low, high)[0]
    assert 3 <= len(ticks) <= 10
    assert all(10.0**place == pytest.approx(float(words)) for place, words in ticks)


def test_errors_that_are_not_known_have_no_line() -> None:
    values = Metrics(0.1, 0.2, 0.3, 0.4, 0.5, 0.6)
    known, older = (
        TermError(terms, 1, 0.7, (), values, 1.0, 100, held_out_sq_log=held) for terms, held in ((1, 0.8), (2, None))
    )
    run = Run(1, 1, "paint", MATERIAL, None)
    live = Live(factorisation=Factorisation(NO_FACTORS, "search", (known, older)))
    line = line_of(run, live, "terms", "held_out_sq_log")
    assert line is not None
    assert [(x, round(10.0**y, 9), terms) for x, y, terms in line.marks] == [(1.0, 0.8, 1)]
    assert (
        line_of(run, Live(factorisation=Factorisation(NO_FACTORS, "search", (older,))), "terms", "held_out_sq_log")
        is None
    )


def test_runs_follow_one_another_when_one_is_removed() -> None:
    runs = tuple(Run(number, number, f"{number}", MATERIAL, None) for number in (1, 2, 3))
    factoring = Factoring(runs=runs, current=2, terms=4)
    assert factoring.without(2).current == 3
    assert factoring.without(2).terms is None
    assert (factoring.without(1).current, factoring.without(1).terms) == (2, 4)
    assert Factoring(runs=runs[:1], current=1).without(1).current is None


def test_sliders_give_whole_numbers_where_only_those_exist(factor: Any) -> None:
    seen: list[FactorSettings] = []
    factor.settings.edited.connect(lambda choices, _final: seen.append(choices))
    editor = next(form.editors["samples"] for form in factor.settings.forms if "samples" in form.editors)
    editor.field.edited.emit(1234.4, True)
    assert [(choices.samples, type(choices.samples)) for choices in seen] == [(1234, int)]


def test_every_colour_is_free_again_once_its_run_is_gone() -> None:
    factoring = Factoring()
    for number in range(12):
        identity = factoring.free_identity
        assert identity is not None
        factoring = factoring.with_run(Run(number, identity, "", MATERIAL, None))
    assert factoring.free_identity is None
    assert factoring.without(4).free_identity == 4
