"""Duration of a piece of work.

Background load: the share of the CPUs that other programs had while times were measured. Company: other
computations of this program that ran at the same time.
"""

from __future__ import annotations

import math
import os
import threading
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


#: Share of the CPUs from which a measurement is disturbed.
DISTURBED = 0.1

#: Seconds of all CPUs that were used so far, by this process, and that have passed.
Spent = tuple[float, float, float]


def read_clock() -> Spent:
    """To be asked for before and after what is measured, for `background_load`.

    What children of the process use is its own: files are decoded and texts of reflectance are evaluated there.
    """
    whole, process = psutil.cpu_times(), psutil.Process()
    used = sum(getattr(whole, name, 0.0) for name in ("user", "nice", "system", "steal"))
    own = _use(process) + sum(_use(child) for child in process.children(recursive=True))
    return used, own, time.perf_counter() * (os.cpu_count() or 1)


def _use(process: psutil.Process) -> float:
    """Seconds that a process has used, with its children that have ended; none of one that has just ended."""
    try:
        times = process.cpu_times()
    except psutil.Error:
        return 0.0
    names = ("user", "system", "children_user", "children_system")
    return float(sum(getattr(times, name, 0.0) for name in names))


def background_load(before: Spent, after: Spent) -> float:
    """The share of the CPUs, 0 … 1, that other programs had in between; meaningless for less than 0.1 s."""
    used, own, passed = (late - early for early, late in zip(before, after, strict=True))
    return min(max(0.0, used - own) / max(passed, 1e-9), 1.0)


_on_this_thread = threading.local()


def notice_company(company: threading.Event) -> None:
    """Let `had_company` on this thread tell whether `company` is set, by whoever starts other computations."""
    _on_this_thread.company = company


def had_company() -> bool:
    """True if the work on this thread shared the CPUs with another computation of this program.

    Times that were measured meanwhile teach nothing about the machine.
    """
    company: threading.Event | None = getattr(_on_this_thread, "company", None)
    return company is not None and company.is_set()


#: Seconds in which the load of others can be told, and for which runs go on beside them: of the frames that two threads
#: draw on two CPUs, one in forty finds both free while another program keeps one of them busy.
WINDOW_S, PATIENCE_S = 0.4, 2.0


def time_undisturbed(work: Callable[[], object]) -> tuple[float, float]:
    """The shortest run of `work` in seconds, and the background load meanwhile.

    Runs end after `WINDOW_S` without other programs, and after `PATIENCE_S` beside them. Work that threads share takes
    as long as on fewer CPUs while others have theirs: a frame of 2.7 ms by OpenGL on two CPUs took 4.6 ms,
    for minutes on end, and as many seconds of the CPUs.
    """
    work()
    best, started = math.inf, time.perf_counter()
    window_began, in_window = started, read_clock()
    while True:
        began = time.perf_counter()
        work()
        now = time.perf_counter()
        best = min(best, now - began)
        if now - window_began < WINDOW_S:
            continue
        after = read_clock()
        load = background_load(in_window, after)
        if load <= DISTURBED or now - started >= PATIENCE_S:
            return best, load
        window_began, in_window = now, after
