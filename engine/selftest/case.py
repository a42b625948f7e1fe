"""A hard case: what is asked, what came out on this machine, and what it may be at most."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

#: Result of a case: a figure, and its limit.
Found = tuple[float, float]


@dataclass(frozen=True)
class Question:
    """A case that has not been asked yet; `ask` works the figure out."""

    id: str
    text: str
    ask: Callable[[], Found]


@dataclass(frozen=True)
class Case:
    """One row: the `id` of the catalogue, what is measured, in words, the figure, and the most it may be.

    `problem` says why there is no figure, where something that the case needs fails; it does not pass then. `skipped`
    says what this machine lacks; such a row counts as passed, because the program does without.
    """

    id: str
    text: str
    measured: float
    bound: float
    problem: str = ""
    skipped: str = ""

    @property
    def passed(self) -> bool:
        return bool(self.skipped) or (not self.problem and math.isfinite(self.measured) and self.measured <= self.bound)

    @property
    def group(self) -> str:
        return group_of(self.id)


def group_of(name: str) -> str:
    """The letters of an id, which name its part of the catalogue."""
    return name.rstrip("0123456789")
