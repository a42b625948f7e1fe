"""The pixels of a stack as they are written: lights one after the other, each corrected and warped in bands of rows;
or its codes, where what makes radiance of them can be applied whenever they are read (`engine.capture.coded_pixels`).

Each light has its place in the files, and its tally and checksums are its own, so that one that was written before the
import began (`engine.capture.ahead`) is adopted as it lies there. The checksum of a file is joined of those of lights.
Cost: bound by the disk, and by memory where the system keeps what is to be written: 13 bytes a pixel, of codes as many
as their files hold when unpacked, 3 of 8 bits and 2 of mosaics, and 12 of room light once.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

import numpy as np
from numpy.typing import DTypeLike, NDArray

from engine.capture.calibration.separation import Separation
from engine.capture.code_counts import CodeCounts
from engine.capture.coded_pixels import Counted, Decoding, Room, Window, count_by_codes, count_rows, radiance_of
from engine.capture.output_region import View
from engine.capture.photograph.bayer import MARGIN, Mosaic
from engine.capture.registration.warp import find_needed_rows, warp
from engine.capture.report import grid_step
from engine.capture.stack import CODES, DIFFUSE, RADIANCE, ROOM, SATURATED, npy_header
from engine.capture.tally import Tally
from engine.capture.waiting import CodedPixels, Pixels, WaitingLight
from engine.core.budget import thread_count
from engine.core.steps import Step, Steps
from engine.images.codes import Coded
from engine.storage.atomic import atomic_file, require_space, synchronise
from engine.storage.crc32 import extend_crc32, join_crc32
from engine.storage.file_array import FileArray, Plane
from engine.storage.scratch import release

#: Bytes of room for the record of a stack, and pixels that are written at once.
RECORD_BYTES, BAND_PIXELS = 1 << 20, 1 << 20

#: Rows of a photograph that all bands need, over those that it has, up to which each band takes its own; those of a
#: photograph that is turned would be made several times.
MAX_ROWS_SHARE = 1.5

#: Correction in place of rows of radiance, from a row of the photograph on.
CorrectRows = Callable[[NDArray[np.float32], int], None]


#: Radiance and saturation of the rows of a region from the first up to the last.
TakeRows = Callable[[int, int], tuple[NDArray[np.float32], NDArray[np.bool_]]]


@dataclass(frozen=True, eq=False)
class Written:
    """A light in the files of a stack: its `tally`, the CRC-32 of its bytes in each file by name, and the `counts` of
    codes of 8 bits."""

    tally: Tally
    crc32: dict[str, int]
    counts: CodeCounts | None = None


class CodeForm(NamedTuple):
    """Kind of the codes of photographs, number of channels of a pixel, and rows and columns around it that enter it."""

    dtype: np.dtype[Any]
    channels: int
    margin: int


def find_form(coded: Coded | Mosaic) -> CodeForm:
    """The form of the codes of a photograph."""
    margin = MARGIN if isinstance(coded, Mosaic) else 0
    return CodeForm(np.dtype(coded.codes.dtype), coded.codes.shape[2], margin)


class Output:
    """The .npy files of a stack, to which lights are added in order; pairs need the `separation` of their parts.

    `size` is the height and width of the photographs. With the `form` of codes these are what is written. `given_back`
    are bytes on the same disk that are free again by and by, as lights are added. The files begin as those of the
    folder `begun`, where it is given.
    """

    def __init__(
        self,
        files: ExitStack,
        place: Path,
        count: int,
        view: View,
        size: tuple[int, int],
        *,
        given_back: int = 0,
        separation: Separation | None = None,
        begun: Path | None = None,
        form: CodeForm | None = None,
    ) -> None:
        shape = (count, view.region.height, view.region.width)
        kinds: dict[str, tuple[tuple[int, ...], DTypeLike]]
        self.view, self.form, self.size = view, form, size
        if form is not None:
            kinds = {CODES: (self._codes_shape(count, form), form.dtype)}
        else:
            kinds = {RADIANCE: ((*shape, 3), np.float32), SATURATED: (shape, np.bool_)}
        if separation is not None:
            kinds[DIFFUSE] = ((*shape, 3), np.float32)
        size_bytes = sum(math.prod(full) * np.dtype(kind).itemsize for full, kind in kinds.values())
        require_space(place, max(0, size_bytes - given_back) + RECORD_BYTES)
        self.written: list[Written] = []
        self._separation = separation
        self._count = count
        self._headers = {name: npy_header(*kind) for name, kind in kinds.items()}
        self._light_bytes = {
            name: math.prod(full[1:]) * np.dtype(kind).itemsize for name, (full, kind) in kinds.items()
        }
        self._files = {name: self._start(files, place / name, begun) for name in kinds}
        self._writer = files.enter_context(ThreadPoolExecutor(1, thread_name_prefix="writing"))
        self._writing: Future[None] | None = None

    def _start(self, files: ExitStack, path: Path, begun: Path | None) -> BinaryIO:
        header = self._headers[path.name]
        file = files.enter_context(atomic_file(path, begun=None if begun is None else begun / path.name))
        file.write(header)
        if begun is not None:  # for other lights than there are
            file.truncate(len(header) + self._count * self._light_bytes[path.name])
        return file

    @property
    def crc32(self) -> dict[str, int]:
        """The CRC-32 of all that follows the header of each file, by its name."""
        joined = dict.fromkeys(self._files, 0)
        for light in self.written:
            for name, crc32 in light.crc32.items():
                joined[name] = join_crc32(joined[name], crc32, self._light_bytes[name])
        return joined

    @property
    def is_writing(self) -> bool:
        """True while something is being written beside other work."""
        return self._writing is not None and not self._writing.done()

    def adopt(self, written: Written) -> None:
        """Add a light that lies at its place already."""
        self.written.append(written)

    def add(
        self,
        light: WaitingLight,
        matrix: NDArray[np.float64],
        corrections: tuple[CorrectRows | None, CorrectRows | None] = (None, None),
        beside: NDArray[np.float64] | None = None,
    ) -> Steps[None]:
        """Add one light, as `write` does."""
        written = yield from self.write(len(self.written), light, matrix, corrections, beside)
        self.written.append(written)

    def write(
        self,
        index: int,
        light: WaitingLight,
        matrix: NDArray[np.float64],
        corrections: tuple[CorrectRows | None, CorrectRows | None] = (None, None),
        beside: NDArray[np.float64] | None = None,
    ) -> Steps[Written]:
        """Correct one light, warp it by its alignment `matrix` and the view at once, and write it band by band.

        `corrections` are those of the photograph and of the crossed one; `beside` (3, 3) takes pixels of a parallel
        photograph to those of the crossed one.
        """
        region = self.view.region
        whole = matrix @ self.view.matrix
        written = Written(Tally(grid_step(region.height, region.width)), dict.fromkeys(self._files, 0))
        take = self._bands(light.pixels, whole, corrections[0])
        take_crossed = None
        if light.crossed is not None:
            take_crossed = self._bands(light.crossed, whole if beside is None else beside @ whole, corrections[1])
        self._finish_writing()
        for name, file in self._files.items():
            file.seek(len(self._headers[name]) + index * self._light_bytes[name])
        for first, last in self._bands_of_rows():
            yield Step((index + first / region.height) / self._count, f"Writing {index + 1} of {self._count}")
            band, mask = take(first, last)
            parts: dict[str, NDArray[Any]] = {SATURATED: mask}
            if take_crossed is not None and self._separation is not None:
                separated = self._separation.apply(band, take_crossed(first, last)[0])
                band, parts[DIFFUSE] = (np.ascontiguousarray(part) for part in separated)
            parts[RADIANCE] = band
            self._finish_writing()
            self._writing = self._writer.submit(self._write, parts, written.crc32)
            written.tally.add(band, mask, first)
            light.release()
        self._finish_writing()
        return written

    def write_codes(self, index: int, coded: Coded | Mosaic, take: TakeRows | None = None) -> Steps[Written]:
        """Write the codes of one light that the region of the view shows, and note the radiance that one can `take`."""
        region, window, margin = self.view.region, self.window, find_form(coded).margin
        step, counts = grid_step(region.height, region.width), None
        if isinstance(coded, Coded) and coded.codes.dtype == np.uint8:
            counts = CodeCounts(coded.white, step, region.width)
        written = Written(Tally(step), {CODES: 0}, counts)
        self._finish_writing()
        self._files[CODES].seek(len(self._headers[CODES]) + index * self._light_bytes[CODES])
        left, right = window.find_columns(region.width, margin)
        begin, _ = window.find_rows(0, region.height, margin)
        for first, last in self._bands_of_rows():
            yield Step((index + first / region.height) / self._count, f"Writing {index + 1} of {self._count}")
            end = window.top + last
            if last == region.height:
                _, end = window.find_rows(0, region.height, margin)
            codes = np.ascontiguousarray(coded.codes[begin:end][:, left:right])
            begin = end
            self._finish_writing()
            self._writing = self._writer.submit(self._write, {CODES: codes}, written.crc32)
            if counts is not None:
                counts.add(codes, first)
            if take is not None:
                written.tally.add(*take(first, last), first)
            release(coded.codes)
        self._finish_writing()
        return written

    @property
    def window(self) -> Window:
        """The part of the photographs that the region of the view shows."""
        return Window(*self.size, self.view.region.top, self.view.region.left)

    def read_codes(self, index: int) -> Plane:
        """The codes of a light that lies at its place."""
        self._finish_writing()
        file, header = self._files[CODES], self._headers[CODES]
        assert self.form is not None
        shape = self._codes_shape(self._count, self.form)
        status = Path(file.name).stat()
        return Plane(FileArray(Path(file.name), shape, self.form.dtype, len(header), status), index)

    def _codes_shape(self, count: int, form: CodeForm) -> tuple[int, ...]:
        """The shape of so many photographs of codes, with their margin."""
        region = self.view.region
        return count, *self.window.find_shape(region.height, region.width, form.margin), form.channels

    def write_room(self, place: Path, room: Room) -> int:
        """Write the room light (H, W, 3) of whole photographs as the region shows it into the folder `place`; its
        CRC-32. Raises OutputError where the folder cannot be written."""
        region, crc32 = self.view.region, 0
        require_space(place, 12 * region.height * region.width + RECORD_BYTES)
        with atomic_file(place / ROOM) as file:
            file.write(npy_header((1, region.height, region.width, 3), np.float32))
            for first, last in self._bands_of_rows():
                band = np.ascontiguousarray(self._cut_room(room, first, last))
                file.write(band.data)
                crc32 = extend_crc32(crc32, band.data)
                release(room)
        return crc32

    def _cut_room(self, room: Room, first: int, last: int) -> Room:
        """Room light in rows of the region."""
        region = self.view.region
        return room[region.top + first : region.top + last, region.left : region.left + region.width]

    def note_codes(self, index: int, written: Written, decoding: Decoding, room: Room | None = None) -> Steps[Written]:
        """Give what was `written` of the codes of a light a tally of the radiance that `decoding` makes of them, less
        `room` light (H, W, 3) of whole photographs.

        Where counts do not tell it, bands are read and counted on all cores, and added in their order.
        """
        known = None if written.counts is None or room is not None else count_by_codes(written.counts, decoding)
        if known is not None:
            return replace(written, tally=known)
        region, codes, window, margin = self.view.region, self.read_codes(index), self.window, decoding.margin
        top, _ = window.find_rows(0, region.height, margin)
        tally = Tally(grid_step(region.height, region.width))
        making: deque[Future[Counted]] = deque()

        def count(first: int, last: int) -> Counted:
            begin, end = window.find_rows(first, last, margin)
            size = last - first, region.width
            darker = None if room is None else self._cut_room(room, first, last)
            return count_rows(codes[begin - top : end - top], first, size, decoding, window, tally.step, darker)

        with ThreadPoolExecutor(thread_count(), thread_name_prefix="decoding") as pool:
            for first, last in self._bands_of_rows():
                yield Step((index + first / region.height) / self._count, f"Measuring {index + 1} of {self._count}")
                making.append(pool.submit(count, first, last))
                if len(making) > thread_count():
                    tally.join(*making.popleft().result())
            for counted in making:
                tally.join(*counted.result())
        return replace(written, tally=tally)

    def decode(self, coded: Coded | Mosaic, decoding: Decoding, room: Room | None = None) -> TakeRows:
        """Function from rows of the region to the radiance that `decoding` makes of `coded`, a whole photograph, less
        `room` light (H, W, 3)."""
        window, width = self.window, self.view.region.width
        left, right = window.find_columns(width, decoding.margin)

        def take(first: int, last: int) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
            begin, end = window.find_rows(first, last, decoding.margin)
            codes = coded.codes[begin:end][:, left:right]
            darker = None if room is None else self._cut_room(room, first, last)
            return radiance_of(codes, first, (last - first, width), decoding, window, darker)

        return take

    def cut(self, pixels: Pixels) -> TakeRows:
        """Function from rows of the region to those of a photograph."""
        return self._bands(pixels, np.eye(3), None)

    def abandon(self) -> None:
        """Write no more: the files are empty, and to be removed when they are closed."""
        self._finish_writing()
        for file in self._files.values():
            file.truncate(0)

    def _bands_of_rows(self) -> Iterator[tuple[int, int]]:
        """First row of each band and the one after its last."""
        height, rows = self.view.region.height, max(1, BAND_PIXELS // self.view.region.width)
        return ((first, min(first + rows, height)) for first in range(0, height, rows))

    def _write(self, parts: dict[str, NDArray[Any]], crc32: dict[str, int]) -> None:
        for name, pixels in parts.items():
            self._files[name].write(pixels.data)
            crc32[name] = extend_crc32(crc32[name], pixels.data)

    def synchronise(self) -> None:
        """Begin to flush what has been written to the disk, beside other work."""
        self._finish_writing()
        self._writing = self._writer.submit(self._flush)

    def _flush(self) -> None:
        for file in self._files.values():
            synchronise(Path(file.name))

    def _finish_writing(self) -> None:
        """Wait for what is being written while the next is made; raises what went wrong."""
        if self._writing is not None:
            writing, self._writing = self._writing, None
            writing.result()

    def _bands(
        self, pixels: Pixels | CodedPixels, matrix: NDArray[np.float64], correct: CorrectRows | None
    ) -> TakeRows:
        """Function from the first row and the one after the last of a band of the region to its radiance and mask."""
        region, samples = self.view.region, self.view.samples

        def correct_taken(first: int, last: int) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
            radiance, saturated = pixels.rows(first, last, to_change=correct is not None)
            if correct is not None:
                correct(radiance, first)
            return radiance, saturated

        def cut(first: int, last: int) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
            radiance, saturated = correct_taken(region.top + first, region.top + last)
            columns = np.s_[:, region.left : region.left + region.width]
            return np.ascontiguousarray(radiance[columns]), np.ascontiguousarray(saturated[columns])

        if samples == 1 and np.array_equal(matrix, np.eye(3)):
            return cut
        spans = {band: find_needed_rows(matrix, region, *band, pixels.height) for band in self._bands_of_rows()}
        if sum(last - first for first, last in spans.values()) > MAX_ROWS_SHARE * pixels.height:
            radiance, saturated = correct_taken(0, pixels.height)
            return lambda first, last: warp(radiance, saturated, matrix, region, first, last, samples)

        def move(first: int, last: int) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
            begin, end = spans[first, last]
            taken = correct_taken(begin, end)
            return warp(*taken, matrix, region, first, last, samples, (begin, pixels.height))

        return move
