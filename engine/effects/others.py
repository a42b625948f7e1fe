"""How much of the processors other programs had while something was measured: times told then may be too long."""

from __future__ import annotations

import os
import time

import psutil

#: Share of the processors from which a measurement is disturbed.
DISTURBED = 0.1

#: Seconds of all processors that were used so far, by this process, and that have passed.
Spent = tuple[float, float, float]


def spent() -> Spent:
    """To be asked for before and after what is measured, for `others`."""
    whole, own = psutil.cpu_times(), psutil.Process().cpu_times()
    used = sum(getattr(whole, name, 0.0) for name in ("user", "nice", "system", "steal"))
    return used, own.user + own.system, time.perf_counter() * (os.cpu_count() or 1)


def others(before: Spent, after: Spent) -> float:
    """The share of the processors, 0 … 1, that other programs had in between; meaningless for less than 0.1 s."""
    used, own, passed = (late - early for early, late in zip(before, after, strict=True))
    return min(max(0.0, used - own) / max(passed, 1e-9), 1.0)
