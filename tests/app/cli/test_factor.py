"""`lightarc factor` as a user types it."""

from __future__ import annotations

import argparse
import inspect
import re
from pathlib import Path

import pytest

from app.cli import factor
from app.document.factoring import Factoring
from engine.brdf.brdf import brdf_from_text
from engine.core.params import parameters
from engine.core.steps import Step, drain
from engine.factor.errors import METRICS
from engine.factor.factor import factor as solve
from engine.factor.factor import search_settings
from engine.factor.factor_file import read_factors
from engine.factor.hemisphere_map import KINDS
from engine.factor.separable import WEIGHTINGS
from engine.factor.separable_factors import PARAMETRISATIONS, SeparableFactors
from engine.factor.settings import DEFAULT, FactorSettings
from engine.factor.textures import SearchSettings
from lightarc import factor_brdf
from tests.app.command import Command, result

QUICK = ("--size", "8", "--samples", "300", "--terms", "2", "--json")


def test_the_choices_are_those_of_the_solvers() -> None:
    values = {parameter.name: parameter.values for parameter in parameters(FactorSettings)}
    assert values["metric"] == METRICS
    assert values["map"] == (*KINDS, "auto")
    assert values["parametrisation"] == (*PARAMETRISATIONS, "auto")
    assert values["weighting"] == WEIGHTINGS


def test_factors_are_made_measured_written_and_used(lightarc: Command, tmp_path: Path) -> None:
    folder = tmp_path / "factors"
    found = result(lightarc("factor", "lafortune:preset=blue-paint", "-o", folder, *QUICK))
    assert (found["method"], found["optimum_ratio"]) == ("symmetric", pytest.approx(1.0, abs=1e-6))
    assert found["asymmetry"] <= 1e-12
    assert [term_error["terms"] for term_error in found["terms"]] == [1, 2]
    for term_error in found["terms"]:
        assert set(METRICS) | {"rms_cosine_weighted", "rms_by_elevation_band", "time_s", "size_bytes"} <= set(
            term_error
        )
        assert len(term_error["rms_by_elevation_band"]) == len(found["elevation_bands_deg"]) - 1
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
    assert [term_error["textures"] for term_error in second["terms"]] == [1, 2]
    assert second["terms"][0]["sq_log"] == first["terms"][0]["sq_log"]
    assert second["evaluations"] > first["evaluations"]


def test_what_is_cancelled_keeps_the_best_so_far(tmp_path: Path) -> None:
    folder = tmp_path / "best"
    parser = argparse.ArgumentParser()
    factor.add_arguments(parser)
    words = ["phong", "--method", "search", "--restarts", "2", "--size", "6", "--samples", "300", "--terms", "3"]

    def interrupt(step: Step) -> None:
        if step.partial is not None:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        factor.run(parser.parse_args(words), interrupt)
    found = factor.run(parser.parse_args([*words, "-o", str(folder)]), interrupt)
    assert (found["cancelled"], found["exit_code"]) == (True, 4)
    assert len(read_factors(folder).term_errors) == len(found["terms"]) >= 1
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
    assert re.search(r"truncation error over the optimum 1(\.0000\d+)? in the ", command.out)
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


def test_window_command_line_notebook_and_solvers_begin_alike() -> None:
    parser = argparse.ArgumentParser()
    factor.add_arguments(parser)
    assert factor._settings(parser.parse_args(["lambert"])) == Factoring().choices == DEFAULT
    search, solver = search_settings(DEFAULT), SearchSettings()
    assert search == solver
    for name, given in inspect.signature(factor_brdf).parameters.items():
        if name in ("method", "samples", "seed"):
            assert given.default == getattr(DEFAULT, name), name


def test_the_map_follows_the_directions_for_everyone_unless_one_is_chosen(lightarc: Command) -> None:
    typed = ("factor", "lambert", "--parametrisation", "half-diff", "--size", "6", "--samples", "50", "--json")
    assert result(lightarc(*typed))["map"] == "polar"
    assert result(lightarc(*typed, "--map", "parabolic"))["map"] == "parabolic"
    made = drain(solve(brdf_from_text("lambert"), FactorSettings(parametrisation="half-diff", side=6, samples=50)))
    assert isinstance(made.factors, SeparableFactors)
    assert made.factors.hemisphere_map.kind == "polar"


def test_sums_below_0_are_warned_of_where_factors_are_made_and_where_they_are_drawn(
    lightarc: Command, tmp_path: Path
) -> None:
    """Black bands in an image of four signed terms, as in a BRDF of Wang2004's kind."""
    text = "ashikhmin-shirley:kd=0.4,ks=0.7,nu=12,nv=120"
    words = ("--terms", 4, "--size", 16, "--samples", 500, "--json")
    for method in ("symmetric", "nonnegative"):
        folder = tmp_path / method
        made = result(lightarc("factor", text, "--method", method, *words, "-o", folder))
        image = ("--width", 16, "--height", 16, "--samples", 1, "--renderer", "cpu", "-o", tmp_path / "a.png")
        drawn = result(lightarc("render", "sphere", "--brdf", folder, *image, "--json"))
        for found in (made, drawn):
            said = [each for each in found["warnings"] if "below 0" in each]
            assert len(said) == (1 if method == "symmetric" else 0)
    assert made["negative_energy_rel"] == 0.0
