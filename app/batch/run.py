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
import signal
import subprocess
import sys
import threading
import time
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import engine
from app.batch.captures import Capture, find_captures
from app.batch.record import Record, Row, open_record, read_folder
from app.batch.report import write_report
from app.batch.template import keep_template, state_of, template_of
from app.document.document import Project
from app.project.values import in_full, name_of
from engine.core.budget import VARIABLES, free_bytes, thread_count
from engine.core.errors import OutOfMemory, UsageError
from engine.core.figure_text import time_text
from engine.core.steps import Step, Steps, time_left
from engine.storage.atomic import make_folder

#: The function that makes a capture, in a worker: of its text, and the order as JSON values.
MAKE = "app.batch.making:make_of_request"

#: Folder of the logs, one for each capture.
LOGS = "logs"

#: Captures that a process makes before it is replaced, whatever libraries leave behind in it.
PER_PROCESS = 100

#: Seconds that a capture may take where nobody says; the least memory of one, in bytes.
TIME_LIMIT_S, MIN_BYTES = 3600.0, 1 << 30

#: Seconds between two looks at the workers, and between two versions of the report while a run goes on; the share of
#: the time that writing it may take.
LOOK_S, REPORT_S, REPORT_SHARE = 0.05, 10.0, 0.02

#: Processes that a capture may end before it has failed: one that was ended from outside is tried again.
TRIES = 3

#: Seconds in which a process that is stopped removes what is half-written.
TIDYING_S = 3.0

#: Files that are looked at in the folder of a capture, at most.
MAX_FILES = 10_000


#: A capture with a step of it, or with its end: a record, or why it failed.
Event = tuple[Capture, dict[str, Any]]


@dataclass(frozen=True)
class Settings:
    """The way in which captures are made.

    Attributes
    ----------
    template : a project whose choices are those of all captures; None for those of the last run, or of a new project.
    targets : exports that are written of each; None for those of the template.
    workers : processes; None for one on each core.
    time_limit_s, memory_limit_bytes : of one capture; None for an even share of the memory that is free.
    """

    template: Project | None = None
    targets: tuple[str, ...] | None = None
    workers: int | None = None
    time_limit_s: float = TIME_LIMIT_S
    memory_limit_bytes: int | None = None

    @property
    def worker_count(self) -> int:
        return self.workers or thread_count()


def go_on(output: Path, sources: Sequence[str], settings: Settings) -> Steps[list[Row]]:
    """Make the captures of `sources` in the folder `output`, or all that its record knows where there are none.

    Where `settings` leave the template or the targets open, they are those of the last run there. The choices of a
    template are copied. The rows are those of these captures. Raises what `find_captures`, `open_record` and
    `make_batch` raise, and UsageError without a capture.
    """
    yield Step(0.0, "looking for captures")
    output = make_folder(in_full(output))
    with open_record(output) as record:
        known = [row.capture for row in record.rows()]
        captures = find_captures(sources, known) if sources else known
        if not captures:
            raise UsageError("there is no capture: name folders of photographs, or a table of them")
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
    rows |= {
        row.capture.name: dataclasses.replace(row, state="waiting") for row in stale if row.capture.name not in chosen
    }
    record.put(rows.values())
    report = _Report(output, settings)
    report.write(rows)
    total, begun_s, ended = len(left), time.monotonic(), 0
    events: queue.SimpleQueue[Event] = queue.SimpleQueue()
    workers = [_Worker(output, settings, make or MAKE, events) for _ in range(min(settings.worker_count, total))]
    progress: dict[str, float] = {}
    try:
        yield Step(0.0, _words(0, total, begun_s), tuple(rows.values()))
        while left or progress:
            changed = [_row_of(rows[capture.name], event) for capture, event in _collect(events, progress)]
            ended += len(changed)
            for worker in workers:
                if left and worker.is_idle:
                    capture = left.popleft()
                    changed.append(dataclasses.replace(rows[capture.name], state="running"))
                    progress[capture.name] = 0.0
                    worker.begin(capture)
            rows |= {row.capture.name: row for row in changed}
            if changed:
                record.put(changed)
                report.write(rows, every_s=REPORT_S)
            yield Step(_share(ended, progress, total), _words(ended, total, begun_s), tuple(changed) or None)
    finally:
        for worker in workers:
            worker.close()
        for worker in workers:
            worker.join()
        unfinished = [dataclasses.replace(rows[name], state="waiting") for name in progress]
        rows |= {row.capture.name: row for row in unfinished}
        record.put(unfinished)
        report.write(rows)
    return list(rows.values())


def _collect(events: queue.SimpleQueue[Event], progress: dict[str, float]) -> Iterator[Event]:
    """The captures that have ended, once one has or `LOOK_S` are over; steps of the others are noted."""
    wait_s = LOOK_S if progress else 0.0
    with contextlib.suppress(queue.Empty):
        while True:
            capture, event = events.get(timeout=wait_s) if wait_s else events.get_nowait()
            wait_s = 0.0
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


class _Worker:
    """A process that makes captures, and the thread that talks to it."""

    def __init__(self, output: Path, settings: Settings, make: str, events: queue.SimpleQueue[Event]) -> None:
        self._output, self._settings, self._make, self._events = output, settings, make, events
        self._asked: queue.SimpleQueue[Capture | None] = queue.SimpleQueue()
        self._process: subprocess.Popen[bytes] | None = None
        self._made, self._stopped, self.is_idle = 0, False, True
        self._memory_bytes = settings.memory_limit_bytes or max(MIN_BYTES, free_bytes() // settings.worker_count)
        self._thread = threading.Thread(target=self._talk, name="batch", daemon=True)
        self._thread.start()

    def begin(self, capture: Capture) -> None:
        self.is_idle = False
        self._asked.put(capture)

    def close(self) -> None:
        """Ask nothing more: the process ends, whatever it is doing, and the thread after it."""
        self._stopped = True
        self._asked.put(None)
        process = self._process
        if process is not None and process.stdin is not None:
            with contextlib.suppress(OSError):
                process.stdin.close()

    def join(self) -> None:
        """Wait until the process has ended, which it may take `TIDYING_S` for."""
        self._end()
        self._thread.join(TIDYING_S)

    def _talk(self) -> None:
        while (capture := self._asked.get()) is not None:
            began_s = time.monotonic()
            event = self._carry_out(capture)
            self.is_idle = True
            self._events.put((capture, {**event, "seconds": round(time.monotonic() - began_s, 3)}))

    def _carry_out(self, capture: Capture) -> dict[str, Any]:
        """The end of a capture: its `record`, or the sentence why it `failed`."""
        ending = ""
        for _ in range(TRIES):
            if self._stopped:
                return {"failed": "It was stopped."}
            try:
                process = self._start()
            except OSError as error:
                return {"failed": str(OutOfMemory(f"No further process can be started ({error.strerror})"))}
            reply, is_late = self._ask_in_time(process, capture)
            if reply is None or reply.pop("last", False) or "failed" in reply or self._made >= PER_PROCESS:
                self._end()
            if reply is not None:
                return reply
            if is_late:
                limit = time_text(self._settings.time_limit_s)
                return {"failed": f"It took longer than {limit}, the limit of a capture. Give --time-limit."}
            ending = _describe_end(process)
        return {"failed": f"Its process ended {TRIES} times ({ending}); its log says where."}

    def _ask_in_time(self, process: subprocess.Popen[bytes], capture: Capture) -> tuple[dict[str, Any] | None, bool]:
        """As `_ask`, by a process that is killed when it takes too long, and whether it was."""
        late = threading.Event()

        def end_late() -> None:
            late.set()
            process.kill()

        timer = threading.Timer(self._settings.time_limit_s, end_late)
        timer.daemon = True
        timer.start()
        try:
            return self._ask(process, capture), late.is_set()
        finally:
            timer.cancel()

    def _ask(self, process: subprocess.Popen[bytes], capture: Capture) -> dict[str, Any] | None:
        """The last reply to a request; None where the process ended before that."""
        template = template_of(self._output)
        order = {"output": os.fspath(self._output), "targets": self._settings.targets}
        order["template"] = None if template is None else os.fspath(template)
        request = {
            "function": self._make,
            "arguments": [capture.as_text(), order],
            "log": os.fspath(self._output / LOGS / f"{capture.name}.log"),
            "memory_bytes": self._memory_bytes,
            "threads": 1,
        }
        assert process.stdin is not None
        assert process.stdout is not None
        self._made += 1
        try:
            process.stdin.write(json.dumps(request).encode() + b"\n")
            process.stdin.flush()
            for line in process.stdout:
                reply = json.loads(line)
                if "done" not in reply:
                    return dict(reply)
                self._events.put((capture, reply))
        except (OSError, ValueError):
            pass
        return None

    def _start(self) -> subprocess.Popen[bytes]:
        """The process, a new one where there is none that lives."""
        if self._process is None or self._process.poll() is not None:
            self._end()
            threads = dict.fromkeys(VARIABLES, "1")
            path = os.pathsep.join(filter(None, sys.path))
            self._process = subprocess.Popen(
                [sys.executable, "-m", "app.batch.worker"],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                env={**os.environ, **threads, "PYTHONPATH": path, "PYTHONSAFEPATH": "1"},
                start_new_session=sys.platform != "win32",
            )
            self._made = 0
            if self._stopped:
                self._process.kill()
        return self._process

    def _end(self) -> None:
        """Let the process end, which it does when nobody can ask it any more."""
        process, self._process = self._process, None
        if process is None:
            return
        assert process.stdin is not None
        with contextlib.suppress(OSError):
            process.stdin.close()
        try:
            process.wait(TIDYING_S)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def _describe_end(process: subprocess.Popen[bytes]) -> str:
    """The signal or the code with which a process ended."""
    code = process.wait()
    if code < 0:
        with contextlib.suppress(ValueError):
            return f"signal {signal.Signals(-code).name}"
    return f"exit code {code}"
