"""Measures the rates that the program ships: `python -m benchmarks.transport.rates`.

The machine is taken for one of a single CPU, and every duration is that of the CPU seconds of the process: what other
programs do meanwhile counts for little. Frames are measured with OpenGL and without.
"""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable
from typing import Any
from unittest.mock import patch

#: Settings of libraries that make them work on one thread; they are read when a process begins.
ALONE = {"OMP_NUM_THREADS": "1", "NUMBA_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "LP_NUM_THREADS": "0"}

#: Significant digits that are kept.
DIGITS = 4


def main() -> None:
    """Measure and write them, in a process of one thread."""
    if any(os.environ.get(name) != value for name, value in ALONE.items()):
        os.execve(sys.executable, [sys.executable, "-m", "benchmarks.transport.rates"], {**os.environ, **ALONE})
    os.cpu_count = lambda: 1
    time.perf_counter = time.process_time
    _measure()


def _measure() -> None:
    from engine.core.steps import drain
    from engine.planning.costs import machine_profile
    from engine.planning.costs.cost_model import FRAMES, PARTS
    from engine.storage.atomic import write_json

    machine_profile.ROUNDS = 1
    model, _ = drain(machine_profile.calibrate())
    tables, kind = dict(model.tables), model.renderer.split()[0]
    of_frames = {"frame-pixel", *(f"{mode}-{part}" for mode in FRAMES for part in PARTS)}
    frames = {kind: {name: tables.pop(name) for name in of_frames}}
    frame_s = {kind: machine_profile.measure_frame()[1]}
    frames["processor"], frame_s["processor"] = _without_opengl(_measure_frames)
    probes = machine_profile.measure_probes()
    machine_profile.SHIPPED.parent.mkdir(exist_ok=True)
    write_json(
        machine_profile.SHIPPED,
        _round({"threads": 1, "probes": probes, "frame_s": frame_s, "frames": frames, "tables": tables}),
    )


def _measure_frames() -> tuple[dict[str, Any], float]:
    from engine.core.steps import drain
    from engine.planning.costs import frame_rates, machine_profile

    tables: dict[str, Any] = {}
    drain(frame_rates.frame_rates(tables))
    return tables, machine_profile.measure_frame()[1]


def _without_opengl(work: Callable[[], Any]) -> Any:
    """What `work` finds where frames are drawn on the CPU."""
    from engine.core.errors import MissingCapability
    from engine.planning.costs import frame_rates

    def refuse() -> Any:
        raise MissingCapability("there is no OpenGL", "frames on the CPU are measured")

    with patch.object(frame_rates, "create_context", refuse):
        return work()


def _round(record: Any) -> Any:
    """The same with numbers of some digits, in the order of their names."""
    if isinstance(record, dict):
        return {name: _round(record[name]) for name in sorted(record)}
    if isinstance(record, list | tuple):
        return [_round(each) for each in record]
    return float(f"{record:.{DIGITS}g}") if isinstance(record, float) else record


if __name__ == "__main__":
    main()
