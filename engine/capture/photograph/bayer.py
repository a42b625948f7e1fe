"""Bayer mosaics to linear colour in one pass: levels, saturation, interpolation and colour matrix.

Malvar2004, "High-quality linear interpolation for demosaicing of Bayer-patterned color images", figure
2. The filters are linear and samples keep their sign, so noise that averages to black still does after them. Beyond
the edges the mosaic is mirrored about its outermost rows and columns, which keeps the pattern.

Decoders answer with the mosaic itself (`Mosaic`), a sixth of the bytes of the pixels, which their parent makes of it.
Cost: bound by arithmetic, 10 ns per pixel on one thread; besides its result it needs memory for five rows only.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.capture.photograph import radiometry
from engine.core.errors import UsageError
from engine.core.kernels import only, scalar
from engine.images.exif import orient

_HALF, _TWO, _FOUR, _FIVE, _SIX = (np.float32(value) for value in (0.5, 2, 4, 5, 6))
_SIDE, _EIGHTH = np.float32(1.5), np.float32(0.125)

#: The orientation that undoes another, where that is not itself.
_INVERSE = {6: 8, 8: 6}


@dataclass(frozen=True, eq=False)
class Mosaic:
    """Samples of a sensor, and how linear light is made of them.

    Attributes
    ----------
    samples : (H, W) uint16 as the sensor lies, H and W ≥ 3.
    black, white : (2, 2) levels of each site.
    colours : (2, 2) of 0, 1, 2 for red, green, blue of each site.
    matrix : (3, 3) float32 from the camera's colours to linear sRGB.
    orientation : EXIF orientation by which the image is upright.

    Raises TypeError for what does not fit together, since decoders of hostile files answer with it.
    """

    samples: NDArray[np.uint16]
    black: NDArray[np.float64]
    white: NDArray[np.float64]
    colours: NDArray[np.int64]
    matrix: NDArray[np.float32]
    orientation: int

    def __post_init__(self) -> None:
        tables = ((self.black, np.float64), (self.white, np.float64), (self.colours, np.int64))
        if self.samples.dtype != np.uint16 or self.samples.ndim != 2 or min(self.samples.shape) < 3:
            raise TypeError(f"samples of {self.samples.dtype} {self.samples.shape}")
        if any(array.dtype != dtype or array.shape != (2, 2) for array, dtype in tables) or not is_bayer(self.colours):
            raise TypeError("levels or colours that are not those of a Bayer mosaic")
        if self.matrix.dtype != np.float32 or self.matrix.shape != (3, 3) or self.orientation not in range(1, 9):
            raise TypeError("a matrix or an orientation that is none")
        try:
            radiometry.level_scale(self.black, self.white)
        except UsageError as error:
            raise TypeError(str(error)) from None

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width of the upright image."""
        height, width = self.samples.shape
        return (width, height) if self.orientation >= 5 else (height, width)

    def develop_into(self, radiance: NDArray[np.float32], saturated: NDArray[np.bool_]) -> None:
        """Fill arrays with upright linear sRGB (H, W, 3), 1 = white level, and where it is saturated (H, W)."""
        turned = (turn_back(array, self.orientation) for array in (radiance, saturated))
        scale = radiometry.level_scale(self.black, self.white)
        samples = self.samples.view()
        samples.flags.writeable = False  # as the kernel has been compiled
        develop(samples, self.black, scale, self.white, self.colours, self.matrix, *turned)


def turn_back(image: NDArray[Any], orientation: int) -> NDArray[Any]:
    """An upright image as it lies in a file of this EXIF orientation (a view)."""
    return orient(image, _INVERSE.get(orientation, orientation))


def is_bayer(colours: NDArray[np.integer]) -> bool:
    """True for a 2×2 array of 0, 1, 2 (red, green, blue) with two greens on a diagonal."""
    if colours.shape != (2, 2) or sorted(colours.ravel()) != [0, 1, 1, 2]:
        return False
    return bool(colours[0, 0] == colours[1, 1] == 1 or colours[0, 1] == colours[1, 0] == 1)


@scalar
def develop(
    samples: np.ndarray,
    black: np.ndarray,
    scale: np.ndarray,
    white: np.ndarray,
    colours: np.ndarray,
    matrix: np.ndarray,
    radiance: np.ndarray,
    saturated: np.ndarray,
) -> None:
    """Fill `radiance` (H, W, 3) and `saturated` (H, W) from `samples` (H, W), integers or floats, H and W ≥ 3.

    A sample s of the site (i, j) stands for (s - black[i, j]) scale[i, j] of the colour colours[i, j]; it is saturated
    from white[i, j] on, and so is every pixel within two steps of it, which it enters. `matrix` (3, 3) float32 takes
    the camera's colours to those of the result. Tables are (2, 2) and repeat from row 0, column 0.
    """
    height, width = samples.shape
    lines = np.zeros((5, 2, width // 2 + 3), np.float32)
    clipped = np.zeros((5, width + 4), np.bool_)
    any_clipped = np.zeros(5, np.bool_)
    planes = np.empty((3, width // 2 + 1), np.float32)
    for row in range(-2, height + 2):
        slot = (row + 2) % 5
        any_clipped[slot] = _read(samples, _mirror(row, height), black, scale, white, lines[slot], clipped[slot])
        if row >= 2:
            at = row - 2
            for parity in range(2):
                colour, beside, across = (
                    colours[at % 2, parity],
                    colours[at % 2, 1 - parity],
                    colours[1 - at % 2, parity],
                )
                count = (width + 1 - parity) // 2
                _interpolate(lines, at, parity, colour == 1, count, planes)
                if colour == 1:
                    _mix(planes, matrix[:, beside], matrix[:, 1], matrix[:, across], count, radiance[at, parity::2])
                else:
                    _mix(planes, matrix[:, colour], matrix[:, 1], matrix[:, 2 - colour], count, radiance[at, parity::2])
            if any_clipped.any():
                a, b, c, d, e = at % 5, (at + 1) % 5, (at + 2) % 5, (at + 3) % 5, (at + 4) % 5
                _spread(clipped[a], clipped[b], clipped[c], clipped[d], clipped[e], saturated[at])
            else:
                saturated[at, :] = False


@scalar
def _mirror(place: int, size: int) -> int:
    return abs(place) if place < size else 2 * (size - 1) - place


@scalar
def _read(
    samples: np.ndarray,
    row: int,
    black: np.ndarray,
    scale: np.ndarray,
    white: np.ndarray,
    line: np.ndarray,
    clipped: np.ndarray,
) -> bool:
    """Linear values of one row and two mirrored ones at either end, and whether any is saturated.

    Column x lies at line[x % 2, x // 2 + 1] and clipped[x + 2].
    """
    width = samples.shape[1]
    some = 0
    for parity in range(2):
        dark, gain, full = black[row % 2, parity], scale[row % 2, parity], white[row % 2, parity]
        own = line[parity]
        for half in range((width + 1 - parity) // 2):
            sample = samples[row, 2 * half + parity]
            own[half + 1] = np.float32((sample - dark) * gain)
            some += sample >= full
    if some == 0:
        clipped[:] = False
    else:
        for column in range(width):
            clipped[column + 2] = samples[row, column] >= white[row % 2, column % 2]
    for beyond in (-2, -1, width, width + 1):
        inside = _mirror(beyond, width)
        line[beyond % 2, (beyond + 2) // 2] = line[inside % 2, inside // 2 + 1]
        clipped[beyond + 2] = clipped[inside + 2]
    return some > 0


@scalar
def _interpolate(lines: np.ndarray, at: int, parity: int, green: bool, count: int, planes: np.ndarray) -> None:
    """The three colours of the columns of one `parity` of row `at`.

    At green: the colour of its row, green, the colour of its column; else its own colour, green, the opposite one.
    """
    a, b, c, d, e = at % 5, (at + 1) % 5, (at + 2) % 5, (at + 3) % 5, (at + 4) % 5
    other = 1 - parity
    above, over, own, under, below = (
        lines[a, parity],
        lines[b, parity],
        lines[c, parity],
        lines[d, parity],
        lines[e, parity],
    )
    over_beside, beside, under_beside = lines[b, other], lines[c, other], lines[d, other]
    first, second, third = planes[0], planes[1], planes[2]
    for x in range(count):
        middle = own[x + 1]
        near_row, near_column = beside[x + parity] + beside[x + parity + 1], over[x + 1] + under[x + 1]
        far_row, far_column = own[x] + own[x + 2], above[x + 1] + below[x + 1]
        diagonal = (over_beside[x + parity] + over_beside[x + parity + 1]) + (
            under_beside[x + parity] + under_beside[x + parity + 1]
        )
        if green:
            first[x] = (_FIVE * middle + _FOUR * near_row - diagonal - far_row + _HALF * far_column) * _EIGHTH
            second[x] = middle
            third[x] = (_FIVE * middle + _FOUR * near_column - diagonal - far_column + _HALF * far_row) * _EIGHTH
        else:
            first[x] = middle
            second[x] = (_FOUR * middle + _TWO * (near_row + near_column) - far_row - far_column) * _EIGHTH
            third[x] = (_SIX * middle + _TWO * diagonal - _SIDE * (far_row + far_column)) * _EIGHTH


@scalar
def _mix(
    planes: np.ndarray, one: np.ndarray, two: np.ndarray, three: np.ndarray, count: int, result: np.ndarray
) -> None:
    """`planes` times the columns `one`, `two`, `three` of the colour matrix."""
    first, second, third = planes[0], planes[1], planes[2]
    for channel in range(3):
        m, n, o = one[channel], two[channel], three[channel]
        for x in range(count):
            result[x, channel] = m * first[x] + n * second[x] + o * third[x]


@scalar
def _spread(a: np.ndarray, b: np.ndarray, c: np.ndarray, d: np.ndarray, e: np.ndarray, result: np.ndarray) -> None:
    for column in range(result.shape[0]):
        x = column + 2
        near = b[x - 1] or b[x] or b[x + 1] or d[x - 1] or d[x] or d[x + 1] or c[x - 1] or c[x] or c[x + 1]
        result[column] = near or c[x - 2] or c[x + 2] or a[x] or e[x]


def prepare() -> None:
    """Compile for results that are upright and turned; later the process may not write the code."""
    levels = ", ".join(["Array(float64, 2, 'C')"] * 3)
    tables = f"{levels}, Array(int64, 2, 'C'), Array(float32, 2, 'C')"
    results = (f"Array(float32, 3, '{layout}'), Array(bool_, 2, '{layout}')" for layout in "CA")
    only(develop, *(f"void(Array(uint16, 2, 'C', readonly=True), {tables}, {result})" for result in results))
