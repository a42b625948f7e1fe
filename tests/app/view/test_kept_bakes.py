"""Bakes of a project that is opened again, or goes back to a choice that was there before: read, and not made anew."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app.document.bake_request import choices_for
from app.project import bakes
from app.project.bakes import encode_note, keep, place_of, tidy, with_effects
from app.project.made import list_notes
from app.project.project_file import data_folder
from app.project.report import describe
from app.view.bake_panel import state_text
from app.view.baking import Baking
from app.window.main_window import MainWindow
from engine.brdf.brdf import brdf_from_text
from tests.app.opening import open_project
from tests.app.view.test_baking import LONG, draw, sphere
from tests.app.view.test_planning import bake, planned, wish
from tests.present import present

__all__ = ["planned"]


@pytest.fixture
def unable(monkeypatch: pytest.MonkeyPatch) -> Any:
    """A function after which no bake can be made."""
    return lambda: monkeypatch.setattr("app.project.bakes.bake", None)


def is_shown(baking: Baking, qtbot: Any) -> None:
    qtbot.waitUntil(lambda: baking.is_made, timeout=LONG)


def test_a_bake_is_there_again_in_the_project_that_is_opened(planned: MainWindow, qtbot: Any, unable: Any) -> None:
    before = present(bake(planned, qtbot).made)
    first = planned.projects.path
    qtbot.waitUntil(lambda: planned.projects.is_saved, timeout=LONG)
    planned.new()
    baking = planned.view.bakings["sh"]
    assert baking.choices == choices_for("sh")
    unable()
    open_project(planned, qtbot, first)
    planned.show_workspace("view")
    assert baking.choices.value("order") == 3
    is_shown(baking, qtbot)
    again = present(baking.made)
    assert again is not before
    assert np.array_equal(again.transport.rows, before.transport.rows)
    assert again.bake_s == pytest.approx(present(before.bake_s), abs=1e-3)
    assert state_text(baking).startswith("Baked in ")
    qtbot.waitUntil(lambda: draw(planned) is not None, timeout=LONG)
    (found,) = [each for each in describe(first)["derived"] if each["kind"] == "bake"]
    assert (found["present"], found["bytes"]) == (True, again.size_bytes)


def test_settings_that_were_there_before_find_their_bake(planned: MainWindow, qtbot: Any, unable: Any) -> None:
    """A setting is one step of the history; undone, redone or chosen back, its bake is read."""
    baking, stack = bake(planned, qtbot), planned.bench.document.undo_stack
    three, count = present(baking.made), stack.count()
    choice = planned.view.bake_panels["sh"].choices["order"]
    choice.setCurrentIndex(choice.findData(5))
    choice.activated.emit(0)
    assert stack.count() == count + 1
    assert baking.choices.value("order") == 5
    five = present(bake(planned, qtbot).made)
    assert five is not three
    unable()
    for move, order in ((stack.undo, 3), (stack.redo, 5)):
        move()
        is_shown(baking, qtbot)
        assert present(baking.made).transport.order == order
    choice.setCurrentIndex(choice.findData(3))
    choice.activated.emit(0)
    is_shown(baking, qtbot)
    assert np.array_equal(present(baking.made).transport.rows, three.transport.rows)


def test_a_bake_that_another_plan_led_to_is_drawn_and_not_taken_for_the_wanted_one(
    planned: MainWindow, qtbot: Any
) -> None:
    baking = bake(planned, qtbot)
    first = present(baking.made)
    wish(planned, "self-shadowing", "on")
    baking.made = None
    qtbot.waitUntil(lambda: baking.ready is not None and baking.made is not None, timeout=LONG)
    assert not baking.is_made
    assert baking.is_drawn
    assert present(baking.made).wanted.decided == first.wanted.decided
    assert "This was not baked yet." in state_text(baking)


def test_a_lost_bake_is_said_with_its_cost_and_baked_again(planned: MainWindow, qtbot: Any) -> None:
    bake(planned, qtbot)
    first = planned.projects.path
    qtbot.waitUntil(lambda: planned.projects.is_saved, timeout=LONG)
    planned.new()
    for place in data_folder(first).glob("bake-*"):
        place.unlink()
    said: list[str] = []
    planned.bench.said.connect(said.append)
    open_project(planned, qtbot, first)
    planned.show_workspace("view")
    assert "Gone from the data folder: a bake. Making that again takes about" in said[0]
    (made,) = list_notes(first)
    assert not made.present
    bake(planned, qtbot)
    assert list_notes(first)[0].present


def test_a_damaged_bake_is_left_out(planned: MainWindow, qtbot: Any, caplog: pytest.LogCaptureFixture) -> None:
    made = present(bake(planned, qtbot).made)
    folder = planned.bench.folder
    place = place_of(made.wanted, folder)
    assert keep(made.wanted, folder) is not None
    content = bytearray(place.read_bytes())
    content[-1] ^= 1
    place.write_bytes(content[: len(content) - 5])
    assert keep(made.wanted, folder) is None
    assert "is damaged or cut short" in caplog.text


def test_bakes_are_found_by_what_they_were_made_from(planned: MainWindow, qtbot: Any, tmp_path: Path) -> None:
    """Another BRDF, ground, model, setting or decision is another bake; the name and time of a plan are not."""
    wanted = present(bake(planned, qtbot).made).wanted
    plan = present(wanted.plan)
    place = place_of(wanted, tmp_path)
    assert (
        place_of(dataclasses.replace(wanted, plan=dataclasses.replace(plan, unoccluded_fraction=0.123)), tmp_path)
        == place
    )
    assert place_of(with_effects(wanted, encode_note(wanted)["effects"]), tmp_path) == place
    assert place_of(dataclasses.replace(wanted, mesh=dataclasses.replace(sphere())), tmp_path) == place
    forced = [[name, "forced on", error] for name, _, error in encode_note(wanted)["effects"]]
    moved = dataclasses.replace(wanted.mesh, positions=wanted.mesh.positions + 1.0)
    others = [
        dataclasses.replace(wanted, brdf=brdf_from_text("ggx")),
        dataclasses.replace(wanted, mesh=moved),
        dataclasses.replace(wanted, ground=planned.bench.document.project.look.__class__(has_ground=True).ground),
        dataclasses.replace(wanted, choices=choices_for("sh", order=4)),
        dataclasses.replace(wanted, choices=choices_for("gaussian")),
        with_effects(wanted, forced),
        with_effects(wanted, None),
    ]
    assert len({place, *(place_of(other, tmp_path) for other in others)}) == 1 + len(others)


def test_a_folder_keeps_no_more_bakes_than_there_is_room_for(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import os

    monkeypatch.setattr(bakes, "KEPT", 3)
    monkeypatch.setattr(bakes, "MAX_BYTES", 25)
    for age, (name, size) in enumerate([("a", 30), ("b", 10), ("c", 10), ("d", 10), ("e", 1)]):
        for path in (tmp_path / f"bake-{name}.transport", tmp_path / f".bake-{name}.transport.unfinished"):
            path.write_bytes(bytes(size))
            os.utime(path, (1e9 - age, 1e9 - age))
    tidy(tmp_path)
    assert {path.name for path in tmp_path.glob("bake-*")} == {"bake-a.transport"}
    assert sorted(path.name[6] for path in tmp_path.glob(".bake-*")) == ["a", "b", "c"]
    os.utime(tmp_path / "bake-a.transport", (1e8, 1e8))
    for name in "bcde":
        (tmp_path / f"bake-{name}.transport").write_bytes(bytes(10))
    tidy(tmp_path)
    assert len(list(tmp_path.glob("bake-*"))) == 2


def test_another_project_shows_no_bake_of_this_one(planned: MainWindow, qtbot: Any) -> None:
    document, baking = planned.bench.document, bake(planned, qtbot)
    of = document.project
    planned.new()
    document.change("The same", mesh=of.mesh, environment=of.environment, material=of.material)
    planned.show_workspace("view")
    baking.choose(choices_for("sh", order=3))
    planned.view.choose_mode("sh")
    assert baking.made is None
    qtbot.waitUntil(lambda: baking.ready is not None, timeout=LONG)
    assert not baking.is_drawn


def test_a_second_window_finds_bakes_and_leaves_its_own_elsewhere(
    planned: MainWindow, qtbot: Any, tmp_path: Path, unable: Any
) -> None:
    baking = bake(planned, qtbot)
    planned.bench.own = tmp_path / "own"
    planned.bench.own.mkdir()
    before = set(planned.bench.folder.glob("bake-*"))
    baking.choose(choices_for("sh", order=4))
    bake(planned, qtbot)
    assert set(planned.bench.folder.glob("bake-*")) == before
    assert len(list(planned.bench.own.glob("bake-*"))) == 1
    unable()
    for order in (3, 4):
        baking.choose(choices_for("sh", order=order))
        is_shown(baking, qtbot)
