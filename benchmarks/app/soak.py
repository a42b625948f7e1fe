"""Random use of the window: models, materials, modes, bakes, workspaces, themes and sizes.

    python -m benchmarks.app.soak SECONDS SEED [ACTIONS]

One run does something every 20 to 400 ms, in an order that SEED alone decides, for SECONDS and for at least ACTIONS
actions, 100 without a number. It prints one JSON object: what it did how often, faults of the program that it met, the
medians of descriptors, threads and memory in the second and the last quarter of its time (single moments differ by a
hundred megabytes, as long as jobs run) and of memory in each sixteenth of it, and how long the thread of the window was
held up: quantiles of the delays of a timer, of those without drawing, and of the time of the CPU in the latter, with
the longest after each kind of action.
`window_soak` (`python -m benchmarks --only window-soak --runs N --run-s SECONDS`) starts many, each with a limit of
256 descriptors, and sums up: how many died, how much descriptors, threads and memory grew, and how much memory the
largest held in the end. Four run at once, so that the machine is loaded, or one after the other (`--at-once 1`).
"""

from __future__ import annotations

import faulthandler
import json
import logging
import os
import random
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Callable, Sequence
from itertools import pairwise
from pathlib import Path
from typing import IO, Any

import psutil

from benchmarks.app.gaps import LIMIT_MS, Drawing, Gaps
from benchmarks.measure import Accuracy
from engine.core.errors import LightarcError, MissingCapability
from engine.core.steps import Step, Steps
from engine.storage.atomic import make_folder, write_bytes

#: Runs side by side: more than this machine has CPUs, because what dies, dies where threads wait.
AT_ONCE = 4
RUNS, RUN_S = 8, 8.0

#: Actions of a run, at least: a loaded machine does fewer in the same time.
MIN_ACTIONS = 100

#: Seconds beyond its time after which a run is taken to hang.
PATIENCE_S = 300.0
DESCRIPTORS = 256

#: Folders that a run has for itself: the user's own projects and settings stay as they are.
FOLDERS = ("CACHE", "CONFIG", "DATA", "STATE")

#: Samples of resources in a run. After the first quarter nothing that is kept should grow any more.
SAMPLES = 80

#: Parts of a run of which each has a figure of its own, and the quantiles of delays that are told.
PARTS = 16
QUANTILES = (0.5, 0.9, 0.99, 0.999, 1.0)

#: Niceness of the thread that takes samples.
NICENESS = 10

#: Quantities that are sampled, with their units.
GROWING = (("descriptors", ""), ("threads", ""), ("memory_mb", " MB"))

#: Bytes that undo may keep here: as much as a user has would hide whatever else grows for the first half hour.
UNDO_BYTES = 32 * 2**20

BRDFS = (
    "lambert:albedo=0.6",
    "ggx:alpha=0.3",
    "ggx:alpha_x=0.1,alpha_y=0.4",
    "ward",
    "phong:exponent=40",
    "lafortune:preset=blue-paint",
)

_log = logging.getLogger(__name__)


def window_soak(
    folder: Path,
    *,
    runs: int = RUNS,
    run_s: float = RUN_S,
    seed: int = 1,
    record: Path | None = None,
    at_once: int = AT_ONCE,
) -> Steps[list[Accuracy]]:
    """Run the window `runs` times for `run_s` seconds each and count deaths and faults; seeds count up from `seed`.

    Each run leaves a line of JSON in `soak.jsonl` in `record` (`folder` without it).
    """
    folder = make_folder(record or folder)
    if sys.platform.startswith("linux") and not os.environ.get("DISPLAY"):
        raise MissingCapability("There is no display to open windows on", "Set DISPLAY, for instance with xvfb-run")
    from PySide6.QtCore import qVersion

    waiting = list(range(seed, seed + runs))
    running: dict[int, tuple[subprocess.Popen[bytes], IO[bytes], float]] = {}
    records: list[dict[str, Any]] = []
    try:
        while waiting or running:
            while waiting and len(running) < at_once:
                number = waiting.pop(0)
                said: IO[bytes] = tempfile.TemporaryFile()  # noqa: SIM115 - it is read when the run has ended
                running[number] = (_start(run_s, number, said), said, time.monotonic())
            for number, (process, said, started_s) in tuple(running.items()):
                if process.poll() is None and time.monotonic() - started_s > run_s + PATIENCE_S:
                    process.kill()
                if process.poll() is not None:
                    del running[number]
                    records.append(_record(number, process.returncode, said))
                    write_bytes(folder / "soak.jsonl", "".join(json.dumps(kept) + "\n" for kept in records).encode())
            yield Step(len(records) / runs, f"{len(records)} of {runs} runs, {sum(map(_has_died, records))} died")
            time.sleep(0.2)
    finally:
        for process, *_ in running.values():
            process.kill()
            process.wait()
    actions = sum(sum(record.get("did", {}).values()) for record in records)
    what = (
        f"of {runs} runs of the window, {run_s:g} s each, {at_once} at once, died; Qt {qVersion()}; {actions} actions"
    )
    growth = [_growth(record) for record in records if "end" in record]
    found = [Accuracy("window-soak", sum(map(_has_died, records)), what, 0.0)]
    for name, unit in GROWING:
        most = max((grown[name] for grown in growth), default=0.0)
        median = statistics.median([grown[name] for grown in growth] or [0.0])
        words = (
            f"{name.partition('_')[0]} more in the last quarter of a run than in its second; median {median:g}{unit}"
        )
        found.append(Accuracy(f"window-soak-{name}", most, words))
    held = [record["end"]["memory_mb"] for record in records if "memory_mb" in record.get("end", {})]
    words = f"MB in the last quarter of the run that held most; median {statistics.median(held or [0.0]):g} MB"
    return [*found, Accuracy("window-soak-held", max(held, default=0.0), words)]


def _start(run_s: float, seed: int, said: IO[bytes]) -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        [sys.executable, "-X", "faulthandler", "-m", "benchmarks.app.soak", f"{run_s:g}", str(seed)],
        stdin=subprocess.DEVNULL,
        stdout=said,
        stderr=subprocess.STDOUT,
        start_new_session=True,
    )


def _record(seed: int, code: int, said: IO[bytes]) -> dict[str, Any]:
    """The last record that a run printed, or its whole output where it ended early, with its exit code."""
    said.seek(0)
    words = said.read().decode(errors="replace")
    lines = [line for line in words.splitlines() if line.startswith('{"seed"')]
    record: dict[str, Any] = json.loads(lines[-1]) if lines else {"seed": seed, "said": words}
    record["exit_code"] = code
    if _has_died(record):
        _log.warning("Run %d ended with exit code %d:\n%s", seed, code, words[-2000:])
    return record


def _has_died(record: dict[str, Any]) -> bool:
    return record["exit_code"] != 0


def _growth(record: dict[str, Any]) -> dict[str, float]:
    return {name: record["end"][name] - record["warm"][name] for name in record["end"]}


def main() -> int:
    from PySide6.QtCore import QTimer

    from app.document import history
    from app.window.application import start
    from app.window.main_window import MainWindow

    run_s, seed = float(sys.argv[1]), int(sys.argv[2])
    actions = int(sys.argv[3]) if len(sys.argv) > 3 else MIN_ACTIONS
    _limit_descriptors()
    history.KEPT_BYTES = UNDO_BYTES
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as name:
        folder = Path(name)
        os.environ.update({f"XDG_{name}_HOME": str(folder / name.lower()) for name in FOLDERS})
        files = _files(folder)
        application = start()
        window = MainWindow(folder)
        window.failures.install()
        window.show()
        Drawing.watch(window.view.viewport.surface)
        hand = _Hand(window, files, random.Random(seed))
        samples: list[dict[str, float]] = []
        after: list[str] = []

        def note() -> bool:
            after.append(hand.last)
            return True

        gaps = Gaps(note)
        is_over = threading.Event()
        sampling = threading.Thread(target=_sample, args=(samples, run_s / SAMPLES, is_over))
        sampling.start()
        window.failures.arrived.connect(hand.handle_error)
        QTimer.singleShot(0, hand.act)
        ending = QTimer(interval=100)
        until_s = time.monotonic() + run_s
        ending.timeout.connect(lambda: _end_after(hand, until_s, actions, application))
        ending.start()
        application.exec()  # left by exit, because quit closes the window
        hand.over = True
        is_over.set()
        sampling.join()
        samples.append(_resources())
        window.files.leaving.stop_others()
        window.close()
    quarter = (len(samples) + 3) // 4
    measured = {
        "warm": _medians(samples[quarter : 2 * quarter] or samples),
        "end": _medians(samples[-quarter:]),
        "memory_mb": [round(_medians(part)["memory_mb"]) for part in _parts(samples)],
        "blocks_ms": _quantiles(gaps.gaps_ms),
        "own_blocks_ms": _quantiles(gaps.own_ms),
        "busy_blocks_ms": _quantiles(gaps.busy_ms),
        "longest_ms": _longest(after, gaps),
    }
    print(json.dumps({"seed": seed, "did": dict(hand.did), "faults": hand.faults, **measured}), flush=True)
    return 1 if hand.faults else 0


def _end_after(hand: _Hand, until_s: float, actions: int, application: Any) -> None:
    if time.monotonic() >= until_s and hand.did.total() >= actions:
        application.exit()


def _parts(samples: Sequence[dict[str, float]]) -> list[Sequence[dict[str, float]]]:
    """`samples` in `PARTS` parts of equal length."""
    bounds = [len(samples) * at // PARTS for at in range(PARTS + 1)]
    return [samples[start:end] for start, end in pairwise(bounds) if end > start]


def _quantiles(delays_ms: Sequence[float]) -> dict[str, float]:
    """Quantiles of delays, and how many are over the limit."""
    ordered = sorted(delays_ms)
    found = {f"p{100 * share:g}": round(ordered[int(share * (len(ordered) - 1))], 1) for share in QUANTILES}
    return {**found, "count": len(ordered), "over_limit": sum(delay > LIMIT_MS for delay in ordered)}


def _longest(after: Sequence[str], gaps: Gaps) -> dict[str, tuple[float, float]]:
    """The longest delay without drawing after each kind of action, and the longest time of the CPU in one."""
    found: dict[str, tuple[float, float]] = {}
    for name, own, busy in zip(after, gaps.own_ms[1:], gaps.busy_ms[1:], strict=True):
        before = found.get(name, (0.0, 0.0))
        found[name] = max(before[0], round(own, 1)), max(before[1], round(busy, 1))
    return found


def _limit_descriptors() -> None:
    if sys.platform != "win32":
        import resource

        hard = resource.getrlimit(resource.RLIMIT_NOFILE)[1]
        resource.setrlimit(resource.RLIMIT_NOFILE, (min(DESCRIPTORS, hard), hard))


def _sample(samples: list[dict[str, float]], every_s: float, is_over: threading.Event) -> None:
    """Take samples on a thread that gives way to the window's, because one takes some 20 ms."""
    if sys.platform == "linux":
        os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), NICENESS)
    while not is_over.wait(every_s):
        samples.append(_resources())


def _resources() -> dict[str, float]:
    process = psutil.Process()
    descriptors = process.num_fds() if hasattr(process, "num_fds") else process.num_handles()
    memory = process.memory_full_info().uss / 2**20
    return {"descriptors": descriptors, "threads": process.num_threads(), "memory_mb": round(memory, 1)}


def _medians(samples: Sequence[dict[str, float]]) -> dict[str, float]:
    return {name: statistics.median(sample[name] for sample in samples) for name, _unit in GROWING}


def _files(folder: Path) -> list[Path]:
    """Small models in four formats, an environment, and a file that is not a model."""
    import numpy as np
    import trimesh

    from engine.images.encode import write_exr

    sphere = trimesh.creation.icosphere(subdivisions=2)
    ring = trimesh.creation.torus(1.0, 0.3)
    made = [folder / name for name in ("ball.obj", "ring.ply", "ball.stl", "ring.glb")]
    for path in made:
        (sphere if path.stem == "ball" else ring).export(path)
    rng = np.random.default_rng(0)
    sky = folder / "sky.exr"
    write_exr(sky, {name: rng.random((16, 32), np.float32) for name in "RGB"})
    write_bytes(folder / "broken.obj", b"v 0 0 nothing\nf 1 2 3\n")
    return [*made, sky, folder / "broken.obj"]


class _Hand:
    """A random user of the window: its actions, chosen by `chance`, and the faults that it met."""

    def __init__(self, window: Any, files: list[Path], chance: random.Random) -> None:
        self.window, self.files, self.chance = window, files, chance
        self.did: Counter[str] = Counter()
        self.faults: list[str] = []
        self.last = ""
        self.over = False
        self.acts: dict[Callable[[], None], int] = {
            self.open_model: 8,
            self.resize: 5,
            self.choose_mode: 4,
            self.show_workspace: 4,
            self.turn: 4,
            self.bake: 2,
            self.compare: 2,
            self.choose_brdf: 2,
            self.light: 2,
            self.undo: 2,
            self.theme: 1,
            self.docks: 1,
            self.sample: 1,
            self.new: 1,
        }

    def act(self) -> None:
        """Do something, and something else a little later."""
        from PySide6.QtCore import QTimer

        if self.over:
            return
        (deed,) = self.chance.choices(list(self.acts), list(self.acts.values()))
        self.last = deed.__name__
        self.did[self.last] += 1
        QTimer.singleShot(self.chance.choice((20, 60, 120, 400)), self.act)
        deed()

    def handle_error(self, _title: str, error: BaseException) -> None:
        """Keep a fault of the program; what a user could cause is expected. Dialogs are closed as a user would."""
        if not isinstance(error, LightarcError):
            self.faults.append(repr(error))
        for box in tuple(self.window.failures.open_dialogs.values()):
            box.close()

    def open_model(self) -> None:
        self.window.show_workspace("view")
        self.window.open([self.chance.choice(self.files)])

    def resize(self) -> None:
        if self.chance.random() < 0.1:
            self.window.setWindowState(self.window.windowState() ^ self.window.windowState().WindowMaximized)
        self.window.resize(self.chance.randint(1120, 1900), self.chance.randint(700, 1050))

    def choose_mode(self) -> None:
        from app.document.modes import modes

        self.window.view.choose_mode(self.chance.choice(modes()).value)

    def show_workspace(self) -> None:
        self.window.show_workspace(self.chance.choice(list(self.window.tabs)))

    def turn(self) -> None:
        self.window.view.viewport.turn(self.chance.uniform(-1.0, 1.0), self.chance.uniform(-0.3, 0.3))

    def bake(self) -> None:
        baking = self.chance.choice(list(self.window.view.bakings.values()))
        if self.chance.random() < 0.3:
            baking.cancel()
        elif baking.estimate is not None:
            baking.bake()

    def compare(self) -> None:
        self.window.view.compare.toggle(self.chance.choice(("wipe", "difference")))

    def choose_brdf(self) -> None:
        import dataclasses

        document = self.window.bench.document
        material = dataclasses.replace(document.project.material, brdf=self.chance.choice(BRDFS))
        document.change("BRDF", material=material)

    def light(self) -> None:
        if self.chance.random() < 0.5:
            self.window.bench.load_environment(self.chance.choice(("studio", "noon", "softboxes")))
        else:
            theta_deg, phi_deg = self.chance.uniform(0, 180), self.chance.uniform(-180, 180)
            self.window.view.viewport.light_moved.emit(theta_deg, phi_deg, True)

    def undo(self) -> None:
        (self.window.undo if self.chance.random() < 0.7 else self.window.redo).trigger()

    def theme(self) -> None:
        self.window.set_theme(self.chance.choice(("dark", "light")))

    def docks(self) -> None:
        for dock in (self.window.docks.lobes, self.window.docks.health, self.window.docks.jobs):
            if self.chance.random() < 0.5:
                dock.setVisible(not dock.isVisible())

    def sample(self) -> None:
        if self.did["sample"] <= 2 and not self.window.bench.document.project.has_map:
            self.window.menus.sample_wanted.emit()

    def new(self) -> None:
        if self.chance.random() < 0.3:
            self.window.new()


if __name__ == "__main__":
    faulthandler.enable()
    sys.exit(main())
