"""Arrays beside a project: large ones are mapped and keep their name, small ones are read and checked."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from app.project import arrays
from app.project.arrays import Mapped, array_name, damaged, find_beside, folder_of, keep_beside
from app.project.values import Absent, array_parts, name_of
from engine.core.steps import drain


@pytest.fixture
def numbers(monkeypatch: pytest.MonkeyPatch) -> np.ndarray:
    """Large enough to be mapped."""
    monkeypatch.setattr(arrays, "MAPPED_BYTES", 1 << 12)
    return np.random.default_rng(3).normal(size=(40, 30, 3)).astype(np.float32)


def owner(array: np.ndarray) -> object:
    base: object = array
    while isinstance(base, np.ndarray):
        base = base.base
    return base


def test_a_large_array_is_mapped_and_is_named_without_being_read(
    numbers: np.ndarray, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    name = keep_beside(tmp_path, numbers)
    assert name == name_of(*array_parts(numbers))
    found = find_beside(tmp_path, name)
    assert isinstance(owner(found), Mapped)
    assert np.array_equal(found, numbers)
    assert not found.flags.writeable
    with monkeypatch.context() as patch:
        patch.setattr(arrays, "name_of", lambda *_: pytest.fail("it was hashed"))
        assert array_name(found) == array_name(found.view()) == name
        assert keep_beside(tmp_path, found) == name
    for part in (found[1:], found[..., 0], found.reshape(-1), found.view(np.int32), found[::-1]):
        assert array_name(part) == name_of(*array_parts(part)) != name


def test_an_array_whose_file_was_removed_is_written_again_from_what_is_mapped(
    numbers: np.ndarray, tmp_path: Path
) -> None:
    name = keep_beside(tmp_path, numbers)
    found = find_beside(tmp_path, name)
    (folder_of(tmp_path) / f"{name}.npy").unlink()
    with pytest.raises(Absent):
        find_beside(tmp_path, name)
    assert keep_beside(tmp_path, found) == name
    assert np.array_equal(find_beside(tmp_path, name), numbers)


def test_damage_is_found_at_once_in_small_arrays_and_by_verification_in_all(
    numbers: np.ndarray, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    small = np.arange(5.0)
    names = [keep_beside(tmp_path, array) for array in (small, numbers)]
    assert drain(damaged(tmp_path)) == []
    for name in names:
        path = folder_of(tmp_path) / f"{name}.npy"
        content = bytearray(path.read_bytes())
        content[-1] ^= 1
        path.write_bytes(content)
    with pytest.raises(Absent):
        find_beside(tmp_path, names[0])
    assert drain(damaged(tmp_path)) == sorted(f"{name}.npy" for name in names)


def test_a_drive_that_may_be_unplugged_is_read(
    numbers: np.ndarray, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(arrays, "_lasting_drives", set)
    found = find_beside(tmp_path, keep_beside(tmp_path, numbers))
    assert not isinstance(owner(found), Mapped)
    assert np.array_equal(found, numbers)
