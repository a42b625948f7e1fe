"""The measure of how long verbs take to end when they are asked to."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from benchmarks.app import cancel
from benchmarks.command import ACCURACIES, LARGE, OPTIONS
from engine.core.steps import drain

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such signals")

SLOW_TO_END = """
import signal, sys, time
def end(*_):
    time.sleep(0.3)
    sys.exit(4)
signal.signal(signal.SIGTERM, end)
print(flush=True)
time.sleep(60)
"""
QUICK = "print(flush=True)"


def test_it_waits_for_the_end_and_counts_exit_codes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def start(words: list[str]) -> subprocess.Popen[bytes]:
        """A process that heeds signals from its first line on."""
        program = {"slow": SLOW_TO_END, "quick": QUICK, "wrong": "raise SystemExit(2)"}[words[0]]
        process = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE)
        assert process.stdout is not None
        process.stdout.readline()
        return process

    monkeypatch.setattr(cancel, "_start", start)
    monkeypatch.setattr(cancel, "LIFE_S", 0.2)
    (slow,) = drain(cancel.cancel(tmp_path / "slow", runs=3, lines={"slow": "slow"}))
    assert slow.error >= 0.3
    assert slow.what.endswith("3 ended: 3 with 4")
    assert slow.bound == cancel.BOUND_S
    monkeypatch.setattr(cancel, "_life_s", lambda *_: 30.0)
    (quick,) = drain(cancel.cancel(tmp_path / "quick", runs=2, seed=5, lines={"quick": "quick"}))
    assert (quick.error, quick.what.rpartition("; ")[2]) == (0.0, "2 ended: 2 with 0")


def test_a_line_that_fails_by_itself_is_no_measure(tmp_path: Path) -> None:
    with pytest.raises(RuntimeError, match="ended with exit code 2"):
        drain(cancel.cancel(tmp_path, runs=1, lines={"wrong": "brdf nonsense"}))


def test_lines_name_every_verb_without_a_display() -> None:
    from app.command_line import VERBS

    # a window, files that are written in no time, and a watch, which a signal has import what is there
    short = {"gui", "project", "completion", "desktop-install", "watch"}
    assert {line.split()[0] for line in cancel.MEASURED.values()} == {name for name, _, _ in VERBS} - short


def test_options_belong_to_groups_that_exist() -> None:
    assert set(OPTIONS) <= set(ACCURACIES)
    assert "cancel" in LARGE
