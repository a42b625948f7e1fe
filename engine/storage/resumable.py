"""Files that take minutes to make: written piece by piece, and kept beside their target when that ends early.

The file lies under a hidden name by which the next run finds it, and goes on with it. One process at a time writes it:
it holds a lock from before the first byte until the file has its own name. A process that opens the file just before
it gets its name, and locks it just after, would write into the result of the other: so whoever has the lock looks
whether the file is still called as before, and tries again where it is not.
"""

from __future__ import annotations

import errno
import os
import stat
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING

from engine.core.errors import OutputError
from engine.storage import atomic
from engine.storage.partial_names import LONGEST_NAME_BYTES

if TYPE_CHECKING:
    from _typeshed import ReadableBuffer


@contextmanager
def resumable_file(path: atomic.AnyPath, size_bytes: int, beginning: bytes) -> Iterator[Resumable]:
    """A file of `size_bytes` that starts with `beginning`, written piece by piece in any order.

    It appears at `path` when the block ends without an exception. Until then it lies beside `path` under a hidden name.
    If the process is killed, or the block fails while `Resumable.worth_keeping`, it stays there, and a later call with
    the same `beginning` and size goes on with it. After `Resumable.discard` it is removed instead. OutputError where it
    cannot be written, or another process is writing it.
    """
    target = atomic.target_of(path)
    existing = atomic.replaceable(target, path)
    partial = _make_unfinished_name(target)
    with atomic.standing_for(partial, target), Resumable(partial, size_bytes, beginning) as output:
        yield output
        if not output.discarded:
            output.synchronise()
            output.release_on_windows()
            atomic.put_file(partial, target, existing)


def find_unfinished(path: atomic.AnyPath) -> Path | None:
    """Unfinished file that a `resumable_file` for `path` left when it ended early; None if there is none."""
    partial = _make_unfinished_name(atomic.spell(path))
    return partial if partial.is_file() and not partial.is_symlink() else None


def discard_unfinished(path: atomic.AnyPath) -> None:
    """Remove what a `resumable_file` for `path` left when it ended early; OutputError where that cannot be."""
    partial = find_unfinished(path)
    if partial is None:
        return
    with atomic.standing_for(partial, atomic.spell(path)):
        descriptor = _open_locked(partial)
        try:
            if sys.platform != "win32":
                atomic.perform("unlink", partial, partial.unlink)
        finally:
            atomic.close(descriptor, partial)
        if sys.platform == "win32":
            atomic.perform("unlink", partial, partial.unlink)


class Resumable:
    """A file of fixed size that this process alone writes, see `resumable_file`; `resumed` tells an earlier one.

    `worth_keeping` says whether it stays when it ends early; at first only what was resumed does.
    """

    def __init__(self, path: Path, size_bytes: int, beginning: bytes) -> None:
        self._path = path
        self._descriptor: int | None = _open_locked(path)
        self.discarded = False
        self.resumed = self.worth_keeping = True
        try:
            same = os.fstat(self._descriptor).st_size == size_bytes
            self.resumed = self.worth_keeping = same and self.read_at(0, len(beginning)) == beginning
            if not self.resumed:
                self._begin(size_bytes, beginning)
        except BaseException as error:
            self.__exit__(error)
            raise

    def write_at(self, offset: int, data: ReadableBuffer) -> None:
        """Write `data` at `offset`."""
        left = memoryview(data).cast("B")
        while left:
            with atomic.explaining(self._path, needed_bytes=len(left)):
                limit = atomic.fault("write", self._path) if atomic.fault is not None else None
                os.lseek(self._open, offset, os.SEEK_SET)
                written = os.write(self._open, left[:limit])
            left, offset = left[written:], offset + written

    def read_at(self, offset: int, count: int) -> bytes:
        """`count` bytes from `offset`, fewer at the end of the file."""
        with atomic.explaining(self._path):
            os.lseek(self._open, offset, os.SEEK_SET)
            parts = []
            while count > 0 and (part := os.read(self._open, count)):
                parts.append(part)
                count -= len(part)
        return b"".join(parts)

    def discard(self) -> None:
        """Let the file vanish when the block ends: what it held has become something else."""
        self.discarded = True

    def synchronise(self) -> None:
        """Flush what was written to the disk, and let a system that complains when a file is closed do so."""
        atomic.perform("fsync", self._path, lambda: os.fsync(self._open))
        atomic.close(atomic.perform("open", self._path, lambda: os.dup(self._open)), self._path)

    def release_on_windows(self) -> None:
        """Close the file where an open one can be neither renamed nor removed; elsewhere the lock must last longer."""
        if sys.platform == "win32":
            self._close()

    def __enter__(self) -> Resumable:
        return self

    def __exit__(self, error: object, *_: object) -> None:
        try:
            if self.discarded or (error is not None and not self.worth_keeping):
                self.release_on_windows()
                if self._descriptor is None or _is_called(self._descriptor, self._path):
                    atomic.discard(self._path)
        finally:
            self._close()

    @property
    def _open(self) -> int:
        assert self._descriptor is not None
        return self._descriptor

    def _close(self) -> None:
        descriptor, self._descriptor = self._descriptor, None
        if descriptor is not None:
            atomic.close(descriptor, self._path)

    def _begin(self, size_bytes: int, beginning: bytes) -> None:
        """All blocks at once where the system can, so that a full disk is known before the work."""
        with atomic.explaining(self._path, needed_bytes=size_bytes):
            os.ftruncate(self._open, 0)
            if size_bytes > atomic.free_bytes(self._path.parent):
                raise OSError(errno.ENOSPC, "")
            if hasattr(os, "posix_fallocate"):
                os.posix_fallocate(self._open, 0, size_bytes)
            else:
                os.ftruncate(self._open, size_bytes)
        self.write_at(0, beginning)


def _make_unfinished_name(target: Path) -> Path:
    return target.with_name(f".{target.name[: LONGEST_NAME_BYTES // 4]}.unfinished")


def _open_locked(path: Path) -> int:
    """A descriptor of the file `path`, old or new, that no other process has."""
    while True:
        descriptor, made = atomic.perform("create", path, lambda: _open(path))
        try:
            held = atomic.perform("lock", path, lambda descriptor=descriptor: _lock(descriptor, path))  # type: ignore[misc]
            ours = held and _is_called(descriptor, path)
        except BaseException:
            if made:
                atomic.discard(path)
            atomic.close(descriptor, path)
            raise
        if ours:
            return descriptor
        atomic.close(descriptor, path)
        if not held:
            named = atomic.as_named(path)
            raise OutputError(named, "another run is writing it", "Wait for that run or choose another name")


def _open(path: Path) -> tuple[int, bool]:
    """A descriptor of the file `path`, and True where there was none before."""
    flags = os.O_RDWR | getattr(os, "O_BINARY", 0) | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0)
    while True:
        with suppress(FileExistsError):
            return os.open(path, flags | os.O_CREAT | os.O_EXCL, 0o666), True
        with suppress(FileNotFoundError):  # it got its name, or was removed, in between
            return os.open(path, flags), False


def _lock(descriptor: int, path: Path) -> bool:
    """Lock an open file, until it is closed; False where another process has."""
    if not stat.S_ISREG(os.fstat(descriptor).st_mode):
        raise OutputError(path, "it is not a regular file", "Remove it")
    if sys.platform == "win32":
        return True  # a file that is open cannot be renamed there, so a second writer fails at its end
    import fcntl

    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True


def _is_called(descriptor: int, path: Path) -> bool:
    """True while the open file lies at `path`, and no other one does."""
    try:
        return os.path.samestat(os.fstat(descriptor), path.lstat())
    except FileNotFoundError:
        return False
