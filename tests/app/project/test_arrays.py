"""Arrays beside a project: large ones are mapped and keep their name, small ones are read and checked."""

from __future__ import annotations

import errno
import os
import subprocess
import sys
from collections import deque
from pathlib import Path

import numpy as np
import pytest

from app.project import arrays
from app.project.arrays import (
    PACKED,
    array_name,
    compress,
    file_of,
    find_beside,
    find_problems,
    folder_of,
    keep_beside,
)
from app.project.values import Absent, array_parts, name_of
from app.session import cache
from engine.core.errors import InputError
from engine.core.steps import drain
from engine.storage.atomic import discard
from engine.storage.guarded import GuardedMapping, is_possible
from engine.storage.packed import pack


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
    assert isinstance(owner(found), GuardedMapping)
    assert np.array_equal(found, numbers)
    assert not found.flags.writeable
    with monkeypatch.context() as patch:
        patch.setattr(arrays, "name_of", lambda *_: pytest.fail("it was hashed"))
        assert array_name(found) == array_name(found.view()) == name
        assert keep_beside(tmp_path, found) == name
    for part in (found[1:], found[..., 0], found.reshape(-1), found.view(np.int32), found[::-1]):
        assert array_name(part) == name_of(*array_parts(part)) != name


def test_an_array_that_was_removed_is_found_in_the_cache_and_written_again_from_what_is_mapped(
    numbers: np.ndarray, tmp_path: Path
) -> None:
    name = keep_beside(tmp_path, numbers)
    found = find_beside(tmp_path, name)
    file_of(tmp_path, name).unlink()
    assert np.array_equal(find_beside(tmp_path, name), numbers)
    discard(cache.entry(f"array-{name}") or tmp_path)
    with pytest.raises(Absent):
        find_beside(tmp_path, name)
    assert keep_beside(tmp_path, found) == name
    assert np.array_equal(find_beside(tmp_path, name), numbers)


def test_without_its_working_copy_a_large_array_is_unpacked_and_has_one_again(
    numbers: np.ndarray, tmp_path: Path
) -> None:
    name = keep_beside(tmp_path, numbers)
    place = cache.entry(f"array-{name}")
    assert place is not None
    discard(place)
    found = find_beside(tmp_path, name)
    assert isinstance(owner(found), GuardedMapping)
    assert found.tobytes() == numbers.tobytes()
    assert place.is_dir()


def test_projects_of_before_arrays_were_compressed_open_and_are_compressed(numbers: np.ndarray, tmp_path: Path) -> None:
    for array in (numbers, np.arange(5.0)):
        header, content = array_parts(array)
        name = name_of(header, content)
        old = folder_of(tmp_path) / f"{name}.npy"
        old.parent.mkdir(exist_ok=True)
        old.write_bytes(header + bytes(content))
        assert np.array_equal(find_beside(tmp_path, name), array)
        assert keep_beside(tmp_path, find_beside(tmp_path, name)) == name
        assert old.exists()
        compress(tmp_path, name)
        assert not old.exists()
        assert np.array_equal(find_beside(tmp_path, name), array)
    assert drain(find_problems(tmp_path)) == []


def test_damage_is_found_at_once_in_small_arrays_and_by_verification_in_all(
    numbers: np.ndarray, tmp_path: Path
) -> None:
    small = np.arange(5.0)
    names = [keep_beside(tmp_path, array) for array in (small, numbers)]
    assert drain(find_problems(tmp_path)) == []
    for name in names:
        path = file_of(tmp_path, name)
        content = bytearray(path.read_bytes())
        content[40] ^= 1
        path.write_bytes(content)
    with pytest.raises(Absent):
        find_beside(tmp_path, names[0])
    assert drain(find_problems(tmp_path)) == [
        f"{name}{PACKED} is damaged, and can be made again" for name in sorted(names)
    ]


def test_an_array_that_the_system_does_not_let_be_read_is_not_called_damaged(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    name = keep_beside(tmp_path, np.arange(5.0))
    assert drain(find_problems(tmp_path)) == []

    def refuse(*_: object) -> int:
        raise PermissionError(errno.EACCES, "Permission denied")

    monkeypatch.setattr(os, "open", refuse)
    assert drain(find_problems(tmp_path)) == [f"{name}{PACKED} cannot be read: Permission denied"]
    with pytest.raises(Absent, match="cannot be read"):
        find_beside(tmp_path, name)


def test_an_array_that_declares_another_size_than_its_shape_has_is_damaged(tmp_path: Path) -> None:
    header, _ = array_parts(np.zeros((1000, 1000)))
    name = keep_beside(tmp_path, np.arange(5.0))
    with file_of(tmp_path, name).open("wb") as file:
        deque(pack(file, [header, bytes(80)], len(header) + 80, 8), maxlen=0)
    with pytest.raises(InputError, match="are not 208 bytes"):
        arrays._unpack(file_of(tmp_path, name))
    with pytest.raises(Absent):
        find_beside(tmp_path, name)


def test_a_drive_that_may_be_unplugged_is_read(
    numbers: np.ndarray, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(arrays, "_lasting_drives", set[int])
    found = find_beside(tmp_path, keep_beside(tmp_path, numbers))
    assert not isinstance(owner(found), GuardedMapping)
    assert np.array_equal(found, numbers)


CUT = """
import dataclasses, gc, os, sys
from pathlib import Path
import numpy as np
from app.document.document import Project
from app.project import arrays
from app.project.project_file import History, Writer, read
from app.session import cache
from engine.core.errors import InputError
from engine.geometry.shapes import shape
from engine.storage import guarded

arrays.MAPPED_BYTES = 1 << 16
plane, count = shape("plane"), 20_000
positions, normals = np.ones((count, 3), np.float32), np.zeros((count, 3), np.float32)
positions[: len(plane.positions)], normals[:, 2] = plane.positions, 1
mesh = dataclasses.replace(plane, positions=positions, normals=normals, uv=np.zeros((count, 2), np.float32))
project, path, other = Project(mesh=mesh), Path("a.lap"), Path("b.lap")
writer = Writer(path)
writer.write(History(project))
writer.close()
for left in (1000, 200_000):
    opened = read(path)
    array = opened.current.mesh.positions
    os.truncate(cache.entry(f"array-{arrays.array_name(array)}") / arrays.CONTENT, left)
    try:
        print(float(array[-1].sum()))
    except InputError as error:
        print(error.problem)
    writer = Writer(other)
    try:
        writer.write(History(opened.current))
    except InputError as error:
        print(error.problem)
    writer.close()
    del opened, array
    gc.collect()
    print(float(read(path).current.mesh.positions[-1].sum()))
    guarded.check()
"""


@pytest.mark.skipif(not is_possible(), reason="this system cannot guard a mapping, and none is made")
def test_a_working_copy_that_is_cut_short_under_an_open_project_costs_nothing(tmp_path: Path) -> None:
    """Nothing is written of what is gone, the process lives, and the project, which is whole, opens again."""
    environment = {**os.environ, "XDG_CACHE_HOME": str(tmp_path / "cache"), "XDG_DATA_HOME": str(tmp_path / "data")}
    code = f"import sys; sys.path.insert(0, {os.fspath(Path(__file__).parents[3])!r})\n{CUT}"
    found = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert found.stdout.splitlines() == [*["was cut short while it was open"] * 2, "3.0"] * 2, found
