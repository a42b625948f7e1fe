"""The bench of large captures: lamps of a dome, and disk that no name shows."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from benchmarks.app.hard_limit import hold_memory
from benchmarks.app.large_memory import Peak, _count_failures, _dome, _find, _nameless, _on_disk, large_memory
from engine.capture.lights.sources import find
from engine.core.errors import MissingCapability, UsageError
from engine.core.steps import drain
from engine.storage import scratch

pytestmark = pytest.mark.skipif(not Path("/proc/self/maps").exists(), reason="this system does not tell mapped files")


def test_photographs_of_a_dome_come_with_their_lamps(tmp_path: Path) -> None:
    drain(_dome(tmp_path / "dome", 16, 24, 12))
    sources = find([tmp_path / "dome"])
    assert len(sources.photographs) == 12
    assert sources.azimuth is not None
    assert len(np.unique(np.round(sources.azimuth, 3))) == 12
    assert np.degrees(sources.elevation).min() > 10


def test_fewer_than_ten_photographs_are_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="takes 10 or more"):
        drain(large_memory(tmp_path, [1.0], photographs=9))


def test_disk_counts_files_with_a_name_and_mapped_ones_without(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(scratch, "IN_MEMORY_BYTES", 0)
    before = _nameless(os.getpid())
    array = scratch.scratch_array((1 << 20,), np.uint8)
    assert _nameless(os.getpid()) - before == array.nbytes
    del array
    assert _nameless(os.getpid()) == before
    (tmp_path / "named").write_bytes(bytes(1 << 16))
    assert _on_disk(tmp_path) == 1 << 16


def test_a_verb_that_fails_is_told_with_its_message() -> None:
    peaks = [Peak(2 << 20, 1 << 20, 0, 1.0), Peak(6 << 20, 2 << 20, 0, 2.0, "could not be measured: no room")]
    found = _find("shade", 16, [1.0, 2.0], peaks, 2.0**30, 4 << 20)
    assert (found.more["ended"], found.more["peak_of_limit"]) == (0, 1.5)
    assert found.more["slope_bytes_per_pixel"] == pytest.approx(4 * 1.048576)
    failures = _count_failures("shade", [1.0, 2.0], peaks)
    assert (failures.error, failures.bound) == (1.0, 0.0)
    assert "2 megapixels: could not be measured: no room" in failures.what
    assert _find("shade", 16, [1.0], peaks[:1], 2.0**30, None).more["ended"] == 1


def test_the_system_holds_a_limit() -> None:
    """A process that needs less than the limit ends well, also when it reads more of files; one that needs more is
    ended, and counted."""
    program = "import sys; kept = bytearray(int(sys.argv[1])); print(len(kept))"
    try:
        with hold_memory(60_000_000) as (within, count_ended):
            for size, ends in ((10_000_000, True), (200_000_000, False)):
                done = subprocess.run(
                    [*within, sys.executable, "-c", program, str(size)], capture_output=True, check=False
                )
                assert (done.returncode == 0) == ends
            assert count_ended() == 1
            left = "import subprocess; subprocess.Popen(['sleep', '60'])"
            subprocess.run([*within, sys.executable, "-c", left], check=True)  # which ends with the group
    except MissingCapability as error:
        pytest.skip(str(error))


def test_a_hard_limit_needs_a_limit(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="--limit"):
        drain(large_memory(tmp_path, [1.0], hard_limit=True))
