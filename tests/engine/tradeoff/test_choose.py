"""Choosing within a budget, against trying everything."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.tradeoff.front import Budget, budget_from_text, choose
from engine.tradeoff.point import Point
from tests.engine.tradeoff.points import POINTS, point

LIMITS = st.none() | st.sampled_from([0.005, 0.01, 0.02, 0.05, 0.1, 1.0, 1000.0, 1e5])
AXES = st.sampled_from(["frame", "relight", "bake"])


@given(POINTS, LIMITS, LIMITS, LIMITS, AXES)
def test_nothing_within_the_budget_is_better(
    points: list[Point], error: float | None, time_s: float | None, memory: float | None, axis: str
) -> None:
    budget = Budget(error, time_s, memory)
    inside = [
        each
        for each in points
        if (error is None or each.error_rmse_rel + each.error_uncertainty <= error)
        and (time_s is None or getattr(each, f"{axis}_s") <= time_s)
        and (memory is None or each.memory_bytes <= memory)
    ]
    found = choose(points, budget, axis)
    assert (found.point is None) == (not inside)
    assert found.reason
    if found.point is not None:
        assert found.point in inside
        if error is not None:
            assert found.point.cost(axis) == min(each.cost(axis) for each in inside)
        else:
            assert found.point.error_rmse_rel == min(each.error_rmse_rel for each in inside)


@pytest.mark.parametrize(
    ("text", "budget"),
    [
        ("8 ms and 100 MB", Budget(time_s=0.008, bytes=1e8)),
        ("1 %", Budget(error=0.01)),
        ("1%", Budget(error=0.01)),
        ("2 s, 0.5 GB, 3 %", Budget(error=0.03, time_s=2.0, bytes=5e8)),
        ("200 µs", Budget(time_s=2e-4)),
    ],
)
def test_budgets_are_read(text: str, budget: Budget) -> None:
    found = budget_from_text(text)
    assert (found.error, found.time_s, found.bytes) == pytest.approx((budget.error, budget.time_s, budget.bytes))


@pytest.mark.parametrize("text", ["", "8", "8 m", "1 % 2 %", "fast", "0 ms", "-1 %", "1 % please", "1e400 s"])
def test_what_is_no_budget_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match="budget"):
        budget_from_text(text)


def test_it_says_when_none_does_and_what_comes_nearest() -> None:
    points = [point(0.05, 0.01, 192), point(0.02, 0.1, 5_000_000)]
    assert choose(points, Budget(error=0.01)).reason.endswith("the least error is 2 %")
    assert choose(points, Budget(time_s=0.001)).reason.endswith("the quickest takes 10 ms")
    assert choose(points, Budget(bytes=10)).reason.endswith("the smallest takes 192 B")
    assert choose(points[1:], Budget(bytes=10)).reason.endswith("the smallest takes 5 MB")
    assert "measured yet" in choose([], Budget(error=0.1)).reason


def test_it_names_only_limits_that_none_keeps() -> None:
    points = [point(0.05, 0.01, 1000), point(0.02, 0.1, 5000)]
    tight = choose(points, Budget(time_s=0.001, bytes=2000)).reason
    assert "quickest" in tight
    assert "smallest" not in tight
    assert "not all of them together" in choose(points, Budget(error=0.03, time_s=0.05)).reason
    unsure = point(0.0095, error_uncertainty=0.001)
    assert choose([unsure], Budget(error=0.01)).reason.endswith("the least error is 0.95 ± 0.10 %")
