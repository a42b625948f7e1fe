"""A folder or zip of known members that someone else made, read without trusting it and without unpacking it.

Only the names that the caller knows are let in, which also shuts out absolute paths, `..`, drive letters, other
spellings, nested archives and links. Counts and sizes are checked before anything is allocated. A zip is read in a
decoder process (`engine.storage.archive_child`): its list of members, and each member when it is asked for.
Limits: 10 000 members, 64 GiB in all, 100 times the packed size plus 10 MB. Memory: one member; the zip stays on the
disk, where another program can change it between two reads, so what matters has a fingerprint of its own.
"""

from __future__ import annotations

import os
import stat
import zipfile
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from engine.core.errors import InputError
from engine.storage.archive_child import one_line, show
from engine.storage.untrusted import decode_content, decode_in_child, read_bytes, time_limit_s

MEMBER_LIMIT = 10_000
TOTAL_LIMIT_BYTES = 4 << 30
BUNDLE_LIMIT_BYTES = 64 << 30
RATIO_LIMIT = 100
RATIO_FLOOR_BYTES = 10_000_000

#: Files that file managers leave in folders; not ours, and harmless.
IGNORED = frozenset({".DS_Store", "Thumbs.db", "desktop.ini"})

_REMEDY = "Ask for the bundle again from where it came"
_DECODERS = "engine.storage.archive_child"
#: Address space of a decoder beside the content of a member.
_MEMORY_BYTES = 2 << 30


class Entry(NamedTuple):
    """A member in the list of a zip: its name as `stored` and as read, sizes, attributes, flags and method."""

    stored: str
    name: str
    size_bytes: int
    packed_bytes: int
    attributes: int
    flags: int
    method: int


@dataclass(frozen=True, eq=False)
class Archive:
    """Members of a folder or zip: `sizes` in bytes by member name, and whether it `is_zip`.

    `numbers` are the places of the members in the list of a zip, and `process` is the decoder process that reads it.
    """

    path: Path
    sizes: Mapping[str, int]
    size_bytes: int
    is_zip: bool
    numbers: Mapping[str, int] = field(default_factory=dict)
    process: str = ""

    def read(self, name: str, limit_bytes: int = BUNDLE_LIMIT_BYTES) -> bytes:
        """The content of the member `name`; InputError where it is missing, too large or damaged."""
        return self.read_array(name, limit_bytes).tobytes()

    def read_array(self, name: str, limit_bytes: int = BUNDLE_LIMIT_BYTES) -> NDArray[np.uint8]:
        """The same as an array, which lies on the disk while memory is limited."""
        size_bytes = self._size(name)
        if size_bytes > limit_bytes:
            raise InputError(self.path, f"{name} has {size_bytes:,} bytes, more than {limit_bytes:,}", _REMEDY)
        if not self.is_zip:
            return np.frombuffer(read_bytes(self.path / name, limit_bytes), np.uint8)
        wanted = [(self.numbers[name], size_bytes)]
        (content,) = zip_contents(self.path, wanted, _REMEDY, BUNDLE_LIMIT_BYTES, self.process)
        return content

    def decode(self, decoder: str, name: str, fingerprint: tuple[int, str], **options: Any) -> dict[str, Any]:
        """Run `decoder` (`engine.storage.untrusted.decode_in_child`) on the member `name`, which nobody reads whole.

        It gets the archive as an open file, and as `member` the place in its list, -1 where the file is the member, and
        the size and SHA-256 of the `fingerprint`, which it compares. InputError names the member.
        """
        self._size(name)
        number, path = (self.numbers[name], self.path) if self.is_zip else (-1, self.path / name)
        more: dict[str, Any] = {"as_file": True, "limit_bytes": BUNDLE_LIMIT_BYTES, "member": [number, *fingerprint]}
        try:
            return decode_in_child(decoder, path, **more, **options)
        except InputError as error:
            raise type(error)(self.path / name, error.problem, error.remedy) from None

    def _size(self, name: str) -> int:
        """Bytes of a member; InputError where it is missing."""
        if name not in self.sizes:
            raise InputError(self.path, f"has no member {name}", _REMEDY)
        return self.sizes[name]


def zip_entries(
    path: Path, remedy: str, other: str, limit_bytes: int, process: str = "", *, comment: bool = False
) -> list[Entry]:
    """The members of a zip of at most `limit_bytes`; InputError where it is damaged (`remedy`) or no zip (`other`)."""
    reply = decode_in_child(
        f"{_DECODERS}:decode_zip",
        path,
        limit_bytes=limit_bytes,
        process=process,
        as_file=True,
        remedy=remedy,
        other=other,
        member_limit=MEMBER_LIMIT,
        comment=comment,
    )
    return [Entry(*fields) for fields in reply["members"]]


def zip_contents(
    path: Path,
    wanted: Sequence[tuple[int, int]],
    remedy: str,
    limit_bytes: int,
    process: str = "",
    *,
    comment: bool = False,
) -> list[NDArray[np.uint8]]:
    """The contents of members of a zip, wanted by their places in its list and their sizes; InputError if damaged."""
    reply = decode_in_child(**contents_request(path, wanted, remedy, limit_bytes, process, comment=comment))
    return [reply[str(place)] for place in range(len(wanted))]


def contents_request(
    path: Path,
    wanted: Sequence[tuple[int, int]],
    remedy: str,
    limit_bytes: int,
    process: str = "",
    *,
    comment: bool = False,
) -> dict[str, Any]:
    """The arguments of `decode_in_child` for `zip_contents`, whose reply holds each content by its place in text."""
    size_bytes = sum(size for _, size in wanted)
    return {
        "decoder": f"{_DECODERS}:decode_zip_contents",
        "path": path,
        "limit_bytes": limit_bytes,
        "memory_bytes": _MEMORY_BYTES + 2 * size_bytes,
        "timeout_s": time_limit_s(size_bytes),
        "process": process,
        "as_file": True,
        "remedy": remedy,
        "member_limit": MEMBER_LIMIT,
        "comment": comment,
        "wanted": wanted,
    }


def json_of(
    content: bytes,
    path: str | os.PathLike[str],
    member: str,
    process: str,
    remedy: str = "Export the bundle again",
) -> Any:
    """The JSON of a member, read in a decoder process; errors as of `engine.storage.text.read_json`."""
    options: dict[str, Any] = {"member": member, "remedy": remedy}
    return decode_content("engine.storage.text:decode_json", path, content, process=process, **options)["value"]


def open_archive(path: str | os.PathLike[str], known: Collection[str], process: str = "") -> Archive:
    """Look into a folder or zip that may hold `known` members and nothing else; InputError says what is amiss.

    `process` is the module whose decoder process reads a zip, where one is there already.
    """
    try:
        is_folder = stat.S_ISDIR(os.stat(path).st_mode)  # noqa: PTH116 - a Path refuses some odd names
    except (OSError, ValueError) as error:
        raise InputError(path, f"cannot be read ({one_line(error)})", "Check that it exists and may be read") from None
    return _open_folder(Path(path), known) if is_folder else _open_zip(Path(path), known, process)


def _open_folder(path: Path, known: Collection[str]) -> Archive:
    sizes: dict[str, int] = {}
    folders = {os.fspath(PurePosixPath(name).parent) for name in known}
    for folder in sorted(folders):
        for name, status in _listing(path / folder):
            member = name if folder == "." else f"{folder}/{name}"
            if name in IGNORED or (stat.S_ISDIR(status.st_mode) and member in folders):
                continue
            if not stat.S_ISREG(status.st_mode):
                raise InputError(path, f"{show(member)} is not a regular file", _REMEDY)
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


def _open_zip(path: Path, known: Collection[str], process: str) -> Archive:
    other = "Choose a .lightarc file or a bundle folder"
    entries = zip_entries(path, _REMEDY, other, BUNDLE_LIMIT_BYTES, process)
    size_bytes = path.stat().st_size
    folders = {f"{PurePosixPath(name).parent}/" for name in known}
    sizes, numbers = dict[str, int](), dict[str, int]()
    for number, entry in enumerate(entries):
        if entry.stored in folders and entry.size_bytes == 0:
            continue
        if entry.stored in sizes:
            raise InputError(path, f"holds {show(entry.stored)} twice", _REMEDY)
        check_entry(path, entry, _REMEDY)
        sizes[entry.stored], numbers[entry.stored] = entry.size_bytes, number
    _check(path, sizes, known)
    if sum(sizes.values()) > RATIO_LIMIT * size_bytes + RATIO_FLOOR_BYTES:
        raise InputError(path, f"would unpack to more than {RATIO_LIMIT} times its size", _REMEDY)
    return Archive(path, MappingProxyType(sizes), size_bytes, True, MappingProxyType(numbers), process)


def check_entry(path: Path, entry: Entry, remedy: str) -> None:
    """Refuse a member that is not a plain file, is encrypted, packed by an unknown method, or inflates too much."""
    name = show(entry.stored)
    kind = stat.S_IFMT(entry.attributes >> 16)
    if entry.stored != entry.name:
        raise InputError(path, f"holds a member with an impossible name, {name}", remedy)
    if kind not in (0, stat.S_IFREG):
        raise InputError(path, f"{name} is not a regular file", remedy)
    if entry.flags & 0x1:
        raise InputError(path, f"{name} is encrypted", "Ask for it without a password")
    if entry.method not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        raise InputError(path, f"{name} is packed by an unknown method", "Pack it with deflate or not at all")
    if entry.size_bytes > RATIO_LIMIT * entry.packed_bytes + RATIO_FLOOR_BYTES:
        raise InputError(path, f"{name} would unpack to more than {RATIO_LIMIT} times its size", remedy)


def _check(path: Path, sizes: Mapping[str, int], known: Collection[str]) -> None:
    unknown = sorted(name for name in sizes if name not in known)
    if unknown:
        more = f" and {len(unknown) - 1} more" if len(unknown) > 1 else ""
        raise InputError(path, f"holds what no bundle holds: {show(unknown[0])}{more}", _REMEDY)
    if sum(sizes.values()) > BUNDLE_LIMIT_BYTES:
        raise InputError(path, f"would unpack to more than {BUNDLE_LIMIT_BYTES >> 30} GiB", _REMEDY)
