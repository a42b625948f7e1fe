"""The soak of the window counts what dies, and keeps what each run said."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import IO

import pytest

from benchmarks.app import soak
from engine.core.steps import drain

SOUND = (
    """print('{"seed": 1, "did": {"turn": 7}, "warm": {"descriptors": 9, "memory_mb": 290}, """
    """"end": {"descriptors": 11, "memory_mb": 300}}')"""
)
DYING = "import os, signal; os.kill(os.getpid(), signal.SIGSEGV)"


@pytest.mark.skipif(sys.platform == "win32", reason="processes there do not die of signals")
def test_a_run_that_dies_is_counted_and_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def start(_run_s: float, seed: int, said: IO[bytes]) -> subprocess.Popen[bytes]:
        return subprocess.Popen([sys.executable, "-c", DYING if seed == 2 else SOUND], stdout=said)

    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setattr(soak, "_start", start)
    monkeypatch.setattr(soak, "GROWING", (("descriptors", ""),))
    died, descriptors, held = drain(soak.window_soak(tmp_path, runs=3, run_s=0.0, at_once=1))
    assert died.error == 1
    assert "14 actions" in died.what
    assert descriptors.error == 2
    assert held.error == 300
    kept = [json.loads(line) for line in (tmp_path / "soak.jsonl").read_text().splitlines()]
    assert sorted(record["exit_code"] for record in kept) == [-11, 0, 0]
