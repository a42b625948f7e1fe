"""Pixels of the photographs that a stack shows, and their sampling density.

Without a framing that is the largest rectangle of whole pixels which all photographs show, cut to the wanted crop.
With one, the framing's matrix follows each photograph's alignment, so that pixels are still resampled only once.
Cost: none worth mentioning.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.capture.import_plan import ImportSettings
from engine.capture.registration.framing import (
    Corners,
    Framing,
    framing_matrix,
    inside_all,
    rectify,
    samples_per_side,
)
from engine.capture.registration.warp import Region, valid_region
from engine.capture.scale import KnownLength
from engine.core.errors import InputError, UsageError

Matrix = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class View:
    """Rows and columns of `region`, taken by `matrix` (3, 3) to pixels of the reference.

    Each pixel is the mean of samples × samples places; `framing` is what the matrix was made of, if it was.
    """

    region: Region
    matrix: Matrix
    samples: int = 1
    framing: Framing | None = None

    def is_same(self, other: View) -> bool:
        """True where the other shows the same pixels."""
        same = self.region == other.region and self.samples == other.samples
        return same and np.array_equal(self.matrix, other.matrix)

    def as_json(self) -> dict[str, Any]:
        """For the provenance."""
        region, framing = self.region, self.framing
        if framing is None:
            return {"crop_px": [region.left, region.top, region.width, region.height], "framing": None}
        corners = [[float(x), float(y)] for x, y in framing.corners]
        size = {"width_px": framing.width_px, "height_px": framing.height_px}
        return {"crop_px": None, "framing": {"corners_px": corners, **size}}


def _check_length(known: KnownLength, size: tuple[int, int], place: Path) -> None:
    """InputError where an end of the known length lies outside the photograph (height, width)."""
    for x, y in (known.first, known.second):
        if not (-0.5 <= x <= size[1] - 0.5 and -0.5 <= y <= size[0] - 0.5):
            problem = f"the known length ends at {x:g},{y:g}, outside the {size[1]} × {size[0]} px of the photographs"
            raise InputError(place, problem, "Give the points in pixels of the photographs, from the top left")


def view_of(settings: ImportSettings, matrices: Matrix, size: tuple[int, int], place: Path) -> View:
    """Part of photographs of `size` (height, width), aligned by `matrices` (N, 3, 3), that `settings` ask for.

    Raises InputError for `place` where that is nothing, or where a framing reaches beyond a photograph.
    """
    if isinstance(settings.scale, KnownLength):
        _check_length(settings.scale, size, place)
    if settings.framing is not None:
        return _frame(settings.framing, matrices, size, place)
    shared = valid_region(matrices, *size)
    if shared.width < 1 or shared.height < 1:
        problem = "the photographs were moved so far apart that no pixel is seen by all"
        raise InputError(place, problem, "Check the control points, or leave out what does not belong")
    if settings.crop is None:
        return View(shared, np.eye(3))
    cut = shared.intersected(Region(*settings.crop))
    if cut.width < 1 or cut.height < 1:
        problem = f"the crop {','.join(map(str, settings.crop))} lies outside what all {size[1]} × {size[0]} px show"
        raise InputError(place, problem, "Give left,top,width,height within the photographs")
    return View(cut, np.eye(3))


def _frame(wanted: Framing | Corners, matrices: Matrix, size: tuple[int, int], place: Path) -> View:
    try:
        framing = wanted if isinstance(wanted, Framing) else rectify(wanted, None, size)
    except UsageError as error:
        problem = f"no image can be made between these corners: {error}"
        raise InputError(place, problem, "Move the corners, or give the size of the image") from None
    if not inside_all(framing, list(matrices), *size):
        corners = "  ".join(f"{x:g},{y:g}" for x, y in framing.corners)
        problem = f"the image between {corners} reaches beyond what all {size[1]} × {size[0]} px show"
        raise InputError(place, problem, "Move its corners inwards, or leave out the photograph that was moved most")
    matrix = framing_matrix(framing)
    samples = samples_per_side(matrix, framing.width_px, framing.height_px)
    return View(Region(0, 0, framing.width_px, framing.height_px), matrix, samples, framing)
