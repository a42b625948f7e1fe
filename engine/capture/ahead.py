"""Lights that lie at their places in a stack before it is imported, as those of a capture that is still being taken.

Where a list names all lights and the camera stands still, what an import writes of a photograph does not depend on the
others but for its place: its codes, of which what is found of the rig makes other radiance but no other bytes, or its
radiance, where it has no codes and nothing is found of all photographs together. It is then made as soon as the
photograph has been decoded, by the steps of the import: calibrated, noted, and written, in files that the import goes
on with. The import takes a light that was made of the same pixels by the same numbers and lies where it belongs, and
writes all others; so all bits are those of an import that begins with nothing. Half-written files lie in a hidden
folder that goes at the end, or with the next result that is written beside it.

Cost: as in the import; the disk is told to write at once, so that little is left to flush at the end.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from engine.capture.decoded import Kept, find_kept
from engine.capture.import_plan import ImportSettings
from engine.capture.lights.azimuth_spread import ONE_ARC, azimuth_spread, usual_motion
from engine.capture.lights.list_forms import LISTED
from engine.capture.lights.listed import Direction, Listed
from engine.capture.noted import Noted, note
from engine.capture.output import CodeForm, Output, Written, find_form
from engine.capture.output_region import View, view_of
from engine.capture.photograph.bayer import Mosaic
from engine.capture.photograph.calibration import Calibration
from engine.capture.photograph.decode import read_photograph
from engine.capture.waiting import Pixels, WaitingLight
from engine.core.errors import FileError
from engine.core.steps import drain
from engine.images.codes import Coded
from engine.images.decode import refuse_larger
from engine.storage.atomic import passing_folder


@dataclass(frozen=True, eq=False)
class AheadLight:
    """A light that lies at its place, `made_of` these pixels by the `numbers` of its calibration."""

    made_of: Coded | Mosaic | Pixels
    numbers: tuple[float, ...]
    noted: Noted
    written: Written


@dataclass(frozen=True, eq=False)
class Begun:
    """Files of a stack in a `folder`, with the `lights` that they hold by their places in a `view` of photographs;
    `form` is that of their codes where they hold these."""

    folder: Path
    view: View
    lights: dict[int, AheadLight]
    form: CodeForm | None = None

    def find(self, index: int, kept: Kept, numbers: tuple[float, ...] | None) -> AheadLight | None:
        """The light at a place where it was made of these pixels by these numbers; None where another is, or none."""
        light = self.lights.get(index)
        is_it = light is not None and light.made_of is kept.pixels and light.numbers == numbers
        return light if is_it else None


class WrittenAhead:
    """The lights of a capture, written beside `beside` for an import by `settings`; to be closed, which removes what no
    import has taken. `options` are those with which its photographs were decoded."""

    def __init__(self, beside: Path, settings: ImportSettings, options: dict[str, object]) -> None:
        self._beside, self._settings, self._options = beside, settings, options
        self._held, self._files = ExitStack(), ExitStack()
        self._lights: dict[int, AheadLight] = {}
        self._folder: Path | None = None
        self._size: tuple[int, int] | None = None
        self._output: Output | None = None
        self._failed = False
        _open.append(self)

    @property
    def count(self) -> int:
        """The number of lights that lie there, 0 while some of that is still on its way to the disk."""
        is_writing = self._output is not None and self._output.is_writing
        return 0 if is_writing else len(self._lights)

    def write_next(self, photographs: Sequence[Path], listed: Listed) -> None:
        """Write one light of which the photograph is there and nothing is written; none while the disk is busy."""
        if self._failed or not _is_known_of_each(self._settings, listed.directions):
            return
        if self._output is not None and self._output.is_writing:
            return
        ranks = {place: rank for rank, place in enumerate(listed.order)}
        for path, place in zip(photographs, listed.places(photographs), strict=True):
            kept = find_kept(path, self._options) if place is not None else None
            if place is None or kept is None or kept.pixels is None:
                continue
            index, before = ranks[place], self._lights.get(ranks[place])
            if before is None or before.made_of is not kept.pixels:
                self._lights.pop(index, None)
                try:
                    self._write(path, kept, index, listed, place)
                except FileError:  # of which the import says more
                    self._failed = True
                return

    def _write(self, path: Path, kept: Kept, index: int, listed: Listed, place: int) -> None:
        (elevation_deg, azimuth_deg), settings = listed.directions[place], self._settings
        elevation, azimuth = (float(np.radians(each)) for each in (elevation_deg, azimuth_deg or 0.0))
        calibration = Calibration(lamp_distance=settings.lamp_distance or listed.lamp_distance or math.inf)
        factor = 1.0 / (float(listed.gains[place]) if listed.gains else 1.0)
        photograph = read_photograph(path, **self._options)  # type: ignore[arg-type]
        numbers = calibration.numbers(photograph, elevation, azimuth, factor)
        photograph = calibration.applied(photograph, elevation, azimuth, factor)
        radiance, saturated = photograph.radiance, photograph.saturated
        refuse_larger(path, radiance)
        is_plain = _is_plain(self._settings, listed.directions)
        coded = kept.coded if self._settings.framing is None else None
        form = None if coded is None else find_form(coded)
        output = self._open(len(listed.directions), saturated.shape, path.parent, form)
        if self._size != saturated.shape or numbers is None or kept.pixels is None or output.form != form:
            return
        pixels = Pixels(radiance, saturated)
        if coded is not None:
            written = drain(output.write_codes(index, coded, output.cut(pixels)))
        elif is_plain:
            written = drain(output.write(index, WaitingLight(pixels), np.eye(3)))
        else:
            return
        output.synchronise()
        noted = note(radiance, saturated, with_grey=not is_plain)
        self._lights[index] = AheadLight(kept.pixels, numbers, noted, written)

    def _open(self, count: int, size: tuple[int, int], place: Path, form: CodeForm | None) -> Output:
        if self._output is None:
            self._folder = self._held.enter_context(passing_folder(self._beside))
            view = view_of(self._settings, np.eye(3)[None], size, place)
            self._output, self._size = Output(self._files, self._folder, count, view, size, form=form), size
        return self._output

    def hand_over(self, settings: ImportSettings, place: Path) -> Begun | None:
        """Give the files to an import by `settings` into the folder `place`; None where they hold nothing, are on
        another disk, or show another part of the photographs. Nothing is written afterwards."""
        output, folder, self._output = self._output, self._folder, None
        if output is None or folder is None or self._size is None or not self._lights or self._failed:
            return None
        self._failed = True
        try:
            self._files.close()
            view = view_of(settings, np.eye(3)[None], self._size, place)
            same_disk = folder.stat().st_dev == place.stat().st_dev
        except (FileError, OSError):
            return None
        is_same = same_disk and output.view.is_same(view)
        return Begun(folder, view, self._lights, output.form) if is_same else None

    def close(self) -> None:
        """Remove what no import has taken."""
        if self in _open:
            _open.remove(self)
        self._failed = True
        try:
            self._files.close()
        except FileError:  # nobody wants it
            pass
        finally:
            self._held.close()


_open: list[WrittenAhead] = []


def take_begun(settings: ImportSettings, place: Path) -> Begun | None:
    """Files that were begun for an import by `settings` into the folder `place`, once; None where there are none."""
    return next((begun for each in tuple(_open) if (begun := each.hand_over(settings, place)) is not None), None)


def _azimuth_of(directions: Sequence[Direction]) -> NDArray[np.float64] | None:
    """Azimuths in radians; None where they are not known of all."""
    azimuths = [azimuth for _, azimuth in directions if azimuth is not None]
    return np.radians(azimuths) if len(azimuths) == len(directions) else None


def _is_plain(settings: ImportSettings, directions: Sequence[Direction]) -> bool:
    """True where nothing is to be found of all photographs together."""
    return settings.calibrate == "none" or azimuth_spread(_azimuth_of(directions)) <= ONE_ARC


def _is_known_of_each(settings: ImportSettings, directions: Sequence[Direction]) -> bool:
    """True where the codes of each photograph, or its radiance, lie at one place whatever the others are; and each is a
    light of its own."""
    motion = settings.motion if settings.motion != "auto" else usual_motion(_azimuth_of(directions))
    is_plain = _is_plain(settings, directions) or settings.crop is None
    others = (settings.chart, settings.lens, settings.equalise, settings.lights, settings.second_sphere)
    is_listed = settings.lights_form == LISTED and not settings.estimate_lights and len(directions) > 1
    return motion == "none" and is_plain and is_listed and not settings.control_points and others == (None,) * 5
