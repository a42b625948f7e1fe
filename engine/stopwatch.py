"""How long something takes."""

from __future__ import annotations

import math
import time
from collections.abc import Callable


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
