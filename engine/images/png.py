"""PNG (W3C, third edition). Every chunk's checksum and the end chunk are verified before libpng decodes.

OpenCV keeps to itself what is found here: the size before anything is allocated, gamma and profile, and the damage.
"""

from __future__ import annotations

import struct
import zlib
from typing import Any

import cv2
import numpy as np

from engine.core.colour import CHROMATICITIES, REC_2020
from engine.core.errors import InputError
from engine.images.colour_space import (
    BT709_CURVE,
    LINEAR_CURVE,
    P3,
    SRGB_CURVE,
    ColourSpace,
    from_chromaticities,
    gamma,
)
from engine.images.icc import MAX_PROFILE_BYTES, InvalidProfile
from engine.images.raster import Raster, Transfer, check_size, white_code
from engine.storage.decoder_child import complaints
from engine.storage.untrusted import AGAIN

SIGNATURE = b"\x89PNG\r\n\x1a\n"
LINEAR_GAMMA = struct.pack(">I", 100000)

#: Gamma that programs state beside sRGB samples; others have to be between these.
_SRGB_GAMMA, _GAMMAS = 45455, (20000, 200000)

_CODED_PRIMARIES = {
    1: CHROMATICITIES,
    9: REC_2020.chromaticities,
    11: (*P3, 0.314, 0.351),
    12: (*P3, *CHROMATICITIES[6:]),
}
_CODED_CURVES = {
    1: BT709_CURVE,
    4: gamma(2.2),
    5: gamma(2.8),
    6: BT709_CURVE,
    8: LINEAR_CURVE,
    13: SRGB_CURVE,
    14: BT709_CURVE,
    15: BT709_CURVE,
}

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
    warnings: tuple[str, ...] = ()
    if samples.ndim == 3:
        warnings = (_ALPHA,) * (samples.shape[2] == 4)
        samples = samples[..., 2::-1]
    bits = samples.dtype.itemsize * 8
    white = white_code(samples, 16) if bits == 16 else 255
    has_profile = b"cICP" not in chunks and b"iCCP" in chunks  # cICP comes before iCCP, and that before the others
    space, invalid = None, ""
    try:
        space = None if has_profile else _space(chunks)
    except InvalidProfile as error:
        invalid = str(error)
    return Raster(
        samples,
        white,
        min(header[8], bits),
        _transfer(chunks),
        "PNG",
        warnings,
        is_grey=header[9] in (0, 4),
        profile=_profile(chunks[b"iCCP"]) if has_profile else b"",
        space=space,
        invalid_space=invalid,
    )


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
    """The profile, or one byte more than a profile may have; what is no profile where it cannot be unpacked."""
    try:
        return zlib.decompressobj().decompress(chunk.partition(b"\0")[2][1:], MAX_PROFILE_BYTES + 1) or b"empty"
    except zlib.error:
        return b"damaged"


def _space(chunks: dict[bytes, bytes]) -> ColourSpace | None:
    """The space that cICP, or gAMA and cHRM without sRGB, state; InvalidProfile for one that cannot be applied."""
    if b"cICP" in chunks:
        return _coded_space(chunks[b"cICP"])
    if b"sRGB" in chunks or not {b"gAMA", b"cHRM"} & chunks.keys():
        return None
    curve, matrix = SRGB_CURVE, None
    stated = int.from_bytes(chunks.get(b"gAMA", b"")[:4], "big")
    if b"gAMA" in chunks and abs(stated - _SRGB_GAMMA) > _SRGB_GAMMA / 100:
        if not _GAMMAS[0] <= stated <= _GAMMAS[1]:
            raise InvalidProfile("states a gamma that no image has")
        curve = LINEAR_CURVE if chunks[b"gAMA"] == LINEAR_GAMMA else gamma(100000 / stated)
    if len(chunks.get(b"cHRM", b"")) == 32:
        white, rgb = np.split(np.frombuffer(chunks[b"cHRM"], ">u4").astype(np.float64) / 100000, [2])
        try:
            matrix = from_chromaticities((*rgb, *white))
        except ValueError:
            raise InvalidProfile("states primaries that no colours have") from None
    if matrix is None and curve in (SRGB_CURVE, LINEAR_CURVE):
        return None
    return ColourSpace("gAMA and cHRM of the file", (curve,), matrix)


def _coded_space(chunk: bytes) -> ColourSpace:
    """The space of the numbers of ITU-T H.273: primaries, curve, matrix, and whether the range is full."""
    primaries, curve, matrix, full = chunk if len(chunk) == 4 else (0, 0, 0, 0)
    known = primaries in _CODED_PRIMARIES and curve in _CODED_CURVES and matrix == 0 and full == 1
    if not known:
        raise InvalidProfile(f"has the coding (cICP) {'-'.join(map(str, chunk[:4]))}, which is not for photographs")
    name = f"cICP {primaries}-{curve}"
    return ColourSpace(name, (_CODED_CURVES[curve],), from_chromaticities(_CODED_PRIMARIES[primaries]))


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
