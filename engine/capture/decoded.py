"""Photographs that were decoded before an import asks for them, as those of a capture that is still being taken.

While a `Decoded` is open, whatever reads one of its photographs in this process gets it from there, as long as the file
is the one that was decoded: the same file by its number, size and time of change, wherever it was renamed to, read with
the same options. An import takes the lights to which nothing is done before they are aligned as they are, with what was
noted of them; others it decodes from their codes. All numbers are those of an import that decodes anew.

Cost: the codes of each photograph, 72 MB for 24 megapixels of 8 bits, 48 of a mosaic, or its pixels where it has none,
four times that and more, in memory or in scratch files.
"""

from __future__ import annotations

import tempfile
import threading
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from engine.capture.noted import Noted, note
from engine.capture.photograph.bayer import Mosaic
from engine.capture.photograph.decode import OPTIONS, Photograph, add_supply, drop_supply
from engine.capture.photograph.exposures import Noted as NotedExposure
from engine.capture.photograph.exposures import read_noted_exposure
from engine.capture.tally import Tally
from engine.capture.waiting import Pixels
from engine.core.errors import OutputError
from engine.images.codes import Coded
from engine.storage.scratch import IN_MEMORY_BYTES, array_in, release


class Mark(NamedTuple):
    """A state of a file, told from others whatever its name is: its `suffix` alone counts of that."""

    device: int
    number: int
    size: int
    changed_ns: int
    suffix: str


@dataclass(frozen=True, eq=False)
class Kept:
    """A photograph that was decoded.

    Attributes
    ----------
    photograph : without its pixels. width, height : of it.
    pixels : codes or pixels, None where there was no room for them.
    noted : what was noted of the pixels.
    exposure : what the camera noted of it.
    clipped, black : shares of its pixels at the white level, and below `engine.capture.report.BLACK`.
    mean_radiance : its mean luminance.
    """

    photograph: Photograph
    width: int
    height: int
    pixels: Coded | Mosaic | Pixels | None
    noted: Noted
    exposure: NotedExposure
    clipped: float
    black: float
    mean_radiance: float

    @property
    def coded(self) -> Coded | Mosaic | None:
        """The codes or the mosaic; None where pixels are kept."""
        return None if isinstance(self.pixels, Pixels) else self.pixels


def mark_of(path: Path) -> Mark | None:
    """The mark of a file as it is now; None where it is not there."""
    try:
        found = path.stat()
    except (OSError, ValueError):
        return None
    return Mark(found.st_dev, found.st_ino, found.st_size, found.st_mtime_ns, path.suffix.lower())


class Decoded:
    """Photographs of one capture, decoded with `options` of `read_photograph`; to be closed, which forgets them."""

    def __init__(self, options: Mapping[str, Any]) -> None:
        self.options = {name: value for name, value in options.items() if name != "keep_codes"}
        self._complete = _complete(self.options)
        self._kept: dict[Mark, Kept] = {}
        self._lock = threading.Lock()
        self._in_memory = 0
        _open.append(self)
        add_supply(self._supply)

    def keep(self, mark: Mark, photograph: Photograph) -> Kept:
        """Keep the photograph of the file with this mark, and what is noted of it."""
        radiance, saturated = photograph.radiance, photograph.saturated
        tally = Tally(max(1, max(saturated.shape)))
        tally.add(radiance, saturated, 0)
        pixels, count = self._pixels(photograph), saturated.size
        nothing = np.empty((0, 0, 3), np.float32)
        bare = replace(photograph, radiance=nothing, saturated=nothing[..., 0] > 0, coded=None)
        height, width = saturated.shape
        shares = tally.clipped / count, tally.black / count
        noted, exposure = note(radiance, saturated), read_noted_exposure(photograph.path)
        kept = Kept(bare, width, height, pixels, noted, exposure, *shares, tally.mean_radiance(count))
        with self._lock:
            self._kept[mark] = kept
        return kept

    def forget(self, mark: Mark) -> None:
        """Forget the photograph of a file that has changed or gone."""
        with self._lock:
            self._kept.pop(mark, None)

    def find_file(self, path: Path) -> Kept | None:
        """The photograph at `path`, with whatever options it was decoded; None where that was not done."""
        mark = mark_of(path) if self._kept else None
        with self._lock:
            return self._kept.get(mark) if mark is not None else None

    def find(self, path: Path, options: Mapping[str, Any]) -> Kept | None:
        """The photograph at `path` as it is decoded with `options`; None where that was not done, or it has changed."""
        kept, asked, known = self.find_file(path), _complete(options), self._complete
        if kept is not None and kept.photograph.container != "RAW":  # whose white balance the decoder sees to
            asked = {**asked, "white_balance": known["white_balance"]}
        return None if kept is None or asked != known else replace(kept, photograph=replace(kept.photograph, path=path))

    def close(self) -> None:
        """Forget all photographs; who has taken one keeps it."""
        drop_supply(self._supply)
        if self in _open:
            _open.remove(self)
        self._kept.clear()

    def _supply(self, path: Path, options: Mapping[str, Any]) -> Photograph | None:
        kept = self.find(path, options)
        if kept is None or kept.pixels is None:
            return None
        if isinstance(kept.pixels, Pixels):
            radiance, saturated, coded = kept.pixels.radiance.view(), kept.pixels.saturated.view(), None
        else:
            radiance, saturated = kept.pixels.linear(0, kept.height)
            coded = kept.pixels if options.get("keep_codes") else None
        radiance.flags.writeable = saturated.flags.writeable = False
        return replace(kept.photograph, radiance=radiance, saturated=saturated, coded=coded)

    def _pixels(self, photograph: Photograph) -> Coded | Mosaic | Pixels | None:
        coded = photograph.coded
        try:
            if coded is None:
                return Pixels(self._copy(photograph.radiance), self._copy(photograph.saturated))
            if isinstance(coded, Mosaic):
                assert isinstance(coded.codes, np.ndarray)
                return replace(coded, codes=self._copy(coded.codes))
            # what is small would keep all the memory alive in which the decoder answered
            tables, matrix = coded.tables.copy(), None if coded.matrix is None else coded.matrix.copy()
            assert isinstance(coded.codes, np.ndarray)
            return replace(coded, codes=self._copy(coded.codes), tables=tables, matrix=matrix)
        except OutputError:
            return None

    def _copy(self, array: NDArray[Any]) -> NDArray[Any]:
        place = None if self._in_memory + array.nbytes <= IN_MEMORY_BYTES else Path(tempfile.gettempdir())
        if place is None:
            self._in_memory += array.nbytes
        copied = array_in(place, array.shape, array.dtype)
        copied[...] = array
        release(copied)
        return copied


_open: list[Decoded] = []


def find_kept(path: Path, options: Mapping[str, Any]) -> Kept | None:
    """The photograph at `path`, decoded before with these options of `read_photograph`; None where it was not."""
    return next((kept for each in tuple(_open) if (kept := each.find(path, options)) is not None), None)


def note_exposure(path: Path) -> NotedExposure:
    """The exposure that the camera noted in the photograph at `path`, which is read unless that was done before."""
    kept = next((kept for each in tuple(_open) if (kept := each.find_file(path)) is not None), None)
    return read_noted_exposure(path) if kept is None else kept.exposure


def _complete(options: Mapping[str, Any]) -> dict[str, Any]:
    """All options of a decoder but whether codes are kept, in one form."""
    known = {**OPTIONS, **options}
    known.pop("keep_codes")
    return {name: tuple(value) if not isinstance(value, str | int | float) else value for name, value in known.items()}
