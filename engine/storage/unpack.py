"""Files out of a zip or tar that someone else made, into a folder of ours, without trusting it.

The archive is read in a decoder process (`engine.storage.archive_child`); here the list that it gives is checked and
the files are written. They have the last part of their name only, so none can leave the folder; names that try are
refused all the same, as are links, devices, sparse files, encrypted members and names that collide. Counts and sizes
are checked before anything is written (limits of `engine.storage.archive`). A packed tar is first inflated into an
unnamed file.
Cost: bound by inflating, some 100 MB/s; memory is that of `_BATCH_BYTES`, or of the largest member of a zip.
"""

from __future__ import annotations

import os
import stat
import tempfile
import unicodedata
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import IO, Any

from engine.core.errors import InputError, OutputError
from engine.core.steps import Step, Steps
from engine.storage.archive import (
    MEMBER_LIMIT,
    RATIO_FLOOR_BYTES,
    RATIO_LIMIT,
    TOTAL_LIMIT_BYTES,
    Entry,
    check_entry,
    contents_request,
    zip_entries,
)
from engine.storage.archive_child import one_line, show
from engine.storage.atomic import atomic_file, require_space
from engine.storage.untrusted import Decoding, open_checked

_PIECE_BYTES = 1 << 20
#: Contents of a zip that are asked for at once, unless a single one is larger.
_BATCH_BYTES = 64 << 20
#: Seconds of CPU time in which a list of members is read, and a packed tar inflated.
_LIMIT_S = 600.0
#: Interval of the steps while the decoder is waited for, in seconds.
_PATIENCE_S = 0.02
_TAR_BLOCK = 512
_REMEDY = "Copy it again from where it came, or unpack it yourself and give the folder"

_ZIP, _TAR = b"PK", b"ustar"
_PACKED = {b"\x1f\x8b": "gzip", b"BZh": "bzip2", b"\xfd7zXZ\0": "xz"}
_UNREAD = {b"7z\xbc\xaf\x27\x1c": "7z", b"Rar!": "RAR"}


@dataclass(frozen=True)
class _Member:
    """A file in an archive: its whole name with slashes, its size, and its place in the list of a zip or in a tar."""

    name: str
    size_bytes: int
    place: int


def is_archive(path: Path) -> bool:
    """True if the regular file `path` begins as an archive does, also one that is not read (7z, RAR)."""
    try:
        if not path.is_file():
            return False
        with path.open("rb") as file:
            head = file.read(_TAR_BLOCK)
    except (OSError, ValueError):
        return False
    return head.startswith((_ZIP, *_PACKED, *_UNREAD)) or head[257:262] == _TAR


def zip_names(path: Path, process: str = "") -> list[str]:
    """The names of the files in a zip; InputError where it is damaged or hostile. `process` as in `unpack`."""
    return [member.name for member in _zip_members(path, _zip_entries(path, process))]


def unpack(
    path: Path, folder: Path, choose: Callable[[Sequence[str]], Sequence[str]], process: str = ""
) -> Steps[dict[str, str]]:
    """Write those members of the archive `path` that `choose` picks from their names into `folder`.

    `process` is the module whose decoder process reads the archive, where it is needed afterwards.
    Returned is the member of each file written, by the name of the file. Raises InputError for what is damaged,
    hostile or not read, OutputError where there is no room.
    """
    with ExitStack() as files:
        file, size_bytes = files.enter_context(open_checked(path, TOTAL_LIMIT_BYTES))
        head = file.read(_TAR_BLOCK)
        for start, name in _UNREAD.items():
            if head.startswith(start):
                raise InputError(path, f"is a {name} archive, which is not read", "Unpack it, or pack it as zip")
        is_zip = head.startswith(_ZIP)
        if is_zip:
            members = _zip_members(path, _zip_entries(path, process))
        else:
            packed = next((kind for start, kind in _PACKED.items() if head.startswith(start)), "")
            tar = files.enter_context(_find_unnamed(folder)) if packed else file
            members = yield from _tar_members(path, size_bytes, tar, packed, process)
        _check_names(path, members)
        _check_sizes(path, members, size_bytes)
        wanted = set(choose([member.name for member in members]))
        chosen = [member for member in members if member.name in wanted]
        _check_collisions(path, chosen)
        require_space(folder / "member", sum(member.size_bytes for member in chosen))
        written = 0
        for batch in _batches(chosen) if is_zip else [[member] for member in chosen]:
            note = f"Unpacking {written + 1} of {len(chosen)}"
            yield Step(written / len(chosen), note)
            contents = (yield from _contents(path, batch, written / len(chosen), note, process)) if is_zip else []
            for index, member in enumerate(batch):
                with atomic_file(folder / _last(member.name)) as output:
                    if is_zip:
                        output.write(contents[index].data)
                    else:
                        yield from _copy(path, member, tar, output, written / len(chosen))
                written += 1
    return {_last(member.name): member.name for member in chosen}


def _last(name: str) -> str:
    return PurePosixPath(name).name


def _zip_entries(path: Path, process: str) -> list[Entry]:
    return zip_entries(path, _REMEDY, _REMEDY, TOTAL_LIMIT_BYTES, process, comment=True)


def _zip_members(path: Path, entries: Iterable[Entry]) -> list[_Member]:
    members = []
    for number, entry in enumerate(entries):
        if stat.S_ISDIR(entry.attributes >> 16) or entry.stored.endswith("/"):
            continue
        check_entry(path, entry, _REMEDY)
        members.append(_Member(_normal(_spell(entry)), entry.size_bytes, number))
    return members


def _batches(members: Iterable[_Member]) -> Iterator[list[_Member]]:
    """Members in their order, together at most `_BATCH_BYTES` or one alone."""
    batch, size_bytes = list[_Member](), 0
    for member in members:
        if batch and size_bytes + member.size_bytes > _BATCH_BYTES:
            yield batch
            batch, size_bytes = [], 0
        batch.append(member)
        size_bytes += member.size_bytes
    if batch:
        yield batch


def _contents(path: Path, members: Sequence[_Member], done: float, note: str, process: str) -> Steps[list[Any]]:
    """The contents of members of a zip."""
    wanted = [(member.place, member.size_bytes) for member in members]
    request = contents_request(path, wanted, _REMEDY, TOTAL_LIMIT_BYTES, process, comment=True)
    reply = yield from _wait(Decoding(**request), lambda: done, note)
    return [reply[str(place)] for place in range(len(members))]


def _wait(decoding: Decoding, done: Callable[[], float], note: str) -> Steps[dict[str, Any]]:
    """The reply of a decoder, in steps; who closes them ends the decoder."""
    is_over = False
    try:
        while not decoding.wait(_PATIENCE_S):
            yield Step(done(), note)
        is_over = True
        reply: dict[str, Any] = decoding.result()
        return reply
    finally:
        if not is_over:
            decoding.cancel()


def _spell(entry: Entry) -> str:
    """The name as it was meant: some packers write UTF-8 without saying so."""
    if entry.flags & 0x800:
        return entry.name
    try:
        return entry.name.encode("cp437").decode("utf-8")
    except UnicodeError:
        return entry.name


def _normal(name: str) -> str:
    """With slashes, also where a packer wrote backslashes, and without `./`."""
    return str(PurePosixPath(name.replace("\\", "/")))


def _tar_members(path: Path, size_bytes: int, tar: IO[bytes], packed: str, process: str) -> Steps[list[_Member]]:
    """The files of a tar, which is inflated into the file `tar` where it is packed."""
    limit = min(TOTAL_LIMIT_BYTES, RATIO_LIMIT * size_bytes + RATIO_FLOOR_BYTES)
    decoding = Decoding(
        "engine.storage.archive_child:decode_tar",
        path,
        limit_bytes=TOTAL_LIMIT_BYTES,
        timeout_s=_LIMIT_S,
        process=process,
        as_file=True,
        scratch=tar if packed else None,
        remedy=_REMEDY,
        member_limit=MEMBER_LIMIT,
        packed=packed,
        max_bytes=limit,
    )
    reply = yield from _wait(decoding, lambda: 0.0, "Unpacking")
    if "too_large" in reply:
        raise _too_large(path, reply["too_large"], size_bytes)
    return [_Member(_normal(name), size, place) for name, size, place in reply["members"]]


def _find_unnamed(folder: Path) -> IO[bytes]:
    try:
        return tempfile.TemporaryFile(dir=folder)
    except OSError as error:
        raise OutputError(folder, f"cannot be written ({one_line(error)})", "Check its permissions") from None


def _check_names(path: Path, members: Iterable[_Member]) -> None:
    for member in members:
        name = member.name
        parts = name.split("/")
        odd = any(unicodedata.category(letter) == "Cc" for letter in name)
        if odd or ".." in parts or not parts[0] or parts[0][1:2] == ":" or len(os.fsencode(_last(name))) > 255:
            raise InputError(path, f"holds a member with an impossible name, {show(name)}", _REMEDY)


def _check_sizes(path: Path, members: Sequence[_Member], packed_bytes: int) -> None:
    total = sum(member.size_bytes for member in members)
    if total > min(TOTAL_LIMIT_BYTES, RATIO_LIMIT * packed_bytes + RATIO_FLOOR_BYTES):
        raise _too_large(path, total, packed_bytes)


def _too_large(path: Path, total_bytes: int, packed_bytes: int) -> InputError:
    if total_bytes > TOTAL_LIMIT_BYTES:
        problem = f"would unpack to more than {TOTAL_LIMIT_BYTES >> 30} GiB"
        return InputError(path, problem, "Unpack it yourself and give the folder")
    return InputError(path, f"would unpack to more than {RATIO_LIMIT} times its size", _REMEDY)


def _check_collisions(path: Path, members: Iterable[_Member]) -> None:
    """No two names that some system takes for one."""
    seen: dict[str, _Member] = {}
    for member in members:
        first = seen.setdefault(unicodedata.normalize("NFC", _last(member.name)).casefold(), member)
        if first is not member:
            raise InputError(path, f"holds both {show(first.name)} and {show(member.name)}", _REMEDY)


def _copy(path: Path, member: _Member, tar: IO[bytes], output: IO[bytes], done: float) -> Steps[None]:
    """Write the content of a member, which lies in a tar as it is."""
    left = member.size_bytes
    tar.seek(member.place)
    while left:
        piece = tar.read(min(left, _PIECE_BYTES))
        if not piece:
            raise InputError(path, f"{show(member.name)} in it is damaged (it is cut short)", _REMEDY)
        output.write(piece)
        left -= len(piece)
        yield Step(done, f"Unpacking {_last(member.name)}")
