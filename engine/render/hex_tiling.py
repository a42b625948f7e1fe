"""PBR maps without a visible period: hexagonal cells, each with a part of the maps of its own, blended by their values.

The plane is a triangle grid whose vertices are the middles of cells. Each cell shows the maps shifted by a hash of its
vertex, and a point blends those of the three vertices around it (Heitz2018b; the grid is that of Mikkelsen2022). A mean
with the weights w would lose contrast, so that deviations from the mean of the maps are added with w / √Σw², which
keeps their variance. Colours, roughness, metallic and f0 are blended as Gaussian numbers of the same rank, so that the
histogram of the maps comes back from a table for each of them: at each mip level of the expected value given the
Gaussian mean of what a point covers, which keeps means from near and from afar. Normals are blended as they are, and
the covariances of slopes that a point covers with w² / Σw²: of independent parts that is the covariance of their sum.
Cells are shifted and not rotated, since most weaves and brushed metals have a direction. Patterns of threads or tiles
that follow a grid are broken at the borders of cells: this is for materials without such an order.

Cost: three look-ups in place of one, six in tables, and a sort of each channel when maps are loaded, some 0.1 s a
megatexel and channel.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.render.mip_maps import Levels, filter_levels, half, pbr_layers
from engine.scene.scene import Scene
from engine.shading.lookup import neighbours
from engine.surface.pbr_maps import PbrMaps

Array = NDArray[np.float64]

#: Cells along one repeat of the maps: their sides are 1 / (2 √3) of it, as in Heitz2018b.
CELLS = 2.0 * math.sqrt(3.0)

#: Power of the weights, by which a cell shows its own part over most of its area.
SHARPNESS = 4.0

#: Entries of a table, and the Gaussian numbers that they reach from the mean.
ENTRIES, REACH = 256, 3.5

_ENTRIES = np.linspace(-REACH, REACH, ENTRIES)

#: Points by which the mean of each table is set right.
SAMPLES = 1 << 12

#: Layers that are blended as Gaussian numbers: base colour; roughness, metallic and f0.
GAUSSIAN_LAYERS = 2

#: Longest part of a blended normal that lies in the surface.
STEEPEST = 0.98

#: Nodes of the mean over what a point covers.
_NODES = np.linspace(-4.0, 4.0, 161)

_SKEW = np.array([[1.0, 0.0], [-1.0 / math.sqrt(3.0), 2.0 / math.sqrt(3.0)]])
_A, _C = np.uint32(1664525), np.uint32(1013904223)


@dataclass(frozen=True, eq=False)
class HexTiles:
    """PBR maps as they are blended.

    Attributes
    ----------
    levels : as `engine.render.mip_maps`: base colour, and roughness, metallic and f0, as Gaussian numbers; normals; the
        products of their components.
    tables : (levels, 2, ENTRIES, 3) values of the Gaussian numbers from −`REACH` to `REACH`.
    mean_normal : (3,) the mean of the normals.
    """

    levels: Levels
    tables: NDArray[np.float32]
    mean_normal: Array


def hex_tiles_of_scene(scene: Scene) -> HexTiles | None:
    """The maps of a scene in hexagonal cells, None where it is tiled otherwise or has no PBR maps."""
    return hex_tiles(scene.pbr) if scene.tiling_mode == "hex" and scene.pbr is not None else None


def hex_tiles(maps: PbrMaps) -> HexTiles:
    """Prepare maps for hex tiling."""
    return hex_tiles_of(pbr_layers(maps))


def hex_tiles_of(layers: NDArray[np.float32]) -> HexTiles:
    """As `hex_tiles`, of the layers (4, H, W, 3) of maps."""
    made, inverse = np.array(layers, np.float32), np.empty((GAUSSIAN_LAYERS, 3, len(_FINE)))
    for layer in range(GAUSSIAN_LAYERS):
        for channel in range(3):
            made[layer, ..., channel], inverse[layer, channel] = gaussianise(layers[layer, ..., channel])
    levels, plain = [made], layers[:GAUSSIAN_LAYERS]
    while max(levels[-1].shape[1:3]) > 1:
        levels.append(np.stack([half(image) for image in levels[-1]]))
    tables = np.empty((len(levels), GAUSSIAN_LAYERS, ENTRIES, 3), np.float32)
    random = np.random.default_rng(1)
    share = _shares(random.random((SAMPLES, 2)))
    for level, images in enumerate(levels):
        plain = plain if level == 0 else np.stack([half(image) for image in plain])
        height, width = images.shape[1:3]
        place = random.random((2, 3 * SAMPLES)) * np.array([[height], [width]])
        place = np.floor(place) + 0.5 if level == 0 else place
        near = [(row * width + column, part) for row, column, part in neighbours(place[0], place[1], height, width)]
        for layer in range(GAUSSIAN_LAYERS):
            for channel in range(3):
                numbers, values = (
                    sum(part * image[layer, ..., channel].ravel()[at] for at, part in near).reshape(-1, 3)
                    for image in (images, plain)
                )
                mean = float(plain[layer, ..., channel].mean(dtype=np.float64))
                lost = math.sqrt(max(1.0 - float(numbers.var()), 0.0)) if level else 0.0
                table = _smooth(inverse[layer, channel], lost)
                # means of values that are far from Gaussian where a point covers some of them would be off
                blended = np.interp((share * numbers).sum(axis=1), _ENTRIES, table)
                linear = mean + (share * (values - mean)).sum(axis=1)
                shifted = table - (blended - linear).mean()
                tables[level, layer, :, channel] = np.clip(shifted, table.min(), table.max())
    return HexTiles(levels, tables, layers[2].mean(axis=(0, 1), dtype=np.float64))


def _shares(uv: Array) -> Array:
    """(N, 3) the factors of deviations from the mean in the cells around `uv`."""
    weight = cells_around(uv, (1, 1))[0]
    return np.asarray(weight / np.sqrt(np.square(weight).sum(axis=1, keepdims=True)))


#: Gaussian numbers at which the values of a channel are kept before they are averaged.
_FINE = np.linspace(-6.0, 6.0, 4001)


def gaussianise(values: NDArray[np.float32]) -> tuple[NDArray[np.float32], Array]:
    """Gaussian numbers (H, W) of the ranks of `values`, with mean 0 and variance 1, and the value of each of `_FINE`.

    Equal values share the mean of their numbers; a channel of one value has the number 0.
    """
    from scipy.special import ndtr, ndtri

    known, at, count = np.unique(values, return_inverse=True, return_counts=True)
    if len(known) == 1:
        return np.zeros(values.shape, np.float32), np.full(len(_FINE), float(known[0]))
    edge = np.concatenate([[0.0], np.cumsum(count) / values.size])
    edge[-1] = 1.0
    density = np.exp(-0.5 * np.square(np.clip(ndtri(edge), -40.0, 40.0))) / math.sqrt(2.0 * math.pi)
    number = (density[:-1] - density[1:]) / np.diff(edge)
    number /= math.sqrt(float((number**2 * count).sum()) / values.size)
    ranked = np.minimum(np.searchsorted(edge[1:], ndtr(_FINE)), len(known) - 1)
    return number[at].reshape(values.shape).astype(np.float32), known[ranked].astype(np.float64)


def _smooth(inverse: Array, deviation: float) -> Array:
    """(ENTRIES,) the means of values about Gaussian numbers with this deviation."""
    if deviation == 0.0:
        return np.asarray(np.interp(_ENTRIES, _FINE, inverse))
    weight = np.exp(-0.5 * _NODES**2)
    places = _ENTRIES[:, None] + deviation * _NODES[None]
    return np.asarray(np.interp(places, _FINE, inverse) @ (weight / weight.sum()))


def cells_around(uv: Array, size: tuple[int, int]) -> tuple[Array, Array]:
    """Weights (N, 3), whose sum is 1, of the cells around `uv` (N, 2) in repeats of the maps, and their shifts
    (N, 3, 2) in repeats: whole texels of maps of `size` (H, W), so that none is smoothed."""
    skewed = (CELLS * uv) @ _SKEW.T
    base = np.floor(skewed)
    x, y = (skewed - base).T
    rest = 1.0 - x - y
    far = (rest <= 0.0).astype(np.float64)
    sign = 2.0 * far - 1.0
    weight = np.stack([-rest * sign, far - y * sign, far - x * sign], axis=1)
    weight = np.maximum(weight, 0.0) ** SHARPNESS
    weight /= weight.sum(axis=1, keepdims=True)
    corners = np.stack([np.stack([far, far], 1), np.stack([far, 1.0 - far], 1), np.stack([1.0 - far, far], 1)], axis=1)
    texels = np.array(size[::-1], np.float64)
    return weight, np.floor(hash_cells((base[:, None] + corners).astype(np.int64)) * texels) / texels


def hash_cells(vertex: NDArray[np.int64]) -> Array:
    """Shifts (…, 2) in [0, 1) of vertices (…, 2): the hash pcg2d (Jarzynski2020), of which 24 bits are taken."""
    x, y = ((vertex[..., axis] & 0xFFFFFFFF).astype(np.uint32) * _A + _C for axis in (0, 1))
    for _ in range(2):
        x = x + y * _A
        y = y + x * _A
        x, y = x ^ (x >> np.uint32(16)), y ^ (y >> np.uint32(16))
    return np.stack([x >> np.uint32(8), y >> np.uint32(8)], axis=-1) / float(1 << 24)


def blend(tiles: HexTiles, uv: Array, detail: Array) -> tuple[Array, Array, Array, Array]:
    """Base colour; roughness, metallic and f0; mean normals; and means of their products, (N, 3) each, at `uv` (N, 2)
    with the mip levels `detail` (N,)."""
    height, width = tiles.levels[0].shape[1:3]
    weight, shift = cells_around(uv, (height, width))
    share = weight / np.sqrt(np.square(weight).sum(axis=1, keepdims=True))
    numbers = np.zeros((GAUSSIAN_LAYERS, len(uv), 3))
    apart, covariance = np.zeros((len(uv), 3)), np.zeros((len(uv), 4))
    for cell in range(3):
        at, own = uv + shift[:, cell], share[:, cell, None]
        for layer in range(GAUSSIAN_LAYERS):
            numbers[layer] += own * filter_levels(tiles.levels, layer, at, detail)
        mean, square = normals_at(tiles.levels, at, detail)
        apart += own * (mean - tiles.mean_normal)
        covariance += own**2 * _covariance(mean, square)
    base, gloss = (_look_up(tiles.tables[:, layer], numbers[layer], detail) for layer in range(GAUSSIAN_LAYERS))
    x, y, _ = (tiles.mean_normal + apart).T
    scale = np.minimum(1.0, STEEPEST / np.maximum(np.hypot(x, y), 1e-12))
    x, y = scale * x, scale * y
    xx, yy, xy, zz = covariance.T
    z = np.sqrt(np.maximum(1.0 - x * x - y * y - xx - yy - zz, 1.0 - STEEPEST**2))
    square = np.stack([xx + x * x, yy + y * y, xy + x * y], axis=1)
    return base, gloss, np.stack([x, y, z], axis=1), square


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


def _look_up(tables: NDArray[Any], numbers: Array, detail: Array) -> Array:
    """(N, 3) the values of Gaussian numbers (N, 3), linear between entries and levels (levels, ENTRIES, 3)."""
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
