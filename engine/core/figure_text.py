"""Figures as users read them: the one place where a number becomes part of a message.

A figure has a few significant digits, never loses one before the point, has no zeros at its end that say nothing, and
commas between thousands from 1,000 on. Below 1e-4 and from 1e9 on it has an exponent.

The window writes figures as its user's language does, with a true minus sign (`write_with`); the command line always
with a point, and with a minus sign that can be typed.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from functools import cache

_SIZES = (("B", 1.0), ("kB", 1e3), ("MB", 1e6), ("GB", 1e9), ("TB", 1e12))
_TIMES = (("µs", 1e-6), ("ms", 1e-3), ("s", 1.0), ("min", 60.0), ("h", 3600.0))

#: Minutes and hours are taken from this many of them on: 90 s are read more easily than 1.5 min.
_ENOUGH = 2.0

#: The letters for the decimal point, the comma between thousands, and the sign of a negative figure.
_marks = {".": ".", ",": ",", "-": "-"}


def write_with(point: str, minus: str = "-") -> None:
    """Write figures with `point` before their decimals from now on: '.' or ','; a comma parts thousands by a space.

    `minus` begins negative figures.
    """
    _marks.update({".": ".", ",": ","} if point == "." else {".": ",", ",": "\u202f"})
    _marks["-"] = minus


def local(figure: str) -> str:
    """`figure`, which has a decimal point and commas between thousands, in the form of the chosen language."""
    size = figure.removeprefix("-")
    sign = _marks["-"] if size != figure else ""
    return sign + "".join(_marks[letter] if letter in ".," else letter for letter in size)


def read_figure(figure: str) -> float:
    """Return the value of `figure` as it was written in the form of the chosen language; a point is read in each."""
    meanings = {_marks[","]: "", _marks["."]: "."}
    return float("".join(meanings.get(letter, letter) for letter in figure))


def figure_pattern() -> re.Pattern[str]:
    """Return a pattern of the figures in a text, in the form of the chosen language; none is in a name."""
    return _pattern_of_figures(re.escape(_marks[","]), re.escape(_marks["."]))


@cache
def _pattern_of_figures(group: str, point: str) -> re.Pattern[str]:
    whole = rf"(?:\d{{1,3}}(?:{group}\d{{3}}){{1,7}}|\d{{1,20}})"
    return re.compile(rf"(?<![\w.,\-/]){whole}(?:[.{point}]\d{{1,20}})?(?![.,]?[\w/])")


def format_fixed(value: float, places: int) -> str:
    """`value` with so many decimals, which columns and readings that change keep: '12.0', and 0 without a sign."""
    figure = f"{value:.{places}f}"
    return local(figure if any(digit in figure for digit in "123456789") else figure.removeprefix("-"))


def number(value: float, digits: int = 2) -> str:
    """`value` with `digits` significant digits: '0.012', '1.2', '116', '1,071', '3e-7', '2.5e12'.

    'not known' and 'infinite' for what is not finite.
    """
    if not math.isfinite(value):
        return "not known" if math.isnan(value) else "infinite"
    size = abs(value)
    if size and not 1e-4 <= size < 1e9:
        mantissa, _, exponent = f"{value:.{digits - 1}e}".partition("e")
        return local(f"{_bare(mantissa)}e{int(exponent)}")
    rounded = float(f"{value:.{digits - 1}e}")
    places = digits - 1 - math.floor(math.log10(abs(rounded))) if rounded else 0
    return local(_bare(f"{rounded if places > 0 else value:,.{max(0, places)}f}"))


def count_text(count: float) -> str:
    """A whole number with all its digits: '7', '1,071', '1,234,567'."""
    return local(f"{count:,.0f}")


def percent(share: float, digits: int = 2) -> str:
    """`share` of 1 in per cent: '0.012 %', '12 %', '116 %', '1,071 %'.

    What is less than all by a millionth or more is never '100 %', but '99.9 %'.
    """
    if not math.isfinite(share):
        return number(share)
    missing = 1.0 - share
    if 1e-6 <= missing < 0.1:
        # Digits behind the point until the first one of what is missing.
        places = math.ceil(-math.log10(100.0 * missing)) if missing < 1e-2 else 0
        digits = max(digits, 2 + places)
    return f"{number(100.0 * share, digits)} %"


def percent_within(share: float, uncertainty: float) -> str:
    """'12.3 ± 0.4 %': to the first digit of the uncertainty, but two of the share; at most two behind the point.

    A share without uncertainty stands alone.
    """
    if not uncertainty > 0.0:
        return percent(share)
    value, off = 100.0 * share, max(100.0 * uncertainty, 0.01)
    certain = -math.floor(math.log10(off))
    two_digits = min(2, 1 - math.floor(math.log10(abs(value)))) if value else 0
    places = max(0, certain, two_digits)
    return local(f"{value:,.{places}f} ± {off:,.{places}f} %")


def percent_range(low: float, high: float) -> str:
    """'0.62 to 1.9 %', and 'up to 1.9 %' from 0."""
    return f"{percent(low).removesuffix(' %')} to {percent(high)}" if low > 0.0 else f"up to {percent(high)}"


def shorten(text: str, digits: int = 5) -> str:
    """`text` with so many digits of each number that has a point: 'alpha=0.0772745622714911' as 'alpha=0.077275'."""
    return re.sub(r"\d+\.\d+(?:e[-+]\d+)?", lambda found: f"{float(found[0]):.{digits}g}", text)


def size_text(size_bytes: float) -> str:
    """Bytes in decimal units: '192 B', '3.14 MB', '84 MB'."""
    return _in_units(size_bytes, _SIZES, 3)


def time_text(seconds: float, digits: int = 2) -> str:
    """A time: '820 µs', '8.2 ms', '12 s', '4 min', '7.3 h'."""
    return _in_units(seconds, _TIMES, digits)


def _in_units(value: float, units: Sequence[tuple[str, float]], digits: int) -> str:
    """`value` in the largest unit of which there is at least one, after rounding."""
    rounded = float(f"{value:.{digits - 1}e}")
    fitting = [unit for unit in units if rounded >= (_ENOUGH if unit[0] in ("min", "h") else 1.0) * unit[1]]
    name, scale = fitting[-1] if fitting else units[0]
    return f"{number(value / scale, digits)} {name}"


def _bare(text: str) -> str:
    """`text` without zeros at the end of its decimals, and 0 without a sign."""
    bare = text.rstrip("0").rstrip(".") if "." in text else text
    return "0" if bare == "-0" else bare
