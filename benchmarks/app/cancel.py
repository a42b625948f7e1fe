"""Seconds from SIGTERM to the end of every verb that needs no display, at moments that a seed decides.

Each verb runs on small or built-in inputs in a process of its own, once to its end (or for `LIFE_S`), so that every
moment of its life can be drawn, and then again and again with a signal. A process that ends before its moment counts
as one that was not asked. Exit code -15 is Python's own end, before the first line of this program has run.
"""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import threading
import time
from collections import Counter
from pathlib import Path

from benchmarks.measure import Accuracy
from engine.core.errors import MissingCapability
from engine.core.steps import Step, Steps
from engine.storage.atomic import make_folder

#: Signals for each verb, and the seconds from one to the end that are promised.
RUNS, BOUND_S = 8, 0.5

#: Most of a verb's life that moments are drawn from where nobody needs its result, and seconds after which it hangs.
LIFE_S, HANGS_S = 8.0, 600.0

#: Commands that make the inputs, in this order; they are measured like the others.
MAKING = {
    "simulate": "simulate -o {output} --sample plain --size 96 --elevations-deg 20,50,80",
    "import": "import {inputs}/simulate -o {output}",
    "shade": "shade {inputs}/import -o {output} --slices 4",
    "render": "render sphere --width 64 --height 48 -o {output}.png",
    "bake": "bake sphere --brdf ggx:alpha=0.3 --mode sh --order 5 -o {output}.transport",
}
MEASURED = {
    **MAKING,
    "demo": "demo -o {output}",
    "render-reference": "render sphere --brdf ggx --mode reference --samples 4000 -o {output}.png",
    "render-transport": "render {inputs}/bake.transport --env sky -o {output}.png",
    "compare": "compare {inputs}/render.png {inputs}/render.png --difference {output}.png",
    "brdf-info": "brdf info ggx",
    "brdf-eval": "brdf eval ggx --wi-deg 10,20 --wo-deg 30,40",
    "brdf-fit": "brdf fit ggx:alpha=0.3 --model cook-torrance",
    "brdf-convert": "brdf convert ggx -o {output}.binary",
    "factor": "factor ggx:alpha=0.2 -o {output}",
    "factor-search": "factor ggx:alpha=0.2 --method search -o {output}",
    "bake-wavelet": "bake sphere --brdf ggx:alpha=0.3 -o {output}.transport",
    "bake-gaussian": "bake sphere --brdf ggx:alpha=0.3 --mode gaussian -o {output}.transport",
    "plan": "plan sphere --brdf ggx:alpha=0.3 --env sky",
    "figures": "figures kautz-6 --quick -o {output}",
    "tradeoff": "tradeoff sphere --brdf ggx --env sky -o {output}",
    "bundle": "bundle verify {inputs}/shade",
    "export": "export {inputs}/shade --to textures gltf -o {output}",
    "batch": "batch {inputs}/simulate -o {output} --to none",
    "normals": "normals {inputs}/import -o {output}",
    "selftest": "selftest",
    "bench": "bench --only brdf-ggx separable-48 reference-direct",
}


def cancel(folder: Path, *, runs: int = RUNS, seed: int = 1, lines: dict[str, str] = MEASURED) -> Steps[list[Accuracy]]:
    """The longest time from a signal to the end by verb, of `runs` signals each, and the exit codes.

    MissingCapability on Windows, which has no such signals.
    """
    if sys.platform == "win32":
        raise MissingCapability("Windows has no signals that ask a program to end", "Measure on another system")
    draw = random.Random(seed)
    inputs = make_folder(folder / "inputs")
    found = []
    for index, (name, line) in enumerate(lines.items()):
        whole = inputs if name in MAKING else make_folder(folder / name)
        life_s = _life_s(_words(line, inputs, whole / name), HANGS_S if name in MAKING else LIFE_S)
        took_s, codes = [], Counter[int]()
        for number in range(runs):
            yield Step((index + number / runs) / len(lines), f"{name}: {number} of {runs}")
            output = make_folder(folder / f"{name}-{number}") / name
            time_s, code = _end(_words(line, inputs, output), draw.uniform(0.0, life_s))
            codes[code] += 1
            took_s += [] if time_s is None else [time_s]
        ends = ", ".join(f"{count} with {code}" for code, count in sorted(codes.items()))
        what = f"s from SIGTERM to the end, the longest of {len(took_s)} in {life_s:.1f} s; {runs} ended: {ends}"
        found.append(Accuracy(f"cancel-{name}", max(took_s, default=0.0), what, BOUND_S))
    return found


def _words(line: str, inputs: Path, output: Path) -> list[str]:
    return [word.format(inputs=inputs, output=output) for word in line.split()]


def _start(words: list[str]) -> subprocess.Popen[bytes]:
    """Start a verb with the ordinary caches and temporary files; its output is discarded."""
    return subprocess.Popen(
        [sys.executable, "-m", "app.__main__", *words],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
    )


def _life_s(words: list[str], max_s: float) -> float:
    """Seconds that the verb takes when nobody interrupts it, `max_s` at most."""
    started_s = time.monotonic()
    code = _wait(_start(words), max_s)
    if code not in (0, -signal.SIGKILL):
        raise RuntimeError(f"{' '.join(words)} ended with exit code {code}")
    return time.monotonic() - started_s


def _end(words: list[str], moment_s: float) -> tuple[float | None, int]:
    """Seconds from a signal at `moment_s` to the end, None where the verb was quicker, and its exit code."""
    process = _start(words)
    try:
        return None, process.wait(moment_s)
    except subprocess.TimeoutExpired:
        wished_s = time.monotonic()
        process.send_signal(signal.SIGTERM)
        code = _wait(process, HANGS_S)
        return time.monotonic() - wished_s, code
    finally:
        process.kill()


def _wait(process: subprocess.Popen[bytes], max_s: float) -> int:
    """The exit code of a process, which is killed after `max_s`; a wait with a limit of its own looks seldom."""
    late = threading.Timer(max_s, process.kill)
    late.start()
    try:
        return process.wait()
    finally:
        late.cancel()
        process.kill()
