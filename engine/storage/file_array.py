"""Arrays in files, read a piece at a time.

They are read and not mapped, because a mapped file that is cut short or whose disk is unplugged ends the process.
Nothing stays open between two reads: arrays that are kept for undo cost no descriptors.
Cost: one copy from the system's cache, about 0.1 s for a gigabyte, and some 20 µs for each read.
"""

from __future__ import annotations

import math
import os
import stat
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from engine.core.errors import InputError

#: A row, counted over all planes, and the array that is filled from there on.
Piece = tuple[int, NDArray[Any]]

_REMEDY, _AGAIN = "Check the disk that it lies on, and open it again", "It is made again from its sources"


@dataclass(frozen=True, eq=False)
class FileArray:
    """A read-only array (N, H, …) of at least two axes, in C order: planes of rows.

    Attributes
    ----------
    path : the file.
    shape, dtype : of the array.
    offset_bytes : where its first entry lies.
    status : `os.fstat` of the file when it was checked; another file of that name is refused. None for a file that may
        come and go, because it can be made again: its size and `header` are checked whenever it is read.
    header : the first `offset_bytes` of the file.
    """

    path: Path
    shape: tuple[int, ...]
    dtype: np.dtype[Any]
    offset_bytes: int
    status: os.stat_result | None
    header: bytes = b""

    @property
    def ndim(self) -> int:
        return len(self.shape)

    @property
    def nbytes(self) -> int:
        return int(np.prod(self.shape, dtype=np.int64)) * self.dtype.itemsize

    def __len__(self) -> int:
        return self.shape[0]

    def __iter__(self) -> Iterator[NDArray[Any]]:
        return (self[plane] for plane in range(len(self)))

    def __getitem__(self, key: Any) -> NDArray[Any]:
        """A copy of what numpy gives for `key`, of which no more than the planes and rows asked for are read.

        Planes are chosen by a number, a slice or a list of numbers, rows by a number or a slice that does not run
        backwards, further axes as in numpy, without an ellipsis or new axes.
        Raises InputError where the file cannot be read, is shorter than it was, or is another one.
        """
        key = key if isinstance(key, tuple) else (key,)
        if any(part is None or part is Ellipsis for part in key):
            raise IndexError("planes and rows are chosen without an ellipsis or new axes")
        of_planes, of_rows, *rest = (*key, slice(None), slice(None))[: max(2, len(key))]
        planes, rows = np.arange(self.shape[0])[of_planes], range(self.shape[1])[of_rows]
        lines = rows if isinstance(rows, range) else range(rows, rows + 1)
        if lines.step < 1:
            raise IndexError("rows are read downwards")
        whole = np.empty((planes.size, len(lines), *self.shape[2:]), self.dtype)
        pieces: list[Piece] = []
        for plane, into in zip(planes.flat, whole, strict=True):
            first = int(plane) * self.shape[1]
            if lines.step == 1:
                pieces.append((first + lines.start, into))
            else:
                pieces += [(first + line, into[at : at + 1]) for at, line in enumerate(lines)]
        self.fill(pieces)
        kept = (len(lines),) if isinstance(rows, range) else ()
        part: NDArray[Any] = whole.reshape(*planes.shape, *kept, *self.shape[2:])
        return part[(*(slice(None),) * (planes.ndim + len(kept)), *rest)] if rest else part

    @property
    def is_there(self) -> bool:
        """True if the file can be read now."""
        try:
            with self._opened():
                return True
        except InputError:
            return False

    def fill(self, pieces: Sequence[Piece]) -> None:
        """Fill arrays (rows, …) from rows on that are counted over all planes."""
        with self.reader() as read:
            for row, into in pieces:
                read(into, row)

    @contextmanager
    def reader(self) -> Iterator[Callable[[NDArray[Any], int], None]]:
        """A function that fills an array from a row on, counted over all planes, while the file is open."""
        with self._opened() as file:
            yield lambda into, row: self._fill(file, into, row)

    @contextmanager
    def _opened(self) -> Iterator[BinaryIO]:
        try:
            flags = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)
            with open(os.open(self.path, flags), "rb", buffering=0) as file:  # noqa: PTH123 - opened by descriptor
                self._check(file)
                yield file
        except OSError as error:
            if self.status is None and isinstance(error, FileNotFoundError):
                raise InputError(self.path, "is not there at the moment", _AGAIN) from None
            problem = f"cannot be read any more ({os.strerror(error.errno or 0)})"
            raise InputError(self.path, problem, _REMEDY) from None

    def _check(self, file: BinaryIO) -> None:
        status = os.fstat(file.fileno())
        if self.status is not None:
            if not _same(self.status, status):
                raise InputError(self.path, "was replaced by another file while it was open", "Open the new one")
            return
        is_whole = stat.S_ISREG(status.st_mode) and status.st_size == self.offset_bytes + self.nbytes
        if not is_whole or file.read(len(self.header)) != self.header:
            raise InputError(self.path, "is damaged", _AGAIN)

    def _fill(self, file: BinaryIO, into: NDArray[Any], row: int) -> None:
        """Read `into` from `row` on, counted over all planes."""
        left = into.reshape(-1).view(np.uint8).data
        file.seek(self.offset_bytes + row * self.dtype.itemsize * math.prod(self.shape[2:]))
        while len(left):
            read = file.readinto(left)  # type: ignore[attr-defined]
            if not read:
                raise InputError(self.path, "was cut short while it was open", _REMEDY)
            left = left[read:]


@dataclass(frozen=True, eq=False)
class Plane:
    """One plane (H, …) of an array in a file, rows of which are read when they are taken."""

    array: FileArray
    index: int

    @property
    def shape(self) -> tuple[int, ...]:
        return self.array.shape[1:]

    @property
    def dtype(self) -> np.dtype[Any]:
        return self.array.dtype

    @property
    def nbytes(self) -> int:
        return self.array.nbytes // len(self.array)

    def __len__(self) -> int:
        return self.array.shape[1]

    def __getitem__(self, rows: slice) -> NDArray[Any]:
        return self.array[self.index, rows]


def _same(before: os.stat_result, now: os.stat_result) -> bool:
    """True if both are of one file: of one number, or changed at one time.

    Either will do, as FAT numbers files anew when it is short of memory, and network disks keep the time late.
    """
    return os.path.samestat(before, now) or before.st_mtime_ns == now.st_mtime_ns
