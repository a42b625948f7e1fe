"""Size of a texel in millimetres, from what a user states or the photographs show.

The scale of the photographs is stated, or follows from two points whose distance is known, or from a colour chart whose
patches have a known pitch. Charts of one layout are sold in many sizes, so that the pitch has to be stated: measured
over five patches with a ruler it is known to some 0.2 %. Where a framing samples the photographs anew, its texels are
larger or smaller by the root of the area that one covers in the middle.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from engine.core.errors import UsageError
from engine.core.figure_text import number

#: Sizes of a pixel that are believed, in millimetres: from a microscope to a hall.
SIZES_MM = (1e-5, 100.0)

#: Labels of what tells a scale.
SOURCES = {
    "stated": "as stated",
    "length": "by the known length",
    "chart": "by the chart",
    "exif": "an estimate from the camera's notes",
}

#: Hint beside the millimetres of a sample.
EXTENT_HINT = "Size of the sample by its scale; ≈ where that is an estimate from the camera's notes"

#: Standard deviation with which a user marks the end of a length, in pixels.
MARKED_PX = 0.5

#: Relative standard deviations of the focal length, which close focus shortens by up to a fifth, of the distance that
#: a camera notes, and of one that a user measures; and distance of the principal planes of a lens, in millimetres.
FOCAL_SIGMA, FOCUS_SIGMA, MEASURED_SIGMA, PRINCIPAL_MM = 0.05, 0.1, 0.01, 20.0

#: Rows and columns of patches of a classic chart, in the order of its colours.
ROWS, COLUMNS = 4, 6

#: Relative difference of scales over a chart from which it lies too obliquely to tell one.
OBLIQUE = 0.12


@dataclass(frozen=True)
class KnownLength:
    """Two points of the reference photograph (x, y in pixels) that lie so many millimetres apart; UsageError if not."""

    first: tuple[float, float]
    second: tuple[float, float]
    length_mm: float

    def __post_init__(self) -> None:
        if not 0.0 < self.length_mm < math.inf or not self.length_px > 2.0:
            raise UsageError("a known length needs points more than two pixels apart, and millimetres above 0")
        _check_size(self.length_mm / self.length_px)

    @property
    def length_px(self) -> float:
        return math.dist(self.first, self.second)


@dataclass(frozen=True)
class ChartPitch:
    """Distance of the middles of neighbouring patches of the colour chart, in millimetres."""

    pitch_mm: float

    def __post_init__(self) -> None:
        if not 0.1 <= self.pitch_mm <= 1000.0:
            raise UsageError(f"patches {self.pitch_mm:g} mm apart are not those of a chart: give 0.1 to 1000 mm")


@dataclass(frozen=True)
class CameraDistance:
    """Estimate the scale from the focal length and the pixels of the sensor as cameras note them, and the distance.

    `distance_mm` is that of the sample from the sensor as a user measured it, None for that of the camera's focus.
    """

    distance_mm: float | None = None

    def __post_init__(self) -> None:
        if self.distance_mm is not None and not 10.0 <= self.distance_mm <= 1e5:
            raise UsageError(f"a sample {self.distance_mm:g} mm from the sensor is not within 10 mm to 100 m")


#: Choice of a user: millimetres per pixel of the photographs, or what tells it.
ScaleChoice = float | KnownLength | ChartPitch | CameraDistance


@dataclass(frozen=True)
class Scale:
    """Millimetres per pixel of the reference photograph, with its standard deviation."""

    mm_per_pixel: float
    sigma: float
    source: Literal["stated", "length", "chart", "exif"]

    def as_json(self, magnification: float) -> dict[str, Any]:
        """Return the record of a stack whose texels are `magnification` pixels wide."""
        size, sigma = self.mm_per_pixel * magnification, self.sigma * magnification
        return {"mm_per_texel": size, "sigma_mm": sigma, "source": self.source}


def check_scale(choice: ScaleChoice | None) -> None:
    """Raise UsageError for a stated size that no pixel has."""
    if isinstance(choice, int | float):
        _check_size(float(choice))


def scale_of(choice: float | KnownLength) -> Scale:
    """The scale that a user states by itself or by a known length."""
    if isinstance(choice, KnownLength):
        size = choice.length_mm / choice.length_px
        return Scale(size, size * math.sqrt(2.0) * MARKED_PX / choice.length_px, "length")
    return Scale(float(choice), 0.0, "stated")


def scale_of_camera(focal_mm: float, pitch_mm: float, distance_mm: float, *, is_measured: bool) -> Scale:
    """An estimate of the scale, of a sample at this distance from the sensor.

    A thin lens shows the size m with D = f (2 + m + 1 / m). A distance that a camera notes may as well be that from the
    lens, where m = f / (D − f): the estimate lies between both. UsageError for a distance that no lens focuses.
    """
    ratio = distance_mm / focal_mm
    if ratio <= 4.0:  # below four focal lengths nothing is in focus
        least = 4.0 * focal_mm
        raise UsageError(f"a lens of {focal_mm:g} mm focuses nothing nearer than {least:g} mm from the sensor")
    half = 0.5 * (ratio - 2.0)
    by_sensor = pitch_mm * (half + math.sqrt(half * half - 1.0))
    by_lens = pitch_mm * (ratio - 1.0)
    size = by_sensor if is_measured else 0.5 * (by_sensor + by_lens)
    apart = PRINCIPAL_MM / distance_mm if is_measured else 0.5 * abs(by_lens - by_sensor) / size
    relative = math.hypot(FOCAL_SIGMA, MEASURED_SIGMA if is_measured else FOCUS_SIGMA, apart)
    _check_size(size)
    return Scale(size, size * relative, "exif")


def scale_of_chart(positions: NDArray[np.float64], pitch_mm: float) -> Scale:
    """The scale at a chart whose patches have their middles at `positions` (24, 2) in pixels, row by row.

    Raises UsageError for a chart that lies too obliquely.
    """
    import cv2

    columns, rows = np.meshgrid(np.arange(COLUMNS, dtype=float), np.arange(ROWS, dtype=float))
    grid = pitch_mm * np.stack([columns.ravel(), rows.ravel()], axis=1)
    matrix = np.asarray(cv2.findHomography(grid, positions)[0], np.float64)
    shown = cv2.perspectiveTransform(grid[None], matrix)[0]
    residual = float(np.sqrt(((shown - positions) ** 2).sum() / (2 * len(grid) - 8)))
    corners = grid[[0, COLUMNS - 1, -COLUMNS, -1]]
    sizes = [1.0 / math.sqrt(abs(_area(matrix, each))) for each in corners]
    size = 1.0 / math.sqrt(abs(_area(matrix, grid.mean(axis=0))))
    if max(sizes) - min(sizes) > OBLIQUE * size:
        raise UsageError("the chart lies obliquely: its scale differs over it by more than 12 %")
    spread = float(np.sqrt(((positions - positions.mean(axis=0)) ** 2).sum()))
    return Scale(size, size * math.hypot(residual / spread, 0.25 * (max(sizes) - min(sizes)) / size), "chart")


def magnification_of(matrix: NDArray[np.float64], width: int, height: int) -> float:
    """Pixels of a photograph along a texel in the middle of a framing of this size, whose `matrix` (3, 3) takes texels
    to pixels."""
    return math.sqrt(abs(_area(matrix, np.array([0.5 * (width - 1), 0.5 * (height - 1)]))))


def mm_per_texel(provenance: Mapping[str, Any]) -> float | None:
    """The size of a texel that a record states, None where it does not."""
    found = provenance.get("scale")
    size = found.get("mm_per_texel") if isinstance(found, dict) else None
    return float(size) if isinstance(size, int | float) and 0.0 < size < math.inf else None


def scale_text(record: Mapping[str, Any], width: int, height: int) -> str:
    """A sentence about the scale of a stack of `width` × `height` texels."""
    size = float(record["mm_per_texel"])
    return f"{size_text(record)}: {number(size * width, 4)} × {number(size * height, 4)} mm"


def size_text(record: Mapping[str, Any]) -> str:
    """The size of a texel with its 95 % interval, and what tells it."""
    size, sigma = float(record["mm_per_texel"]), float(record["sigma_mm"])
    known = f" ± {number(2.0 * sigma, 2)}" if sigma else ""
    return f"{number(size, 4)}{known} mm per texel, {SOURCES[record['source']]}"


def extent_text(provenance: Mapping[str, Any], width: int, height: int) -> str:
    """The millimetres of so many texels, with ≈ where they are an estimate; empty where they are not known."""
    texel = mm_per_texel(provenance)
    if texel is None:
        return ""
    about = "≈ " if is_estimate(provenance) else ""
    return f"{about}{number(texel * width, 3)} × {number(texel * height, 3)} mm"


def is_estimate(provenance: Mapping[str, Any]) -> bool:
    """Return whether the size of a texel that a record states is an estimate by the camera's notes."""
    found = provenance.get("scale")
    return isinstance(found, dict) and found.get("source") == "exif"


def _area(matrix: NDArray[np.float64], point: NDArray[np.float64]) -> float:
    """Determinant of the derivative of a perspective map at a point."""
    scale = matrix[2] @ [*point, 1.0]
    return float(np.linalg.det(matrix) / scale**3)


def _check_size(mm: float) -> None:
    if not SIZES_MM[0] <= mm <= SIZES_MM[1]:
        raise UsageError(f"a pixel of {mm:g} mm is not within {SIZES_MM[0]:g} to {SIZES_MM[1]:g} mm")
