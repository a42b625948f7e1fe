"""Batches of simulated captures: what the scheduler costs, what killed processes lose, and what memory grows by.

A simulated capture waits, or computes, for a known time and writes one file, so that nothing but the scheduler and the
processes is measured. A schedule of many more captures is simulated from what is measured here.

`batch_captures` makes whole captures of simulated photographs instead, from the import to the export. All have the
same photographs, and of their results no more than the record is kept on the disk.
"""

from __future__ import annotations

import heapq
import json
import math
import random
import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import psutil

from app.batch.captures import Capture
from app.batch.making import make_of_request
from app.batch.record import FOLDER_RECORD, Row, open_record
from app.batch.run import REPORT_SHARE, Settings, make_batch
from benchmarks.measure import Accuracy
from engine.core.budget import thread_count
from engine.core.errors import UsageError
from engine.core.steps import Step, Steps
from engine.simulate.arc import LightArc
from engine.simulate.simulate import simulate
from engine.storage.atomic import atomic_folder, discard, make_folder, write_bytes, write_json

#: Captures for each process, seconds that one takes, and seconds between two kills.
CAPTURES, CAPTURE_S, KILL_S = 24, 0.5, 3.0

#: Processes of which the overhead is measured, and the schedule that is simulated: captures, processes, and seconds of
#: a capture of 1 megapixel.
PROCESSES, SCHEDULE = (2, 4, 8), (100_000, 64, 60.0)

#: Whole captures for each process and for the one that they are compared with, megapixels of a photograph, elevations
#: of the lamp in degrees, and seconds between two kills.
WHOLE, ALONE, MEGAPIXELS, ELEVATIONS_DEG, WHOLE_KILL_S = 30, 8, 0.05, (15, 30, 45, 60, 75), 60.0


def wait(text: str, order: Mapping[str, Any]) -> Steps[dict[str, Any]]:
    """A capture that takes `CAPTURE_S` of no core."""
    begun_s = time.monotonic()
    yield Step(0.5, "waiting")
    time.sleep(CAPTURE_S)
    return _write(text, order, begun_s)


def compute(text: str, order: Mapping[str, Any]) -> Steps[dict[str, Any]]:
    """A capture that takes `CAPTURE_S` of the time of one core."""
    begun_s = time.monotonic()
    yield Step(0.5, "computing")
    _compute()
    return _write(text, order, begun_s)


def make_whole(text: str, order: Mapping[str, Any]) -> Steps[dict[str, Any]]:
    """A capture as a batch makes it; the record tells the seconds."""
    begun_s = time.monotonic()
    record = yield from make_of_request(text, order)
    return {**record, "spent_s": time.monotonic() - begun_s}


def _compute() -> None:
    values = np.linspace(0.0, 1.0, 1 << 14)
    until = time.process_time() + CAPTURE_S
    while time.process_time() < until:
        values = np.sin(values)


def _write(text: str, order: Mapping[str, Any], begun_s: float) -> dict[str, Any]:
    """Write a folder; the record tells the seconds that all of the capture took."""
    name = json.loads(text)["name"]
    with atomic_folder(Path(order["output"]) / name, FOLDER_RECORD) as folder:
        write_bytes(folder / "made.txt", f"{time.time_ns()}".encode())
        write_json(folder / FOLDER_RECORD, {"lightarc_capture": 1, "key": name})
    return {"verdict": "good", "warnings": [], "photographs": 64, "spent_s": time.monotonic() - begun_s}


def batch(folder: Path, *, runs: int = CAPTURES, seed: int = 1) -> Steps[list[Accuracy]]:
    """Captures that are lost or made twice while processes are killed, growth of memory, throughput, and overhead.

    `runs` are captures for each process, `seed` decides which process is killed.
    """
    cores = thread_count()
    found = []
    captures = _captures(make_folder(folder / "killed"), runs * cores)
    seen = yield from _kill(folder / "killed", captures, cores, "wait", KILL_S, seed)
    found += _judge("batch", seen, len(captures), cores, "captures")
    one, _ = yield from _spend_on(folder / "one", runs, 1, "compute")
    all_cores, _ = yield from _spend_on(folder / "all", runs * cores, cores, "compute")
    what = f"throughput below that of one process times {cores}, each with {runs} captures of {CAPTURE_S} s"
    found.append(Accuracy("batch-throughput", max(0.0, 1.0 - one / all_cores), what, 0.1))
    for processes in PROCESSES:
        taken_s, captures_s = yield from _spend_on(folder / f"wait-{processes}", runs * processes, processes, "wait")
        what = f"time beyond that of {runs} captures of {CAPTURE_S} s on each of {processes} processes that wait"
        found.append(Accuracy(f"batch-overhead-{processes}", taken_s / captures_s - 1.0, what, 0.05))
    count, processes, capture_s = SCHEDULE
    service_s = yield from _find_service_s(folder / "service", runs)
    lost_share = 1.0 - count * capture_s / (processes * simulate_schedule(count, processes, capture_s, service_s))
    what = f"of the time of {processes} processes is lost in a simulated schedule of {count:,} captures of "
    what += f"{capture_s:g} s, of which the scheduler takes {1e3 * service_s:.2g} ms each, {REPORT_SHARE:.0%} of its "
    what += "time for the report"
    found.append(Accuracy("batch-schedule", lost_share, what, 0.05))
    return found


def batch_captures(
    folder: Path,
    megapixels: Sequence[float] = (MEGAPIXELS,),
    *,
    runs: int = WHOLE,
    seed: int = 1,
    keep: Path | None = None,
) -> Steps[list[Accuracy]]:
    """The same of whole captures, of which a process is killed every minute.

    `runs` are captures for each process, of photographs of so many `megapixels`, the first of which counts. A run that
    was ended goes on in the folder `keep`; UsageError where its photographs have another size.
    """
    folder = folder if keep is None else make_folder(keep)
    cores, size = thread_count(), round(1000.0 * math.sqrt(megapixels[0]))
    place = folder / "photographs"
    if place.is_dir():
        kept_px = json.loads((place / "truth" / "truth.json").read_bytes())["size_px"]
        if kept_px != size:
            raise UsageError(f"--keep {keep}: its photographs have {kept_px} px a side, and {size} are asked for")
    else:
        yield from simulate(LightArc(elevation=tuple(map(math.radians, ELEVATIONS_DEG)), size=size), place)
    captures = [Capture(f"capture {at}", place) for at in range(runs * cores)]
    discard(folder / "one")
    one, _ = yield from _spend(make_folder(folder / "one"), captures[:ALONE], 1, "make_whole")
    discard(folder / "one")
    seen = yield from _kill(make_folder(folder / "killed"), captures, cores, "make_whole", WHOLE_KILL_S, seed)
    what = f"captures of {len(ELEVATIONS_DEG)} photographs of {size * size / 1e6:.2g} megapixels"
    found = _judge("batch-whole", seen, len(captures), cores, what)
    idle = 1.0 - seen.made_s / (cores * seen.taken_s)
    what = f"of the time of {cores} processes is not spent on captures that were made: {seen.taken_s:.0f} s in all"
    found.append(Accuracy("batch-whole-idle", idle, what, 0.1, {"captures": len(captures), "taken_s": seen.taken_s}))
    alone_s, each_s = one / (ALONE - 1), seen.taken_s / len(captures)
    what = f"throughput below {cores} times that of one process, which takes {alone_s:.2f} s for a capture; {cores} "
    what += f"take {each_s:.2f} s; both as the load of the machine was"
    found.append(Accuracy("batch-whole-throughput", max(0.0, 1.0 - alone_s / (cores * each_s)), what, 0.1))
    return found


@dataclass(frozen=True)
class _Seen:
    """Captures lost and made twice, processes killed, the growth of this process in MB with each capture, seconds of
    the captures that were made, and of everything."""

    lost: int
    doubled: int
    killed: int
    slope_mb: float
    made_s: float
    taken_s: float


def _judge(name: str, seen: _Seen, count: int, processes: int, captures: str) -> list[Accuracy]:
    what = f"of {count:,} {captures} on {processes} processes, {seen.killed} of which were killed"
    return [
        Accuracy(f"{name}-lost", float(seen.lost), f"captures that are not there, {what}", 0.0),
        Accuracy(f"{name}-doubled", float(seen.doubled), f"captures that were made twice, {what}", 0.0),
        Accuracy(f"{name}-memory", seen.slope_mb, "MB that the scheduler grows by with a capture", 0.1),
    ]


def _captures(folder: Path, count: int) -> list[Capture]:
    """Captures that share one folder of photographs, which nobody reads."""
    place = make_folder(folder / "photographs")
    write_bytes(place / "a.png", b"no image")
    return [Capture(f"capture {at}", place) for at in range(count)]


def _run(folder: Path, captures: Sequence[Capture], processes: int, function: str) -> Steps[list[Row]]:
    output = make_folder(folder / "results")
    with open_record(output) as record:
        settings = Settings(workers=processes)
        return (yield from make_batch(output, record, captures, settings, f"benchmarks.batch:{function}"))


def _spend(folder: Path, captures: Sequence[Capture], processes: int, function: str) -> Steps[tuple[float, float]]:
    """Seconds from the first ends of captures to the last, since processes start but once, and those of the captures
    themselves, on each process."""
    first = last = time.monotonic()
    ended, captures_s = 0, 0.0
    for step in _run(folder, captures, processes, function):
        for row in _list_done(step):
            last, ended = time.monotonic(), ended + 1
            if ended <= processes:
                first = last
            else:
                captures_s += row.record["spent_s"] / processes
        yield Step(step.done, f"{processes} processes: {step.note}")
    return last - first, captures_s


def _spend_on(folder: Path, count: int, processes: int, function: str) -> Steps[tuple[float, float]]:
    """As `_spend`, of so many captures that are none."""
    return _spend(folder, _captures(make_folder(folder), count), processes, function)


def _list_done(step: Step) -> list[Row]:
    """The captures that a step says are done."""
    return [row for row in step.partial or () if row.state == "done"]


def _kill(
    folder: Path, captures: Sequence[Capture], processes: int, function: str, every_s: float, seed: int
) -> Steps[_Seen]:
    """Make captures while one of the processes is killed every so many seconds; a run that was ended goes on."""
    kept, draw, own, sizes = folder / "seen.json", random.Random(seed), psutil.Process(), list[float]()
    seen: dict[str, Any] = {"made": {}, "killed": 0, "made_s": 0.0, "taken_s": 0.0}
    if kept.is_file():
        seen = json.loads(kept.read_bytes())
    earlier, made = frozenset(seen["made"]), seen["made"]
    there = {name for name in made if _keep_record(folder / "results" / name)}
    last_s = time.monotonic()
    due_s = last_s + every_s
    for at, step in enumerate(_run(folder, captures, processes, function)):
        for row in _list_done(step):
            name = row.capture.name
            if at == 0 and name in earlier:  # the first step lists what earlier parts have made
                continue
            made[name] = made.get(name, 0) + 1
            seen["made_s"] += row.record["spent_s"]
            sizes.append(own.memory_info().rss / 1e6)
            there |= {name} & _keep_record(folder / "results" / name)
        if time.monotonic() > due_s:
            due_s = time.monotonic() + every_s
            with suppress(psutil.Error, IndexError):  # one that has just ended
                draw.choice([each for each in own.children() if "app.batch.worker" in each.cmdline()]).kill()
                seen["killed"] += 1
        if step.partial:
            last_s, taken_s = time.monotonic(), time.monotonic() - last_s
            seen["taken_s"] += taken_s
            write_json(kept, seen)
        yield Step(step.done, f"killing: {step.note}")
    later = sizes[len(sizes) // 2 :]
    slope_mb = float(np.polyfit(np.arange(len(later)), later, 1)[0]) if len(later) > 2 else 0.0
    lost, doubled = len(captures) - len(there), sum(made.values()) - len(made)
    return _Seen(lost, doubled, seen["killed"], slope_mb, seen["made_s"], seen["taken_s"])


def _keep_record(folder: Path) -> set[str]:
    """The name of a folder with a record, from which all else is removed."""
    if not (folder / FOLDER_RECORD).is_file():
        return set()
    for each in folder.iterdir():
        if each.name != FOLDER_RECORD:
            discard(each)
    return {folder.name}


def _find_service_s(folder: Path, count: int) -> Steps[float]:
    """Seconds of this process for one capture: to hand it out, to note it, to show it."""
    yield Step(0.0, "measuring the scheduler")
    captures, output = _captures(make_folder(folder), count), make_folder(folder / "results")
    with open_record(output) as record:
        record.put(map(Row, captures))
        begun_s = time.perf_counter()
        for capture in captures:
            record.put([Row(capture, "running")])
            record.put([Row(capture, "done", seconds=1.0, record={"verdict": "good"})])
        return (time.perf_counter() - begun_s) / count


def simulate_schedule(count: int, processes: int, capture_s: float, service_s: float) -> float:
    """Seconds until all captures are done: each takes `capture_s` (± 30 %, by a fixed seed) on one of `processes`, and
    `service_s` of the one scheduler before the process goes on, which writes reports besides (`REPORT_SHARE`).
    """
    draw = random.Random(1)
    free_s, scheduler_s = [0.0] * processes, 0.0
    for _ in range(count):
        ready_s = heapq.heappop(free_s)
        scheduler_s = max(ready_s, scheduler_s) + service_s * (1.0 + REPORT_SHARE)
        heapq.heappush(free_s, scheduler_s + capture_s * draw.uniform(0.7, 1.3))
    return max(free_s)
