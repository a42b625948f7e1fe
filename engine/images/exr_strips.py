"""OpenEXR files written and read strip by strip, for maps that are larger than memory.

The bytes are those that OpenEXR itself writes for scan lines with ZIP compression (16 rows to a chunk): the header
comes from it, and chunks are packed by the same library (libdeflate, level 4). Its Python binding takes whole
images only. The sizes of chunks are known after they are packed, and the table of their places lies before them: it
is written as zeros and handed back.
OpenEXR file layout, "Chunk layout"; ImfZip.cpp (even bytes before odd ones, then differences).
Cost: writing some 60 MB/s on each core, and the memory of as many strips as there are cores; reading some 200 MB/s, and
the memory of one strip.
"""

from __future__ import annotations

import struct
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Future, ThreadPoolExecutor, wait
from dataclasses import dataclass, field
from typing import IO, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from engine.core.budget import thread_count
from engine.core.steps import Step, Steps
from engine.images.encode import as_half, encode_exr
from engine.images.exr import end_of_header
from engine.storage.scratch import release

_CHUNK_ROWS = 16
_LEVEL = 4
_PATIENCE_S = 0.05

#: Version 2 of the format, with names of any length and otherwise plain: one part of scan lines; and what its header
#: says of ZIP compression, of rows from the top, and of samples.
_PLAIN_FLAGS, _ZIP, _FROM_THE_TOP = (2, 2 | 0x400), 3, 0
_KINDS: dict[int, np.dtype[Any]] = {1: np.dtype("<f2"), 2: np.dtype("<f4")}

#: Longest header that is read.
_HEADER_BYTES = 1 << 20


@dataclass(frozen=True, eq=False)
class Planes:
    """An image to be written: `channels` (H, W) by name, of which mapped ones are read a strip at a time.

    `half` stores half floats in place of floats; `attributes` are text or numbers.
    """

    channels: Mapping[str, NDArray[Any]]
    attributes: Mapping[str, Any] = field(default_factory=dict)
    half: bool = False

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width."""
        height, width = next(iter(self.channels.values())).shape
        return height, width

    @property
    def size_bytes(self) -> int:
        """Bytes of all samples before they are packed."""
        height, width = self.shape
        return height * width * len(self.channels) * (2 if self.half else 4)


def encode(content: bytes | Planes) -> bytes:
    """The whole file of planes; what is a file already stays."""
    if isinstance(content, bytes):
        return content
    return encode_exr(content.channels, half=content.half, attributes=content.attributes)


class Late(NamedTuple):
    """Bytes that are known only when all others have been written, and the place in the file where they belong."""

    place: int
    content: bytes


def write_exr_strips(planes: Planes, write: Callable[[bytes], object], note: str) -> Steps[Late]:
    """Hand the file of `planes` to `write`, in order and with zeros where the `Late` bytes go that are returned."""
    height, width = planes.shape
    header = _header(planes, height, width)
    starts = range(0, height, _CHUNK_ROWS)
    write(header + bytes(8 * len(starts)))
    place = len(header) + 8 * len(starts)
    places: list[int] = []
    workers = thread_count()
    pending: deque[Future[bytes]] = deque()
    pool = ThreadPoolExecutor(workers)
    try:
        for first in (*starts, *[None] * workers):
            if first is not None:
                pending.append(pool.submit(_chunk, planes, first))
                if len(pending) <= workers:
                    continue
            if not pending:
                break
            done = len(places) / len(starts)
            while wait([pending[0]], timeout=_PATIENCE_S).not_done:
                yield Step(done, note)
            chunk = pending.popleft().result()
            write(chunk)
            places.append(place)
            place += len(chunk)
            for channel in planes.channels.values():
                release(channel)
        return Late(len(header), struct.pack(f"<{len(places)}Q", *places))
    finally:
        pool.shutdown(wait=False, cancel_futures=True)


def _header(planes: Planes, height: int, width: int) -> bytes:
    """OpenEXR's own, of an image of one row, with the height that this one has."""
    row = {name: np.zeros((1, width), np.float32) for name in planes.channels}
    content = encode_exr(row, half=planes.half, attributes=planes.attributes)
    header = bytearray(content[: end_of_header(content)])
    for window in (b"dataWindow\0box2i\0", b"displayWindow\0box2i\0"):
        struct.pack_into("<4i", header, header.index(window) + len(window) + 4, 0, 0, width - 1, height - 1)
    return bytes(header)


def _chunk(planes: Planes, first: int) -> bytes:
    """Rows from `first` on, packed: first row, size, and pixels, plain where packing does not make them smaller."""
    import imagecodecs

    kind = np.dtype("<f2" if planes.half else "<f4")
    height, width = planes.shape
    rows = min(_CHUNK_ROWS, height - first)
    samples = np.empty((rows, len(planes.channels), width), kind)
    for place, name in enumerate(sorted(planes.channels)):
        part = planes.channels[name][first : first + rows]
        samples[:, place] = as_half(part) if planes.half else part
    plain = samples.reshape(-1).view(np.uint8)
    sorted_bytes = np.concatenate([plain[0::2], plain[1::2]])
    differences = sorted_bytes.copy()
    differences[1:] -= sorted_bytes[:-1]
    differences[1:] += np.uint8(128)
    packed = imagecodecs.deflate_encode(differences.tobytes(), level=_LEVEL)
    body = bytes(packed) if len(packed) < plain.size else plain.tobytes()
    return struct.pack("<2i", first, len(body)) + body


@dataclass(frozen=True)
class Strips:
    """Layout of a file: `channels` in order, all samples of one `kind`, and the `start` of the table of places."""

    channels: tuple[str, ...]
    kind: np.dtype[Any]
    height: int
    width: int
    start: int


def find_strips(file: IO[bytes]) -> Strips | None:
    """The strips of a file as `write_exr_strips` writes it; None for one that only OpenEXR reads, or no such file."""
    file.seek(0)
    head = file.read(_HEADER_BYTES)
    try:
        if head[:4] != b"v/1\x01" or int.from_bytes(head[4:8], "little") not in _PLAIN_FLAGS:
            return None
        values = _attributes(head)
        if values[b"compression"] != bytes([_ZIP]) or values[b"lineOrder"] != bytes([_FROM_THE_TOP]):
            return None
        left, top, right, bottom = struct.unpack("<4i", values[b"dataWindow"])
        names, kinds = [], set()
        entry = values[b"channels"]
        while entry[0]:
            name, _, entry = entry.partition(b"\0")
            kind, _, *sampling = struct.unpack_from("<iI2i", entry)
            if sampling != [1, 1]:
                return None
            names.append(name.decode())
            kinds.add(kind)
            entry = entry[16:]
        (kind,) = kinds
        return Strips(tuple(names), _KINDS[kind], bottom - top + 1, right - left + 1, end_of_header(head))
    except (LookupError, ValueError, struct.error):
        return None


def _attributes(head: bytes) -> dict[bytes, bytes]:
    """Values of a header by name; LookupError or ValueError where it ends early."""
    found, at = {}, 8
    while head[at]:
        name_end = head.index(b"\0", at)
        start = head.index(b"\0", name_end + 1) + 5
        stop = start + int.from_bytes(head[start - 4 : start], "little")
        found[head[at:name_end]] = head[start:stop]
        at = stop
    return found


def read_strips(file: IO[bytes], strips: Strips) -> Iterator[tuple[int, NDArray[Any]]]:
    """First row and samples (rows, C, W) of one strip after the other; ValueError where the file is damaged."""
    starts = range(0, strips.height, _CHUNK_ROWS)
    file.seek(strips.start)
    table = file.read(8 * len(starts))
    if len(table) != 8 * len(starts):
        raise ValueError("its table of places is cut short")
    for first, place in zip(starts, struct.unpack(f"<{len(starts)}Q", table), strict=True):
        rows = min(_CHUNK_ROWS, strips.height - first)
        size_bytes = rows * len(strips.channels) * strips.width * strips.kind.itemsize
        file.seek(place)
        head = file.read(8)
        row, packed_bytes = struct.unpack("<2i", head) if len(head) == 8 else (-1, 0)
        body = file.read(packed_bytes) if 0 < packed_bytes <= size_bytes else b""
        if row != first or len(body) != packed_bytes:
            raise ValueError(f"its rows from {first} on are not where they should be")
        samples = np.frombuffer(body if packed_bytes == size_bytes else _unpack(body, size_bytes), strips.kind)
        yield first, samples.reshape(rows, len(strips.channels), strips.width)


def _unpack(body: bytes, size_bytes: int) -> NDArray[np.uint8]:
    """The plain bytes of a strip that was packed; ValueError where they are fewer or more."""
    import imagecodecs

    try:
        unpacked = imagecodecs.deflate_decode(body, out=size_bytes)
    except imagecodecs.DeflateError as error:
        raise ValueError(f"its rows do not unpack ({error})") from None
    if len(unpacked) != size_bytes:
        raise ValueError("its rows are too short")
    sorted_bytes = imagecodecs.delta_decode(np.frombuffer(unpacked, np.uint8))
    sorted_bytes[1::2] += np.uint8(128)  # of as many differences as a byte has before it, each of 128 too much
    plain = np.empty(size_bytes, np.uint8)
    middle = (size_bytes + 1) // 2
    plain[0::2], plain[1::2] = sorted_bytes[:middle], sorted_bytes[middle:]
    return plain
