"""Bakes of the window show what their mode shows: the plan advises, and what a user switches off is not baked."""

from __future__ import annotations

import dataclasses
import time
from typing import Any

import pytest

from app.document.bake_request import choices_for, decide, make_request
from app.view.bake_panel import state_text
from app.view.baking import Baking
from app.window.main_window import MainWindow
from engine.core.steps import Step, Steps
from engine.planning import plan as planning_of_scenes
from engine.planning.plan import Effect
from tests.app.view.test_baking import LONG, ball, built_in, sphere
from tests.present import present


@pytest.fixture
def planned(window: MainWindow, qtbot: Any) -> MainWindow:
    """A ball, which neither shades nor lights itself, under the studio in spherical harmonics of few bands."""
    document = window.bench.document
    material = dataclasses.replace(document.project.material, brdf="phong:exponent=5")
    document.change("Ball", mesh=ball(), environment=built_in("studio"), material=material)
    window.show_workspace("view")
    window.view.bakings["sh"].choose(choices_for("sh", order=3))
    window.view.choose_mode("sh")
    return window


def wish(window: MainWindow, effect: str, value: str) -> None:
    box = window.docks.effects.wishes[effect]
    box.setCurrentIndex(box.findData(value))
    box.activated.emit(0)


def bake(window: MainWindow, qtbot: Any) -> Baking:
    """Bake what is wanted, once it is known."""
    baking = window.view.bakings["sh"]
    qtbot.waitUntil(lambda: window.docks.effects.plan is not None and baking.ready is not None, timeout=LONG)
    window.view.bake_panels["sh"].go.click()
    qtbot.waitUntil(lambda: baking.job is None and baking.is_made, timeout=LONG)
    return baking


def names(effects: tuple[Effect, ...]) -> tuple[str, ...]:
    return tuple(effect.effect for effect in effects)


def test_shadows_are_baked_unless_a_user_switches_them_off(planned: MainWindow, qtbot: Any) -> None:
    panel = planned.view.bake_panels["sh"]
    baking = bake(planned, qtbot)
    plan = present(planned.docks.effects.plan)
    assert plan.decision("self-shadowing") == "skipped", "a ball does not shade itself"
    assert present(baking.made).wanted.left_out == ()
    assert present(baking.estimate).work.settings.shadows
    assert present(baking.estimate).work.settings.bounces == 0
    wish(planned, "self-shadowing", "off")
    baking = bake(planned, qtbot)
    assert names(present(baking.made).wanted.left_out) == ("self-shadowing",)
    assert not present(baking.estimate).work.settings.shadows, "no ray is cast"
    assert "Not shown: shadows." in panel.words.text()


def test_a_bake_begins_at_once_although_the_plan_is_on_its_way(planned: MainWindow, qtbot: Any) -> None:
    baking, panel = planned.view.bakings["sh"], planned.view.bake_panels["sh"]
    planned.view.planning.at_rest.setInterval(LONG)  # the plan does not come
    planned.bench.document.change("Another", mesh=dataclasses.replace(sphere()))
    assert baking.is_planning
    assert panel.go.isEnabled()
    panel.go.click()
    assert panel.go.text() == "Stop baking"
    qtbot.waitUntil(lambda: baking.made is not None, timeout=LONG)
    assert present(baking.made).wanted.plan is None
    assert planned.view.planning.plan is None


def endless() -> Steps[None]:
    while True:
        time.sleep(0.01)
        yield Step(0.0, "")


def test_a_bake_that_follows_a_wish_waits_for_no_other_computation(planned: MainWindow, qtbot: Any) -> None:
    """The plan that it needs is made at once, though plans are work for idle moments otherwise."""
    baking = planned.view.bakings["sh"]
    qtbot.waitUntil(lambda: planned.docks.effects.plan is not None, timeout=LONG)
    other = planned.bench.jobs.submit("Searching for factors", endless, lane="compute")
    planned.view.planning.at_rest.setInterval(LONG)
    wish(planned, "glossy", "off")
    assert baking.is_planning
    planned.view.bake_panels["sh"].go.click()
    qtbot.waitUntil(lambda: baking.is_made and baking.job is None, timeout=LONG)
    assert not other.over
    planned.bench.jobs.cancel(other)


def test_a_forced_effect_is_one_step_and_calls_for_another_bake(planned: MainWindow, qtbot: Any) -> None:
    baking, stack, panel = bake(planned, qtbot), planned.bench.document.undo_stack, planned.view.bake_panels["sh"]
    count = stack.count()
    wish(planned, "glossy", "off")
    assert stack.count() == count + 1
    qtbot.waitUntil(lambda: baking.ready is not None, timeout=LONG)
    assert not baking.is_made
    assert baking.is_drawn, "the image keeps what was baked before"
    assert "Not shown: gloss (" in panel.words.text()
    assert present(bake(planned, qtbot).made).transport.diffuse, "nothing of the view is baked"
    for move, is_diffuse in ((stack.undo, False), (stack.redo, True)):
        move()
        qtbot.waitUntil(lambda: baking.is_made and not baking.is_planning, timeout=LONG)
        assert present(baking.made).transport.diffuse == is_diffuse, "the bake that was made of this wish"


def test_bounces_that_are_forced_are_baked_and_cannot_be_left_out(planned: MainWindow, qtbot: Any) -> None:
    qtbot.waitUntil(lambda: planned.docks.effects.plan is not None, timeout=LONG)
    wish(planned, "interreflection", "on")
    baking, choice = bake(planned, qtbot), planned.view.bake_panels["sh"].choices["interreflection"]
    assert baking.made is not None
    assert baking.made.transport.interreflection
    assert (choice.isEnabled(), choice.currentData(), choice.toolTip()) == (False, True, "Forced under Effects")
    assert planned.view.setting["interreflection"] == 1


def test_a_plan_is_made_for_a_bake_although_its_dock_is_closed(planned: MainWindow, qtbot: Any) -> None:
    planned.docks.effects.close()
    planned.bench.document.change("Another", mesh=dataclasses.replace(sphere()))
    baking = planned.view.bakings["sh"]
    assert baking.is_planning
    assert "Analysing the scene" in state_text(baking)
    qtbot.waitUntil(lambda: baking.ready is not None, timeout=LONG)
    assert present(present(baking.ready).wanted.plan).decision("glossy") == "needed"


def test_without_a_plan_all_is_baked(planned: MainWindow, qtbot: Any) -> None:
    planned.bench.document.change("One light", environment=None)
    baking = planned.view.bakings["sh"]
    qtbot.waitUntil(lambda: baking.ready is not None, timeout=LONG)
    assert baking.ready is not None
    assert baking.ready.work.settings.shadows
    assert baking.ready.wanted.left_out == ()


def test_choices_of_a_user_go_before_what_the_plan_would_do(planned: MainWindow, qtbot: Any) -> None:
    dock = planned.docks.effects
    qtbot.waitUntil(lambda: dock.plan is not None, timeout=LONG)
    mesh = sphere()
    for chosen, expected in ((None, False), (True, True), (False, False)):
        choices = choices_for("sh", interreflection=chosen)
        assert decide(choices, dock.plan).settings.interreflection is expected
        wanted = make_request(mesh, None, None, choices, dock.plan)  # type: ignore[arg-type]
        assert wanted.choices.settings.interreflection is expected


@pytest.fixture
def broken_plan(window: MainWindow, monkeypatch: pytest.MonkeyPatch) -> None:
    def find_broken(*_scene: Any, **_wishes: Any) -> None:
        raise ZeroDivisionError("a plan broke")

    monkeypatch.setattr("engine.planning.plan.plan_in_steps", find_broken)


@pytest.mark.usefixtures("broken_plan")
def test_a_plan_that_fails_is_not_waited_for(planned: MainWindow, qtbot: Any) -> None:
    planning = planned.view.planning
    qtbot.waitUntil(
        lambda: not planning.is_coming and planning.words == "This scene could not be planned.", timeout=LONG
    )
    qtbot.waitUntil(lambda: len(planned.failures.open_dialogs) == 1, timeout=LONG)
    next(iter(planned.failures.open_dialogs.values())).close()


def test_a_plan_is_for_the_view_on_screen_and_another_view_asks_for_none(
    planned: MainWindow, qtbot: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    viewport = planned.view.viewport
    planning, made, original = planned.view.planning, [], planning_of_scenes.plan_in_steps

    def note(*arguments: Any, **options: Any) -> Any:
        made.append((options["camera"], viewport.camera))
        return original(*arguments, **options)

    qtbot.waitUntil(lambda: viewport.camera is not None, timeout=LONG)
    monkeypatch.setattr(planning_of_scenes, "plan_in_steps", note)
    planned.bench.document.change("Another", mesh=dataclasses.replace(sphere()))
    qtbot.waitUntil(lambda: planning.plan is not None, timeout=LONG)
    camera = present(viewport.camera)
    viewport.camera = dataclasses.replace(camera, fov_deg=0.8 * camera.fov_deg)
    planning.refresh()
    assert planning.plan is not None
    assert not planning.is_coming
    planned.bench.document.change(
        "Budget", look=dataclasses.replace(planned.bench.document.project.look, plan_budget="3 %")
    )
    qtbot.waitUntil(lambda: planning.plan is not None and len(made) == 2, timeout=LONG)
    assert made[1] == (viewport.camera, viewport.camera)
