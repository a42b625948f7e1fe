"""The run of a batch: captures that are missing or have changed are made side by side, each in a process of its own.

A process makes one capture at a time and is replaced after a failure, so that whatever a capture does to it costs that
capture alone. It computes on one thread: captures are many, and one on each core leaves none idle. What a run does is
decided by what is there (`app.batch.record`, and the folders of results), so that it may end at any moment and go on
with the same call.

Cost: 2 s for the start of a process, which then makes captures until one fails or `PER_PROCESS` are made; for each
capture two rows in the record, some milliseconds.
"""

from __future__ import annotations

import contextlib
import dataclasses
import json
import os
import queue
import threading
import time
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import engine
from app.batch.captures import Capture, find_captures
from app.batch.cluster import on_cluster
from app.batch.processes import LOGS, TIDYING_S, CarryOut, MakingProcess, Order
from app.batch.record import Record, Row, open_record, read_folder, read_rows
from app.batch.report import write_report
from app.batch.template import keep_template, state_of, template_of
from app.document.document import Project
from app.project.values import in_full, name_of
from engine.core.budget import thread_count
from engine.core.errors import UsageError
from engine.core.steps import Step, Steps, time_left
from engine.storage.atomic import make_folder

#: The function that makes a capture, in a worker: of its text, and the order as JSON values.
MAKE = "app.batch.making:make_of_request"

#: Seconds that a capture may take where nobody says, and the shortest and the longest time that it may be given.
TIME_LIMIT_S = 3600.0
MIN_TIME_S, MAX_TIME_S = 1.0, 1e9

#: Seconds between two looks at the workers, and between two versions of the report while a run goes on; the share of
#: the time that writing it may take.
LOOK_S, REPORT_S, REPORT_SHARE = 0.05, 10.0, 0.02

#: Files that are looked at in the folder of a capture, at most.
MAX_FILES = 10_000


#: A capture with a step of it, or with its end: a record, or why it failed.
Event = tuple[Capture, dict[str, Any]]
Events = queue.SimpleQueue[Event]


@dataclass(frozen=True)
class Settings:
    """The way in which captures are made.

    Attributes
    ----------
    template : a project whose choices are those of all captures; None for those of the last run, or of a new project.
    targets : exports that are written of each; None for those of the template.
    workers : processes; None for one on each core.
    time_limit_s, memory_limit_bytes : of one capture; None for an even share of the memory that is free.
    cluster : address of the scheduler of a Dask cluster, on whose workers captures are made (`engine.core.cluster`).

    UsageError for a time that no capture can be given.
    """

    template: Project | None = None
    targets: tuple[str, ...] | None = None
    workers: int | None = None
    time_limit_s: float = TIME_LIMIT_S
    memory_limit_bytes: int | None = None
    cluster: str = ""

    def __post_init__(self) -> None:
        if not MIN_TIME_S <= self.time_limit_s <= MAX_TIME_S:
            low, high = f"{MIN_TIME_S:g} s", f"{MAX_TIME_S:g} s"
            raise UsageError(f"a time limit of {self.time_limit_s:g} s is outside {low} … {high}")

    @property
    def worker_count(self) -> int:
        return self.workers or thread_count()


def go_on(output: Path, sources: Sequence[str], settings: Settings) -> Steps[list[Row]]:
    """Make the captures of `sources` in the folder `output`, or all that its record knows where there are none.

    Where `settings` leave the template or the targets open, they are those of the last run there. The choices of a
    template are copied. The rows are those of these captures. Raises what `find_captures`, `open_record` and
    `make_batch` raise, and UsageError without a capture; nothing is then written.
    """
    yield Step(0.0, "looking for captures")
    output = in_full(output)
    known = [row.capture for row in read_rows(output)]
    captures = find_captures(sources, known) if sources else known
    if not captures:
        raise UsageError("there is no capture: name folders of photographs, or a table of them")
    with open_record(make_folder(output)) as record:
        if settings.template is not None:
            keep_template(settings.template, output)
        targets = settings.targets if settings.targets is not None else record.choices().get("targets")
        settings = dataclasses.replace(settings, targets=None if targets is None else tuple(targets))
        record.choose({"targets": settings.targets})
        names = {each.name for each in captures}
        rows = yield from make_batch(output, record, captures, settings)
        return [row for row in rows if row.capture.name in names]


def make_batch(
    output: Path, record: Record, captures: Sequence[Capture], settings: Settings, make: str | None = None
) -> Steps[list[Row]]:
    """Make those of `captures` that are missing in the folder `output`, or have changed; all rows of the `record`.

    The `partial` of a step are rows that have changed, that of the first all rows. Closing the generator stops what is
    being made; not asking for the next step lets that end, and nothing else begins. `make` is the function in place of
    `MAKE`. A failure of a capture is part of its row. Raises OutputError where the record or the report cannot be
    written.
    """
    make_folder(output / LOGS)
    rows = {row.capture.name: row for row in record.rows()}
    order = (engine.__version__, settings.targets, state_of(template_of(output)))
    chosen = {each.name: _stamp(each, order) for each in captures}
    left = deque(each for each in captures if not _is_done(rows.get(each.name), chosen[each.name], output))
    for each in captures:
        rows.setdefault(each.name, Row(each))
    stale = [row for row in rows.values() if row.state == "running" and row.capture.name not in chosen]
    rows |= {each.name: _again(rows[each.name], each, chosen[each.name], output) for each in left}
    rows |= {row.capture.name: dataclasses.replace(row, state="waiting") for row in stale}
    record.put(rows.values())
    report = _Report(output, settings)
    report.write(rows)
    total, begun_s, ended = len(left), time.monotonic(), 0
    progress: dict[str, float] = {}
    yield Step(0.0, _words(0, total, begun_s), tuple(rows.values()))
    if not left:
        return list(rows.values())
    try:
        with _open_lanes(output, settings, make or MAKE, total) as (lanes, events):
            while left or progress:
                changed = [_row_of(rows[capture.name], event) for capture, event in _collect(events, progress)]
                ended += len(changed)
                for lane in lanes:
                    if left and lane.is_idle:
                        capture = left.popleft()
                        changed.append(dataclasses.replace(rows[capture.name], state="running"))
                        progress[capture.name] = 0.0
                        lane.begin(capture)
                rows |= {row.capture.name: row for row in changed}
                if changed:
                    record.put(changed)
                    report.write(rows, every_s=REPORT_S)
                yield Step(_share(ended, progress, total), _words(ended, total, begun_s), tuple(changed) or None)
    finally:
        unfinished = [dataclasses.replace(rows[name], state="waiting") for name in progress]
        rows |= {row.capture.name: row for row in unfinished}
        record.put(unfinished)
        report.write(rows)
    return list(rows.values())


def _collect(events: Events, progress: dict[str, float]) -> Iterator[Event]:
    """The captures that have ended, once one has or `LOOK_S` are over; steps of the others are noted."""
    wait_s = LOOK_S if progress else 0.0
    with contextlib.suppress(queue.Empty):
        while True:
            capture, event = events.get(timeout=wait_s) if wait_s else events.get_nowait()
            wait_s = 0.0
            if "error" in event:
                raise event["error"]
            if "done" in event:
                progress[capture.name] = float(event["done"])
            else:
                del progress[capture.name]
                yield capture, event


def _share(ended: int, progress: Mapping[str, float], total: int) -> float:
    return min(1.0, (ended + sum(progress.values())) / max(1, total))


def _words(ended: int, total: int, begun_s: float) -> str:
    if not ended:
        return f"{ended} of {total} captures"
    left = time_left((time.monotonic() - begun_s) / ended * (total - ended))
    return f"{ended} of {total} captures, {left}"


def _again(row: Row, capture: Capture, stamp: str, output: Path) -> Row:
    """The row of a capture that is to be made, or looked at again, with what its folder says now."""
    record = read_folder(output / capture.name) or {}
    seconds = row.seconds if record == row.record else None
    return Row(capture, stamp=stamp, seconds=seconds, record=record)


def _row_of(row: Row, event: Mapping[str, Any]) -> Row:
    """The row of a capture that has ended; one that was found unchanged took what making it took."""
    if "record" in event:
        seconds = row.seconds if event["record"] == row.record else event["seconds"]
        return dataclasses.replace(row, state="done", reason="", seconds=seconds, record=event["record"])
    return dataclasses.replace(row, state="failed", reason=event["failed"], seconds=event["seconds"], record={})


def _stamp(capture: Capture, order: tuple[Any, ...]) -> str:
    """The hash of what a capture is made from, files by names, sizes and times of change.

    Where it is another, contents decide (`app.batch.making`).
    """
    files = []
    for path in (capture.place, *_files_below(capture.place)):
        with contextlib.suppress(OSError):
            about = path.stat()
            files.append((os.fspath(path), about.st_size, about.st_mtime_ns))
    return name_of(json.dumps([order, capture.as_text(), sorted(files)]).encode())


def _files_below(place: Path) -> list[Path]:
    """Files in a folder and in its folders, none for an archive."""
    found: list[Path] = []
    for folder, _, names in os.walk(place):
        found += [Path(folder, name) for name in names]
        if len(found) > MAX_FILES:
            break
    return found


def _is_done(row: Row | None, stamp: str, output: Path) -> bool:
    return row is not None and row.state == "done" and row.stamp == stamp and (output / row.capture.name).is_dir()


class _Report:
    """Writes the report, and not again before some time has passed, which grows with the time that writing takes."""

    def __init__(self, output: Path, settings: Settings) -> None:
        self._output, self._settings, self._due_s = output, settings, 0.0

    def write(self, rows: Mapping[str, Row], every_s: float = 0.0) -> None:
        if every_s and time.monotonic() < self._due_s:
            return
        began_s = time.monotonic()
        write_report(self._output, list(rows.values()))
        now = time.monotonic()
        self._due_s = now + max(every_s or REPORT_S, (now - began_s) / REPORT_SHARE)


class _Lane:
    """A thread that has one capture made after the other, by `carry_out`, and says in `events` what became of each."""

    def __init__(self, carry_out: CarryOut, events: Events) -> None:
        self._carry_out, self._events, self.is_idle = carry_out, events, True
        self._asked: queue.SimpleQueue[Capture | None] = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._work, name="batch", daemon=True)
        self._thread.start()

    def begin(self, capture: Capture) -> None:
        self.is_idle = False
        self._asked.put(capture)

    def close(self) -> None:
        """Wait until the thread has ended, once what it waits for has."""
        self._asked.put(None)
        self._thread.join(TIDYING_S)

    def _work(self) -> None:
        while (capture := self._asked.get()) is not None:
            began_s = time.monotonic()
            end = self._carry_out(capture, partial(self._tell, capture))
            self.is_idle = True
            self._tell(capture, {**end, "seconds": round(time.monotonic() - began_s, 3)})

    def _tell(self, capture: Capture, event: dict[str, Any]) -> None:
        self._events.put((capture, event))


@contextlib.contextmanager
def _open_lanes(output: Path, settings: Settings, make: str, count: int) -> Iterator[tuple[list[_Lane], Events]]:
    """At most `count` lanes, by processes of this machine or by the workers of a cluster; they end with the block."""
    events: Events = queue.SimpleQueue()
    template = template_of(output)
    order = Order(
        make,
        os.fspath(output),
        None if template is None else os.fspath(template),
        settings.targets,
        settings.time_limit_s,
        settings.memory_limit_bytes,
    )
    lanes: list[_Lane] = []
    with contextlib.ExitStack() as opened:
        if settings.cluster:
            carry_out, threads = opened.enter_context(on_cluster(settings.cluster, order))
            works = [carry_out] * min(count, threads)
        else:
            processes = [MakingProcess(order, settings.worker_count) for _ in range(min(count, settings.worker_count))]
            for process in processes:
                opened.callback(process.end)
            for process in processes:  # all are asked to end before the end of one is waited for
                opened.callback(process.close)
            works = [process.carry_out for process in processes]
        try:
            lanes += [_Lane(work, events) for work in works]
            yield lanes, events
        finally:
            opened.close()
            for lane in lanes:
                lane.close()
