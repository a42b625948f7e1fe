"""Decoders of archives: their lists of members and the contents of some, out of a zip or tar that someone else made.

They run in a decoder process (`engine.storage.untrusted`), which gets the archive as an open file. Counts are checked
before anything is allocated, first in the zip's end record, so that a million members cost nothing; while inflating no
more is produced than was declared, and the checksums of zip, gzip, bzip2 and xz must agree.
Cost: bound by inflating, some 100 MB/s; memory is that of the contents that are asked for.
"""

from __future__ import annotations

import bz2
import lzma
import os
import struct
import tarfile
import zipfile
import zlib
from collections.abc import Callable, Sequence
from typing import IO, Any

import numpy as np

from engine.core.errors import InputError
from engine.storage.shared_memory import result_array

#: As much of the end of a zip as can hold its end record with a comment, and as much without one.
_TAIL_BYTES, _END_BYTES = 22 + 76 + 65535, 22 + 76
_END, _END_64, _LOCATOR_64 = b"PK\5\6", b"PK\6\6", b"PK\6\7"
_ENTRY_BYTES = 400

_PIECE_BYTES = 1 << 20
#: Names of tar members may take this much, which is also all that its reader takes at once.
_HEADER_LIMIT_BYTES = 1 << 20
_TAR_BLOCK = 512
_XZ_MEMORY_BYTES = 256 << 20
_INFLATERS: dict[str, Callable[[], Any]] = {
    "gzip": lambda: zlib.decompressobj(wbits=31),
    "bzip2": bz2.BZ2Decompressor,
    "xz": lambda: lzma.LZMADecompressor(lzma.FORMAT_XZ, memlimit=_XZ_MEMORY_BYTES),
}

#: Exceptions that reading a damaged archive may raise.
_DAMAGE = (
    *(zipfile.BadZipFile, zlib.error, struct.error, tarfile.TarError, lzma.LZMAError, EOFError, NotImplementedError),
    *(OSError, OverflowError, RuntimeError, ValueError, LookupError),
)


def decode_zip(
    file: IO[bytes], name: str, remedy: str, other: str, member_limit: int, comment: bool
) -> dict[str, list[Any]]:
    """The `members` of a zip: names as stored and as read, sizes, packed sizes, attributes, flags and methods.

    Raises InputError for what is damaged (with `remedy`), no zip at all (`other`), or lists more than `member_limit`;
    a `comment` at the end is let in or not.
    """
    archive = _open(file, name, remedy, other, member_limit, comment)
    return {
        "members": [
            [
                *(entry.orig_filename, entry.filename, entry.file_size, entry.compress_size),
                *(entry.external_attr, entry.flag_bits, entry.compress_type),
            ]
            for entry in archive.infolist()
        ]
    }


def decode_zip_contents(
    file: IO[bytes], name: str, remedy: str, member_limit: int, comment: bool, wanted: Sequence[Sequence[Any]]
) -> dict[str, Any]:
    """The contents of the `wanted` members, pairs of a number in the list and a size, by their place among them.

    Raises InputError where one is damaged, or has not exactly its size.
    """
    entries = _open(file, name, remedy, remedy, member_limit, comment)
    members = entries.infolist()
    found = {}
    for place, (number, size_bytes) in enumerate(wanted):
        entry = members[number]
        content = result_array((size_bytes,), "u1")
        try:
            with entries.open(entry) as member:
                count = 0
                while count < size_bytes and (piece := member.read(min(_PIECE_BYTES, size_bytes - count))):
                    content[count : count + len(piece)] = np.frombuffer(piece, np.uint8)
                    count += len(piece)
                more = member.read(1)
        except _DAMAGE as error:
            raise InputError(name, f"{show(entry.filename)} in it is damaged ({one_line(error)})", remedy) from None
        if count != size_bytes or entry.file_size != size_bytes or more:
            problem = f"{show(entry.filename)} in it is damaged (its size is not the declared one)"
            raise InputError(name, problem, remedy)
        found[str(place)] = content
    return found


def open_member(file: IO[bytes], name: str, number: int) -> IO[bytes]:
    """The member at a place in the list of a zip that has been looked into, as a file; for -1 the file itself."""
    if number < 0:
        file.seek(0)
        return file
    try:
        archive = zipfile.ZipFile(file)
        return archive.open(archive.infolist()[number])
    except _DAMAGE as error:
        raise InputError(name, f"is damaged ({one_line(error)})", "Ask for it again from where it came") from None


def _open(file: IO[bytes], name: str, remedy: str, other: str, member_limit: int, comment: bool) -> zipfile.ZipFile:
    size_bytes = file.seek(0, os.SEEK_END)
    file.seek(0)
    head = file.read(4)
    file.seek(max(0, size_bytes - (_TAIL_BYTES if comment else _END_BYTES)))
    _check_end_record(name, head, file.read(), size_bytes, other, member_limit, comment)
    file.seek(0)
    try:
        return zipfile.ZipFile(file)
    except _DAMAGE as error:
        raise InputError(name, f"is a damaged zip archive ({one_line(error)})", remedy) from None


def _check_end_record(
    name: str, head: bytes, tail: bytes, size_bytes: int, remedy: str, member_limit: int, comment: bool
) -> None:
    """Refuse what is not a zip, is cut short, has data before or after it, or lists too much, by its last bytes alone.

    `head` is how the file of `size_bytes` begins, and `tail` how it ends.
    """
    start = tail.rfind(_END) if comment else len(tail) - 22
    after = tail[start + 22 :] if start >= 0 else b""
    if start < 0 or tail[start : start + 4] != _END or len(tail) < start + 22 or _length(tail, start) != len(after):
        kind = "is cut short or has data after its end" if head[:4] == b"PK\3\4" else "is not a zip archive"
        raise InputError(name, kind, remedy)
    _, disk, first_disk, _, count, size, offset, _ = struct.unpack("<4s4H2LH", tail[start : start + 22])
    if tail[max(0, start - 20) : start][:4] == _LOCATOR_64:
        start -= 20 + 56
        if start < 0 or tail[start : start + 4] != _END_64:
            raise InputError(name, "is a damaged zip archive (no 64-bit end record)", remedy)
        count, size, offset = struct.unpack("<3Q", tail[start + 32 : start + 56])
    if count > member_limit or size > _ENTRY_BYTES * member_limit:
        raise InputError(name, f"lists {count:,} members in {size:,} bytes, more than an archive may", remedy)
    if disk or first_disk or offset + size != size_bytes - len(tail) + start:
        raise InputError(name, "is a damaged zip archive (its end record does not fit its length)", remedy)


def _length(tail: bytes, start: int) -> int:
    """The length of the comment after the end record at `start`."""
    length: int = struct.unpack("<H", tail[start + 20 : start + 22])[0]
    return length


def decode_tar(
    file: IO[bytes],
    name: str,
    remedy: str,
    member_limit: int,
    packed: str = "",
    max_bytes: int = 0,
    scratch: IO[bytes] | None = None,
) -> dict[str, Any]:
    """The `members` of a tar: names, sizes, and the places of their contents in the tar.

    Where it is `packed` ('gzip', 'bzip2' or 'xz'), it is inflated into `scratch` first, of at most `max_bytes`: more
    gives `too_large`, the bytes that it has by then. Raises InputError for what is damaged, has no end, holds what is
    no plain file, or more than `member_limit`.
    """
    if scratch is not None:
        written = _inflate(file, name, remedy, scratch, packed, max_bytes)
        if written > max_bytes:
            return {"too_large": written}
        scratch.flush()
        file = scratch
    return {"members": _tar_members(file, name, remedy, member_limit)}


class _Bounded:
    """A file of which nobody can ask for much at once, as the headers of a tar may try."""

    def __init__(self, file: IO[bytes]) -> None:
        self.seek, self.tell = file.seek, file.tell
        self._read = file.read

    def read(self, size: int) -> bytes:
        if not 0 <= size <= _HEADER_LIMIT_BYTES:
            raise tarfile.ReadError(f"a header of {size:,} bytes")
        return self._read(size)


def _tar_members(file: IO[bytes], name: str, remedy: str, member_limit: int) -> list[Any]:
    """The files of a tar, which must end as a whole one does: tarfile takes what it cannot read for the end."""
    members: list[Any] = []
    try:
        file.seek(0)
        archive = tarfile.TarFile(fileobj=_Bounded(file))  # type: ignore[arg-type]
        for entry in archive:
            if entry.isdir():
                continue
            if not entry.isreg() or entry.sparse is not None:
                raise InputError(name, f"{show(entry.name)} is not a regular file", remedy)
            if len(members) == member_limit:
                raise InputError(name, f"lists more than {member_limit:,} members", remedy)
            members.append([entry.name, entry.size, entry.offset_data])
        file.seek(archive.offset)
        end = file.read(_TAR_BLOCK)
    except _DAMAGE as error:
        raise InputError(name, f"is not a tar archive, or a damaged one ({one_line(error)})", remedy) from None
    if end != bytes(_TAR_BLOCK):
        raise InputError(name, "is cut short or damaged: its list of members has no end", remedy)
    return members


def _inflate(file: IO[bytes], name: str, remedy: str, target: IO[bytes], packed: str, limit_bytes: int) -> int:
    """The packed tar, one stream or several, into `target`; the bytes written, or more than `limit_bytes`."""
    file.seek(0)
    stream, content, written = _INFLATERS[packed](), b"", 0
    while True:
        try:
            if not content and getattr(stream, "needs_input", True):
                content = file.read(_PIECE_BYTES)
                if not content:
                    break
            piece = stream.decompress(content, _PIECE_BYTES)
        except _DAMAGE as error:
            raise InputError(name, f"is damaged ({one_line(error)})", remedy) from None
        content = getattr(stream, "unconsumed_tail", b"")
        written += len(piece)
        if written > limit_bytes:
            return written
        try:
            target.write(piece)
        except OSError as error:
            remedy = "Free some space, or unpack it yourself and give the folder"
            raise InputError(name, f"cannot be unpacked ({one_line(error)})", remedy) from None
        if stream.eof:
            content = stream.unused_data.lstrip(b"\0") or file.read(_PIECE_BYTES)
            if not content:
                return written
            stream = _INFLATERS[packed]()
    raise InputError(name, "is cut short", remedy)


def show(name: str) -> str:
    """A name of a stranger, harmless and short."""
    return ascii(name) if len(name) <= 80 else f"{name[:80]!a}… ({len(name)} characters)"


def one_line(error: BaseException) -> str:
    """Message of an error, on one line."""
    return " ".join((getattr(error, "strerror", None) or str(error) or type(error).__name__).split())[:120]
