"""The Pareto front: settings that no other one beats in error without costing more.

Both comparisons are of figures as measured. Of settings that are equal in both, all are on the front.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from engine.tradeoff.point import Point

#: An error may rise by this share along a ladder and still counts as not rising (spec 05).
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
    """Neighbours on a ladder, from coarse to fine, whose error rises by more than `slack` and than is uncertain."""
    return [(low, high) for low, high in pairwise(points) if high.error_rmse_rel > _allowed(low, high, slack)]


def _allowed(low: Point, high: Point, slack: float) -> float:
    unsure = (low.error_uncertainty**2 + high.error_uncertainty**2) ** 0.5
    return low.error_rmse_rel * (1.0 + slack) + unsure
