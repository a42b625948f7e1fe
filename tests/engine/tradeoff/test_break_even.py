"""The break-even of a bake, against counting frames."""

from __future__ import annotations

import pytest

from engine.planning.costs.setting import Setting
from engine.tradeoff.front import break_even_frames, effort
from tests.engine.tradeoff.points import point

#: A reference whose error² · time is 0.0004 s: 2 % after a second.
REFERENCE = [
    point(0.02 * (64 / n) ** 0.5, n / 64, setting=Setting("reference", {"samples": n})) for n in (1, 4, 16, 64, 256)
]


def test_error_squared_times_time_is_one_number() -> None:
    assert effort(REFERENCE) == pytest.approx(0.0004)
    assert effort([point(0.1)]) is None
    assert effort([point(0.01, 1.0, setting=Setting("reference"), error_uncertainty=0.02)]) is None


@pytest.mark.parametrize(("error", "frame_s", "bake_s"), [(0.02, 0.01, 30.0), (0.01, 0.5, 2.0), (0.005, 0.02, 600.0)])
def test_it_is_the_first_frame_at_which_the_bake_has_taken_less(error: float, frame_s: float, bake_s: float) -> None:
    baked = point(error, frame_s, setting=Setting("sh"), bake_s=bake_s, relight_s=0.1)
    of_reference = 0.0004 / error**2
    counted = next(n for n in range(1, 100_000) if bake_s + 0.1 + n * frame_s <= n * of_reference)
    assert break_even_frames(baked, effort(REFERENCE)) == pytest.approx(counted, abs=1)


def test_it_is_never_where_the_reference_is_quicker_or_nothing_is_baked() -> None:
    assert break_even_frames(point(0.2, 0.02, setting=Setting("sh"), bake_s=1.0), effort(REFERENCE)) is None
    assert break_even_frames(point(0.01, 0.02), effort(REFERENCE)) is None
    assert break_even_frames(point(0.01, setting=Setting("wavelet"), bake_s=1.0), None) is None
