"""The soak of the window counts what dies, and keeps what each run said."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import IO

import pytest

from app.bench import soak
from engine.core.steps import drain

SOUND = """print('{"seed": 1, "warm": {"descriptors": 9}, "end": {"descriptors": 11}}')"""
DYING = "import os, signal; os.kill(os.getpid(), signal.SIGSEGV)"


@pytest.mark.skipif(sys.platform == "win32", reason="processes there do not die of signals")
def test_a_run_that_dies_is_counted_and_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def start(_run_s: float, seed: int, said: IO[bytes]) -> subprocess.Popen[bytes]:
        return subprocess.Popen([sys.executable, "-c", DYING if seed == 2 else SOUND], stdout=said)

    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setattr(soak, "_start", start)
    monkeypatch.setattr(soak, "GROWING", (("descriptors", ""),))
    died, descriptors = drain(soak.window_soak(tmp_path, runs=3, run_s=0.0))
    assert died.error == 1
    assert descriptors.error == 2
    kept = [json.loads(line) for line in (tmp_path / "soak.jsonl").read_text().splitlines()]
    assert sorted(record["exit_code"] for record in kept) == [-11, 0, 0]
