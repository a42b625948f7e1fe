"""A law of one part of the program: what must hold of any case that can be drawn, and how cases are drawn."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from hypothesis import strategies as st

from engine.selftest.case import Found

#: A case as it stands in a file: numbers and texts by name. No number is a size, so that no file asks for much memory.
Values = dict[str, Any]

#: A share of a range, and a seed of numpy's generators.
SHARE = st.floats(0.0, 1.0)
SEED = st.integers(0, 2**32 - 1)


@dataclass(frozen=True)
class Law:
    """`ask` works out a figure for a case, and the most that it may be; `cases` draws cases."""

    id: str
    text: str
    cases: st.SearchStrategy[Values]
    ask: Callable[[Values], Found]


def draw(**values: st.SearchStrategy[Any]) -> st.SearchStrategy[Values]:
    """Cases of values by name."""
    return st.fixed_dictionaries(values)


def many(of: st.SearchStrategy[Any], least: int = 1, most: int = 12) -> st.SearchStrategy[list[Any]]:
    return st.lists(of, min_size=least, max_size=most)


def decades(low: int, high: int) -> st.SearchStrategy[float]:
    """Numbers of any size from 10^low to 10^high."""
    return st.floats(low, high).map(lambda power: float(10.0**power))
