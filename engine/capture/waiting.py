"""Lights that wait until all photographs have been read, because what is done to them depends on all.

The photograph of a light waits as pixels in a scratch file; or, where its pixels follow from the codes of the file,
as these, which are a quarter of it or less. What a calibration found is taken off as pixels are taken out again, so
that nothing is written twice.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.capture.photograph.bayer import Mosaic
from engine.images.codes import Coded
from engine.storage.scratch import release

Radiance = NDArray[np.float32]
Saturated = NDArray[np.bool_]

#: Correction in place of rows of radiance and saturation, from a row of the photograph on.
CalibrateRows = Callable[[Radiance, Saturated, int], None]

#: Bytes of a pixel: three numbers of radiance in single precision, and one that says where it is clipped; of a pair
#: the same of the crossed photograph, which is clipped where its fellow is.
PIXEL_BYTES, PAIR_BYTES = 13, 25


@dataclass(frozen=True, eq=False)
class Pixels:
    """Pixels of a photograph, in memory or in a scratch file.

    Attributes
    ----------
    radiance : (H, W, 3), `saturated` : (H, W).
    """

    radiance: Radiance
    saturated: Saturated

    @property
    def height(self) -> int:
        return len(self.saturated)

    @property
    def size_bytes(self) -> int:
        return self.radiance.nbytes + self.saturated.nbytes

    def rows(self, first: int, last: int, to_change: bool = False) -> tuple[Radiance, Saturated]:
        """Radiance and saturation of the rows [first, last); a copy of the radiance where it is `to_change`."""
        radiance = self.radiance[first:last]
        return radiance.copy() if to_change else radiance, self.saturated[first:last]

    def release(self) -> None:
        """Let the system reclaim the memory of what is mapped."""
        release(self.radiance)
        release(self.saturated)


@dataclass(frozen=True, eq=False)
class CodedPixels:
    """Codes of a photograph, and what is done to rows of the light that is made of them; otherwise as `Pixels`."""

    coded: Coded | Mosaic
    calibrate: CalibrateRows

    @property
    def height(self) -> int:
        return len(self.coded.codes)

    @property
    def size_bytes(self) -> int:
        return self.coded.codes.nbytes

    def rows(self, first: int, last: int, to_change: bool = False) -> tuple[Radiance, Saturated]:
        radiance, saturated = self.coded.linear(first, last)
        self.calibrate(radiance, saturated, first)
        return radiance, saturated

    def release(self) -> None:
        release(self.coded.codes)


@dataclass(frozen=True, eq=False)
class WaitingLight:
    """The photograph of a light, and of pairs the `crossed` one (H, W, 3), which is saturated where its fellow is.

    It `stays` where somebody else keeps the pixels too, so that no room comes free when the light is written.
    """

    pixels: Pixels | CodedPixels
    crossed: Pixels | None = None
    stays: bool = False

    @property
    def size_bytes(self) -> int:
        """Bytes of memory or of scratch files."""
        return self.pixels.size_bytes + (0 if self.crossed is None else self.crossed.radiance.nbytes)

    def release(self) -> None:
        """Let the system reclaim the memory of what is mapped."""
        self.pixels.release()
        if self.crossed is not None:
            self.crossed.release()
