"""Parameters are declared once; everything that reads the declaration agrees with it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.core.params import check, param, parameters, parse, unparse


@dataclass(frozen=True)
class Example:
    exponent: float = param(20.0, 0.0, 1e6, doc="Sharpness.")
    albedo: tuple[float, float, float] = param((0.5, 0.5, 0.5), 0.0, 1.0, doc="Colour.")

    def __post_init__(self) -> None:
        check(self)


@given(st.floats(0, 1e6), st.tuples(*[st.floats(0, 1)] * 3))
def test_text_gives_back_the_instance(exponent: Any, albedo: Any) -> None:
    example = Example(exponent, albedo)
    assert parse(Example, unparse(example)) == example


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("gloss=1", "choose from exponent, albedo"),
        ("exponent=-1", "outside"),
        ("exponent=nan", "outside"),
        ("albedo=0.1/0.2", "one number or r/g/b"),
        ("exponent=1/2/3", "one number"),
        ("exponent", "exponent needs a value, as exponent="),
        ("exponent=much", "not a number"),
    ],
)
def test_bad_text_is_refused_in_words(text: str, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        parse(Example, text)


def test_one_number_for_a_colour_is_grey() -> None:
    assert parse(Example, "albedo=0.25").albedo == (0.25, 0.25, 0.25)


def test_nan_is_outside_every_range() -> None:
    with pytest.raises(ValueError, match="outside"):
        Example(exponent=math.nan)


def test_labels_leave_the_unit_out() -> None:
    @dataclass(frozen=True)
    class Angles:
        sigma_deg: float = param(30.0, 0.0, 90.0, unit="°", doc="Spread of slopes.")

    assert parameters(Angles)[0].label == "Sigma"
