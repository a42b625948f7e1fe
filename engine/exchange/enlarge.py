"""A larger tile of a material, for programs that repeat maps in a grid: hexagonal cells that repeat at its border.

The cells are those of `engine.render.hex_tiling`, a little wider or narrower, so that a whole number of them lies along
the tile. All maps of a material are blended in the same cells, as Gaussian numbers, which become the values of equal
rank; normals by their parts that lie in the surface. Each channel has the histogram of its map exactly, and with it the
mean. Cost: some 2 µs a texel and map.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from engine.capture.scale import mm_per_texel
from engine.core.colour import LUMINANCE
from engine.core.errors import UsageError
from engine.core.steps import Step, Steps, part
from engine.exchange.export import subject_of
from engine.render.hex_tiling import STEEPEST, cells_around, gaussianise
from engine.render.mip_maps import planes_by_three
from engine.scene.material import Material
from engine.shading.quantise import quantise_exponent, restore_exponent
from engine.surface.pbr_maps import PbrMaps, SurfaceMaps

if TYPE_CHECKING:
    from engine.capture.stack import ImageStack

Floats = NDArray[np.float32]

#: Repeats along each side of a larger tile.
MIN_REPEATS, MAX_REPEATS = 2, 16

#: Most texels along a side of a larger tile.
MAX_TEXELS = 8192

#: Ranks at which numbers and values are paired.
QUANTILES = 4097

#: Texels of a band, about 50 ms of work.
BAND = 1 << 15


def enlarge(material: Material, repeats: int, stack: ImageStack | None = None) -> Steps[Material]:
    """The material as a tile of `repeats` × `repeats` of its own size, with PBR maps if it comes from photographs.

    `stack` holds its photographs where they are at hand, to find the surface (`subject_of`). Uncertainty, regions and
    errors of the maps are left out, for they belong to places of the sample.
    UsageError for a number of repeats beyond `MIN_REPEATS` … `MAX_REPEATS`, for more than `MAX_TEXELS` a side, and for
    a material that does not repeat: an object with a mask, and a power law of which some tiles keep their slices.
    """
    check_repeats(material, repeats)
    if material.pbr is not None:
        maps = yield from _enlarge_maps(material.pbr, repeats)
        return replace(material, pbr=maps)
    subject = yield from part(subject_of(material, stack), 0.0, 0.4)
    maps = yield from part(_enlarge_maps(subject.maps, repeats), 0.4, 0.7)
    larger = yield from part(_enlarge_look_up(material, repeats), 0.7, 1.0)
    return replace(larger, surface=SurfaceMaps(maps, subject.white), mask=None)


def check_repeats(material: Material, repeats: int) -> None:
    """Raise UsageError where `enlarge` would."""
    if not MIN_REPEATS <= repeats <= MAX_REPEATS:
        raise UsageError(f"a tile of {repeats} × {repeats} repeats is not within {MIN_REPEATS} to {MAX_REPEATS}")
    height, width = material.size
    if max(height, width) * repeats > MAX_TEXELS:
        most = MAX_TEXELS // max(height, width)
        less = f"at most {most} repeats fit" if most >= MIN_REPEATS else "make the material smaller first"
        raise UsageError(f"a tile of {width * repeats} × {height * repeats} texels is too large; {less}")
    mask = material.mask if material.pbr is None else material.pbr.mask
    if mask is not None and not np.all(mask):
        raise UsageError("an object with a mask does not repeat; cut a tile out of it (lightarc shade --part)")
    if material.power_law is not None and material.power_law.kept is not None:
        raise UsageError("a power law of which some tiles keep their slices cannot be enlarged; build it without them")


def width_of_tile(material: Material, repeats: int, stack: ImageStack | None, width_mm: float | None) -> float | None:
    """Width of the tile in millimetres from that of the sample, the given one or that which the photographs know."""
    if width_mm is None and stack is not None:
        size = mm_per_texel(stack.provenance)
        width_mm = None if size is None else size * material.size[1]
    return None if width_mm is None else width_mm * repeats


def _enlarge_look_up(material: Material, repeats: int) -> Steps[Material]:
    """Slices, the pair and planes, each in the same cells."""
    slices, power_law, directional = material.shading_map, material.power_law, material.directional
    found: dict[str, Any] = {}
    if slices is not None:
        images = yield from part(blend_tile(slices.slices, repeats), 0.0, 0.5)
        means = images.mean(axis=(1, 2), dtype=np.float64) @ LUMINANCE
        found["shading_map"] = replace(slices, slices=images, mean_radiance=means, clipped=None)
    if power_law is not None:
        pair = np.stack([power_law.scale, power_law.exponent])
        scale, exponent = yield from part(blend_tile(pair, repeats), 0.5, 1.0)
        storage = power_law.storage
        if storage.exponent_bits != 32:
            codes, step = quantise_exponent(exponent, storage.exponent_bits, storage.exponent_step)
            exponent = restore_exponent(codes, step)
        scale = scale.astype(np.float16).astype(np.float32) if storage.scale_bits == 16 else scale
        error = np.tile(power_law.error_map, (repeats, repeats))
        found["power_law"] = replace(power_law, scale=scale, exponent=exponent, error_map=error)
    if directional is not None:
        layers = yield from blend_tile(planes_by_three(directional.planes), repeats)
        planes = np.moveaxis(layers, 3, 1).reshape(-1, *layers.shape[1:3])[: len(directional.planes)]
        found["directional"] = replace(directional, planes=np.clip(np.rint(planes), 0, 255).astype(np.uint8))
    return replace(material, **found)


def _enlarge_maps(maps: PbrMaps, repeats: int) -> Steps[PbrMaps]:
    """PBR maps in the same cells."""
    scalars = [maps.roughness, maps.metallic, maps.f0, maps.height, maps.occlusion]
    known = [values for values in scalars if values is not None]
    tilt = maps.normal * np.array([1.0, 1.0, 0.0], np.float32)
    wide = [] if maps.wide is None else [maps.wide.base_colour]
    filled = np.stack([*known, *[np.zeros(maps.size, np.float32)] * (-len(known) % 3)])
    layers = np.stack([maps.base_colour, tilt, *wide, *np.moveaxis(filled.reshape(-1, 3, *maps.size), 1, 3)])
    made = yield from blend_tile(np.asarray(layers, np.float32), repeats)
    rest = np.moveaxis(made[2 + len(wide) :], 3, 1).reshape(-1, *made.shape[1:3])
    found = iter(np.ascontiguousarray(rest[: len(known)]))
    roughness, metallic, f0, height, occlusion = (None if each is None else next(found) for each in scalars)
    assert roughness is not None
    assert metallic is not None
    assert f0 is not None
    return replace(
        maps,
        base_colour=made[0].copy(),
        normal=_unit_normals(made[1]),
        roughness=roughness,
        metallic=metallic,
        f0=f0,
        height=height,
        occlusion=occlusion,
        uncertainty=None,
        region=None,
        mask=None,
        wide=None if maps.wide is None else replace(maps.wide, base_colour=made[2].copy(), sigma=None),
    )


def _unit_normals(tilt: Floats) -> Floats:
    """Unit normals (H, W, 3) of their parts x and y."""
    x, y = tilt[..., 0].astype(np.float64), tilt[..., 1].astype(np.float64)
    scale = np.minimum(1.0, STEEPEST / np.maximum(np.hypot(x, y), 1e-12))
    return np.dstack([scale * x, scale * y, np.sqrt(1.0 - (scale * x) ** 2 - (scale * y) ** 2)]).astype(np.float32)


def blend_tile(layers: Floats, repeats: int) -> Steps[Floats]:
    """Layers (L, H, W, 3) as a tile (L, repeats H, repeats W, 3) that repeats at its border."""
    count, height, width = layers.shape[:3]
    numbers = np.array(layers, np.float32)
    for layer, channel in np.ndindex(count, 3):
        numbers[layer, ..., channel] = gaussianise(layers[layer, ..., channel])
        yield Step(0.2 * (3 * layer + channel + 1) / (3 * count), "enlarging the tile")
    made = np.empty((count, repeats * height, repeats * width, 3), np.float32)
    rows = max(1, BAND // (repeats * width))
    column = np.arange(repeats * width)
    for top in range(0, repeats * height, rows):
        row = np.arange(top, min(top + rows, repeats * height))
        down, along = (each.ravel() for each in np.meshgrid(row, column, indexing="ij"))
        uv = np.column_stack([(along + 0.5) / width, (down + 0.5) / height])
        weight, shift = cells_around(uv, (height, width), repeats)
        share = weight / np.sqrt(np.square(weight).sum(axis=1, keepdims=True))
        moved = np.rint(shift * [width, height]).astype(np.int64)
        blended = np.zeros((count, len(uv), 3))
        for cell in range(3):
            at = (down + moved[:, cell, 1]) % height, (along + moved[:, cell, 0]) % width
            blended += share[:, cell, None] * numbers[:, at[0], at[1]]
        made[:, row[0] : row[-1] + 1] = blended.reshape(count, len(row), -1, 3)
        yield Step(0.2 + 0.6 * (row[-1] + 1) / (repeats * height), "enlarging the tile")
    for layer, channel in np.ndindex(count, 3):
        made[layer, ..., channel] = rank_alike(made[layer, ..., channel], layers[layer, ..., channel])
        yield Step(0.8 + 0.2 * (3 * layer + channel + 1) / (3 * count), "enlarging the tile")
    return made


def rank_alike(numbers: Floats, values: Floats) -> Floats:
    """The histogram of `values` for `numbers` of any shape: each becomes the value of equal rank."""
    known, wanted = (np.quantile(each, np.linspace(0.0, 1.0, QUANTILES)) for each in (numbers, values))
    return np.interp(numbers, known, wanted).astype(np.float32)
