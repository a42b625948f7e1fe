"""Second moments of photographs over texels, from which the errors of all linear representations follow.

A representation is linear where it predicts a photograph by a weighted sum of others, or of projections of texels on
a few vectors. Its error over a whole capture is then a quadratic form of these moments: leaving each photograph out in
turn reads no pixel again. Values are codes of 8-bit sRGB as real numbers, 255 at the white level and more above it, in
which tools for domes state their errors.

Bound by one product of matrices, (3 N)² multiplications for each texel.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.capture.stack import ImageStack
from engine.core.colour import srgb_encode
from engine.core.steps import Step, Steps

Array = NDArray[np.float64]

#: Values of all photographs in a block of rows, about 50 MB in single precision.
BLOCK_VALUES = 1 << 23

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

    def of_channels(self) -> Array:
        """(N, N) second moments of photographs, the mean of the three channels."""
        count = len(self.mean) // 3
        return np.einsum("icjc->ij", self.second.reshape(count, 3, count, 3)) / 3.0


def moments(stack: ImageStack, used: NDArray[np.int64]) -> Steps[Moments]:
    """Moments of the photographs `used` of a stack, over evenly spaced rows of at least `TEXELS` texels if there are.

    Every `step`-th row alone is read.
    """
    _, height, width = stack.radiance.shape[:3]
    step = max(1, height * width // TEXELS)
    size = 3 * len(used)
    total, second, pivot = np.zeros(size), np.zeros((size, size)), None
    wanted = np.arange((step - 1) // 2, height, step)
    rows = max(1, BLOCK_VALUES // (size * width)) if step == 1 else 1
    for place in range(0, len(wanted), rows):
        first = int(wanted[place])
        block = texels(stack, used, first, min(first + rows, height))
        if pivot is None:
            pivot = block.mean(axis=1, dtype=np.float64)
        block -= pivot.astype(np.float32)[:, None]
        total += block.sum(axis=1, dtype=np.float64)
        second += block @ block.T
        yield Step(min(first + rows, height) / height, "comparing photographs")
    count = len(wanted) * width
    assert pivot is not None
    pivot = pivot.astype(np.float32).astype(np.float64)
    apart, about = total / count, second / count
    mean = pivot + apart
    across = np.outer(pivot, apart)
    return Moments(mean, about + across + across.T + np.outer(pivot, pivot))


def texels(stack: ImageStack, used: NDArray[np.int64], first: int, last: int) -> NDArray[np.float32]:
    """(3 N, texels) codes of the rows from `first` to before `last`, to 0.002."""
    from engine.shading.directional.codes_kernel import write_codes  # compiled code: loaded when first needed

    radiance = np.ascontiguousarray(stack.radiance[used, first:last])
    found = np.empty((3 * len(used), radiance.shape[1] * radiance.shape[2]), np.float32)
    write_codes(radiance, _TABLE, np.float32(BRIGHTEST), found)
    return found
