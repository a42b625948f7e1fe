"""Integer codes to linear light in one pass, with the mask of what is at full scale. Runs in the decoder child.

Cost: bound by memory: 24 megapixels of 16-bit colour 0.15 s on one thread.
"""

from __future__ import annotations

import numpy as np

from engine.core.kernels import only, scalar


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


def prepare() -> None:
    """Compile for every kind of samples, before the process gives up what compiling needs."""
    first, rest = "Array({}, 3, 'A', readonly=True)", "int64, Array(float32, 3, 'C'), Array(bool_, 2, 'C')"
    colours = "Array(float32, 2, 'A', readonly=True), Array(float32, 2, 'C')"
    kinds = [first.format(code) for code in ("uint8", "uint16")]
    only(decode_codes, *(f"void({samples}, Array(float32, 1, 'C'), {rest})" for samples in kinds))
    only(decode_colours, *(f"void({samples}, {colours}, {rest})" for samples in kinds))
