"""How a transport file is laid out: its header, and where its arrays lie (`engine.transport.transport_file`)."""

from __future__ import annotations

import json
import math
from typing import Annotated, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, JsonValue

MAGIC = b"LATRANS1"
FORMAT: Literal["lightarc-transport"] = "lightarc-transport"

DONE = 1 << 32
PAGE = 4096
HEADER_LIMIT_BYTES = 1 << 20
BOUNDS = "chunk_bounds"
MESH_ARRAYS = ("positions", "normals", "uv", "faces")

#: How the arrays of a mesh lie in the file.
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
    version: Literal[1] = 1
    kind: Annotated[str, Field(pattern=r"^[a-z-]{1,20}$")]
    mesh_name: Annotated[str, Field(max_length=1000)]
    mesh_sha256: Annotated[str, Field(pattern=r"^[0-9a-f]{64}$")]
    texture_coordinates_made: bool
    settings: dict[str, JsonValue]
    chunks: Annotated[int, Field(ge=0, le=1 << 26)]
    table_offset: _Count
    size_bytes: _Count
    arrays: Annotated[list[Array], Field(max_length=64)]


def laid_out(header: Header) -> Header:
    """Give every array its place; the offsets change the length of the header, so its room is fixed first."""
    room = len(header_text(header)) + 32 * (len(header.arrays) + 2)
    table = _aligned(len(MAGIC) + 8 + room)
    offset = _aligned(table + 8 * header.chunks + 4)
    arrays = []
    for array in header.arrays:
        arrays.append(array.model_copy(update={"offset": offset}))
        offset = _aligned(offset + array.size_bytes)
    return header.model_copy(update={"arrays": arrays, "table_offset": table, "size_bytes": offset})


def _aligned(offset: int) -> int:
    return (offset + PAGE - 1) // PAGE * PAGE


def header_text(header: Header) -> bytes:
    return json.dumps(header.model_dump(), ensure_ascii=True, allow_nan=False, sort_keys=True).encode()
