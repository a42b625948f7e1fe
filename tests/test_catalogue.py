"""The catalogue of hard cases reads its figures off the assertions, and knows every id."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.catalogue import (
    WITHOUT_TEST,
    Figure,
    all_ids,
    array_figure,
    as_table,
    cases_of,
    close_figure,
    figure_of,
    ids_of,
    nearest,
)

TESTS = Path(__file__).parent


def test_names_tell_their_ids() -> None:
    assert ids_of("test_W3_W4_eigenvalues_that_crowd[3-True]") == ["W3", "W4"]
    assert ids_of("test_GL10_a_shader") == ["GL10"]
    assert ids_of("test_the_X4_case") == ids_of("test_Uneven") == []


@pytest.mark.parametrize(
    ("explanation", "expected"),
    [
        ("np.float64(3e-16) <= 1e-13\n + where …", (3e-16, "<=", 1e-13)),
        ("np.float64(0.82) <= (1.0 + 0.002)", (0.82, "<=", 1.002)),
        ("-0.5 > -1", (-0.5, ">", -1.0)),
        ("1.25 == 1.0 ± 0.5", (0.25, "<=", 0.5)),
        ("3 == 3", (3.0, "=", 3.0)),
    ],
)
def test_explanations_of_assertions_are_read(explanation: str, expected: Any) -> None:
    figure = figure_of(explanation, "here")
    assert figure is not None
    assert (figure.measured, figure.relation, figure.bound) == expected


@pytest.mark.parametrize("explanation", ["np.True_", "'NO' in ['NO']", "not False", "(3, 4) == (3, 4)", "f(2) < 3"])
def test_what_compares_no_numbers_is_no_figure(explanation: str) -> None:
    assert figure_of(explanation, "here") is None


def test_arrays_are_compared_where_they_come_nearest() -> None:
    names = {"np": np, "a": np.array([1.0, 3.0, 2.0]), "b": np.array([4.0, 4.0, 40.0])}
    assert array_figure("(a <= b).all()", names, "here") == Figure(3.0, "<=", 4.0, "here")
    assert array_figure("np.all(np.abs(a) < 5)", names, "here") == Figure(3.0, "<", 5.0, "here")
    assert array_figure("(next(a) <= b).all()", names, "here") is None, "asking again would change something"
    assert array_figure("(np.random.rand(3) <= b).all()", names, "here") is None


def test_close_arrays_give_the_largest_share_of_what_is_allowed() -> None:
    figure = close_figure([1.0, 2.0, np.nan], [1.5, 2.1, np.nan], 0.0, 1.0, "here")
    assert figure is not None
    assert (figure.measured, figure.bound) == (0.5, 1.0)
    figure = close_figure([np.inf, 1.0], [np.inf, 1.5], 0.0, 1.0, "here")
    assert figure is not None
    assert figure.measured == 0.5
    assert close_figure(["a"], ["a"], 0.0, 1.0, "here") is None


def test_the_nearest_figure_is_no_count() -> None:
    small, near, count = Figure(1e-9, "<=", 1e-6, ""), Figure(0.9, "<=", 1.5, ""), Figure(64.0, "<=", 64.0, "")
    assert nearest([small, near, count]) is near
    assert nearest([count]) is count
    assert nearest([]) is None


def test_a_failed_test_fails_its_case_and_what_has_none_says_so() -> None:
    outcomes = {"X4": {"a": "passed", "b": "failed"}, "X5": {"c": "passed", "d": "skipped"}}
    cases = {case.id: case for case in cases_of(outcomes, {"X4": [Figure(0.5, "<=", 1.5, "here")]})}
    assert cases["X4"].outcome == "failed"
    assert cases["X5"].outcome == "passed"
    assert cases["X6"].outcome == "no test"
    table = as_table(list(cases.values()))
    assert "| X4 | failed | 0.5 ≤ 1.5 | `a`<br>`b` |" in table
    assert len(re.findall(r"^\| [A-Z]+\d+ \|", table, re.MULTILINE)) == len(all_ids()) == 231


def test_every_hard_case_has_a_test_or_a_reason() -> None:
    names = re.compile(r"def (test_\w+)")
    tested = {
        name for file in TESTS.rglob("test_*.py") for test in names.findall(file.read_text()) for name in ids_of(test)
    }
    assert set(all_ids()) - tested == set(WITHOUT_TEST)
    assert tested <= set(all_ids()), "an id that the catalogue does not know"
