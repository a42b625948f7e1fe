"""PBR maps as codes of images, and back as a reader gets them.

Base colour is sRGB-coded in PNG and linear in OpenEXR, there in the working space of the maps; all else is linear data.
Normals are (n + 1) / 2 in PNG and n in OpenEXR, y up (OpenGL) or down (DirectX). Heights are stretched to [0, 1] in PNG
and plain in OpenEXR. Compression of PNG bounds the time, some 30 MB/s.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from engine.core.colour import REC_709, WorkingSpace, srgb_decode, srgb_encode
from engine.images.encode import encode_exr, encode_png, rgb_channels
from engine.images.png_rows import encode_png_rows
from engine.storage.atomic import Pieces
from engine.surface.pbr_maps import PbrMaps, space_of

Map = NDArray[np.float32]

#: Codings of textures: PNG of 8 or 16 bits, or OpenEXR half floats.
Coding = Literal["png8", "png16", "exr"]
CODINGS: tuple[Coding, ...] = ("png8", "png16", "exr")

#: Direction of y in maps of normals: up as in OpenGL, down as in DirectX.
Handedness = Literal["opengl", "directx"]


def code(values: Map, name: str, coding: Coding, handedness: Handedness = "opengl") -> NDArray[Any]:
    """The map `name`, (H, W) or (H, W, 3), as uint8 or uint16 codes or float16."""
    if name == "normal" and handedness == "directx":
        values = values * np.array([1.0, -1.0, 1.0], np.float32)
    if coding == "exr":
        return values.astype(np.float16)
    if name == "base_colour":
        values = np.asarray(srgb_encode(values))
    elif name == "normal":
        values = 0.5 * values + 0.5
    elif name == "height":
        low, high = float(values.min()), float(values.max())
        values = (values - low) / ((high - low) or 1.0)
    top = _top(coding)
    return np.rint(np.clip(values, 0.0, 1.0) * top).astype(np.uint8 if coding == "png8" else np.uint16)


def encode(image: NDArray[Any], loss: str = "") -> bytes:
    """A PNG of codes, or an OpenEXR file of half floats, that states the `loss` as its comment."""
    if image.dtype != np.float16:
        return encode_png(image, software="Lightarc", comment=loss)
    return encode_exr(_name_channels(image), attributes={"comments": loss} if loss else None)


def encode_large(image: NDArray[Any], loss: str = "") -> bytes | Pieces:
    """The same file; a PNG in pieces, so that memory need not hold it."""
    return (
        encode(image, loss) if image.dtype == np.float16 else encode_png_rows(image, software="Lightarc", comment=loss)
    )


def _name_channels(image: NDArray[Any]) -> dict[str, NDArray[Any]]:
    channels = {"Y": image} if image.ndim == 2 else rgb_channels(image)
    if image.ndim == 3 and image.shape[2] == 4:
        channels["A"] = image[..., 3]
    return channels


def encode_base_colour(maps: PbrMaps, space: WorkingSpace, loss: str = "") -> bytes:
    """An OpenEXR file of half floats with the base colours in `space`, which its chromaticities state."""
    values, held = (maps.base_colour, REC_709) if maps.wide is None else (maps.wide.base_colour, space_of(maps))
    if held != space:
        values = values @ (space.from_rec709 @ held.to_rec709).T.astype(np.float32)
    attributes = {"comments": loss} if loss else None
    return encode_exr(rgb_channels(values.astype(np.float16)), attributes=attributes, space=space)


def round_values(maps: PbrMaps, coding: Coding) -> PbrMaps:
    """The maps as a reader gets them back from textures."""

    def back(values: Map, name: str) -> Map:
        codes = code(values, name, coding)
        if coding == "exr":
            return codes.astype(np.float32)
        share = codes.astype(np.float32) / np.float32(_top(coding))
        return np.asarray(srgb_decode(share), np.float32) if name == "base_colour" else share

    normal = back(maps.normal, "normal")
    normal = normal if coding == "exr" else 2.0 * normal - 1.0
    return replace(
        maps,
        base_colour=back(maps.base_colour, "base_colour"),
        normal=normal / np.linalg.norm(normal, axis=2, keepdims=True),
        roughness=back(maps.roughness, "roughness"),
        metallic=back(maps.metallic, "metallic"),
        height=None,
        occlusion=None,
        uncertainty=None,
    )


def _top(coding: Coding) -> int:
    return 255 if coding == "png8" else 65535
