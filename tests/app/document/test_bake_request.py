"""Requests for bakes: those that a plan chose teach the machine profile how long they took."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import trimesh

from app.document.bake_request import Estimate, Wanted, bake, choices_for, make_request
from app.project.bakes import place_of
from app.session import machine_profile
from engine.brdf.brdf import brdf_from_text
from engine.core.steps import Step, Steps, drain
from engine.geometry.mesh import Mesh
from engine.planning.ceilings import usual
from engine.planning.costs.cost_model import Cost
from engine.planning.costs.setting import Setting
from engine.planning.plan import Effect, EffectsPlan

PLANNED_S = 12.5
PLAN = EffectsPlan(
    effects=(Effect("interreflection", "skipped", "", 0.0, 0.0, 0), Effect("self-shadowing", "needed", "", 0.1, 0, 0)),
    setting=Setting("sh", {"order": 3, "interreflection": 0}),
    predicted_error_rel=0.1,
    error_interval_rel=(0.0, 0.2),
    cost=Cost(PLANNED_S, 0.01, 0.01, 1000, 1000),
    satisfied=True,
    unoccluded_fraction=0.0,
    times_within=1.5,
    ceilings=usual(),
)


def ask(order: int = 3, plan: EffectsPlan | None = PLAN) -> Wanted:
    made = trimesh.creation.icosphere(subdivisions=1)
    positions = np.asarray(made.vertices, np.float64)
    uv = np.zeros((len(positions), 2), np.float32)
    sphere = Mesh(positions, positions.astype(np.float32), uv, np.asarray(made.faces, np.int32), "ball")
    return make_request(sphere, None, brdf_from_text("lambert:albedo=0.5"), choices_for("sh", order=order), plan)


def test_only_the_bake_that_the_plan_chose_has_its_time() -> None:
    forced = replace(PLAN, effects=(replace(PLAN.effects[0], decision="needed"), PLAN.effects[1]))
    assert ask().predicted_s == PLANNED_S
    assert ask(order=4).predicted_s is None, "another setting"
    assert ask(plan=forced).predicted_s is None, "interreflection is part of the setting"
    assert ask(plan=None).predicted_s is None


def test_a_bake_by_part_is_another_one_for_other_materials(tmp_path: Path) -> None:
    whole, (red, grey) = ask().mesh, (brdf_from_text(f"lambert:albedo={text}") for text in ("0.8/0.1/0.1", "0.5"))
    mesh = replace(whole, part=np.arange(len(whole.faces), dtype=np.int32) % 2, part_names=("a", "b"))
    one, other, none = (
        make_request(mesh, None, grey, choices_for("sh"), None, (), parts) for parts in ((red, grey), (grey, red), ())
    )
    assert len({place_of(each, tmp_path) for each in (one, other, none)}) == 3
    assert one.reflects_as(replace(one, brdf=red))
    assert not one.reflects_as(other)
    assert not none.reflects_as(one)
    assert one.subject.parts == (red, grey)
    assert len(one.subject.mesh.positions) > len(mesh.positions)


@pytest.mark.parametrize(("order", "resumed_chunks", "lessons"), [(3, 0, 1), (4, 0, 0), (3, 2, 0)])
def test_a_predicted_bake_teaches_the_profile_unless_it_was_resumed(
    order: int, resumed_chunks: int, lessons: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    learnt = list[tuple[str, float, float]]()
    monkeypatch.setattr("engine.accuracy.bake_check.check_file", lambda *_words: (_ for _ in ()))
    monkeypatch.setattr(machine_profile, "learn", lambda *lesson: learnt.append(lesson[:3]))
    monkeypatch.setattr("engine.transport.sh_method.casts_rays", lambda _work: False)

    def start(_path: Path) -> Steps[Any]:
        yield Step(0.5, "baking")
        file = SimpleNamespace(size_bytes=7)
        return SimpleNamespace(transport=None, bake_s=20.0, visibility_s=0.0, resumed_chunks=resumed_chunks, file=file)

    made = drain(bake(tmp_path / "ball.transport", Estimate(ask(order), None, 0.0, start)))
    assert made.bake_s == 20.0
    assert learnt == [("sh", PLANNED_S, 20.0)] * lessons


def test_a_bake_that_began_without_a_plan_serves_the_plan_that_comes() -> None:
    """It leaves nothing out; only what a user decides asks for another one."""
    skipped = replace(PLAN, effects=tuple(replace(each, decision="skipped") for each in PLAN.effects))
    off = replace(PLAN, effects=(PLAN.effects[0], replace(PLAN.effects[1], decision="forced off")))
    assert ask(plan=None).covers(ask(plan=skipped))
    assert not ask(plan=None).covers(ask(plan=off))
    assert not ask(plan=None).covers(ask(order=4, plan=skipped))
