"""PBR maps as pictures: one folder of textures, named and packed as an importer expects them.

Base colour is sRGB-coded in PNG and linear in OpenEXR; all else is linear data. Normals are (n + 1) / 2 in PNG and n in
OpenEXR, y up (OpenGL) or down (DirectX). Heights are stretched to [0, 1] in PNG, over the range that the record states
in widths of a texel, and plain in OpenEXR. A texture of which nothing is known (no height without slopes, no occlusion
without relief) is left out and named; within a packed texture unknown occlusion is 1. Compression of PNG bounds the
time, some 30 MB/s.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.core.colour import srgb_decode, srgb_encode
from engine.core.errors import UsageError
from engine.core.steps import Step, Steps
from engine.exchange.loss import maps_shown
from engine.exchange.subject import Coding, Contents, Handedness, Settings, Subject
from engine.surface.pbr_maps import DIELECTRIC_F0, PbrMaps

Map = NDArray[np.float32]


@dataclass(frozen=True)
class Texture:
    """One file: the ending of its name, and the map of its colour or of each of its channels."""

    suffix: str
    sources: tuple[str, ...]


@dataclass(frozen=True)
class Preset:
    """Textures of one program; `prefix` begins their names, `normal` is how it reads normals."""

    textures: tuple[Texture, ...]
    normal: Handedness = "opengl"
    prefix: str = ""


_ORM = ("occlusion", "roughness", "metallic")

PRESETS: dict[str, Preset] = {
    # The words by which Node Wrangler sorts files into sockets.
    "blender": Preset(
        (
            Texture("_base_color", ("base_colour",)),
            Texture("_normal", ("normal",)),
            Texture("_roughness", ("roughness",)),
            Texture("_metallic", ("metallic",)),
            Texture("_height", ("height",)),
            Texture("_ao", ("occlusion",)),
            Texture("_cavity", ("cavity",)),
        )
    ),
    # Epic's recommended prefix and suffixes.
    "unreal": Preset(
        (
            Texture("_BC", ("base_colour",)),
            Texture("_N", ("normal",)),
            Texture("_ORM", _ORM),
            Texture("_H", ("height",)),
            Texture("_Cavity", ("cavity",)),
        ),
        normal="directx",
        prefix="T_",
    ),
    # The mask map of the High Definition Render Pipeline: metallic, occlusion, detail mask, smoothness.
    "unity": Preset(
        (
            Texture("_BaseMap", ("base_colour",)),
            Texture("_Normal", ("normal",)),
            Texture("_MaskMap", ("metallic", "occlusion", "one", "smoothness")),
            Texture("_Height", ("height",)),
        )
    ),
    # ORMMaterial3D.
    "godot": Preset(
        (
            Texture("_albedo", ("base_colour",)),
            Texture("_normal", ("normal",)),
            Texture("_orm", _ORM),
            Texture("_height", ("height",)),
        )
    ),
    # Substance 3D Painter's template of metallic-roughness, whose projects are DirectX by default.
    "substance": Preset(
        (
            Texture("_BaseColor", ("base_colour",)),
            Texture("_Normal", ("normal",)),
            Texture("_Roughness", ("roughness",)),
            Texture("_Metallic", ("metallic",)),
            Texture("_Height", ("height",)),
            Texture("_AmbientOcclusion", ("occlusion",)),
            Texture("_Cavity", ("cavity",)),
        ),
        normal="directx",
    ),
    "gltf": Preset(
        (
            Texture("_baseColor", ("base_colour",)),
            Texture("_normal", ("normal",)),
            Texture("_occlusionRoughnessMetallic", _ORM),
        )
    ),
}

#: Words for what is left out.
_WORDS = {
    "height": "no height: the slopes of the surface were not observed",
    "occlusion": "no ambient occlusion: the relief of the surface was not observed",
    "cavity": "no cavity: the material has no power law",
}


def contents(subject: Subject, settings: Settings) -> Steps[Contents]:
    """The textures of a preset; UsageError for one that does not exist."""
    if settings.preset not in PRESETS:
        raise UsageError(f"unknown preset {settings.preset!r}; known are {', '.join(PRESETS)}")
    preset = PRESETS[settings.preset]
    handedness = settings.normal or preset.normal
    files: dict[str, bytes] = {}
    left_out = []
    read = 0.0
    for number, texture in enumerate(preset.textures):
        yield Step(number / len(preset.textures), f"writing {texture.suffix.strip('_')}")
        if len(texture.sources) == 1 and source(subject, texture.sources[0]) is None:
            left_out.append(_WORDS[texture.sources[0]])
            continue
        name = f"{preset.prefix}{subject.name}{texture.suffix}.{'exr' if settings.coding == 'exr' else 'png'}"
        picture = packed(subject, texture.sources, settings.coding, handedness)
        files[name] = encoded(picture)
        read += picture.itemsize * picture.shape[2]
    height = subject.maps.height
    warnings = (*common_warnings(subject.maps), *left_out)
    if not np.allclose(subject.maps.f0, DIELECTRIC_F0, atol=1e-3):
        warnings = (*warnings, "textures hold no f0; importers take 0.04")
    record: dict[str, Any] = {"preset": settings.preset, "coding": settings.coding, "normal": handedness}
    if height is not None:
        record["height_range_texels"] = [float(height.min()), float(height.max())]
    shown = maps_shown(replace(rounded(subject.maps, settings.coding), f0=np.full_like(subject.maps.f0, DIELECTRIC_F0)))
    return Contents(files, shown, read, warnings, record)


def common_warnings(maps: PbrMaps) -> tuple[str, ...]:
    """Sentences about maps that every target of them has to say."""
    if maps.observed.kind == "none":
        return ("normals are flat: lamps on one arc do not show the side that a slope faces",)
    if maps.observed.kind == "along the arc":
        return ("normals tilt along the arc of the lamps alone",)
    return ()


def source(subject: Subject, name: str) -> Map | None:
    """A map by name, (H, W) or (H, W, 3); None where it is not known."""
    if name == "cavity":
        return subject.cavity
    if name == "one":
        return np.ones(subject.maps.size, np.float32)
    if name == "smoothness":
        return 1.0 - subject.maps.roughness
    found: Map | None = getattr(subject.maps, name)
    return found


def packed(
    subject: Subject, sources: tuple[str, ...], coding: Coding, handedness: Handedness = "opengl"
) -> NDArray[Any]:
    """The codes (H, W, channels) of a texture: uint8, uint16, or float16 for OpenEXR; what is not known is 1."""
    planes = []
    for name in sources:
        values = source(subject, name)
        values = np.ones(subject.maps.size, np.float32) if values is None else values
        planes.append(_coded(np.atleast_3d(values), name, coding, handedness))
    return np.concatenate(planes, axis=2)


def _coded(values: Map, name: str, coding: Coding, handedness: Handedness) -> NDArray[Any]:
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


def encoded(picture: NDArray[Any]) -> bytes:
    """A PNG of codes, or an OpenEXR file of half floats."""
    from engine.images.encode import encode_exr, encode_png, rgb_channels

    if picture.dtype == np.float16:
        if picture.shape[2] == 3:
            return encode_exr(rgb_channels(picture))
        names = ("Y",) if picture.shape[2] == 1 else tuple("RGBA")
        return encode_exr({name: picture[..., index] for index, name in enumerate(names)})
    return encode_png(picture[..., 0] if picture.shape[2] == 1 else picture)


def rounded(maps: PbrMaps, coding: Coding) -> PbrMaps:
    """The maps as a reader gets them back from textures."""

    def back(values: Map, name: str) -> Map:
        codes = _coded(np.atleast_3d(values), name, coding, "opengl").reshape(values.shape)
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
