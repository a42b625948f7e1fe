"""Long work is a generator: it yields a `Step` about every 50 ms and returns its result.

A yield is progress and perhaps a partial result. Closing the generator cancels it (its `finally` blocks remove what
is half-written); not asking for the next step pauses it. The engine knows no callback, token or thread.
"""

from __future__ import annotations

from collections.abc import Callable, Generator
from dataclasses import dataclass
from typing import Any, TypeVar

Result = TypeVar("Result")


@dataclass(frozen=True, eq=False)
class Step:
    """Progress of long work: `done` in [0, 1], `note` in a few words, `partial` a result so far where one exists."""

    done: float
    note: str
    partial: Any = None


Steps = Generator[Step, None, Result]


def drain(steps: Steps[Result], show: Callable[[Step], None] | None = None) -> Result:
    """Run `steps` to the end, hand each step to `show`, and return the result."""
    while True:
        try:
            step = next(steps)
        except StopIteration as finished:
            return finished.value
        if show is not None:
            show(step)


def time_left(seconds: float) -> str:
    """`12 s left` or `3 min left`, for notes."""
    return f"{seconds:.0f} s left" if seconds < 120.0 else f"{seconds / 60.0:.0f} min left"


def relay(steps: Steps[Result], change: Callable[[Step], Step]) -> Steps[Result]:
    """Run `steps`, each step as `change` makes it: `result = yield from relayed(steps, …)`."""
    try:
        while True:
            try:
                step = next(steps)
            except StopIteration as finished:
                return finished.value
            yield change(step)
    finally:
        steps.close()


def part(steps: Steps[Result], start: float, stop: float) -> Steps[Result]:
    """Run `steps` as the part [start, stop] of a longer work: `result = yield from part(steps, 0.2, 0.5)`."""
    return relay(steps, lambda step: Step(start + (stop - start) * step.done, step.note, step.partial))


def without_partials(steps: Steps[Result]) -> Steps[Result]:
    """Run `steps` without their partial results, where the longer work has others: those of a fit are BRDFs."""
    return relay(steps, lambda step: Step(step.done, step.note))
