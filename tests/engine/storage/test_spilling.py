"""Large arrays in files while memory is limited: the same numbers, gone with the array, and plainly refused."""

from __future__ import annotations

import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import psutil
import pytest

from engine.core.errors import OutputError
from engine.storage import scratch, spilling
from engine.storage.spilling import count_spilled_bytes, spill_arrays

pytestmark = pytest.mark.skipif(
    not spilling.is_possible(scratch.temporary_folder()), reason="arrays stay in memory on this system"
)

#: Less than the process takes already, so that all large arrays lie in files.
LIMIT = 16 << 20


def _resident() -> int:
    return psutil.Process().memory_info().rss


def _compute(seed: int) -> np.ndarray:
    values = np.random.default_rng(seed).random((512, 1024))
    return np.sort(np.sqrt(values) @ values.T, axis=0) + np.zeros((512, 512))


def test_arrays_lie_in_files_as_long_as_they_live_with_the_same_numbers() -> None:
    plain, before = _compute(1), count_spilled_bytes()
    with spill_arrays(1 << 40):
        few = np.ones(1 << 18)
        assert count_spilled_bytes() == before
    with spill_arrays(LIMIT):
        found = [_compute(1), _compute(1)]
        small = [np.arange(count) for count in range(1000)]
    assert count_spilled_bytes() - before >= found[1].nbytes
    assert all(np.array_equal(each, plain) for each in found)
    assert few.sum() == 1 << 18
    assert sum(len(each) for each in small) == 499500
    del few, found
    assert count_spilled_bytes() == before
    assert np.ones(1 << 20).sum() == 1 << 20
    assert count_spilled_bytes() == before


def test_an_array_keeps_its_content_as_it_grows_out_of_memory_and_shrinks() -> None:
    with spill_arrays(LIMIT):
        values = np.arange(100.0)
        for size in (1000, 1 << 19, 1 << 20, 5000, 50):
            values.resize(size, refcheck=False)
            assert np.array_equal(values[:50], np.arange(50.0))
        assert np.fromiter((float(each) for each in range(300_000)), np.float64).sum() == 299_999 * 150_000


def test_files_of_arrays_that_are_gone_serve_the_next_ones() -> None:
    with spill_arrays(16 * LIMIT):
        spilling._table[0] = 0  # no room in memory, which is noted again every `LOOK_S`
        values = np.full(1 << 20, 7.0)
        place = values.ctypes.data
        del values
        again = [np.empty(1 << 20), np.empty(1 << 20)]
        assert again[0].ctypes.data == place != again[1].ctypes.data
        del again
        zeros = [np.zeros(1 << 20) for _ in range(2)]
        assert not any(each.any() for each in zeros)
        assert place in (each.ctypes.data for each in zeros)
        del zeros
        assert np.ones(1 << 19).sum() == 1 << 19
        assert _count_spare() > 0
    assert _count_spare() == 0
    with spill_arrays(LIMIT):
        for size in range(1 << 18, 1 << 19, 1 << 15):
            np.ones(size)
        assert _count_spare() <= spilling.SPARE_PART * LIMIT


def _count_spare() -> int:
    rows = np.ctypeslib.as_array(spilling._table).reshape(-1, 3)[2:]
    return int(rows[(rows[:, 0] != 0) & (rows[:, 2] == spilling._SPARE), 1].sum())


def test_threads_that_do_not_ask_for_it_keep_their_arrays_in_memory() -> None:
    before = count_spilled_bytes()
    with spill_arrays(LIMIT), ThreadPoolExecutor(1) as pool:
        other = pool.submit(np.ones, 1 << 21).result()
        assert count_spilled_bytes() == before
    del other


def test_pages_are_given_back_while_the_process_has_more_than_its_limit() -> None:
    with spill_arrays(LIMIT):
        patience_s, before = 20.0, _resident()
        values = np.arange(1 << 23)
        while _resident() > before + values.nbytes // 2 and patience_s > 0.0:
            time.sleep(0.02)
            patience_s -= 0.02
        assert patience_s > 0.0
        assert np.array_equal(values[:: 1 << 20], np.arange(8) << 20)
    assert spilling._count_resident(1 << 30) == 0  # a process that has ended


def test_a_disk_without_room_is_told_with_what_is_needed_and_free() -> None:
    with pytest.raises(OutputError, match=r"no room for 9,007 TB .*No space left.* are free\)"), spill_arrays(LIMIT):
        np.empty(1 << 50)
    with pytest.raises(MemoryError), spill_arrays(LIMIT):  # of somebody else
        raise MemoryError


def test_the_folder_is_on_a_disk_where_that_for_temporary_files_lies_in_memory(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tempfile.gettempdir", lambda: str(tmp_path))
    assert scratch.temporary_folder() == tmp_path
    read_text = Path.read_text
    mounts = f"none / ext4 rw 0 0\nnone {tmp_path.parent} tmpfs rw 0 0\n"
    monkeypatch.setattr(
        Path, "read_text", lambda path, **more: mounts if path == Path("/proc/mounts") else read_text(path, **more)
    )
    monkeypatch.setattr(scratch, "_ON_DISK", tmp_path / "disk")
    assert scratch.temporary_folder() == tmp_path  # there is no such folder
    (tmp_path / "disk").mkdir()
    assert scratch.temporary_folder() == tmp_path / "disk"
