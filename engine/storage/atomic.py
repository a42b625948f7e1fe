"""The one module through which everything is written: complete or absent, never half.

A result is written beside its target under a hidden partial name, flushed to the disk, renamed over the target, and
the folder entry is flushed as well (Pillai2014: the order that
survives a crash at any point). A failure or a closed generator removes the partial; a killed process leaves it, and
the next write into the same folder removes it (`remove_leftovers`). Only what takes minutes to make is kept beside its
target when that ends early (`engine.storage.resumable`).

Every operation on the disk passes `perform`, where a test can make it fail, come up short, or end the process.
Cost: two flushes to the disk for each file, one for each file and folder of a folder.
"""

from __future__ import annotations

import ctypes
import errno
import functools
import io
import json
import os
import shutil
import stat
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO, Protocol, TypeVar, cast

from engine.core.errors import FileError, OutputError
from engine.core.figure_text import size_text
from engine.storage import guarded
from engine.storage.partial_names import aside_name, is_abandoned, is_aside, is_partial, partial_name

if TYPE_CHECKING:
    from _typeshed import ReadableBuffer

Value = TypeVar("Value")
AnyPath = str | os.PathLike[str]

#: A test puts a function of (operation, path) here. It may raise OSError, end the process, or return the number of
#: bytes that a 'write' shall take. Operations: stat, list, create, open, lock, write, truncate, fsync, fsync-dir,
#: close, chmod, link, mkdir, rename, unlink, rmdir.
fault: Callable[[str, Path], int | None] | None = None

#: Room demanded before writing, as a multiple of the size where that is known.
HEADROOM = 1.1

#: Bytes of a file that wait in memory before the disk begins with them, and a flag of `man 2 sync_file_range`.
_WAITING_BYTES, _WRITE_RANGE = 1 << 26, 2

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
def atomic_file(path: AnyPath, size_bytes: int | None = None, begun: Path | None = None) -> Iterator[BinaryIO]:
    """A binary stream whose content appears at `path` when the block ends without an exception.

    Parameters
    ----------
    path : file to create or to replace; a symbolic link is followed and stays.
    size_bytes : the size where it is known, for which room is demanded before the first byte.
    begun : a file of ours on the same disk, which it begins as: that is moved, and its content is there to change.

    Raises
    ------
    OutputError : with path, cause, remedy and, on a full disk, needed and free bytes; `path` is then as before.
    InputError : where a file that is mapped was cut short, so that what was computed is not to be trusted.
    """
    with atomic_path(path, size_bytes) as partial:
        if begun is not None:
            perform("rename", partial, lambda: begun.replace(partial))
        output = _Output(partial, is_new=begun is None)
        try:
            yield cast(BinaryIO, output)
        finally:
            output.close()


@contextmanager
def atomic_path(path: AnyPath, size_bytes: int | None = None) -> Iterator[Path]:
    """As `atomic_file`, for libraries that write by name: yields the partial name, with the suffix of `path`."""
    target = target_of(path)
    existing = replaceable(target, path)
    with _partial_beside(target, size_bytes) as partial:
        yield partial
        guarded.check()
        synchronise(partial)
        put_file(partial, target, existing)


def put_file(partial: Path, target: Path, existing: os.stat_result | None) -> None:
    """Rename `partial`, which is on the disk, to `target`, with the permissions of the file that `existing` tells."""
    if existing is not None:
        perform("chmod", partial, lambda: partial.chmod(stat.S_IMODE(existing.st_mode)))
    perform("rename", partial, lambda: partial.replace(target))
    synchronise(target.parent)


def replaceable(target: Path, path: AnyPath) -> os.stat_result | None:
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
    target = target_of(path)
    existing = _look(target)
    if existing is not None and not stat.S_ISDIR(existing.st_mode):
        raise OutputError(path, "a file of that name exists", "Choose another name for the folder")
    if existing is not None and not (target / marker).is_file() and _entries(target):
        raise OutputError(path, f"the folder exists and holds no {marker}, so it is not ours", "Choose another name")
    with _partial_beside(target, size_bytes) as partial:
        perform("mkdir", partial, partial.mkdir)
        yield partial
        guarded.check()
        _synchronise_tree(partial)
        _put_folder(partial, target)
        synchronise(target.parent)
        discard(partial)


@contextmanager
def passing_folder(path: AnyPath) -> Iterator[Path]:
    """An empty hidden folder beside `path`, which goes when the block ends with what is then still in it."""
    with _partial_beside(target_of(path), None) as partial:
        perform("mkdir", partial, partial.mkdir)
        yield partial
        discard(partial)


class Pieces(Protocol):
    """Content of a file that is too large for memory: its bytes altogether (`len`), and the pieces in their order."""

    def __len__(self) -> int: ...

    def __iter__(self) -> Iterator[bytes]: ...


def write_bytes(path: AnyPath, data: bytes | Pieces) -> None:
    """Write `data` to the file `path`."""
    with atomic_file(path, len(data)) as output:
        for piece in (data,) if isinstance(data, bytes) else data:
            output.write(piece)


def overwrite_end(path: AnyPath, data: bytes) -> None:
    """Overwrite the last bytes of a complete file, in one call of the system; OutputError where that cannot be."""
    target = target_of(path)
    with explaining(target), perform("open", target, lambda: target.open("r+b", buffering=0)) as file:
        perform("seek", target, lambda: file.seek(-len(data), os.SEEK_END))
        written = perform("write", target, lambda: file.write(data))
        if written != len(data):
            raise OSError(errno.ENOSPC, "")
        perform("fsync", target, lambda: os.fsync(file.fileno()))


def write_json(path: AnyPath, value: object) -> None:
    """Write `value` as indented JSON in UTF-8; NaN and infinities raise ValueError before anything is written.

    What UTF-8 cannot hold, as of names of files in other encodings, is escaped, and is read back as it was.
    """
    text = json.dumps(value, indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    write_bytes(path, text.encode(errors="backslashreplace"))


def link(path: Path, target: Path) -> bool:
    """Give the file `path` a second name, `target`; False where it is gone or the file system cannot do that.

    For files that are replaced and never changed: a change would show under both names.
    """
    with suppress(OutputError):
        perform("link", target, lambda: os.link(path, target))
        return True
    return False


def make_folder(path: AnyPath) -> Path:
    """Create the folder `path` and its parents where they are missing; OutputError where that cannot be."""
    folder = spell(path)
    perform("mkdir", folder, lambda: folder.mkdir(parents=True, exist_ok=True))
    return folder


def remove_leftovers(folder: AnyPath) -> None:
    """Remove the partials that killed processes left in `folder`, and restore what they were about to replace."""
    with suppress(OutputError):
        for leftover in _entries(spell(folder)):
            if leftover in _in_use or not is_abandoned(leftover):
                continue
            if is_aside(leftover.name):
                _settle(leftover)
            else:
                discard(leftover)


def remove_own_partials() -> None:
    """Remove what this process has half-written, and restore what it was about to replace, where no `finally` will."""
    for path in tuple(_in_use):
        if is_aside(path.name):
            _settle(path)
        elif is_partial(path.name):
            discard(path)


def require_space(path: AnyPath, size_bytes: int) -> None:
    """Raise OutputError unless the folder of `path` can be written to and its disk has room for 1.1 `size_bytes`."""
    target = target_of(path)
    needed = int(HEADROOM * size_bytes)
    if needed > free_bytes(target.parent):
        raise _explain(target, OSError(errno.ENOSPC, ""), needed)


def free_bytes(folder: Path) -> int:
    """Bytes that this user may still write to the disk that holds `folder`."""
    return shutil.disk_usage(folder).free


class _Output(io.RawIOBase):
    """A file, new or begun, of which every write is complete; without `fileno`, so that no library writes past
    `perform`."""

    def __init__(self, path: Path, *, is_new: bool = True) -> None:
        self._path, self._waiting_bytes = path, 0
        flags = os.O_WRONLY | (os.O_CREAT | os.O_EXCL if is_new else 0) | getattr(os, "O_BINARY", 0)
        self._descriptor = perform("create", path, lambda: os.open(path, flags, 0o666))

    @property
    def name(self) -> str:
        """The path under which it lies until it is complete."""
        return os.fspath(self._path)

    def writable(self) -> bool:
        return True

    def seekable(self) -> bool:
        return True

    def write(self, data: ReadableBuffer) -> int:
        left = memoryview(data).cast("B")
        total = len(left)
        while left:
            left = left[self._write_some(left) :]
        self._waiting_bytes += total
        if self._waiting_bytes >= _WAITING_BYTES:
            self._waiting_bytes = 0
            _begin_flush(self._descriptor)
        return total

    def _write_some(self, data: memoryview) -> int:
        with explaining(self._path, needed_bytes=self.tell() + len(data)):
            limit = fault("write", self._path) if fault is not None else None
            return os.write(self._descriptor, data[:limit])

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        return os.lseek(self._descriptor, offset, whence)

    def tell(self) -> int:
        return self.seek(0, os.SEEK_CUR)

    def truncate(self, size: int | None = None) -> int:
        wanted = self.tell() if size is None else size
        perform("truncate", self._path, lambda: os.ftruncate(self._descriptor, wanted))
        return wanted

    def close(self) -> None:
        if not self.closed:
            super().close()
            close(self._descriptor, self._path)


def _begin_flush(descriptor: int) -> None:
    """Have what was written to a file taken to the disk beside other work (Linux); a failure shows when it is flushed.

    The system does so after seconds, so that a flush at the end of quick work waits for nearly all of it.
    """
    library: Any = ctypes.CDLL(None) if sys.platform == "linux" else None
    if hasattr(library, "sync_file_range"):
        library.sync_file_range(descriptor, ctypes.c_int64(0), ctypes.c_int64(0), _WRITE_RANGE)


@contextmanager
def _partial_beside(target: Path, size_bytes: int | None) -> Iterator[Path]:
    """A free hidden name beside `target`; whatever lies there when the block fails is removed."""
    remove_leftovers(target.parent)
    if size_bytes is not None:
        require_space(target, size_bytes)
    partial = target.with_name(partial_name(target))
    with standing_for(partial, target):
        try:
            yield partial
        except BaseException as error:
            discard(partial)
            if isinstance(error, FileError) and Path(error.path).is_relative_to(partial):  # what was written is read
                error.path = os.fspath(target / Path(error.path).relative_to(partial))
            if isinstance(error, OSError) and isinstance(error.filename, (str, bytes)):
                place = Path(os.fsdecode(error.filename))  # of a library that writes by name
                if place.is_relative_to(partial):
                    raise _explain(place, error) from error
            raise


@contextmanager
def standing_for(partial: Path, target: Path) -> Iterator[None]:
    """Within the block `partial` is at work, and errors about it name `target`."""
    if partial in _in_use:
        raise OutputError(target, "another run is writing it", "Wait for that run or choose another name")
    _in_use[partial] = target
    try:
        yield
    finally:
        del _in_use[partial]


def is_in_use(path: Path) -> bool:
    """True if this process is writing `path`, which is a partial or a resumable file."""
    return path in _in_use


def spell(path: AnyPath) -> Path:
    """The path with links resolved, or OutputError where no file system call would take it."""
    try:
        os.fsencode(path)
        return Path(os.path.realpath(path))
    except ValueError:
        shown = os.fspath(path).replace("\0", "\\0")
        raise OutputError(shown, "the name holds characters that no file name can hold", "Choose another") from None


def target_of(path: AnyPath) -> Path:
    """Path that `path` leads to, in a folder that exists and may be written to."""
    target = spell(path)
    if not target.name:
        raise OutputError(path, "it is the root of the file system", "Choose another name")
    perform("stat", target, target.parent.stat)
    if not os.access(target.parent, os.W_OK | os.X_OK):
        raise _explain(target, OSError(errno.EROFS if _is_read_only(target.parent) else errno.EACCES, ""))
    return target


def _is_read_only(folder: Path) -> bool:
    """True on a medium or a mount that takes no writing from anybody; False where the system does not say."""
    return hasattr(os, "statvfs") and bool(os.statvfs(folder).f_flag & os.ST_RDONLY)


def _look(target: Path) -> os.stat_result | None:
    with explaining(target), suppress(FileNotFoundError):
        return target.stat()
    return None


def _entries(folder: Path) -> list[Path]:
    return perform("list", folder, lambda: sorted(folder.iterdir()))


def synchronise(path: Path) -> None:
    """Flush a file, or the entries of a folder, to the disk (Windows does the latter by itself)."""
    folder = path.is_dir()
    if folder and sys.platform == "win32":
        return
    descriptor = perform("open", path, lambda: os.open(path, os.O_RDWR if sys.platform == "win32" else os.O_RDONLY))
    try:
        perform("fsync-dir" if folder else "fsync", path, lambda: os.fsync(descriptor))
    finally:
        close(descriptor, path)


def _synchronise_tree(folder: Path) -> None:
    for entry in _entries(folder):
        if entry.is_dir():
            _synchronise_tree(entry)
        else:
            synchronise(entry)
    synchronise(folder)


def _put_folder(partial: Path, target: Path) -> None:
    """Rename `partial` to `target`; a folder that is there ends up at `partial`, or is gone."""
    if not target.exists():
        perform("rename", partial, lambda: partial.rename(target))
    elif not perform("rename", target, lambda: _exchange(partial, target)):
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
    aside = target.with_name(aside_name())
    with standing_for(aside, target.parent):
        try:
            perform("mkdir", aside, aside.mkdir)
            perform("rename", target, lambda: target.rename(aside / target.name))
            perform("rename", partial, lambda: partial.rename(target))
        finally:
            _settle(aside)


def _settle(aside: Path) -> None:
    """Bring back the folder that was put aside, or remove it where another has taken its place; never lose it."""
    with suppress(OutputError):
        for entry in _entries(aside):
            home = aside.with_name(entry.name)
            if os.path.lexists(home):
                discard(entry)
            else:
                perform("rename", home, functools.partial(entry.rename, home))
        perform("rmdir", aside, aside.rmdir)


def discard(path: Path) -> None:
    """Remove a file or folder of ours as far as that can be done; what stays is a leftover for the next write."""
    with suppress(OutputError):
        if path.is_dir() and not path.is_symlink():
            for entry in _entries(path):
                discard(entry)
            perform("rmdir", path, path.rmdir)
        elif os.path.lexists(path):
            perform("unlink", path, path.unlink)


def perform(operation: str, path: Path, action: Callable[[], Value]) -> Value:
    with explaining(path):
        if fault is not None:
            fault(operation, path)
        return action()


def close(descriptor: int, path: Path) -> None:
    """Close a file; OutputError where the system, as some do, only now says that it could not be written."""
    with explaining(path):
        os.close(descriptor)
        if fault is not None:
            fault("close", path)


@contextmanager
def explaining(path: Path, needed_bytes: int | None = None) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise _explain(path, error, needed_bytes) from error


def _explain(path: Path, error: OSError, needed_bytes: int | None = None) -> OutputError:
    """The sentence for `error`, about the file that the user named instead of its partial."""
    problem, remedy = _CAUSES.get(
        error.errno or 0, (f"it cannot be written ({error.strerror})", "Choose another place")
    )
    if error.errno in (errno.ENOSPC, errno.EDQUOT):
        with suppress(OSError):
            free = free_bytes(path.parent)
            needed = f"{_room(needed_bytes)} needed, " if needed_bytes is not None else ""
            problem = f"{problem} ({needed}{_room(free)} free)"
    return OutputError(as_named(path), problem, remedy)


def _room(size_bytes: int) -> str:
    """Bytes as users read them: to the byte below a megabyte, where they may decide."""
    return f"{size_bytes:,} bytes" if size_bytes < 1_000_000 else size_text(size_bytes)


def as_named(path: Path) -> Path:
    for ancestor in (path, *path.parents):
        if ancestor in _in_use:
            return as_named(_in_use[ancestor] / path.relative_to(ancestor))
    return path
