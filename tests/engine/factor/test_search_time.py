"""The time of a search is its own: what passes between two steps, as while it is paused, does not count."""

from __future__ import annotations

import time
from dataclasses import replace

import pytest

from engine.factor.projection_search import search
from engine.factor.textures import SearchSettings
from tests.engine.factor.factored import blue_paint

SMALL = replace(SearchSettings(), terms=2, size=6, low_size=0, restarts=0, low_samples=100)

#: Seconds that each step waits for the next one, and that one look at the clock takes.
PAUSE_S, LOOK_S = 1000.0, 0.02


def test_pauses_do_not_count(monkeypatch: pytest.MonkeyPatch) -> None:
    now = 0.0

    def clock() -> float:
        nonlocal now
        now += LOOK_S
        return now

    monkeypatch.setattr(time, "perf_counter", clock)
    steps, taken = search(blue_paint(100), SMALL), 0
    while True:
        try:
            next(steps)
        except StopIteration as finished:
            found = finished.value
            break
        taken += 1
        now += PAUSE_S
    assert taken > 2
    assert 0.0 < found.term_errors[0].time_s <= found.term_errors[-1].time_s < PAUSE_S
