"""Numbers with units on the command line."""

from __future__ import annotations

import argparse
import math

import pytest

from app.arguments.quantities import MEGABYTES, MILLIMETRES, MILLISECONDS, Degrees, share, size_bytes


def test_units_are_converted() -> None:
    assert Degrees(2)("45,0.5rad") == (45.0, math.degrees(0.5))
    assert Degrees(1)("90°") == 90.0
    assert share("5 %") == share("0.05") == 0.05
    assert MILLIMETRES("0.12m") == MILLIMETRES("120") == MILLIMETRES("12 cm") == 120.0
    assert MILLISECONDS("0.016s") == 16.0
    assert MEGABYTES("2GB") == 2000.0
    assert size_bytes("1.5GiB") == 3 << 29


@pytest.mark.parametrize("angles", ["45,0", "1,2", "0.5,0", "5,10,20", "90,1.57", "-30,0", "0,0", "6.5,6.28"])
def test_degrees_that_can_be_meant_are_taken(angles: str) -> None:
    assert Degrees(0)(angles) == tuple(map(float, angles.split(",")))


@pytest.mark.parametrize("angles", ["0.785,0", "1.5708,-0.25", "0.3,0.8,1.2"])
def test_radians_are_questioned(angles: str) -> None:
    with pytest.raises(argparse.ArgumentTypeError, match=r"seem to be radians; write .*rad or .*deg"):
        Degrees(0)(angles)


@pytest.mark.parametrize(
    ("read", "text", "said"),
    [
        (share, "5", "5 is 500%; write that if it is meant, or 5%"),
        (share, "5m", "is not a share"),
        (MILLIMETRES, "0.12", "hardly meant"),
        (MILLIMETRES, "3 feet", "unit 'feet'"),
        (MILLIMETRES, "wide", "is not a number such as 120mm"),
        (size_bytes, "2", "is not a size"),
        (Degrees(2), "45", "is not angles"),
        (Degrees(2), "inf,0", "is not finite"),
    ],
)
def test_what_cannot_be_meant_is_said(read: object, text: str, said: str) -> None:
    with pytest.raises(argparse.ArgumentTypeError, match=said):
        read(text)  # type: ignore[operator]
