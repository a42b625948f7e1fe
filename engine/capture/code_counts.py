"""Numbers of pixels by their codes, from which the tally of a photograph follows whatever is found of its lamp later.

Photographs are counted while their codes are written. What a rig makes of them is known at the end, and then needs no
code again: a channel of 8 bits has 256 values, and what is black has the lowest codes of all three.
Cost: 3 ns a pixel, bound by the counters; 250 kB a photograph, most of it the codes of the grid.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from engine.capture.report import BLACK
from engine.capture.tally import LUMINANCE32, Tally
from engine.core.kernels import scalar

#: Codes of red, green and blue, below which pixels are counted by all three together: enough for what is black where
#: photographs are coded as sRGB or linear and gains are above a quarter.
DARK = (16, 8, 32)

#: Bits of a number in double precision, and of one in single precision.
_BITS, _BITS32 = 53, 24


@dataclass(eq=False)
class CodeCounts:
    """Numbers of pixels of a photograph of 8 bits in which `white` is saturated, of every `step`-th of which codes are
    kept.

    Attributes
    ----------
    of_channels : (3, 256) by the code of each channel. of_dark : `DARK`, by all codes.
    clipped : of which a channel is at white or above. width : pixels of a row. grid : codes (h, w, 1 or 3) of bands.
    """

    white: int
    step: int
    width: int
    clipped: int = 0
    of_channels: NDArray[np.int64] = field(default_factory=lambda: np.zeros((3, 256), np.int64))
    of_dark: NDArray[np.int64] = field(default_factory=lambda: np.zeros(DARK, np.int64))
    grid: list[NDArray[np.uint8]] = field(default_factory=list)

    def add(self, codes: NDArray[np.uint8], first: int) -> None:
        """Count the band (rows, W, 1 or 3) that begins at row `first` of the image."""
        codes = np.require(codes, requirements=["C", "W"])
        self.clipped += int(_count(codes, self.white, self.of_channels, self.of_dark))
        self.grid.append(codes[-first % self.step :: self.step, :: self.step].copy())

    def tally(self, tables: NDArray[np.float32]) -> Tally | None:
        """The tally of the radiance that `tables` (3, 256) have of each channel, bit for bit that of the pixels.

        None where the sum of a row in double precision would depend on its order, or black pixels were not counted.
        """
        lit, weights = self.of_channels > 0, LUMINANCE32[:, None]
        used = np.abs(tables[lit & (tables != 0.0)])
        if used.size and not self._is_exact(used):
            return None
        bright = [np.all(row[least:] >= np.float32(BLACK)) for row, least in zip(tables * weights, DARK, strict=True)]
        if not all(bright) or (tables < 0.0).any():
            return None
        red, green, blue = (row[:least] * weight for row, least, weight in zip(tables, DARK, LUMINANCE32, strict=True))
        luminance = red[:, None, None] + green[:, None] + blue
        black = int(self.of_dark[luminance < np.float32(BLACK)].sum())
        sums = [math.fsum(each) for each in self.of_channels * tables.astype(np.float64)]
        tally = Tally(self.step)
        for codes in self.grid:
            tally.grid.append(
                np.stack([tables[at, codes[..., min(at, codes.shape[2] - 1)]] for at in range(3)], axis=-1)
            )
        tally.rows, tally.clipped, tally.black = [np.array([sums])], self.clipped, black
        return tally

    def _is_exact(self, used: NDArray[np.float32]) -> bool:
        """True where sums of a row, and products with numbers of pixels, are whole multiples of one unit that double
        precision holds."""
        unit = math.ldexp(1.0, math.frexp(float(used.min()))[1] - _BITS32)
        products = int(self.of_channels.max()) < 1 << (_BITS - _BITS32)
        return products and self.width * float(used.max()) < math.ldexp(unit, _BITS)


@scalar
def _count(codes: np.ndarray, white: int, of_channels: np.ndarray, of_dark: np.ndarray) -> int:
    """Bound by the counters: one that follows another of the same code waits for it."""
    second, third = min(1, codes.shape[2] - 1), codes.shape[2] - 1
    clipped = 0
    for row in range(codes.shape[0]):
        for column in range(codes.shape[1]):
            red, green, blue = codes[row, column, 0], codes[row, column, second], codes[row, column, third]
            of_channels[0, red] += 1
            of_channels[1, green] += 1
            of_channels[2, blue] += 1
            clipped += max(red, green, blue) >= white
            if red < of_dark.shape[0] and green < of_dark.shape[1] and blue < of_dark.shape[2]:
                of_dark[red, green, blue] += 1
    return clipped
