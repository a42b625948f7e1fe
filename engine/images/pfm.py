"""Portable float maps: three lines of text, then floats of 32 bits, rows from the bottom up.

`PF` has red, green and blue, `Pf` one channel; then width and height, and a scale, whose sign tells the order of bytes.
Its size is a factor of the values for a unit of radiance, which programs do not agree on; it is not applied.
"""

from __future__ import annotations

import re

import numpy as np

from engine.core.errors import InputError
from engine.images.raster import Raster, check_size
from engine.storage.untrusted import AGAIN

_HEADER = re.compile(
    rb"P([Ff])\s{1,9}+(\d{1,9}+)\s{1,9}+(\d{1,9}+)\s{1,9}+([-+]?[0-9.]{1,20}+(?:[eE][-+]?\d{1,3}+)?)\s"
)


def read_pfm(content: bytes, name: str) -> Raster:
    """Colours or grey, either order of bytes; InputError for one that is cut short."""
    found = _HEADER.match(content)
    if found is None:
        raise InputError(name, "is a damaged PFM image (its header is not one)", AGAIN)
    width, height, channels = int(found[2]), int(found[3]), 3 if found[1] == b"F" else 1
    check_size(name, width, height, 12, len(content))
    try:
        scale = float(found[4])
    except ValueError:
        scale = 0.0
    if scale == 0.0:
        raise InputError(name, "is a PFM image that states no order of its bytes", AGAIN)
    count = width * height * channels
    if len(content) - found.end() < 4 * count:
        raise InputError(name, "is an incomplete PFM image: it ends before its image does", AGAIN)
    values = np.frombuffer(content, "<f4" if scale < 0.0 else ">f4", count, found.end())
    samples = values.reshape(height, width, channels)[::-1].astype(np.float32)
    warnings = () if abs(scale) == 1.0 else (f"states a scale of {abs(scale):g}, which is not applied",)
    shown = samples if channels == 3 else samples[..., 0]
    return Raster(np.ascontiguousarray(shown), None, 32, "linear", "PFM", warnings)
