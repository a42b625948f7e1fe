"""Exports for other programs by clicks: cards with losses, the choice within an error, files, and what is refused."""

from __future__ import annotations

import dataclasses
import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import Qt, QUrl
from PySide6.QtWidgets import QWidget

from app.cli.export import CODINGS as CLI_CODINGS
from app.cli.export import PRESETS as CLI_PRESETS
from app.commands import export_elsewhere
from app.document import exporting
from app.document.document import Project
from app.document.exporting import Exporting
from app.export import elsewhere
from app.window.main_window import MainWindow
from engine.core.figure_text import percent, size_text
from engine.core.steps import Step, Steps
from engine.exchange import export, loss
from engine.exchange.coding import CODINGS
from engine.exchange.subject import Contents, Settings, Subject
from engine.exchange.targets import EXPORTERS
from engine.exchange.textures import PRESETS
from engine.light.environment import DistantLights
from engine.scene.material import Material
from engine.storage.atomic import make_folder
from tests.app.window.test_main_window import fill

OFFERED = len(EXPORTERS)


def few_samples(_subject: Subject, _settings: Settings, _loss: str) -> Steps[Contents]:
    yield Step(0.5, "evaluating the BRDF", "the best BRDF so far, which is no offer")
    return Contents({"felt.csv": b"0,0"}, None, ("felt.mtlx is the nearest metallic-roughness, 9 % away",))


def two_lamps(_name: str) -> DistantLights:
    return DistantLights(np.array([[0.0, 0.6, 0.8], [0.8, 0.0, 0.6]]), np.ones((2, 3)))


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of what was measured of the material, once for all tests: the page finds it beside the project."""
    return tmp_path_factory.mktemp("measured")


@pytest.fixture
def anew() -> None:
    """The page is measured in this test, and not found to be."""


@pytest.fixture
def page(
    window: MainWindow,
    qtbot: Any,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    measured: Path,
    request: pytest.FixtureRequest,
) -> Any:
    """The page, measured, of a material lit from one side; tables of BRDFs are short, lights few."""
    targets = tuple(
        dataclasses.replace(target, contents=few_samples) if target.name == "brdf" else target
        for target in export.TARGETS
    )
    monkeypatch.setattr(export, "TARGETS", targets)
    monkeypatch.setattr(loss, "environment_lights", two_lamps)
    fill(window)
    window.bench.write_into(tmp_path)
    found = [] if "anew" in request.fixturenames else list(measured.iterdir())
    for file in found:
        shutil.copy(file, make_folder(window.bench.own))
    window.show_workspace("export")
    click(qtbot, window.export.forms.buttons["elsewhere"])
    page = window.export.elsewhere
    assert not page.is_measuring
    if not found:
        click(qtbot, page.measure)
    qtbot.waitUntil(lambda: whole(page), timeout=240_000)
    for file in window.bench.own.glob("loss-*.json"):
        shutil.copy(file, measured)
    return page


def whole(page: Any) -> bool:
    """True once all targets and the material itself are measured."""
    return len(page.found) == OFFERED + 1 and not page.latest.busy


@pytest.mark.parametrize(("typed", "known"), [(80.0, 80.0), (0.0, None), (0.001, None)])
def test_a_width_of_nothing_is_not_known(typed: float, known: float | None) -> None:
    assert Exporting(width_mm=typed).settings.width_mm == known


def test_brdfs_that_a_fit_finds_on_its_way_are_no_result(monkeypatch: pytest.MonkeyPatch) -> None:
    ready: Any = object()

    def fitting(_material: Material, _stack: Any, _own: Any) -> Steps[Any]:
        yield Step(0.5, "fitting", "a BRDF")
        return ready

    monkeypatch.setattr(export, "departure", fitting)
    steps = list(export_elsewhere.prepare_export(Project(), None, export_elsewhere.Known()))
    assert [step.partial for step in steps if step.partial is not None] == [ready]


def click(qtbot: Any, widget: QWidget) -> None:
    qtbot.mouseClick(widget, Qt.MouseButton.LeftButton)


def choose(page: Any, qtbot: Any, *names: str) -> None:
    """Click check boxes until `names` alone are chosen."""
    for name, card in page.cards.items():
        if card.box.isChecked() != (name in names):
            card.box.click()


def test_the_window_offers_what_the_engine_has() -> None:
    assert list(EXPORTERS) == list(export.NAMES) == [each.name for each in export.targets()]
    assert [*exporting.PRESETS, *exporting.CODINGS] == [*PRESETS, *CODINGS]
    assert [name for name, _ in elsewhere.NORMALS] == list(exporting.NORMALS)
    assert [name for name, _ in elsewhere.PRESETS] == list(PRESETS) == list(CLI_PRESETS)
    assert [name for name, _ in elsewhere.CODINGS] == list(CODINGS) == list(CLI_CODINGS)


def test_cards_say_what_is_lost_and_the_files_say_the_same(
    page: Any, window: MainWindow, qtbot: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    choose(page, qtbot, "textures", "shaders")
    assert page.export.text() == "Export 2 targets"
    page.name.setText("felt elsewhere")
    click(qtbot, page.export)
    with qtbot.waitSignal(page.exporting.succeeded, timeout=240_000):
        pass
    record = json.loads((tmp_path / "felt elsewhere" / export.RECORD).read_text())
    assert [entry["target"] for entry in record["targets"]] == ["textures", "shaders"]
    for entry in record["targets"]:
        card = page.cards[entry["target"]]
        texts = [figure.text() for figure in card.figures]
        assert texts[0] == percent(entry["rmse_rel_reference"], 3)
        assert texts[2] == percent(entry["rmse_rel"], 3)
        assert texts[3] == size_text(entry["bytes"])
        assert card.sphere.image is not None
    assert page.own.figures[2].text() == percent(record["material"]["rmse_rel"], 3)
    assert "felt elsewhere written" in page.verdict.text()
    assert page.export.isEnabled()
    written = sorted(path for path in (tmp_path / "felt elsewhere").rglob("*") if path.is_file())
    listed = page.files.text().replace("\u200b", "").splitlines()
    assert [line.rpartition(", ")[0] for line in listed] == [
        *(name for entry in record["targets"] for name in entry["files"]),
        export.RECORD,
    ]
    assert len(written) == len(listed)
    opened: list[QUrl] = []
    monkeypatch.setattr("app.export.elsewhere.QDesktopServices.openUrl", opened.append)
    click(qtbot, page.show_folder)
    assert [Path(url.toLocalFile()) for url in opened] == [tmp_path / "felt elsewhere"]


def test_what_cannot_be_exported_says_why_in_one_sentence(page: Any) -> None:
    card = page.cards["rti"]
    assert not card.box.isEnabled()
    assert card.words.text() == "An RTI file needs light from several sides: give the stack of a dome."
    assert card.box.toolTip() == card.words.text()
    assert "nearest metallic-roughness, 9 % away" in page.cards["brdf"].words.text()


def test_the_smallest_within_an_error_is_the_choice_of_the_command_line(anew: None, page: Any, qtbot: Any) -> None:
    """Of all that show the surface; slices in shaders are the material itself, and without them nothing is."""
    best = export.choice([page.found[name] for name in export.candidates() if name != "rti"], 10.0)["chosen"]
    page.budget.edited.emit(1000.0, True)
    click(qtbot, page.choose)
    assert page.names == [best]
    page.budget.edited.emit(0.0, True)
    click(qtbot, page.choose)
    assert page.names == ["shaders"]
    assert page.chosen.text().startswith("Shaders by its slices keeps it at 0 %, ")
    del page.found["shaders"].entry["slices"]
    click(qtbot, page.choose)
    assert "no representation keeps it" in page.chosen.text()


def test_another_preset_is_measured_alone_when_asked_for(anew: None, page: Any, window: MainWindow, qtbot: Any) -> None:
    """Nothing is measured again that was measured, and the material is not made ready again."""
    before, leaving = dict(page.found), page.leaving
    page.preset.setCurrentIndex(1)
    page.preset.activated.emit(1)
    assert set(before) - set(page.found) == {"textures"}
    qtbot.waitUntil(lambda: not page.looking.busy)
    assert not page.is_measuring
    assert "1 target is not measured" in page.state.text()
    click(qtbot, page.measure)
    qtbot.waitUntil(lambda: whole(page), timeout=240_000)
    assert page.found["textures"].entry["preset"] == "unreal"
    assert page.leaving is leaving
    assert {name for name in before if before[name] is not page.found[name]} == {"textures"}
    window.bench.document.undo_stack.undo()
    assert page.preset.currentData() == "blender"
    qtbot.waitUntil(lambda: "textures" in page.found)
    assert page.found["textures"].entry["bytes"] == before["textures"].entry["bytes"]


def test_a_capture_from_a_dome_proposes_what_conservators_publish() -> None:
    assert Exporting().targets_for(is_directional=True) == ("web", "rti")
    assert Exporting(targets=("gltf",)).targets_for(is_directional=True) == ("gltf",)
    assert Exporting(targets=()).targets_for(is_directional=False) == ()


def test_settings_belong_to_the_project(page: Any, window: MainWindow, qtbot: Any) -> None:
    document = window.bench.document
    choose(page, qtbot, "web", "usd")
    page.measure_in("cm")
    page.width_field.edited.emit(2.4, True)
    assert (document.project.exporting.targets, document.project.exporting.width_mm) == (("usd", "web"), 24.0)
    document.undo_stack.undo()
    assert page.width_field.value == 0.0
    document.undo_stack.undo()
    assert page.names != ["usd", "web"]


def test_another_material_is_measured_when_asked_for_and_the_former_is_known(
    page: Any, window: MainWindow, qtbot: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    before, document = dict(page.found), window.bench.document
    material = document.project.material
    document.change("BRDF", material=dataclasses.replace(material, brdf="lambert:albedo=0.2"))
    assert page.found == {}
    assert page.cards["textures"].figures[0].text() == "–"
    qtbot.waitUntil(lambda: not page.looking.busy)
    assert set(page.found) == {"rti"}
    monkeypatch.setattr(export, "departure", None)  # nothing is made ready any more
    document.undo_stack.undo()
    qtbot.waitUntil(lambda: not page.looking.busy)
    assert whole(page)
    for name, offer in before.items():
        again = page.found[name]
        assert {key: offer.entry[key] for key in again.entry if key in offer.entry} == again.entry
        assert again.why_not == offer.why_not
        np.testing.assert_array_equal(again.sphere, offer.sphere)
    assert page.cards["gltf"].sphere.image is not None


def test_what_was_stopped_stays_stopped(page: Any, window: MainWindow, qtbot: Any) -> None:
    document = window.bench.document
    document.change("BRDF", material=dataclasses.replace(document.project.material, brdf="lambert:albedo=0.3"))
    qtbot.waitUntil(lambda: not page.looking.busy)
    click(qtbot, page.measure)
    click(qtbot, page.stop)
    assert "Stopped" in page.state.text()
    qtbot.waitUntil(lambda: not page.latest.busy, timeout=240_000)
    window.show_workspace("view")
    window.show_workspace("export")
    assert not page.is_measuring
    assert not page.latest.busy
    assert page.measure.isVisible()


def test_a_cancelled_export_leaves_nothing(page: Any, window: MainWindow, qtbot: Any, tmp_path: Path) -> None:
    page.name.setText("never")
    click(qtbot, page.export)
    window.bench.jobs.cancel(page.exporting)
    with qtbot.waitSignal(page.exporting.cancelled, timeout=240_000):
        pass
    assert page.verdict.text() == "Cancelled. Nothing was written."
    assert not (tmp_path / "never").exists()


def test_a_folder_of_something_else_is_left_alone(page: Any, window: MainWindow, qtbot: Any, tmp_path: Path) -> None:
    (tmp_path / "letters").mkdir()
    (tmp_path / "letters" / "letter.txt").write_text("Dear reader")
    page.name.setText("letters")
    click(qtbot, page.export)
    with qtbot.waitSignal(page.exporting.failed, timeout=240_000):
        pass
    assert "not ours" in page.verdict.text()
    assert (tmp_path / "letters" / "letter.txt").read_text() == "Dear reader"
    page.name.setText("a/b")
    assert not page.export.isEnabled()
    assert "without slashes" in page.export.toolTip()
