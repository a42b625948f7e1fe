"""`lightarc tradeoff` as a user types it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from app.cli.transport import tradeoff
from app.document.document import Project
from app.project.project_file import History, Writer
from engine.core.errors import UsageError
from engine.core.steps import Step, Steps
from engine.geometry.shapes import shape
from engine.light.sky import make_built_in
from engine.planning.costs.cost_model import NAMES, CostModel
from engine.planning.costs.setting import modes
from engine.scene.material import Material
from engine.tradeoff import sweep as sweeping
from engine.tradeoff.point import COSTS
from tests.app.command import Command

pytestmark = pytest.mark.usefixtures("coarse")

SMALL = ("--width", "24", "--height", "18", "--modes", "direct")
QUICK, LONG = (*SMALL, "--budget-s", "1"), (*SMALL, "--budget-s", "600")


@pytest.fixture(autouse=True)
def _known_costs(monkeypatch: pytest.MonkeyPatch) -> None:
    """Replace the machine profile by made-up costs: measuring it takes longer than the tests."""

    def costs() -> Steps[CostModel]:
        yield Step(1.0, "the costs of this machine are made up")
        return CostModel("test", "test", dict.fromkeys(NAMES, ((1.0, 1e-6),)))

    monkeypatch.setattr("app.session.machine_profile.cost_model", costs)


def test_the_choices_are_those_of_the_engine() -> None:
    assert tuple(COSTS) == tradeoff.AXES
    assert all(
        mode in " ".join(modes()) for mode in ("sh", "wavelet", "gaussian", "shading-map", "direct", "reference")
    )


def test_points_are_measured_and_one_is_chosen(lightarc: Command, mesh: Path, tmp_path: Path) -> None:
    words = ("tradeoff", mesh, "--brdf", "phong:exponent=5", "--env", "sky", "-o", tmp_path / "out", *QUICK)
    done = lightarc(*words, "--choose", "10 s and 1 GB", "--json")
    assert done.code == 0, done.err
    found = json.loads(done.out)
    assert found["points"]
    for point in found["points"]:
        assert point["mode"] == "direct"
        assert set(point) >= {
            "knobs",
            "error_rmse_rel",
            "error_flip",
            "error_uncertainty",
            "frame_s",
            "relight_s",
            "bake_s",
            "another_brdf_s",
            "memory_bytes",
            "size_bytes",
            "on_front",
        }
        assert point["predicted_frame_s"] > 0.0
        assert point["predicted_bake_s"] is None
    assert "break_even_frames" in found
    reported = found["predictions"]
    assert reported["compared"] == len(found["points"]) == reported["within"] + len(reported["misses"])
    assert found["choice"]["error_rmse_rel"] == min(point["error_rmse_rel"] for point in found["points"])
    assert {"tradeoff.json", "tradeoff.csv", "tradeoff.png", "tradeoff.svg"} <= {
        path.name for path in (tmp_path / "out").iterdir()
    }


def test_the_scene_of_a_project_is_measured(lightarc: Command, tmp_path: Path) -> None:
    path, material = tmp_path / "a.lap", Material(None, None, brdf="phong:exponent=5")
    writer = Writer(path)
    writer.write(History(Project(mesh=shape("plane"), environment=make_built_in("sky"), material=material)))
    writer.close()
    before = path.read_bytes()
    done = lightarc("tradeoff", path, "-o", tmp_path / "out", *QUICK, "--json")
    assert done.code == 0, done.err
    points = json.loads(done.out)["points"]
    assert {point["mode"] for point in points} == {"direct"}
    assert path.read_bytes() == before


@pytest.mark.parametrize(
    ("words", "problem"),
    [
        ((), "--brdf or --material"),
        (("--brdf", "lambert", "--material", "a.lightarc"), "--brdf or --material"),
        (("--brdf", "lambert", "--budget-s", "nan"), "--budget-s"),
        (("--brdf", "lambert", "--width", "3"), "pixels"),
        (("--brdf", "lambert", "--modes", "guess"), "guess"),
        (("--brdf", "lambert", "--modes", "shading-map"), "--material"),
        (("--brdf", "lambert", "--choose", "fast"), "budget"),
        (("--brdf", "lambert", "--max-depth", "0"), "--max-depth"),
    ],
)
def test_words_that_do_not_fit_are_wrong_usage(
    lightarc: Command, mesh: Path, tmp_path: Path, words: tuple[str, ...], problem: str
) -> None:
    done = lightarc("tradeoff", mesh, "--env", "sky", "-o", tmp_path / "out", *words)
    assert done.code == 2
    assert problem in done.err
    assert not (tmp_path / "out").exists()


def test_a_missing_model_is_bad_input(lightarc: Command, tmp_path: Path) -> None:
    done = lightarc("tradeoff", tmp_path / "none.obj", "--brdf", "lambert", "--env", "sky", "-o", tmp_path / "out")
    assert done.code == 3


def test_a_folder_that_cannot_be_is_said(lightarc: Command, mesh: Path, tmp_path: Path) -> None:
    (tmp_path / "out").write_text("a file")
    done = lightarc("tradeoff", mesh, "--brdf", "lambert", "--env", "sky", "-o", tmp_path / "out", *QUICK)
    assert done.code == 3
    assert "out" in done.err


def test_a_folder_that_was_made_for_nothing_goes_again(
    lightarc: Command, mesh: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def dark(*_: object, **__: object) -> Steps[None]:
        yield Step(0.0, "looking")
        raise UsageError("nothing is in sight")

    monkeypatch.setattr("engine.tradeoff.sweep.sweep", dark)
    done = lightarc("tradeoff", mesh, "--brdf", "lambert", "--env", "sky", "-o", tmp_path / "out", *QUICK)
    assert done.code == 2
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("with_result", [False, True])
def test_an_interrupt_keeps_what_was_measured_and_nothing_else(
    lightarc: Command, mesh: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, with_result: bool
) -> None:
    """At the first step, or at the first one with a result. That a signal interrupts: `test_command_line`."""
    whole, out = sweeping.sweep, tmp_path / "out"

    def interrupted(*values: Any, **named: Any) -> Steps[Any]:
        for step in whole(*values, **named):
            yield step
            if not with_result or step.partial is not None:
                raise KeyboardInterrupt

    monkeypatch.setattr(sweeping, "sweep", interrupted)
    done = lightarc("tradeoff", mesh, "--brdf", "phong:exponent=5", "--env", "sky", "-o", out, *LONG)
    assert done.code == 4, done.err
    assert "Traceback" not in done.err
    if not with_result:
        assert done.err.rstrip().endswith("Cancelled; nothing was written.")
        assert not out.exists()
        return
    assert "Cancelled; these are the results so far." in done.out
    record = json.loads((out / "tradeoff.json").read_text())
    assert record["cancelled"]
    assert record["points"]
    assert sorted(record["files"]) == sorted(path.name for path in out.iterdir())
