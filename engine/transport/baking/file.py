"""Transport files: what a bake finds for every vertex, in a file.

    8 bytes "LATRANS1", u32 length and u32 CRC-32 of the header (JSON in UTF-8), the header,
    u64 for each chunk of rows: its CRC-32 and 2^32 on top; then a u32 CRC-32 of these numbers,
    the blocks of all arrays, one after the other, each packed (`engine.transport.baking.packing`),
    zeros, up to a thousandth of what the arrays take,
    for each block u32 bytes and u32 CRC-32, u8 form and three u8 shifts; then a u32 CRC-32 of these numbers,
    a page of 4096 bytes for the check of the bake (`engine.transport.baking.check`), zero where there is none.

Arrays are little-endian and in C order, and of two kinds. Whole ones are known when the bake begins: the mesh itself,
factors of the BRDF, the bounds of the chunks. Streamed ones have one row for each thing that is baked, and chunks of
rows arrive in any order, so a bake writes them into an unfinished file in which every array has its place: its table
begins at a multiple of 4096 bytes after the header, and so does each array; a table that is not finished has zeros.
Everything before the first array depends only on what is baked, so a bake that was interrupted is known again by it,
and goes on with the chunks that are missing or damaged (`engine.storage.resumable`). The size of the unfinished file is
known before the bake begins. When all chunks are there, it is packed.

Files of version 1, which are still read, are unfinished files that were finished: all arrays as they are, and the page
for the check; the oldest have no page. Opening checks every byte once, about 1 s for a gigabyte.
"""

from __future__ import annotations

import hashlib
import os
import zlib
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from numpy.typing import DTypeLike, NDArray

import engine
from engine.core.errors import InputError, UsageError
from engine.core.health import Health
from engine.core.side_by_side import side_by_side
from engine.geometry.brushing import TEXTURE, Brushing, parse_brushing
from engine.geometry.mesh import BACKS, Mesh
from engine.storage.atomic import atomic_file
from engine.storage.resumable import Resumable, resumable_file
from engine.transport.baking.check import BakeCheck, decode_check
from engine.transport.baking.file_header import (
    BOUNDS,
    DONE,
    MAGIC,
    MESH_ARRAYS,
    MESH_KINDS,
    PAGE,
    RATIO_LIMIT,
    VERSION,
    Array,
    Header,
    check_content,
    content_of,
    has_check,
    head_of,
    header_text,
    lay_out,
    read_header,
)
from engine.transport.baking.file_header import REMEDY as REMEDY
from engine.transport.baking.packing import BLOCK_ROW, pack_block, parts_of, unpack_content

if TYPE_CHECKING:
    from _typeshed import ReadableBuffer

#: Ending of the files' names.
SUFFIX = ".transport"

Found = TypeVar("Found")


@dataclass(frozen=True, eq=False)
class TransportPlan:
    """A transport file before it is written; made by `plan_transport`.

    Attributes
    ----------
    size_bytes : of the unfinished file, which is packed when it is complete.
    beginning : everything before the table of chunks.
    whole : the arrays that are known.
    """

    header: Header
    beginning: bytes
    whole: Mapping[str, NDArray[Any]]

    @property
    def size_bytes(self) -> int:
        return self.header.size_bytes

    @property
    def chunks(self) -> int:
        return self.header.chunks


@dataclass(frozen=True, eq=False)
class TransportFile:
    """An open transport file; its arrays are read-only and do not depend on the file any more.

    Attributes
    ----------
    kind : the method that it belongs to, "wavelet" or "sh".
    mesh : the surface that was baked, a ground included. settings : as the bake was asked for.
    arrays : by name, without those of the mesh. size_bytes : of the file, packed as it is.
    check : the errors that were measured when the bake ended; None where they were not.
    """

    kind: str
    mesh: Mesh
    settings: Mapping[str, Any]
    arrays: Mapping[str, NDArray[Any]]
    size_bytes: int
    path: Path
    check: BakeCheck | None = None


def mesh_fingerprint(mesh: Mesh) -> str:
    """SHA-256 of the arrays of a mesh as they lie in a file, and of its brushing where it has one."""
    digest = hashlib.sha256()
    for name, array in _mesh_arrays(mesh).items():
        digest.update(f"{name} {array.shape} ".encode())
        digest.update(np.ascontiguousarray(array).data)
    if mesh.brushing != Brushing():
        digest.update(f"brushing {mesh.brushing}".encode())
    return digest.hexdigest()


def plan_transport(
    kind: str,
    mesh: Mesh,
    settings: Mapping[str, Any],
    whole: Mapping[str, NDArray[Any]],
    streamed: Mapping[str, tuple[DTypeLike, tuple[int, ...]]],
    bounds: NDArray[np.int64],
) -> TransportPlan:
    """Lay a transport file out.

    Parameters
    ----------
    settings : whatever JSON holds; a bake with others does not go on with this one, nor does one of another version of
        the program, which is named beside them.
    streamed : for each streamed array its type and the shape of one row.
    bounds : (chunks + 1,) rising from 0: chunk c has the rows bounds[c] … bounds[c + 1] − 1.
    """
    known = {**_mesh_arrays(mesh), **whole, BOUNDS: np.asarray(bounds, "<i8")}
    known = {name: _little_endian(array) for name, array in known.items()}
    rows, chunks = int(bounds[-1]), len(bounds) - 1
    described = [
        Array(name=name, dtype=array.dtype.str, shape=list(array.shape), offset=0, crc32=zlib.crc32(array.data))  # type: ignore[arg-type]
        for name, array in known.items()
    ] + [
        Array(name=name, dtype=np.dtype(dtype).str, shape=[rows, *shape], offset=0, crc32=None)  # type: ignore[arg-type]
        for name, (dtype, shape) in streamed.items()
    ]
    header = Header(
        kind=kind,
        mesh_name=mesh.name[:1000],
        mesh_sha256=mesh_fingerprint(mesh),
        texture_coordinates_made=bool(mesh.health.figures.get("texture_coordinates_made")),
        backs=int(mesh.health.figures[BACKS]) if BACKS in mesh.health.figures else None,
        brushing=str(mesh.brushing) if mesh.brushing != Brushing() else None,
        settings={**settings, "software": f"lightarc {engine.__version__}"},
        chunks=chunks,
        table_offset=0,
        size_bytes=0,
        arrays=described,
    )
    header = lay_out(header)
    text = header_text(header)
    beginning = MAGIC + len(text).to_bytes(4, "little") + zlib.crc32(text).to_bytes(4, "little") + text
    return TransportPlan(header, beginning, MappingProxyType(known))


class TransportWriter:
    """Takes the chunks of one bake; made by `writing`."""

    def __init__(self, output: Resumable, plan: TransportPlan) -> None:
        self._output, self._plan = output, plan
        self._arrays = {array.name: array for array in plan.header.arrays}
        self._bounds = plan.whole[BOUNDS]
        for name, array in plan.whole.items():  # also of a resumed file: they may not have outlived a loss of power
            output.write_at(self._arrays[name].offset, array.data)
        self._table = np.zeros(plan.chunks, "<u8")
        if output.resumed:
            self._table = np.frombuffer(output.read_at(plan.header.table_offset, 8 * plan.chunks), "<u8").copy()
        self.missing = [chunk for chunk in range(plan.chunks) if not self._holds(chunk)]
        output.worth_keeping = len(self.missing) < plan.chunks

    def put(self, chunk: int, rows: Mapping[str, NDArray[Any]]) -> None:
        """Write the rows of one chunk of every streamed array."""
        start, stop = self._bounds[chunk], self._bounds[chunk + 1]
        checksum = 0
        for array in self._stream():
            part = _little_endian(rows[array.name])
            if part.dtype.str != array.dtype or part.shape != (stop - start, *array.shape[1:]):
                raise ValueError(f"rows of {array.name} have the shape {part.shape} or type {part.dtype} of others")
            self._output.write_at(array.offset + start * array.row_bytes, part.data)
            checksum = zlib.crc32(part.data, checksum)
        self._table[chunk] = DONE | checksum
        self._output.write_at(self._plan.header.table_offset + 8 * chunk, self._table[chunk : chunk + 1].data)
        self._output.worth_keeping = True

    def get(self, chunk: int) -> dict[str, NDArray[Any]]:
        """The rows of one chunk that is not missing, as they were put."""
        start, stop = int(self._bounds[chunk]), int(self._bounds[chunk + 1])
        rows = {}
        for array in self._stream():
            data = self._output.read_at(array.offset + start * array.row_bytes, (stop - start) * array.row_bytes)
            rows[array.name] = np.frombuffer(data, array.dtype).reshape(stop - start, *array.shape[1:])
        return rows

    def finish(self, path: str | os.PathLike[str]) -> None:
        """Pack what was written, once every chunk is there, into the file `path`."""
        if not (self._table & np.uint64(DONE)).all():
            raise ValueError("chunks are missing")
        read = lambda array, start, stop: self._output.read_at(array.offset + start, stop - start)  # noqa: E731
        _write_packed(path, self._plan.header, read, self._table.tobytes())

    def _stream(self) -> list[Array]:
        return [array for array in self._plan.header.arrays if array.crc32 is None]

    def _holds(self, chunk: int) -> bool:
        """True if the rows of `chunk` are there, and are those that were written."""
        entry = int(self._table[chunk])
        if entry < DONE:
            return False
        checksum, start, stop = 0, int(self._bounds[chunk]), int(self._bounds[chunk + 1])
        for array in self._stream():
            where = array.offset + start * array.row_bytes
            checksum = zlib.crc32(self._output.read_at(where, (stop - start) * array.row_bytes), checksum)
        return entry == DONE | checksum


@contextmanager
def writing(path: str | os.PathLike[str], plan: TransportPlan) -> Iterator[TransportWriter]:
    """Write the file that `plan` describes; packed, it appears at `path` when the block ends without an exception.

    What was written stays for a later call with an equal plan if the block is left early with any chunk done.
    OutputError where the disk has no room or another run writes the same file.
    """
    with resumable_file(path, plan.size_bytes, plan.beginning) as output:
        writer = TransportWriter(output, plan)
        yield writer
        writer.finish(path)
        output.discard()


def write_transport(path: str | os.PathLike[str], plan: TransportPlan) -> None:
    """Write a file all of whose arrays are known; OutputError where it cannot be written."""
    if plan.chunks:
        raise ValueError("a file with chunks is written by `writing`")
    read = lambda array, start, stop: _bytes_of(plan.whole[array.name])[start:stop].data  # noqa: E731
    _write_packed(path, plan.header, read, b"")


def _write_packed(
    path: str | os.PathLike[str],
    header: Header,
    read: Callable[[Array, int, int], ReadableBuffer],
    table: bytes,
) -> None:
    """Write the arrays of `header`, whose bytes `read` gives by first and last, with the `table` of their chunks."""
    parts = ((array.dtype, read(array, *part)) for array in header.arrays for part in parts_of(array))
    text = header_text(header.model_copy(update={"version": VERSION}))
    pack = lambda part: pack_block(np.frombuffer(part[1], np.uint8), part[0])  # noqa: E731
    with atomic_file(path) as stream, closing(side_by_side(pack, parts)) as blocks:
        written = stream.write(MAGIC + len(text).to_bytes(4, "little") + zlib.crc32(text).to_bytes(4, "little") + text)
        written += stream.write(table + zlib.crc32(table).to_bytes(4, "little"))
        rows = b""
        for block in blocks:
            written += stream.write(block.packed)
            rows += BLOCK_ROW.pack(len(block.packed), zlib.crc32(block.packed), block.form, *block.shifts)
        stream.write(bytes(max(0, -(-header.size_bytes // RATIO_LIMIT) - written)))
        stream.write(rows + zlib.crc32(rows).to_bytes(4, "little") + bytes(PAGE))


def open_transport(path: str | os.PathLike[str], mesh: Mesh | None = None) -> TransportFile:
    """Open a transport file and check all of it; with `mesh`, also that it was baked for that mesh.

    InputError where it is none, incomplete, damaged, of a newer version or of another mesh.
    """
    place = Path(path)
    head, size_bytes = head_of(place)
    header = read_header(place, head)
    if mesh is not None and mesh_fingerprint(mesh) != header.mesh_sha256:
        raise InputError(place, f"was baked for another mesh ({header.mesh_name})", "Bake this mesh")
    if header.version == 1 and size_bytes != header.size_bytes:
        raise InputError(place, f"has {size_bytes:,} bytes instead of {header.size_bytes:,}", REMEDY)
    content = content_of(place, size_bytes) if header.version == 1 else unpack_content(place, size_bytes, header)
    arrays = {array.name: _array(content, array) for array in header.arrays}
    check_content(place, content, header, arrays)
    try:
        found = _mesh_of(header, arrays)
    except (KeyError, ValueError, IndexError, UsageError) as error:
        raise InputError(place, f"holds a mesh that cannot be ({str(error)[:120]})", REMEDY) from None
    rest = {name: array for name, array in arrays.items() if name not in (*MESH_ARRAYS, BOUNDS)}
    settings, by_name = MappingProxyType(header.settings), MappingProxyType(rest)
    check = decode_check(place, content[-PAGE:].tobytes()) if has_check(header) else None
    return TransportFile(header.kind, found, settings, by_name, size_bytes, place, check)


def read_as(file: TransportFile, kind: str, read: Callable[[TransportFile], Found]) -> Found:
    """Result of `read` for a file of this `kind`; InputError for another kind, or for impossible content.

    `read` raises KeyError, TypeError or ValueError for the latter.
    """
    if file.kind != kind:
        raise InputError(file.path, f"holds transport of the mode {file.kind}", f"Bake with --mode {kind}")
    try:
        return read(file)
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(file.path, f"holds transport that cannot be ({str(error)[:200]})", REMEDY) from None


def holds_transport(path: str | os.PathLike[str]) -> bool:
    """True if `path` is a file that begins as a transport file does."""
    try:
        if not Path(path).is_file():  # opening a pipe would wait
            return False
        with Path(path).open("rb") as file:
            return file.read(len(MAGIC)) == MAGIC
    except (OSError, ValueError):
        return False


def _bytes_of(array: NDArray[Any]) -> NDArray[np.uint8]:
    return array.reshape(-1).view(np.uint8)


def _little_endian(array: NDArray[Any]) -> NDArray[Any]:
    return np.ascontiguousarray(array, array.dtype.newbyteorder("<"))


def _mesh_arrays(mesh: Mesh) -> dict[str, NDArray[Any]]:
    return {name: np.ascontiguousarray(getattr(mesh, name), MESH_KINDS[name]) for name in MESH_ARRAYS}


def _mesh_of(header: Header, arrays: Mapping[str, NDArray[Any]]) -> Mesh:
    if any(arrays[name].dtype.str != kind or arrays[name].ndim != 2 for name, kind in MESH_KINDS.items()):
        raise ValueError("its arrays are of other types")
    if arrays["positions"].shape[1] != 3 or not all(np.isfinite(arrays[name]).all() for name in MESH_ARRAYS[:3]):
        raise ValueError("its numbers are not finite")
    made = float(header.texture_coordinates_made)
    backs = {} if header.backs is None else {BACKS: float(header.backs)}
    health = Health(MappingProxyType({"texture_coordinates_made": made, **backs}))
    positions, normals, uv, faces = (arrays[name] for name in MESH_ARRAYS)
    brushing = parse_brushing(header.brushing or TEXTURE)
    return Mesh(positions, normals, uv, faces, header.mesh_name, health, brushing)


def _array(content: NDArray[np.uint8], array: Array) -> NDArray[Any]:
    part = content[array.offset : array.offset + array.size_bytes]
    return part.view(array.dtype).reshape(array.shape)
