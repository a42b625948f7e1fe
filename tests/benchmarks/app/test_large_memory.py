"""The bench of large captures: lamps of a dome, and disk that no name shows."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

from benchmarks.app.large_memory import _dome, _nameless, _on_disk, large_memory
from engine.capture.lights.sources import find
from engine.core.errors import UsageError
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
