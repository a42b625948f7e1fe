"""Plots of measured points, without a measurement."""

from __future__ import annotations

from typing import Any

import pytest

from engine.planning.costs.setting import Setting
from engine.tradeoff import write
from engine.tradeoff.sweep import Tradeoff
from tests.engine.tradeoff.points import point


def test_a_plot_shows_each_point_in_its_units(monkeypatch: pytest.MonkeyPatch) -> None:
    """Errors in per cent, times of frames in milliseconds; points without the cost are left to the note."""
    shown: list[Any] = []
    monkeypatch.setattr(write, "scatter_front", lambda dots, *words, **more: shown.append((dots, words, more)))
    settings = [Setting("direct", {"directions": count}) for count in (1, 4)]
    points = tuple(
        point(error, frame_s, setting=setting, error_uncertainty=0.01)
        for error, frame_s, setting in zip((0.25, 0.125), (0.002, 0.03), settings, strict=True)
    )
    found = Tradeoff((*points, point(0.5, 0.0)), (), 0.0, 16, "a card", (8, 8), 1.0)
    write.plot_of(found, "frame", current=settings[1])
    ((dots, words, more),) = shown
    assert [(dot.x, dot.y, dot.spread, dot.front, dot.current) for dot in dots] == [
        (2.0, 25.0, 1.0, True, False),
        (30.0, 12.5, 1.0, True, True),
    ]
    assert words == ("Time of a frame / ms", "Error, relative RMSE / %")
    assert "1 settings have no such cost" in more["note"]
    assert write.plot_of(Tradeoff((), (), 0.0, 16, "a card", (8, 8), 1.0), "frame") is None
