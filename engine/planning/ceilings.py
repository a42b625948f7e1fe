"""Limits of a plan unless a user says otherwise: a quarter of free memory, ten minutes of bake, 100 ms a frame.

A setting beyond them is never chosen while there is another, however exact it is: nobody waits for it, or it leaves no
memory to other programs. Where it alone would meet a budget, the plan names it beside its choice.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

from engine.core.budget import free_bytes
from engine.core.errors import UsageError
from engine.planning.costs.cost_model import Cost

#: Share of free memory, seconds of a bake, and seconds of a frame where many are drawn.
MEMORY_SHARE, BAKE_S, FRAME_S = 0.25, 600.0, 0.1


@dataclass(frozen=True)
class Ceilings:
    """The most that a setting may take; UsageError for limits that are not above 0."""

    memory_bytes: float
    bake_s: float = BAKE_S
    frame_s: float = FRAME_S

    def __post_init__(self) -> None:
        for name in ("memory_bytes", "bake_s", "frame_s"):
            if not getattr(self, name) > 0.0:
                raise UsageError(f"a ceiling of {name} = {getattr(self, name)!r} is not above 0")

    def exceeded(self, cost: Cost) -> tuple[str, ...]:
        """The names of the limits that a cost is beyond."""
        values = {"memory_bytes": cost.memory_bytes, "bake_s": cost.bake_s, "frame_s": cost.frame_s}
        return tuple(name for name, value in values.items() if value > getattr(self, name))


#: Nothing is too much.
NONE = Ceilings(inf, inf, inf)


def usual(*, memory_bytes: float | None = None, bake_s: float | None = None, frame_s: float | None = None) -> Ceilings:
    """The ceilings of this machine as it is now, with those that a user gives in their place."""
    free = MEMORY_SHARE * free_bytes() if memory_bytes is None else memory_bytes
    return Ceilings(free, BAKE_S if bake_s is None else bake_s, FRAME_S if frame_s is None else frame_s)
