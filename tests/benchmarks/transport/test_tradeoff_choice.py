"""The choices of sweeps are compared with the cheapest setting of no larger error."""

from __future__ import annotations

import pytest

from benchmarks.transport.tradeoff_choice import compare_choice
from engine.accuracy.compare import ErrorEstimate
from engine.planning.costs.setting import Setting

LOW, MIDDLE, HIGH = (Setting("sh", {"order": order}) for order in (3, 5, 8))


def test_a_choice_is_beside_the_cheapest_that_is_not_further_off() -> None:
    exact = {LOW: ErrorEstimate(0.2, 0.0), MIDDLE: ErrorEstimate(0.1, 0.0), HIGH: ErrorEstimate(0.09, 0.02)}
    prices = {LOW: 1.0, MIDDLE: 4.0, HIGH: 2.0}
    found = compare_choice(0, 0.1, MIDDLE, exact, prices)
    assert (found.best, found.ratio) == (MIDDLE, 1.0), "the third may be further off"
    exact[HIGH] = ErrorEstimate(0.09, 0.005)
    found = compare_choice(0, 0.1, MIDDLE, exact, prices)
    assert found.best == HIGH
    assert found.ratio == pytest.approx(2.0)
