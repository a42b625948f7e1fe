"""Long work: progress by yielding, cancelling by closing."""

from __future__ import annotations

from typing import Any

from engine.core.steps import Step, Steps, drain, part


def count(to: Any, closed: Any = None) -> Steps[Any]:
    try:
        for i in range(to):
            yield Step(i / to, f"{i}")
        return to
    finally:
        if closed is not None:
            closed.append(True)


def test_drain_returns_the_result_and_shows_every_step() -> None:
    seen: list[Any] = []
    assert drain(count(4), seen.append) == 4
    assert [step.done for step in seen] == [0, 0.25, 0.5, 0.75]


def test_part_maps_progress_into_its_share() -> None:
    def whole() -> Steps[Any]:
        first = yield from part(count(2), 0.0, 0.5)
        second = yield from part(count(2), 0.5, 1.0)
        return first + second

    seen: list[Any] = []
    assert drain(whole(), seen.append) == 4
    assert [step.done for step in seen] == [0, 0.25, 0.5, 0.75]


def test_closing_the_whole_closes_the_part() -> None:
    closed: list[Any] = []

    def whole() -> Steps[Any]:
        yield from part(count(9, closed), 0.0, 1.0)

    steps = whole()
    next(steps)
    steps.close()
    assert closed == [True]
