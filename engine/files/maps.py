"""Maps of floats from an OpenEXR member of a bundle; `decode_maps` runs in the child of `engine.files.untrusted`.

They were written by `engine.images.encode.encode_exr` as 32-bit floats and come back bit for bit.
Cost: about 200 MB/s.
"""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import Any

import numpy as np

from engine.errors import InputError


def decode_maps(content: bytes, name: str, channels: Sequence[str], height: int, width: int) -> dict[str, Any]:
    """The `channels` of an OpenEXR file as `{"maps": (C, H, W) float32}`.

    Raises InputError, before any pixel is decoded, where the size or the channels are not the expected ones.
    """
    import OpenEXR

    header = OpenEXR.File(io.BytesIO(content), header_only=True).parts[0].header
    low, high = (np.asarray(corner, dtype=np.int64) for corner in header["dataWindow"])
    columns, rows = (int(size) for size in high - low + 1)
    if (rows, columns) != (height, width):
        raise _unexpected(name, f"has {rows} x {columns} pixels where the manifest says {height} x {width}")
    if sorted(channel.name for channel in header["channels"]) != sorted(channels):
        raise _unexpected(name, f"has other channels than the {len(channels)} that the manifest implies")
    pixels = OpenEXR.File(io.BytesIO(content), separate_channels=True).parts[0].channels
    for channel in channels:
        if pixels[channel].pixels.dtype != np.float32 or pixels[channel].pixels.shape != (height, width):
            raise _unexpected(name, f"has a channel {channel} that is not of 32-bit floats at full resolution")
    return {"maps": np.stack([pixels[channel].pixels for channel in channels])}


def _unexpected(name: str, problem: str) -> InputError:
    return InputError(name, problem, "Export the bundle again")
