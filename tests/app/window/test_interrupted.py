"""Jobs that a crash interrupted: listed when the project is opened again, with a button that goes on."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from PySide6.QtWidgets import QFileDialog

from app.export.tab import ExportTab
from app.jobs.jobs import Jobs
from app.project.interrupted import Interrupted, interrupt_in, propose_place, running
from app.project.project_file import data_folder
from app.session.settings import load
from app.view.baking import RESUMED
from app.window.application import recover
from app.window.interrupted import CAUSE
from app.window.main_window import MainWindow
from engine.bundle.bundle import open_bundle
from engine.core.steps import Step, Steps
from tests.app.export.test_tab import tab
from tests.app.opening import open_project
from tests.app.view.test_baking import LONG
from tests.app.view.test_planning import bake, planned

__all__ = ["planned", "tab"]

KILLED = """
import os, signal, sys
from pathlib import Path
from app.project.interrupted import running
with running(Path(sys.argv[1]), sys.argv[2], eval(sys.argv[3])):
    os.kill(os.getpid(), signal.SIGKILL)
"""


def kill_during(folder: Path, title: str, again: dict[str, Any] | None) -> None:
    """Let a process be killed in the middle of a job."""
    command = [sys.executable, "-c", KILLED, str(folder), title, repr(again)]
    assert subprocess.run(command, check=False).returncode < 0


def test_a_job_leaves_a_file_while_it_runs_and_no_longer(tmp_path: Path) -> None:
    with running(tmp_path, "Baking", {"kind": "bake"}):
        assert len(list(tmp_path.glob("job-*"))) == 1
        assert interrupt_in(tmp_path) == (), "the process lives"
    with pytest.raises(ValueError, match="mishap"), running(tmp_path, "Baking"):
        raise ValueError("mishap")
    assert not list(tmp_path.iterdir())
    with running(tmp_path / "gone", "Baking"):
        assert not (tmp_path / "gone").exists()


def test_jobs_of_a_killed_process_are_listed_and_damaged_files_are_not(tmp_path: Path) -> None:
    kill_during(tmp_path, "Baking wavelets", {"kind": "bake", "method": "wavelet"})
    kill_during(tmp_path, "Fitting", None)
    (first, second) = interrupt_in(tmp_path)
    assert (first.title, dict(first.again)) == ("Baking wavelets", {"kind": "bake", "method": "wavelet"})
    assert (second.title, dict(second.again)) == ("Fitting", {})
    for content in (b"", b"[]", json.dumps({"title": 1}).encode(), b"{" * 100_000):
        second.path.write_bytes(content)
        assert [each.title for each in interrupt_in(tmp_path)] == ["Baking wavelets"]
        assert not second.path.exists()


def test_every_job_that_the_user_asked_for_leaves_its_file(window: MainWindow, qtbot: Any) -> None:
    jobs: Jobs = window.bench.jobs
    seen: dict[str, int] = {}

    def work(name: str) -> Steps[None]:
        seen[name] = len(list(window.bench.folder.glob("job-*")))
        yield Step(0.5, "half")

    asked = jobs.submit("Asked", lambda: work("asked"), lane="compute", again={"kind": "none"})
    qtbot.waitUntil(lambda: asked.over, timeout=LONG)
    image = jobs.submit("Image", lambda: work("image"), lane="screen")
    qtbot.waitUntil(lambda: image.over, timeout=LONG)
    assert seen == {"asked": 1, "image": 0}
    assert not list(window.bench.folder.glob("job-*"))


def open_after(window: MainWindow, qtbot: Any, jobs: list[tuple[str, dict[str, Any] | None]]) -> Any:
    """The banner of the project that is opened after a process was killed during `jobs`."""
    path = window.projects.path
    qtbot.waitUntil(lambda: window.projects.is_saved, timeout=LONG)
    window.new()
    for title, again in jobs:
        kill_during(data_folder(path), title, again)
    open_project(window, qtbot, path)
    return window.banners.of[CAUSE]


def test_an_interrupted_bake_goes_on_at_a_button(planned: MainWindow, qtbot: Any) -> None:
    banner = open_after(
        planned,
        qtbot,
        [("Baking spherical harmonics", {"kind": "bake", "method": "sh"}), ("Fitting GGX", {"kind": "unknown"})],
    )
    assert banner.isVisibleTo(planned)
    assert "in the middle of this work: baking spherical harmonics, fitting GGX." in banner.words.text()
    assert [each.text() for each in banner.buttons] == ["Resume", "Hide"]
    planned.show_workspace("capture")
    baking, on_stop = planned.view.bakings["sh"], set[str]()
    jobs: Jobs = planned.bench.jobs
    jobs.changed.connect(lambda job: on_stop.add(job.on_stop) if job.title.startswith("Baking") else None)
    banner.buttons[0].click()
    assert planned.stack.currentWidget() is planned.view
    qtbot.waitUntil(lambda: baking.job is None and baking.is_made, timeout=LONG)
    assert on_stop == {RESUMED}, "Quit asks"
    assert "spherical" not in banner.words.text()
    banner.buttons[-1].click()
    assert not banner.isVisibleTo(planned)
    assert not list(planned.bench.folder.glob("job-*"))


def test_several_interrupted_jobs_go_on_at_one_button(window: MainWindow, qtbot: Any) -> None:
    jobs: list[tuple[str, dict[str, Any] | None]] = [
        ("Baking", {"kind": "bake", "method": "sh"}),
        ("Factoring", {"kind": "factor", "number": 1}),
    ]
    gone_on: list[Any] = []
    window.interrupted.ways = {"bake": gone_on.append, "factor": gone_on.append}
    banner = open_after(window, qtbot, [*jobs, ("Exporting", None)])
    assert [each.text() for each in banner.buttons] == ["Resume all", "Hide"]
    banner.buttons[0].click()
    assert sorted(each["kind"] for each in gone_on) == ["bake", "factor"]
    assert "exporting" in banner.words.text()
    assert [each.text() for each in banner.buttons] == ["Hide"]


def test_a_project_comes_back_in_the_workspace_that_was_in_front(
    window: MainWindow, qtbot: Any, tmp_path: Path
) -> None:
    path = window.projects.path
    window.settings.folder = tmp_path
    window.show_workspace("factor")
    qtbot.waitUntil(lambda: load(tmp_path).workspace == "factor", timeout=LONG)
    qtbot.waitUntil(lambda: window.projects.is_saved, timeout=LONG)
    window.new()
    recover(window, path, "factor")
    qtbot.waitUntil(lambda: not window.projects.is_opening, timeout=LONG)
    assert window.projects.path == path
    assert window.stack.currentWidget() is window.factor
    recover(window, path, "no workspace")
    assert window.stack.currentWidget() is window.factor


def test_a_bake_that_was_done_after_all_is_not_baked_anew(
    planned: MainWindow, qtbot: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    bake(planned, qtbot)
    again = {"kind": "bake", "method": "sh"}
    banner = open_after(planned, qtbot, [("Baking spherical harmonics", again)])
    monkeypatch.setattr("app.project.bakes.bake", None)
    banner.buttons[0].click()
    baking = planned.view.bakings["sh"]
    qtbot.waitUntil(lambda: baking.is_made, timeout=LONG)
    assert baking.job is None


def test_an_interrupted_import_begins_again_and_its_material_follows(
    window: MainWindow, qtbot: Any, drop: Any, photographs: Path
) -> None:
    from engine.capture.lights.sources import find

    window.bench.document.change("Open 5 photographs", sources=find([photographs]))
    banner = open_after(window, qtbot, [("Importing photographs", {"kind": "import", "name": "Felt"})])
    banner.buttons[0].click()
    qtbot.waitUntil(lambda: window.bench.document.project.has_map, timeout=2 * LONG)
    assert window.bench.document.project.name == "Felt"
    assert banner.words.text() == ""


def test_an_interrupted_run_is_factored(window: MainWindow, qtbot: Any) -> None:
    from tests.app.factor.test_kept import factor_brdf
    from tests.app.factor.test_tab import settle

    run, _ = factor_brdf(window, qtbot)
    for place in window.bench.folder.glob("factors-*"):
        for file in place.iterdir():
            file.unlink()
        place.rmdir()
    banner = open_after(window, qtbot, [("Factoring", {"kind": "factor", "number": run.number})])
    banner.buttons[0].click()
    settle(window.factor, qtbot)
    qtbot.waitUntil(lambda: window.factor.runs.of(window.factor.factoring.runs[0]).state == "done", timeout=LONG)


def answer(monkeypatch: pytest.MonkeyPatch, dialog: str, answer: Path | None) -> list[Path]:
    """The paths that a file dialog proposes from now on; the user answers with `answer`, or cancels."""
    proposed: list[Path] = []

    def ask(_parent: object, _title: str, place: str, *_filter: str) -> Any:
        proposed.append(Path(place))
        chosen = str(answer) if answer is not None else ""
        return (chosen, "") if dialog == "getSaveFileName" else chosen

    monkeypatch.setattr(QFileDialog, dialog, ask)
    return proposed


def test_an_interrupted_bundle_is_written_where_the_user_says(
    tab: ExportTab, window: MainWindow, qtbot: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    tab.parts["power-law"][0].setChecked(False)
    tab.start()
    exporting = tab.exporting
    assert exporting is not None
    assert exporting.on_stop, "Quit asks"
    qtbot.waitUntil(lambda: exporting.over, timeout=LONG)
    written = tab.target
    written.unlink()
    tab.parts["slices"][0].setChecked(False)
    tab.parts["power-law"][0].setChecked(True)
    tab.name.setText("another.lightarc")
    banner = open_after(window, qtbot, [("Writing the bundle", dict(exporting.again or {}))])
    tab.bench.write_into(Path.home())
    proposed = answer(monkeypatch, "getSaveFileName", None)
    banner.buttons[0].click()
    assert window.stack.currentWidget() is tab
    assert proposed == [written]
    assert (tab.name.text(), tab.bench.output_folder, tab.exporting) == ("felt.lightarc", Path.home(), exporting)
    assert not written.exists()
    again = tmp_path / "elsewhere"
    again.mkdir()
    answer(monkeypatch, "getSaveFileName", again / "mine.lightarc")
    tab.go_on(exporting.again or {})
    qtbot.waitUntil(lambda: not window.bench.jobs.active, timeout=LONG)
    assert "mine.lightarc written and verified" in tab.verdict.text()
    assert open_bundle(again / "mine.lightarc").power_law is None
    assert not written.exists()


def test_interrupted_exports_are_written_where_the_user_says(
    tab: ExportTab, window: MainWindow, qtbot: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    again = {"kind": "exports", "folder": str(tmp_path), "name": "felt exports", "parts": ["brdf"]}
    banner = open_after(window, qtbot, [("Exporting", again)])
    tab.bench.write_into(Path.home())
    begun: list[tuple[Path, list[str]]] = []
    monkeypatch.setattr(tab.elsewhere, "start", lambda: begun.append((tab.elsewhere.target, tab.elsewhere.names)))
    tab.elsewhere.export.clicked.disconnect()
    tab.elsewhere.export.clicked.connect(lambda: tab.elsewhere.start())
    assert answer(monkeypatch, "getExistingDirectory", None) == []
    banner.buttons[0].click()
    assert begun == []
    proposed = answer(monkeypatch, "getExistingDirectory", tmp_path)
    tab.elsewhere.go_on(again)
    assert proposed == [tmp_path]
    assert begun == [(tmp_path / "felt exports", ["brdf"])]


NONSENSE: tuple[dict[str, Any], ...] = (
    {},
    {"folder": "relative", "name": "../../escaped.lightarc", "parts": 7, "number": "one", "method": []},
    {"folder": "/\0", "name": "..", "parts": [{}, None, "slices", "brdf"], "number": 1e9, "method": "none"},
    {"folder": "/" + "x" * 5000, "name": "a/b", "parts": ["slices", "brdf"]},
)


def test_a_file_that_says_nonsense_begins_nothing_and_is_no_fault(
    tab: ExportTab, window: MainWindow, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    proposed = [answer(monkeypatch, dialog, None) for dialog in ("getSaveFileName", "getExistingDirectory")]
    kinds = ("bundle", "exports", "factor", "bake", "import", ["bundle"])
    jobs = [Interrupted(tmp_path / "none", "Work", {"kind": kind, **said}) for kind in kinds for said in NONSENSE]
    window.interrupted.jobs = tuple(jobs)
    window.interrupted._say()
    window.banners.of[CAUSE].buttons[0].click()
    assert proposed == [[tmp_path / "felt.lightarc"] * 2, [tmp_path] * 2]
    assert not [job for job in window.bench.jobs.active if job.again]


def test_the_place_of_an_interrupted_export_has_a_name_that_can_be_shown(tmp_path: Path) -> None:
    folder = tmp_path / "folder"
    assert propose_place({"folder": str(tmp_path), "name": "a.lightarc"}, folder, "b") == tmp_path / "a.lightarc"
    assert propose_place({"name": "a\u202e\nb"}, folder, "b") == folder / "ab"
    for name in ("", ".", "..", "../a", "a/b", "/etc/passwd", "\0"):
        assert propose_place({"folder": "..", "name": name}, folder, "b") == folder / "b"
    assert propose_place({"folder": str(tmp_path / "gone")}, folder, "b") == folder / "b"


def test_a_project_that_a_crash_left_says_so_with_its_last_step_until_that_is_read(
    window: MainWindow, qtbot: Any, tmp_path: Path
) -> None:
    path = tmp_path / "Felt.lap"
    program = """
import os, signal, sys
from pathlib import Path
from app.document.document import Look, Project, Step
from app.project.places import claim
from app.project.project_file import History, Writer
path, first, second = Path(sys.argv[1]), Project(), Project(look=Look(gain=2.0))
claim(path)
Writer(path).write(History(second, (Step("Change the light", "", first, second),), 1))
os.kill(os.getpid(), signal.SIGKILL)
"""
    subprocess.run([sys.executable, "-c", program, str(path)], check=False)
    open_project(window, qtbot, path)
    words = "Lightarc ended unexpectedly. Felt is as you left it, after “Change the light”."
    assert window.banners.words[CAUSE] == words
    assert window.banners.of[CAUSE].image.isVisible()
    (hide,) = window.banners.of[CAUSE].buttons
    hide.click()
    assert CAUSE not in window.banners.words
    window.new()
    open_project(window, qtbot, path)
    assert CAUSE not in window.banners.words
