"""Outputs checked before any work starts: none may meet an input, and none may replace what is not its own.

A result may take the place of an earlier one of its own kind, which is known by what it holds (a header, a software
tag, a folder with nothing but the files of such a result). Any other regular file needs the consent `overwrite`. Three
things are refused always: a path that leads to an input by whatever name (symbolic and hard links, `..`, letter case
where the disk ignores it), a folder that holds or lies in an input, and anything that is neither file nor folder.
`engine.storage.atomic` still checks what it replaces when it writes. Cost: some looks at the disk, under a millisecond;
folders that are read are listed only where an output exists.
"""

from __future__ import annotations

import os
import stat
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from fnmatch import fnmatch
from itertools import islice
from pathlib import Path

from engine.core.errors import InputError, OutputError, UsageError
from engine.storage.atomic import make_folder, require_space
from engine.storage.untrusted import read_head

#: Entries of folders that are read which an output is compared with.
MAX_ENTRIES = 100_000

#: Endings that a folder must not have, because a file was surely meant.
_ENDINGS_OF_FILES = (".png", ".exr", ".jpg", ".jpeg", ".tif", ".tiff", ".hdr", ".json", ".csv", ".obj", ".ply", ".zip")

#: Ends of paths that can only name a folder.
_FOLDER_ENDS = tuple(slash + dots for slash in {"/", os.sep} for dots in ("", ".", ".."))

#: Files that file managers leave in any folder, which may go with it.
_LITTER = (".DS_Store", "Thumbs.db", "desktop.ini")

#: Bytes at the beginning of a file in which a software tag is looked for.
_HEAD_BYTES = 1 << 16


@dataclass(frozen=True)
class Kind:
    """A kind of result.

    Attributes
    ----------
    noun : its name in sentences, with its article: 'a transport file'.
    endings : of a file, in small letters, one of which its name must have; none for a folder.
    is_earlier : True for a path to a file, or to a folder that is not empty, that is an earlier result of this kind.
    members : patterns of the paths (with /) of all files that a folder of this kind may hold; a * also takes /.
    shared : True for a folder into which results are put beside what is there, and whose parents are made.
    """

    noun: str
    endings: tuple[str, ...] = ()
    is_earlier: Callable[[Path], bool] = lambda _path: False
    members: tuple[str, ...] = ()
    shared: bool = False

    @property
    def is_folder(self) -> bool:
        return not self.endings


def check_outputs(
    outputs: Sequence[tuple[str, Kind]],
    inputs: Iterable[str],
    *,
    overwrite: bool = False,
    makes_folders: bool = False,
) -> None:
    """Raise unless every output can be written without harm to an input or to a file of somebody else.

    Parameters
    ----------
    outputs : paths that will be written, in the order of writing, and what each will be.
    inputs : paths that are read; those that do not exist are left to the reader.
    overwrite : consent to replace a regular file of another kind; it covers no input and no folder.
    makes_folders : True for a caller that makes the missing folders of outputs (`make_folders`).

    Raises
    ------
    UsageError : the name of an output has not the ending of its kind.
    OutputError : it leads to an input or to another output, or something stands there that must stay, or its folder is
        missing or cannot be written to.
    """
    for path, kind in outputs:
        _check_name(path, kind)
    exists = any(os.path.lexists(path) for path, _ in outputs)
    read = _Read.of(inputs, with_entries=exists)
    for path, kind in outputs:
        _check_inputs(path, kind, read)
    _check_each_other(outputs)
    shared = {Path(path) for path, kind in outputs if kind.shared}
    for path, kind in outputs:
        _check_existing(path, kind, overwrite=overwrite)
        if Path(path).parent not in shared:
            _check_place(path, kind, makes_folders=makes_folders)


@contextmanager
def make_folders(outputs: Sequence[tuple[str, Kind]]) -> Iterator[None]:
    """Make the missing folders in which `outputs` will lie; those that are empty after the block are removed again."""
    made: list[Path] = []
    try:
        for path, _ in outputs:
            above = [folder for folder in Path(path).absolute().parents if not os.path.lexists(folder)]
            for folder in reversed(above):
                make_folder(folder)
                made.append(folder)
        yield
    finally:
        for folder in reversed(made):
            with suppress(OSError):  # it holds a result
                folder.rmdir()


@dataclass(frozen=True)
class Written:
    """A result that was written: its `path`, its `size_bytes`, and its number of `files`."""

    path: str
    size_bytes: int
    files: int


def identify(outputs: Sequence[tuple[str, Kind]]) -> list[tuple[int, ...]]:
    """Identity and time of what lies at each of `outputs`, which writing changes; `find_written` compares them."""
    return [() if (found := look(path)) is None else (*_identity(found), found.st_mtime_ns) for path, _ in outputs]


def find_written(outputs: Sequence[tuple[str, Kind]], before: Sequence[tuple[int, ...]]) -> list[Written]:
    """Those of `outputs` that are there and differ from `before`; what lies in a shared folder as one with it."""
    changed = [
        path
        for (path, kind), known, now in zip(outputs, before, identify(outputs), strict=True)
        if now and now != known and not kind.shared
    ]
    groups: dict[str, list[str]] = {}
    shared = {Path(path): path for path, kind in outputs if kind.shared}
    for path in changed:
        groups.setdefault(shared.get(Path(path).parent, path), []).append(path)
    found = []
    for path, members in groups.items():
        files = [each for member in members for each in (_entries(member) if _is_folder(member) else [member])]
        sizes = [status.st_size for each in files if (status := look(each)) is not None]
        found.append(Written(path, sum(sizes), len(sizes)))
    return found


def has_tag(path: Path, software: str) -> bool:
    """True for a PNG or OpenEXR file whose software tag is `software`, see `engine.images.encode`."""
    try:
        head, _ = read_head(path, _HEAD_BYTES)
    except InputError:
        return False
    name = software.encode()
    in_exr = b"software\0string\0" + len(name).to_bytes(4, "little") + name
    in_png = (len(name) + 9).to_bytes(4, "big") + b"tEXtSoftware\0" + name
    return (head.startswith(b"\x89PNG") and in_png in head) or (head.startswith(b"\x76\x2f\x31\x01") and in_exr in head)


def look(path: str | Path) -> os.stat_result | None:
    """Status of the file at `path`, links followed; None if nothing is there or nothing can be seen."""
    try:
        return Path(path).stat()
    except (OSError, ValueError):
        return None


_Identity = tuple[int, int]


@dataclass
class _Read:
    """Everything that is read: names by identity of files, of folders, and of all folders above them."""

    files: dict[_Identity, str] = field(default_factory=dict)
    folders: dict[_Identity, str] = field(default_factory=dict)
    above: dict[_Identity, str] = field(default_factory=dict)

    @classmethod
    def of(cls, inputs: Iterable[str], *, with_entries: bool) -> _Read:
        read = cls()
        for path in inputs:
            read._add(path, path)
            if with_entries:
                for entry in islice(_entries(path), MAX_ENTRIES):
                    read._add(str(entry), path)
        return read

    def _add(self, path: str, name: str) -> None:
        found = look(path)
        if found is None:
            return
        known = self.folders if stat.S_ISDIR(found.st_mode) else self.files
        known.setdefault(_identity(found), name)
        for folder in _folders_above(path):
            self.above.setdefault(folder, name)


def _entries(folder: str | Path) -> Iterator[Path]:
    """All files below `folder`, whose links to folders are not followed; none below a file."""
    for place, _, names in os.walk(folder):
        yield from (Path(place) / name for name in names)


def _identity(found: os.stat_result) -> _Identity:
    return found.st_dev, found.st_ino


def _is_folder(path: str | Path) -> bool:
    found = look(path)
    return found is not None and stat.S_ISDIR(found.st_mode)


def _folders_above(path: str) -> Iterator[_Identity]:
    for folder in Path(os.path.realpath(path)).parents:
        found = look(folder)
        if found is not None:
            yield _identity(found)


def _check_name(path: str, kind: Kind) -> None:
    """UsageError for a wrong ending, OutputError for a name that cannot be that of a file or folder."""
    if not path.strip():
        raise OutputError("''", "the name of the output is empty", f"Name {kind.noun}")
    if "\0" in path:
        raise OutputError(path.replace("\0", "\\0"), "no name can hold such a character", "Choose another name")
    lower = Path(path).name.lower()
    if kind.is_folder:
        if not (kind.shared or _is_folder(path)) and lower.endswith(_ENDINGS_OF_FILES):
            raise UsageError(f"{path!r} has the ending of a file, and {kind.noun} is a folder")
        return
    if not lower.endswith(kind.endings):
        raise UsageError(f"{path!r} must end in {' or '.join(kind.endings)}, as the name of {kind.noun}")
    if path.endswith(_FOLDER_ENDS):
        raise OutputError(path, f"it names a folder, and {kind.noun} is a file", "Leave the slash at its end out")


def _check_inputs(path: str, kind: Kind, read: _Read) -> None:
    found = look(path)
    identity = _identity(found) if found is not None else (0, 0)
    if name := read.files.get(identity) or read.folders.get(identity):
        what = "it is read by this command" if name == path else f"it is the same as, or part of, {name}, which is read"
        raise OutputError(path, f"{what}, and an output never replaces an input", "Choose another name")
    for folder in _folders_above(path):
        if folder in read.folders:
            problem = f"it lies in {read.folders[folder]}, which is read by this command"
            raise OutputError(path, problem, "Choose a place outside that folder")
    if kind.is_folder and not kind.shared and identity in read.above:
        raise OutputError(
            path,
            f"the folder holds {read.above[identity]}, which is read, and would be replaced",
            "Choose another name",
        )


def _check_each_other(outputs: Sequence[tuple[str, Kind]]) -> None:
    """No output may be another one, or lie in a folder that another one replaces."""
    places = [Path(os.path.realpath(path)) for path, _ in outputs]
    for index, (path, _) in enumerate(outputs):
        for other in range(len(outputs)):
            replaced = other != index and not outputs[other][1].shared
            if replaced and (places[other] == places[index] or places[other] in places[index].parents):
                problem = f"it is, or lies in, {outputs[other][0]}, which is another output of this command"
                raise OutputError(path, problem, "Choose another name for one of them")


def _check_existing(path: str, kind: Kind, *, overwrite: bool) -> None:
    """OutputError where something stands at `path` that is not an earlier result of this kind."""
    try:
        mode = Path(path).stat().st_mode
    except (FileNotFoundError, NotADirectoryError):
        return
    except OSError as error:
        raise OutputError(path, f"it cannot be looked at ({error.strerror})", "Choose another path") from None
    if stat.S_ISDIR(mode):
        if not kind.is_folder:
            raise OutputError(path, "it is a folder", f"Name a file for {kind.noun}")
        if not kind.shared:
            _check_folder(Path(path), kind)
    elif kind.is_folder:
        raise OutputError(path, "a file of that name exists", "Choose another name for the folder")
    elif not stat.S_ISREG(mode):
        raise OutputError(path, "it is not a regular file", "Choose another name")
    elif not os.access(path, os.W_OK):
        raise OutputError(path, "the file is write-protected", "Choose another name or change its permissions")
    elif not (overwrite or kind.is_earlier(Path(path))):
        problem = f"it exists, and is not {kind.noun} that this command wrote"
        raise OutputError(path, problem, "Choose another name, or add --overwrite to replace it")


def _check_folder(folder: Path, kind: Kind) -> None:
    """OutputError unless `folder` is empty or an earlier result with nothing else in it."""
    try:
        if next(folder.iterdir(), None) is None:
            return
    except OSError as error:
        raise OutputError(folder, f"it cannot be looked at ({error.strerror})", "Choose another name") from None
    if not kind.is_earlier(folder):
        raise OutputError(folder, f"the folder exists and is not {kind.noun}", "Choose another name")
    for name in sorted(entry.relative_to(folder).as_posix() for entry in _entries(folder)):
        if not any(fnmatch(name, pattern) for pattern in (*kind.members, *_LITTER)):
            problem = f"the folder would be replaced, and holds {name}, which is no part of {kind.noun}"
            raise OutputError(folder, problem, "Move that elsewhere, or choose another name")


def _check_place(path: str, kind: Kind, *, makes_folders: bool) -> None:
    """OutputError where the folder of an output is read-only, or missing unless it is made or a shared one."""
    folder = Path(path) if kind.shared else Path(path).parent
    while (kind.shared or makes_folders) and not os.path.lexists(folder) and folder != folder.parent:
        folder = folder.parent
    if look(folder) is not None and not _is_folder(folder):
        raise OutputError(path, f"{folder} is a file, and would have to be a folder", "Choose another path")
    require_space(folder / Path(path).name, 0)
