"""Arrays in a file that nobody sees."""

from __future__ import annotations

import errno
from pathlib import Path
from typing import Any, cast
from unittest.mock import Mock

import numpy as np
import pytest

from engine.core.errors import OutputError
from engine.storage import scratch
from engine.storage.scratch import release, scratch_array


def test_small_arrays_stay_in_memory(tmp_path: Path) -> None:
    array = scratch_array((3, 4), np.float32, tmp_path)
    assert type(array) is np.ndarray
    assert array.shape == (3, 4)
    assert not array.any()
    release(array)


def test_large_arrays_lie_in_a_file_without_a_name_and_survive_release(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(scratch, "IN_MEMORY_BYTES", 100)
    array = scratch_array((1000, 7), np.float32, tmp_path)
    assert isinstance(array, np.memmap)
    assert list(tmp_path.iterdir()) == []
    assert not array.any()
    array[...] = np.arange(7000).reshape(1000, 7)
    release(array)
    assert np.array_equal(array.ravel(), np.arange(7000))


def test_a_full_disk_is_reported_before_anything_is_computed(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    def full(*_: Any) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(scratch, "IN_MEMORY_BYTES", 100)
    monkeypatch.setattr(cast(Any, scratch).os, "posix_fallocate", full, raising=False)
    with pytest.raises(OutputError, match=r"no room for 4\.19 MB"):
        scratch_array((1024, 1024), np.float32, tmp_path)


def test_without_preallocation_the_file_is_filled_instead(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(scratch, "IN_MEMORY_BYTES", 100)
    monkeypatch.delattr(cast(Any, scratch).os, "posix_fallocate", raising=False)
    array = scratch_array((5000, 1001), np.float32, tmp_path)
    assert array.shape == (5000, 1001)
    array[-1] = 1
    assert array[-1, -1] == 1


@pytest.mark.parametrize(("free_bytes", "chosen"), [(80_000, "system"), (79_999, "stack")])
def test_large_arrays_lie_on_the_system_s_disk_while_it_has_room(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, free_bytes: int, chosen: str
) -> None:
    for name in ("system", "stack"):
        (tmp_path / name).mkdir()
    used: list[Any] = []
    make = cast(Any, scratch).tempfile.TemporaryFile
    monkeypatch.setattr(scratch, "IN_MEMORY_BYTES", 100)
    monkeypatch.setattr(cast(Any, scratch).tempfile, "gettempdir", lambda: str(tmp_path / "system"))
    monkeypatch.setattr(
        cast(Any, scratch).tempfile, "TemporaryFile", lambda dir: cast(Any, used).append(dir) or make(dir=dir)
    )
    monkeypatch.setattr(cast(Any, scratch).shutil, "disk_usage", lambda _: type("Usage", (), {"free": free_bytes}))
    scratch_array((100, 100), np.float32, tmp_path / "stack")
    assert used == [tmp_path / chosen]


def test_a_folder_that_cannot_be_written_gives_way_to_the_temporary_one(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(scratch, "IN_MEMORY_BYTES", 100)
    array = scratch_array((100, 100), np.float32, tmp_path / "absent")
    array[0] = 1
    assert array[0].all()


def test_contents_by_name_lie_in_a_file_beyond_what_memory_may_hold(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(scratch, "IN_MEMORY_BYTES", 100)
    files = scratch.ScratchFiles()
    for name, content in (("a", b"1" * 60), ("b", b"2" * 60), ("a", b"3" * 5)):
        files.put(name, content)
    assert dict(files) == {"a": b"3" * 5, "b": b"2" * 60}
    file = cast(Any, files._contents._file)
    assert file._rolled
    monkeypatch.setattr(file, "write", Mock(side_effect=OSError(errno.ENOSPC, "full")))
    with pytest.raises(OutputError, match=r"no room for 3 B .*full.* are free"):
        files.put("c", b"abc")


def test_contents_by_number_are_those_that_were_put_last(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(scratch, "IN_MEMORY_BYTES", 100)
    rows = scratch.ScratchRows(4)
    for number, content in ((3, b"1" * 60), (0, b""), (1, b"2" * 60), (3, b"3" * 5)):
        rows.put(number, content)
    assert dict(rows) == {0: b"", 1: b"2" * 60, 3: b"3" * 5}
    assert len(rows) == 3
    for missing in (2, 4, -1):
        with pytest.raises(KeyError):
            rows[missing]
