"""Maps without a visible period: hexagonal cells, each with a part of the maps of its own, blended by their values.

The plane is a triangle grid whose vertices are the middles of cells. Each cell shows the maps shifted by a hash of its
vertex, and a point blends those of the three vertices around it (Heitz2018b; the grid is that of Mikkelsen2022). A mean
with the weights w would lose contrast, so that deviations from the mean of the maps are added with w / √Σw², which
keeps their variance. Values are blended as Gaussian numbers of the same rank. A table for each channel and mip level
brings their histogram back, and with it the mean: it pairs blended numbers and values of equal rank, found at points
drawn evenly over cells and maps.

Slices of shading maps, the pair of a power law, planes of directional maps, and colours, roughness, metallic and f0 of
PBR maps are blended in this way. All channels of a point have the same weights, which keeps correlations between them.
Normals are blended as they are, and the covariances of slopes that a point covers with w² / Σw²: of independent parts
that is the covariance of their sum. Tiles of a power law that keep their slices make slices of the whole map.

Cells are shifted and not rotated, since most weaves and brushed metals have a direction, and photographs hold light
from one side. Patterns of threads or tiles that follow a grid are broken at the borders of cells: this is for materials
without such an order.

Cost: three look-ups in place of one, one in a table for each number, and a sort of each channel when maps are loaded,
some 0.1 s a megatexel and channel.
"""

from __future__ import annotations

import math
from collections.abc import Generator
from dataclasses import dataclass, field
from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from engine.core.cached import remember_with
from engine.render.gains import NO_GAINS, compare_means, gains_of, interpolate
from engine.render.mip_maps import Levels, filter_levels, halves, mip_levels
from engine.scene.scene import Scene
from engine.shading.directional.planes import DirectionalMap
from engine.shading.lookup import neighbours
from engine.shading.power_law import PowerLawMap
from engine.shading.shading_map import ShadingMap
from engine.surface.pbr_maps import PbrMaps

Array = NDArray[np.float64]
Result = TypeVar("Result")

#: Cells along one repeat of the maps: their sides are 1 / (2 √3) of it, as in Heitz2018b.
CELLS = 2.0 * math.sqrt(3.0)

#: Power of the weights, by which a cell shows its own part over most of its area.
SHARPNESS = 4.0

#: Share of the weights that each cell gives up, so that half of all points look up two cells or one.
MIN_SHARE = 2e-3

#: Entries of a table, and the Gaussian numbers that they reach from the mean.
ENTRIES, REACH = 256, 3.5

_ENTRIES = np.linspace(-REACH, REACH, ENTRIES)

#: Points at which a table pairs numbers and values, as a power of 2.
POINTS = 13

#: Layers of PBR maps that are blended as Gaussian numbers: base colour; roughness, metallic and f0.
GAUSSIAN_LAYERS = 2

#: Longest part of a blended normal that lies in the surface.
STEEPEST = 0.98

#: Cells along a repeat to the right, before `CELLS`, and along the other side of the grid.
_SKEW = np.array([[1.0, 0.0], [-2.0, 4.0]])
_A, _C = np.uint32(1664525), np.uint32(1013904223)


@dataclass(frozen=True, eq=False)
class Maps:
    """Maps as a scene looks them up, in a grid or in hexagonal cells.

    Attributes
    ----------
    levels : as `engine.render.mip_maps`, in hexagonal cells with Gaussian numbers in the layers that have tables.
    gains : (levels, A, B, 3) as `engine.render.gains`.
    tables : (levels, layers, ENTRIES, 3) values of the Gaussian numbers from −`REACH` to `REACH`; None in a grid.
    mean_normal : (3,) the mean of the normals of PBR maps in cells, else 0.
    """

    levels: Levels
    gains: NDArray[np.float32] = field(default_factory=lambda: NO_GAINS)
    tables: NDArray[np.float32] | None = None
    mean_normal: Array = field(default_factory=lambda: np.zeros(3))


Source = PbrMaps | ShadingMap | PowerLawMap | DirectionalMap


def maps_of_scene(scene: Scene) -> Maps:
    """Maps as a scene looks them up; no levels where it has one BRDF everywhere."""
    maps = scene.pbr or scene.shading
    return hex_tiles(maps) if scene.tiling_mode == "hex" and maps is not None else grid_tiles(maps)


def grid_tiles(maps: Source | None) -> Maps:
    """Prepare maps that repeat in a grid."""
    levels = mip_levels(maps)
    return Maps(levels, gains_of(maps, levels))


@remember_with
def hex_tiles(maps: Source) -> Maps:
    """Prepare maps for hexagonal cells."""
    return run_at_once(prepare_tiles(maps, mip_levels(maps if isinstance(maps, PbrMaps) else in_slices(maps))))


def in_slices(maps: ShadingMap | PowerLawMap | DirectionalMap) -> ShadingMap | PowerLawMap | DirectionalMap:
    """The map itself, or the slices of a power law of which some tiles keep theirs."""
    if not isinstance(maps, PowerLawMap) or maps.kept is None:
        return maps
    targets = np.linspace(0.0, maps.r_max, maps.kept.slices.shape[1])
    slices = np.stack([maps.slice_image(r) for r in targets])
    return ShadingMap(slices, maps.r_max, targets)


def run_at_once(work: Generator[None, None, Result]) -> Result:
    """Result of work that is made in pieces."""
    while True:
        try:
            next(work)
        except StopIteration as end:
            return cast(Result, end.value)


def prepare_tiles(maps: Source, values: Levels) -> Generator[None, None, Maps]:
    """Make the tiles of `maps` from their `values` at all sizes, in pieces of one channel or size."""
    count = GAUSSIAN_LAYERS if isinstance(maps, PbrMaps) else len(values[0])
    ranked = np.array(values[0], np.float32)
    for layer in range(count):
        for channel in range(3):
            ranked[layer, ..., channel] = gaussianise(values[0][layer, ..., channel])
            yield
    numbers = halves(ranked[:count])
    numbers = [np.concatenate([each, rest[count:]]) for each, rest in zip(numbers, values, strict=True)]
    tables = np.empty((len(values), count, ENTRIES, 3), np.float32)
    share, places = _points()
    for level, (of_level, plain) in enumerate(zip(numbers, values, strict=True)):
        at = np.floor(places * _size(plain)) + 0.5 if level == 0 else places * _size(plain)
        mean = plain[:count].mean(axis=(1, 2), dtype=np.float64)
        blended, wanted = _blend_numbers(of_level[:count], share, at), _interpolate(plain[:count], at)
        for layer in range(count):
            for channel in range(3):
                given = blended[layer, :, channel], wanted[layer, ..., channel], mean[layer, channel]
                tables[level, layer, :, channel] = transfer(*given)
        yield
    normal = values[0][2].mean(axis=(0, 1), dtype=np.float64) if isinstance(maps, PbrMaps) else np.zeros(3)
    return Maps(numbers, (yield from _compare_means(maps, numbers, tables, values[0])), tables, normal)


def _compare_means(
    maps: Source, numbers: Levels, tables: NDArray[np.float32], whole: NDArray[np.float32]
) -> Generator[None, None, NDArray[np.float32]]:
    """The gains of blended maps: channels that are blended one by one do not keep what joins them."""
    if isinstance(maps, PbrMaps) or isinstance(in_slices(maps), ShadingMap):
        return NO_GAINS
    share, places = _points()
    seen = []
    for level, of_level in enumerate(numbers):
        blended = _blend_numbers(of_level, share, places * _size(of_level))
        where = np.full(blended.shape[1], float(level))
        seen.append(np.stack([values_of_numbers(tables[:, layer], each, where) for layer, each in enumerate(blended)]))
        yield
    return compare_means(maps, seen, interpolate(whole))


def _size(layers: NDArray[np.float32]) -> Array:
    return np.array(layers.shape[1:3], np.float64)[:, None]


def _interpolate(layers: NDArray[np.float32], places: Array) -> Array:
    """(L, M, 3) layers (L, h, w, 3) between texels, at rows and columns (2, M)."""
    value = np.zeros((len(layers), places.shape[1], 3))
    for row, column, part in neighbours(places[0], places[1], *layers.shape[1:3]):
        value += part[:, None] * layers[:, row, column]
    return value


def _blend_numbers(layers: NDArray[np.float32], share: Array, places: Array) -> Array:
    """(L, N, 3) blends with factors (N, 3) of the three `places` of each point."""
    return np.asarray((share[..., None] * _interpolate(layers, places).reshape(len(layers), -1, 3, 3)).sum(axis=2))


def transfer(numbers: Array, values: Array, mean: float) -> Array:
    """(ENTRIES,) the table that gives `numbers` (N,) the histogram of `values` of any shape, and this mean."""
    known, values = np.sort(numbers), np.sort(values, axis=None)
    rank = np.linspace(0.0, 1.0, len(values))
    of_number = np.interp(np.linspace(0.0, 1.0, len(known)), rank, values)
    table = np.interp(_ENTRIES, known, of_number)
    shifted = table - (np.interp(known, _ENTRIES, table).mean() - mean)
    return np.clip(shifted, values[0], values[-1])


def _points() -> tuple[Array, Array]:
    """Factors (N, 3) of deviations in the cells around points, and places (2, 3 N) in the maps of each cell."""
    from scipy.stats import qmc

    even = qmc.Sobol(8, seed=1).random_base2(POINTS)
    weight = cells_around(even[:, :2], (1, 1))[0]
    share = weight / np.sqrt(np.square(weight).sum(axis=1, keepdims=True))
    return np.asarray(share), np.ascontiguousarray(even[:, 2:].reshape(-1, 2).T)


def gaussianise(values: NDArray[np.float32]) -> NDArray[np.float32]:
    """Gaussian numbers (H, W) of the ranks of `values`, with mean 0 and variance 1.

    Equal values share the mean of their numbers; a channel of one value has the number 0.
    """
    from scipy.special import ndtri

    known, at, count = np.unique(values, return_inverse=True, return_counts=True)
    if len(known) == 1:
        return np.zeros(values.shape, np.float32)
    edge = np.concatenate([[0.0], np.cumsum(count) / values.size])
    edge[-1] = 1.0
    density = np.exp(-0.5 * np.square(np.clip(ndtri(edge), -40.0, 40.0))) / math.sqrt(2.0 * math.pi)
    number = (density[:-1] - density[1:]) / np.diff(edge)
    number /= math.sqrt(float((number**2 * count).sum()) / values.size)
    return np.asarray(number[at].reshape(values.shape), np.float32)


def cells_around(uv: Array, size: tuple[int, int], period: int = 0) -> tuple[Array, Array]:
    """Weights (N, 3), whose sum is 1, of the cells around `uv` (N, 2) in repeats of the maps, and their shifts
    (N, 3, 2) in repeats: whole texels of maps of `size` (H, W), so that none is smoothed.

    With a `period`, cells repeat after so many repeats; they are then a little wider or narrower.
    """
    skewed = uv @ _SKEW.T
    columns = round(CELLS * period)
    skewed[:, 0] *= CELLS if period == 0 else columns / period
    base = np.floor(skewed)
    x, y = (skewed - base).T
    rest = 1.0 - x - y
    far = (rest <= 0.0).astype(np.float64)
    sign = 2.0 * far - 1.0
    weight = np.stack([-rest * sign, far - y * sign, far - x * sign], axis=1)
    weight = np.maximum(weight, 0.0) ** SHARPNESS
    weight = np.maximum(weight - MIN_SHARE * weight.sum(axis=1, keepdims=True), 0.0)
    weight /= weight.sum(axis=1, keepdims=True)
    corners = np.stack([np.stack([far, far], 1), np.stack([far, 1.0 - far], 1), np.stack([1.0 - far, far], 1)], axis=1)
    texels = np.array(size[::-1], np.float64)
    vertex = (base[:, None] + corners).astype(np.int64)
    if period:
        turns = vertex[..., 0] // columns
        vertex = np.stack([vertex[..., 0] - turns * columns, (vertex[..., 1] + 2 * period * turns) % (4 * period)], -1)
    return weight, np.floor(hash_cells(vertex) * texels) / texels


def hash_cells(vertex: NDArray[np.int64]) -> Array:
    """Shifts (…, 2) in [0, 1) of vertices (…, 2): the hash pcg2d (Jarzynski2020), of which 24 bits are taken."""
    x, y = ((vertex[..., axis] & 0xFFFFFFFF).astype(np.uint32) * _A + _C for axis in (0, 1))
    for _ in range(2):
        x = x + y * _A
        y = y + x * _A
        x, y = x ^ (x >> np.uint32(16)), y ^ (y >> np.uint32(16))
    return np.stack([x >> np.uint32(8), y >> np.uint32(8)], axis=-1) / float(1 << 24)


def values_at(maps: Maps, layer: int, uv: Array, detail: Array) -> Array:
    """One layer (N, 3) at `uv` (N, 2) with the mip levels `detail` (N,), filtered or blended."""
    if maps.tables is None:
        return filter_levels(maps.levels, layer, uv, detail)
    weight, shift = cells_around(uv, maps.levels[0].shape[1:3])
    share = weight / np.sqrt(np.square(weight).sum(axis=1, keepdims=True))
    numbers = np.zeros((len(uv), 3))
    for cell in range(3):
        numbers += share[:, cell, None] * filter_levels(maps.levels, layer, uv + shift[:, cell], detail)
    return values_of_numbers(maps.tables[:, layer], numbers, detail)


def differences_at(levels: Levels, uv: Array, detail: Array) -> tuple[Array, Array] | tuple[None, None]:
    """Layers 4 and 5 (N, 3) of `pbr_levels`, by which texels below points differ; None where all are of full size."""
    if not (detail > 0.0).any():
        return None, None
    return filter_levels(levels, 4, uv, detail), filter_levels(levels, 5, uv, detail)


def blend(
    tiles: Maps, uv: Array, detail: Array
) -> tuple[Array, Array, Array, Array, tuple[Array, Array] | tuple[None, None]]:
    """Base colour; roughness, metallic and f0; mean normals; means of their products; and `differences_at`, (N, 3)
    each, at `uv` (N, 2) with the mip levels `detail` (N,)."""
    assert tiles.tables is not None
    weight, shift = cells_around(uv, tiles.levels[0].shape[1:3])
    share = weight / np.sqrt(np.square(weight).sum(axis=1, keepdims=True))
    numbers = np.zeros((GAUSSIAN_LAYERS, len(uv), 3))
    apart, covariance = np.zeros((len(uv), 3)), np.zeros((len(uv), 4))
    within = [np.zeros((len(uv), 3))] * 2
    for cell in range(3):
        at, own = uv + shift[:, cell], share[:, cell, None]
        for layer in range(GAUSSIAN_LAYERS):
            numbers[layer] += own * filter_levels(tiles.levels, layer, at, detail)
        mean, square = normals_at(tiles.levels, at, detail)
        apart += own * (mean - tiles.mean_normal)
        covariance += own**2 * _covariance(mean, square)
        within = [
            each if part is None else each + own**2 * part
            for each, part in zip(within, differences_at(tiles.levels, at, detail), strict=True)
        ]
    base, gloss = (
        values_of_numbers(tiles.tables[:, layer], numbers[layer], detail) for layer in range(GAUSSIAN_LAYERS)
    )
    x, y, _ = (tiles.mean_normal + apart).T
    scale = np.minimum(1.0, STEEPEST / np.maximum(np.hypot(x, y), 1e-12))
    x, y = scale * x, scale * y
    xx, yy, xy, zz = covariance.T
    z = np.sqrt(np.maximum(1.0 - x * x - y * y - xx - yy - zz, 1.0 - STEEPEST**2))
    square = np.stack([xx + x * x, yy + y * y, xy + x * y], axis=1)
    return base, gloss, np.stack([x, y, z], axis=1), square, (within[0], within[1])


def _covariance(mean: Array, square: Array) -> Array:
    """(N, 4) covariances xx, yy, xy and zz of the components of unit normals."""
    x, y, z = mean.T
    about = square - np.stack([x * x, y * y, x * y], axis=1)
    zz = np.maximum(1.0 - square[:, 0] - square[:, 1] - z * z, 0.0)
    return np.column_stack([np.maximum(about[:, :2], 0.0), about[:, 2], zz])


def normals_at(levels: Levels, uv: Array, detail: Array) -> tuple[Array, Array]:
    """Mean normals, and the means of their products xx, yy, xy, (N, 3) each: layers 2 and 3 of `levels`."""
    mean, square = (filter_levels(levels, layer, uv, detail) for layer in (2, 3))
    # between texels of full size the surface is smooth, and normals of unit length
    close = np.flatnonzero(detail < 1.0)
    share = 1.0 - detail[close, None]
    near = [filter_levels(levels[:1], layer, uv[close], np.zeros(len(close))) for layer in (2, 3)]
    unit = near[0] / np.maximum(np.linalg.norm(near[0], axis=1, keepdims=True), 1e-12)
    mean[close] += share * (unit - near[0])
    square[close] += share * (np.stack([unit[:, 0] ** 2, unit[:, 1] ** 2, unit[:, 0] * unit[:, 1]], axis=1) - near[1])
    return mean, square


def values_of_numbers(tables: NDArray[Any], numbers: Array, detail: Array) -> Array:
    """Values (N, 3) of Gaussian numbers (N, 3), linear between entries and levels (levels, ENTRIES, 3)."""
    place = np.clip((numbers + REACH) * ((ENTRIES - 1) / (2.0 * REACH)), 0.0, ENTRIES - 1.0)
    entry = np.minimum(place.astype(np.int64), ENTRIES - 2)
    level = np.clip(detail, 0.0, len(tables) - 1.0)
    below = np.minimum(level.astype(np.int64), max(len(tables) - 2, 0))
    above = np.minimum(below + 1, len(tables) - 1)
    beyond, between = (level - below)[:, None], place - entry
    channel = np.arange(3)[None]

    def at(rows: NDArray[np.int64]) -> Array:
        low, high = tables[rows[:, None], entry, channel], tables[rows[:, None], entry + 1, channel]
        return np.asarray((1.0 - between) * low + between * high, np.float64)

    return (1.0 - beyond) * at(below) + beyond * at(above)
