"""Maps from an OpenEXR or PNG member of a bundle; the decoders run in the child of `engine.storage.untrusted`.

They were written by `engine.images.encode` as floats, half floats or codes and come back bit for bit. Maps as they are
written are read strip by strip, so that they may be larger than memory. A member is read twice: before it is decoded
its fingerprint is compared.
Cost: about 200 MB/s.
"""

from __future__ import annotations

import hashlib
import io
import struct
from collections.abc import Sequence
from typing import IO, Any

import cv2
import numpy as np
import OpenEXR

from engine.core.errors import InputError
from engine.images.exr_strips import find_strips, read_strips
from engine.images.png import SIGNATURE
from engine.storage.archive_child import open_member
from engine.storage.shared_memory import result_array

_PART_BYTES = 1 << 22


def decode_maps(
    file: IO[bytes],
    name: str,
    member: Sequence[Any],
    channels: Sequence[str],
    height: int,
    width: int,
    half: bool = False,
) -> dict[str, Any]:
    """The `channels` of an OpenEXR file as `{"maps": (C, H, W) float32}`; they must be of half floats where `half`.

    `member` is its place in the zip `file`, -1 for the file itself, and its size and fingerprint (`Archive.decode`).
    Raises InputError, before any pixel is decoded, where it is not as it was written, or where size or channels are not
    the expected ones.
    """
    with _open_checked(file, name, member) as stream:
        kind = np.dtype(np.float16 if half else np.float32)
        strips = find_strips(stream)
        expected = (sorted(channels), kind, height, width)
        if strips is None or (sorted(strips.channels), strips.kind, strips.height, strips.width) != expected:
            stream.seek(0)
            return _decode_whole(stream.read(), name, channels, height, width, kind)
        maps = result_array((len(channels), height, width), np.float32)
        places = [strips.channels.index(channel) for channel in channels]
        for first, samples in read_strips(stream, strips):
            maps[:, first : first + len(samples)] = samples[:, places].swapaxes(0, 1)
    return {"maps": maps}


def _open_checked(file: IO[bytes], name: str, member: Sequence[Any]) -> IO[bytes]:
    """The member as a file, after its size and fingerprint have been found right; else InputError."""
    number, size_bytes, sha256 = member
    stream = open_member(file, name, number)
    found, count = hashlib.sha256(), 0
    while part := stream.read(_PART_BYTES):
        found.update(part)
        count += len(part)
    if (count, found.hexdigest()) != (size_bytes, sha256):
        raise InputError(name, "is not as it was written", "Ask for the bundle again")
    stream.seek(0)
    return stream


def _decode_whole(
    content: bytes, name: str, channels: Sequence[str], height: int, width: int, kind: np.dtype[Any]
) -> dict[str, Any]:
    """As `decode_maps`, by OpenEXR, which tells what is not as it should be."""
    header = OpenEXR.File(io.BytesIO(content), header_only=True).parts[0].header
    low, high = (np.asarray(corner, dtype=np.int64) for corner in header["dataWindow"])
    columns, rows = (int(size) for size in high - low + 1)
    if (rows, columns) != (height, width):
        raise _report_unexpected(name, f"has {rows} x {columns} pixels where the manifest says {height} x {width}")
    if sorted(channel.name for channel in header["channels"]) != sorted(channels):
        raise _report_unexpected(name, f"has other channels than the {len(channels)} that the manifest implies")
    pixels = OpenEXR.File(io.BytesIO(content), separate_channels=True).parts[0].channels
    for channel in channels:
        if pixels[channel].pixels.dtype != kind or pixels[channel].pixels.shape != (height, width):
            bits = 8 * kind.itemsize
            raise _report_unexpected(
                name, f"has a channel {channel} that is not of {bits}-bit floats at full resolution"
            )
    return {"maps": np.stack([pixels[channel].pixels for channel in channels]).astype(np.float32, copy=False)}


def decode_codes(
    file: IO[bytes], name: str, member: Sequence[Any], bits: int, height: int, width: int, grey: bool = False
) -> dict[str, Any]:
    """The codes of an RGB PNG of 8 or 16 bits as `{"maps": (H, W, 3) uint8 or uint16}`, (H, W) where it is `grey`.

    Raises InputError, before any pixel is decoded, where size, depth or channels are not the expected ones.
    """
    with _open_checked(file, name, member) as stream:
        content = stream.read()
    kind = 0 if grey else 2
    if content[:8] != SIGNATURE or content[12:16] != b"IHDR" or len(content) < 33:
        raise _report_unexpected(name, "is not a PNG")
    if struct.unpack(">IIBB", content[16:26]) != (width, height, bits, kind):
        what = "a grey" if grey else "an RGB"
        raise _report_unexpected(name, f"is not {what} image of {height} x {width} pixels with {bits} bits each")
    codes = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_UNCHANGED)
    shape = (height, width) if grey else (height, width, 3)
    if codes is None or codes.shape != shape or codes.dtype.itemsize * 8 != bits:
        raise _report_unexpected(name, "is damaged")
    return {"maps": codes if grey else np.ascontiguousarray(codes[..., ::-1])}


def _report_unexpected(name: str, problem: str) -> InputError:
    return InputError(name, problem, "Export the bundle again")
