"""`lightarc factor` as a person types it."""

from __future__ import annotations

import argparse
import math
from pathlib import Path

import pytest

from app.cli import factor
from app.document.factoring import FactorChoices
from engine.core.steps import Step
from engine.factor.errors import METRICS
from engine.factor.factor import (
    HOMOMORPHIC_SIZE,
    HOMOMORPHIC_TERMS,
    METHOD_NAMES,
    SEPARABLE_SIZE,
    SEPARABLE_TERMS,
    FactorSettings,
)
from engine.factor.factor_file import read_factors
from engine.factor.hemisphere_map import KINDS
from engine.factor.separable_factors import PARAMETRISATIONS
from tests.app.command import Command, result

QUICK = ("--size", "8", "--samples", "300", "--terms", "2", "--json")


def test_the_choices_are_those_of_the_engine() -> None:
    assert factor.METHODS == METHOD_NAMES
    assert factor.METRICS == METRICS


def test_factors_are_made_measured_written_and_used(lightarc: Command, tmp_path: Path) -> None:
    folder = tmp_path / "factors"
    found = result(lightarc("factor", "lafortune:preset=blue-paint", "-o", folder, *QUICK))
    assert (found["method"], found["optimum_ratio"]) == ("symmetric", pytest.approx(1.0, abs=1e-6))
    assert found["asymmetry"] <= 1e-12
    assert [rung["terms"] for rung in found["terms"]] == [1, 2]
    for rung in found["terms"]:
        assert set(METRICS) | {"rms_cosine_weighted", "rms_by_elevation_band", "time_s", "size_bytes"} <= set(rung)
        assert len(rung["rms_by_elevation_band"]) == len(found["elevation_bands_deg"]) - 1
    assert any("wavelets" in sentence for sentence in found["uses"])
    assert sorted(path.name for path in folder.iterdir())[0] == "factors.json"
    info = result(lightarc("brdf", "info", folder, "--json"))
    assert (info["kind"], info["name"]) == ("separable factors", "lafortune:preset=blue-paint")
    values = lightarc("brdf", "eval", folder, "--wi-deg", "30,0", "--wo-deg", "30,180", "--json")
    assert len(result(values)["values"]) == 1


@pytest.mark.parametrize("kind", [*KINDS, "auto"])
@pytest.mark.parametrize("form", PARAMETRISATIONS)
def test_every_map_and_parametrisation(kind: str, form: str, lightarc: Command) -> None:
    command = lightarc("factor", "phong", "--map", kind, "--parametrisation", form, "--method", "svd", *QUICK)
    assert result(command)["parametrisation"] == form


def test_a_search_goes_on_where_it_ended(lightarc: Command, tmp_path: Path) -> None:
    options = ("--method", "search", "--restarts", "0", "--size", "6", "--samples", "300", "--json")
    first = result(lightarc("factor", "phong", "--terms", "1", "-o", tmp_path / "one", *options))
    assert len(first["projections"]) == 1
    more = lightarc("factor", "phong", "--terms", "2", "--resume", tmp_path / "one", "-o", tmp_path / "two", *options)
    second = result(more)
    assert [rung["textures"] for rung in second["terms"]] == [1, 2]
    assert second["terms"][0]["sq_log"] == first["terms"][0]["sq_log"]
    assert second["evaluations"] > first["evaluations"]


def test_what_is_cancelled_keeps_the_best_so_far(tmp_path: Path) -> None:
    folder = tmp_path / "best"
    parser = argparse.ArgumentParser()
    factor.add_arguments(parser)
    words = ["phong", "--method", "search", "--restarts", "2", "--size", "6", "--samples", "300", "--terms", "3"]

    def interrupted(step: Step) -> None:
        if step.partial is not None:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        factor.run(parser.parse_args(words), interrupted)
    found = factor.run(parser.parse_args([*words, "-o", str(folder)]), interrupted)
    assert (found["cancelled"], found["exit_code"]) == (True, 4)
    assert len(read_factors(folder).ladder) == len(found["terms"]) >= 1
    assert "--resume" in factor.report(found)


def test_a_table_compares_every_method_on_each_brdf(lightarc: Command) -> None:
    options = ("--restarts", "0", "--size", "6", "--samples", "300", "--terms", "1")
    found = result(lightarc("factor", "phong", "lambert", "--table", *options, "--json"))
    rows = found["table"]
    assert [row["brdf"] for row in rows] == ["phong"] * 10 + ["lambert"] * 10
    assert {row["method"] for row in rows} == {"mccool", "search", "separable"}
    searched = [row for row in rows if row["method"] == "search" and row["brdf"] == "phong"]
    forms = {(row["parametrisation"], row["reciprocal"]) for row in searched}
    assert len(forms) == 4
    assert all(row["max_theta_deg"] == pytest.approx(88.0) for row in rows)
    assert set(METRICS) <= set(rows[0])
    assert factor.report(found).count("phong: 300 samples") == 1
    assert "half-diff" in factor.report(found)


def test_the_report_is_in_words(lightarc: Command) -> None:
    command = lightarc("factor", "oren-nayar", *QUICK[:-1])
    assert command.code == 0
    assert "truncation error over the optimum 1.00000" in command.out
    assert "bands of 10°" in command.out
    assert "wavelets" in command.out


@pytest.mark.parametrize(
    ("words", "code"),
    [
        ((), 2),
        (("lambert", "phong"), 2),
        (("lambert", "--table", "-o", "factors"), 2),
        (("nonsense", "--table"), 2),
        (("nonsense",), 2),
        (("./missing.bsdf",), 3),
        (("lambert", "--size", "0"), 2),
        (("lambert", "--size", "200"), 2),
        (("lambert", "--seed", "-1"), 2),
        (("lambert", "--epsilon", "nan"), 2),
        (("lambert", "--max-theta-deg", "90"), 2),
        (("lambert", "--samples", "100000000000"), 2),
        (("lambert", "--method", "symmetric", "--parametrisation", "half-diff"), 2),
        (("lambert:albedo=0", "--method", "search"), 2),
        (("lambert", "--resume", "nowhere"), 2),
        (("lambert", "--method", "search", "--resume", "nowhere"), 3),
    ],
)
def test_what_cannot_be_is_said_in_a_sentence(words: tuple[str, ...], code: int, lightarc: Command) -> None:
    command = lightarc("factor", *words)
    assert command.code == code
    assert command.out == ""
    assert command.err.strip()
    assert "Traceback" not in command.err


def test_knobs_begin_at_the_defaults_of_the_engine() -> None:
    """On the command line and in the window, which begins with another method and with reciprocal textures."""
    parser, engine, window = argparse.ArgumentParser(), FactorSettings(), FactorChoices()
    factor.add_arguments(parser)
    typed = parser.parse_args(["lambert"])
    for name in ("method", "parametrisation", "weighting", "reciprocal", "restarts", "together", "samples", "metric"):
        assert getattr(typed, name) == getattr(engine, name), name
    for name in ("parametrisation", "map", "metric", "preset", "restarts", "together", "samples", "seed"):
        assert getattr(window, name) == getattr(engine, name), name
    assert (window.side, window.products) == (SEPARABLE_SIZE, SEPARABLE_TERMS)
    assert (window.size, window.textures) == (HOMOMORPHIC_SIZE, HOMOMORPHIC_TERMS)
    for degrees in (typed.max_theta_deg, window.max_theta_deg):
        assert math.radians(degrees) == pytest.approx(engine.max_theta)
