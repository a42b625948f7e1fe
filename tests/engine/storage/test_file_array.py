"""Arrays that are read from files piece by piece: the same entries as in memory, and sentences instead of signals."""

from __future__ import annotations

import os
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import psutil
import pytest

from engine.core.errors import InputError
from engine.storage.file_array import FileArray

VALUES = np.random.default_rng(0).random((5, 400, 7, 3)).astype(np.float32)


@pytest.fixture
def array(tmp_path: Path) -> FileArray:
    path = tmp_path / "values.npy"
    np.save(path, VALUES)
    return FileArray(path, VALUES.shape, VALUES.dtype, 128, path.stat())


@pytest.mark.parametrize(
    "key",
    [
        np.s_[:],
        np.s_[-1],
        np.s_[np.int64(2)],
        np.s_[1:4],
        np.s_[::2],
        np.s_[[3, 0, 3]],
        np.s_[np.array([4, 1]), 100:300],
        np.s_[:, 17],
        np.s_[3, -2],
        np.s_[3, 5, 6],
        np.s_[3, 5, 6, 1],
        np.s_[:, 3:900, 2:5, 0],
        np.s_[2, :, :, 1],
        np.s_[2:2],
        np.s_[:, 400:],
        np.s_[2, 1::4],
        np.s_[::2, 3:399:44, 1:, 2],
    ],
)
def test_indexing_gives_what_numpy_gives(array: FileArray, key: Any) -> None:
    part = array[key]
    assert part.shape == VALUES[key].shape
    assert np.array_equal(part, VALUES[key])


@pytest.mark.parametrize("key", [5, -6, np.s_[0, 400], ..., np.s_[..., 0], np.s_[0, ::-2], np.s_[None]])
def test_other_keys_are_refused_loudly(array: FileArray, key: Any) -> None:
    with pytest.raises(IndexError):
        array[key]


def test_planes_come_one_after_the_other(array: FileArray) -> None:
    assert (len(array), array.ndim) == (5, 4)
    assert np.array_equal(list(array), VALUES)


def test_a_file_that_is_cut_short_is_named_where_it_ends(array: FileArray) -> None:
    os.truncate(array.path, 128 + VALUES[:3].nbytes - 1)
    assert np.array_equal(array[1], VALUES[1])
    for key in (2, slice(None), np.s_[:, -1]):
        with pytest.raises(InputError, match=r"values\.npy: was cut short while it was open"):
            array[key]


def test_a_file_that_is_gone_or_replaced_is_named(array: FileArray) -> None:
    other = array.path.with_name("other.npy")
    np.save(other, VALUES + 1)
    os.utime(other, ns=(0, 0))
    other.replace(array.path)
    with pytest.raises(InputError, match="was replaced by another file"):
        array[0]
    array.path.unlink()
    with pytest.raises(InputError, match="cannot be read any more"):
        array[0]


def test_a_file_whose_number_or_time_alone_changes_is_the_same(array: FileArray) -> None:
    copy = array.path.with_name("copy.npy")
    shutil.copy2(array.path, copy)
    copy.replace(array.path)
    assert np.array_equal(array[1], VALUES[1])
    again = FileArray(array.path, array.shape, array.dtype, array.offset_bytes, array.path.stat())
    os.utime(array.path, ns=(0, 0))
    assert np.array_equal(again[1], VALUES[1])


@pytest.mark.skipif(not hasattr(psutil.Process, "num_fds"), reason="descriptors are not counted here")
def test_nothing_stays_open_between_reads(array: FileArray) -> None:
    before = psutil.Process().num_fds()
    kept = [array[2] for _ in range(3)]
    assert psutil.Process().num_fds() == before
    assert len(kept) == 3
