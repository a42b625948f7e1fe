"""A material that repeats without visible seams: the tile is found on the slices, and its own slices are built anew.

One cut through all slices says which texel of the sample each texel of the tile copies (`engine.shading.tile`). The
photographs are then copied along it and linearised once more, because the mean of a tile is not that of the sample: so
slice i of the tile has mean r_i of the tile exactly, and no slice is interpolated twice.
The planes of a directional map are those of the sample along the cut, which is found on its images under a few lamps.
Cost: about 5 s for eight slices of four megapixels, one copy of the photographs, and a second linearisation.

Tileable materials: one cut through all slices at once (image quilting of Efros2001, on a torus).

The tile is a rectangle of the photographed sample whose size is searched so that its opposite edges repeat (a weave
wants a whole number of threads), and whose edges overlap by a band. In the band a path of least error decides, texel
by texel, which of the two edges is seen. The path is found on all slices jointly and every output texel copies one
input texel, so the slices stay consistent and no texel is a blend.

The second path runs along an image that already repeats sideways, so it must end where it began: the least closed
path is the best over all starting points. Cost: O(H W) for the copy, O(length * band^2) for the closed path.
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
from engine.storage.scratch import release, scratch_array

SEARCHING = "finding where the material repeats"

#: Rows of a closed path between two steps.
ROWS_PER_STEP = 64

#: Edge length in texels of the reduced image on which the tile size is searched.
SEARCH_SIZE = 256


@dataclass(frozen=True, eq=False)
class TileSource:
    """Texel of the sample that each texel of the tile copies.

    Attributes
    ----------
    row, column : (h, w) int32 source coordinates; `slices[:, row, column]` is the tile.
    seam_error : mean step between neighbours that were joined, divided by the mean step that the same texels make to
        their neighbours in the sample; 1 is a seam that nobody can find.
    """

    row: NDArray[np.int32]
    column: NDArray[np.int32]
    seam_error: float


def tile_source(slices: NDArray[np.float32], overlap: int | None = None, smallest: float = 0.5) -> Steps[TileSource]:
    """Find the tile of `slices` (S, H, W, 3) with the least visible seams.

    Parameters
    ----------
    overlap : width of the band in which edges are joined, texels; an eighth of the shorter side by default.
    smallest : the least acceptable fraction of the sample's width and height that the tile keeps, in (0, 1).

    Raises UsageError if the sample is smaller than 8 texels or the overlap leaves no room.
    """
    height, width = slices.shape[1:3]
    if min(height, width) < 8:
        raise UsageError(f"a sample of {width} x {height} texels is too small to be made tileable")
    band = overlap if overlap is not None else max(4, min(height, width) // 8)
    if not 1 <= band <= (1 - smallest) * min(height, width):
        raise UsageError(f"an overlap of {band} texels does not fit a sample of {width} x {height}")
    yield Step(0.0, SEARCHING)
    features = _features(slices)
    tile_width = yield from part(_best_period(features, band, smallest), 0.0, 0.3)
    cuts = _open_path(_disagreement(features, tile_width, band))
    column = _join(np.broadcast_to(np.arange(width, dtype=np.int32), (height, width)), tile_width, cuts)
    row = np.broadcast_to(np.arange(height, dtype=np.int32)[:, None], column.shape)

    sideways = features[row, column].transpose(1, 0, 2)
    tile_height = yield from part(_best_period(sideways, band, smallest), 0.3, 0.6)
    cuts = yield from part(_find_closed_path(_disagreement(sideways, tile_height, band)), 0.6, 1.0)
    row = _join(row.T, tile_height, cuts).T
    column = _join(column.T, tile_height, cuts).T
    return TileSource(row, column, _seam_error(features, row, column))


def _features(slices: NDArray[np.float32]) -> NDArray[np.float32]:
    """(H, W, S) root of the luminance of every slice: differences then weigh as they are seen."""
    weights = np.array([0.2126, 0.7152, 0.0722], np.float32)
    return np.stack([np.sqrt(np.maximum(image @ weights, 0)) for image in slices], axis=-1)


def _disagreement(features: NDArray[np.float32], period: int, band: int) -> NDArray[np.float64]:
    """(H, band) squared difference between the band at the left edge and the one a period further right."""
    return np.sum((features[:, :band] - features[:, period : period + band]) ** 2, axis=-1, dtype=np.float64)


def _best_period(features: NDArray[np.float32], band: int, smallest: float) -> Steps[int]:
    """The tile width whose overlapping bands agree best; searched on a reduced image, then around the winner."""
    width = features.shape[1]
    step = max(1, min(features.shape[:2]) // SEARCH_SIZE)
    lowest, highest = int(np.ceil(smallest * width)), width - band
    coarse = yield from part(_cheapest(features, range(lowest, highest + 1, step), band, step), 0.0, 0.5)
    near = range(max(lowest, coarse - step), min(highest, coarse + step) + 1)
    return (yield from part(_cheapest(features, near, band, 1), 0.5, 1.0))


def _cheapest(features: NDArray[np.float32], periods: range, band: int, stride: int) -> Steps[int]:
    """The period whose bands agree best on every `stride`-th texel; of equal ones the largest."""
    best = (np.inf, 0)
    for count, period in enumerate(periods, 1):
        cost = _open_path_cost(_disagreement(features[::stride], period, band)[:, ::stride])
        best = min(best, (cost, -period))
        yield Step(count / len(periods), SEARCHING)
    return -best[1]


def _accumulate(cost: NDArray[np.float64], start: NDArray[np.float64]) -> NDArray[np.float64]:
    """Least cost of a path from row 0 to each cell, moving at most one cell sideways per row; (rows, ..., band)."""
    total = np.empty((len(cost), *start.shape))
    total[0] = start
    for y in range(1, len(cost)):
        before = total[y - 1]
        best = before.copy()
        best[..., 1:] = np.minimum(best[..., 1:], before[..., :-1])
        best[..., :-1] = np.minimum(best[..., :-1], before[..., 1:])
        total[y] = best + cost[y]
    return total


def _trace(total: NDArray[np.float64], end: int) -> NDArray[np.int64]:
    """Walk back from cell `end` of the last row along the least costs."""
    path = np.empty(len(total), np.int64)
    path[-1] = end
    for y in range(len(total) - 2, -1, -1):
        low, high = max(path[y + 1] - 1, 0), min(path[y + 1] + 2, total.shape[1])
        path[y] = low + int(np.argmin(total[y, low:high]))
    return path


def _open_path(cost: NDArray[np.float64]) -> NDArray[np.int64]:
    total = _accumulate(cost, cost[0])
    return _trace(total, int(np.argmin(total[-1])))


def _open_path_cost(cost: NDArray[np.float64]) -> float:
    """Mean cost per row of the least path."""
    return float(_accumulate(cost, cost[0])[-1].min()) / len(cost)


def _find_closed_path(cost: NDArray[np.float64]) -> Steps[NDArray[np.int64]]:
    """The least path that ends beside the cell where it began: the best over all starting cells."""
    band = cost.shape[1]
    last = np.where(np.eye(band, dtype=bool), cost[0], np.inf)
    for y, row in enumerate(cost[1:], 1):
        best = last.copy()
        best[:, 1:] = np.minimum(best[:, 1:], last[:, :-1])
        best[:, :-1] = np.minimum(best[:, :-1], last[:, 1:])
        last = best + row
        if y % ROWS_PER_STEP == 0:
            yield Step(y / len(cost), SEARCHING)
    start, end = np.indices(last.shape)
    closed = np.where(np.abs(start - end) <= 1, last, np.inf)
    first, final = np.unravel_index(int(np.argmin(closed)), closed.shape)
    begin = np.full(band, np.inf)
    begin[first] = cost[0, first]
    return _trace(_accumulate(cost, begin), int(final))


def _join(source: NDArray[np.int32], period: int, cuts: NDArray[np.int64]) -> NDArray[np.int32]:
    """Left of each row's cut the tile shows what follows its right edge, so that the wrap-around continues."""
    x = np.arange(period)
    shown = np.where(x[None, :] < cuts[:, None], x[None, :] + period, x[None, :])
    shown = np.minimum(shown, source.shape[1] - 1)
    return np.take_along_axis(source, shown, axis=1)


def _seam_error(features: NDArray[np.float32], row: NDArray[np.int32], column: NDArray[np.int32]) -> float:
    """Mean step to the neighbour across all joins, over the mean step the same texels make in the sample itself."""
    tile = features[row, column]
    seams, sample = 0.0, 0.0
    for axis, limit in ((0, features.shape[0]), (1, features.shape[1])):
        next_row, next_column = np.roll(row, -1, axis), np.roll(column, -1, axis)
        own_row = np.minimum(row + (axis == 0), limit - 1) if axis == 0 else row
        own_column = np.minimum(column + 1, limit - 1) if axis == 1 else column
        joined = (next_row != own_row) | (next_column != own_column)
        here = tile[joined]
        seams += float(np.abs(np.roll(tile, -1, axis)[joined] - here).sum(dtype=np.float64))
        sample += float(np.abs(features[own_row[joined], own_column[joined]] - here).sum(dtype=np.float64))
    return seams / sample if sample > 0 else 1.0


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
