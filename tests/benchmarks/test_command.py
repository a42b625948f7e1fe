"""`lightarc bench`: what it reports. How fast things are is not asserted anywhere."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest

from app import command_line
from app.cli import bench as verb
from benchmarks import brdf, capture_truth, shading
from benchmarks import command as bench
from benchmarks.measure import Accuracy, Measure, best_of
from benchmarks.page import write_page
from engine.brdf.brdf import MODELS
from engine.core.steps import Step, Steps
from tests.app.conftest import BUILD_PARSER

KEYS = ["name", "time_s", "limit_s", "limit", "ratio"]


@pytest.fixture
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shading, "SIDE", 16)
    monkeypatch.setattr(shading, "TEXELS_FOR_SCIPY", 8)


@pytest.mark.parametrize("name", ["linearise", "power-law-fit", "power-law-fit-copy"])
def test_a_measure_stands_beside_its_limit(lightarc: Callable[..., SimpleNamespace], small: None, name: str) -> None:
    done = lightarc("bench", "--only", name, "--json")
    assert done.code == 0, done.err
    (measure,) = json.loads(done.out)["measures"]
    assert list(measure) == KEYS
    assert measure["name"] == name
    assert measure["ratio"] == measure["time_s"] / measure["limit_s"] > 0


def test_every_measure_exists() -> None:
    for place in (*bench.MEASURES.values(), *bench.ACCURACIES.values()):
        module, function = place.split(":")
        assert callable(getattr(__import__(module, fromlist=[function]), function))


def test_every_brdf_model_is_measured(
    lightarc: Callable[..., SimpleNamespace], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(brdf, "PAIRS", 1000)
    assert MODELS.keys() == set(bench.BRDFS)
    names = [f"brdf-{model}" for model in bench.BRDFS]
    done = lightarc("bench", "--only", *names, "--json")
    measures = json.loads(done.out)["measures"]
    assert [measure["name"] for measure in measures] == names
    assert {measure["pairs"] for measure in measures} == {1000}


def test_what_the_machine_lacks_is_left_out_unless_asked_for(
    lightarc: Callable[..., SimpleNamespace], monkeypatch: pytest.MonkeyPatch
) -> None:
    if not sys.platform.startswith("linux"):
        pytest.skip("only Linux can be without a display")
    for variable in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(variable, raising=False)
    asked = lightarc("bench", "--only", "window-start", "--json")
    assert asked.code == 5
    assert "display" in asked.err
    monkeypatch.setattr(bench, "MEASURES", {"window-start": bench.MEASURES["window-start"]})
    monkeypatch.setattr(bench, "ACCURACIES", {})
    all_of_them = lightarc("bench", "--json")
    assert all_of_them.code == 0
    result = json.loads(all_of_them.out)
    (left_out,) = result.pop("warnings")
    assert left_out.startswith("window-start was left out: There is no display")
    assert result == {"measures": [], "accuracies": []}


def test_the_large_import_is_measured_only_on_request(
    lightarc: Callable[..., SimpleNamespace], monkeypatch: pytest.MonkeyPatch
) -> None:
    taken: list[Any] = []
    monkeypatch.setattr(bench, "ACCURACIES", {})
    monkeypatch.setattr(
        bench, "_measure", lambda name: cast(Any, taken).append(name) or Measure(name, 1.0, 2.0, "half", {"n": 1})
    )
    lightarc("bench", "--json")
    assert not set(bench.LARGE) & set(taken)
    done = lightarc("bench", "--large", "--json")
    last = [name for name in bench.MEASURES if name in bench.LARGE][-1]
    assert json.loads(done.out)["measures"][-1] == {
        "name": last, "time_s": 1.0, "limit_s": 2.0, "limit": "half", "ratio": 0.5, "n": 1,
    }  # fmt: skip


def test_errors_stand_beside_what_is_promised(
    lightarc: Callable[..., SimpleNamespace], monkeypatch: pytest.MonkeyPatch
) -> None:
    def some(folder: Path) -> Steps[Any]:
        assert folder.is_dir()
        yield Step(0.5, "half")
        return [Accuracy("radiance-woven", 0.007, "of something", 0.01), Accuracy("rendering-woven", 0.1, "of all")]

    monkeypatch.setattr(capture_truth, "measures", some)
    done = lightarc("bench", "--only", "capture-truth", "--json")
    assert json.loads(done.out)["accuracies"][0] == {
        "name": "radiance-woven", "error": 0.007, "what": "of something", "bound": 0.01,
    }  # fmt: skip
    reported = lightarc("bench", "--only", "capture-truth").out
    assert "bound: 0.01; of something" in reported
    assert "no bound; of all" in reported


def test_an_installation_says_where_the_benchmarks_are(
    lightarc: Callable[..., SimpleNamespace], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(verb, "COMMAND", tmp_path / "command.py")
    monkeypatch.setattr(command_line, "build_parser", BUILD_PARSER)  # the options depend on it: no other test has them
    done = lightarc("bench", "--only", "linearise")
    assert done.code == 5
    assert "packaging/dev.py bench" in done.err


def test_unknown_names_are_wrong_usage(lightarc: Callable[..., SimpleNamespace]) -> None:
    assert lightarc("bench", "--only", "everything").code == 2


def test_a_user_reads_a_table(lightarc: Callable[..., SimpleNamespace], small: None) -> None:
    done = lightarc("bench", "--only", "linearise")
    assert "linearise" in done.out
    assert "limit: copying" in done.out


def test_best_of_warms_up_and_takes_the_shortest(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = iter([0.0, 5.0, 10.0, 12.0, 20.0, 29.0])
    monkeypatch.setattr("engine.core.stopwatch.time.perf_counter", lambda: next(clock))
    runs = []
    assert best_of(lambda: runs.append(os.getpid()), repeats=3) == 2.0
    assert len(runs) == 4


def test_the_page_states_every_figure_beside_its_limit() -> None:
    measure = {"name": "linearise", "time_s": 0.002, "limit_s": 0.001, "ratio": 2.0, "limit": "copying | moving"}
    error = {"name": "ray-misses", "error": 3.0, "bound": None, "what": "rays of a million"}
    page = write_page({"measures": [measure], "accuracies": [error], "warnings": ["gl-frame was left out"]}, 0.5)
    assert r"| `linearise` | 2 ms | 1 ms | 2 | copying \| moving |" in page
    assert "| `ray-misses` | 3 | none | rays of a million |" in page
    assert "- Load before the run: 0.5" in page
    assert page.endswith("- gl-frame was left out\n")
