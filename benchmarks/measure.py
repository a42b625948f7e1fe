"""The figures that a benchmark reports: a speed beside the limit that bounds it in the same run, or an error.

asv follows one figure over commits; these rows compare a figure with its limit on this machine, in the same run.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from engine.core.stopwatch import shortest


@dataclass(frozen=True)
class Measure:
    """`time_s` of something, `limit_s` of what bounds it or of what it is compared with, and in words what `limit` is.

    `more` are further figures, with the unit in each key.
    """

    name: str
    time_s: float
    limit_s: float
    limit: str
    more: Mapping[str, Any] = field(default_factory=dict)

    @property
    def ratio(self) -> float:
        return self.time_s / self.limit_s


@dataclass(frozen=True)
class Accuracy:
    """An error called `name`, of what it is in words, and the largest that is promised; None where none is.

    `more` are further figures.
    """

    name: str
    error: float
    what: str
    bound: float | None = None
    more: Mapping[str, Any] = field(default_factory=dict)


def best_of(work: Callable[[], object], repeats: int = 7) -> float:
    """The shortest of `repeats` runs in seconds; one more run warms up."""
    return shortest(work, repeats)
