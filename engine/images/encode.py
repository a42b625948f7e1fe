"""Images to files: PNG for users, 16-bit TIFF for other programs, OpenEXR for radiance and for tables."""

from __future__ import annotations

import io
import json
import os
import struct
import zlib
from collections.abc import Mapping
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from engine.core.colour import REC_709, WorkingSpace
from engine.images.icc import write_profile
from engine.images.png import LINEAR_GAMMA, SIGNATURE
from engine.images.raster import HALF_MAX, Transfer
from engine.storage.atomic import atomic_file


def encode_png(
    pixels: NDArray[np.uint8] | NDArray[np.uint16],
    *,
    transfer: Transfer = "srgb",
    software: str = "",
    comment: str = "",
) -> bytes:
    """PNG of uint8 or uint16 codes, (H, W), (H, W, 3) or (H, W, 4); it says how they are coded (`sRGB` or `gAMA`).

    `software` is kept as its tag of that name, by which `engine.storage.outputs.has_tag` knows it again; `comment` as
    one for users, letters beyond Latin-1 as question marks.
    """
    if pixels.dtype not in (np.uint8, np.uint16) or pixels.ndim not in (2, 3):
        raise ValueError(f"PNG needs uint8 or uint16 codes, got {pixels.dtype} {pixels.shape}")
    swapped = pixels[..., [2, 1, 0, 3][: pixels.shape[2]]] if pixels.ndim == 3 else pixels
    done, data = cv2.imencode(".png", np.ascontiguousarray(swapped))
    if not done:
        raise ValueError(f"PNG cannot hold {pixels.dtype} {pixels.shape}")
    content = data.reshape(-1).data  # `data` may lie on the disk (`engine.storage.spilling`)
    after_header = len(SIGNATURE) + 25
    return b"".join([content[:after_header], write_png_tags(transfer, software, comment), content[after_header:]])


def write_png_tags(transfer: Transfer, software: str, comment: str) -> bytes:
    """The chunks of a PNG between its header and its samples, as `encode_png` describes them."""
    coding = write_png_chunk(b"sRGB", b"\1") if transfer == "srgb" else write_png_chunk(b"gAMA", LINEAR_GAMMA)
    words = {"Software": software, "Comment": comment}
    texts = (f"{name}\0{text}".encode("latin-1", "replace") for name, text in words.items() if text)
    return b"".join([coding, *(write_png_chunk(b"tEXt", text) for text in texts)])


def write_png_chunk(kind: bytes, body: bytes) -> bytes:
    """A chunk with its length and checksum."""
    return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))


def write_exr(
    path: str | os.PathLike[str],
    channels: Mapping[str, NDArray[Any]],
    *,
    half: bool = True,
    attributes: Mapping[str, Any] | None = None,
    space: WorkingSpace = REC_709,
) -> None:
    """Write linear channels (H, W) as scan-line OpenEXR: half for images, float for tables.

    Names are R, G, B or layer.R; `attributes` are text or numbers; `space` is that of colours. Half cannot hold more
    than 65504 and would turn it into infinity: larger finite values are stored as 65504.
    """
    with atomic_file(path) as file:
        file.write(encode_exr(channels, half=half, attributes=attributes, space=space))


def encode_exr(
    channels: Mapping[str, NDArray[Any]],
    *,
    half: bool = True,
    attributes: Mapping[str, Any] | None = None,
    space: WorkingSpace = REC_709,
) -> bytes:
    """The content of the file that `write_exr` writes."""
    import OpenEXR

    shapes = {channel.shape for channel in channels.values()}
    if len(shapes) != 1 or len(next(iter(shapes))) != 2:
        raise ValueError(f"channels of an EXR image must be (H, W) and alike, got {sorted(shapes)}")
    header = {
        "compression": OpenEXR.ZIP_COMPRESSION,
        "type": OpenEXR.scanlineimage,
        "chromaticities": space.chromaticities,
        **(attributes or {}),
    }
    stored = {name: as_half(channel) if half else np.float32(channel) for name, channel in channels.items()}
    stream = io.BytesIO()
    with OpenEXR.File(header, {name: np.ascontiguousarray(channel) for name, channel in stored.items()}) as file:
        file.write(stream)
    return stream.getvalue()


def as_half(channel: NDArray[Any]) -> NDArray[np.float16]:
    """`channel` as half floats, finite values beyond `HALF_MAX` as that."""
    inside = np.where(np.isfinite(channel), np.clip(channel, -HALF_MAX, HALF_MAX), channel)
    return inside.astype(np.float16)


def rgb_channels(image: NDArray[Any], layer: str = "") -> dict[str, NDArray[Any]]:
    """Channels R, G, B (or layer.R …) of an image (H, W, 3)."""
    prefix = f"{layer}." if layer else ""
    return {prefix + name: image[..., index] for index, name in enumerate("RGB")}


def write_tiff16(path: str | os.PathLike[str], codes: NDArray[np.uint16], *, transfer: Transfer) -> None:
    """Write uint16 codes (H, W) or (H, W, 3) as TIFF; its description says how they are coded, and of colours an ICC
    profile."""
    import tifffile

    if codes.dtype != np.uint16 or codes.ndim not in (2, 3):
        raise ValueError(f"16-bit TIFF needs uint16 codes, got {codes.dtype} {codes.shape}")
    description = json.dumps({"transfer": transfer})
    with atomic_file(path, codes.nbytes) as file:
        tifffile.imwrite(
            file,
            codes,
            photometric="rgb" if codes.ndim == 3 else "minisblack",
            compression="zlib",
            predictor=True,
            description=description,
            metadata=None,
            software="Lightarc",
            iccprofile=write_profile(transfer) if codes.ndim == 3 else None,
        )
