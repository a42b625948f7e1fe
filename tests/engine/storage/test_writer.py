"""Writers in names of files: who lives, who is gone, and who has ended without anybody having asked."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from engine.storage.writer import is_gone, is_own, writer

#: A program that says its writer and waits.
WAITS = "from engine.storage.writer import writer; print(writer(), flush=True); input()"


def test_a_process_knows_its_own_and_that_it_lives(tmp_path: Path) -> None:
    path = tmp_path / f"open-{writer()}"
    path.touch()
    assert is_own(path)
    assert not is_gone(path)


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux keeps processes whose end nobody has asked for so long")
def test_a_killed_process_is_gone_also_where_its_parent_never_asks(tmp_path: Path) -> None:
    """Otherwise a project stays read-only after a crash for as long as the parent lives: in a container, for ever."""
    with subprocess.Popen([sys.executable, "-c", WAITS], stdin=subprocess.PIPE, stdout=subprocess.PIPE) as other:
        assert other.stdout is not None
        path = tmp_path / f"open-{other.stdout.readline().decode().strip()}"
        path.touch()
        assert not is_own(path)
        assert not is_gone(path)
        os.kill(other.pid, signal.SIGKILL)
        end = time.monotonic() + 60.0
        while not is_gone(path) and time.monotonic() < end:
            time.sleep(0.01)
        assert Path(f"/proc/{other.pid}").exists(), "it has ended and was not asked"
        assert is_gone(path)
    assert is_gone(path)
