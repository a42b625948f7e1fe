"""The scene of a proof: the whole material as a flat square, seen from straight above, under one lamp.

Nothing but the material can differ then: no model, no camera, no environment. The lamp has an irradiance of pi on a
surface that faces it, so that a white diffuse surface shows the cosine; formats without a scale of their own, RTI, take
one of 1. Images are linear, (H, W, 3), one pixel for a texel; of larger maps the middle `SIDE` texels count.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.core.directions import surface_direction
from engine.exchange.loss import Shown, View
from engine.light.environment import DistantLights

Floats = NDArray[np.float64]

#: Most texels along a side, and the lamp: angles from the normal and about it, at the upper left.
SIDE, TILT_DEG, AZIMUTH_DEG = 512, 40.0, 135.0

#: Pixels of the ball that stands for a BRDF alone.
SPHERE = 96


@dataclass(frozen=True, eq=False)
class Drawn:
    """A consumer, the image that it drew (None where it draws none), and what it said, in sentences.

    Attributes
    ----------
    target : the target of the export that it read.
    name : of the program with its version.
    is_sound : False where it complained, None where it is absent from this machine.
    """

    target: str
    name: str
    image: Floats | None
    words: str
    is_sound: bool | None = True


def lamp() -> Floats:
    """(3,) the direction towards the lamp."""
    return np.asarray(surface_direction(np.radians(TILT_DEG), np.radians(AZIMUTH_DEG)), np.float64)


def draw_ourselves(shown: Shown, size: tuple[int, int], irradiance: float) -> Floats:
    """(H, W, 3) radiance of the square as a representation of maps of `size` (H, W) shows it."""
    rows, columns = (value.ravel() for value in np.indices(size))
    frames = np.broadcast_to(np.eye(3), (len(rows), 3, 3))
    above = np.broadcast_to(np.array([0.0, 0.0, 1.0]), (len(rows), 3))
    view = View(rows, columns, frames, above, np.ones(size, np.bool_))
    lights = DistantLights(lamp()[None], np.full((1, 3), irradiance))
    return np.asarray(shown(view, lights), np.float64).reshape(*size, 3)


def middle(image: Floats) -> Floats:
    """At most `SIDE` pixels a side from the middle."""
    height, width = (_keep(length) for length in image.shape[:2])
    top, left = (image.shape[0] - height) // 2, (image.shape[1] - width) // 2
    return image[top : top + height, left : left + width]


def relative_rmse(found: Floats, wanted: Floats) -> float:
    """Root of the summed squares of the difference over that of `wanted`."""
    whole = float(np.sum(wanted**2))
    return float(np.sqrt(np.sum((found - wanted) ** 2) / whole)) if whole > 0.0 else 0.0


def windows(size: tuple[int, int]) -> tuple[tuple[int, int], tuple[float, float]]:
    """(height, width) in pixels of what `middle` leaves of maps of `size`, and the shares of the square that it is."""
    height, width = (_keep(length) for length in size)
    return (height, width), (height / size[0], width / size[1])


def _keep(length: int) -> int:
    """Texels of the middle of `length`, as many left out on one side as on the other."""
    return length if length <= SIDE else SIDE - (length - SIDE) % 2
