"""ICC profiles of images (ICC.1:2001 and ICC.1:2022): what they say of samples, checked before it is used.

Profiles of red, green and blue, or of grey, are read: curves and primaries here, tables by Little CMS, which sees none
but those that passed these checks, in the confined process of the decoder. The colorimetric table (A2B1) comes before
the perceptual one (A2B0), and a table before curves and primaries, as the standard has it.
"""

from __future__ import annotations

import struct
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.core.colour import D65, XYZ_FROM_SRGB, adaptation
from engine.images.colour_space import (
    D50,
    LINEAR_CURVE,
    SRGB_CURVE,
    ColourSpace,
    Curve,
    apply_table,
    from_xyz,
    gamma,
)

#: Largest profile that is read; tables of cameras and scanners take up to 2 MB.
MAX_PROFILE_BYTES = 4 << 20

MAX_TAGS = 100

#: Samples of one curve.
MAX_CURVE_SAMPLES = 1 << 16

MAX_NAME = 80

_HEADER_BYTES, _TAG_BYTES = 128, 12
_GREY, _RGB = b"GRAY", b"RGB "
_MODELS = {b"CMYK": "CMYK", b"Lab ": "CIE L*a*b*", b"XYZ ": "CIE XYZ", b"YCbr": "YCbCr", b"HSV ": "HSV", b"CMY ": "CMY"}
_CLASSES = (b"mntr", b"scnr", b"prtr", b"spac")

#: Luminance of the sum of the primaries, and its distance from the white of the profile, in x and y.
_WHITE_RANGE, _WHITE_DISTANCE = (0.95, 1.05), 0.02

#: Number of parameters of each type of parametric curve.
_PARAMETERS = (1, 3, 4, 5, 7)


class InvalidProfile(ValueError):
    """A profile that cannot be applied; its text completes "its colour profile …"."""


def read_profile(content: bytes) -> ColourSpace:
    """Read the space that an ICC profile describes; InvalidProfile for one that cannot be applied."""
    if len(content) > MAX_PROFILE_BYTES:
        raise InvalidProfile(f"has more than {MAX_PROFILE_BYTES >> 20} MiB")
    if len(content) < _HEADER_BYTES + 4 or content[36:40] != b"acsp":
        raise InvalidProfile("is not an ICC profile")
    size_bytes = int.from_bytes(content[:4], "big")
    if size_bytes > len(content):
        raise InvalidProfile(f"is truncated: {len(content)} of {size_bytes} bytes are there")
    content = content[:size_bytes]
    kind, model, connection = content[12:16], content[16:20], content[20:24]
    tags = _tags(content)
    name = _name(tags)
    if model not in (_GREY, _RGB):
        raise InvalidProfile(f"{name!r} is for {_MODELS.get(model, 'another colour model')}")
    if kind not in _CLASSES or connection not in (b"XYZ ", b"Lab "):
        raise InvalidProfile(f"{name!r} does not describe the colours of a device")
    if model == _GREY:
        if connection == b"Lab ":
            raise InvalidProfile(f"{name!r} states grey as lightness")
        return ColourSpace(name, settle_curves((check_curve(_curve(tags, b"kTRC")),)), is_grey=True)
    if b"A2B1" in tags or b"A2B0" in tags:
        return _table(name, content)
    curves = tuple(check_curve(_curve(tags, tag)) for tag in (b"rTRC", b"gTRC", b"bTRC"))
    primaries = np.stack([_xyz(tags, tag) for tag in (b"rXYZ", b"gXYZ", b"bXYZ")], axis=1)
    _check_primaries(primaries, _xyz(tags, b"wtpt") if b"wtpt" in tags else D50)
    curves = curves[:1] if all(curve.is_like(curves[0]) for curve in curves) else curves
    return ColourSpace(name, settle_curves(curves), from_xyz(primaries))


def write_profile(transfer: Literal["srgb", "linear"]) -> bytes:
    """The ICC profile (version 4.3) of Rec. 709 primaries with the curve of sRGB, or with none: ever the same bytes."""
    from_d65 = adaptation(D65, D50)
    primaries = (from_d65 @ XYZ_FROM_SRGB).T
    numbers = (1.0,) if transfer == "linear" else (2.4, 1 / 1.055, 0.055 / 1.055, 1 / 12.92, 0.04045)
    curve = b"para" + struct.pack(">I2H", 0, 0 if transfer == "linear" else 3, 0) + _to_fixed_point(numbers)
    name = "Linear Rec. 709" if transfer == "linear" else "sRGB IEC61966-2.1"
    bodies = {
        b"desc": _words(name),
        b"cprt": _words("No rights reserved"),
        b"wtpt": b"XYZ " + bytes(4) + _to_fixed_point(D50),
        b"chad": b"sf32" + bytes(4) + _to_fixed_point(from_d65.ravel()),
        **{
            tag: b"XYZ " + bytes(4) + _to_fixed_point(each)
            for tag, each in zip((b"rXYZ", b"gXYZ", b"bXYZ"), primaries, strict=True)
        },
        **dict.fromkeys((b"rTRC", b"gTRC", b"bTRC"), curve),
    }
    at = _HEADER_BYTES + 4 + _TAG_BYTES * len(bodies)
    table, data, places = b"", b"", dict[bytes, int]()
    for tag, body in bodies.items():
        if body not in places:
            places[body] = at + len(data)
            data += body + bytes(-len(body) % 4)
        table += struct.pack(">4s2I", tag, places[body], len(body))
    head = struct.pack(">I4sI", at + len(data), bytes(4), 0x04300000) + b"mntrRGB XYZ "
    head += struct.pack(">6H", 2026, 1, 1, 0, 0, 0) + b"acsp" + bytes(28) + _to_fixed_point(D50)
    return head.ljust(_HEADER_BYTES, b"\0") + struct.pack(">I", len(bodies)) + table + data


def _to_fixed_point(numbers: ArrayLike) -> bytes:
    """Numbers as signed fixed point of 16 bits after the point."""
    return np.rint(65536 * np.asarray(numbers, np.float64)).astype(">i4").tobytes()


def _words(text: str) -> bytes:
    body = text.encode("utf-16-be")
    return b"mluc" + struct.pack(">5I", 0, 1, 12, 0x656E5553, len(body)) + struct.pack(">I", 28) + body


def _tags(content: bytes) -> dict[bytes, bytes]:
    (count,) = struct.unpack_from(">I", content, _HEADER_BYTES)
    if count > MAX_TAGS or _HEADER_BYTES + 4 + count * _TAG_BYTES > len(content):
        raise InvalidProfile("is damaged: its list of tags does not fit into it")
    tags: dict[bytes, bytes] = {}
    for at in range(count):
        tag, start, length = struct.unpack_from(">4sII", content, _HEADER_BYTES + 4 + at * _TAG_BYTES)
        if start < _HEADER_BYTES or length < 8 or start + length > len(content):
            raise InvalidProfile("is damaged: a tag lies outside it")
        tags.setdefault(tag, content[start : start + length])
    return tags


def _name(tags: dict[bytes, bytes]) -> str:
    """The description in one line of printable letters."""
    body = tags.get(b"desc", b"")
    text = ""
    if body[:4] == b"desc":
        text = body[12 : 12 + min(MAX_NAME, int.from_bytes(body[8:12], "big"))].split(b"\0")[0].decode("latin-1")
    elif body[:4] == b"mluc" and len(body) >= 28:
        length, start = struct.unpack_from(">II", body, 20)
        text = body[start : start + min(2 * MAX_NAME, length)].decode("utf-16-be", "replace").split("\0")[0]
    return " ".join("".join(letter if letter.isprintable() else " " for letter in text).split()) or "without a name"


def _xyz(tags: dict[bytes, bytes], tag: bytes) -> NDArray[np.float64]:
    body = tags.get(tag, b"")
    if body[:4] != b"XYZ " or len(body) < 20:
        raise InvalidProfile(f"is damaged: it has no {tag.decode()}")
    return np.array(struct.unpack_from(">3i", body, 8)) / 65536


def _curve(tags: dict[bytes, bytes], tag: bytes) -> Curve:
    body = tags.get(tag, b"")
    damaged = InvalidProfile(f"is damaged: it has no {tag.decode()}")
    if len(body) < 12:
        raise damaged
    if body[:4] == b"para":
        kind = int.from_bytes(body[8:10], "big")
        if kind >= len(_PARAMETERS) or len(body) < 12 + 4 * _PARAMETERS[kind]:
            raise damaged
        return _parametric(kind, [value / 65536 for value in struct.unpack_from(f">{_PARAMETERS[kind]}i", body, 12)])
    count = int.from_bytes(body[8:12], "big")
    if body[:4] != b"curv" or count > MAX_CURVE_SAMPLES or len(body) < 12 + 2 * count:
        raise damaged
    values = np.frombuffer(body, ">u2", count, 12).astype(np.float64)
    if count == 0:
        return LINEAR_CURVE
    return gamma(float(values[0]) / 256) if count == 1 else Curve(samples=values / 65535)


def _parametric(kind: int, numbers: list[float]) -> Curve:
    g, a, b, c, d, e, f = (*numbers, *([0.0] * (7 - len(numbers))))
    if kind == 0:
        return gamma(g)
    if kind in (1, 2):  # below -b / a these are constant
        if a == 0.0:
            raise InvalidProfile("has a curve that no samples have")
        return Curve((g, a, b, 0.0, -b / a, c if kind == 2 else 0.0, c if kind == 2 else 0.0))
    return Curve((g, a, b, c, d, e, f))


def check_curve(curve: Curve) -> Curve:
    """The curve; InvalidProfile for one that does not rise from black to white."""
    values = curve.linear(np.linspace(0.0, 1.0, 1025))
    if not np.isfinite(values).all() or (np.diff(values) < -1e-4).any():
        raise InvalidProfile("has a curve that does not rise")
    if abs(values[-1] - 1.0) > 0.01 or abs(values[0]) > 0.05:
        raise InvalidProfile("has a curve that does not lead from black to white")
    return curve


def settle_curves(curves: tuple[Curve, ...]) -> tuple[Curve, ...]:
    """The exact curve in place of one that is it but for rounding."""
    for exact in (SRGB_CURVE, LINEAR_CURVE):
        if all(curve.is_like(exact) for curve in curves):
            return (exact,)
    return curves


def _check_primaries(primaries: NDArray[np.float64], white: NDArray[np.float64]) -> None:
    found = primaries.sum(axis=1)
    if not _WHITE_RANGE[0] <= found[1] <= _WHITE_RANGE[1] or abs(np.linalg.det(primaries)) < 1e-3:
        raise InvalidProfile("has primaries that do not add up to white")
    near = [np.abs(found / found.sum() - each / each.sum()).max() for each in (D50, white) if each.sum() > 0.0]
    if min(near) > _WHITE_DISTANCE:
        raise InvalidProfile("has primaries that do not add up to its white")


def _table(name: str, content: bytes) -> ColourSpace:
    """A space that is applied by Little CMS, tried on greys first."""
    try:
        greys = np.repeat(np.linspace(0.0, 1.0, 65)[:, None], 3, axis=1)
        luminance = apply_table(content, greys)[:, 1]
    except (ValueError, RuntimeError, TypeError, MemoryError):
        raise InvalidProfile(f"{name!r} has a table that cannot be read") from None
    if not np.isfinite(luminance).all() or (np.diff(luminance) < -5e-3).any():
        raise InvalidProfile(f"{name!r} has a table in which greys do not rise")
    if not 0.5 <= luminance[-1] - luminance[0] <= 2.0:
        raise InvalidProfile(f"{name!r} has a table that does not lead from black to white")
    return ColourSpace(name, table=content)
