"""Photographs of a stack as the codes of their files, and the radiance that is made of them when it is read.

    radiance = max(light * factor * stated fall-off - room light, 0) * found fall-off * gain

in this order and in single precision, where light is the entry of a table at the code, or of RAW files what
`engine.capture.photograph.bayer` makes of the samples around the pixel, and room light is that of a file beside the
codes. These are the operations of `engine.images.codes`, `engine.capture.photograph.calibration` and
`engine.capture.calibration.correction`: what is read has the bits of a stack whose radiance was written. Codes are a
half of radiance and saturation or less, so that large stacks stay in the memory that the system keeps of files, and
what was found of a rig changes no bytes of theirs.

Cost: bound by the lookups and by the memory that is filled, 2 ns a pixel and thread of 8 bits and 3 of 16, with a near
lamp 2 more, with room light as much, and 1 for saturation; of mosaics by arithmetic, 6 ns. More than two megapixels at
once are decoded on all cores.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import ExitStack
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from engine.capture.code_counts import CodeCounts
from engine.capture.photograph.bayer import MARGIN, Sensor, find_span
from engine.capture.photograph.calibrate import lamp_distances
from engine.capture.report import BLACK
from engine.capture.tally import LUMINANCE32, Tally
from engine.core.budget import thread_count
from engine.core.kernels import scalar
from engine.storage.file_array import FileArray, Piece

if TYPE_CHECKING:
    from engine.capture.calibration.correction import Correction

#: Pixels that are decoded at once by one thread, and up to which there is no other, since those who read as few do so
#: on several threads themselves.
_PART_PIXELS, FEW_PIXELS = 1 << 18, 1 << 21

_Codes = NDArray[np.unsignedinteger]

#: Radiance (rows, W, 3) by room light.
Room = NDArray[np.float32]

#: What a tally adds: sums by rows, numbers of clipped and of black pixels, and its grid.
Counted = tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.float32]]


@dataclass(frozen=True, eq=False)
class Curve:
    """Light by codes, as `engine.images.codes.Coded` has it: `tables` (1 or 3, N), code of `white`, `matrix` (3, 3) or
    None."""

    tables: NDArray[np.float32]
    white: int
    matrix: NDArray[np.float32] | None = None

    def is_same(self, other: Curve) -> bool:
        """True where the other gives the same light."""
        one, another = (np.eye(3) if each.matrix is None else each.matrix for each in (self, other))
        same = self.white == other.white and np.array_equal(self.tables, other.tables)
        return same and np.array_equal(one, another)


@dataclass(frozen=True)
class FallOff:
    """A near lamp at `distance` widths of the image and these angles (radians), whose fall-off is taken off."""

    distance: float
    elevation: float
    azimuth: float


@dataclass(frozen=True, eq=False)
class Decoding:
    """Steps that make radiance of the codes of one photograph.

    Attributes
    ----------
    curve : light by codes, or the sensor whose samples they are. factors : (3,) of its channels.
    stated, found : near lamps, as they were known before and as they were found; None for distant ones.
    gain : inverse of the intensity that was found.
    """

    curve: Curve | Sensor
    factors: tuple[float, float, float] = (1.0, 1.0, 1.0)
    stated: FallOff | None = None
    found: FallOff | None = None
    gain: float = 1.0

    @property
    def margin(self) -> int:
        """Rows and columns around a pixel whose codes enter it."""
        return find_margin(self.curve)

    def add_correction(self, correction: Correction | None, index: int) -> Decoding:
        """The decoding of photograph number `index` with what was found of the rig, but for room light."""
        if correction is None:
            return self
        found = None
        if correction.nearness > 0.0:
            angles = float(correction.elevation[index]), float(correction.azimuth[index])
            found = FallOff(1.0 / correction.nearness, *angles)
        return replace(self, found=found, gain=float(np.float32(1.0 / correction.gains[index])))


@dataclass(frozen=True)
class Window:
    """The part of photographs of `height` and `width` whose codes there are, from this row and column on."""

    height: int
    width: int
    top: int = 0
    left: int = 0

    def find_rows(self, first: int, last: int, margin: int) -> tuple[int, int]:
        """Rows of the photographs whose codes enter the rows [first, last) of the part."""
        return find_span(self.top + first, self.top + last, self.height, margin)

    def find_columns(self, width: int, margin: int) -> tuple[int, int]:
        """The same of columns of a part of this `width`."""
        return find_span(self.left, self.left + width, self.width, margin)

    def find_shape(self, height: int, width: int, margin: int) -> tuple[int, int]:
        """Height and width of the codes that enter a part of this `height` and `width`."""
        (top, bottom), (left, right) = self.find_rows(0, height, margin), self.find_columns(width, margin)
        return bottom - top, right - left


def is_same(one: Curve | Sensor, other: Curve | Sensor) -> bool:
    """True where both give the same light of the same codes."""
    if isinstance(one, Sensor):
        return isinstance(other, Sensor) and one.is_same(other)
    return isinstance(other, Curve) and one.is_same(other)


def find_margin(curve: Curve | Sensor) -> int:
    """Rows and columns around a pixel whose codes enter it."""
    return MARGIN if isinstance(curve, Sensor) else 0


def decode_rows(
    codes: _Codes,
    first: int,
    decoding: Decoding,
    window: Window,
    into: NDArray[np.float32],
    room: Room | None = None,
) -> None:
    """Fill `into` (rows, W, 3) with the radiance of `codes` (rows, W, 1 or 3), from row `first` of the window on, less
    that of `room` light in these rows.

    Codes of a sensor are those of the rows and columns around as well, as far as photographs have them.
    """
    none, curve = np.empty(0), decoding.curve
    near = [(none, none), (none, none)]
    columns = slice(window.left, window.left + into.shape[1])
    rows = (window.top + first, window.top + first + len(into))
    for place, lamp in enumerate((decoding.stated, decoding.found)):
        if lamp is not None:
            angles = lamp.elevation, lamp.azimuth
            across, along = lamp_distances(window.height, window.width, lamp.distance, *angles, rows)
            near[place] = across[columns], along
    lamps = *near[0], _require_room(room), *near[1], np.float32(decoding.gain)
    factors = np.array(decoding.factors, np.float32)
    if isinstance(curve, Sensor):
        _develop(codes, first, curve, window, into, np.empty(into.shape[:2], np.bool_))
        _correct(factors, *lamps, into)
        return
    matrix = np.empty((0, 3), np.float32) if curve.matrix is None else curve.matrix
    _decode(_plain(codes), curve.tables, matrix, factors, *lamps, into)


def count_rows(
    codes: _Codes,
    first: int,
    size: tuple[int, int],
    decoding: Decoding,
    window: Window,
    step: int,
    room: Room | None = None,
) -> Counted:
    """Count for `Tally.join` the radiance of `codes`, as `decode_rows`, of a part of this height and width.

    `step` is that of the tally. Where a code tells the light by itself, no radiance is written: 2 ns a pixel, with
    `room` light 3.
    """
    gain, tables = np.float32(decoding.gain), _tabulate(replace(decoding, gain=1.0))
    if tables is None:
        tally = Tally(step)
        tally.add(*radiance_of(codes, first, size, decoding, window, room), first)
        return tally.rows[0], np.array([[tally.clipped, tally.black]]), tally.grid[0]
    assert isinstance(decoding.curve, Curve)
    sums, counts = np.empty((len(codes), 3)), np.empty((len(codes), 2), np.int64)
    darker, kinds = _require_room(room), (decoding.curve.white, LUMINANCE32, np.float32(BLACK))
    _count_plain(_plain(codes), tables, darker, gain, *kinds, sums, counts)
    thinned = np.s_[-first % step :: step, ::step]
    some = codes[thinned]
    grid = np.stack([tables[each, some[..., min(each, some.shape[2] - 1)]] for each in range(3)], axis=-1)
    if room is not None:
        grid = np.maximum(grid - room[thinned], np.float32(0.0))
    return sums, counts, grid * gain


def count_by_codes(counts: CodeCounts, decoding: Decoding) -> Tally | None:
    """The tally of a photograph by `counts` of its codes; None where these do not tell it."""
    tables = _tabulate(decoding)
    if tables is None or not isinstance(decoding.curve, Curve) or decoding.curve.white != counts.white:
        return None
    return counts.tally(tables)


def _tabulate(decoding: Decoding) -> NDArray[np.float32] | None:
    """(3, E) radiance by codes of each channel; None where that of a pixel does not follow from the code of each
    channel alone, as under a near lamp or of a mosaic."""
    curve = decoding.curve
    if (
        isinstance(curve, Sensor)
        or curve.matrix is not None
        or decoding.stated is not None
        or decoding.found is not None
    ):
        return None
    factors = np.array(decoding.factors, np.float32)[:, None]
    return np.asarray(curve.tables * factors * np.float32(decoding.gain), np.float32)


def _develop(
    codes: _Codes,
    first: int,
    sensor: Sensor,
    window: Window,
    radiance: NDArray[np.float32],
    saturated: NDArray[np.bool_],
) -> None:
    """Light of the samples of a sensor."""
    begin = _begin_of(first, window, saturated)
    at = window.top + first, window.left
    sensor.develop(codes[..., 0], begin, (window.height, window.width), at, radiance, saturated)


def _begin_of(first: int, window: Window, part: NDArray[np.bool_]) -> tuple[int, int]:
    """First row and column of the photograph whose samples enter a part from row `first` of the window on."""
    return window.find_rows(first, first + len(part), MARGIN)[0], window.find_columns(part.shape[1], MARGIN)[0]


def find_saturated(codes: _Codes, first: int, curve: Curve | Sensor, window: Window, into: NDArray[np.bool_]) -> None:
    """Fill `into` (rows, W) with where any of `codes`, as in `decode_rows`, is at white or above."""
    if isinstance(curve, Sensor):
        at = window.top + first, window.left
        size = window.height, window.width
        curve.find_saturated(codes[..., 0], _begin_of(first, window, into), size, at, into)
    elif curve.white > np.iinfo(codes.dtype).max:
        into[...] = False
    else:
        _find_full(_plain(codes), codes.dtype.type(curve.white), into)


def _plain(codes: _Codes) -> _Codes:
    """The codes as kernels are compiled for them."""
    return np.require(codes, requirements=["C", "W"])


def _require_room(room: Room | None) -> Room:
    """Room light as kernels are compiled for it, without rows where there is none."""
    return np.empty((0, 0, 3), np.float32) if room is None else np.require(room, requirements=["C", "W"])


@scalar
def _take_off(across: np.ndarray, along: float, gain: np.float32, scale: np.ndarray, radiance: np.ndarray) -> None:
    """Take the fall-off of a near lamp off a row (W, 3), times `gain`; `scale` (W,) is memory. Bound by roots."""
    for column in range(len(scale)):
        squared = across[column] + along
        scale[column] = squared * np.sqrt(squared)
    for column in range(len(scale)):
        for channel in range(3):
            radiance[column, channel] *= scale[column] * gain


@scalar
def _decode(
    codes: np.ndarray,
    tables: np.ndarray,
    matrix: np.ndarray,
    factors: np.ndarray,
    stated_across: np.ndarray,
    stated_along: np.ndarray,
    room: np.ndarray,
    found_across: np.ndarray,
    found_along: np.ndarray,
    gain: np.float32,
    radiance: np.ndarray,
) -> None:
    """Bound by the lookups, and with a near lamp by its square roots."""
    width, second, third = codes.shape[1], min(1, codes.shape[2] - 1), codes.shape[2] - 1
    table, other = min(1, len(tables) - 1), len(tables) - 1
    scale = np.empty(width, np.float32)
    for row in range(codes.shape[0]):
        for column in range(width):
            red, green, blue = codes[row, column, 0], codes[row, column, second], codes[row, column, third]
            r, g, b = tables[0, red], tables[table, green], tables[other, blue]
            if len(matrix) > 0:
                mixed_r = matrix[0, 0] * r + matrix[0, 1] * g + matrix[0, 2] * b
                mixed_g = matrix[1, 0] * r + matrix[1, 1] * g + matrix[1, 2] * b
                mixed_b = matrix[2, 0] * r + matrix[2, 1] * g + matrix[2, 2] * b
                r, g, b = mixed_r, mixed_g, mixed_b
            radiance[row, column, 0] = r * factors[0]
            radiance[row, column, 1] = g * factors[1]
            radiance[row, column, 2] = b * factors[2]
        _take_lights_off(row, stated_across, stated_along, room, found_across, found_along, gain, scale, radiance[row])


@scalar
def _correct(
    factors: np.ndarray,
    stated_across: np.ndarray,
    stated_along: np.ndarray,
    room: np.ndarray,
    found_across: np.ndarray,
    found_along: np.ndarray,
    gain: np.float32,
    radiance: np.ndarray,
) -> None:
    """The same of light that has been made. Bound by memory, and with a near lamp by its square roots."""
    width = radiance.shape[1]
    scale = np.empty(width, np.float32)
    is_scaled = factors[0] != 1.0 or factors[1] != 1.0 or factors[2] != 1.0
    for row in range(radiance.shape[0]):
        if is_scaled:
            for column in range(width):
                for channel in range(3):
                    radiance[row, column, channel] *= factors[channel]
        _take_lights_off(row, stated_across, stated_along, room, found_across, found_along, gain, scale, radiance[row])


@scalar
def _take_lights_off(
    row: int,
    stated_across: np.ndarray,
    stated_along: np.ndarray,
    room: np.ndarray,
    found_across: np.ndarray,
    found_along: np.ndarray,
    gain: np.float32,
    scale: np.ndarray,
    radiance: np.ndarray,
) -> None:
    """Take what is known of the lamp and the `room` light off a row (W, 3); `scale` (W,) is memory."""
    if len(stated_along) > 0:
        _take_off(stated_across, stated_along[row], np.float32(1.0), scale, radiance)
    if len(room) > 0:
        for column in range(len(scale)):
            for channel in range(3):
                radiance[column, channel] = max(radiance[column, channel] - room[row, column, channel], np.float32(0.0))
    if len(found_along) > 0:
        _take_off(found_across, found_along[row], gain, scale, radiance)
    elif gain != 1.0:
        for column in range(len(scale)):
            for channel in range(3):
                radiance[column, channel] *= gain


@scalar
def _find_full(codes: np.ndarray, white: np.unsignedinteger, saturated: np.ndarray) -> None:
    """Bound by memory."""
    second, third = min(1, codes.shape[2] - 1), codes.shape[2] - 1
    for row in range(codes.shape[0]):
        for column in range(codes.shape[1]):
            largest = max(codes[row, column, 0], codes[row, column, second], codes[row, column, third])
            saturated[row, column] = largest >= white


@scalar
def _count_plain(
    codes: np.ndarray,
    tables: np.ndarray,
    room: np.ndarray,
    gain: np.float32,
    white: int,
    weights: np.ndarray,
    black: np.float32,
    sums: np.ndarray,
    counts: np.ndarray,
) -> None:
    """Count what `tables` (3, E) have, less `room` light where there is such, times `gain`, as `Tally.add` does.
    Bound by the lookups and the sums, in order."""
    second, third = min(1, codes.shape[2] - 1), codes.shape[2] - 1
    for row in range(codes.shape[0]):
        in_red, in_green, in_blue = 0.0, 0.0, 0.0
        clipped, dark = 0, 0
        for column in range(codes.shape[1]):
            red, green, blue = codes[row, column, 0], codes[row, column, second], codes[row, column, third]
            r, g, b = tables[0, red], tables[1, green], tables[2, blue]
            if len(room) > 0:
                r = max(r - room[row, column, 0], np.float32(0.0))
                g = max(g - room[row, column, 1], np.float32(0.0))
                b = max(b - room[row, column, 2], np.float32(0.0))
            r, g, b = r * gain, g * gain, b * gain
            in_red += r
            in_green += g
            in_blue += b
            clipped += max(red, green, blue) >= white
            dark += r * weights[0] + g * weights[1] + b * weights[2] < black
        sums[row, 0], sums[row, 1], sums[row, 2] = in_red, in_green, in_blue
        counts[row, 0], counts[row, 1] = clipped, dark


@dataclass(frozen=True, eq=False)
class CodedArray(FileArray):
    """An array that is made of codes in a file when it is read; shape and dtype are its own, the rest is of the file.

    Attributes
    ----------
    codes : (N, H, W, 1 or 3), with the margin of the decodings around. decodings : of the N photographs.
    window : the part of photographs that the array shows. room : (1, H, W, 3) light that is taken off, None for none.
    """

    codes: FileArray | None = None
    decodings: tuple[Decoding, ...] = ()
    window: Window = Window(0, 0)
    room: FileArray | None = None

    @property
    def is_there(self) -> bool:
        return self.codes is not None and self.codes.is_there and (self.room is None or self.room.is_there)

    def decode(self, codes: _Codes, plane: int, first: int, into: NDArray[Any], room: Room | None) -> None:
        """Fill `into` of codes that begin at a row of a plane, and of room light from there on."""
        raise NotImplementedError

    def fill(self, pieces: Sequence[Piece]) -> None:
        """Codes are read one part after the other, and decoded meanwhile."""
        assert self.codes is not None
        height, width = self.shape[1:3]
        rows = max(1, _PART_PIXELS // max(1, width))
        parts = [
            (*divmod(row + at, height), into[at : at + rows])
            for row, into in pieces
            for at in range(0, len(into), rows)
        ]
        margin = self.decodings[0].margin if self.decodings else 0
        top = self.window.find_rows(0, height, margin)[0]
        many = sum(len(into) for _, _, into in parts) * width > FEW_PIXELS and thread_count() > 1
        running: deque[Future[None]] = deque()
        rows_of_room, room = (-1, -1), None  # photographs have the same, so that what was read last mostly fits
        with ExitStack() as held:
            read = held.enter_context(self.codes.reader())
            read_room = None if self.room is None else held.enter_context(self.room.reader())
            threads = ThreadPoolExecutor(thread_count(), thread_name_prefix="decoding") if many else None
            pool = held.enter_context(threads) if threads is not None else None
            for plane, first, into in parts:
                begin, end = self.window.find_rows(first, first + len(into), margin)
                codes = np.empty((end - begin, *self.codes.shape[2:]), self.codes.dtype)
                read(codes, plane * self.codes.shape[1] + begin - top)
                if read_room is not None and rows_of_room != (first, len(into)):
                    rows_of_room, room = (first, len(into)), np.empty((len(into), width, 3), np.float32)
                    read_room(room, first)
                if pool is None:
                    self.decode(codes, plane, first, into, room)
                    continue
                if len(running) > thread_count():
                    running.popleft().result()
                running.append(pool.submit(self.decode, codes, plane, first, into, room))
            for each in running:
                each.result()


@dataclass(frozen=True, eq=False)
class CodedRadiance(CodedArray):
    """(N, H, W, 3) radiance."""

    def __getitem__(self, key: Any) -> NDArray[Any]:
        """As of any array in a file; of rows and columns some of which are left out no others are decoded."""
        found = self._look_up(*key) if isinstance(key, tuple) and len(key) == 3 else None
        return super().__getitem__(key) if found is None else found

    def _look_up(self, planes: Any, rows: Any, columns: Any) -> NDArray[np.float32] | None:
        """Radiance by the codes of one plane; None where rows follow each other, or codes alone do not tell it."""
        if not isinstance(planes, int | np.integer) or not isinstance(rows, slice) or rows.step in (None, 1):
            return None
        assert self.codes is not None
        tables = _tabulate(self.decodings[int(planes)]) if self.room is None else None
        if tables is None:
            return None
        codes = self.codes[planes, rows, columns]
        return np.stack([tables[each, codes[..., min(each, codes.shape[-1] - 1)]] for each in range(3)], axis=-1)

    def decode(self, codes: _Codes, plane: int, first: int, into: NDArray[Any], room: Room | None) -> None:
        decode_rows(codes, first, self.decodings[plane], self.window, into, room)

    def tabulate(self, planes: NDArray[np.int64]) -> NDArray[np.float32] | None:
        """(M, 256, 3) radiance by codes of 8 bits in these planes; None where that of a pixel does not follow from the
        code of each channel alone, as under a near lamp or with room light."""
        if self.room is not None:
            return None
        found = [_tabulate(self.decodings[plane]) for plane in planes]
        tables = [each.T[:256] for each in found if each is not None]
        is_coded = self.codes is not None and self.codes.dtype == np.uint8 and len(tables) == len(found)
        return np.ascontiguousarray(np.stack(tables)) if is_coded else None


@dataclass(frozen=True, eq=False)
class CodedSaturated(CodedArray):
    """(N, H, W) True where a channel is at white."""

    def decode(self, codes: _Codes, plane: int, first: int, into: NDArray[Any], room: Room | None) -> None:
        find_saturated(codes, first, self.decodings[plane].curve, self.window, into)


def arrays_of(
    codes: FileArray,
    decodings: tuple[Decoding, ...],
    window: Window,
    size: tuple[int, int],
    room: FileArray | None = None,
) -> tuple[CodedArray, CodedArray]:
    """Radiance and saturation of photographs by their codes and `room` light, of the part of this height and width."""
    shape, of_file = (len(codes), *size), (codes.offset_bytes, codes.status, codes.header)
    how = codes, decodings, window
    radiance = CodedRadiance(codes.path, (*shape, 3), np.dtype(np.float32), *of_file, *how, room)
    return radiance, CodedSaturated(codes.path, shape, np.dtype(np.bool_), *of_file, *how)


def radiance_of(
    codes: _Codes,
    first: int,
    size: tuple[int, int],
    decoding: Decoding,
    window: Window,
    room: Room | None = None,
) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
    """Radiance (rows, W, 3) and saturation (rows, W) of `codes`, as `decode_rows`, of a part of this `size`."""
    radiance, saturated = np.empty((*size, 3), np.float32), np.empty(size, np.bool_)
    decode_rows(codes, first, decoding, window, radiance, room)
    find_saturated(codes, first, decoding.curve, window, saturated)
    return radiance, saturated
