"""Visibility that is found once for a surface and kept: bakes of other BRDFs, terms or modes then cast no ray.

A record is a SQLite file named by the hash of all that visibility depends on: the surface that rays meet, where they
start, the horizons, and the cube map. It holds blocks of vertices, each compressed by itself; a bake that ends early
leaves those that are done. What cannot be read is found anew: a record only saves time. Rays are nine tenths of a
wavelet bake of a model of 35,000 vertices; a block is read in a hundredth of their time.
"""

from __future__ import annotations

import hashlib
import logging
import os
import sqlite3
import zlib
from collections.abc import Callable, Iterable, Iterator
from contextlib import closing, suppress
from dataclasses import dataclass, replace
from pathlib import Path

import imagecodecs
import numpy as np
from numpy.typing import NDArray

from engine.core.errors import OutputError
from engine.storage.atomic import discard, make_folder
from engine.transport.baking.visibility import TEXELS, Receivers

log = logging.getLogger(__name__)

#: Raised with each change after which equal surfaces have other counts.
VERSION = 1

#: Bytes that all records of a folder may take; those used longest ago go first.
MAX_BYTES = 4 * 2**30

#: Seconds that another process may hold a record.
PATIENCE_S = 5.0

#: Effort of the compression: counts are none or all nearly everywhere.
LEVEL = 1

Counts = NDArray[np.uint8]
Indices = NDArray[np.int64]


@dataclass(frozen=True)
class VisibilityRecord:
    """The record of a surface in `folder`; `surface` is the hash of what it depends on but for the cube map."""

    folder: Path
    surface: str

    def path(self, edge: int, fine: int) -> Path:
        """The file with shares of the texels of a cube map of `edge`, cut into `fine`² parts."""
        return self.folder / f"visibility-{self.surface[:40]}-{edge}-{fine}.sqlite"

    def holds(self, of: Receivers, edge: int, fine: int) -> bool:
        """True if nothing is missing, so that `shares` casts no ray (blocks that are damaged show only there)."""
        path = self.path(edge, fine)
        if not path.is_file():
            return False
        with closing(_open(path)) as file:
            return file.count() == -(-len(of) // block_size(edge))

    def missing(self, of: Receivers, edge: int, fine: int) -> list[int]:
        """The numbers of the blocks that are missing."""
        with closing(_open(self.path(edge, fine))) as file:
            held = file.numbers()
        return [number for number in range(len(blocks(of, edge))) if number not in held]

    def take(self, edge: int, fine: int, numbers: Iterable[int]) -> dict[int, bytes]:
        """Blocks as `pack_block` makes them, by their numbers; none where one of them is missing."""
        path = self.path(edge, fine)
        with closing(_open(path)) as file:
            _note_use(path)
            found = {number: file.read_packed(number) for number in numbers}
        held = {number: data for number, data in found.items() if data is not None}
        return held if len(held) == len(found) else {}

    def put(self, edge: int, fine: int, number: int, data: bytes) -> None:
        """Keep a block that `pack_block` made elsewhere."""
        with closing(_open(self.path(edge, fine))) as file:
            file.put(number, data)

    def find_whole(self, of: Receivers) -> tuple[int, int] | None:
        """The edge and fineness of the coarsest cube map of which nothing is missing; None where there is none."""
        names = (path.stem.split("-") for path in self.folder.glob(f"visibility-{self.surface[:40]}-*.sqlite"))
        cubes = sorted((int(edge), int(fine)) for *_, edge, fine in names if edge.isdecimal() and fine.isdecimal())
        return next((cube for cube in cubes if self.holds(of, *cube)), None)

    def shares(
        self, of: Receivers, edge: int, fine: int, vertices: Indices, find: Callable[[Indices], Counts]
    ) -> Iterator[tuple[Indices, Counts]]:
        """As `visibility_shares`; `find` gives the counts of the vertices of a block that is missing."""
        size = block_size(edge)
        if (np.diff(vertices) < 0).any():
            raise ValueError("vertices are asked for in rising order")
        path = self.path(edge, fine)
        with closing(_open(path)) as file:
            _note_use(path)
            for number in np.unique(vertices // size).tolist():
                chunk = vertices[vertices // size == number]
                first, last = number * size, min((number + 1) * size, len(of))
                counts = file.read(number, last - first, edge)
                if counts is None:
                    counts = find(np.arange(first, last))
                    file.put(number, pack_block(counts))
                yield chunk, counts[chunk - first]


def block_size(edge: int) -> int:
    """Vertices of a block."""
    return max(1, TEXELS // (6 * edge * edge))


def blocks(of: Receivers, edge: int) -> list[Indices]:
    """The vertices of each block."""
    size = block_size(edge)
    return [np.arange(start, min(start + size, len(of))) for start in range(0, len(of), size)]


def pack_block(counts: Counts) -> bytes:
    """The counts of a block as a record holds them."""
    return bytes(imagecodecs.zstd_encode(np.ascontiguousarray(counts).tobytes(), level=LEVEL))


def unpack_block(data: bytes, vertices: int, edge: int) -> Counts:
    """(vertices, 6 edge²) counts of a block that `pack_block` made; ValueError where it is not of so many."""
    size = vertices * 6 * edge * edge
    content = imagecodecs.zstd_decode(data, out=size)
    if len(content) != size:
        raise ValueError(f"a block of visibility has {len(content)} counts in place of {size}")
    return np.frombuffer(content, np.uint8).reshape(vertices, -1)


def is_kept(of: Receivers, edge: int, fine: int) -> bool:
    """True if a record holds all that `of` sees over a cube map."""
    return isinstance(of.record, VisibilityRecord) and of.record.holds(of, edge, fine)


def keep_visibility(of: Receivers, folder: Path | None) -> Receivers:
    """`of` with its record in `folder`, which is made; without one where there is no folder or it cannot be written."""
    if folder is None:
        return of
    try:
        make_folder(folder)
    except OutputError as error:
        log.info("visibility is not kept: %s", error)
        return of
    _remove_oldest(folder)
    digest = hashlib.sha256(f"visibility {VERSION}".encode())
    for array in (of.caster.positions, of.caster.faces, of.origin, of.normal, of.free):
        digest.update(f"{array.shape} {array.dtype}".encode())
        digest.update(np.ascontiguousarray(array).data)
    return replace(of, record=VisibilityRecord(folder, digest.hexdigest()))


class _File:
    """Blocks in a SQLite file; nothing is kept where it cannot be opened, or after the first failure."""

    def __init__(self, connection: sqlite3.Connection | None) -> None:
        self._connection = connection

    def read(self, number: int, vertices: int, edge: int) -> Counts | None:
        """The counts of a block; None where they are missing or damaged."""
        data = self.read_packed(number)
        if data is not None:
            with suppress(imagecodecs.ZstdError, ValueError):
                return unpack_block(data, vertices, edge)
        return None

    def read_packed(self, number: int) -> bytes | None:
        """A block as it was put; None where it is missing or damaged."""
        row = self._run("SELECT crc, data FROM blocks WHERE number = ?", (number,))
        if not row:
            return None
        crc, data = row[0]
        return data if isinstance(data, bytes) and zlib.crc32(data) == crc else None

    def count(self) -> int:
        """Number of blocks."""
        row = self._run("SELECT COUNT(*) FROM blocks", ())
        return int(str(row[0][0])) if row else 0

    def numbers(self) -> set[int]:
        """Numbers of the blocks that are there."""
        return {int(str(row[0])) for row in self._run("SELECT number FROM blocks", ())}

    def put(self, number: int, data: bytes) -> None:
        """Keep a block that is packed."""
        self._run("INSERT OR REPLACE INTO blocks VALUES (?, ?, ?)", (number, zlib.crc32(data), data))

    def close(self) -> None:
        """Close the file."""
        if self._connection is not None:
            self._connection.close()

    def _run(self, statement: str, values: tuple[object, ...]) -> list[tuple[object, ...]]:
        if self._connection is None:
            return []
        try:
            with self._connection:
                return self._connection.execute(statement, values).fetchall()
        except sqlite3.Error as error:  # another process holds it, the disk is full, or it is damaged
            log.info("visibility is not kept: %s", error)
            self.close()
            self._connection = None
            return []


def _open(path: Path) -> _File:
    """The file at `path`, which is made; a damaged one is begun anew."""
    for _ in range(2):
        try:
            connection = sqlite3.connect(path, timeout=PATIENCE_S)
            connection.execute("PRAGMA synchronous = OFF")
            with connection:
                connection.execute(
                    "CREATE TABLE IF NOT EXISTS blocks (number INTEGER PRIMARY KEY, crc INTEGER, data BLOB)"
                )
            return _File(connection)
        except sqlite3.OperationalError as error:
            log.info("visibility is not kept: %s", error)
            return _File(None)
        except sqlite3.DatabaseError as error:
            log.info("a record of visibility is begun anew: %s", error)
            discard(path)
    return _File(None)


def _note_use(path: Path) -> None:
    """Let a record be one that was used now."""
    with suppress(OSError):
        os.utime(path)


def _remove_oldest(folder: Path, limit_bytes: int = MAX_BYTES) -> None:
    """Remove the records that were used longest ago, until the rest is within the limit."""
    found = []
    for path in folder.glob("visibility-*.sqlite"):
        with suppress(OSError):
            status = path.stat()
            found.append((status.st_mtime_ns, status.st_size, path))
    total = sum(size for _, size, _ in found)
    for _, size, path in sorted(found):
        if total <= limit_bytes:
            return
        discard(path)
        total -= size
