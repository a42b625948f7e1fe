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


def prepare() -> None:
    """Compile for every kind of samples, before the process gives up what compiling needs."""
    rest = "Array(float32, 1, 'C'), int64, Array(float32, 3, 'C'), Array(bool_, 2, 'C')"
    only(decode_codes, *(f"void(Array({code}, 3, 'A', readonly=True), {rest})" for code in ("uint8", "uint16")))
