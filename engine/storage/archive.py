"""A folder or zip of known members that someone else made, read without trusting it and without unpacking it.

Only the names that the caller knows are let in, which also shuts out absolute paths, `..`, drive letters, other
spellings, nested archives and links. Counts and sizes are checked before anything is allocated, first in the zip's
end record (so that a million members cost nothing), then member by member; while inflating no more is produced than
was declared, and the checksum of the zip must agree.
Limits: 10 000 members, 64 GiB in all, 100 times the packed size plus 10 MB. Memory: one member; the zip stays on the
disk, where another program can change it between two reads, so what matters has a fingerprint of its own.
"""

from __future__ import annotations

import os
import stat
import struct
import zipfile
import zlib
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from types import MappingProxyType

from engine.core.errors import InputError
from engine.storage.untrusted import opened, read_bytes

MEMBER_LIMIT = 10_000
TOTAL_LIMIT_BYTES = 4 << 30
BUNDLE_LIMIT_BYTES = 64 << 30
RATIO_LIMIT = 100
RATIO_FLOOR_BYTES = 10_000_000

#: Files that file managers leave in folders; not ours, and harmless.
IGNORED = frozenset({".DS_Store", "Thumbs.db", "desktop.ini"})

_DIRECTORY_LIMIT_BYTES = 400 * MEMBER_LIMIT
_END, _END_64, _LOCATOR_64 = b"PK\5\6", b"PK\6\6", b"PK\6\7"
#: As much of the end of a zip without a comment as holds its end records.
_END_BYTES = 22 + 76
#: As much of the end of a zip as can hold its end record with a comment.
TAIL_BYTES = 22 + 76 + 65535

_REMEDY = "Ask for the bundle again from where it came"
#: Exceptions that reading a damaged zip may raise.
DAMAGE = (
    zipfile.BadZipFile, zlib.error, struct.error, EOFError, NotImplementedError, OSError, OverflowError, RuntimeError,
    ValueError,
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class Archive:
    """Members of a folder or zip: `sizes` in bytes by member name, and whether it `is_zip`."""

    path: Path
    sizes: Mapping[str, int]
    size_bytes: int
    is_zip: bool

    def read(self, name: str, limit_bytes: int = BUNDLE_LIMIT_BYTES) -> bytes:
        """The content of the member `name`; InputError where it is missing, too large or damaged."""
        if name not in self.sizes:
            raise InputError(self.path, f"has no member {name}", _REMEDY)
        if self.sizes[name] > limit_bytes:
            raise InputError(self.path, f"{name} has {self.sizes[name]:,} bytes, more than {limit_bytes:,}", _REMEDY)
        if not self.is_zip:
            return read_bytes(self.path / name, limit_bytes)
        with opened(self.path, BUNDLE_LIMIT_BYTES) as (file, _):
            try:
                with zipfile.ZipFile(file) as archive, archive.open(mode="r", name=name) as member:
                    content = member.read(self.sizes[name] + 1)
            except (*DAMAGE, KeyError) as error:
                raise InputError(self.path, f"{name} is damaged ({one_line(error)})", _REMEDY) from None
        if len(content) != self.sizes[name]:
            raise InputError(self.path, f"{name} is damaged (its size is not the declared one)", _REMEDY)
        return content


def open_archive(path: str | os.PathLike[str], known: Collection[str]) -> Archive:
    """Look into a folder or zip that may hold `known` members and nothing else; InputError says what is amiss."""
    try:
        is_folder = stat.S_ISDIR(os.stat(path).st_mode)  # noqa: PTH116 - a Path refuses some odd names
    except (OSError, ValueError) as error:
        raise InputError(path, f"cannot be read ({one_line(error)})", "Check that it exists and may be read") from None
    return _open_folder(Path(path), known) if is_folder else _open_zip(Path(path), known)


def _open_folder(path: Path, known: Collection[str]) -> Archive:
    sizes: dict[str, int] = {}
    folders = {os.fspath(PurePosixPath(name).parent) for name in known}
    for folder in sorted(folders):
        for name, status in _listing(path / folder):
            member = name if folder == "." else f"{folder}/{name}"
            if name in IGNORED or (stat.S_ISDIR(status.st_mode) and member in folders):
                continue
            if not stat.S_ISREG(status.st_mode):
                raise InputError(path, f"{shown(member)} is not a regular file", _REMEDY)
            sizes[member] = status.st_size
    _check(path, sizes, known)
    return Archive(path, MappingProxyType(sizes), sum(sizes.values()), is_zip=False)


def _listing(folder: Path) -> list[tuple[str, os.stat_result]]:
    """Names and kinds of what lies in `folder`, links not followed; nothing where there is no such folder."""
    if not folder.is_dir():
        return []
    found = []
    try:
        with os.scandir(folder) as entries:
            for entry in entries:
                found.append((entry.name, entry.stat(follow_symlinks=False)))
                if len(found) > MEMBER_LIMIT:
                    raise InputError(folder, f"holds more than {MEMBER_LIMIT:,} files", "Choose a bundle")
    except OSError as error:
        raise InputError(folder, f"cannot be read ({one_line(error)})", "Check its permissions") from None
    return found


def _open_zip(path: Path, known: Collection[str]) -> Archive:
    with opened(path, BUNDLE_LIMIT_BYTES) as (file, size_bytes):
        head = file.read(4)
        file.seek(max(0, size_bytes - _END_BYTES))
        check_end_record(path, head, file.read(), size_bytes, "Give a .lightarc file or a bundle folder")
        try:
            with zipfile.ZipFile(file) as archive:
                entries = archive.infolist()
        except DAMAGE as error:
            raise InputError(path, f"is a damaged zip archive ({one_line(error)})", _REMEDY) from None
    folders = {f"{PurePosixPath(name).parent}/" for name in known}
    sizes: dict[str, int] = {}
    for entry in entries:
        if entry.orig_filename in folders and entry.file_size == 0:
            continue
        if entry.orig_filename in sizes:
            raise InputError(path, f"holds {shown(entry.orig_filename)} twice", _REMEDY)
        check_entry(path, entry, _REMEDY)
        sizes[entry.orig_filename] = entry.file_size
    _check(path, sizes, known)
    if sum(sizes.values()) > RATIO_LIMIT * size_bytes + RATIO_FLOOR_BYTES:
        raise InputError(path, f"would unpack to more than {RATIO_LIMIT} times its size", _REMEDY)
    return Archive(path, MappingProxyType(sizes), size_bytes, is_zip=True)


def check_end_record(path: Path, head: bytes, tail: bytes, size_bytes: int, remedy: str, comment: bool = False) -> None:
    """Refuse what is no zip, is cut short, has data before or after it, or lists too much, by its last bytes alone.

    `head` is how the file of `size_bytes` begins, and `tail` how it ends: at least 98 bytes, or all; `TAIL_BYTES` where
    a `comment` may follow the record.
    """
    start = tail.rfind(_END) if comment else len(tail) - 22
    after = tail[start + 22 :] if start >= 0 else b""
    if start < 0 or tail[start : start + 4] != _END or len(tail) < start + 22 or _length(tail, start) != len(after):
        kind = "is cut short or has data after its end" if head[:4] == b"PK\3\4" else "is no zip archive"
        raise InputError(path, kind, remedy)
    _, disk, first_disk, _, count, size, offset, _ = struct.unpack("<4s4H2LH", tail[start : start + 22])
    if tail[max(0, start - 20) : start][:4] == _LOCATOR_64:
        start -= 20 + 56
        if start < 0 or tail[start : start + 4] != _END_64:
            raise InputError(path, "is a damaged zip archive (no 64-bit end record)", remedy)
        count, size, offset = struct.unpack("<3Q", tail[start + 32 : start + 56])
    if count > MEMBER_LIMIT or size > _DIRECTORY_LIMIT_BYTES:
        raise InputError(path, f"lists {count:,} members in {size:,} bytes, more than an archive may", remedy)
    if disk or first_disk or offset + size != size_bytes - len(tail) + start:
        raise InputError(path, "is a damaged zip archive (its end record does not fit its length)", remedy)


def _length(tail: bytes, start: int) -> int:
    """Of the comment after the end record at `start`."""
    length: int = struct.unpack("<H", tail[start + 20 : start + 22])[0]
    return length


def check_entry(path: Path, entry: zipfile.ZipInfo, remedy: str) -> None:
    """Refuse a member that is no plain file, is encrypted, packed by an unknown method, or inflates too much."""
    name = shown(entry.orig_filename)
    kind = stat.S_IFMT(entry.external_attr >> 16)
    if entry.orig_filename != entry.filename:
        raise InputError(path, f"holds a member with an impossible name, {name}", remedy)
    if kind not in (0, stat.S_IFREG):
        raise InputError(path, f"{name} is not a regular file", remedy)
    if entry.flag_bits & 0x1:
        raise InputError(path, f"{name} is encrypted", "Ask for it without a password")
    if entry.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        raise InputError(path, f"{name} is packed by an unknown method", "Pack it with deflate or not at all")
    if entry.file_size > RATIO_LIMIT * entry.compress_size + RATIO_FLOOR_BYTES:
        raise InputError(path, f"{name} would unpack to more than {RATIO_LIMIT} times its size", remedy)


def _check(path: Path, sizes: Mapping[str, int], known: Collection[str]) -> None:
    unknown = sorted(name for name in sizes if name not in known)
    if unknown:
        more = f" and {len(unknown) - 1} more" if len(unknown) > 1 else ""
        raise InputError(path, f"holds what no bundle holds: {shown(unknown[0])}{more}", _REMEDY)
    if sum(sizes.values()) > BUNDLE_LIMIT_BYTES:
        raise InputError(path, f"would unpack to more than {BUNDLE_LIMIT_BYTES >> 30} GiB", _REMEDY)


def shown(name: str) -> str:
    """A name of a stranger, harmless and short."""
    return ascii(name) if len(name) <= 80 else f"{name[:80]!a}… ({len(name)} characters)"


def one_line(error: BaseException) -> str:
    """Message of an error, on one line."""
    return " ".join((getattr(error, "strerror", None) or str(error) or type(error).__name__).split())[:120]
