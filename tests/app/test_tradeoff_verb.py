"""`lightarc tradeoff` as a person types it."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import pytest

from app.verbs import tradeoff
from engine.effects.cost_model import NAMES, CostModel
from engine.effects.setting import MODES
from engine.steps import Step, Steps
from engine.tradeoff.point import COSTS

Command = Callable[..., SimpleNamespace]
QUICK = ("--width", "24", "--height", "18", "--budget-s", "3", "--modes", "direct")


@pytest.fixture(autouse=True)
def _known_costs(monkeypatch: pytest.MonkeyPatch) -> None:
    """What this machine costs is made up: measuring it takes longer than the tests."""

    def costs() -> Steps[CostModel]:
        yield Step(1.0, "the costs of this machine are made up")
        return CostModel("test", "test", dict.fromkeys(NAMES, ((1.0, 1e-6),)))

    monkeypatch.setattr("app.cost.cost_model", costs)


@pytest.fixture
def mesh(tmp_path: Path) -> Path:
    """A tetrahedron."""
    path = tmp_path / "tetrahedron.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
    return path


def test_the_choices_are_those_of_the_engine() -> None:
    assert tuple(COSTS) == tradeoff.AXES
    assert all(mode in " ".join(MODES) for mode in ("sh", "wavelet", "gaussian", "shading-map", "direct", "reference"))


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
            "memory_bytes",
            "size_bytes",
            "on_front",
        }
        assert point["predicted_frame_s"] > 0.0
        assert point["predicted_bake_s"] is None
    assert "break_even_frames" in found
    told = found["predictions"]
    assert told["compared"] == len(found["points"]) == told["within"] + len(told["misses"])
    assert found["choice"]["error_rmse_rel"] == min(point["error_rmse_rel"] for point in found["points"])
    assert {"tradeoff.json", "tradeoff.csv", "tradeoff.png", "tradeoff.svg"} <= {
        path.name for path in (tmp_path / "out").iterdir()
    }


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
