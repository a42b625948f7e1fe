"""JPEG (ITU-T T.81). The file's segments are walked to the end before libjpeg sees them.

libjpeg fills what is missing with grey and says so on stderr only; here an incomplete file is an error.
"""

from __future__ import annotations

import re
import struct
from dataclasses import dataclass, replace

import cv2
import numpy as np

from engine.core.errors import InputError
from engine.images.raster import UNWANTED, Raster, check_size
from engine.storage.decoder_child import complaints
from engine.storage.untrusted import AGAIN

SIGNATURE = b"\xff\xd8\xff"

#: A marker inside entropy-coded data: not a stuffed zero, not a restart marker, not fill bytes.
_MARKER = re.compile(rb"\xff[^\x00\xd0-\xd7\xff]", re.DOTALL)
_FRAMES = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}
_LOSSLESS = frozenset({0xC3, 0xC7, 0xCB, 0xCF})
_START_OF_SCAN, _END, _APP2 = 0xDA, 0xD9, 0xE2


@dataclass(frozen=True)
class _Frame:
    kind: int
    bits: int
    height: int
    width: int
    components: int
    profile: bytes = b""


def read_jpeg(content: bytes, name: str) -> Raster:
    frame = check_jpeg(content, name)
    if frame.components not in (1, 3):
        kind = "CMYK" if frame.components == 4 else f"of {frame.components} components"
        raise InputError(name, f"is a JPEG {kind}", UNWANTED)
    if frame.bits != 8 or frame.kind in _LOSSLESS:
        kind = "lossless" if frame.kind in _LOSSLESS else f"{frame.bits}-bit"
        raise InputError(name, f"is a {kind} JPEG", UNWANTED)
    check_size(name, frame.width, frame.height, 3, len(content))
    with complaints() as said:
        samples = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_COLOR_RGB | cv2.IMREAD_IGNORE_ORIENTATION)
    damage = [line for line in said if "JPEG" in line]
    if samples is None or damage:
        raise InputError(name, f"is a damaged JPEG ({damage[0].strip() if damage else 'it cannot be decoded'})", AGAIN)
    return Raster(samples, 255, 8, "srgb", "JPEG", is_grey=frame.components == 1, profile=frame.profile)


def check_jpeg(content: bytes, name: str) -> _Frame:
    """The frame header of a JPEG whose segments are complete up to its end marker; else InputError."""
    frame: _Frame | None = None
    profile: dict[int, bytes] = {}
    at = 2
    while True:
        marker = _marker_at(content, at, name)
        if marker == _END:
            break
        if marker == 0x01 or 0xD0 <= marker <= 0xD7:
            at += 2
            continue
        length = int.from_bytes(content[at + 2 : at + 4], "big")
        body = content[at + 4 : at + 2 + length]
        if length < 2 or len(body) != length - 2:
            raise _incomplete(name)
        if marker in _FRAMES and len(body) >= 6 and frame is None:
            frame = _frame(marker, body)
        elif marker == _APP2 and body.startswith(b"ICC_PROFILE\0"):
            profile[body[12] if len(body) > 12 else 0] = body[14:]
        at += 2 + length
        if marker == _START_OF_SCAN:
            found = _MARKER.search(content, at)
            if found is None:
                raise _incomplete(name)
            at = found.start()
    if frame is None:
        raise InputError(name, "is a JPEG without an image", AGAIN)
    return replace(frame, profile=b"".join(part for _, part in sorted(profile.items())))


def _frame(marker: int, body: bytes) -> _Frame:
    bits, height, width, components = struct.unpack(">BHHB", body[:6])
    return _Frame(marker, bits, height, width, components)


def _marker_at(content: bytes, at: int, name: str) -> int:
    while content[at : at + 2] == b"\xff\xff":
        at += 1
    if len(content) < at + 2:
        raise _incomplete(name)
    if content[at] != 0xFF:
        raise InputError(name, f"is a damaged JPEG (no marker at byte {at})", AGAIN)
    return content[at + 1]


def _incomplete(name: str) -> InputError:
    return InputError(name, "is an incomplete JPEG: it ends before its image does", AGAIN)
