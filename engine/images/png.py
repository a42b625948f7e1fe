"""PNG (W3C, third edition). Every chunk's checksum and the end chunk are verified before libpng decodes.

OpenCV keeps to itself what is found here: the size before anything is allocated, gamma and profile, and the damage.
"""

from __future__ import annotations

import struct
import zlib
from typing import Any

import cv2
import numpy as np

from engine.core.errors import InputError
from engine.images.raster import Raster, Transfer, check_size, profile_warning, white_code
from engine.storage.decoder_child import complaints
from engine.storage.untrusted import AGAIN

SIGNATURE = b"\x89PNG\r\n\x1a\n"
LINEAR_GAMMA = struct.pack(">I", 100000)

_SAMPLES = {0: 1, 2: 3, 3: 3, 4: 2, 6: 4}
_ALPHA = "has an alpha channel, which is ignored"


def read_png(content: bytes, name: str) -> Raster:
    chunks = _check_chunks(content, name)
    header = chunks.get(b"IHDR", b"")
    if len(header) != 13 or header[9] not in _SAMPLES:
        raise InputError(name, "is a damaged PNG (its header is wrong)", AGAIN)
    width, height = struct.unpack(">II", header[:8])
    check_size(name, width, height, _SAMPLES[header[9]] * (2 if header[8] == 16 else 1), len(content))
    with complaints() as said:
        samples = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_UNCHANGED | cv2.IMREAD_IGNORE_ORIENTATION)
    damage = [line for line in said if "libpng error" in line or "Not enough" in line]
    if samples is None or damage or samples.shape[:2] != (height, width):
        raise InputError(name, f"is a damaged PNG ({damage[0].strip() if damage else 'it cannot be decoded'})", AGAIN)
    warnings = profile_warning(_profile(chunks.get(b"iCCP", b"")))
    if samples.ndim == 3:
        warnings += (_ALPHA,) * (samples.shape[2] == 4)
        samples = samples[..., 2::-1]
    bits = samples.dtype.itemsize * 8
    white = white_code(samples, 16) if bits == 16 else 255
    return Raster(samples, white, min(header[8], bits), _transfer(chunks), "PNG", warnings)


def _check_chunks(content: bytes, name: str) -> dict[bytes, bytes]:
    """Chunks by type, image data left out, each with its checksum right and the end chunk present."""
    chunks: dict[bytes, bytes] = {}
    view = memoryview(content)
    at = len(SIGNATURE)
    kind = b""
    while kind != b"IEND":
        if at + 12 > len(content):
            raise InputError(name, "is an incomplete PNG: it ends before its image does", AGAIN)
        length = int.from_bytes(view[at : at + 4], "big")
        kind = bytes(view[at + 4 : at + 8])
        end = at + 8 + length
        if end + 4 > len(content):
            raise InputError(name, "is an incomplete PNG: it ends before its image does", AGAIN)
        if zlib.crc32(view[at + 4 : end]) != int.from_bytes(view[end : end + 4], "big"):
            raise InputError(name, f"is a damaged PNG (wrong checksum at byte {at})", AGAIN)
        if kind != b"IDAT":
            chunks.setdefault(kind, bytes(view[at + 8 : end]))
        at = end + 4
    return chunks


def _transfer(chunks: dict[bytes, bytes]) -> Transfer:
    return "linear" if chunks.get(b"gAMA") == LINEAR_GAMMA and b"sRGB" not in chunks else "srgb"


def _profile(chunk: bytes) -> bytes:
    compressed = chunk.partition(b"\0")[2][1:]
    return zlib.decompressobj().decompress(compressed, 1 << 22) if compressed else b""


def read_alpha(content: bytes, name: str) -> np.ndarray[Any, Any]:
    """The alpha channel (H, W) of a PNG with colour, as codes; InputError where there is none."""
    header = _check_chunks(content, name).get(b"IHDR", b"")
    if len(header) != 13 or header[9] != 6:
        raise InputError(name, "has no alpha channel", "Save it with its fourth channel, as a PNG")
    width, height = struct.unpack(">II", header[:8])
    check_size(name, width, height, 4 * (2 if header[8] == 16 else 1), len(content))
    samples = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_UNCHANGED | cv2.IMREAD_IGNORE_ORIENTATION)
    if samples is None or samples.shape != (height, width, 4):
        raise InputError(name, "is a damaged PNG (it cannot be decoded)", AGAIN)
    return np.ascontiguousarray(samples[..., 3])
