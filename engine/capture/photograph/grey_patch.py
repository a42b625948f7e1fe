"""White balance from a grey patch in the image, measured on the photograph that exposes it best.

The patch's mean in camera colours (RAW) or linear sRGB (all else) becomes neutral; saturated pixels are left out. Best
exposed is the brightest patch of which no more than `CLIPPED` is saturated.
Cost: each photograph is decoded once more, at half size.
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.capture.photograph.decode import Photograph, ReadAhead
from engine.capture.photograph.radiometry import white_balance
from engine.core.errors import InputError, UsageError
from engine.core.steps import Steps

#: Share of a patch that may be saturated in the photograph on which it is measured.
CLIPPED = 0.05


@dataclass(frozen=True)
class GreyPatch:
    """A rectangle of pixels of the upright photographs that shows a grey or white surface."""

    left: int
    top: int
    width: int
    height: int

    def __post_init__(self) -> None:
        if min(self.left, self.top) < 0 or min(self.width, self.height) < 1:
            raise UsageError(f"grey patch {self} needs left and top from 0, width and height from 1")


def balance_of(
    photographs: list[Path], patch: GreyPatch, options: Mapping[str, Any]
) -> Steps[tuple[float, float, float]]:
    """Multipliers of red, green, blue that make `patch` neutral; InputError where no photograph shows it well.

    The photographs are read with `options` of `read_photograph`.
    """
    best: tuple[float, NDArray[np.float64], Path] | None = None
    with closing(ReadAhead(photographs, **options, white_balance="none", half_size=True)) as ahead:
        for index, path in enumerate(photographs):
            note = f"Measuring the grey patch in {index + 1} of {len(photographs)}"
            photograph = yield from ahead.next_photograph(index / len(photographs), note)
            colour = _colour(photograph, patch)
            if colour is not None and (best is None or float(colour.sum()) > best[0]):
                best = float(colour.sum()), colour, path
    if best is None:
        problem = "the grey patch is clipped in every photograph"
        raise InputError(photographs[0].parent, problem, "Pick a darker patch, or import with --white-balance none")
    multipliers = white_balance((1 / np.maximum(best[1], 1e-9)).tolist())
    if multipliers is None:
        colours = ", ".join(f"{value:.3g}" for value in best[1])
        problem = f"the grey patch is not light grey: its red, green and blue are {colours}"
        raise InputError(best[2], problem, "Pick another patch")
    red, green, blue = (float(value) for value in multipliers)
    return red, green, blue


def _colour(photograph: Photograph, patch: GreyPatch) -> NDArray[np.float64] | None:
    """Mean colour of the patch as the sensor saw it, None where too much of it is saturated."""
    height, width = photograph.saturated.shape
    rows = slice(patch.top // 2, max(patch.top // 2 + 1, (patch.top + patch.height) // 2))
    columns = slice(patch.left // 2, max(patch.left // 2 + 1, (patch.left + patch.width) // 2))
    if rows.stop > height or columns.stop > width:
        problem = f"the grey patch lies outside its {2 * width} × {2 * height} px"
        raise InputError(photograph.path, problem, "Give left,top,width,height within the photographs")
    known = ~photograph.saturated[rows, columns]
    if known.mean() < 1 - CLIPPED:
        return None
    mean: NDArray[np.float64] = photograph.radiance[rows, columns][known].mean(axis=0, dtype=np.float64)
    if photograph.camera_matrix:
        return np.linalg.solve(np.reshape(photograph.camera_matrix, (3, 3)), mean)
    return mean
