"""A material that repeats without visible seams: the tile is found on the slices, and its own slices are built anew.

One cut through all slices says which texel of the sample each texel of the tile copies (`engine.shading.tileable`). The
photographs are then copied along it and linearised once more, because the mean of a tile is not that of the sample: so
slice i of the tile has mean r_i of the tile exactly, and no slice is interpolated twice.
The planes of a directional map are those of the sample along the cut, which is found on its images under a few lamps.
Cost: about 5 s for eight slices of four megapixels, one copy of the photographs, and a second linearisation.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from engine.capture.stack import ImageStack
from engine.core.colour import LUMINANCE
from engine.core.errors import InputError, UsageError
from engine.core.health import Finding, Health, Verdict
from engine.core.steps import Step, Steps, part
from engine.shading.directional.planes import DirectionalMap
from engine.shading.shading_map import ShadingMap, build, include
from engine.shading.tileable import TileSource, tile_source
from engine.storage.scratch import release, scratch_array

#: Lamps, evenly over the list, under which planes are looked at.
IMAGES = 8

#: Above this ratio of steps across the seams to steps within the sample, users find the seams.
VISIBLE_SEAM = 2.0


@dataclass(frozen=True, eq=False)
class Tile:
    """A shading map that repeats, and where its texels come from."""

    shading_map: ShadingMap
    source: TileSource


def make_tile(
    stack: ImageStack, shading_map: ShadingMap, *, overlap: int | None = None, excluded: Collection[str] = ()
) -> Steps[Tile]:
    """The tile of `shading_map`, which was built from `stack` without the photographs named in `excluded`.

    `overlap` is the width in texels of the band in which opposite edges are joined, by default an eighth of the
    shorter side. Raises InputError where the sample is too small for it.
    """
    try:
        source = yield from part(tile_source(shading_map.slices, overlap), 0.0, 0.5)
    except UsageError as error:
        where = stack.folder or "the stack"
        raise InputError(where, str(error), "Choose a smaller overlap or a larger crop") from None
    used = include(stack, excluded)
    tiled = yield from part(_copy(stack, source, used), 0.5, 0.75)
    again = yield from part(build(tiled, len(shading_map.slices)), 0.75, 1.0)
    health = again.health.merge(tile_health(source, shading_map.slices.shape[1:3]))
    order = tuple(int(used[photograph]) for photograph in again.order)
    return Tile(dataclasses.replace(again, health=health, order=order), source)


def tile_planes(
    directional: DirectionalMap, *, overlap: int | None = None, name: str | Path = "the material"
) -> Steps[tuple[DirectionalMap, TileSource]]:
    """A directional map that repeats, and where its texels come from; its errors are those of the sample.

    `overlap` as in `make_tile`. Raises InputError, which names `name`, where the sample is too small for it.
    """
    lamps = directional.lights[np.linspace(0, len(directional.lights) - 1, IMAGES).round().astype(np.int64)]
    images = []
    for count, lamp in enumerate(lamps):
        yield Step(0.2 * count / IMAGES, "lighting the planes")
        images.append(directional.image(lamp))
    try:
        source = yield from part(tile_source(np.stack(images), overlap), 0.2, 1.0)
    except UsageError as error:
        raise InputError(name, str(error), "Choose a smaller overlap or a larger crop") from None
    planes = np.ascontiguousarray(directional.planes[:, source.row, source.column])
    return dataclasses.replace(directional, planes=planes), source


def tile_health(source: TileSource, sample: tuple[int, int]) -> Health:
    """The size of the tile and its seams in words and figures; `sample` is the size (H, W) that it was cut from."""
    height, width = source.row.shape
    findings = [Finding(Verdict.NOTE, f"tileable: {width} x {height} texels of the sample's {sample[1]} x {sample[0]}")]
    if source.seam_error > VISIBLE_SEAM:
        text = f"steps across the seams are {source.seam_error:.1f} times those of the sample; they can be seen"
        findings.append(Finding(Verdict.WARNING, text))
    return Health(MappingProxyType({"seam_error": source.seam_error}), tuple(findings))


def _copy(stack: ImageStack, source: TileSource, used: NDArray[np.int64]) -> Steps[ImageStack]:
    """The stack of the tile's texels, with mean radiances of its own."""
    radiance = scratch_array((len(used), *source.row.shape, 3), np.float32, stack.folder)
    saturated = np.empty((len(used), *source.row.shape), np.bool_)
    means = np.empty(len(used))
    for place, photograph in enumerate(used):
        radiance[place] = stack.radiance[photograph][source.row, source.column]
        saturated[place] = stack.saturated[photograph][source.row, source.column]
        means[place] = radiance[place].mean(axis=(0, 1), dtype=np.float64) @ LUMINANCE
        release(radiance)
        yield Step((place + 1) / len(used), "copying the tile")
    return dataclasses.replace(
        stack,
        radiance=radiance,
        saturated=saturated,
        mean_radiance=means,
        elevation=stack.elevation[used],
        azimuth=None if stack.azimuth is None else stack.azimuth[used],
        sources=tuple(stack.sources[photograph] for photograph in used),
        quality=tuple(stack.quality[photograph] for photograph in used) if stack.quality else (),
    )
