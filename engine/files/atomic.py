"""The one module through which everything is written: complete or absent, never half.

A result is written beside its target under a hidden partial name, flushed to the disk, renamed over the target, and
the folder entry is flushed as well (Pillai et al. 2014, "All File Systems Are Not Created Equal": the order that
survives a crash at any point). A failure or a closed generator removes the partial; a killed process leaves it, and
the next write into the same folder removes it (`remove_leftovers`). Only what takes minutes to make is kept beside its
target when that ends early, under a name by which the next run finds it (`resumable_file`).

Every operation on the disk passes `_perform`, where a test can make it fail, come up short, or end the process.
Cost: two flushes to the disk for each file, one for each file and folder of a folder.
"""

from __future__ import annotations

import ctypes
import errno
import functools
import io
import json
import os
import re
import secrets
import shutil
import stat
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, BinaryIO, TypeVar, cast

from engine.errors import OutputError

Value = TypeVar("Value")
AnyPath = str | os.PathLike[str]

#: A test puts a function of (operation, path) here. It may raise OSError, end the process, or return the number of
#: bytes that a 'write' shall take. Operations: stat, list, create, open, write, fsync, fsync-dir, chmod, mkdir,
#: rename, unlink, rmdir.
fault: Callable[[str, Path], int | None] | None = None

#: Room demanded before writing, as a multiple of the size where that is known.
HEADROOM = 1.1

_LONGEST_NAME_BYTES = 255
_PARTIAL = re.compile(r"^\..*\.partial-(\d{1,9})-[0-9a-f]{8}(\.[^.]{1,15})?$", re.DOTALL)
_REPLACED = re.compile(r"^\.lightarc-replaced-(\d{1,9})-[0-9a-f]{8}$")
#: Partial names of this process and the targets they stand for.
_in_use: dict[Path, Path] = {}

_CAUSES = {
    errno.ENOSPC: ("the disk is full", "Free some space or choose another disk"),
    errno.EDQUOT: ("your disk quota is used up", "Free some space or choose another disk"),
    errno.EFBIG: ("the file is larger than this file system or account allows", "Choose another disk"),
    errno.EACCES: ("writing here is not permitted", "Choose another folder or change its permissions"),
    errno.EPERM: ("writing here is not permitted", "Choose another folder or change its permissions"),
    errno.EROFS: ("the file system is read-only", "Choose a folder on another disk"),
    errno.EMFILE: ("too many files are open", "Close other files or programs and try again"),
    errno.ENFILE: ("too many files are open", "Close other files or programs and try again"),
    errno.EIO: ("the disk reported an error", "Check the disk, or choose another one"),
    errno.ENAMETOOLONG: ("the name is too long", "Choose a shorter name"),
    errno.ENOENT: ("the folder does not exist", "Create it first or choose another one"),
    errno.ENOTDIR: ("a part of the path is not a folder", "Choose another path"),
    errno.EISDIR: ("it is a folder", "Name a file"),
    errno.ELOOP: ("its symbolic links lead in a circle", "Choose another path"),
    errno.EBUSY: ("it is in use by the system", "Choose another path"),
}


@contextmanager
def atomic_file(path: AnyPath, size_bytes: int | None = None) -> Iterator[BinaryIO]:
    """A binary stream whose content appears at `path` when the block ends without an exception.

    Parameters
    ----------
    path : file to create or to replace; a symbolic link is followed and stays.
    size_bytes : the size where it is known, for which room is demanded before the first byte.

    Raises
    ------
    OutputError : with path, cause, remedy and, on a full disk, needed and free bytes; `path` is then as before.
    """
    with atomic_path(path, size_bytes) as partial:
        output = _Output(partial)
        try:
            yield cast(BinaryIO, output)
        finally:
            output.close()


@contextmanager
def atomic_path(path: AnyPath, size_bytes: int | None = None) -> Iterator[Path]:
    """As `atomic_file`, for libraries that write by name: yields the partial name, with the suffix of `path`."""
    target = _target(path)
    existing = _replaceable(target, path)
    with _partial_beside(target, size_bytes) as partial:
        yield partial
        _synchronise(partial)
        if existing is not None:
            _perform("chmod", partial, lambda: partial.chmod(stat.S_IMODE(existing.st_mode)))
        _perform("rename", partial, lambda: partial.replace(target))
        _synchronise(target.parent)


@contextmanager
def resumable_file(path: AnyPath, size_bytes: int, beginning: bytes) -> Iterator[Resumable]:
    """A file of `size_bytes` that starts with `beginning`, written piece by piece in any order.

    It appears at `path` when the block ends without an exception. Until then, and if the block fails or the process is
    killed, it stays beside `path` under a hidden name, and a later call with the same `beginning` and size goes on with
    it. After `Resumable.discard` it is removed instead. OutputError where it cannot be written, or another process is
    writing it.
    """
    target = _target(path)
    existing = _replaceable(target, path)
    partial = _unfinished_name(target)
    _in_use[partial] = target
    try:
        with Resumable(partial, size_bytes, beginning) as output:
            yield output
            if not output.discarded:
                _synchronise(partial)
                if existing is not None:
                    _perform("chmod", partial, lambda: partial.chmod(stat.S_IMODE(existing.st_mode)))
                _perform("rename", partial, lambda: partial.replace(target))
                _synchronise(target.parent)
        if output.discarded:
            _discard(partial)
    finally:
        _in_use.pop(partial, None)


def _unfinished_name(target: Path) -> Path:
    return target.with_name(f".{target.name[: _LONGEST_NAME_BYTES // 4]}.unfinished")


def unfinished(path: AnyPath) -> Path | None:
    """What a `resumable_file` for `path` left when it ended early; None where there is nothing."""
    partial = _unfinished_name(_spelled(path))
    return partial if partial.is_file() and not partial.is_symlink() else None


def discard_unfinished(path: AnyPath) -> None:
    """Remove what a `resumable_file` for `path` left when it ended early; OutputError where that cannot be."""
    partial = unfinished(path)
    if partial is not None:
        _perform("unlink", partial, partial.unlink)


def _replaceable(target: Path, path: AnyPath) -> os.stat_result | None:
    """The file at `target`, None where there is none; OutputError where it is something that must stay."""
    existing = _look(target)
    if existing is not None and not stat.S_ISREG(existing.st_mode):
        folder = stat.S_ISDIR(existing.st_mode)
        raise OutputError(path, "it is a folder" if folder else "it is not a regular file", "Choose another name")
    if existing is not None and not os.access(target, os.W_OK):
        raise OutputError(path, "the file is write-protected", "Choose another name or change its permissions")
    return existing


@contextmanager
def atomic_folder(path: AnyPath, marker: str, size_bytes: int | None = None) -> Iterator[Path]:
    """An empty hidden folder that becomes `path` when the block ends without an exception.

    An existing folder is replaced in one step, but only if it is empty or holds a file called `marker`, by which a
    folder of ours is known; any other raises OutputError before anything is written.
    """
    target = _target(path)
    existing = _look(target)
    if existing is not None and not stat.S_ISDIR(existing.st_mode):
        raise OutputError(path, "a file of that name exists", "Choose another name for the folder")
    if existing is not None and not (target / marker).is_file() and _entries(target):
        raise OutputError(path, f"the folder exists and holds no {marker}, so it is not ours", "Choose another name")
    with _partial_beside(target, size_bytes) as partial:
        _perform("mkdir", partial, partial.mkdir)
        yield partial
        _synchronise_tree(partial)
        _put_folder(partial, target)
        _synchronise(target.parent)
        _discard(partial)


def write_bytes(path: AnyPath, data: bytes) -> None:
    """Write `data` to the file `path`."""
    with atomic_file(path, len(data)) as output:
        output.write(data)


def write_json(path: AnyPath, value: Any) -> None:
    """Write `value` as indented JSON in UTF-8; NaN and infinities raise ValueError before anything is written."""
    write_bytes(path, (json.dumps(value, indent=2, ensure_ascii=False, allow_nan=False) + "\n").encode())


def make_folder(path: AnyPath) -> Path:
    """Create the folder `path` and its parents where they are missing; OutputError where that cannot be."""
    folder = _spelled(path)
    _perform("mkdir", folder, lambda: folder.mkdir(parents=True, exist_ok=True))
    return folder


def remove_leftovers(folder: AnyPath) -> None:
    """Remove the partials that killed processes left in `folder`, and restore what they were about to replace."""
    with suppress(OutputError):
        for leftover in _entries(_spelled(folder)):
            found = _PARTIAL.match(leftover.name) or _REPLACED.match(leftover.name)
            if found is None or leftover in _in_use or _belongs_to_another(int(found.group(1))):
                continue
            if _REPLACED.match(leftover.name):
                _settle(leftover)
            else:
                _discard(leftover)


def require_space(path: AnyPath, size_bytes: int) -> None:
    """Raise OutputError unless the folder of `path` can be written to and its disk has room for 1.1 `size_bytes`."""
    target = _target(path)
    needed = int(HEADROOM * size_bytes)
    if needed > free_bytes(target.parent):
        raise _explained(target, OSError(errno.ENOSPC, ""), needed)


def free_bytes(folder: Path) -> int:
    """Bytes that this user may still write to the disk that holds `folder`."""
    return shutil.disk_usage(folder).free


class _Output(io.RawIOBase):
    """A new file of which every write is complete; without `fileno`, so that no library writes past `_perform`."""

    def __init__(self, path: Path) -> None:
        self._path = path
        flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0)
        self._descriptor = _perform("create", path, lambda: os.open(path, flags, 0o666))

    def writable(self) -> bool:
        return True

    def seekable(self) -> bool:
        return True

    def write(self, data: Any) -> int:
        left = memoryview(data).cast("B")
        total = len(left)
        while left:
            left = left[self._write_some(left) :]
        return total

    def _write_some(self, data: memoryview) -> int:
        with _explaining(self._path, needed_bytes=self.tell() + len(data)):
            limit = fault("write", self._path) if fault is not None else None
            return os.write(self._descriptor, data[:limit])

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        return os.lseek(self._descriptor, offset, whence)

    def tell(self) -> int:
        return self.seek(0, os.SEEK_CUR)

    def close(self) -> None:
        if not self.closed:
            super().close()
            with _explaining(self._path):
                os.close(self._descriptor)


class Resumable:
    """A file of fixed size that this process alone writes, see `resumable_file`; `resumed` tells an earlier one."""

    def __init__(self, path: Path, size_bytes: int, beginning: bytes) -> None:
        self._path = path
        self.discarded = False
        flags = os.O_RDWR | os.O_CREAT | getattr(os, "O_BINARY", 0) | getattr(os, "O_NOFOLLOW", 0)
        self._descriptor = _perform("create", path, lambda: os.open(path, flags, 0o666))
        try:
            self._lock()
            same = os.fstat(self._descriptor).st_size == size_bytes
            self.resumed = same and self.read_at(0, len(beginning)) == beginning
            if not self.resumed:
                with _explaining(path, needed_bytes=size_bytes):
                    os.ftruncate(self._descriptor, 0)
                    self._reserve(size_bytes)
                self.write_at(0, beginning)
        except BaseException:
            os.close(self._descriptor)
            raise

    def write_at(self, offset: int, data: Any) -> None:
        """Write `data` at `offset`."""
        left = memoryview(data).cast("B")
        while left:
            with _explaining(self._path, needed_bytes=len(left)):
                limit = fault("write", self._path) if fault is not None else None
                os.lseek(self._descriptor, offset, os.SEEK_SET)
                written = os.write(self._descriptor, left[:limit])
            left, offset = left[written:], offset + written

    def read_at(self, offset: int, count: int) -> bytes:
        """`count` bytes from `offset`, fewer at the end of the file."""
        with _explaining(self._path):
            os.lseek(self._descriptor, offset, os.SEEK_SET)
            parts = []
            while count > 0 and (part := os.read(self._descriptor, count)):
                parts.append(part)
                count -= len(part)
        return b"".join(parts)

    def discard(self) -> None:
        """Let the file vanish when the block ends: what it held has become something else."""
        self.discarded = True

    def __enter__(self) -> Resumable:
        return self

    def __exit__(self, *_: object) -> None:
        os.close(self._descriptor)

    def _reserve(self, size_bytes: int) -> None:
        """All blocks at once where the system can, so that a full disk is known before the work."""
        if size_bytes > free_bytes(self._path.parent):
            raise OSError(errno.ENOSPC, "")
        if hasattr(os, "posix_fallocate"):
            os.posix_fallocate(self._descriptor, 0, size_bytes)
        else:
            os.ftruncate(self._descriptor, size_bytes)

    def _lock(self) -> None:
        if sys.platform == "win32":
            return  # a file that is open cannot be renamed there, so a second writer fails at its end
        import fcntl

        try:
            fcntl.flock(self._descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            raise OutputError(
                _as_named(self._path), "another run is writing it", "Wait for that run or choose another name"
            ) from None


@contextmanager
def _partial_beside(target: Path, size_bytes: int | None) -> Iterator[Path]:
    """A free hidden name beside `target`; whatever lies there when the block fails is removed."""
    remove_leftovers(target.parent)
    if size_bytes is not None:
        require_space(target, size_bytes)
    partial = target.with_name(_partial_name(target))
    _in_use[partial] = target
    try:
        yield partial
    except BaseException:
        _discard(partial)
        raise
    finally:
        del _in_use[partial]


def _partial_name(target: Path) -> str:
    suffix = target.suffix if len(target.suffix) <= 16 else ""
    ending = f".partial-{os.getpid()}-{secrets.token_hex(4)}{suffix}"
    stem = target.name.removesuffix(suffix)
    while len(os.fsencode(stem + ending)) >= _LONGEST_NAME_BYTES:
        stem = stem[:-1]
    return f".{stem}{ending}"


def _spelled(path: AnyPath) -> Path:
    """The path with links resolved, or OutputError where no file system call would take it."""
    try:
        os.fsencode(path)
        return Path(os.path.realpath(path))
    except ValueError:
        shown = os.fspath(path).replace("\0", "\\0")
        raise OutputError(shown, "the name holds characters that no file name can hold", "Choose another") from None


def _target(path: AnyPath) -> Path:
    """Where `path` leads, in a folder that exists and may be written to."""
    target = _spelled(path)
    if not target.name:
        raise OutputError(path, "it is the root of the file system", "Choose another name")
    _perform("stat", target, target.parent.stat)
    if not os.access(target.parent, os.W_OK | os.X_OK):
        raise _explained(target, OSError(errno.EACCES, ""))
    return target


def _look(target: Path) -> os.stat_result | None:
    with _explaining(target), suppress(FileNotFoundError):
        return target.stat()
    return None


def _entries(folder: Path) -> list[Path]:
    return _perform("list", folder, lambda: sorted(folder.iterdir()))


def _synchronise(path: Path) -> None:
    """Flush a file, or the entries of a folder, to the disk (Windows does the latter by itself)."""
    folder = path.is_dir()
    if folder and sys.platform == "win32":
        return
    descriptor = _perform("open", path, lambda: os.open(path, os.O_RDWR if sys.platform == "win32" else os.O_RDONLY))
    try:
        _perform("fsync-dir" if folder else "fsync", path, lambda: os.fsync(descriptor))
    finally:
        os.close(descriptor)


def _synchronise_tree(folder: Path) -> None:
    for entry in _entries(folder):
        if entry.is_dir():
            _synchronise_tree(entry)
        else:
            _synchronise(entry)
    _synchronise(folder)


def _put_folder(partial: Path, target: Path) -> None:
    """Rename `partial` to `target`; a folder that is there ends up at `partial`, or is gone."""
    if not target.exists():
        _perform("rename", partial, lambda: partial.rename(target))
    elif not _perform("rename", target, lambda: _exchange(partial, target)):
        _replace_in_two_steps(partial, target)


def _exchange(one: Path, other: Path) -> bool:
    """Swap two folders in one step (Linux renameat2, macOS renamex_np); False where the system cannot."""
    here, swap = -100, 2
    library: Any = ctypes.CDLL(None, use_errno=True) if sys.platform != "win32" else None
    if hasattr(library, "renameat2"):
        code = library.renameat2(here, os.fsencode(one), here, os.fsencode(other), swap)
    elif hasattr(library, "renamex_np"):
        code = library.renamex_np(os.fsencode(one), os.fsencode(other), swap)
    else:
        return False
    if code != 0 and ctypes.get_errno() not in (errno.EINVAL, errno.ENOSYS, errno.ENOTSUP):
        raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))
    return code == 0


def _replace_in_two_steps(partial: Path, target: Path) -> None:
    """Put the old folder aside, under its own name so that `remove_leftovers` can bring it back after a crash."""
    aside = target.with_name(f".lightarc-replaced-{os.getpid()}-{secrets.token_hex(4)}")
    _in_use[aside] = target.parent
    try:
        _perform("mkdir", aside, aside.mkdir)
        _perform("rename", target, lambda: target.rename(aside / target.name))
        _perform("rename", partial, lambda: partial.rename(target))
    finally:
        _settle(aside)
        del _in_use[aside]


def _settle(aside: Path) -> None:
    """Bring back the folder that was put aside, or remove it where another has taken its place; never lose it."""
    with suppress(OutputError):
        for entry in _entries(aside):
            home = aside.with_name(entry.name)
            if os.path.lexists(home):
                _discard(entry)
            else:
                _perform("rename", home, functools.partial(entry.rename, home))
        _perform("rmdir", aside, aside.rmdir)


def _discard(path: Path) -> None:
    """Remove a file or folder of ours as far as that can be done; what stays is a leftover for the next write."""
    with suppress(OutputError):
        if path.is_dir() and not path.is_symlink():
            for entry in _entries(path):
                _discard(entry)
            _perform("rmdir", path, path.rmdir)
        elif os.path.lexists(path):
            _perform("unlink", path, path.unlink)


def _belongs_to_another(process: int) -> bool:
    import psutil

    return process != os.getpid() and psutil.pid_exists(process)


def _perform(operation: str, path: Path, action: Callable[[], Value]) -> Value:
    with _explaining(path):
        if fault is not None:
            fault(operation, path)
        return action()


@contextmanager
def _explaining(path: Path, needed_bytes: int | None = None) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise _explained(path, error, needed_bytes) from error


def _explained(path: Path, error: OSError, needed_bytes: int | None = None) -> OutputError:
    """The sentence for `error`, about the file that the user named instead of its partial."""
    problem, remedy = _CAUSES.get(
        error.errno or 0, (f"it cannot be written ({error.strerror})", "Choose another place")
    )
    if error.errno in (errno.ENOSPC, errno.EDQUOT):
        with suppress(OSError):
            free = free_bytes(path.parent)
            needed = f"{needed_bytes:,} bytes needed, " if needed_bytes is not None else ""
            problem = f"{problem} ({needed}{free:,} bytes free)"
    return OutputError(_as_named(path), problem, remedy)


def _as_named(path: Path) -> Path:
    for ancestor in (path, *path.parents):
        if ancestor in _in_use:
            return _as_named(_in_use[ancestor] / path.relative_to(ancestor))
    return path
