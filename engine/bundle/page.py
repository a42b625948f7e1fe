"""The page of a material: zoom, pan and a light that can be dragged, in any browser with WebGL 2.

It is put together from resources/viewer: a document, a style sheet and five scripts. As one file it carries all within
itself, loads nothing and opens from a disk; in parts, script, style and images lie beside it, as sites want it whose
policy allows no code within a page. Its maps are the power-law pair in 16 bits, each as two 8-bit PNG images (high
and low byte), because browsers read no floats; the error is half of 1/65535 of a map's largest value. Of a directional
map they are the planes, three in an image, and the table of their weights in 16 bits. PBR maps, where they are given,
are further channels in 8 bits. These maps are averaged down to 1024 texels; what is finer comes in tiles as it is seen
(`engine.bundle.page`), in the one file as far as that keeps below the limit of a bundle's member, and the page says
what it holds. It shares the GLSL of the window (resources/shaders), includes written out.

Maps at full resolution in tiles, for a page that zooms: a pyramid of levels, each half as large as the one before.

A tile is an image of 8 bits of at most `TILE` texels a side, with a `MARGIN` of its neighbours on each side, across
the edges of a map that repeats. Scale of a power law is in codes of sRGB of its largest value. Its exponents K are the
codes

    c = 1 + 254 ln(K / low) / ln(high / low),    0 for K = 0,

because an error of K changes s^K by at most 1 / (e K) of it: a step of the codes is then the same share of radiance
everywhere. Planes are 8 bits as they are. Coding a power law is bound by PNG, some 20 MB/s of pixels a core.
"""

from __future__ import annotations

import base64
import json
import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from engine.brdf.brdf import MODELS, Brdf, brdf_from_text, model_name
from engine.bundle.portable import RESOURCES, brdf_glsl, fill_in, fit_statement, glsl_source
from engine.core.colour import srgb_decode, srgb_encode
from engine.core.errors import UsageError
from engine.core.params import Parameter, parameters
from engine.images.encode import encode_png
from engine.scene.material import Material
from engine.shading.directional.planes import DirectionalMap
from engine.shading.power_law import PowerLawMap
from engine.storage.scratch import ScratchFiles, release
from engine.surface.pbr_maps import PbrMaps

#: Texels of a tile and of its margin, a side.
TILE, MARGIN = 512, 4

#: Ratio of the largest to the least exponent that has a code of its own.
EXPONENTS = 4096.0

#: Texels and shares of r_max by which the error of the coding is measured.
MEASURED, SHARES = 1 << 14, (0.05, 0.1, 0.2, 0.35, 0.5, 0.7, 1.0)

Floats = NDArray[np.float32]

#: A map (H, W, 3) and the codes (h, w, 3) of a part of it.
Layer = tuple[NDArray[Any], Callable[[Any], NDArray[np.uint8]]]


@dataclass(frozen=True)
class Codes:
    """Ranges of the codes of a power law: the largest scale, and the least and the largest exponent above 0."""

    largest: float
    low: float
    high: float

    def reduce_scale(self, scale: Floats) -> NDArray[np.uint8]:
        return np.rint(255.0 * srgb_encode(np.clip(scale / self.largest, 0.0, 1.0))).astype(np.uint8)

    def reduce_exponent(self, exponent: Floats) -> NDArray[np.uint8]:
        share = np.log(np.maximum(exponent, self.low) / self.low) / max(np.log(self.high / self.low), 1e-9)
        codes = np.rint(1.0 + 254.0 * np.minimum(share, 1.0))
        return np.where(exponent > 0.5 * self.low, codes, 0.0).astype(np.uint8)

    def scale(self, codes: NDArray[np.uint8]) -> NDArray[np.float64]:
        return np.asarray(self.largest * srgb_decode(codes / 255.0))

    def exponent(self, codes: NDArray[np.uint8]) -> NDArray[np.float64]:
        return np.where(codes > 0, self.low * (self.high / self.low) ** ((codes - 1.0) / 254.0), 0.0)


def codes_of(power_law: PowerLawMap) -> Codes:
    """The codes for the values of a power law."""
    high = float(power_law.exponent.max()) or 1.0
    least = min(
        float(rows[rows > 0.0].min(initial=high)) for rows in np.array_split(power_law.exponent, 16) if len(rows)
    )
    return Codes(float(power_law.scale.max()) or 1.0, max(least, high / EXPONENTS), high)


def coding_error(power_law: PowerLawMap, codes: Codes) -> float:
    """Relative RMSE of the radiance of coded texels, over `SHARES` of r_max and some `MEASURED` texels."""
    height, width = power_law.scale.shape[:2]
    step = max(1, int(np.sqrt(height * width / MEASURED)))
    scale, exponent = power_law.scale[::step, ::step], power_law.exponent[::step, ::step]
    found = codes.scale(codes.reduce_scale(scale)), codes.exponent(codes.reduce_exponent(exponent))
    squares = np.zeros(2)
    for share in SHARES:
        wanted = scale * np.float64(share) ** exponent
        squares += np.sum((found[0] * share ** found[1] - wanted) ** 2), np.sum(wanted**2)
    return float(np.sqrt(squares[0] / squares[1])) if squares[1] else 0.0


def level_sizes(size: tuple[int, int], whole: int) -> list[tuple[int, int]]:
    """(H, W) of the levels, from the full one; none where a map of `whole` texels a side shows everything.

    The last is at least 1.5 times as large as such a map.
    """
    sizes, longer = [], max(size)
    share = 1
    while longer > whole and (share == 1 or longer >= 1.5 * whole * share):
        sizes.append((max(1, round(size[0] / share)), max(1, round(size[1] / share))))
        share *= 2
    return sizes


def bytes_of(sizes: list[tuple[int, int]], layers: int) -> int:
    """Bytes of the pixels of levels in three channels, margins included."""
    total = 0
    for size in sizes:
        sides = [length + 2 * MARGIN * -(-length // TILE) for length in size]
        total += 3 * layers * sides[0] * sides[1]
    return total


def tiles(layers: Iterable[Layer], size: tuple[int, int]) -> Iterator[tuple[int, int, int, NDArray[np.uint8]]]:
    """Column, row, layer and pixels of each tile of one level, `size` (H, W)."""
    for number, (values, coded) in enumerate(layers):
        level = _at_size(values, size)
        for row in range(-(-size[0] // TILE)):
            rows = _places(row, size[0])
            strip = level[rows]
            for column in range(-(-size[1] // TILE)):
                yield column, row, number, coded(strip[:, _places(column, size[1])])


def planes_in_layers(planes: NDArray[np.uint8] | NDArray[np.float16]) -> Iterator[Layer]:
    """The codes (K, H, W) of planes by three as (H, W, 3) of 8 bits, the last filled up with 0."""
    for first in range(0, len(planes), 3):
        layer = np.zeros((*planes.shape[1:], 3), np.uint8)
        for channel, plane in enumerate(planes[first : first + 3]):
            layer[..., channel] = np.rint(plane)
        yield layer, lambda codes: np.asarray(codes, np.uint8)


def smaller_in_layers(directional: DirectionalMap, layers: list[NDArray[np.uint8]]) -> list[NDArray[np.uint8]]:
    """For each of the `layers` (H, W, 3) of planes its small sizes below each other, in an image as wide as the first.

    None where the layers are one texel.
    """
    planes = np.moveaxis(np.stack(layers), 3, 1).reshape(-1, *layers[0].shape[:2])[: len(directional.planes)]
    images: list[list[NDArray[np.uint8]]] = [[] for _ in layers]
    for level in replace(directional, planes=planes).smaller:
        for image, (layer, coded) in zip(images, planes_in_layers(level), strict=True):
            rest = layers[0].shape[1] // 2 - layer.shape[1]
            image.append(np.pad(coded(layer), ((0, 0), (0, max(rest, 0)), (0, 0))))
    return [np.concatenate(image) for image in images if image]


def _places(index: int, length: int) -> NDArray[np.int64]:
    """Rows or columns of a tile with its margins, around the edges of the map."""
    first, last = index * TILE, min((index + 1) * TILE, length)
    return np.arange(first - MARGIN, last + MARGIN) % length


def _at_size(values: NDArray[Any], size: tuple[int, int]) -> NDArray[Any]:
    if values.shape[:2] == size:
        return values

    small = cv2.resize(np.asarray(values), (size[1], size[0]), interpolation=cv2.INTER_AREA)
    return np.asarray(small).reshape(*size, 3)


#: Longest side of the maps in the page, in texels.
VIEWER_SIDE = 1024

#: Bytes of pixels in a page of one file, whose PNG in base64 then fits a member of a bundle, 256 MiB; and in parts.
PIXELS_WITHIN, PIXELS_BESIDE = 190 << 20, 2 << 30

#: What stands in the data of a page for its images until they are put in.
_HERE = "@images"

_BEYOND_ASCII = re.compile(r"[^\x00-\x7f]")

_SCRIPTS = ("shaders.js", "maps.js", "tiles.js", "view.js", "panel.js")
_BEGINNING = """"use strict";
const data = JSON.parse(document.getElementById("data").textContent);
const canvas = document.getElementById("picture");
const byId = (id) => document.getElementById(id);
"""

#: Policies of the page as one file and in parts.
_WITHIN = "default-src 'none'; img-src data:; script-src 'unsafe-inline'; style-src 'unsafe-inline'"
_BESIDE = "default-src 'self'"


@dataclass(frozen=True)
class Extras:
    """Parts of a page beyond the material itself.

    Attributes
    ----------
    loss : a sentence about errors, besides that of a fitted BRDF.
    maps : PBR maps of the same texels, which become channels.
    width_mm : width of the sample, by which the page draws a scale bar; None where it is not known.
    """

    loss: str = ""
    maps: PbrMaps | None = None
    width_mm: float | None = None


@dataclass(frozen=True, eq=False)
class _Images:
    """PNG images and bytes of their pixels by their names, as the data of the page call them."""

    files: ScratchFiles = field(default_factory=ScratchFiles)
    sizes: dict[str, int] = field(default_factory=dict)

    @property
    def names(self) -> list[str]:
        return list(self.files)

    def put(self, name: str, pixels: NDArray[np.uint8]) -> str:
        """All are said to be sRGB, as canvases are, so that no browser converts their codes."""
        self.files.put(f"{name}.png", encode_png(pixels))
        self.sizes[f"{name}.png"] = pixels.nbytes
        return f"{name}.png"

    def put_two_bytes(self, name: str, codes: NDArray[np.uint16]) -> dict[str, str]:
        """The high and the low bytes of `codes` (H, W, 3) as two images."""
        planes = {"high": (codes >> 8).astype(np.uint8), "low": (codes & 255).astype(np.uint8)}
        return {part: self.put(f"{name}-{part}", plane) for part, plane in planes.items()}


@dataclass(frozen=True, eq=False)
class OneFile:
    """The page as one file: `pieces` of it, each read and coded when it is its turn, so that none is in memory whole.

    Attributes
    ----------
    before, after : the text around the images, in ASCII.
    names : those of the `files` that belong to it.
    """

    before: bytes
    names: Sequence[str]
    files: ScratchFiles
    after: bytes

    def __iter__(self) -> Iterator[bytes]:
        yield self.before
        for index, name in enumerate(self.names):
            yield self._head(index, name)
            yield base64.b64encode(self.files[name])
            yield b'"'
        yield self.after

    def __len__(self) -> int:
        """Bytes."""
        images = (
            len(self._head(index, name)) + 4 * -(-self.files.size_bytes(name) // 3) + 1
            for index, name in enumerate(self.names)
        )
        return len(self.before) + sum(images) + len(self.after)

    @staticmethod
    def _head(index: int, name: str) -> bytes:
        return f'{", " if index else ""}"{name}": "'.encode("ascii")


def make_page(material: Material, extras: Extras | None = None) -> OneFile:
    """The page as one file: the material on a plane and a sphere under a light that can be dragged.

    Of shading maps it shows the power law: tiles that keep their slices are shown by it too, with the error that it
    has, and the page says so. Of directional maps it shows the planes. UsageError for a material with neither.
    It states the error of a fitted BRDF, and what else is known of the loss.
    """
    data, images = _data_and_images(material, extras or Extras(), PIXELS_WITHIN)
    return _one_file(data, images, images.names)


def viewer(material: Material, extras: Extras | None = None) -> str:
    """The text of `make_page`."""
    return b"".join(make_page(material, extras)).decode("ascii")


def viewer_and_parts(material: Material, extras: Extras | None = None) -> tuple[OneFile, Mapping[str, bytes]]:
    """The same page as one file, and as `index.html` without code or styles, `lightarc.js`, `lightarc.css` and its
    images, by path, which hold all tiles."""
    data, images = _data_and_images(material, extras or Extras(), PIXELS_BESIDE)
    style, script = '<link rel="stylesheet" href="lightarc.css">', '<script src="lightarc.js"></script>'
    text = {
        "index.html": _document(data, _BESIDE, style, script),
        "lightarc.css": _style(),
        "lightarc.js": _script(),
    }
    page = _one_file(*_within(data, images))
    for name, content in text.items():
        images.files.put(name, content.encode())
    return page, images.files


def _one_file(data: dict[str, Any], images: _Images, names: Sequence[str]) -> OneFile:
    """The page with the images of such names in its data."""
    style, script = (f"<{tag}>\n{text}</{tag}>" for tag, text in (("style", _style()), ("script", _script())))
    page = _document({**data, "pictures": {_HERE: ""}}, _WITHIN, style, script)
    before, _, after = page.rpartition(f'"{_HERE}": ""')
    return OneFile(before.encode("ascii"), names, images.files, after.encode("ascii"))


def _within(data: dict[str, Any], images: _Images) -> tuple[dict[str, Any], _Images, list[str]]:
    """The part of a page that has room in one file: without the finest tiles where they are too large."""
    pyramid = data.get("pyramid")
    if pyramid is None:
        return data, images, images.names
    of_maps = sum(size for name, size in images.sizes.items() if not name.startswith("tiles/"))
    sizes = [(height, width) for width, height in pyramid["levels"]]
    finest = _finest(sizes, pyramid["layers"], PIXELS_WITHIN - of_maps)
    left_out = tuple(f"tiles/{name}-{level}-" for name, first in finest.items() for level in range(first))
    names = [name for name in images.names if not (left_out and name.startswith(left_out))]
    return {**data, "pyramid": {**pyramid, "finest": finest}}, images, names


def _document(data: dict[str, Any], policy: str, style: str, script: str) -> str:
    text = json.dumps(data, ensure_ascii=True, allow_nan=False).replace("<", "\\u003c")
    return fill_in(_part("index.html"), POLICY=policy, STYLE=style, SCRIPT=script, DATA=text)


def _part(name: str) -> str:
    """A part of the page in ASCII: a page with any wider character takes five times its size to be encoded."""
    text = (RESOURCES / "viewer" / name).read_text(encoding="utf-8")
    if name.endswith(".js"):
        return _BEYOND_ASCII.sub(lambda found: f"\\u{ord(found[0]):04x}", text)
    return text.encode("ascii", "xmlcharrefreplace").decode("ascii")


def _style() -> str:
    return _part("viewer.css")


def _script() -> str:
    return "\n".join([_BEGINNING, *map(_part, _SCRIPTS)])


def _data_and_images(material: Material, extras: Extras, max_bytes: int) -> tuple[dict[str, Any], _Images]:
    """JSON values of the page, in which images are named, and the images, of at most so many bytes of pixels."""
    brdf, images = brdf_from_text(material.brdf), _Images()
    sources, channels = ["frame", "shading_map"], [["picture", "Image"]]
    if material.directional is not None:
        shown, sources = _planes(material.directional, images), [*sources, "directional", "effective_light"]
    elif material.power_law is not None:
        shown = _power_law(material.power_law, images)
        channels += [["brightest", "Brightest light"], ["exponent", "Exponent"]]
    else:
        raise UsageError("the page shows the compressed pair or planes, which this material does not have")
    written: set[str] = set()
    data = {
        "name": material.name,
        "brdf": model_name(brdf),
        "models": [_model(name, brdf) for name in MODELS],
        "sigma": material.sigma,
        "elevation_deg": _thin(material.elevation_deg, 64),
        "fit": " ".join(filter(None, (fit_statement(material), extras.loss))),
        "width_mm": extras.width_mm,
        **shown,
        "sources": {name: glsl_source(f"{name}.glsl", written) for name in sources},
    }
    if extras.maps is not None:
        data["surface"], further = _surface(extras.maps, images)
        channels += further
    if material.mask is not None and material.mask.shape == material.size:
        cover = np.repeat(np.float32(255.0) * material.mask[..., None], 3, axis=2)
        pixels = np.rint(_reduce(cover)).astype(np.uint8)
        data["cover"] = {"size": _size(pixels), "layers": [images.put("cover", pixels)]}
    sizes = level_sizes(material.size, VIEWER_SIDE)
    if sizes:
        data["pyramid"] = _pyramid(material, extras.maps, sizes, images, max_bytes)
    return {**data, "channels": channels}, images


def _pyramid(
    material: Material, maps: PbrMaps | None, sizes: list[tuple[int, int]], images: _Images, max_bytes: int
) -> dict[str, Any]:
    """The tiles of all levels, or from the one on that has room; of the look-up before those of the surface."""
    groups: dict[str, tuple[int, Callable[[tuple[int, int]], Iterator[Layer]]]] = {}
    figures: dict[str, Any] = {"error": 0.0}
    if material.directional is not None:
        planes, at_least = material.directional.planes, material.directional.at_least
        groups["look_up"] = -(-len(planes) // 3), lambda size: planes_in_layers(at_least(max(size)))
    else:
        assert material.power_law is not None
        law, codes = material.power_law, codes_of(material.power_law)
        groups["look_up"] = 2, lambda _: iter(((law.scale, codes.reduce_scale), (law.exponent, codes.reduce_exponent)))
        figures = {"error": coding_error(law, codes), "largest": codes.largest, "exponents": [codes.low, codes.high]}
    if maps is not None:
        groups["surface"] = 3, lambda _: _surface_layers(maps)
    layers = {name: count for name, (count, _) in groups.items()}
    finest = _finest(sizes, layers, max_bytes - sum(images.sizes.values()))
    for name, (_, made) in groups.items():
        for level in range(finest[name], len(sizes)):
            for column, row, layer, pixels in tiles(made(sizes[level]), sizes[level]):
                images.put(f"tiles/{name}-{level}-{column}-{row}-{layer}", pixels)
    levels = [[width, height] for height, width in sizes]
    return {"tile": TILE, "margin": MARGIN, "levels": levels, "layers": layers, "finest": finest, **figures}


def _finest(sizes: list[tuple[int, int]], layers: dict[str, int], max_bytes: int) -> dict[str, int]:
    """The first level of each group for which there is room, the number of levels where there is for none."""
    finest = {}
    for name, count in layers.items():
        finest[name] = next(level for level in range(len(sizes) + 1) if bytes_of(sizes[level:], count) <= max_bytes)
        max_bytes -= bytes_of(sizes[finest[name] :], count)
    return finest


def _power_law(power_law: PowerLawMap, images: _Images) -> dict[str, Any]:
    height, width = power_law.scale.shape[:2]
    return {
        "r_max": power_law.r_max,
        "rms": power_law.health.figures.get("rms_without_kept_tiles", power_law.rms),
        "kept_percent": 0.0 if power_law.kept is None else 100.0 * float((power_law.kept.place >= 0).mean()),
        "size": [width, height],
        "maps": {name: _code(name, getattr(power_law, name), images) for name in ("scale", "exponent")},
    }


def _code(name: str, values: NDArray[np.float32], images: _Images) -> dict[str, Any]:
    """A map in 16 bits for the page: value = largest (256 high + low) / 65535."""
    small = _reduce(values)
    release(values)
    largest = float(small.max())
    codes = np.rint(small / (largest or 1.0) * 65535.0).astype(np.uint16)
    return {"largest": largest, "size": _size(small), **images.put_two_bytes(name, codes)}


def _planes(directional: DirectionalMap, images: _Images) -> dict[str, Any]:
    """Planes by three as images, with their smaller sizes, and their weights, (1 + 3 L, TILTS, TURNS, 3), as rows."""
    whole, (height, width) = directional.at_least(VIEWER_SIDE), directional.planes.shape[1:]
    layers = [np.rint(_reduce(layer)).astype(np.uint8) for layer, _ in planes_in_layers(whole)]
    smaller = smaller_in_layers(directional, layers)
    weights = np.zeros((1 + 3 * len(layers), *directional.table.shape[:3]))
    weights[: directional.table.shape[3]] = np.moveaxis(directional.table, 3, 0)
    low = weights.min(axis=(1, 2, 3))
    step = np.maximum(weights.max(axis=(1, 2, 3)) - low, np.finfo(np.float32).tiny) / 65535.0
    codes = np.rint((weights - low[:, None, None, None]) / step[:, None, None, None]).astype(np.uint16)
    rows, columns = codes.shape[1:3]
    return {
        "r_max": directional.r_max,
        "size": [width, height],
        "planes": {
            "count": len(directional.planes),
            "lowest": directional.lowest,
            "leave_one_out": directional.leave_one_out if math.isfinite(directional.leave_one_out) else None,
            "size": _size(layers[0]),
            "layers": [images.put(f"planes-{number}", layer) for number, layer in enumerate(layers)],
            "smaller": [images.put(f"planes-{number}-smaller", each) for number, each in enumerate(smaller)],
        },
        "weights": {
            "size": [columns, rows],
            "lowest": low.tolist(),
            "step": step.tolist(),
            **images.put_two_bytes("weights", codes.reshape(-1, columns, 3)),
        },
    }


def _surface(maps: PbrMaps, images: _Images) -> tuple[dict[str, Any], list[list[str]]]:
    """Base colour, normals, and roughness, metallic and occlusion as images of 8 bits, and the channels they give.

    Normals n are the codes 128 + 127 n. Flat ones are not a channel, nor is what is 0 or unknown everywhere.
    """
    layers = zip(("base-colour", "normals", "others"), _surface_layers(maps), strict=True)
    small = {name: coded(np.asarray(_reduce(values), np.float32)) for name, (values, coded) in layers}
    names = [images.put(name, layer) for name, layer in small.items()]
    channels = [["base_colour", "Base colour"], ["roughness", "Roughness"]]
    if (maps.normal[..., 2] < 1.0).any():
        along = " along the arc" if maps.observed.kind == "along the arc" else ""
        channels += [["normal", f"Normals{along}"], ["relief", "Relief"]]
        channels += [["enhanced", "Enhanced highlights"]]
    channels += [["metallic", "Metallic"]] if maps.metallic.any() else []
    channels += [["occlusion", "Occlusion"]] if maps.occlusion is not None else []
    return {"size": _size(small["normals"]), "layers": names}, channels


def _surface_layers(maps: PbrMaps) -> Iterator[Layer]:
    """The images of a surface: maps (H, W, 3) and their codes."""
    occlusion = np.ones(maps.size, np.float32) if maps.occlusion is None else maps.occlusion
    yield maps.base_colour, lambda values: np.rint(255.0 * srgb_encode(values)).astype(np.uint8)
    yield maps.normal, lambda values: np.rint(128.0 + 127.0 * values).astype(np.uint8)
    yield (
        np.stack([maps.roughness, maps.metallic, occlusion], axis=2),
        lambda values: np.rint(255.0 * values).astype(np.uint8),
    )


def _size(pixels: NDArray[Any]) -> list[int]:
    return [pixels.shape[1], pixels.shape[0]]


def _reduce(values: NDArray[Any]) -> NDArray[np.float64]:
    """The map averaged down to at most VIEWER_SIDE texels on its longer side."""
    height, width = values.shape[:2]
    share = VIEWER_SIDE / max(height, width)
    if share >= 1.0:
        return values.astype(np.float64)

    size = (max(1, round(width * share)), max(1, round(height * share)))
    small = cv2.resize(np.asarray(values), size, interpolation=cv2.INTER_AREA)
    return np.asarray(small, np.float64).reshape(size[1], size[0], 3)


def _thin(values: tuple[float, ...], most: int) -> list[float]:
    """At most `most` of `values`, evenly chosen, with the first and the last: uniforms are few."""
    chosen = np.linspace(0, len(values) - 1, min(len(values), most)).round().astype(int)
    return [float(values[index]) for index in chosen]


def _model(name: str, current: Brdf) -> dict[str, Any]:
    """A model for the page: its declared parameters (with the current values where it is the current one), its GLSL."""
    instance = current if name == model_name(current) else MODELS[name]()
    declared = [_parameter(parameter, getattr(instance, parameter.name)) for parameter in parameters(instance)]
    return {"name": name, "parameters": declared, "glsl": brdf_glsl(name)}


def _parameter(parameter: Parameter, value: Any) -> dict[str, Any]:
    low, high = parameter.slider
    return {
        "name": parameter.name,
        "label": parameter.label,
        "doc": parameter.doc,
        "unit": parameter.unit,
        "low": low,
        "high": high,
        "log": parameter.log,
        "value": value,
    }
