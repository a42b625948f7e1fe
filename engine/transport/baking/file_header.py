"""Layout of a transport file: its header, and the offsets of its arrays (`engine.transport.baking.file`).

Reading a transport file that may be anything: its header understood, all of it copied, every byte checked once.

It is copied and not mapped, because a mapped file that is cut short or unplugged ends the process.
"""

from __future__ import annotations

import io
import json
import math
import os
import stat
import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, JsonValue, ValidationError

from engine.core.errors import InputError
from engine.storage.scratch import scratch_array
from engine.storage.text import read_json

MAGIC = b"LATRANS1"
FORMAT: Literal["lightarc-transport"] = "lightarc-transport"

#: The version of files that are packed; version 1 has its arrays as they are.
VERSION: Literal[2] = 2

#: Bytes that a byte of a packed file may stand for: more would be a small file that fills a disk.
RATIO_LIMIT = 1000

DONE = 1 << 32
PAGE = 4096
HEADER_LIMIT_BYTES = 1 << 20
BOUNDS = "chunk_bounds"
MESH_ARRAYS = ("positions", "normals", "uv", "faces")

#: Types of the arrays of a mesh in the file.
MESH_KINDS = {"positions": "<f8", "normals": "<f4", "uv": "<f4", "faces": "<i4"}

_Count = Annotated[int, Field(ge=0, le=1 << 48)]
_Checksum = Annotated[int, Field(ge=0, lt=1 << 32)]


class _Strict(BaseModel):
    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)


class Array(_Strict):
    name: Annotated[str, Field(pattern=r"^[a-z_0-9]{1,40}$")]
    dtype: Literal["<f4", "<f8", "<u2", "<u4", "<i2", "<i4", "<i8", "|u1", "|b1"]
    shape: Annotated[list[_Count], Field(min_length=1, max_length=6)]
    offset: _Count
    crc32: _Checksum | None

    @property
    def row_bytes(self) -> int:
        return math.prod(self.shape[1:]) * np.dtype(self.dtype).itemsize

    @property
    def size_bytes(self) -> int:
        return self.shape[0] * self.row_bytes


class Header(_Strict):
    format: Literal["lightarc-transport"] = FORMAT
    version: Literal[1, 2] = 1
    kind: Annotated[str, Field(pattern=r"^[a-z-]{1,20}$")]
    mesh_name: Annotated[str, Field(max_length=1000)]
    mesh_sha256: Annotated[str, Field(pattern=r"^[0-9a-f]{64}$")]
    texture_coordinates_made: bool
    brushing: Annotated[str, Field(max_length=100)] | None = None
    backs: Annotated[int, Field(ge=1, le=1 << 30)] | None = None
    settings: dict[str, JsonValue]
    chunks: Annotated[int, Field(ge=0, le=1 << 26)]
    table_offset: _Count
    size_bytes: _Count
    arrays: Annotated[list[Array], Field(max_length=64)]


def lay_out(header: Header) -> Header:
    """Give every array its place; the offsets change the length of the header, so its length is fixed first."""
    reserved = len(header_text(header)) + 32 * (len(header.arrays) + 2)
    table = _align(len(MAGIC) + 8 + reserved)
    offset = _align(table + 8 * header.chunks + 4)
    arrays = []
    for array in header.arrays:
        arrays.append(array.model_copy(update={"offset": offset}))
        offset = _align(offset + array.size_bytes)
    size_bytes = offset + PAGE  # for the check
    return header.model_copy(update={"arrays": arrays, "table_offset": table, "size_bytes": size_bytes})


def has_check(header: Header) -> bool:
    """True where a page for the check follows the arrays; files of older versions have none."""
    end = max(array.offset + array.size_bytes for array in header.arrays)
    return header.size_bytes == _align(end) + PAGE


def _align(offset: int) -> int:
    return (offset + PAGE - 1) // PAGE * PAGE


def header_text(header: Header) -> bytes:
    said = header.model_dump()
    for name in ("brushing", "backs"):
        if said[name] is None:  # as in files of versions that know none
            del said[name]
    return json.dumps(said, ensure_ascii=True, allow_nan=False, sort_keys=True).encode()


REMEDY = "Bake the mesh again"

_PART_BYTES = 1 << 26


def head_of(path: Path) -> tuple[NDArray[np.uint8], int]:
    """The beginning of a file, as much as a header takes, and the size of the whole; InputError as `content_of`."""
    with _open(path) as (file, size_bytes):
        if size_bytes < len(MAGIC) + 8:
            raise InputError(path, "is not a transport file", "Give one that lightarc bake made")
        return np.frombuffer(file.read(len(MAGIC) + 8 + HEADER_LIMIT_BYTES), np.uint8), size_bytes


def content_of(path: Path, size_bytes: int) -> NDArray[np.uint8]:
    """A copy of all bytes of a file, in memory or, where there are many, in an unnamed file.

    InputError where it is not a regular file of that size, or cannot be read.
    """
    content = scratch_array((size_bytes,), np.uint8)
    with _open(path) as (file, now_bytes):
        read = 0
        while part := file.readinto(content.data[read : read + _PART_BYTES]):
            read += part
        if read != size_bytes or now_bytes != size_bytes:
            raise InputError(path, "changed while it was being read", "Wait until it is complete and try again")
    content.flags.writeable = False
    return content


@contextmanager
def _open(path: Path) -> Iterator[tuple[io.FileIO, int]]:
    try:
        flags = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)
        with io.FileIO(os.open(path, flags), "rb") as file:
            status = os.fstat(file.fileno())
            if not stat.S_ISREG(status.st_mode):
                raise InputError(path, "is not a regular file", "Give a transport file that lightarc bake made")
            yield file, status.st_size
    except FileNotFoundError:
        raise InputError(path, "does not exist", "Check the name") from None
    except (OSError, ValueError) as error:
        words = os.strerror(error.errno or 0) if isinstance(error, OSError) else str(error)
        raise InputError(path, f"cannot be read ({words})", "Check the name") from None


def read_header(path: Path, content: NDArray[np.uint8]) -> Header:
    start = len(MAGIC) + 8
    if content[: len(MAGIC)].tobytes() != MAGIC:
        raise InputError(path, "is not a transport file", "Give one that lightarc bake made")
    length, checksum = (int.from_bytes(content[at : at + 4].tobytes(), "little") for at in (len(MAGIC), start - 4))
    text = content[start : start + min(length, HEADER_LIMIT_BYTES)].tobytes()
    if len(text) != length or zlib.crc32(text) != checksum:
        raise InputError(path, "is damaged: the checksum of its header does not fit", REMEDY)
    value = read_json(text, path, "its header", REMEDY)
    if isinstance(value, dict) and isinstance(value.get("version"), int) and value["version"] > VERSION:
        raise InputError(path, f"was written by a newer Lightarc (version {value['version']})", "Update Lightarc")
    try:
        header = Header.model_validate(value)
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False)[0]
        place = ".".join(map(str, first["loc"]))[:80]
        raise InputError(path, f"has a header with a faulty {place} ({first['msg'][:100]})", REMEDY) from None
    _check_places(path, header)
    return header


def _check_places(path: Path, header: Header) -> None:
    """That table and arrays follow each other and end with the file, before anything is taken from there."""
    end = header.table_offset + 8 * header.chunks + 4
    names = {array.name for array in header.arrays}
    for array in header.arrays:
        if array.offset % PAGE or array.offset < end:
            raise InputError(path, f"has a header that puts {array.name} where something else is", REMEDY)
        end = array.offset + array.size_bytes
    if end > header.size_bytes or len(names) != len(header.arrays) or not {*MESH_ARRAYS, BOUNDS} <= names:
        raise InputError(path, "has a header whose arrays do not fit its size", REMEDY)


def check_content(path: Path, content: NDArray[np.uint8], header: Header, arrays: Mapping[str, NDArray[Any]]) -> None:
    is_checked = header.version > 1  # block by block, before it was unpacked
    for array in header.arrays:
        if (
            not is_checked
            and array.crc32 is not None
            and zlib.crc32(content[array.offset :][: array.size_bytes].data) != array.crc32
        ):
            raise InputError(path, f"is damaged: the checksum of {array.name} does not fit", REMEDY)
    table = content[header.table_offset :][: 8 * header.chunks]
    sealed = content[header.table_offset + 8 * header.chunks :][:4].tobytes()
    if zlib.crc32(table.tobytes()) != int.from_bytes(sealed, "little"):
        raise InputError(path, "is damaged or was never finished: the table of its chunks does not fit", REMEDY)
    entries, bounds = table.view("<u8"), arrays[BOUNDS]
    streamed = [array for array in header.arrays if array.crc32 is None]
    if (
        bounds.dtype.str != "<i8"
        or bounds.shape != (header.chunks + 1,)
        or bounds[0] != 0
        or (np.diff(bounds) < 0).any()
    ):
        raise InputError(path, "has bounds of chunks that cannot be", REMEDY)
    if any(array.shape[0] != bounds[-1] for array in streamed):
        raise InputError(path, "has arrays with another number of rows than chunks", REMEDY)
    if is_checked:
        return
    for chunk, (start, stop) in enumerate(zip(bounds[:-1].tolist(), bounds[1:].tolist(), strict=True)):
        checksum = 0
        for array in streamed:
            rows = content[array.offset + start * array.row_bytes : array.offset + stop * array.row_bytes]
            checksum = zlib.crc32(rows.data, checksum)
        if int(entries[chunk]) != DONE | checksum:
            raise InputError(path, f"is damaged: the checksum of chunk {chunk + 1} does not fit", REMEDY)
