"""A batch makes what is missing or has changed, whatever becomes of its processes; here by a fast function."""

from __future__ import annotations

import contextlib
import os
import random
import signal
import sqlite3
import subprocess
import sys
import time
from pathlib import Path

import psutil
import pytest

from app.batch.captures import Capture, find_captures
from app.batch.record import FILE, Row, open_record
from app.batch.run import Settings, make_batch
from engine.core.errors import InputError, OutputError
from engine.core.steps import drain

FAST = "tests.app.batch.fast:make"

PROGRAM = f"""
import sys
from pathlib import Path
from app.batch.captures import find_captures
from app.batch.record import open_record
from app.batch.run import Settings, make_batch
from engine.core.steps import drain
source, output = map(Path, sys.argv[1:])
with open_record(output) as record:
    drain(make_batch(output, record, find_captures([str(source)]), Settings(workers=2), "{FAST}"))
"""


def captures(folder: Path, *names: str) -> Path:
    for name in names:
        (folder / name).mkdir(parents=True)
        for photograph in ("a.png", "b.png"):
            (folder / name / photograph).write_bytes(f"{name} {photograph}".encode())
    return folder


def work(output: Path, source: Path, settings: Settings | None = None) -> list[Row]:
    output.mkdir(exist_ok=True)
    with open_record(output) as record:
        return drain(make_batch(output, record, find_captures([str(source)]), settings or Settings(workers=2), FAST))


def content(output: Path) -> dict[str, bytes]:
    """Files of the results by their names, those left half-written included."""
    return {
        path.relative_to(output).as_posix(): path.read_bytes()
        for path in output.rglob("*")
        if path.is_file() and path.suffix not in (".log", ".sqlite") and not path.name.startswith("report.")
    }


def test_a_run_makes_what_is_missing_or_has_changed(tmp_path: Path) -> None:
    source, output = captures(tmp_path / "source", "one", "two"), tmp_path / "output"
    first = work(output, source)
    assert [(row.capture.name, row.state) for row in first] == [("one", "done"), ("two", "done")]
    before, times = content(output), {name: (output / name).stat().st_ino for name in ("one", "two")}
    captures(source, "three")
    (source / "two" / "a.png").write_bytes(b"another one")
    rows = work(output, source)
    assert [row.state for row in rows] == ["done"] * 3
    assert (output / "one").stat().st_ino == times["one"]
    assert (output / "two").stat().st_ino != times["two"]
    after = content(output)
    assert after["one/result.bin"] == before["one/result.bin"]
    assert after["two/result.bin"] != before["two/result.bin"]
    assert rows[0] == first[0]


def test_a_capture_that_fails_costs_no_other_one(tmp_path: Path) -> None:
    """One is refused, one ends its process, one hangs, one takes all memory, and one meets a mistake of ours."""
    bad = ("crash", "eat", "hang", "mistake", "refuse")
    source, output = captures(tmp_path / "source", *bad, "fine", "well"), tmp_path / "output"
    settings = Settings(workers=3, time_limit_s=12.0, memory_limit_bytes=1 << 30)
    rows = {row.capture.name: row for row in work(output, source, settings)}
    assert {name for name, row in rows.items() if row.state == "done"} == {"fine", "well"}
    reasons = {name: rows[name].reason for name in bad}
    assert "SIGABRT" in reasons["crash"]
    assert "more than 1.07 GB of memory" in reasons["eat"]
    assert "longer than 12 s" in reasons["hang"]
    assert "KeyError" in reasons["mistake"]
    assert reasons["refuse"] == f"{source / 'refuse'}: is <b>no</b> capture. Give another."
    assert "KeyError" in (output / "logs" / "mistake.log").read_text()
    assert set(content(output)) == {
        f"{name}/{file}" for name in ("fine", "well") for file in ("capture.json", "result.bin")
    }


def test_a_run_that_is_closed_stops_its_processes_and_goes_on(tmp_path: Path) -> None:
    source, output = captures(tmp_path / "source", "hang", "one"), tmp_path / "output"
    output.mkdir()
    with open_record(output) as record:
        steps = make_batch(output, record, find_captures([str(source)]), Settings(workers=1), FAST)
        next(step for step in steps if step.partial and step.partial[0].state == "running")
        with pytest.raises(OutputError, match="another run"), open_record(output):
            pass
        steps.close()
        assert [row.state for row in record.rows()] == ["waiting", "waiting"]
    (source / "hang").rename(source / "fine")
    assert {row.capture.name: row.state for row in work(output, source)} == {
        "hang": "waiting",
        "one": "done",
        "fine": "done",
    }


def test_a_record_from_elsewhere_writes_nowhere_else(tmp_path: Path) -> None:
    with open_record(tmp_path) as record:
        record.put([Row(Capture("medal", tmp_path), "failed", reason='"\N{SNOWMAN}"\n')])
        record.put(record.rows())
        assert [row.reason for row in record.rows()] == ['"\N{SNOWMAN}"\n']
    for statement in (
        """UPDATE capture SET row = replace(row, 'medal', '../medal')""",
        "CREATE TRIGGER t AFTER INSERT ON capture BEGIN DELETE FROM choice; END",
        "PRAGMA application_id = 7",
    ):
        with contextlib.closing(sqlite3.connect(tmp_path / FILE)) as connection, connection:
            connection.execute(statement)
        with pytest.raises(InputError, match=r"batch\.sqlite: is"), open_record(tmp_path) as record:
            record.rows()
    (tmp_path / FILE).write_bytes(b"SQLite format 3\0" + 200 * b"?")
    with pytest.raises(InputError, match="is damaged"), open_record(tmp_path):
        pass


@pytest.mark.skipif(os.name == "nt", reason="Windows has no SIGKILL")
@pytest.mark.campaign(rounds=100)
def test_a_run_that_is_killed_goes_on_bit_for_bit(tmp_path: Path, seed: int) -> None:
    """Killed at random moments, its processes too; nothing is lost, doubled or left half-written."""
    draw = random.Random(seed)
    source = captures(tmp_path / "source", *(f"capture {at}" for at in range(8)))
    output = tmp_path / "output"
    output.mkdir()
    for _ in range(3):
        words = [sys.executable, "-c", PROGRAM, str(source), str(output)]
        path = os.pathsep.join(filter(None, sys.path))
        process = subprocess.Popen(words, env={**os.environ, "PYTHONPATH": path}, stderr=subprocess.PIPE)
        time.sleep(draw.uniform(0.1, 1.0))
        with contextlib.suppress(psutil.Error):  # one that has just ended
            for child in psutil.Process(process.pid).children()[: draw.randrange(3)]:
                child.kill()
        time.sleep(draw.uniform(0.0, 1.0))
        process.send_signal(signal.SIGKILL)
        process.wait()
    rows = work(output, source)
    assert sorted((row.capture.name, row.state) for row in rows) == [(f"capture {at}", "done") for at in range(8)]
    other = tmp_path / "at once"
    work(other, source)
    assert content(output) == content(other)
