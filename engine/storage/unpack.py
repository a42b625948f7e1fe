"""Files out of a zip or tar that someone else made, into a folder of ours, without trusting it.

Members are written under the last part of their name only, so none can leave the folder; names that try are refused
all the same, as are links, devices, sparse files, encrypted members and names that collide. Counts and sizes are
checked before anything is written (limits of `engine.storage.archive`), no more is produced than was declared, and the
checksums of zip, gzip, bzip2 and xz must agree. A packed tar is first inflated into an unnamed file.
Cost: bound by inflating, some 100 MB/s; memory is that of one piece.
"""

from __future__ import annotations

import bz2
import lzma
import os
import stat
import tarfile
import tempfile
import unicodedata
import zipfile
import zlib
from collections.abc import Callable, Iterable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from pathlib import Path, PurePosixPath
from typing import IO, Any

from engine.core.errors import InputError, OutputError
from engine.core.steps import Step, Steps
from engine.storage.archive import (
    DAMAGE,
    MEMBER_LIMIT,
    RATIO_FLOOR_BYTES,
    RATIO_LIMIT,
    TAIL_BYTES,
    TOTAL_LIMIT_BYTES,
    check_end_record,
    check_entry,
    one_line,
    shown,
)
from engine.storage.atomic import atomic_file, require_space
from engine.storage.untrusted import opened

_PIECE_BYTES = 1 << 20
#: Names of tar members may take this much, which is also all that its reader takes at once.
_HEADER_LIMIT_BYTES = 1 << 20
_TAR_BLOCK = 512
_XZ_MEMORY_BYTES = 256 << 20
_REMEDY = "Copy it again from where it came, or unpack it yourself and give the folder"
_FAILURES = (*DAMAGE, tarfile.TarError, lzma.LZMAError)

_ZIP, _GZIP, _BZIP2, _XZ, _TAR = b"PK", b"\x1f\x8b", b"BZh", b"\xfd7zXZ\0", b"ustar"
_UNREAD = {b"7z\xbc\xaf\x27\x1c": "7z", b"Rar!": "RAR"}
_INFLATERS: dict[bytes, Callable[[], Any]] = {
    _GZIP: lambda: zlib.decompressobj(wbits=31),
    _BZIP2: bz2.BZ2Decompressor,
    _XZ: lambda: lzma.LZMADecompressor(lzma.FORMAT_XZ, memlimit=_XZ_MEMORY_BYTES),
}


@dataclass(frozen=True)
class _Member:
    """A file in an archive: its whole name with slashes, its size, and how its content is opened."""

    name: str
    size_bytes: int
    open: Callable[[], IO[bytes]]


def is_archive(path: Path) -> bool:
    """True if the regular file `path` begins as an archive does, also one that is not read (7z, RAR)."""
    try:
        if not path.is_file():
            return False
        with path.open("rb") as file:
            head = file.read(_TAR_BLOCK)
    except (OSError, ValueError):
        return False
    return head.startswith((_ZIP, *_INFLATERS, *_UNREAD)) or head[257:262] == _TAR


def zip_names(path: Path) -> list[str]:
    """The names of the files in a zip; InputError where it is damaged or hostile."""
    with ExitStack() as files:
        file, size_bytes = files.enter_context(opened(path, TOTAL_LIMIT_BYTES))
        return [member.name for member in _zip_members(path, files, file, file.read(_TAR_BLOCK), size_bytes)]


def unpack(path: Path, folder: Path, choose: Callable[[Sequence[str]], Sequence[str]]) -> Steps[dict[str, str]]:
    """Write those members of the archive `path` that `choose` picks from their names into `folder`.

    Returned is the member of each file written, by the name of the file. Raises InputError for what is damaged,
    hostile or not read, OutputError where there is no room.
    """
    with ExitStack() as files:
        file, size_bytes = files.enter_context(opened(path, TOTAL_LIMIT_BYTES))
        head = file.read(_TAR_BLOCK)
        for start, name in _UNREAD.items():
            if head.startswith(start):
                raise InputError(path, f"is a {name} archive, which is not read", "Unpack it, or pack it as zip")
        if head.startswith(_ZIP):
            members = _zip_members(path, files, file, head, size_bytes)
        else:
            inflater = next((make for start, make in _INFLATERS.items() if head.startswith(start)), None)
            if inflater is not None:
                file = files.enter_context(_unnamed(folder))
                yield from _inflate(path, files, file, inflater)
            members = _tar_members(path, files, file)
        _check_names(path, members)
        _check_sizes(path, members, size_bytes)
        wanted = set(choose([member.name for member in members]))
        chosen = [member for member in members if member.name in wanted]
        _check_collisions(path, chosen)
        require_space(folder / "member", sum(member.size_bytes for member in chosen))
        for index, member in enumerate(chosen):
            yield Step(index / len(chosen), f"Unpacking {index + 1} of {len(chosen)}")
            yield from _write(path, member, folder / _last(member.name), index / len(chosen))
    return {_last(member.name): member.name for member in chosen}


def _last(name: str) -> str:
    return PurePosixPath(name).name


def _zip_members(path: Path, files: ExitStack, file: IO[bytes], head: bytes, size_bytes: int) -> list[_Member]:
    try:
        file.seek(max(0, size_bytes - TAIL_BYTES))
        check_end_record(path, head, file.read(TAIL_BYTES), size_bytes, _REMEDY, comment=True)
        file.seek(0)
        archive = files.enter_context(zipfile.ZipFile(file))
        entries = archive.infolist()
    except DAMAGE as error:
        raise InputError(path, f"is a damaged zip archive ({one_line(error)})", _REMEDY) from None
    members = []
    for entry in entries:
        if stat.S_ISDIR(entry.external_attr >> 16) or entry.orig_filename.endswith("/"):
            continue
        check_entry(path, entry, _REMEDY)
        members.append(_Member(_normal(_spelled(entry)), entry.file_size, partial(archive.open, entry)))
    return members


def _spelled(entry: zipfile.ZipInfo) -> str:
    """The name as it was meant: some packers write UTF-8 without saying so."""
    if entry.flag_bits & 0x800:
        return entry.filename
    try:
        return entry.filename.encode("cp437").decode("utf-8")
    except UnicodeError:
        return entry.filename


def _normal(name: str) -> str:
    """With slashes, also where a packer wrote backslashes, and without `./`."""
    return str(PurePosixPath(name.replace("\\", "/")))


class _Bounded:
    """A file of which nobody can ask for much at once, as the headers of a tar may try."""

    def __init__(self, file: IO[bytes]) -> None:
        self.seek, self.tell = file.seek, file.tell
        self._read = file.read

    def read(self, size: int) -> bytes:
        if not 0 <= size <= _HEADER_LIMIT_BYTES:
            raise tarfile.ReadError(f"a header of {size:,} bytes")
        return self._read(size)


def _tar_members(path: Path, files: ExitStack, file: IO[bytes]) -> list[_Member]:
    """The files of a tar, which must end as a whole one does: tarfile takes what it cannot read for the end."""
    members: list[_Member] = []
    try:
        file.seek(0)
        archive = files.enter_context(tarfile.TarFile(fileobj=_Bounded(file)))  # type: ignore[arg-type]
        for entry in archive:
            name = _normal(entry.name)
            if entry.isdir():
                continue
            if not entry.isreg() or entry.sparse is not None:
                raise InputError(path, f"{shown(name)} is not a regular file", _REMEDY)
            if len(members) == MEMBER_LIMIT:
                raise InputError(path, f"lists more than {MEMBER_LIMIT:,} members", _REMEDY)
            members.append(_Member(name, entry.size, partial(_extracted, archive, entry)))
        file.seek(archive.offset)
        end = file.read(_TAR_BLOCK)
    except _FAILURES as error:
        raise InputError(path, f"is no tar archive, or a damaged one ({one_line(error)})", _REMEDY) from None
    if end != bytes(_TAR_BLOCK):
        raise InputError(path, "is cut short or damaged: its list of members has no end", _REMEDY)
    return members


def _extracted(archive: tarfile.TarFile, entry: tarfile.TarInfo) -> IO[bytes]:
    file = archive.extractfile(entry)
    if file is None:
        raise tarfile.ReadError("no regular file")
    return file


def _unnamed(folder: Path) -> IO[bytes]:
    try:
        return tempfile.TemporaryFile(dir=folder)
    except OSError as error:
        raise OutputError(folder, f"cannot be written ({one_line(error)})", "Check its permissions") from None


def _inflate(path: Path, files: ExitStack, target: IO[bytes], inflater: Callable[[], Any]) -> Steps[None]:
    """The packed tar `path`, one stream or several, into `target`."""
    source, size_bytes = files.enter_context(opened(path, TOTAL_LIMIT_BYTES))
    limit = min(TOTAL_LIMIT_BYTES, RATIO_LIMIT * size_bytes + RATIO_FLOOR_BYTES)
    stream, packed, written = inflater(), b"", 0
    while True:
        try:
            if not packed and getattr(stream, "needs_input", True):
                packed = source.read(_PIECE_BYTES)
                if not packed:
                    break
            piece = stream.decompress(packed, _PIECE_BYTES)
        except _FAILURES as error:
            raise InputError(path, f"is damaged ({one_line(error)})", _REMEDY) from None
        packed = getattr(stream, "unconsumed_tail", b"")
        written += len(piece)
        if written > limit:
            raise _too_large(path, written, size_bytes)
        _put(target, piece, path)
        yield Step(min(1.0, source.tell() / size_bytes), "Unpacking")
        if stream.eof:
            packed = stream.unused_data.lstrip(b"\0") or source.read(_PIECE_BYTES)
            if not packed:
                return
            stream = inflater()
    raise InputError(path, "is cut short", _REMEDY)


def _put(target: IO[bytes], piece: bytes, path: Path) -> None:
    try:
        target.write(piece)
    except OSError as error:
        remedy = "Free some space, or unpack it yourself and give the folder"
        raise OutputError(path, f"cannot be unpacked ({one_line(error)})", remedy) from None


def _check_names(path: Path, members: Iterable[_Member]) -> None:
    for member in members:
        name = member.name
        parts = name.split("/")
        odd = any(unicodedata.category(letter) == "Cc" for letter in name)
        if odd or ".." in parts or not parts[0] or parts[0][1:2] == ":" or len(os.fsencode(_last(name))) > 255:
            raise InputError(path, f"holds a member with an impossible name, {shown(name)}", _REMEDY)


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
            raise InputError(path, f"holds both {shown(first.name)} and {shown(member.name)}", _REMEDY)


def _write(path: Path, member: _Member, target: Path, before: float) -> Steps[None]:
    """One member, no more and no less than was declared, whose checksum (of a zip) agrees."""
    with atomic_file(target) as output:
        written = 0
        try:
            content = member.open()
        except _FAILURES as error:
            raise _damaged(path, member, one_line(error)) from None
        with content:
            while True:
                try:
                    piece = content.read(_PIECE_BYTES)
                except _FAILURES as error:
                    raise _damaged(path, member, one_line(error)) from None
                written += len(piece)
                if written > member.size_bytes or (not piece and written < member.size_bytes):
                    raise _damaged(path, member, "its size is not the declared one")
                if not piece:
                    return
                output.write(piece)
                yield Step(before, f"Unpacking {target.name}")


def _damaged(path: Path, member: _Member, why: str) -> InputError:
    return InputError(path, f"{shown(member.name)} in it is damaged ({why})", _REMEDY)
