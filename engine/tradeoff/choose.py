"""From a budget to a setting, both ways: the most exact within time and memory, or the quickest within an error."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from engine.tradeoff.point import Point

_UNITS = {
    "%": ("error", 0.01),
    "µs": ("time_s", 1e-6),
    "us": ("time_s", 1e-6),
    "ms": ("time_s", 1e-3),
    "s": ("time_s", 1.0),
    "b": ("bytes", 1.0),
    "kb": ("bytes", 1e3),
    "mb": ("bytes", 1e6),
    "gb": ("bytes", 1e9),
}

_PART = re.compile(r"([0-9]+(?:\.[0-9]*)?|\.[0-9]+)\s*(%|[a-zµ]+)", re.IGNORECASE)


@dataclass(frozen=True)
class Budget:
    """At most so much of each; None is any. ValueError for numbers that are not above 0.

    Attributes
    ----------
    error : relative RMSE, its uncertainty included.
    time_s : of a frame, or of whatever cost is looked at.
    bytes : of memory.
    """

    error: float | None = None
    time_s: float | None = None
    bytes: float | None = None

    def __post_init__(self) -> None:
        for name in ("error", "time_s", "bytes"):
            value = getattr(self, name)
            if value is not None and not 0.0 < value < float("inf"):
                raise ValueError(f"a budget of {name} = {value!r} is not above 0")

    def allows(self, point: Point, axis: str = "frame") -> bool:
        """Whether a setting keeps within all of it."""
        limits = (
            (self.error, point.error_rmse_rel + point.error_uncertainty),
            (self.time_s, point.cost("frame" if axis == "memory" else axis)),
            (self.bytes, point.cost("memory")),
        )
        return all(limit is None or value <= limit for limit, value in limits)


@dataclass(frozen=True)
class Choice:
    """The best setting within a budget, or None and in words why there is none."""

    point: Point | None
    reason: str


def budget_from_text(text: str) -> Budget:
    """'8 ms and 100 MB', '1 %', '2 % 50 MB'; ValueError for anything else."""
    found: dict[str, float] = {}
    for number, unit in _PART.findall(text):
        name, factor = _UNITS.get(unit.lower(), ("", 0.0))
        if not name or name in found:
            raise ValueError(f"{text!r} is not a budget such as '8 ms and 100 MB' or '1 %'")
        found[name] = float(number) * factor
    rest = re.sub(r"\band\b|[\s,;&+|]", "", _PART.sub("", text), flags=re.IGNORECASE)
    if not found or rest:
        raise ValueError(f"{text!r} is not a budget such as '8 ms and 100 MB' or '1 %'")
    return Budget(**found)


def choose(points: Sequence[Point], budget: Budget, axis: str = "frame") -> Choice:
    """The best of `points` within `budget`; time is that of `axis` (of a frame where that is memory).

    Where an error is given, the cheapest on `axis` of those that keep it, else the one with the least error. Of equals
    the other figure decides, then memory, then the order of `points`.
    """
    allowed = [point for point in points if budget.allows(point, axis)]
    if not allowed:
        return Choice(None, _why_none(points, budget, axis))

    def rank(point: Point) -> tuple[float, float, float]:
        error, cost = point.error_rmse_rel, point.cost(axis)
        return (*((cost, error) if budget.error is not None else (error, cost)), point.cost("memory"))

    return Choice(min(allowed, key=rank), f"{len(allowed)} of {len(points)} settings keep within it")


def _why_none(points: Sequence[Point], budget: Budget, axis: str) -> str:
    """What comes nearest, one limit at a time."""
    if not points:
        return "Nothing has been measured yet"
    timed = "frame" if axis == "memory" else axis
    best = {
        "error": (budget.error, f"the least error is {_share(min(point.error_rmse_rel for point in points))}"),
        "time": (budget.time_s, f"the quickest takes {1e3 * min(point.cost(timed) for point in points):.3g} ms"),
        "bytes": (budget.bytes, f"the smallest takes {min(point.memory_bytes for point in points) / 1e6:.3g} MB"),
    }
    told = [words for limit, words in best.values() if limit is not None]
    return f"No measured setting keeps within it: {', '.join(told)}"


def _share(value: float) -> str:
    return f"{100.0 * value:.2g} %"
