"""The Pareto front: settings that no other one beats in error without costing more.

Both comparisons are of figures as measured. Of settings that are equal in both, all are on the front.

From a budget to a setting, both ways: the most exact within time and memory, or the quickest within an error.

After how many frames a bake has paid off against the progressive reference at equal error.

The error of the reference is its noise, which falls with the root of the samples, and its time grows with them:
error² · time is one number for a scene, found from images of a few numbers of samples. A frame as exact as a bake's
therefore takes the reference t = number / error², and the bake has paid off after bake_s / (t − frame_s) frames.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from engine.core.errors import UsageError
from engine.core.figure_text import percent_within, size_text, time_text
from engine.scene.mode import is_traced
from engine.tradeoff.point import Point
from engine.transport import method as transport

#: An error may rise by this share along a sweep and still counts as not rising (spec 05).
SLACK = 0.01


def front(points: Sequence[Point], axis: str = "frame") -> list[Point]:
    """The points on the front of error against the cost `axis` (`point.COSTS`), cheapest first. O(n log n)."""
    order = sorted(points, key=lambda point: (point.cost(axis), point.error_rmse_rel))
    kept: list[Point] = []
    for point in order:
        if not kept or point.error_rmse_rel < kept[-1].error_rmse_rel or _equal(point, kept[-1], axis):
            kept.append(point)
    return kept


def _equal(one: Point, other: Point, axis: str) -> bool:
    return one.error_rmse_rel == other.error_rmse_rel and one.cost(axis) == other.cost(axis)


def rises(points: Sequence[Point], slack: float = SLACK) -> list[tuple[Point, Point]]:
    """Neighbours on a sweep, from coarse to fine, whose error rises by more than `slack` and than is uncertain."""
    return [(low, high) for low, high in pairwise(points) if high.error_rmse_rel > _is_allowed(low, high, slack)]


def _is_allowed(low: Point, high: Point, slack: float) -> float:
    unsure = (low.error_uncertainty**2 + high.error_uncertainty**2) ** 0.5
    return low.error_rmse_rel * (1.0 + slack) + unsure


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

_PART = re.compile(
    r"([0-9]{1,20}+(?:\.[0-9]{0,20}+|,[0-9]{1,20}+)?|[.,][0-9]{1,20}+)\s{0,9}+(%|[a-zµ]{1,9}+)", re.IGNORECASE
)


@dataclass(frozen=True)
class Budget:
    """At most so much of each; None is any. UsageError for numbers that are not above 0.

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
                raise UsageError(f"a budget of {name} = {value!r} is not above 0")

    def allows(self, point: Point, axis: str = "frame") -> bool:
        """True if a setting keeps within all limits."""
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
    """'8 ms and 100 MB', '1 %', '0,5 %', '2 % 50 MB'; UsageError for anything else."""
    found: dict[str, float] = {}
    for number, unit in _PART.findall(text):
        name, factor = _UNITS.get(unit.lower(), ("", 0.0))
        if not name or name in found:
            raise UsageError(f"{text[:60]!r} is not a budget such as '8 ms and 100 MB' or '1 %'")
        found[name] = float(number.replace(",", ".")) * factor
    rest = re.sub(r"\band\b|[\s,;&+|]", "", _PART.sub("", text), flags=re.IGNORECASE)
    if not found or rest:
        raise UsageError(f"{text[:60]!r} is not a budget such as '8 ms and 100 MB' or '1 %'")
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
    """Nearest setting to each limit that no setting keeps, or a note that they are kept alone but not together."""
    if not points:
        return "Nothing has been measured yet"
    timed = "frame" if axis == "memory" else axis
    exact = min(points, key=lambda point: point.error_rmse_rel + point.error_uncertainty)
    limits = (
        (Budget(error=budget.error), f"the least error is {_error(exact)}"),
        (Budget(time_s=budget.time_s), f"the quickest takes {time_text(min(p.cost(timed) for p in points), 3)}"),
        (Budget(bytes=budget.bytes), f"the smallest takes {size_text(min(p.memory_bytes for p in points))}"),
    )
    unmet = [words for limit, words in limits if not any(limit.allows(point, axis) for point in points)]
    why = ", ".join(unmet) if unmet else "each limit can be kept alone, but not all of them together"
    return f"No measured setting keeps within it: {why}"


def _error(point: Point) -> str:
    return percent_within(point.error_rmse_rel, point.error_uncertainty)


def effort(points: Sequence[Point]) -> float | None:
    """error² · time in s of the reference, the median over its points; None where none is certain enough."""
    found = [
        point.error_rmse_rel**2 * point.frame_s
        for point in points
        if is_traced(point.mode) and point.error_rmse_rel > 2.0 * point.error_uncertainty
    ]
    return sorted(found)[len(found) // 2] if found else None


def break_even_frames(point: Point, reference_effort: float | None) -> int | None:
    """Frames from which on `point` has taken less time than the reference at its error.

    None where the mode bakes nothing, where the reference is quicker in each frame, and where its effort is not known.
    """
    if point.mode not in transport.names() or reference_effort is None:
        return None
    error = max(point.error_rmse_rel, point.error_uncertainty)
    if error <= 0.0:
        return None
    saved = reference_effort / error**2 - point.frame_s
    return max(1, math.ceil((point.bake_s + point.relight_s) / saved)) if saved > 0.0 else None
