"""Quantities on the command line: a number, with or without its unit, where a unit that cannot be meant is questioned.

An angle is `45`, `45deg` or `0.785rad`, a share `0.05` or `5%`. A number without a unit that only makes sense in
another one (0.785 for a direction in degrees, 5 for a share) is refused with both ways to write it: work of hours must
not begin with a wrong unit, and a warning at its end would be too late.
"""

from __future__ import annotations

import argparse
import math
import string
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field

#: Letters of units.
_LETTERS = f"{string.ascii_letters}%°µ"

#: Characters of a word that a message repeats.
_LONGEST = 40


@dataclass(frozen=True, eq=False)  # argparse looks types up by their hash
class Units:
    """The type of an argument that is a number of `unit`, or of another of `factors`, which are in that unit.

    Attributes
    ----------
    least : positive numbers without a unit that are smaller are questioned. example : a value with its unit.
    """

    unit: str
    factors: Mapping[str, float]
    example: str
    least: float = 0.0

    def __call__(self, text: str) -> float:
        value, unit = split(text, f"a number such as {self.example}")
        if unit and unit not in self.factors:
            known = ", ".join(self.factors)
            raise argparse.ArgumentTypeError(f"{text[:_LONGEST]!r} has the unit {unit!r}; {known} are known")
        if not unit and 0.0 < value < self.least:
            others = " or ".join(f"{text}{each}" for each in self.factors)
            raise argparse.ArgumentTypeError(f"{text[:_LONGEST]} {self.unit} is hardly meant; write {others}")
        return value * self.factors.get(unit, 1.0)


MILLIMETRES = Units("mm", {"um": 1e-3, "mm": 1.0, "cm": 10.0, "m": 1000.0, "in": 25.4}, "120mm", least=1.0)
MILLISECONDS = Units("ms", {"ms": 1.0, "s": 1e3}, "16ms", least=0.05)
SECONDS = Units("s", {"ms": 1e-3, "s": 1.0, "min": 60.0, "h": 3600.0}, "90s")
MEGABYTES = Units("MB", {"kB": 1e-3, "MB": 1.0, "GB": 1e3, "MiB": 2**20 / 1e6, "GiB": 2**30 / 1e6}, "500MB")

_ANGLES = {"deg": 1.0, "°": 1.0, "rad": math.degrees(1.0)}


@dataclass(frozen=True)
class Degrees:
    """The type of an argument that is one angle, or `count` of them (0 for any number), in degrees or with a unit.

    `example` is what a message shows. Angles without a unit that are sure to be radians are questioned unless
    `is_small` says that some tenths of a degree are usual.
    """

    count: int = 1
    example: str = "50,30"
    is_small: bool = field(default=False, kw_only=True)

    def __call__(self, text: str) -> float | tuple[float, ...]:
        words = text.split(",")
        noun = f"angles such as {self.example}" if self.count != 1 else f"an angle such as {self.example}"
        if self.count and len(words) != self.count:
            raise argparse.ArgumentTypeError(f"{text[:_LONGEST]!r} is not {noun}")
        pairs = [split(word, noun) for word in words]
        for _, unit in pairs:
            if unit and unit not in _ANGLES:
                raise argparse.ArgumentTypeError(f"{text[:_LONGEST]!r} has the unit {unit!r}; deg, ° and rad are known")
        if self.count != 1 and not all(math.isfinite(value) for value, _ in pairs):
            raise argparse.ArgumentTypeError(f"{text[:_LONGEST]!r} is not finite")
        if not self.is_small and not any(unit for _, unit in pairs) and seem_radians([value for value, _ in pairs]):
            both = " or ".join(",".join(f"{word.strip()}{unit}" for word in words[:4]) for unit in ("rad", "deg"))
            raise argparse.ArgumentTypeError(f"{text[:_LONGEST]} seem to be radians; write {both}")
        angles = tuple(value * _ANGLES.get(unit, 1.0) for value, unit in pairs)
        return angles[0] if self.count == 1 else angles


def seem_radians(angles: list[float]) -> bool:
    """True for angles within 2π of which one has hundredths, or for three and more of which one is not whole."""
    if not max(map(abs, angles)) <= 2.0 * math.pi + 1e-3:
        return False
    fine = 10.0 if len(angles) < 3 else 1.0
    return any(abs(fine * angle - round(fine * angle)) > 1e-6 for angle in angles)


def share(text: str) -> float:
    """A share as a fraction, from `0.05` or `5%`; one above 1 is questioned unless it is in percent."""
    value, unit = split(text, "a share such as 0.05 or 5%")
    if unit not in ("", "%"):
        raise argparse.ArgumentTypeError(f"{text[:_LONGEST]!r} is not a share such as 0.05 or 5%")
    if not unit and 1.0 < value < math.inf:
        hundredths = f"{100.0 * value:.6g}"  # as it can be typed, without separators
        raise argparse.ArgumentTypeError(
            f"{text[:_LONGEST]} is {hundredths}%; write that if it is meant, or {text.strip()}%"
        )
    return value / 100.0 if unit else value


def size_bytes(text: str) -> int:
    """A number of bytes from `2GB` or `500 MB`; a number alone is questioned."""
    value, unit = split(text, "a size such as 2GB or 500MB")
    if unit not in MEGABYTES.factors or not 0.0 < value < 1e12:
        raise argparse.ArgumentTypeError(f"{text[:_LONGEST]!r} is not a size such as 2GB or 500MB")
    return round(value * MEGABYTES.factors[unit] * 1e6)


def split(text: str, noun: str) -> tuple[float, str]:
    """The number and the unit of a quantity; `noun` is what it should be, for the parser's error."""
    plain = text.strip()
    bare = plain.rstrip(_LETTERS)
    for number, unit in ((plain, ""), (bare.strip(), plain[len(bare) :])):
        with suppress(ValueError):
            return float(number), unit
    raise argparse.ArgumentTypeError(f"{text[:_LONGEST]!r} is not {noun}")
