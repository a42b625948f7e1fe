"""Maps at full resolution in tiles, for a page that zooms: a pyramid of levels, each half as large as the one before.

A tile is an image of 8 bits of at most `TILE` texels a side, with a `MARGIN` of its neighbours on each side, across
the edges of a map that repeats. Scale of a power law is in codes of sRGB of its largest value. Its exponents K are the
codes

    c = 1 + 254 ln(K / low) / ln(high / low),    0 for K = 0,

because an error of K changes s^K by at most 1 / (e K) of it: a step of the codes is then the same share of radiance
everywhere. Planes are 8 bits as they are. Coding a power law is bound by PNG, some 20 MB/s of pixels a core.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from engine.core.colour import srgb_decode, srgb_encode
from engine.shading.directional.planes import DirectionalMap
from engine.shading.power_law import PowerLawMap

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
