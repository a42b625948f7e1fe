"""Maps of floats as OpenEXR files that restore every bit: 32-bit floats, ZIP compression, one channel per name.

Radiance carries the chromaticities of linear sRGB (ITU-R BT.709, D65); data maps (exponents) carry none, and neither
is ever gamma-coded. `decode_maps` runs in the child interpreter of `engine.files.untrusted`.
Cost: about 25 MB/s to write photographic data, 200 MB/s to read, both without the interpreter lock.
"""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import OpenEXR
from numpy.typing import NDArray

from engine.errors import InputError

#: x, y of red, green, blue and white.
CHROMATICITIES = (0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290)


def encode_maps(channels: Mapping[str, NDArray[np.float32]], attributes: Mapping[str, Any]) -> bytes:
    """An OpenEXR file of (H, W) float32 `channels`, with `attributes` in its header."""
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage, **attributes}
    content = io.BytesIO()
    OpenEXR.File(header, {name: np.ascontiguousarray(channel) for name, channel in channels.items()}).write(content)
    return content.getvalue()


def decode_maps(content: bytes, name: str, channels: Sequence[str], height: int, width: int) -> dict[str, Any]:
    """The `channels` of an OpenEXR file as `{"maps": (C, H, W) float32}`.

    Raises InputError, before any pixel is decoded, where the size or the channels are not the expected ones.
    """
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
