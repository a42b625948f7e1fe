"""The Health dock: what every result says of its numbers, with a verdict, and the self-test."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace
from typing import Any

import pytest
from PySide6.QtWidgets import QApplication

from app.docks import health
from app.docks import health as healths
from app.docks.health import figures_of, parts_of, report_text, worst_of
from app.window.main_window import MainWindow
from benchmarks.app.faults import cut
from engine.core.health import Finding, Health, Verdict
from engine.core.steps import Step, Steps
from engine.light.environment_file import open_environment
from engine.selftest.case import Case
from engine.storage.sandbox import Protection
from tests.app.view.test_baking import LONG, sphere
from tests.present import present

DOUBTFUL = Health({"clipped_texels": 12.0, "edge_error_px": 0.25}, (Finding(Verdict.WARNING, "12 texels are clipped"),))


def rows(window: MainWindow) -> dict[str, list[str]]:
    """The words of each part, and of what is under it."""
    tree = window.docks.health.tree
    found = {}
    for at in range(tree.topLevelItemCount()):
        top = tree.topLevelItem(at)
        assert top is not None
        under = [top.child(each) for each in range(top.childCount())]
        found[top.text(0)] = [
            top.text(1),
            top.text(2),
            *(f"{present(item).text(1)}: {present(item).text(2)}" for item in under),
        ]
    return found


def test_every_result_is_reported_with_its_figures_and_a_verdict(window: MainWindow) -> None:
    mesh = dataclasses.replace(sphere(), health=DOUBTFUL)
    window.bench.document.change("Ball", mesh=mesh, environment=open_environment("sky"))
    shown = rows(window)
    assert shown["Model"][:2] == ["12 texels are clipped", "check"]
    assert "Clipped texels: 12" in shown["Model"]
    assert "Edge error: 0.25 px" in shown["Model"]
    assert shown["Light"][1] == "good"
    window.bench.document.undo_stack.undo()
    assert "Model" not in rows(window)


@pytest.mark.dressed
def test_a_finding_names_what_it_is_about_and_is_read_in_whole(window: MainWindow, qtbot: Any) -> None:
    about = Finding(Verdict.WARNING, "is predicted from the others with an error of 77 % of its mean radiance", "a.tif")
    window.bench.document.change("Ball", mesh=dataclasses.replace(sphere(), health=Health({}, (about, *[about] * 2))))
    assert rows(window)["Model"][0].startswith("a.tif is predicted from the others")
    assert window.status.health.toolTip().startswith("a.tif is predicted")
    assert (
        Finding(Verdict.NOTE, "10 % of the pixels are black", "a.tif").sentence == "a.tif: 10 % of the pixels are black"
    )
    window.resize(1024, 700)
    window.show_workspace("view")
    window.docks.show_health()
    qtbot.waitUntil(lambda: window.docks.health.tree.isVisible())
    qtbot.waitUntil(lambda: cut(window.docks.health) == [])


def test_the_status_bar_opens_it(window: MainWindow) -> None:
    assert not window.docks.health.isVisible()
    window.status.health_clicked.emit()
    assert window.docks.health.isVisible()


def test_the_status_bar_tells_of_all_results(window: MainWindow) -> None:
    assert not window.status.health.isVisibleTo(window)
    window.bench.document.change("Ball", mesh=dataclasses.replace(sphere(), health=DOUBTFUL))
    assert window.status.health.isVisibleTo(window)
    assert window.status.health.text() == "Health: check"
    assert window.status.health.toolTip() == "12 texels are clipped"


def test_bakes_and_brdfs_are_among_the_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    from app.document.document import Project

    table = SimpleNamespace(health=Health({"condition": 3.0}))
    made = SimpleNamespace(transport=SimpleNamespace(table=table), health=Health())
    monkeypatch.setattr(healths, "protection", lambda: Protection(0, True))
    brdf: Any = SimpleNamespace(health=DOUBTFUL)
    parts = parts_of(Project(), brdf, [("Bake, sh", made), ("Bake, wavelet", None)])
    assert [part.name for part in parts] == ["BRDF", "Bake, sh", "Bake, sh: BRDF", "Reading of files"]
    assert "no Landlock" in parts[-1].summary
    assert worst_of(parts).verdict == Verdict.WARNING
    assert [*figures_of(table.health)] == [("Condition", "3", False)]


def test_figures_that_are_not_known_are_said_to_be() -> None:
    assert [*figures_of(Health({"noise_rel": float("nan")}))] == [("Noise", "not known", False)]


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("noise_rel", 0.0125, "1.25 %"),
        ("table_bytes", 123_456_789.0, "123 MB"),
        ("condition", float("inf"), "infinite"),
        ("angle_deg", 12.5, "12.5 °"),
    ],
)
def test_figures_have_units_that_users_read(name: str, value: float, words: str) -> None:
    assert [shown for _, shown, _ in figures_of(Health({name: value}))] == [words]


@pytest.mark.parametrize("fails", [pytest.param(False, marks=pytest.mark.long), True])
def test_the_self_test_is_under_help_and_reported_case_by_case(
    window: MainWindow, qtbot: Any, monkeypatch: pytest.MonkeyPatch, fails: bool
) -> None:
    cases = (Case("F1", "frames", 1e-16, 1e-15), Case("H2", "poles", 2.0 if fails else 0.0, 1.0))

    def check() -> Steps[Any]:
        yield Step(0.5, "trying")
        return cases

    monkeypatch.setattr(health, "_on_tested", check)
    window.self_test()
    qtbot.waitUntil(lambda: window.docks.health.job is None, timeout=LONG)
    reported = rows(window)["Self-test"]
    assert reported[1] == ("problem" if fails else "good")
    assert "F1  frames: 1e-16 ≤ 1e-15" in reported
    assert ("H2" in window.docks.health.words.text()) == fails
    assert window.docks.health.test.text() == "Self-test"


def test_a_stopped_self_test_says_so(window: MainWindow, qtbot: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    def check() -> Steps[Any]:
        while True:
            yield Step(0.5, "trying")

    monkeypatch.setattr(health, "_on_tested", check)
    window.self_test()
    window.docks.health.test.click()
    qtbot.waitUntil(lambda: window.docks.health.job is None, timeout=LONG)
    assert "stopped" in window.docks.health.words.text()


def test_reports_are_sentences() -> None:
    good = Case("F1", "frames", 0.0, 1.0)
    assert report_text((good,)) == "All 1 cases of the self-test pass."
    assert "1 of 2" in report_text((good, Case("H2", "poles", 2.0, 1.0)))


@pytest.mark.dressed
def test_names_of_results_are_not_cut(window: MainWindow) -> None:
    window.bench.document.change("Ball", mesh=sphere(), environment=open_environment("sky"))
    window.docks.health.show()
    QApplication.processEvents()
    tree = window.docks.health.tree
    tops = [tree.topLevelItem(at) for at in range(tree.topLevelItemCount())]
    assert tops
    wide = max(tree.fontMetrics().horizontalAdvance(top.text(0)) for top in tops if top is not None)
    assert tree.columnWidth(0) > wide
    assert tree.visualItemRect(present(tops[0])).height() >= 24
