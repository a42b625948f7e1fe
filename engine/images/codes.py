"""Integer codes to linear light in one pass, with the mask of what is at full scale.

Decoders run it in their child. Whoever needs an image again later keeps its codes (`Coded`), a quarter of the linear
image or less, and decodes rows of them when they are needed, with the same bits.
Cost: bound by memory: 24 megapixels of 16-bit colour 0.15 s on one thread.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.core.kernels import only, scalar
from engine.storage.file_array import Plane


@dataclass(frozen=True, eq=False)
class Coded:
    """Codes of an image, and how linear light is made of them.

    Attributes
    ----------
    codes : (H, W, 3) uint8 or uint16, upright; (H, W, 1) of grey images. In memory, or in a file.
    tables : (1, N) or (3, N) float32, light by code for all or for each channel, of every code of the type of `codes`.
    white : code at which a channel is saturated.
    matrix : (3, 3) float32 that is applied to the light, or None.

    Raises TypeError for arrays that do not fit together.
    """

    codes: NDArray[np.unsignedinteger] | Plane
    tables: NDArray[np.float32]
    white: int
    matrix: NDArray[np.float32] | None = None

    def __post_init__(self) -> None:
        codes = self.codes if isinstance(self.codes, Plane) else np.asarray(self.codes)
        shape, dtype = codes.shape, codes.dtype
        if dtype not in (np.uint8, np.uint16) or len(shape) != 3 or shape[2] not in (1, 3):
            raise TypeError(f"codes of {dtype} {shape}")
        shapes = [(number, 256**dtype.itemsize) for number in (1, 3)]
        for name, array, known in (("tables", self.tables, shapes), ("matrix", self.matrix, [(3, 3)])):
            if array is not None and (np.asarray(array).dtype != np.float32 or np.shape(array) not in known):
                raise TypeError(f"{name} of {np.asarray(array).dtype} {np.shape(array)}")
        if not isinstance(self.white, int):
            raise TypeError("a white level that is no code")

    def linear(self, first: int, last: int) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
        """Light (rows, W, 3) of the rows [first, last), and where it is saturated (rows, W)."""
        rows = self.codes[first:last]
        samples = np.broadcast_to(rows, (*rows.shape[:2], 3))
        pixels, saturated = np.empty(samples.shape, np.float32), np.empty(samples.shape[:2], np.bool_)
        decode(samples, self.tables, self.matrix, self.white, pixels, saturated)
        return pixels, saturated


@scalar
def decode_codes(samples: np.ndarray, table: np.ndarray, white: int, pixels: np.ndarray, saturated: np.ndarray) -> None:
    """Fill `pixels` (H, W, 3) with `table[code]`, and `saturated` (H, W) where a code is `white` or above.

    `samples` are (H, W, 3) unsigned codes, all of which `table` holds.
    """
    for row in range(samples.shape[0]):
        for column in range(samples.shape[1]):
            full = False
            for channel in range(3):
                code = samples[row, column, channel]
                full = full or code >= white
                pixels[row, column, channel] = table[code]
            saturated[row, column] = full


@scalar
def decode_colours(
    samples: np.ndarray,
    tables: np.ndarray,
    matrix: np.ndarray,
    white: int,
    pixels: np.ndarray,
    saturated: np.ndarray,
) -> None:
    """As `decode_codes`, by a table for each channel, (3, N), and then the matrix (3, 3) of the colours."""
    for row in range(samples.shape[0]):
        for column in range(samples.shape[1]):
            red, green, blue = samples[row, column, 0], samples[row, column, 1], samples[row, column, 2]
            saturated[row, column] = red >= white or green >= white or blue >= white
            r, g, b = tables[0, red], tables[1, green], tables[2, blue]
            for channel in range(3):
                pixels[row, column, channel] = matrix[channel, 0] * r + matrix[channel, 1] * g + matrix[channel, 2] * b


def decode(
    samples: NDArray[np.unsignedinteger],
    tables: NDArray[np.float32],
    matrix: NDArray[np.float32] | None,
    white: int,
    pixels: NDArray[np.float32],
    saturated: NDArray[np.bool_],
) -> None:
    """Fill `pixels` (H, W, 3) and `saturated` (H, W) from codes (H, W, 3) as `Coded` describes it."""
    if matrix is None and len(tables) == 1:
        decode_codes(samples, tables[0], white, pixels, saturated)
        return
    matrix = np.eye(3, dtype=np.float32) if matrix is None else matrix
    decode_colours(samples, np.broadcast_to(tables, (3, tables.shape[1])), matrix, white, pixels, saturated)


def prepare() -> None:
    """Compile for every kind of samples, before the process gives up what compiling needs."""
    first, rest = "Array({}, 3, 'A', readonly=True)", "int64, Array(float32, 3, 'C'), Array(bool_, 2, 'C')"
    colours = "Array(float32, 2, 'A', readonly=True), Array(float32, 2, 'C')"
    kinds = [first.format(code) for code in ("uint8", "uint16")]
    only(decode_codes, *(f"void({samples}, Array(float32, 1, 'C'), {rest})" for samples in kinds))
    only(decode_colours, *(f"void({samples}, {colours}, {rest})" for samples in kinds))
