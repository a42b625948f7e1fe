"""PNG files of large images, packed some rows at a time into memory or a scratch file.

The bytes are those of OpenCV (`engine.images.encode.encode_png`), whose encoder keeps a whole file in memory several
times: each sample less the one before it (filter Sub), deflated at level 1 with runs alone as matches, in chunks of
8 KiB. Another zlib than the usual one may pack the same samples into other bytes.
PNG (W3C, third edition), sections 5.3 and 9.2.
Cost: bound by zlib, some 80 MB/s of samples on one core; memory for some rows, and of the file as
`engine.storage.scratch` has it.
"""

from __future__ import annotations

import math
import os
import struct
import zlib
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from engine.images.encode import encode_png, write_png_chunk, write_png_tags
from engine.images.png import SIGNATURE
from engine.images.raster import Transfer
from engine.storage.atomic import write_bytes
from engine.storage.scratch import ScratchPieces

#: Bytes of samples that are packed at once; smaller images are encoded whole. Bytes of the image data of a chunk.
_PART_BYTES, _CHUNK_BYTES = 1 << 22, 1 << 13

#: Numbers of the header for grey, colour, and colour with alpha, by channels.
_COLOUR_TYPES = {1: 0, 3: 2, 4: 6}

Codes = NDArray[np.uint8] | NDArray[np.uint16]


def encode_png_rows(
    pixels: Codes, *, transfer: Transfer = "srgb", software: str = "", comment: str = ""
) -> ScratchPieces:
    """The file that `encode_png` makes, in pieces; OutputError where the disk has no room for it."""
    if pixels.nbytes <= _PART_BYTES:
        return ScratchPieces([encode_png(pixels, transfer=transfer, software=software, comment=comment)])
    return ScratchPieces(_pack(pixels, write_png_tags(transfer, software, comment)))


def write_png(
    path: str | os.PathLike[str], pixels: Codes, *, transfer: Transfer = "srgb", software: str = "", comment: str = ""
) -> None:
    """Write the file that `encode_png` makes."""
    write_bytes(path, encode_png_rows(pixels, transfer=transfer, software=software, comment=comment))


def _pack(pixels: Codes, tags: bytes) -> Iterator[bytes]:
    height, width = pixels.shape[:2]
    channels = math.prod(pixels.shape[2:])
    step = channels * pixels.itemsize
    header = struct.pack(">IIBBBBB", width, height, 8 * pixels.itemsize, _COLOUR_TYPES[channels], 0, 0, 0)
    yield SIGNATURE + write_png_chunk(b"IHDR", header) + tags
    packer = zlib.compressobj(1, zlib.DEFLATED, zlib.MAX_WBITS, 8, zlib.Z_RLE)
    packed = b""
    rows = max(1, _PART_BYTES // (step * width))
    for first in range(0, height, rows):
        packed += packer.compress(_filter(pixels[first : first + rows], step))
        whole = len(packed) - len(packed) % _CHUNK_BYTES
        yield b"".join(_split(packed[:whole]))
        packed = packed[whole:]
    yield b"".join([*_split(packed + packer.flush()), write_png_chunk(b"IEND", b"")])


def _filter(pixels: Codes, step: int) -> memoryview:
    """Rows of samples, each less the one `step` bytes before it, after the number of the filter."""
    ordered = np.ascontiguousarray(pixels, pixels.dtype.newbyteorder(">"))
    plain = ordered.view(np.uint8).reshape(len(pixels), -1)
    filtered = np.empty((len(plain), 1 + plain.shape[1]), np.uint8)
    filtered[:, 0] = 1
    filtered[:, 1 : 1 + step] = plain[:, :step]
    np.subtract(plain[:, step:], plain[:, :-step], out=filtered[:, 1 + step :])
    return filtered.data


def _split(packed: bytes) -> Iterator[bytes]:
    return (write_png_chunk(b"IDAT", packed[at : at + _CHUNK_BYTES]) for at in range(0, len(packed), _CHUNK_BYTES))
