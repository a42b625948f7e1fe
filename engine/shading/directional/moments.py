"""Second moments of photographs over texels, from which the errors of all linear representations follow.

A representation is linear where it predicts a photograph by a weighted sum of others, or of projections of texels on
a few vectors. Its error over a whole capture is then a quadratic form of these moments: leaving each photograph out in
turn reads no pixel again. Values are codes of 8-bit sRGB as real numbers, 255 at the white level and more above it, in
which tools for domes state their errors.

Bound by one product of matrices, (3 N)² multiplications for each texel. Where a code of a file tells the value by
itself, as of 8 bits under distant lamps, photographs are read by one table for each channel.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.capture.coded_pixels import FEW_PIXELS, CodedRadiance
from engine.capture.object_part import object_mask
from engine.capture.stack import ImageStack
from engine.core.colour import srgb_encode
from engine.core.side_by_side import side_by_side
from engine.core.steps import Step, Steps
from engine.shading.directional.codes_kernel import look_up_codes, write_codes

Array = NDArray[np.float64]

#: Values of all photographs in a block of rows, 4 MB in single precision, about what the cache of a core holds.
BLOCK_VALUES = 1 << 20

#: Bytes of codes of all photographs that are read at once: each reading takes as long as 100 kB.
PIECE_BYTES = 1 << 23

#: Texels that are enough: half of 800 × 800 would give errors to two thousandths.
TEXELS = 1 << 19

#: Entries of the table of codes over the square root of radiance, and the radiance where it ends.
ENTRIES, BRIGHTEST = 1 << 14, 64.0

_TABLE = (255.0 * srgb_encode(np.linspace(0.0, np.sqrt(BRIGHTEST), ENTRIES) ** 2)).astype(np.float32)


@dataclass(frozen=True, eq=False)
class Moments:
    """Moments of texels x of N photographs, 3 N values photograph by photograph.

    Attributes
    ----------
    mean : (3 N,) of x over texels.
    second : (3 N, 3 N) mean of x xᵀ.
    """

    mean: Array
    second: Array

    @property
    def covariance(self) -> Array:
        return self.second - np.outer(self.mean, self.mean)

    def average_channels(self) -> Array:
        """(N, N) second moments of photographs, the mean of the three channels."""
        count = len(self.mean) // 3
        return np.einsum("icjc->ij", self.second.reshape(count, 3, count, 3)) / 3.0


def moments(stack: ImageStack, used: NDArray[np.int64]) -> Steps[Moments]:
    """Moments of the photographs `used` of a stack, over evenly spaced rows of at least `TEXELS` texels if there are.

    Of a stack that shows an object alone they are over its texels. Every `step`-th row alone is read. Sums are taken
    about the mean of the first block, which single precision suffices for.
    """
    _, height, width = stack.radiance.shape[:3]
    step = max(1, height * width // TEXELS)
    size = 3 * len(used)
    mask = object_mask(stack)
    inside = np.ones((height, width), np.bool_) if mask is None else mask
    blocks = [rows for rows in row_blocks(height, width, len(used), step) if inside[slice(*rows)].any()]
    if not blocks:  # an object that lies between the rows
        blocks = [rows for rows in row_blocks(height, width, len(used)) if inside[slice(*rows)].any()]

    def take_shown(reader: TexelReader, rows: tuple[int, int]) -> NDArray[np.float32]:
        ((_, _, block),) = reader.read_blocks(*rows)
        return block if mask is None else np.ascontiguousarray(block[:, mask[slice(*rows)].ravel()])

    pivot = take_shown(make_reader(stack, used), blocks[0]).mean(axis=1, dtype=np.float64).astype(np.float32)
    about_pivot = make_reader(stack, used, pivot)

    def sums(rows: tuple[int, int]) -> tuple[int, NDArray[np.float32], NDArray[np.float32]]:
        block = take_shown(about_pivot, rows)
        return rows[1], block @ np.ones(block.shape[1], np.float32), block @ block.T

    total, second = np.zeros(size), np.zeros((size, size))
    with closing(side_by_side(sums, blocks)) as found:
        for last, of_values, of_products in found:
            total += of_values
            second += of_products
            yield Step(last / height, "comparing photographs")
    count = sum(int(inside[first:last].sum()) for first, last in blocks)
    apart, about = total / count, second / count
    middle = pivot.astype(np.float64)
    across = np.outer(middle, apart)
    return Moments(middle + apart, about + across + across.T + np.outer(middle, middle))


def row_blocks(height: int, width: int, photographs: int, step: int = 1) -> Iterator[tuple[int, int]]:
    """The first row of each block and the row after its last; with a `step`, blocks of one row, that far apart."""
    rows = _block_rows(width, photographs) if step == 1 else 1
    for first in range((step - 1) // 2, height, max(step, rows)):
        yield first, min(first + rows, height)


def _block_rows(width: int, photographs: int) -> int:
    return max(1, BLOCK_VALUES // (3 * photographs * width))


@dataclass(frozen=True, eq=False)
class TexelReader:
    """Texels of the photographs `used` of a stack, codes of sRGB to 0.002 less `pivot` (3 N,), block by block.

    `tables` (3 N, 256) float32 are the values of codes in files, where these tell them.
    """

    stack: ImageStack
    used: NDArray[np.int64]
    pivot: NDArray[np.float32]
    tables: NDArray[np.float32] | None

    def list_pieces(self) -> Iterator[tuple[int, int]]:
        """The first row and the one after the last of pieces of whole blocks, each of which is best read at once."""
        _, height, width = self.stack.radiance.shape[:3]
        rows, line = _block_rows(width, len(self.used)), len(self.used) * width
        if self.tables is not None:
            rows *= max(1, PIECE_BYTES // (3 * line * rows))
        elif isinstance(self.stack.radiance, CodedRadiance):
            rows *= max(1, FEW_PIXELS // (line * rows))
        return ((first, min(first + rows, height)) for first in range(0, height, rows))

    def read_blocks(self, first: int, last: int) -> Iterator[tuple[int, int, NDArray[np.float32]]]:
        """The first row, the one after the last, and the texels (3 N, texels) of each block of the rows from `first` to
        before `last`; the next block lies in the memory of the one before it."""
        count, width = len(self.used), self.stack.radiance.shape[2]
        rows = _block_rows(width, count)
        memory = np.empty(3 * count * min(rows, last - first) * width, np.float32)
        if self.tables is not None:
            assert isinstance(self.stack.radiance, CodedRadiance)
            assert self.stack.radiance.codes is not None
            pixels = self.stack.radiance.codes[self.used, first:last]
        else:
            radiance = np.ascontiguousarray(self.stack.radiance[self.used, first:last]).reshape(count, -1, 3)
        for start in range(first, last, rows):
            stop = min(start + rows, last)
            found = memory[: 3 * count * (stop - start) * width].reshape(3 * count, -1)
            if self.tables is not None:
                look_up_codes(pixels, start - first, stop - first, self.tables, found)
            else:
                first_texel = (start - first) * width
                write_codes(radiance, first_texel, _TABLE, np.float32(BRIGHTEST), self.pivot, found)
            yield start, stop, found


def make_reader(stack: ImageStack, used: NDArray[np.int64], pivot: NDArray[np.float32] | None = None) -> TexelReader:
    """The reader of the photographs `used` of a stack."""
    pivot = np.zeros(3 * len(used), np.float32) if pivot is None else pivot
    radiance = stack.radiance.tabulate(used) if isinstance(stack.radiance, CodedRadiance) else None
    if radiance is None:
        return TexelReader(stack, used, pivot, None)
    tables = np.empty((3 * len(used), radiance.shape[1]), np.float32)
    write_codes(radiance, 0, _TABLE, np.float32(BRIGHTEST), pivot, tables)
    return TexelReader(stack, used, pivot, tables)
