"""Members of a bundle as they are written, one after the other, into a zip or into a folder.

A member may be larger than memory: it comes in parts, and bytes that are known only at its end (`Late`) are put in
their place afterwards, for which it is read back once more.
"""

from __future__ import annotations

import hashlib
import zipfile
import zlib
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import BinaryIO

from engine.images.exr_strips import Late
from engine.storage.atomic import atomic_file, atomic_folder, explaining, make_folder
from engine.storage.records import Member

#: Bytes that are read of a member without images: a page with its tiles is the largest.
SMALL_LIMIT_BYTES = 256 << 20

_PART_BYTES = 1 << 22
_PACKED_WELL = (".json", ".glsl", ".html")

#: Members that may become larger have the longer header of large zip files.
_ZIP64_BYTES = 1 << 31


class Growing:
    """A member while it is written; afterwards `fingerprint` is that of its content."""

    def __init__(self, write: Callable[[bytes], object]) -> None:
        self._write = write
        self._hash = hashlib.sha256()
        self._size_bytes = 0
        self.late: Late | None = None

    def write(self, content: bytes) -> None:
        """Add `content`."""
        self._write(content)
        self._hash.update(content)
        self._size_bytes += len(content)

    @property
    def fingerprint(self) -> Member:
        return Member(sha256=self._hash.hexdigest(), size_bytes=self._size_bytes)

    def patch(self, file: BinaryIO, path: Path, start: int) -> int:
        """Put the late bytes into a member that begins at `start` of `file`; the CRC-32 of what `path` then holds."""
        assert self.late is not None
        end = file.tell()
        file.seek(start + self.late.place)
        file.write(self.late.content)
        file.seek(end)
        self._hash, checksum, left = hashlib.sha256(), 0, self._size_bytes
        with explaining(path), path.open("rb", buffering=0) as written:
            written.seek(start)
            while left and (part := written.read(min(left, _PART_BYTES))):
                self._hash.update(part)
                checksum = zlib.crc32(part, checksum)
                left -= len(part)
        return checksum


#: A function that opens the next member by its name and an upper bound of its size in bytes.
OpenMember = Callable[[str, int], AbstractContextManager[Growing]]


@contextmanager
def zip_members(target: Path, size_bytes: int) -> Iterator[OpenMember]:
    """The zip appears at `target` when the block ends."""
    with atomic_file(target, size_bytes) as output, zipfile.ZipFile(output, "w") as packed:

        @contextmanager
        def member(name: str, max_bytes: int) -> Iterator[Growing]:
            entry = _entry(name)
            is_large = max_bytes > _ZIP64_BYTES
            with packed.open(entry, "w", force_zip64=is_large) as file:
                growing = Growing(file.write)
                yield growing
            if growing.late is not None:
                header_bytes = len(entry.FileHeader(is_large))
                entry.CRC = growing.patch(output, Path(output.name), entry.header_offset + header_bytes)
                output.seek(entry.header_offset)
                output.write(entry.FileHeader(is_large))
                output.seek(packed.start_dir)

        yield member


@contextmanager
def folder_members(target: Path, marker: str, size_bytes: int) -> Iterator[OpenMember]:
    """The folder appears at `target` when the block ends."""
    with atomic_folder(target, marker, size_bytes) as folder:

        @contextmanager
        def member(name: str, max_bytes: int) -> Iterator[Growing]:
            path = folder / name
            make_folder(path.parent)
            with atomic_file(path, max_bytes) as output:
                growing = Growing(output.write)
                yield growing
                if growing.late is not None:
                    growing.patch(output, Path(output.name), 0)

        yield member


def _entry(name: str) -> zipfile.ZipInfo:
    entry = zipfile.ZipInfo(name, date_time=(1980, 1, 1, 0, 0, 0))
    entry.compress_type = zipfile.ZIP_DEFLATED if name.endswith(_PACKED_WELL) else zipfile.ZIP_STORED
    entry.create_system, entry.external_attr = 3, 0o100644 << 16
    return entry
