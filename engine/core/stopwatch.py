"""Duration of a piece of work.

Background load: the share of the processors that other programs had while times were measured.
"""

from __future__ import annotations

import math
import os
import time
from collections.abc import Callable

import psutil


def shortest(work: Callable[[], object], runs: int = 2, enough_s: float = math.inf) -> float:
    """The shortest of so many runs in seconds, which other programs disturb least; one more run warms up.

    No further run begins after `enough_s`.
    """
    work()
    times: list[float] = []
    while not times or (len(times) < runs and sum(times) < enough_s):
        started = time.perf_counter()
        work()
        times.append(time.perf_counter() - started)
    return min(times)


#: Share of the processors from which a measurement is disturbed.
DISTURBED = 0.1

#: Seconds of all processors that were used so far, by this process, and that have passed.
Spent = tuple[float, float, float]


def spent() -> Spent:
    """To be asked for before and after what is measured, for `background_load`."""
    whole, own = psutil.cpu_times(), psutil.Process().cpu_times()
    used = sum(getattr(whole, name, 0.0) for name in ("user", "nice", "system", "steal"))
    return used, own.user + own.system, time.perf_counter() * (os.cpu_count() or 1)


def background_load(before: Spent, after: Spent) -> float:
    """The share of the processors, 0 … 1, that other programs had in between; meaningless for less than 0.1 s."""
    used, own, passed = (late - early for early, late in zip(before, after, strict=True))
    return min(max(0.0, used - own) / max(passed, 1e-9), 1.0)
