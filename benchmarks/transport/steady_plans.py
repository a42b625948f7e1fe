"""Plans of one scene beside busy programs: the same answer every time, the first of a fresh machine included."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from benchmarks.measure import Accuracy
from engine.core.steps import Step, Steps

#: Plans that are made, and programs that are busy meanwhile.
RUNS, BUSY = 10, 4

#: The plan of the manual.
WORDS = ("plan", "torus-knot", "--brdf", "ggx:alpha=0.3", "--env", "studio", "--error", "0.02", "--json")


@contextmanager
def busy_programs(count: int) -> Iterator[None]:
    """So many programs that do nothing but take the CPU."""
    programs = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(count)]
    try:
        yield
    finally:
        for each in programs:
            each.kill()
            each.wait()


def steady_plans(folder: Path) -> Steps[list[Accuracy]]:
    """The share of plans that differ from the first, and the seconds of the first, which measures the machine."""
    answers, seconds = [], []
    with busy_programs(BUSY):
        for number in range(RUNS):
            yield Step(number / RUNS, f"plan {number + 1} of {RUNS} beside {BUSY} busy programs")
            started = time.perf_counter()
            answers.append(_answer(folder))
            seconds.append(time.perf_counter() - started)
    differing = sum(each != answers[0] for each in answers)
    what = f"share of {RUNS} plans beside {BUSY} busy programs that differ from the first: {answers[0]}"
    times = f"seconds of the first plan of a fresh machine beside them, {max(seconds[1:]):.3g} at most of the others"
    return [Accuracy("steady-plans", differing / RUNS, what, 0.0), Accuracy("steady-plans-first", seconds[0], times)]


def _answer(folder: Path) -> str:
    """Setting, effects that are shown, and whether the budget is met; the machine profile is kept in `folder`."""
    environment = {**os.environ, "XDG_CACHE_HOME": str(folder)}
    run = subprocess.run(
        [sys.executable, "-m", "app", *WORDS], capture_output=True, check=True, text=True, env=environment
    )
    found: dict[str, Any] = json.loads(run.stdout)
    shown = [each["effect"] for each in found["effects"] if each["decision"] in ("needed", "included", "forced on")]
    return f"{found['mode']} {found['knobs']}, satisfied {found['satisfied']}, with {', '.join(shown)}"
