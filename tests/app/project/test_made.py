"""Results beside a project, and arrays as they lie there."""

from __future__ import annotations

import io
import tracemalloc
from pathlib import Path

import numpy as np
import pytest

from app.project.made import keep_newest
from app.project.values import array_from, array_parts
from engine.storage import atomic

ARRAYS = (
    np.zeros((3, 4), np.float32),
    np.ones(()),
    np.zeros((0, 3)),
    np.arange(12).reshape(3, 4).T,
    np.zeros(5, bool),
    np.zeros((2, 2), ">f4"),
    np.asfortranarray(np.ones((3, 5), np.float16)),
)


@pytest.mark.parametrize("array", ARRAYS, ids=lambda array: f"{array.dtype.str}{array.shape}")
def test_arrays_are_npy_files_bit_for_bit(array: np.ndarray) -> None:
    """So that projects of earlier versions keep the names of their arrays."""
    expected = io.BytesIO()
    np.lib.format.write_array(expected, np.ascontiguousarray(array).reshape(array.shape), allow_pickle=False)
    header, numbers = array_parts(array)
    assert header + bytes(numbers) == expected.getvalue()
    again = array_from(expected.getvalue())
    assert (again.dtype, again.shape, again.flags.writeable) == (array.dtype, array.shape, False)
    assert np.array_equal(again, array)


@pytest.mark.parametrize(
    "damage", [lambda c: c[:-1], lambda c: c + b"\0", lambda c: c[:40], lambda c: b"", bytes.upper]
)
def test_damaged_arrays_are_refused(damage: object) -> None:
    header, numbers = array_parts(np.arange(6.0))
    with pytest.raises(ValueError, match=r"."):
        array_from(damage(header + bytes(numbers)))  # type: ignore[operator]
    with pytest.raises(ValueError, match="objects"):
        array_parts(np.array([None]))


def test_an_array_is_taken_apart_and_read_without_a_copy() -> None:
    array = np.ones(1 << 22)
    tracemalloc.start()
    header, numbers = array_parts(array)
    content = b"".join((header, numbers))
    before = tracemalloc.get_traced_memory()[0]
    assert array_from(content).sum() == array.sum()
    assert tracemalloc.get_traced_memory()[1] - before < array.nbytes / 2
    tracemalloc.stop()


def test_a_result_that_is_removed_is_never_there_in_part(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever operation is the last: the folder of a run is whole, or has no name of a run."""
    for last in range(1, 8):
        for name in ("old", "new"):
            for file in ("a", "b", "c"):
                (tmp_path / f"factors-{name}").mkdir(exist_ok=True)
                (tmp_path / f"factors-{name}" / file).write_bytes(b"x")
        (tmp_path / "factors-old").touch()
        left = [last]

        def fault(_operation: str, _path: Path, left: list[int] = left) -> None:
            left[0] -= 1
            if left[0] < 0:
                raise OSError("killed")

        monkeypatch.setattr(atomic, "fault", fault)
        keep_newest(tmp_path, "factors-*", 1)
        monkeypatch.setattr(atomic, "fault", None)
        assert all(len(list(place.iterdir())) == 3 for place in tmp_path.glob("factors-*"))
        atomic.remove_leftovers(tmp_path)
