"""Figures of messages: what is read is the figure, for every size of it."""

from __future__ import annotations

import ast
import itertools
import math
import re
from pathlib import Path

import numpy as np
import pytest

from engine.core.figure_text import number, percent, percent_range, percent_within, shorten, size_text, time_text

#: Every size that a share may have, and values next to whole powers of ten, where rounding carries.
SHARES = np.concatenate([10.0 ** np.linspace(-9.0, 9.0, 2_001), *(10.0 ** np.arange(-9, 10) * f for f in (0.99, 1.01))])


def read(text: str) -> float:
    return float(text.removesuffix(" %").replace(",", ""))


@pytest.mark.parametrize("digits", [2, 3])
def test_what_is_read_is_the_figure_to_its_digits(digits: int) -> None:
    for share in [*SHARES, *-SHARES]:
        assert read(percent(share, digits)) == pytest.approx(100.0 * share, rel=0.5 * 10.0 ** (1 - digits) * 1.001)
        assert read(number(share, digits)) == pytest.approx(share, rel=0.5 * 10.0 ** (1 - digits) * 1.001)


def test_a_larger_share_is_never_read_as_a_smaller_one() -> None:
    found = [read(percent(share)) for share in np.sort(SHARES)]
    assert all(one <= other for one, other in itertools.pairwise(found))


def test_only_all_is_read_as_all() -> None:
    for missing in 10.0 ** np.linspace(-5.99, -2.0, 400):
        assert read(percent(1.0 - missing)) < 100.0
    assert percent(0.996) == "99.6 %"
    assert percent(0.9996) == "99.96 %"


@pytest.mark.parametrize(
    ("share", "text"),
    [
        (0.0, "0 %"),
        (1e-9, "1e-7 %"),
        (0.00012, "0.012 %"),
        (0.0096, "0.96 %"),
        (0.5, "50 %"),
        (0.528, "53 %"),
        (0.994, "99.4 %"),
        (1.0, "100 %"),
        (1.16, "116 %"),
        (4.32, "432 %"),
        (10.71, "1,071 %"),
        (-0.25, "-25 %"),
        (1e9, "1e11 %"),
        (math.nan, "not known"),
        (math.inf, "infinite"),
    ],
)
def test_per_cents_that_users_meet(share: float, text: str) -> None:
    assert percent(share) == text


@pytest.mark.parametrize(
    ("share", "uncertainty", "text"),
    [(0.123, 0.004, "12.3 ± 0.4 %"), (10.71, 0.2, "1,071 ± 20 %"), (0.02, 0.0, "2 %"), (0.3, 1e-7, "30.00 ± 0.01 %")],
)
def test_an_uncertainty_decides_the_digits(share: float, uncertainty: float, text: str) -> None:
    assert percent_within(share, uncertainty) == text


def test_numbers_in_a_text_are_shortened() -> None:
    text = "ggx:kd=0.00075080760/4.8273533898e-20/0,alpha=0.0772745622714911,f0=1.0"
    assert shorten(text) == "ggx:kd=0.00075081/4.8274e-20/0,alpha=0.077275,f0=1"


def test_a_range_of_per_cents() -> None:
    assert percent_range(0.0062, 0.019) == "0.62 to 1.9 %"
    assert percent_range(0.0, 1.2) == "up to 120 %"


@pytest.mark.parametrize(
    ("size_bytes", "text"),
    [(0, "0 B"), (192, "192 B"), (999.9, "1 kB"), (3_140_000, "3.14 MB"), (84e6, "84 MB"), (999_999_999, "1 GB")],
)
def test_sizes(size_bytes: float, text: str) -> None:
    assert size_text(size_bytes) == text


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(0.0, "0 µs"), (0.0082, "8.2 ms"), (0.9999, "1 s"), (99.0, "99 s"), (240.0, "4 min"), (26309.0, "7.3 h")],
)
def test_times(seconds: float, text: str) -> None:
    assert time_text(seconds) == text


#: The formatter itself, and progress and the zoom of an image, which are counted in whole per cents.
COUNTED = {"engine/core/figure_text.py", "app/command_line.py", "app/factor/inspector.py", "app/capture/tab.py"}


#: A figure of a formatted string before the sign, also where a line ends between them; other modules have none.
SHARE = re.compile(r"\}(?: ?%|[\"']\s*f?[\"'] ?%)")


def test_no_message_rounds_a_share_by_itself() -> None:
    """'{100 * share:.0f} %' reads as none or all of what is a little more or less."""
    root = Path(__file__).parents[3]
    for path in (*(root / "engine").rglob("*.py"), *(root / "app").rglob("*.py")):
        if str(path.relative_to(root)) in COUNTED:
            continue
        source = path.read_text("utf-8")
        nodes = ast.walk(ast.parse(source)) if SHARE.search(source) else ()
        for text in (each for each in nodes if isinstance(each, ast.JoinedStr)):
            for figure, behind in itertools.pairwise(text.values):
                own = isinstance(figure, ast.FormattedValue) and figure.format_spec is not None
                share = isinstance(behind, ast.Constant) and str(behind.value).startswith((" %", "%"))
                assert not (own and share), f"{path}:{text.lineno}"
