"""Images that others call PBR textures, as PBR maps.

A reader of a format says of each map where it comes from (`Input`): a number, an image or one channel of it, and a
factor. Here the images are decoded, each once and in the decoder child, brought to one size, and checked.

What is taken for granted, because no image says it: base colour is sRGB-coded where its samples are integers and
linear where they are floating point; everything else holds numbers, not colours. Normals are (n + 1) / 2, or n itself
where values go below zero or have the length 1, with y up (OpenGL) or down (DirectX). Where nothing says which, the
maps do: slopes are the gradient of a height, so ∂²h/∂x∂y is the same by both of them, and with y the wrong way round it
is the negative. Maps larger than `MAX_SIDE` are made smaller, which is said. Decoding bounds the time.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import partial
from pathlib import Path
from typing import Any, Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from engine.brdf.brdf import brdf_from_text
from engine.brdf.models.microfacet import MetallicRoughness
from engine.brdf.models.openpbr import OpenPbr
from engine.core.colour import ACESCG, REC_2020, luminance
from engine.core.errors import InputError
from engine.core.figure_text import percent
from engine.core.health import Finding, Health, Verdict
from engine.core.steps import Step, Steps
from engine.exchange.readers.colour_spaces import SPACES
from engine.exchange.readers.layers import make_fuzz
from engine.images.decode import TransferChoice, image_from_reply
from engine.scene.credits import Credits
from engine.storage.untrusted import decode_content, read_bytes
from engine.surface.pbr_maps import DIELECTRIC_F0, WORTH_SAYING, PbrMaps, WideColours, clip_wide, wide_text

Map = NDArray[np.float32]
Floats = NDArray[np.float64]

#: Range of a texture, of 1, within which it is one value: a code of 8 bits.
EVEN = 1.0 / 255.0

#: Range of a component of normals within which they are one.
UNEVEN = 0.02

#: Images of layers by the field of `Described`, with words for them.
_OF_LAYERS = {
    "coat": "clear coat",
    "coat_roughness": "roughness of the clear coat",
    "sheen": "colour of the sheen",
    "sheen_roughness": "roughness of the sheen",
}

#: A channel of an image, or None for its colour.
Channel = Literal[0, 1, 2, "alpha"] | None

#: Direction of y in a map of normals, where it is known.
Upwards = Literal["opengl", "directx", ""]

#: Most texels of a side; PBR maps of 4096 × 4096 texels take 0.6 GB.
MAX_SIDE = 4096

#: Correlation of the two mixed derivatives from which they tell the direction of y, and its least number of standard
#: deviations of that between independent values.
TELLING, DEVIATIONS = 0.1, 4.0

#: First bytes of a JPEG, which has no alpha channel: it is 1 everywhere.
JPEG = b"\xff\xd8"

#: Slopes beyond this are those of a wall.
STEEPEST = 10.0


@dataclass(frozen=True)
class Image:
    """An image: a file, or the `content` that `path` holds, `name` for users; what its integer samples mean.

    `channel` is 0, 1 or 2 for one channel as a number, 'alpha' for that of a PNG, None for the colour. `part` is the
    first byte and the length of an image within the file `path`. In a decoder `path` is as the document names it.
    `space` is the name of the colour space that a document states (`engine.exchange.readers.colour_spaces`), '' for
    what the file says. `tiles` are the files of a UDIM set by their numbers, in the place of `path`.
    """

    path: Path
    name: str
    transfer: TransferChoice = "linear"
    channel: Channel = None
    content: bytes | None = field(default=None, repr=False)
    part: tuple[int, int] | None = None
    space: str = ""
    tiles: tuple[tuple[int, Path], ...] = ()

    @property
    def side(self) -> int:
        """Tiles a side of the square atlas that holds the set, 1 for a single image."""
        return max((max((number - 1001) % 10, (number - 1001) // 10) + 1 for number, _ in self.tiles), default=1)

    @property
    def key(self) -> tuple[Path, str, TransferChoice, bool, str]:
        """Images of equal keys are decoded once."""
        return self.path, self.name, self.transfer, self.channel == "alpha", self.space


@dataclass(frozen=True)
class Input:
    """A map: an image times `factor`, or the factor alone; `inverted` takes 1 − image (smoothness, glossiness)."""

    factor: tuple[float, ...] = (1.0,)
    image: Image | None = None
    inverted: bool = False


@dataclass(frozen=True)
class Described:
    """A material of others as its files describe it.

    Attributes
    ----------
    f0 : its factor is the reflectance of dielectrics at normal incidence, and its image, a colour by its luminance,
        the share of it.
    specular, glossiness : the colour of highlights and 1 − roughness in place of f0, metallic and roughness, or None;
        the base colour is then that of the diffuse part.
    normal : an image alone, or None; `normal_scale` multiplies its slopes, `upwards` is the direction of its y.
    notes : sentences about what was assumed or passed over.
    elsewhere : sentences about what is lost on other models than that of its file.
    credits : as the files state them.
    layers : text of the model whose layers lie over the base (`PbrMaps.layers`); '' for none.
    coat, coat_roughness : images by which the weight and the roughness of its coat vary, or None: their means count.
    sheen, sheen_roughness : the same of the colour and the roughness of its sheen, or of the fuzz in place of it.
    """

    name: str
    base_colour: Input
    roughness: Input = Input((0.5,))
    metallic: Input = Input((0.0,))
    f0: Input = Input((DIELECTRIC_F0,))
    specular: Input | None = None
    glossiness: Input | None = None
    normal: Input | None = None
    height: Input | None = None
    occlusion: Input | None = None
    normal_scale: float = 1.0
    upwards: Upwards = ""
    notes: tuple[str, ...] = ()
    elsewhere: tuple[str, ...] = ()
    layers: str = ""
    coat: Input | None = None
    coat_roughness: Input | None = None
    sheen: Input | None = None
    sheen_roughness: Input | None = None
    credits: Credits = field(default_factory=Credits)


def maps_of(described: Described, most: int = MAX_SIDE) -> Steps[tuple[PbrMaps, Health]]:
    """The maps, and findings about what was assumed; InputError for an image that cannot be read.

    Maps have at most so many texels a side.
    """
    inputs = {each.name: getattr(described, each.name) for each in fields(described)}
    images = {name: each.image for name, each in inputs.items() if isinstance(each, Input) and each.image}
    decoded: dict[object, Map] = {}
    tiles = max((image.side for image in images.values()), default=1)
    for number, image in enumerate(images.values()):
        yield Step(number / (len(images) + 1), f"reading {image.name}")
        if image.key not in decoded:
            decoded[image.key] = _decode(image) if tiles == 1 else _decode_atlas(image, tiles, most)
    yield Step(len(images) / (len(images) + 1), "making maps")
    found = {name: _read_channel(decoded[image.key], image) for name, image in images.items()}
    of_layers: dict[str, Map] = {name: found.pop(name) for name in _OF_LAYERS if name in found}
    size, notes = _size(found, images, most)
    notes = [*described.notes, *notes]
    if tiles > 1:
        notes.append(
            f"UDIM tiles are read as one texture of {tiles} × {tiles} tiles, {most // tiles} texels each at most"
        )
    found = {name: _resize(values, size) for name, values in found.items()}
    base = _colour(described.base_colour, found.get("base_colour"), size)
    described, base, found = _as_metal(described, base, found, size)
    share = found.get("f0")
    if share is not None and share.ndim == 3:
        share = luminance(share).astype(np.float32)
    normal = _normals(described, found.get("normal"), size, notes)
    base_colour, wide = _keep_wide(base, notes)
    maps = PbrMaps(
        base_colour=base_colour,
        normal=normal,
        roughness=_limit(_number(described.roughness, found.get("roughness"), size), "roughness", notes),
        metallic=_limit(_number(described.metallic, found.get("metallic"), size), "metallic", notes),
        f0=_limit(_number(described.f0, share, size), "specular", notes),
        height=_height(found.get("height")),
        occlusion=None
        if described.occlusion is None
        else _limit(_number(described.occlusion, found.get("occlusion"), size), "occlusion", notes),
        multiple_scattering=True,
        layers=_layers(described.layers, of_layers, normal, notes),
        wide=wide,
        tiles=tiles,
    )
    return maps, Health(findings=tuple(Finding(Verdict.WARNING, note) for note in notes))


def _layers(text: str, images: dict[str, Map], normal: Map, notes: list[str]) -> OpenPbr | MetallicRoughness | None:
    """The layers of a text times the mean of images (H, W) or (H, W, 3), with a sentence on those that vary."""
    layers = brdf_from_text(text) if text else None
    assert layers is None or isinstance(layers, OpenPbr | MetallicRoughness)
    if layers is None:
        return None
    for name, values in images.items():
        if not np.isfinite(values).all():
            continue
        layers = _times_mean(layers, name, values.mean(axis=(0, 1), dtype=np.float64))
        shown = luminance(values) if values.ndim == 3 else values
        mean, low, high = (float(of(shown)) for of in (partial(np.mean, dtype=np.float64), np.min, np.max))
        if np.ptp(values, axis=(0, 1)).max() > EVEN:
            words = _OF_LAYERS[name]
            notes.append(f"the {words} varies over its texture, {low:.2g} to {high:.2g}; its mean {mean:.2g} is drawn")
    if isinstance(layers, MetallicRoughness) and any(layers.sheen_color) and np.ptp(normal, axis=(0, 1)).max() > UNEVEN:
        notes.append("where a pixel covers normals that differ, the sheen is that of their mean")
    return layers


def _times_mean(layers: OpenPbr | MetallicRoughness, name: str, mean: Floats) -> OpenPbr | MetallicRoughness:
    """The layers with one of their parameters times the mean () or (3,) of an image, which `_OF_LAYERS` has."""
    if name == "sheen" and isinstance(layers, OpenPbr):
        colour = np.clip(layers.fuzz_weight * np.asarray(layers.fuzz_color) * mean, 0.0, 1.0)
        return replace(layers, **{"fuzz_weight": 0.0, **make_fuzz(tuple(colour.tolist()), layers.fuzz_roughness)})
    words = {"coat": "coat_weight", "sheen": "sheen_color"}
    if isinstance(layers, OpenPbr):
        words["sheen_roughness"] = "fuzz_roughness"
    parameter = words.get(name, name)
    value = np.clip(np.asarray(getattr(layers, parameter)) * mean, 0.0, 1.0)
    changed: dict[str, Any] = {parameter: tuple(value.tolist()) if value.ndim else float(value)}
    return replace(layers, **changed)


def _as_metal(
    described: Described, diffuse: Map, found: dict[str, Map], size: tuple[int, int]
) -> tuple[Described, Map, dict[str, Map]]:
    """Specular and glossiness, where a material has them, as base colour, metallic and roughness.

    Both have one brightness: with d that of the diffuse part, which highlights of s leave, b that of the base and m the
    share of metal, b (1 − m) = d and 0.04 (1 − m) + b m = s, so that 0.04 m² + (d + s − 0.08) m + 0.04 − s = 0. The
    base has the colour of the diffuse part where m is small, and of the highlight where it is large.
    """
    if described.specular is None or described.glossiness is None:
        return described, diffuse, found
    specular = _colour(described.specular, found.get("specular"), size)
    left = diffuse * (1.0 - specular.max(axis=-1, keepdims=True))
    d, s = luminance(left)[..., None], luminance(specular)[..., None]
    half = 0.5 * (d + s - 2.0 * DIELECTRIC_F0)
    root = np.sqrt(np.maximum(half * half - DIELECTRIC_F0 * (DIELECTRIC_F0 - s), 0.0))
    metal = np.where(s > DIELECTRIC_F0, np.clip((root - half) / DIELECTRIC_F0, 0.0, 1.0), 0.0)
    of_diffuse = left / np.maximum(1.0 - metal, 1e-6)
    of_highlight = (specular - DIELECTRIC_F0 * (1.0 - metal)) / np.maximum(metal, 1e-6)
    base = np.clip(np.where(metal > 0.0, of_diffuse + (of_highlight - of_diffuse) * metal**2, of_diffuse), 0.0, 1.0)
    roughness = 1.0 - _number(described.glossiness, found.get("glossiness"), size)
    f0 = np.where(s > DIELECTRIC_F0, DIELECTRIC_F0, s)[..., 0]
    maps = {"roughness": roughness, "metallic": metal[..., 0], "f0": f0}
    factors = dict.fromkeys(maps, Input((1.0,)))
    return (
        replace(described, **factors),  # type: ignore[arg-type]
        np.asarray(base, np.float32),
        {**found, **{name: np.asarray(each, np.float32) for name, each in maps.items()}},
    )


def _decode(image: Image) -> Map:
    """(H, W, 3) linear, or (H, W) of an alpha channel."""
    content = image.content if image.content is not None else read_bytes(image.path)
    name = image.path if image.content is None else f"{image.path}: {image.name}"
    if image.channel == "alpha":
        if content.startswith(JPEG):
            return np.ones((1, 1), np.float32)
        alpha: Map = decode_content("engine.images.decode:decode_alpha", name, content)["alpha"]
        return alpha
    reply = decode_content("engine.images.decode:decode", name, content, transfer=image.transfer)
    pixels = image_from_reply(reply).pixels
    return SPACES[image.space].linear(pixels) if image.space else pixels


def _decode_atlas(image: Image, side: int, most: int) -> Map:
    """The tiles of a set in a square of so many a side; of a single image as many repeats.

    Texture coordinates divided by `side` meet the tile that they meant: v runs up, and repeats, so that the rows after
    the first lie below it in the reverse order. A place without a tile has the first one.
    """
    largest = max(1, most // side)

    def decode(one: Image) -> Map:
        """One tile, no larger than it may be."""
        pixels = _decode(one)
        return _resize(pixels, (min(pixels.shape[0], largest), min(pixels.shape[1], largest)))

    parts = {number: decode(replace(image, path=path, tiles=())) for number, path in image.tiles} or {0: decode(image)}
    size = max(each.shape[0] for each in parts.values()), max(each.shape[1] for each in parts.values())
    first = _resize(next(iter(parts.values())), size)
    atlas = np.tile(first, (side, side, 1) if first.ndim == 3 else (side, side))
    for number in (each for each in parts if image.tiles):
        row, column = -((number - 1001) // 10) % side, (number - 1001) % 10
        here = slice(row * size[0], (row + 1) * size[0]), slice(column * size[1], (column + 1) * size[1])
        atlas[here] = _resize(parts[number], size)
    return np.ascontiguousarray(atlas, np.float32)


def _read_channel(pixels: Map, image: Image) -> Map:
    if pixels.ndim == 2 or not isinstance(image.channel, int):
        return pixels
    return np.ascontiguousarray(pixels[..., image.channel])


def _size(found: Mapping[str, Map], images: Mapping[str, Image], most: int) -> tuple[tuple[int, int], list[str]]:
    """(H, W) of the largest image, within `most`, and what is said about it; (1, 1) without any."""
    if not found:
        return (1, 1), []
    height, width = max((values.shape[:2] for values in found.values()), key=lambda shape: shape[0] * shape[1])
    notes = []
    other = sorted({images[name].name for name, each in found.items() if each.shape[:2] != (height, width)})
    if other:
        notes.append(f"{', '.join(other)}: another size than {width} × {height} texels, brought to it")
    scale = min(1.0, most / max(height, width))
    if scale < 1.0:
        size = max(1, round(height * scale)), max(1, round(width * scale))
        notes.append(f"{width} × {height} texels are taken at {size[1]} × {size[0]}, the most that is kept")
        return size, notes
    return (height, width), notes


def _resize(values: Map, size: tuple[int, int]) -> Map:
    if values.shape[:2] == size:
        return values
    smaller = values.shape[0] > size[0]
    kind = cv2.INTER_AREA if smaller else cv2.INTER_LINEAR
    resized: Map = cv2.resize(np.ascontiguousarray(values), (size[1], size[0]), interpolation=kind)
    return resized


def _colour(given: Input, values: Map | None, size: tuple[int, int]) -> Map:
    """(H, W, 3)."""
    factor = np.broadcast_to(np.asarray(given.factor, np.float32), (3,))
    if values is None:
        return np.broadcast_to(factor, (*size, 3)).astype(np.float32)
    values = np.repeat(values[..., None], 3, axis=2) if values.ndim == 2 else values
    return (1.0 - values if given.inverted else values) * factor


def _number(given: Input, values: Map | None, size: tuple[int, int]) -> Map:
    """(H, W); of a colour the first channel, which is all three of a grey image."""
    factor = np.float32(given.factor[0])
    if values is None:
        return np.full(size, factor, np.float32)
    values = values[..., 0] if values.ndim == 3 else values
    return (1.0 - values if given.inverted else values) * factor


def _keep_wide(base: Map, notes: list[str]) -> tuple[Map, WideColours | None]:
    """Base colours in [0, 1], and in the first wider space that holds them, where Rec.709 does not."""
    whole = np.nan_to_num(base, nan=0.0, posinf=1.0, neginf=0.0)
    if whole.min(initial=0.0) < -WORTH_SAYING:
        for space in (REC_2020, ACESCG):
            values = np.asarray(whole @ space.from_rec709.T, np.float32)
            held = np.ascontiguousarray(np.clip(values, 0.0, 1.0))
            if np.abs(values - held).max() < WORTH_SAYING:
                clipped, _, wide = clip_wide(space, held, None)
                notes += [] if wide is None else [wide_text(wide)]
                return clipped, wide
    return _limit(base, "base colour", notes), None


def _limit(values: Map, name: str, notes: list[str]) -> Map:
    """`values` in [0, 1], as numbers; a sentence where they were not."""
    whole = np.nan_to_num(values, nan=0.0, posinf=1.0, neginf=0.0)
    beyond = float(np.mean((whole < -1e-3) | (whole > 1.0 + 1e-3)))
    if beyond > 0.0:
        notes.append(f"{name} is outside 0 … 1 in {percent(beyond)} of the texels, and clamped")
    return np.ascontiguousarray(np.clip(whole, 0.0, 1.0), np.float32)


def _height(values: Map | None) -> Map | None:
    """Heights about their mean; their unit is not known, and nothing is drawn of them."""
    if values is None:
        return None
    values = np.nan_to_num(values[..., 0] if values.ndim == 3 else values)
    return np.ascontiguousarray(values - values.mean(dtype=np.float64), np.float32)


def _normals(described: Described, values: Map | None, size: tuple[int, int], notes: list[str]) -> Map:
    """(H, W, 3) unit vectors with y up."""
    flat = np.zeros((*size, 3), np.float32)
    flat[..., 2] = 1.0
    if values is None or values.ndim != 3:
        return flat
    values = np.nan_to_num(values)
    vectors = values if _are_plain(values) else 2.0 * values - 1.0
    if float(vectors[..., 2].max()) < 0.01:  # two channels alone are stored: the third follows
        squared = np.clip(1.0 - vectors[..., 0] ** 2 - vectors[..., 1] ** 2, 0.0, None)
        vectors = np.dstack([vectors[..., :2], np.sqrt(squared)])
    vectors = vectors * np.array([described.normal_scale, described.normal_scale, 1.0], np.float32)
    length = np.sqrt(np.einsum("ijk,ijk->ij", vectors, vectors))[..., None]
    normal = np.where((length > 0.05) & (vectors[..., 2:] > 0.0), vectors / np.maximum(length, 1e-6), flat)
    sense, telling = _agreement(normal), max(TELLING, DEVIATIONS / math.sqrt(size[0] * size[1]))
    upwards = described.upwards
    seen: Upwards = "directx" if sense < -telling else "opengl" if sense > telling else ""
    if not upwards:
        upwards = seen or "opengl"
        words = {"opengl": "up (OpenGL)", "directx": "down (DirectX)"}[upwards]
        why = "by its slopes" if seen else "because nothing says otherwise"
        notes.append(f"y of the normals is taken to point {words}, {why}")
    elif seen and seen != upwards:
        notes.append(f"the normals are called {upwards}, but their slopes look like those of {seen}")
    if upwards == "directx":
        normal = normal * np.array([1.0, -1.0, 1.0], np.float32)
    length = np.sqrt(np.einsum("ijk,ijk->ij", normal, normal))[..., None]
    return np.ascontiguousarray(normal / length, np.float32)


def _are_plain(values: Map) -> bool:
    """True for normals n themselves, False for codes (n + 1) / 2: the former go below zero, or have the length 1."""
    if values.min() < -0.01:
        return True
    plain, coded = (float(np.abs(np.linalg.norm(each, axis=2) - 1.0).mean()) for each in (values, 2.0 * values - 1.0))
    return plain < min(0.01, coded)


def _agreement(normal: Map) -> float:
    """Correlation, in [−1, 1], of ∂p/∂y and ∂q/∂x for the slopes p and q of normals with y up; 0 where all is flat.

    The slopes of a height h are p = ∂h/∂x and q = ∂h/∂y, so both are ∂²h/∂x∂y.
    """
    if min(normal.shape[:2]) < 3:
        return 0.0
    steep = np.maximum(normal[..., 2], 1.0 / STEEPEST)
    p, q = -normal[..., 0] / steep, -normal[..., 1] / steep
    # rows run down, y runs up
    one, other = -np.diff(p, axis=0)[:, :-1], np.diff(q, axis=1)[:-1]
    whole = float(np.sqrt(np.sum(one.astype(np.float64) ** 2) * np.sum(other.astype(np.float64) ** 2)))
    return float(np.sum(one.astype(np.float64) * other)) / whole if whole > 1e-12 else 0.0


def only(path: Path, values: Sequence[object], what: str, remedy: str) -> None:
    """InputError where there is not exactly one."""
    if len(values) != 1:
        names = ", ".join(os.fspath(each) if isinstance(each, os.PathLike) else str(each) for each in values[:3])
        problem = f"holds no {what}" if not values else f"holds several of {what} ({names})"
        raise InputError(path, problem, remedy)
