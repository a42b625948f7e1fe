"""Factor runs and bakes of a project made anew: equal bit by bit, and a reason where they are not or cannot be."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from app.commands.brdf import fit
from app.commands.replay import EDITED, LOST, NOT_AT_END, NOT_FOUND_YET, OTHER_STATE, SAME, TARGET_GONE, replay
from app.document.bake_request import Wanted, choices_for, estimate
from app.document.comparison import Comparison, Fitted
from app.document.document import Project
from app.document.factoring import Factoring, Run
from app.project.bakes import bake_and_keep, place_of
from app.project.factors import Keeping
from app.project.factors import place_of as place_of_factors
from app.project.project_file import data_folder
from engine.brdf.brdf import brdf_from_text
from engine.core.steps import drain
from engine.factor.factor import factor
from engine.factor.settings import FactorSettings
from engine.geometry.mesh import Mesh
from engine.scene.material import Material
from tests.app.command import Command
from tests.app.commands.test_replay import save

GLOSSY = "ggx:kd=0.5,alpha=0.4,f0=0.04"


def sphere() -> Mesh:
    made = trimesh.creation.icosphere(subdivisions=1)
    positions = np.asarray(made.vertices, np.float64)
    uv = np.zeros((len(positions), 2), np.float32)
    return Mesh(positions, positions.astype(np.float32), uv, np.asarray(made.faces, np.int32), "ball")


@pytest.fixture
def project(coarse: None, tmp_path: Path) -> tuple[Path, Project, Run]:
    """A project without photographs, with a factor run and a bake."""
    given = brdf_from_text(GLOSSY)
    run = Run(7, 0, "GGX", "material", FactorSettings(side=8, products=2), given)
    made = Project(
        mesh=sphere(),
        material=Material(None, None, brdf=GLOSSY, name="Ball"),
        bakes={"sh": {"order": 3}},
        factoring=Factoring().with_run(run),
    )
    path = save(tmp_path / "a.lap", made)
    assert run.choices is not None
    Keeping(run, data_folder(path)).keep(drain(factor(given, run.choices, None)))
    wanted = Wanted(sphere(), None, given, choices_for("sh", order=3))
    drain(bake_and_keep(drain(estimate(wanted)), data_folder(path)))
    return path, made, run


def verdicts(results: list[dict[str, Any]]) -> dict[str, bool | None]:
    return {each["name"]: each["bit_equal"] for each in results}


def test_runs_and_bakes_are_equal_bit_by_bit(
    project: tuple[Path, Project, Run], lightarc: Command, tmp_path: Path
) -> None:
    found = lightarc("project", "replay", project[0], "-o", tmp_path / "again", "--json")
    assert found.code == 0, found.err
    results = json.loads(found.out)["results"]
    assert list(verdicts(results).values()) == [True, True], results
    names = list(verdicts(results))
    assert names[0].startswith("factors of GGX, ")
    assert names[1].startswith("bake sh, order 3")
    assert json.loads((tmp_path / "again" / "replay.json").read_text()) == results


def test_differences_are_named(project: tuple[Path, Project, Run], tmp_path: Path) -> None:
    """A result is put in place of another: the replay does not call them equal."""
    path, _, run = project
    folder = data_folder(path)
    assert run.choices is not None
    other = drain(factor(brdf_from_text("ggx:kd=0.5,alpha=0.3,f0=0.04"), run.choices, None))
    Keeping(run, folder).keep(dataclasses.replace(other, searching=True))
    wanted = Wanted(sphere(), None, brdf_from_text(GLOSSY), choices_for("sh", order=3))
    another = Wanted(sphere(), None, brdf_from_text("lambert:albedo=0.3"), choices_for("sh", order=3))
    drain(bake_and_keep(drain(estimate(another)), tmp_path / "elsewhere"))
    place_of(another, tmp_path / "elsewhere").replace(place_of(wanted, folder))
    factors, bake = drain(replay(path, tmp_path / "again"))
    assert (factors["bit_equal"], bake["bit_equal"]) == (False, False)
    assert NOT_AT_END in factors["reason"]
    assert "differ: settings are the same" in bake["reason"]


def test_results_of_other_states_and_lost_ones_are_told_apart(
    project: tuple[Path, Project, Run], tmp_path: Path
) -> None:
    path, made, run = project
    for place in data_folder(path).glob("bake-*"):
        place.unlink()
    place_of_factors(run, data_folder(path)).rename(tmp_path / "away")
    results = drain(replay(path, tmp_path / "again"))
    assert [(each["bit_equal"], each["reason"]) for each in results] == [(None, LOST), (None, LOST)]
    unfinished = dataclasses.replace(run, number=8, choices=FactorSettings(side=8, products=1))
    runs = Factoring().with_run(unfinished)
    save(path, dataclasses.replace(made, material=Material(None, None, brdf="lambert", name="Ball"), factoring=runs))
    results = drain(replay(path, tmp_path / "other"))
    assert [each["reason"] for each in results] == [NOT_FOUND_YET, OTHER_STATE]


def test_fits_are_made_again_from_their_targets(project: tuple[Path, Project, Run], tmp_path: Path) -> None:
    path, made, _ = project
    target = brdf_from_text("lambert:albedo=0.4")
    found = drain(fit(target, "lambert", "cosine"))
    note = Fitted("paper", "cosine", 1.0, 0.0)
    compared = Comparison().added("paper", target).added("Lambert to paper", found.brdf, fitted=note)
    turned = compared.added("turned", brdf_from_text("lambert:albedo=0.41"), fitted=note)
    turned = turned.added("orphan", found.brdf, fitted=Fitted("gone", "cosine", 1.0, 0.0))
    alone = dataclasses.replace(made, comparison=turned, factoring=Factoring(), bakes={})
    results = drain(replay(save(path, alone), tmp_path / "again"))
    verdict = {each["name"]: (each["bit_equal"], each["reason"]) for each in results}
    assert verdict["fit Lambert to paper"] == (True, SAME)
    assert verdict["fit turned"] == (False, f"albedo differ: {EDITED}")
    assert verdict["fit orphan"] == (None, TARGET_GONE)
