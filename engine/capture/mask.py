"""The mask of a stack: the texels that show the object, kept with its record as bits that are compressed."""

from __future__ import annotations

import base64
import binascii
import zlib

import numpy as np
from numpy.typing import NDArray

from engine.capture.stack import ImageStack
from engine.core.errors import InputError

Mask = NDArray[np.bool_]


def pack(mask: Mask) -> str:
    """A mask as text."""
    return base64.b64encode(zlib.compress(np.packbits(mask).tobytes())).decode("ascii")


def mask_of(stack: ImageStack) -> Mask | None:
    """(H, W) True where the stack shows the object; None where it has no mask. InputError for a damaged one."""
    packed = stack.provenance.get("mask")
    if packed is None:
        return None
    shape = (stack.radiance.shape[1], stack.radiance.shape[2])
    length = -(-shape[0] * shape[1] // 8)
    try:
        content = zlib.decompressobj().decompress(base64.b64decode(packed, validate=True), length + 1)
    except (zlib.error, binascii.Error, TypeError, ValueError):
        content = b""
    if len(content) != length:
        raise InputError(stack.folder or "the stack", "holds a damaged mask", "Import the photographs again")
    bits = np.unpackbits(np.frombuffer(content, np.uint8), count=shape[0] * shape[1])
    return np.asarray(bits.reshape(shape) > 0)
