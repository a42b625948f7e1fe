"""Maps from an OpenEXR or PNG member of a bundle; the decoders run in the child of `engine.storage.untrusted`.

They were written by `engine.images.encode` as floats, half floats or codes and come back bit for bit.
Cost: about 200 MB/s.
"""

from __future__ import annotations

import io
import struct
from collections.abc import Sequence
from typing import Any

import cv2
import numpy as np
import OpenEXR

from engine.core.errors import InputError
from engine.images.png import SIGNATURE


def decode_maps(
    content: bytes, name: str, channels: Sequence[str], height: int, width: int, half: bool = False
) -> dict[str, Any]:
    """The `channels` of an OpenEXR file as `{"maps": (C, H, W) float32}`; they must be of half floats where `half`.

    Raises InputError, before any pixel is decoded, where the size or the channels are not the expected ones.
    """
    header = OpenEXR.File(io.BytesIO(content), header_only=True).parts[0].header
    low, high = (np.asarray(corner, dtype=np.int64) for corner in header["dataWindow"])
    columns, rows = (int(size) for size in high - low + 1)
    if (rows, columns) != (height, width):
        raise _report_unexpected(name, f"has {rows} x {columns} pixels where the manifest says {height} x {width}")
    if sorted(channel.name for channel in header["channels"]) != sorted(channels):
        raise _report_unexpected(name, f"has other channels than the {len(channels)} that the manifest implies")
    pixels = OpenEXR.File(io.BytesIO(content), separate_channels=True).parts[0].channels
    kind = np.dtype(np.float16 if half else np.float32)
    for channel in channels:
        if pixels[channel].pixels.dtype != kind or pixels[channel].pixels.shape != (height, width):
            bits = 8 * kind.itemsize
            raise _report_unexpected(
                name, f"has a channel {channel} that is not of {bits}-bit floats at full resolution"
            )
    return {"maps": np.stack([pixels[channel].pixels for channel in channels]).astype(np.float32, copy=False)}


def decode_codes(content: bytes, name: str, bits: int, height: int, width: int, grey: bool = False) -> dict[str, Any]:
    """The codes of an RGB PNG of 8 or 16 bits as `{"maps": (H, W, 3) uint8 or uint16}`, (H, W) where it is `grey`.

    Raises InputError, before any pixel is decoded, where size, depth or channels are not the expected ones.
    """
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
