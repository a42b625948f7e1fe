"""Tiles of a compressed shading map that keep their slices, because a power law describes them too badly.

Tiles are squares of `size` texels on a grid that begins at the upper left texel; those at the right and lower edge may
reach beyond the map. Where a look-up touches texels of both kinds, the kept ones are filtered as slices, the power law
as two textures, and each counts with the weight of its own texels: so a map with no kept tile is the power law and a
map of kept tiles alone is the shading map, bit for bit.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.shading.lookup import Numbers, layer_at, neighbours


@dataclass(frozen=True, eq=False)
class KeptTiles:
    """The slices of M tiles.

    Attributes
    ----------
    place : (rows, columns) int32 of the grid, the place of each tile in `slices`, which go row by row; -1 for those
        that are not kept.
    slices : (M, S, size, size, 3) float32, M >= 1; 0 beyond the map.
    """

    place: NDArray[np.int32]
    slices: NDArray[np.float32]

    def __post_init__(self) -> None:
        shape = self.slices.shape
        if len(shape) != 5 or shape[1] < 2 or shape[2] != shape[3] or shape[4] != 3 or 0 in shape:
            raise ValueError(f"tiles must be (M, S >= 2, size, size, 3), not {shape}")
        if not np.array_equal(self.place[self.place >= 0], np.arange(shape[0])):
            raise ValueError(f"the grid does not hold each of the {shape[0]} tiles once, row by row")
        for name in ("place", "slices"):
            view = getattr(self, name).view()
            view.flags.writeable = False
            object.__setattr__(self, name, view)

    @property
    def size(self) -> int:
        """Texels along the side of a tile."""
        return self.slices.shape[2]

    def covers(self, height: int, width: int) -> NDArray[np.bool_]:
        """(height, width) bool, True for the texels of kept tiles."""
        kept = np.repeat(np.repeat(self.place >= 0, self.size, axis=0), self.size, axis=1)
        return kept[:height, :width]

    def over(
        self, power_law: Numbers, row: Numbers, column: Numbers, share: Numbers, shape: tuple[int, int]
    ) -> Numbers:
        """The look-ups `power_law` (..., 3) at texel coordinates, with the kept texels among their neighbours instead.

        `share` is r / r_max in [0, 1], `shape` the height and width of the map.
        """
        lower, fraction = layer_at(share, self.slices.shape[1])
        value, covered, left = np.zeros_like(power_law), np.zeros(share.shape), np.zeros(share.shape)
        for rows, columns, weight in neighbours(row, column, *shape):
            place = self.place[rows // self.size, columns // self.size]
            held = np.where(place >= 0, weight, 0.0)
            covered += held
            left += weight - held
            at = (rows % self.size, columns % self.size)
            value += (held * (1.0 - fraction))[..., None] * self.slices[(place, lower, *at)]
            value += (held * fraction)[..., None] * self.slices[(place, lower + 1, *at)]
        return np.where((covered > 0.0)[..., None], value + left[..., None] * power_law, power_law)

    def image_over(self, power_law: Numbers, share: float) -> Numbers:
        """The whole image `power_law` (H, W, 3) at one share of r_max, with the kept tiles instead."""
        lower, fraction = layer_at(np.float64(share), self.slices.shape[1])
        tiles = (1.0 - fraction) * self.slices[:, int(lower)] + fraction * self.slices[:, int(lower) + 1]
        return np.ascontiguousarray(self._with(power_law, tiles))

    def part_over(self, power_law: Numbers, part: tuple[slice, slice], share: float) -> Numbers:
        """The same of a part of the image, its rows and columns; `power_law` (h, w, 3) is of these."""
        lower, fraction = layer_at(np.float64(share), self.slices.shape[1])
        row, column = ((at.start or 0) + np.arange(size) for at, size in zip(part, power_law.shape[:2], strict=True))
        place = self.place[np.ix_(row // self.size, column // self.size)]
        rows, columns = np.nonzero(place >= 0)
        tile, at = place[rows, columns], (row[rows] % self.size, column[columns] % self.size)
        image = power_law.copy()
        image[rows, columns] = (1.0 - fraction) * self.slices[(tile, int(lower), *at)]
        image[rows, columns] += fraction * self.slices[(tile, int(lower) + 1, *at)]
        return image

    def slice_images(self, height: int, width: int) -> NDArray[np.float32]:
        """(S, height, width, 3) float32: the slices where tiles are kept, 0 elsewhere."""
        black = np.zeros((height, width, 3), np.float32)
        return np.stack([self._with(black, self.slices[:, index]) for index in range(self.slices.shape[1])])

    def _with(self, image: NDArray[np.floating], tiles: NDArray[np.floating]) -> NDArray[np.floating]:
        """The image with tiles (M, size, size, 3) in their places."""
        padded, blocks = _blocks(image, self.size)
        held = self.place >= 0
        blocks[held] = tiles[self.place[held]]
        return padded[: image.shape[0], : image.shape[1]]


def cut_tiles(slices: NDArray[np.float32], kept: NDArray[np.bool_], size: int) -> KeptTiles:
    """The tiles of `slices` (S, H, W, 3) that are True in `kept` (rows, columns) of the grid."""
    place = np.where(kept, np.cumsum(kept).reshape(kept.shape) - 1, -1).astype(np.int32)
    tiles = np.empty((int(kept.sum()), len(slices), size, size, 3), np.float32)
    for index, image in enumerate(slices):
        tiles[:, index] = _blocks(image, size)[1][kept]
    return KeptTiles(place, tiles)


def tile_maxima(values: NDArray[np.float32], size: int) -> NDArray[np.float32]:
    """(rows, columns) the largest of (H, W) values >= 0 in each tile of the grid."""
    largest: NDArray[np.float32] = _blocks(values[..., None], size)[1].max(axis=(2, 3, 4))
    return largest


def grid_shape(height: int, width: int, size: int) -> tuple[int, int]:
    """Rows and columns of the grid of tiles."""
    return -(-height // size), -(-width // size)


def _blocks(image: NDArray[np.floating], size: int) -> tuple[NDArray[np.floating], NDArray[np.floating]]:
    """A copy of the image padded with 0 to whole tiles, and a view of it as (rows, columns, size, size, channels)."""
    rows, columns = grid_shape(image.shape[0], image.shape[1], size)
    padded = np.zeros((rows * size, columns * size, image.shape[2]), image.dtype)
    padded[: image.shape[0], : image.shape[1]] = image
    return padded, padded.reshape(rows, size, columns, size, -1).swapaxes(1, 2)
