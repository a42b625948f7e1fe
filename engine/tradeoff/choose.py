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

_PART = re.compile(r"([0-9]{1,20}+(?:\.[0-9]{0,20}+)?|\.[0-9]{1,20}+)\s{0,9}+(%|[a-zµ]{1,9}+)", re.IGNORECASE)


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
            raise ValueError(f"{text[:60]!r} is not a budget such as '8 ms and 100 MB' or '1 %'")
        found[name] = float(number) * factor
    rest = re.sub(r"\band\b|[\s,;&+|]", "", _PART.sub("", text), flags=re.IGNORECASE)
    if not found or rest:
        raise ValueError(f"{text[:60]!r} is not a budget such as '8 ms and 100 MB' or '1 %'")
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
    """What comes nearest to each limit that no setting keeps, or that they are kept alone but not together."""
    if not points:
        return "Nothing has been measured yet"
    timed = "frame" if axis == "memory" else axis
    exact = min(points, key=lambda point: point.error_rmse_rel + point.error_uncertainty)
    limits = (
        (Budget(error=budget.error), f"the least error is {_error(exact)}"),
        (Budget(time_s=budget.time_s), f"the quickest takes {_amount(min(p.cost(timed) for p in points), _SECONDS)}"),
        (Budget(bytes=budget.bytes), f"the smallest takes {_amount(min(p.memory_bytes for p in points), _BYTES)}"),
    )
    told = [words for limit, words in limits if not any(limit.allows(point, axis) for point in points)]
    why = ", ".join(told) if told else "each limit can be kept alone, but not all of them together"
    return f"No measured setting keeps within it: {why}"


def _error(point: Point) -> str:
    share, unsure = 100.0 * point.error_rmse_rel, 100.0 * point.error_uncertainty
    return f"{share:.2g} ± {unsure:.1g} %" if unsure > 0.0 else f"{share:.2g} %"


_SECONDS = (("µs", 1e-6), ("ms", 1e-3), ("s", 1.0))
_BYTES = (("B", 1.0), ("kB", 1e3), ("MB", 1e6), ("GB", 1e9))


def _amount(value: float, units: Sequence[tuple[str, float]]) -> str:
    """'192 B', '3.1 MB', '12 ms': in the largest unit of which there is at least one."""
    name, unit = next((each for each in reversed(units) if value >= each[1]), units[0])
    return f"{value / unit:.3g} {name}"
