"""OpenEXR: colour images for the capture, and all channels with their attributes for our own bundles."""

from __future__ import annotations

import io
from typing import Any

import numpy as np
import OpenEXR
from numpy.typing import NDArray

from engine.core.colour import CHROMATICITIES, srgb_from_xyz
from engine.core.errors import InputError
from engine.images.colour_space import ColourSpace, linear_space
from engine.images.raster import Raster, check_size
from engine.storage.untrusted import AGAIN

SIGNATURE = b"\x76\x2f\x31\x01"

_FLAT = (OpenEXR.scanlineimage, OpenEXR.tiledimage)
_COLOUR = ("R", "G", "B")
_TRISTIMULUS = ("X", "Y", "Z")
_ENVIRONMENTS = {OpenEXR.ENVMAP_LATLONG: "latlong", OpenEXR.ENVMAP_CUBE: "cube"}
_MULTIPART = 0x10
_LARGEST_CHUNK_ROWS = 256

#: Bytes of a chunk before its pixels: row and length, or column and row of a tile with its levels, and length.
_ROWS_LEAD_BYTES, _TILE_LEAD_BYTES = 8, 20
_REMEDY = "Save it as an EXR image with channels R, G, B"


def read_exr(content: bytes, name: str) -> Raster:
    """R, G, B (or r, g, b, or Y, or those of the first layer that has them) of the first part that has R, G, B.

    Where none has, it is the first of all. A data window within the display window is completed by black.
    """
    channels, header, warnings = _read(content, name)
    channels = _with_capitals(channels)
    layer, names = _colour_channels(channels, name)
    if layer:
        warnings += (f"has no channels R, G, B; its layer {layer!r} is used",)
    if any(channels[c].dtype.kind != "f" for c in names):
        raise InputError(name, "has integer colour channels", _REMEDY)
    if "A" in channels:
        warnings += ("has an alpha channel, which is ignored",)
    bits = max(channels[c].dtype.itemsize for c in names) * 8
    planes = [channels[c].astype(np.float32) for c in names]
    samples = planes[0] if len(planes) == 1 else np.stack(planes, axis=-1)
    if names == _TRISTIMULUS:
        warnings += ("has channels X, Y, Z, which are taken as CIE tristimulus values",)
        with np.errstate(over="ignore", invalid="ignore"):
            samples = srgb_from_xyz(samples).astype(np.float32)
    space, invalid = (None, "") if len(planes) == 1 or names == _TRISTIMULUS else _space(header.get("chromaticities"))
    environment = _ENVIRONMENTS.get(header.get("envmap"), "")
    stated: dict[str, Any] = {"environment": environment, "space": space, "invalid_space": invalid}
    return Raster(samples, None, bits, "linear", "EXR", warnings, **stated)


def _space(stated: object) -> tuple[ColourSpace | None, str]:
    """The linear space of the attribute `chromaticities`, None for that of sRGB or where nothing is stated, a hundredth
    off being as good; or else why the statement cannot be applied."""
    if not isinstance(stated, tuple) or len(stated) != len(CHROMATICITIES):
        return None, ""
    if np.allclose(stated, CHROMATICITIES, atol=0.01):
        return None, ""
    try:
        return linear_space(stated), ""
    except ValueError as error:
        return None, f"states {error}"


def read_exr_channels(content: bytes, name: str) -> dict[str, Any]:
    """Decoder for `decode_in_child`: every channel (H, W) in its own dtype as `channel:NAME`, and `attributes`.

    They are those of the first part that has R, G, B, or of the first of all. Attributes are those that JSON can hold:
    text, numbers and tuples of them.
    """
    channels, header, _ = _read(content, name)
    attributes = {key: value for key, value in header.items() if _plain(value)}
    return {**{f"channel:{key}": plane for key, plane in channels.items()}, "attributes": attributes}


def read_exr_alpha(content: bytes, name: str) -> NDArray[np.float32]:
    """The channel A (H, W) of the first part; InputError where there is none."""
    alpha = _with_capitals(_read(content, name)[0]).get("A")
    if alpha is None:
        raise InputError(name, "has no alpha channel", "Save it with its fourth channel")
    return alpha.astype(np.float32)


def _plain(value: object) -> bool:
    return isinstance(value, (str, int, float)) or (isinstance(value, tuple) and all(map(_plain, value)))


def _read(content: bytes, name: str) -> tuple[dict[str, NDArray[Any]], dict[str, Any], tuple[str, ...]]:
    headers = OpenEXR.File(io.BytesIO(content), header_only=True).parts
    for part in headers:
        _check_part(part, name, len(content))
    if len(headers) == 1 and not content[5] & _MULTIPART:
        _check_chunks(content, headers[0].header, name)
    chosen = next((at for at, part in enumerate(headers) if _has_colour(part)), 0)
    with OpenEXR.File(io.BytesIO(content), separate_channels=True) as file:
        channels = {key: np.array(channel.pixels) for key, channel in file.parts[chosen].channels.items()}
        header = dict(file.parts[chosen].header)
    if len({plane.shape for plane in channels.values()}) != 1:
        raise InputError(name, "has channels of different resolution", _REMEDY)
    warnings: tuple[str, ...] = ()
    if len(headers) > 1:
        which = "the first" if chosen == 0 else f"part {chosen + 1}, the first with channels R, G, B,"
        warnings += (f"has {len(headers)} parts, of which {which} is used",)
    stored, shown = (
        np.reshape([tuple(corner) for corner in header[f"{name}Window"]], 4) for name in ("data", "display")
    )
    if not np.array_equal(stored, shown):
        if (stored[:2] >= shown[:2]).all() and (stored[2:] <= shown[2:]).all():
            width, height = (int(side) for side in shown[2:] - shown[:2] + 1)
            check_size(name, width, height, 4 * len(channels), len(content))
            channels = {key: _complete(plane, stored, shown) for key, plane in channels.items()}
            warnings += ("stores a part of the area that it displays; the rest is black",)
        else:
            warnings += ("stores another area than it displays; all that is stored is used",)
    return channels, header, warnings


def _has_colour(part: OpenEXR.Part) -> bool:
    """True where a part has channels R, G, B, or r, g, b."""
    names = {str(channel.name).upper() for channel in part.header["channels"]}
    return names >= set(_COLOUR)


def _complete(plane: NDArray[Any], stored: NDArray[np.int64], shown: NDArray[np.int64]) -> NDArray[Any]:
    """A plane of the data window `stored` (left, top, right, bottom) within the display window `shown`, in black."""
    whole = np.zeros((shown[3] - shown[1] + 1, shown[2] - shown[0] + 1), plane.dtype)
    left, top = stored[:2] - shown[:2]
    whole[top : top + plane.shape[0], left : left + plane.shape[1]] = plane
    return whole


def _check_part(part: OpenEXR.Part, name: str, file_bytes: int) -> None:
    header = part.header
    if header.get("type", OpenEXR.scanlineimage) not in _FLAT:
        raise InputError(name, "is a deep EXR image", _REMEDY)
    (left, top), (right, bottom) = (tuple(int(v) for v in corner) for corner in header["dataWindow"])
    count = len(header["channels"])
    if count == 0:
        raise InputError(name, "is an EXR image without channels", _REMEDY)
    check_size(name, right - left + 1, bottom - top + 1, 4 * count, file_bytes)


def _check_chunks(content: bytes, header: dict[str, Any], name: str) -> None:
    """The chunks of scan lines or tiles must cover the image that the header describes, and no more.

    OpenEXR believes the header and leaves out, or fills with zeros, what does not agree with it. A chunk starts with
    its row, or with the column and row of its tile and its level (OpenEXR file layout, "Chunk layout").
    """
    is_tiled = header.get("type") == OpenEXR.tiledimage
    lead_bytes = _TILE_LEAD_BYTES if is_tiled else _ROWS_LEAD_BYTES
    start = end_of_header(content)
    first = int.from_bytes(content[start : start + 8], "little")
    if not start < first < len(content) - lead_bytes:
        raise InputError(name, "is an incomplete EXR image: its table of chunks is empty", AGAIN)
    offsets = np.frombuffer(content, "<u8", (first - start) // 8, start)
    if offsets.max() >= len(content) - lead_bytes or offsets.min() < first:
        raise InputError(name, "is an incomplete EXR image: some of its chunks are missing", AGAIN)
    places = offsets.astype(np.int64)[:, None] + np.arange(lead_bytes)
    leads = np.frombuffer(content, np.uint8)[places].view("<i4")
    if (offsets + lead_bytes + leads[:, -1].astype(np.uint64)).max() > len(content):
        raise InputError(name, "is an incomplete EXR image: some of its chunks are missing", AGAIN)
    (left, top), (right, bottom) = (tuple(int(v) for v in corner) for corner in header["dataWindow"])
    if is_tiled:
        tiles = leads[(leads[:, 2] == 0) & (leads[:, 3] == 0)]
        size = header["tiles"]
        covered = len(tiles) > 0 and tiles[:, 0].max() == (right - left) // size.xSize
        covered = covered and tiles[:, 1].max() == (bottom - top) // size.ySize
    else:
        rows = np.sort(leads[:, 0])
        chunk_rows = rows[1] - rows[0] if len(rows) > 1 else _LARGEST_CHUNK_ROWS
        covered = rows[0] == top and bottom - chunk_rows < rows[-1] <= bottom
    if not covered:
        raise InputError(name, "is a damaged EXR image: its chunks are not those of the size it states", AGAIN)


def _with_capitals(channels: dict[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
    """The same channels, of which r, g, b, a, x, y, z are named R, G, B … in every layer that has no such channel."""
    named = {}
    for key, plane in channels.items():
        layer, dot, last = key.rpartition(".")
        capital = f"{layer}{dot}{last.upper()}"
        named[capital if len(last) == 1 and capital not in channels else key] = plane
    return named


def end_of_header(content: bytes) -> int:
    """Position after the header: attributes are name, type (each ended by 0), length and value; an empty name ends."""
    at = 8
    while content[at]:
        at = content.index(b"\0", content.index(b"\0", at) + 1) + 1
        at += 4 + int.from_bytes(content[at : at + 4], "little")
    return at + 1


def _colour_channels(channels: dict[str, NDArray[Any]], name: str) -> tuple[str, tuple[str, ...]]:
    """The layer ('' for none) and names of the colour channels."""
    if all(c in channels for c in _COLOUR):
        return "", _COLOUR
    if "RY" in channels or "BY" in channels:
        raise InputError(name, "stores luminance and chroma (Y, RY, BY)", _REMEDY)
    if all(c in channels for c in _TRISTIMULUS):
        return "", _TRISTIMULUS
    if "Y" in channels:
        return "", ("Y",)
    for layer in sorted(key.removesuffix(".R") for key in channels if key.endswith(".R")):
        names = tuple(f"{layer}.{c}" for c in _COLOUR)
        if all(c in channels for c in names):
            return layer, names
    raise InputError(name, f"has no channels R, G, B but {', '.join(sorted(channels))[:100]}", _REMEDY)
