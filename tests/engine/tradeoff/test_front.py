"""The Pareto front against its definition."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.tradeoff.front import front, rises
from engine.tradeoff.point import COSTS, Point
from tests.engine.tradeoff.points import POINTS, point


def beats(one: Point, other: Point, axis: str) -> bool:
    no_worse = one.error_rmse_rel <= other.error_rmse_rel and one.cost(axis) <= other.cost(axis)
    return no_worse and (one.error_rmse_rel, one.cost(axis)) != (other.error_rmse_rel, other.cost(axis))


@given(POINTS, st.sampled_from(sorted(COSTS)))
def test_the_front_is_what_nothing_beats(points: list[Point], axis: str) -> None:
    expected = [each for each in points if not any(beats(other, each, axis) for other in points)]
    found = front(points, axis)
    assert sorted(map(id, found)) == sorted(map(id, expected))
    assert [each.cost(axis) for each in found] == sorted(each.cost(axis) for each in expected)


@pytest.mark.parametrize("bad", [float("nan"), float("inf"), -1.0, None])
def test_figures_are_numbers_from_0(bad: float) -> None:
    with pytest.raises(ValueError, match="error_rmse_rel"):
        point(bad)


def test_an_error_may_rise_by_a_hundredth_and_by_what_is_uncertain() -> None:
    flat, little, much = point(0.1), point(0.1009), point(0.102)
    assert rises([flat, little, flat]) == []
    assert rises([flat, much]) == [(flat, much)]
    unsure = point(0.102, error_uncertainty=0.002)
    assert rises([flat, unsure]) == []
