"""PBR maps as images: one folder of textures, named and packed as an importer expects them.

A texture of which nothing is known (no height without slopes, no occlusion without relief) is left out and named, as is
a map for which a program has no place; in a packed texture unknown occlusion is 1. The record states the range of
heights in widths of a texel. An f0 other than 0.04, which importers take, is a specular level where the program has
one; else the error is measured with 0.04. See `engine.exchange.coding` for the codes.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.core.errors import UsageError
from engine.core.steps import Step, Steps
from engine.exchange.coding import Coding, Handedness, Map, code, encode_base_colour, encode_large, round_values
from engine.exchange.layers import none_warnings
from engine.exchange.loss import Shown, maps_shown
from engine.exchange.subject import Contents, Files, Settings, Subject
from engine.storage.atomic import Pieces
from engine.surface.pbr_maps import DIELECTRIC_F0, count_regions, space_of, wide_text


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


#: Reflectance of a dielectric that the specular level 1 stands for, in Blender, Unreal and Substance.
FULL_SPECULAR = 0.08

#: Mean product of metallic and roughness from which programs that add light between facets differ by a tenth and more.
ROUGH_METAL = 0.35

_ORM = ("occlusion", "roughness", "metallic")

PRESETS: dict[str, Preset] = {
    # The words by which Node Wrangler sorts files into sockets.
    "blender": Preset(
        (
            Texture("_base_color", ("base_colour",)),
            Texture("_normal", ("normal",)),
            Texture("_roughness", ("roughness",)),
            Texture("_metallic", ("metallic",)),
            Texture("_specular", ("specular",)),
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
            Texture("_S", ("specular",)),
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
            Texture("_SpecularLevel", ("specular",)),
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

#: Words for what is not known of a material that was photographed, of one that came as PBR maps, and of one from a dome
#: whose photographs are not at hand.
_WORDS = {
    "height": "no height: the slopes of the surface were not observed",
    "occlusion": "no ambient occlusion: the relief of the surface was not observed",
    "cavity": "no cavity: the material has no power law",
}
_WORDS_OF_MAPS = {
    "height": "no height: the material came without one",
    "occlusion": "no ambient occlusion: the material came without it",
    "cavity": "no cavity: the material came without one",
}
_WORDS_OF_A_DOME = {
    "height": "no height: it is measured on photographs of these texels, and none were given",
    "occlusion": "no ambient occlusion: it is measured on photographs of these texels, and none were given",
    "cavity": _WORDS["cavity"],
}

#: Maps that a target may have no place for, and what users call them.
_NAMES = {"height": "height", "occlusion": "ambient occlusion", "cavity": "cavity", "uncertainty": "uncertainty"}


def show(subject: Subject, settings: Settings) -> Shown:
    """The maps as they come back, with the f0 of importers where the preset has no place for another.

    A specular level says no more than `FULL_SPECULAR`.
    """
    if not _has_specular(_preset(settings)):
        return subject.decode_as(settings.coding, DIELECTRIC_F0, layers=None)
    if not _is_beyond_full(subject):
        return subject.decode_as(settings.coding, layers=None)

    def limit() -> Shown:
        f0 = np.minimum(subject.maps.f0, np.float32(FULL_SPECULAR))
        back = replace(round_values(subject.maps, settings.coding), f0=f0, layers=None)
        return maps_shown(back, np.pi * subject.white)

    found = subject.remember((settings.coding, "f0 of a full specular level"), limit)
    assert found is not None
    return found


def _is_beyond_full(subject: Subject) -> bool:
    return bool(subject.maps.f0.max() > FULL_SPECULAR + 1e-3)


def contents(subject: Subject, settings: Settings, loss: str) -> Steps[Contents]:
    """The textures of a preset; UsageError for one that does not exist."""
    preset = _preset(settings)
    handedness = settings.normal or preset.normal
    files: dict[str, Callable[[], bytes | Pieces]] = {}
    read = 0
    yield Step(0.0, "choosing textures")
    for texture in preset.textures:
        if len(texture.sources) == 1 and source(subject, texture.sources[0]) is None:
            continue
        name = f"{preset.prefix}{subject.name}{texture.suffix}.{'exr' if settings.coding == 'exr' else 'png'}"
        files[name] = partial(_file, subject, texture, settings.coding, handedness, loss)
        read += _channels(texture) * (1 if settings.coding == "png8" else 2)
    places = [name for texture in preset.textures for name in texture.sources]
    holds_wide = settings.coding == "exr"
    warnings = (*common_warnings(subject, places, holds_wide=holds_wide), *none_warnings(subject.maps.layers))
    warnings = (*warnings, *_unknown(subject, places))
    if subject.maps.wide is not None and holds_wide:
        label = space_of(subject.maps).label
        text = f"base colours are in {label}, as their chromaticities say: choose {label} for this image in the program"
        warnings = (*warnings, text)
    if source(subject, "specular") is not None and not _has_specular(preset):
        warnings = (*warnings, "these textures hold no f0, and importers take 0.04")
    elif _has_specular(preset) and _is_beyond_full(subject):
        warnings = (*warnings, f"f0 is up to {float(subject.maps.f0.max()):.3f}, of which a specular level says 0.08")
    height = subject.maps.height
    record: dict[str, Any] = {"preset": settings.preset, "coding": settings.coding, "normal": handedness}
    record["base_colour_space"] = space_of(subject.maps).label if holds_wide else "sRGB"
    if height is not None:
        record["height_range_texels"] = [float(height.min()), float(height.max())]
        if settings.width_mm is not None:
            texel_mm = settings.width_mm / subject.maps.size[1]
            record["height_range_mm"] = [texel_mm * each for each in record["height_range_texels"]]
    return Contents(Files(files), float(read), warnings, record)


def _file(subject: Subject, texture: Texture, coding: Coding, handedness: Handedness, loss: str) -> bytes | Pieces:
    if coding == "exr" and texture.sources == ("base_colour",):
        return encode_base_colour(subject.maps, space_of(subject.maps), loss)
    return encode_large(pack(subject, texture.sources, coding, handedness), loss)


def _channels(texture: Texture) -> int:
    if len(texture.sources) > 1:
        return len(texture.sources)
    return 3 if texture.sources[0] in ("base_colour", "normal") else 1


def _preset(settings: Settings) -> Preset:
    if settings.preset not in PRESETS:
        raise UsageError(f"unknown preset {settings.preset!r}; choose from {', '.join(PRESETS)}")
    return PRESETS[settings.preset]


def _has_specular(preset: Preset) -> bool:
    return any("specular" in texture.sources for texture in preset.textures)


def ior_of(f0: float) -> float:
    """The index of refraction of a dielectric that reflects `f0` at normal incidence in air."""
    root = min(f0, 0.999) ** 0.5
    return (1.0 + root) / (1.0 - root)


def common_warnings(subject: Subject, places: Collection[str], *, holds_wide: bool = False) -> tuple[str, ...]:
    """Sentences about maps that every target of them has to say; `places` names those that it holds.

    `holds_wide` says that the target holds base colours in the working space.
    """
    maps, said = subject.maps, tuple[str, ...]()
    if maps.observed.kind == "none":
        said = ("normals are flat: lamps on one arc do not show the side that a slope faces",)
        if subject.material.directional is not None:
            said = ("normals are flat: they are measured on photographs of these texels, and none were given",)
    if maps.observed.kind == "along the arc":
        said = ("normals tilt along the arc of the lamps alone",)
    if maps.region is not None and "height" in places:
        count = count_regions(maps)
        said = (*said, f"the height has {count} regions, and the steps between them are unknown")
    if float(np.mean(maps.metallic * maps.roughness, dtype=np.float64)) > ROUGH_METAL:
        again = maps.multiple_scattering or maps.openpbr is not None
        less = "up to a third darker where light between facets is not simulated, as in plain glTF"
        more = "up to half brighter where light between facets is added, as three.js does"
        said = (*said, f"rough metal looks {less if again else more}")
    if maps.tiles > 1:
        divided = f"texture coordinates are to be divided by {maps.tiles}"
        said = (*said, f"{maps.tiles} × {maps.tiles} UDIM tiles are one texture: {divided}")
    if not holds_wide:
        said = (*said, *wide_warnings(subject))
    left_out = [words for name, words in _NAMES.items() if name not in places and source(subject, name) is not None]
    return (*said, f"not written: {', '.join(left_out)}") if left_out else said


def wide_warnings(subject: Subject) -> tuple[str, ...]:
    """A sentence on base colours that a target of Rec.709 clips; none where the maps are in that space."""
    return () if subject.maps.wide is None else (wide_text(subject.maps.wide),)


def mean_f0_warnings(subject: Subject, holder: str) -> tuple[str, ...]:
    """A sentence on the one f0 that `holder` states; none where that is all there is."""
    mean = subject.mean_f0
    if np.allclose(subject.maps.f0, mean, atol=1e-3):
        return ()
    return (f"f0 varies, and {holder} states its mean, {mean:.3f}",)


def _unknown(subject: Subject, places: Collection[str]) -> list[str]:
    """Sentences on the `places` of a preset for which the material has nothing."""
    words = _WORDS if subject.material.pbr is None else _WORDS_OF_MAPS
    if subject.material.directional is not None and subject.maps.observed.kind == "none":
        words = _WORDS_OF_A_DOME
    return [sentence for name, sentence in words.items() if name in places and source(subject, name) is None]


def source(subject: Subject, name: str) -> Map | None:
    """A map by name, (H, W) or (H, W, 3); None where it is not known."""
    if name == "cavity":
        return subject.cavity
    if name == "one":
        return np.ones(subject.maps.size, np.float32)
    if name == "specular":
        is_usual = np.allclose(subject.maps.f0, DIELECTRIC_F0, atol=1e-3)
        return None if is_usual else np.minimum(subject.maps.f0 / np.float32(FULL_SPECULAR), 1.0)
    if name == "smoothness":
        return 1.0 - subject.maps.roughness
    found: Map | None = getattr(subject.maps, name)
    return found


def pack(subject: Subject, sources: tuple[str, ...], coding: Coding, handedness: Handedness = "opengl") -> NDArray[Any]:
    """The codes of a texture, (H, W) or (H, W, channels); what is not known is 1."""
    planes = []
    for name in sources:
        values = source(subject, name)
        values = np.ones(subject.maps.size, np.float32) if values is None else values
        planes.append(code(values, name, coding, handedness))
    return planes[0] if len(planes) == 1 else np.stack(planes, axis=2)
