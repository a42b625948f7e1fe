"""Cases of a law that are many or slow: the ordinary suite tries some, and all run with `--long`."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import pytest


def few(cases: Iterable[Any], ordinary: Callable[[Any], bool]) -> list[Any]:
    """`cases` for `parametrize`, of which those that are not `ordinary` run with `--long` only."""
    return [case if ordinary(case) else pytest.param(case, marks=pytest.mark.long) for case in cases]
