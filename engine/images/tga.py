"""Targa (TGA) images, as renderers and older photometric-stereo collections have them, read by Pillow.

The format has no signature: version 2 ends with one, and for version 1 the fields of the header have to make sense.
So a file is tried as Targa only when no other reader knows it. Alpha is ignored; samples are sRGB-coded.
"""

from __future__ import annotations

import io
import struct

import numpy as np

from engine.core.errors import InputError
from engine.images.raster import Raster, check_size
from engine.storage.untrusted import AGAIN

_FOOTER = b"TRUEVISION-XFILE.\0"
_HEADER = struct.Struct("<3B 2HB 4H 2B")

#: Bits of a pixel that Pillow reads, by kind of image (palette, colour, grey; 8 more where runs are packed).
_DEPTHS = {1: (8,), 2: (16, 24, 32), 3: (8, 16)}
_MAP_DEPTHS = (0, 16, 24, 32)


def looks_like_tga(content: bytes, _size_bytes: int, _name: str) -> bool:
    """True for a Targa image, by its footer or by a header without contradictions.

    `content` is all of it: only the whole has the footer.
    """
    if len(content) < _HEADER.size:
        return False
    _, has_map, kind, _, map_length, map_depth, _, _, width, height, depth, flags = _HEADER.unpack_from(content)
    if kind & ~8 not in _DEPTHS or has_map > 1 or width == 0 or height == 0:
        return False
    if content.endswith(_FOOTER):
        return True
    fits = depth in _DEPTHS[kind & ~8] and map_depth in _MAP_DEPTHS and not flags & 0xC0
    return fits and (has_map == 1 if kind & ~8 == 1 else map_length == 0 or has_map == 1)


def _refuse_other_size(content: bytes, name: str) -> None:
    """Refuse plain pixels of a whole row or more beyond the size that the header states: the size is damaged."""
    length, has_map, kind, _, map_length, map_depth, _, _, width, height, depth, _ = _HEADER.unpack_from(content)
    footer = content[-26:] if content.endswith(_FOOTER) else b""
    if kind & 8 or footer[:8].strip(b"\0"):  # packed pixels do not tell their size, other areas lie behind them
        return
    pixels = len(content) - len(footer) - _HEADER.size - length - has_map * map_length * ((map_depth + 7) // 8)
    row_bytes = width * ((depth + 7) // 8)
    if pixels >= (height + 1) * row_bytes:
        raise InputError(name, "is a damaged Targa image: it holds more rows than it states", AGAIN)


def read_tga(content: bytes, name: str) -> Raster:
    """Grey, colour and palette images, packed or not, from any corner; InputError for one that is cut short."""
    from PIL.TgaImagePlugin import TgaImageFile

    *_, width, height, depth, _ = _HEADER.unpack_from(content)
    check_size(name, width, height, 4, len(content))
    _refuse_other_size(content, name)
    try:
        image = TgaImageFile(io.BytesIO(content))
        image.load()
    except (SyntaxError, OSError, EOFError):
        raise InputError(name, "is a damaged or incomplete Targa image", AGAIN) from None
    if image.mode == "1":
        raise InputError(name, "is a Targa image of black and white alone", "Save it as an RGB or grey image")
    warnings = ("has an alpha channel, which is ignored",) if depth == 32 or image.mode == "LA" else ()
    if depth == 16 and image.mode != "LA":
        warnings = ("has five bits for each channel, too few to measure light",)
    samples = np.asarray(image.convert("L" if image.mode in ("L", "LA") else "RGB"))
    return Raster(samples, 255, 5 if depth == 16 and image.mode != "LA" else 8, "srgb", "TGA", warnings)
