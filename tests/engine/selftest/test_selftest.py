"""The self-test asks what the catalogue asks, tells failures instead of hiding them, and can be narrowed."""

from __future__ import annotations

import math

import pytest

from engine.core.steps import Step, drain
from engine.selftest.case import Case, Question
from engine.selftest.run import QUESTIONS, ask, selftest

GROUPS = {"R", "AL", "S", "P", "BR", "M", "F", "W", "L", "Q", "H", "Z", "V", "G", "EN", "GL", "CO", "T", "X", "D"}

#: Numbers that files may hold, which the catalogue does not ask for.
FURTHER = {"N"}


def test_every_group_of_the_catalogue_has_a_row() -> None:
    assert {question.id.rstrip("0123456789") for question in QUESTIONS} == GROUPS | FURTHER
    assert len(QUESTIONS) >= 40


@pytest.mark.parametrize("question", QUESTIONS, ids=lambda question: f"{question.id}-{question.ask.__name__}")
def test_this_machine_passes(question: Question) -> None:
    case = ask(question)
    assert case.passed, f"{case.measured} > {case.bound} {case.problem}"
    assert case.problem == ""


@pytest.mark.parametrize("figure", [2.0, math.nan, math.inf])
def test_what_is_out_of_bounds_does_not_pass(figure: float) -> None:
    case = ask(Question("H1", "a figure", lambda: (figure, 1.0)))
    assert not case.passed
    assert math.isfinite(case.measured)


def test_a_row_that_raises_is_reported_and_does_not_pass() -> None:
    case = ask(Question("H1", "a figure", lambda: (1.0 / 0.0, 1.0)))
    assert not case.passed
    assert "ZeroDivisionError" in case.problem


def test_what_is_done_is_shown_on_the_way() -> None:
    partial: list[tuple[Case, ...]] = []

    def keep(step: Step) -> None:
        partial.append(step.partial)

    cases = drain(selftest(("CO", "H6")), keep)
    assert [case.id for case in cases] == ["CO1", "CO5", "CO7", "H6"]
    assert [len(each) for each in partial] == [0, 1, 2, 3, 4]


def test_an_unknown_case_is_refused() -> None:
    with pytest.raises(ValueError, match="unknown case"):
        drain(selftest(("Y9",)))
