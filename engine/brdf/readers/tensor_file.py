"""The container "tensor_file" 1.0 of EPFL's Realistic Graphics Lab: named arrays in one file.

Little-endian throughout: the 12 bytes `tensor_file\\0`, two bytes of version, the number of fields as u32, and for each
field u16 length of the name, the name, u16 number of dimensions, u8 type, u64 offset from the start of the file and
one u64 per dimension. The arrays lie anywhere behind, in C order.

Nothing that such a file says is believed before it has been compared with the file's size.
"""

from __future__ import annotations

import math
import os
import struct
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from engine.core.errors import InputError
from engine.storage.untrusted import AGAIN, read_bytes

MAGIC = b"tensor_file\0"

#: Far above the 11 fields, 5 dimensions and 11 letters of the largest published files.
MAX_FIELDS, MAX_DIMENSIONS, MAX_NAME_BYTES = 256, 16, 256

_PREAMBLE = struct.Struct("<12sBBI")
_NAME_BYTES = struct.Struct("<H")
_LAYOUT = struct.Struct("<HBQ")
_TYPES = {1: "u1", 2: "i1", 3: "<u2", 4: "<i2", 5: "<u4", 6: "<i4", 7: "<u8", 8: "<i8", 9: "<f2", 10: "<f4", 11: "<f8"}


class _Field(NamedTuple):
    """Place of an array, checked against the size of the file."""

    name: str
    dtype: np.dtype[Any]
    shape: tuple[int, ...]
    first: int

    @property
    def last(self) -> int:
        """The byte behind it."""
        return self.first + self.dtype.itemsize * math.prod(self.shape)


def looks_like_tensor_file(head: bytes) -> bool:
    """True if a file that begins with `head` is a tensor_file, of any version and however damaged behind that."""
    return head.startswith(MAGIC)


def read_tensor_file(path: str | os.PathLike[str], limit_bytes: int) -> dict[str, NDArray[Any]]:
    """The arrays of a tensor_file of at most `limit_bytes`, by name: read-only views of its content, of any alignment.

    Raises InputError for a file that is not one, is of another version or byte order, or whose fields do not fit into
    it: truncated, too many, of no known type, with absurd dimensions, over one another or over the header.
    """
    content = read_bytes(path, limit_bytes)
    fields, header_end = _fields(path, content)
    _check_places(path, fields, header_end)
    return {
        field.name: np.frombuffer(content, field.dtype, math.prod(field.shape), field.first).reshape(field.shape)
        if math.prod(field.shape)
        else np.empty(field.shape, field.dtype)
        for field in fields
    }


class _Cursor:
    """Reads structures one after the other; InputError where the file ends."""

    def __init__(self, path: str | os.PathLike[str], content: bytes) -> None:
        self.path, self.content, self.place = path, content, 0

    def take(self, count: int) -> bytes:
        taken = self.content[self.place : self.place + count]
        if len(taken) < count:
            raise InputError(self.path, "is cut off within its list of fields", AGAIN)
        self.place += count
        return taken

    def unpack(self, layout: struct.Struct) -> tuple[Any, ...]:
        return layout.unpack(self.take(layout.size))


def _fields(path: str | os.PathLike[str], content: bytes) -> tuple[list[_Field], int]:
    """The announced fields and the first byte behind their list."""
    if not looks_like_tensor_file(content):
        raise InputError(path, "is not a tensor_file: it begins otherwise", "Give a .bsdf file of the RGL database")
    cursor = _Cursor(path, content)
    _, major, minor, count = cursor.unpack(_PREAMBLE)
    if major != 1:
        raise InputError(path, f"is a tensor_file of version {major}.{minor}, and 1.0 is read", "Convert it to 1.0")
    if count > MAX_FIELDS:
        if int.from_bytes(count.to_bytes(4, "little"), "big") <= MAX_FIELDS:
            raise InputError(path, "is byte-swapped: its numbers are big-endian", "Write it in little-endian order")
        raise InputError(path, f"announces {count} fields, more than {MAX_FIELDS}: it is damaged", AGAIN)
    fields = [_field(cursor) for _ in range(count)]
    if len({field.name for field in fields}) < count:
        raise InputError(path, "has two fields of one name: it is damaged", AGAIN)
    return fields, cursor.place


def _field(cursor: _Cursor) -> _Field:
    (length,) = cursor.unpack(_NAME_BYTES)
    if not 0 < length <= MAX_NAME_BYTES:
        raise InputError(cursor.path, f"has a field whose name is {length} bytes long: it is damaged", AGAIN)
    raw = cursor.take(length)
    if not raw.isascii() or not raw.decode("ascii").isprintable():
        raise InputError(cursor.path, "has a field whose name is not text: it is damaged", AGAIN)
    name = raw.decode("ascii")
    dimensions, kind, first = cursor.unpack(_LAYOUT)
    if dimensions > MAX_DIMENSIONS:
        raise InputError(cursor.path, f"has a field {name!r} of {dimensions} dimensions: it is damaged", AGAIN)
    if kind not in _TYPES:
        raise InputError(cursor.path, f"has a field {name!r} of the unknown type {kind}: it is damaged", AGAIN)
    shape = cursor.unpack(struct.Struct(f"<{dimensions}Q"))
    field = _Field(name, np.dtype(_TYPES[kind]), shape, first)
    size_bytes = len(cursor.content)
    # An empty array too, which needs no bytes: NumPy refuses absurd dimensions beside a zero.
    if field.dtype.itemsize * math.prod(max(length, 1) for length in shape) > size_bytes:
        text = " × ".join(map(str, shape))
        problem = f"is damaged: its field {name!r} of {text} numbers does not fit into its {size_bytes} bytes"
        raise InputError(cursor.path, problem, AGAIN)
    if field.last > size_bytes:
        problem = f"is cut off: its field {name!r} ends at byte {field.last}, the file at {size_bytes}"
        raise InputError(cursor.path, problem, AGAIN)
    return field


def _check_places(path: str | os.PathLike[str], fields: list[_Field], header_end: int) -> None:
    """InputError where two arrays, or one and the list of fields, share a byte."""
    end, before = header_end, "the list of fields"
    for field in sorted((field for field in fields if field.last > field.first), key=lambda field: field.first):
        if field.first < end:
            raise InputError(path, f"has a field {field.name!r} that lies over {before}: it is damaged", AGAIN)
        end, before = field.last, repr(field.name)
