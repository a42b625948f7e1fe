"""A capture's calibration as the import applies it: frames are read once, photographs corrected one at a time.

    radiance = (sample - dark) * flat-field gain * near-lamp gain * balance * exposure factor

in the terms of `engine.capture.photograph.calibrate`. Frames of each lamp take the place of those of all: the flat
field F_i of lamp i, at the elevation e_i, gives (sample - dark_i) m sin(e_i) / (F_i - dark_i), with m the median over
lamps of mean(F_i - dark_i) / sin(e_i). That is the radiance under lamps of equal intensity without fall-off, whatever
their distance, since a white card shows the irradiance d sin(e) / |v|³ itself. What the flat field cannot tell, and
where it was at white, joins the saturation mask.
Cost: for 24 megapixels 0.5 s a photograph, and 0.3 GB for each frame; frames of each lamp are decoded once more.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from contextlib import closing
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.capture.photograph.calibrate import DARKEST_FLAT, flat_field_gain, near_lamp_gain
from engine.capture.photograph.decode import Photograph, ReadAhead, read_photograph
from engine.capture.photograph.lens import Lens
from engine.core.errors import InputError, UsageError
from engine.core.steps import Step, Steps
from engine.storage.scratch import release, scratch_array

_BAND_ROWS = 128

#: Elevation (radians) below which a flat field is not divided by less: its lamp grazes the card.
MIN_ELEVATION = math.radians(3.0)


@dataclass(frozen=True, eq=False)
class Calibration:
    """Corrections that are divided out of every photograph.

    Attributes
    ----------
    dark, gain : (H, W, 3) float32 dark frame and gain of the flat field, None where there is none.
    unknown : (H, W) bool, where the flat field cannot tell.
    lamp_distance : of a near lamp in widths of the image, infinite for a distant one.
    lens : distortion that is taken off after the frames, None for none.
    flats, darks : the frame of each lamp by the photograph that it belongs to, in place of the above; `level` (3,) is
        m of the flat fields. They are read with `options` when they are needed.
    balance : (3,) factors of red, green, blue for photographs that are not RAW, whose decoder balances them.
    """

    dark: NDArray[np.float32] | None = None
    gain: NDArray[np.float32] | None = None
    unknown: NDArray[np.bool_] | None = None
    lamp_distance: float = math.inf
    balance: tuple[float, float, float] = (1.0, 1.0, 1.0)
    flats: Mapping[Path, Path] = field(default_factory=dict)
    darks: Mapping[Path, Path] = field(default_factory=dict)
    level: NDArray[np.float64] | None = None
    options: Mapping[str, Any] = field(default_factory=dict)
    lens: Lens | None = None

    def of_lamp(self, photograph: Path, elevation: float) -> Calibration:
        """The calibration of one photograph, with the frames of its lamp read."""
        dark, gain, unknown = self.dark, self.gain, self.unknown
        if photograph in self.darks:
            dark = read_photograph(self.darks[photograph], **self.options).radiance
        if photograph in self.flats and self.level is not None:
            white = read_photograph(self.flats[photograph], **self.options)
            if dark is not None and dark.shape != white.radiance.shape:
                raise InputError(white.path, "has not the size of its dark frame", "Give frames of the same camera")
            light = white.radiance.astype(np.float64) - (0.0 if dark is None else dark)
            wanted = self.level * math.sin(max(elevation, MIN_ELEVATION))
            unknown = white.saturated | (light < DARKEST_FLAT * light.mean(axis=(0, 1))).any(axis=-1)
            gain = np.where(unknown[..., None], 1.0, wanted / np.where(unknown[..., None], 1.0, light))
            gain = gain.astype(np.float32)
        return replace(self, dark=dark, gain=gain, unknown=unknown, flats={}, darks={})

    def applied(self, photograph: Photograph, elevation: float, azimuth: float, factor: float) -> Photograph:
        """`photograph` of a lamp at these angles (radians), corrected; `factor` brings it to the scale of the stack.

        Raises InputError where its size is not that of the calibration frames.
        """
        if photograph.path in self.flats or photograph.path in self.darks:
            return self.of_lamp(photograph.path, elevation).applied(photograph, elevation, azimuth, factor)
        if self.lens is not None:
            frames = replace(self, lens=None, lamp_distance=math.inf)
            photograph = self._straighten(frames.applied(photograph, elevation, azimuth, factor))
            return Calibration(lamp_distance=self.lamp_distance).applied(photograph, elevation, azimuth, 1.0)
        if self.leaves(photograph, factor):
            return photograph
        factors = self.factors(photograph, factor)
        self._check_size(photograph)
        radiance, saturated = np.empty_like(photograph.radiance), photograph.saturated.copy()
        for first in range(0, len(radiance), _BAND_ROWS):
            band = np.s_[first : first + _BAND_ROWS]
            radiance[band] = photograph.radiance[band]
            self._correct(radiance[band], saturated[band], first, len(radiance), elevation, azimuth, factors)
        for frame in (self.dark, self.gain):
            if frame is not None:
                release(frame)
        return replace(photograph, radiance=radiance, saturated=saturated)

    def leaves(self, photograph: Photograph, factor: float) -> bool:
        """True where a photograph stays as it is."""
        is_plain = self.is_by_pixel and self.dark is None and self.gain is None and math.isinf(self.lamp_distance)
        return is_plain and bool((self.factors(photograph, factor) == 1).all())

    def numbers(
        self, photograph: Photograph, elevation: float, azimuth: float, factor: float
    ) -> tuple[float, ...] | None:
        """All that decides what becomes of a photograph besides itself; None where it is more than a few numbers."""
        if not self.is_by_pixel or self.dark is not None or self.gain is not None:
            return None
        near = (self.lamp_distance, elevation, azimuth) if math.isfinite(self.lamp_distance) else ()
        return *self.factors(photograph, factor).tolist(), *near

    @property
    def is_by_pixel(self) -> bool:
        """True where the same frames are for all photographs, and each pixel is corrected by itself."""
        return self.lens is None and not self.flats and not self.darks

    def correct_rows(
        self,
        rows: tuple[NDArray[np.float32], NDArray[np.bool_]],
        first: int,
        photograph: Photograph,
        height: int,
        elevation: float,
        azimuth: float,
        factor: float,
    ) -> None:
        """As `applied`, in place, for rows from `first` on of the radiance and saturation of a photograph.

        `photograph` tells what the photograph of this `height` is, and `is_by_pixel` holds.
        """
        self._correct(*rows, first, height, elevation, azimuth, self.factors(photograph, factor))

    def factors(self, photograph: Photograph, factor: float) -> NDArray[np.float32]:
        """(3,) of the channels of a photograph, `factor` included."""
        balance = 1.0 if photograph.container == "RAW" else np.array(self.balance)
        return np.asarray(np.full(3, factor) * balance, np.float32)

    def _correct(
        self,
        radiance: NDArray[np.float32],
        saturated: NDArray[np.bool_],
        first: int,
        height: int,
        elevation: float,
        azimuth: float,
        factors: NDArray[np.float32],
    ) -> None:
        band = np.s_[first : first + len(radiance)]
        if self.dark is not None:
            radiance -= self.dark[band]
        with np.errstate(over="ignore"):  # infinite radiance is refused with all that is too large
            if (factors != 1).any():
                radiance *= factors
            if self.gain is not None:
                radiance *= self.gain[band]
            if math.isfinite(self.lamp_distance):
                rows = (first, first + len(radiance))
                even = near_lamp_gain(height, radiance.shape[1], self.lamp_distance, elevation, azimuth, rows)
                radiance *= even[..., None]
        if self.unknown is not None:
            saturated |= self.unknown[band]

    def _straighten(self, photograph: Photograph) -> Photograph:
        lens = self.lens
        assert lens is not None
        height, width = photograph.saturated.shape
        if (width, height) != (lens.width, lens.height):
            sizes = (
                f"has {width} × {height} px",
                f"the lens was measured in photographs of {lens.width} × {lens.height} px",
            )
            problem = ", but ".join(sizes)
            raise InputError(photograph.path, problem, "Measure it with the same camera, in the same orientation")
        radiance, saturated = lens.straighten(photograph.radiance, photograph.saturated)
        return replace(photograph, radiance=radiance, saturated=saturated)

    def _check_size(self, photograph: Photograph) -> None:
        for frame, kind in ((self.dark, "dark frame"), (self.gain, "flat field")):
            if frame is not None and frame.shape != photograph.radiance.shape:
                sizes = [f"{shape[1]} × {shape[0]} px" for shape in (photograph.radiance.shape, frame.shape)]
                problem = f"has {sizes[0]}, but the {kind} has {sizes[1]}"
                raise InputError(photograph.path, problem, "Give frames of the same camera, or leave them out")


def measure_level(
    flats: Mapping[Path, Path], darks: Mapping[Path, Path], elevations: Mapping[Path, float], options: dict[str, Any]
) -> Steps[NDArray[np.float64]]:
    """(3,) median over lamps of the mean of a flat field over the sine of the lamp's elevation.

    InputError names a flat field without light.
    """
    found: list[NDArray[np.float64]] = []
    for photograph, path in flats.items():
        yield Step(len(found) / len(flats), f"Reading {path.name}")
        light = read_photograph(path, half_size=True, **options).radiance.mean(axis=(0, 1), dtype=np.float64)
        if photograph in darks:
            dark = read_photograph(darks[photograph], half_size=True, **options)
            light = light - dark.radiance.mean(axis=(0, 1), dtype=np.float64)
        if not (light > 0.0).all():
            raise InputError(path, "is a flat field without light", "Give one of an even white surface under its lamp")
        found.append(light / math.sin(max(elevations[photograph], MIN_ELEVATION)))
    level: NDArray[np.float64] = np.median(found, axis=0)
    return level


def read_calibration(
    dark: Path | None,
    flat: Path | None,
    lamp_distance: float,
    balance: tuple[float, float, float],
    options: dict[str, Any],
) -> Steps[Calibration]:
    """The calibration from its frames, which are read with `options` of `read_photograph`, as the photographs are."""
    paths = [path for path in (dark, flat) if path is not None]
    with closing(ReadAhead(paths, **options)) as ahead:
        read = []
        for path in paths:
            read.append((yield from ahead.next_photograph(0.0, f"Reading {path.name}")))
    if not read:
        return Calibration(lamp_distance=lamp_distance, balance=balance)
    if len({photograph.radiance.shape for photograph in read}) > 1:
        problem = f"has not the size of the dark frame {read[0].path.name}"
        raise InputError(read[1].path, problem, "Give frames of the same camera, or leave one out")
    frames = scratch_array((len(read), *read[0].radiance.shape), np.float32)
    dark_frame = None
    if dark is not None:
        dark_frame = frames[0]
        dark_frame[...] = read[0].radiance
    if flat is None:
        return Calibration(dark_frame, None, None, lamp_distance, balance)
    white = read[-1]
    try:
        gain, unknown = flat_field_gain(white.radiance, dark_frame)
    except UsageError as error:
        raise InputError(
            flat, f"is not a usable flat field: {error}", "Give another, or import with --no-flat"
        ) from None
    frames[-1] = gain
    return Calibration(dark_frame, frames[-1], unknown | white.saturated, lamp_distance, balance)
