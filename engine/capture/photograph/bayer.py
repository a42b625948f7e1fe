"""Bayer mosaics to linear colour in one pass: levels, saturation, interpolation and colour matrix.

Malvar2004, "High-quality linear interpolation for demosaicing of Bayer-patterned color images", figure
2. The filters are linear and samples keep their sign, so noise that averages to black still does after them. Beyond
the edges the mosaic is mirrored about its outermost rows and columns, which keeps the pattern.

Decoders answer with the mosaic itself (`Mosaic`), a sixth of the bytes of the pixels, which their parent makes of it.
Whoever needs pixels again later keeps the mosaic and makes rows of it, with the same bits: a pixel depends on samples
within `MARGIN` of it alone.
Cost: bound by arithmetic, 5 to 10 ns per pixel on one thread; besides its result it needs memory for five rows only.
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
from engine.storage.file_array import Plane

#: Rows and columns around a pixel whose samples enter it.
MARGIN = 2

_HALF, _TWO, _FOUR, _FIVE, _SIX = (np.float32(value) for value in (0.5, 2, 4, 5, 6))
_SIDE, _EIGHTH = np.float32(1.5), np.float32(0.125)

#: The orientation that undoes another, where that is not itself.
_INVERSE = {6: 8, 8: 6}

#: By EXIF orientation, the edges of the upright image (0 top, 1 bottom, 2 left, 3 right) that are the first row and the
#: first column of the sensor.
_FIRST_EDGES = {1: (0, 2), 2: (0, 3), 3: (1, 3), 4: (1, 2), 5: (2, 0), 6: (3, 0), 7: (3, 1), 8: (2, 1)}

#: First row and column of a part of an upright image.
Corner = tuple[int, int]


def find_span(first: int, last: int, size: int, margin: int) -> tuple[int, int]:
    """The rows (or columns) [first, last) of `size` with a `margin` on either side, as far as there is one."""
    return max(0, first - margin), min(size, last + margin)


@dataclass(frozen=True, eq=False)
class Sensor:
    """Levels, colours and orientation of a sensor, by which linear light is made of its samples.

    Attributes
    ----------
    black, white : (2, 2) levels of each site, from the first row and column of the sensor on.
    colours : (2, 2) of 0, 1, 2 for red, green, blue of each site.
    matrix : (3, 3) float32 from the camera's colours to linear sRGB.
    orientation : EXIF orientation by which the image is upright.

    Raises TypeError for what does not fit together, since decoders of hostile files answer with it.
    """

    black: NDArray[np.float64]
    white: NDArray[np.float64]
    colours: NDArray[np.int64]
    matrix: NDArray[np.float32]
    orientation: int

    def __post_init__(self) -> None:
        tables = ((self.black, np.float64), (self.white, np.float64), (self.colours, np.int64))
        if any(array.dtype != dtype or array.shape != (2, 2) for array, dtype in tables) or not is_bayer(self.colours):
            raise TypeError("levels or colours that are not those of a Bayer mosaic")
        if self.matrix.dtype != np.float32 or self.matrix.shape != (3, 3) or self.orientation not in range(1, 9):
            raise TypeError("a matrix or an orientation that is none")
        try:
            radiometry.level_scale(self.black, self.white)
        except UsageError as error:
            raise TypeError(str(error)) from None

    def is_same(self, other: Sensor) -> bool:
        """True where the other gives the same light."""
        names = ("black", "white", "colours", "matrix", "orientation")
        return all(np.array_equal(getattr(self, name), getattr(other, name)) for name in names)

    def develop(
        self,
        samples: NDArray[np.uint16],
        begin: Corner,
        size: tuple[int, int],
        at: Corner,
        radiance: NDArray[np.float32],
        saturated: NDArray[np.bool_],
    ) -> None:
        """Fill arrays with linear sRGB (h, w, 3), 1 = white level, and where it is saturated (h, w), of the part of an
        upright image of `size` that begins `at` a corner.

        `samples` are those of the part that begins at the corner `begin`, upright, with the `MARGIN` around the result
        that the image has.
        """
        lying, origin, start = self._turn_back(samples, begin, size, at, saturated.shape)
        black, white, colours = (_shift(table, origin) for table in (self.black, self.white, self.colours))
        scale = radiometry.level_scale(black, white)
        results = (turn_back(array, self.orientation) for array in (radiance, saturated))
        develop(lying, black, scale, white, colours, self.matrix, start[0], start[1], *results)

    def find_saturated(
        self,
        samples: NDArray[np.uint16],
        begin: Corner,
        size: tuple[int, int],
        at: Corner,
        saturated: NDArray[np.bool_],
    ) -> None:
        """Fill `saturated` alone, as `develop`."""
        lying, origin, start = self._turn_back(samples, begin, size, at, saturated.shape)
        mark(lying, _shift(self.white, origin), start[0], start[1], turn_back(saturated, self.orientation))

    def _turn_back(
        self, samples: NDArray[np.uint16], begin: Corner, size: tuple[int, int], at: Corner, shape: tuple[int, ...]
    ) -> tuple[NDArray[np.uint16], Corner, Corner]:
        """`samples` as they lie on the sensor, the first row and column of that, and those of the result in them."""
        before, within = [], []
        for axis in (0, 1):
            end = begin[axis] + samples.shape[axis]
            before += [begin[axis], size[axis] - end]
            within += [at[axis] - begin[axis], end - at[axis] - shape[axis]]
        row, column = _FIRST_EDGES[self.orientation]
        lying = np.ascontiguousarray(turn_back(samples, self.orientation)).view()
        lying.flags.writeable = False  # as the kernel has been compiled
        return lying, (before[row], before[column]), (within[row], within[column])


@dataclass(frozen=True, eq=False)
class Mosaic:
    """Samples of an image, and the sensor that gave them.

    Attributes
    ----------
    codes : (H, W, 1) uint16, upright, H and W ≥ 3. In memory, or in a file.
    sensor : how linear light is made of them.

    Raises TypeError for other codes.
    """

    codes: NDArray[np.uint16] | Plane
    sensor: Sensor

    def __post_init__(self) -> None:
        shape = self.codes.shape
        if self.codes.dtype != np.uint16 or len(shape) != 3 or min(shape[:2]) < MARGIN + 1 or shape[2] != 1:
            raise TypeError(f"samples of {self.codes.dtype} {shape}")

    @classmethod
    def turn_upright(cls, samples: NDArray[np.uint16], sensor: Sensor) -> Mosaic:
        """The mosaic of samples (H, W) as they lie on the sensor."""
        if samples.ndim != 2:
            raise TypeError(f"samples of {samples.dtype} {samples.shape}")
        return cls(orient(samples, sensor.orientation)[..., None], sensor)

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width of the image."""
        return self.codes.shape[0], self.codes.shape[1]

    def develop_into(self, radiance: NDArray[np.float32], saturated: NDArray[np.bool_], first: int = 0) -> None:
        """Fill arrays with linear sRGB (rows, W, 3), 1 = white level, and where it is saturated (rows, W), from the row
        `first` on."""
        top, bottom = find_span(first, first + len(saturated), len(self.codes), MARGIN)
        samples = self.codes[top:bottom][..., 0]
        self.sensor.develop(samples, (top, 0), self.shape, (first, 0), radiance, saturated)

    def linear(self, first: int, last: int) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
        """Light (rows, W, 3) of the rows [first, last), and where it is saturated (rows, W)."""
        rows, width = range(self.shape[0])[first:last], self.shape[1]
        pixels, saturated = np.empty((len(rows), width, 3), np.float32), np.empty((len(rows), width), np.bool_)
        self.develop_into(pixels, saturated, first)
        return pixels, saturated


def _shift(table: NDArray[Any], origin: Corner) -> NDArray[Any]:
    """A table of sites that repeats, from another row and column on."""
    return np.ascontiguousarray(np.roll(table, (-origin[0], -origin[1]), axis=(0, 1)))


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
    top: int,
    left: int,
    radiance: np.ndarray,
    saturated: np.ndarray,
) -> None:
    """Fill `radiance` (h, w, 3) and `saturated` (h, w) from `samples` (H, W), integers or floats, H and W ≥ 3, of which
    the result shows the part from row `top` and column `left` on.

    A sample s of the site (i, j) stands for (s - black[i, j]) scale[i, j] of the colour colours[i, j]; it is saturated
    from white[i, j] on, and so is every pixel within two steps of it, which it enters. `matrix` (3, 3) float32 takes
    the camera's colours to those of the result. Tables are (2, 2) and repeat from row 0, column 0.
    """
    height, width = samples.shape
    rows, columns = saturated.shape
    lines = np.zeros((5, 2, width // 2 + 3), np.float32)
    clipped = np.zeros((5, width + 4), np.bool_)
    any_clipped = np.zeros(5, np.bool_)
    planes = np.empty((3, columns // 2 + 1), np.float32)
    for row in range(top - 2, top + rows + 2):
        slot = (row + 2) % 5
        any_clipped[slot] = _read(samples, _mirror(row, height), black, scale, white, lines[slot], clipped[slot])
        if row >= top + 2:
            at = row - 2
            result = radiance[at - top]
            for parity in range(2):
                colour, beside, across = (
                    colours[at % 2, parity],
                    colours[at % 2, 1 - parity],
                    colours[1 - at % 2, parity],
                )
                skipped = (left + parity) % 2  # columns of the result before the first of this parity
                start, count = (left + skipped) // 2, (columns + 1 - skipped) // 2
                _interpolate(lines, at, parity, colour == 1, start, count, planes)
                if colour == 1:
                    _mix(planes, matrix[:, beside], matrix[:, 1], matrix[:, across], count, result[skipped::2])
                else:
                    _mix(planes, matrix[:, colour], matrix[:, 1], matrix[:, 2 - colour], count, result[skipped::2])
            _spread_near(clipped, any_clipped, at, left, saturated[at - top])


@scalar
def mark(samples: np.ndarray, white: np.ndarray, top: int, left: int, saturated: np.ndarray) -> None:
    """Fill `saturated` alone, as `develop`. Bound by the read of the samples."""
    height, width = samples.shape
    rows = saturated.shape[0]
    clipped = np.zeros((5, width + 4), np.bool_)
    any_clipped = np.zeros(5, np.bool_)
    for row in range(top - 2, top + rows + 2):
        slot, at = (row + 2) % 5, _mirror(row, height)
        some = 0
        for parity in range(2):
            full = white[at % 2, parity]
            for half in range((width + 1 - parity) // 2):
                some += samples[at, 2 * half + parity] >= full
        any_clipped[slot] = _mark_row(samples, at, white, some, clipped[slot])
        if row >= top + 2:
            _spread_near(clipped, any_clipped, row - 2, left, saturated[row - 2 - top])


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
    for beyond in (-2, -1, width, width + 1):
        inside = _mirror(beyond, width)
        line[beyond % 2, (beyond + 2) // 2] = line[inside % 2, inside // 2 + 1]
    return _mark_row(samples, row, white, some, clipped)


@scalar
def _mark_row(samples: np.ndarray, row: int, white: np.ndarray, some: int, clipped: np.ndarray) -> bool:
    """Where samples of one row and two mirrored ones at either end are saturated, which so many are."""
    width = samples.shape[1]
    if some == 0:
        clipped[:] = False
        return False
    for column in range(width):
        clipped[column + 2] = samples[row, column] >= white[row % 2, column % 2]
    for beyond in (-2, -1, width, width + 1):
        clipped[beyond + 2] = clipped[_mirror(beyond, width) + 2]
    return True


@scalar
def _interpolate(
    lines: np.ndarray, at: int, parity: int, green: bool, start: int, count: int, planes: np.ndarray
) -> None:
    """The three colours of `count` columns of one `parity` of row `at`, from number `start` of these on.

    At green: the colour of its row, green, the colour of its column; else its own colour, green, the opposite one.
    """
    a, b, c, d, e = at % 5, (at + 1) % 5, (at + 2) % 5, (at + 3) % 5, (at + 4) % 5
    other = 1 - parity
    above, over, own, under, below = (
        lines[a, parity, start:],
        lines[b, parity, start:],
        lines[c, parity, start:],
        lines[d, parity, start:],
        lines[e, parity, start:],
    )
    over_beside, beside, under_beside = lines[b, other, start:], lines[c, other, start:], lines[d, other, start:]
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
def _spread_near(clipped: np.ndarray, any_clipped: np.ndarray, at: int, left: int, saturated: np.ndarray) -> None:
    """Fill a row of the result, of row `at` of the samples from column `left` on."""
    if any_clipped.any():
        a, b, c, d, e = at % 5, (at + 1) % 5, (at + 2) % 5, (at + 3) % 5, (at + 4) % 5
        _spread(clipped[a], clipped[b], clipped[c], clipped[d], clipped[e], left, saturated)
    else:
        saturated[:] = False


@scalar
def _spread(
    a: np.ndarray, b: np.ndarray, c: np.ndarray, d: np.ndarray, e: np.ndarray, left: int, result: np.ndarray
) -> None:
    for column in range(result.shape[0]):
        x = left + column + 2
        near = b[x - 1] or b[x] or b[x + 1] or d[x - 1] or d[x] or d[x + 1] or c[x - 1] or c[x] or c[x + 1]
        result[column] = near or c[x - 2] or c[x + 2] or a[x] or e[x]


def prepare() -> None:
    """Compile for results that are upright and turned; later the process may not write the code."""
    levels = ", ".join(["Array(float64, 2, 'C')"] * 3)
    tables = f"{levels}, Array(int64, 2, 'C'), Array(float32, 2, 'C'), int64, int64"
    results = (f"Array(float32, 3, '{layout}'), Array(bool_, 2, '{layout}')" for layout in "CA")
    only(develop, *(f"void(Array(uint16, 2, 'C', readonly=True), {tables}, {result})" for result in results))
