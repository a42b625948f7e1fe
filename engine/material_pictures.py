"""Pictures about a material for people: where its compression is off, and how it looks when it repeats."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from engine.colour import luminance, to_display8
from engine.contact_sheet import Picture, draw_error_map
from engine.shading.fit_error import Texel
from engine.shading.power_law import PowerLawMap
from engine.shading.shading_map import ShadingMap

#: Longest side of a tile in its preview, in pixels.
PREVIEW_SIDE = 512

REPEATS = 3


def error_picture(power_law: PowerLawMap, worst: Sequence[Texel] = ()) -> Picture:
    """The error of each texel relative to r_max in colours, with a bar that explains them and rings around `worst`."""
    relative = power_law.error_map / power_law.r_max
    caption = (
        f"RMS {power_law.rms / power_law.r_max:.4f} of r max over {relative.shape[1]} x {relative.shape[0]} texels"
    )
    return draw_error_map(relative, "error of a texel / r max", caption, [(row, column) for row, column, _ in worst])


def tile_preview(shading_map: ShadingMap) -> Picture:
    """The brightest slice, 3 x 3 times, in display colours; exposed so that one texel in a hundred is white."""
    image = _reduced(shading_map.slices[-1])
    white = float(np.percentile(luminance(image), 99.0))
    shown = to_display8(np.clip(image / white if white > 0 else image, 0.0, 1.0))
    return np.tile(shown, (REPEATS, REPEATS, 1))


def repeated(image: NDArray[np.float32]) -> NDArray[np.float32]:
    """Linear radiance (H, W, 3), reduced to `PREVIEW_SIDE` and 3 x 3 times."""
    return np.tile(_reduced(image), (REPEATS, REPEATS, 1))


def _reduced(image: NDArray[np.float32]) -> NDArray[np.float32]:
    height, width = image.shape[:2]
    share = PREVIEW_SIDE / max(height, width)
    if share >= 1.0:
        return image
    size = (max(1, round(width * share)), max(1, round(height * share)))
    return np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_AREA), np.float32)
