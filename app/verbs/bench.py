"""`lightarc bench`: how fast each part is on this machine, beside what bounds it."""

from __future__ import annotations

import argparse
import importlib
import logging
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from engine.errors import MissingCapability
from engine.steps import Step

if TYPE_CHECKING:
    from engine.bench.measure import Measure

HELP = "Measure the speed of each part beside the limit that bounds it, in the same run."
EXAMPLE = "lightarc bench --only linearise power-law-fit"

#: Name of a measure and the function that takes it.
MEASURES = {
    "linearise": "engine.bench.shading:linearise",
    "power-law-fit": "engine.bench.shading:power_law_fit",
    "power-law-fit-copy": "engine.bench.shading:power_law_fit_copy",
    "gl-frame": "engine.bench.frame:gl_frame",
    "gl-frame-slices": "engine.bench.frame:gl_frame_slices",
    "window-start": "app.bench_program:window_start",
    "window-block": "app.bench_program:window_block",
    "import-large": "app.bench_program:import_large",
}
LARGE = "import-large"

log = logging.getLogger(__name__)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--only", nargs="+", choices=tuple(MEASURES), metavar="NAME", help=", ".join(MEASURES))
    parser.add_argument("--large", action="store_true", help="also import ten photographs of 24 megapixels (minutes)")


def run(arguments: argparse.Namespace, show: Callable[[Step], None]) -> dict[str, Any]:
    chosen = arguments.only or [name for name in MEASURES if arguments.large or name != LARGE]
    measures = []
    for index, name in enumerate(chosen):
        show(Step(index / len(chosen), f"measuring {name}"))
        try:
            measures.append(_record(_measure(name)))
        except MissingCapability as missing:
            if arguments.only:
                raise
            log.warning("%s was left out. %s", name, missing)
    return {"measures": measures}


def report(result: dict[str, Any]) -> str:
    lines = [f"{'':22}{'time':>12}{'limit':>12}{'ratio':>10}"]
    for measure in result["measures"]:
        times = "".join(f"{measure[key] * 1000:9.1f} ms" for key in ("time_s", "limit_s"))
        lines.append(f"{measure['name']:22}{times}{measure['ratio']:10.4g}   limit: {measure['limit']}")
    return "\n".join(lines)


def _measure(name: str) -> Measure:
    """Only what is asked for is loaded."""
    module, function = MEASURES[name].split(":")
    measure: Measure = getattr(importlib.import_module(module), function)()
    return measure


def _record(measure: Measure) -> dict[str, Any]:
    record = {key: getattr(measure, key) for key in ("name", "time_s", "limit_s", "limit", "ratio")}
    return {**record, **measure.more}
