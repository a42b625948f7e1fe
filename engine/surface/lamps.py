"""The lamps of a capture as each texel sees them, and the slopes that they can tell.

A lamp in the direction l, at the distance D in widths of the image, lights the place p of the image along
v = l − p / D. The import has multiplied photographs of near lamps by |v|³ (`engine.capture.photograph.calibrate`), so
that a diffuse texel of the normal n has the radiance ρ n·v whatever its place: v is not normalised.

Three lamps that do not lie in one plane with the texel tell both slopes. Lamps in one plane, an arc, tell the slope
along it alone: turning the surface about the axis of the arc only dims all photographs alike.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.capture.stack import ImageStack
from engine.core.directions import Vectors, surface_direction
from engine.core.errors import InputError
from engine.surface.pbr_maps import ObservedSlopes

#: Lamps that are nearer to each other than this (radians) count as one.
SAME = np.radians(1.0)

#: Spread of lamps out of their common plane, over that within it, below which they are an arc.
FLAT = 0.1

#: The least number of lamps.
FEWEST = 3


@dataclass(frozen=True, eq=False)
class Lamps:
    """Directions (N, 3) of unit length, the inverse of the distance in widths of the image, and what they tell."""

    direction: Vectors
    nearness: float
    observed: ObservedSlopes

    @property
    def turn(self) -> float:
        """Azimuth of the first axis in which slopes are found: that of the arc, or 0."""
        return self.observed.azimuth or 0.0

    def observe_from(self, rows: NDArray[np.int64], columns: NDArray[np.int64], height: int, width: int) -> Vectors:
        """(N, T, 3) vectors from the texels at `rows` and `columns` (T,); (N, 1, 3) where lamps are distant.

        Their first axis is turned by `turn`, so that it runs along an arc.
        """
        towards = self.direction[:, None, :]
        if self.nearness > 0.0:
            x = (columns + 0.5) / width - 0.5
            y = (0.5 * height - 0.5 - rows) / width
            towards = towards - self.nearness * np.stack([x, y, np.zeros_like(x)], axis=-1)
        cosine, sine = np.cos(self.turn), np.sin(self.turn)
        along = cosine * towards[..., 0] + sine * towards[..., 1]
        across = cosine * towards[..., 1] - sine * towards[..., 0]
        return np.ascontiguousarray(np.stack([along, across, towards[..., 2]], axis=-1))


def lamps(stack: ImageStack, used: NDArray[np.int64]) -> Lamps:
    """The lamps of the photographs `used`.

    Raises InputError where azimuths are not known, or fewer than three lamps stand apart.
    """
    where = stack.folder or "the stack"
    if stack.azimuth is None:
        problem = "does not know the azimuth of its lamps, so it is not known in which direction slopes lie"
        raise InputError(
            where,
            problem,
            "Import it with a light list (.lp), with azimuth_deg in a capture.toml, or with --estimate-lights",
        )
    direction = surface_direction(0.5 * np.pi - stack.elevation[used], stack.azimuth[used])
    count = _apart(direction)
    if count < FEWEST:
        lit = "1 direction" if count == 1 else f"{count} directions"
        problem = f"is lit from {lit}, which do not separate a slope from a colour"
        raise InputError(where, problem, "Photograph it under lamps in three directions or more, from several sides")
    distance = stack.provenance.get("lamp_distance_widths")
    nearness = 1.0 / float(distance) if isinstance(distance, int | float) and distance > 0.5 else 0.0
    return Lamps(direction, nearness, observe_slopes(direction))


def observe_slopes(direction: Vectors) -> ObservedSlopes:
    """The slopes that lamps in these directions (N, 3) tell."""
    _, spread, axes = np.linalg.svd(direction, full_matrices=False)
    if spread[2] > FLAT * spread[1]:
        return ObservedSlopes("both")
    across = axes[2]
    return ObservedSlopes("along the arc", float(np.arctan2(-across[0], across[1]) % np.pi))


def apart(stack: ImageStack, used: NDArray[np.int64]) -> int:
    """The number of directions from which the photographs `used` are lit; ValueError where azimuths are not known."""
    if stack.azimuth is None:
        raise ValueError("the azimuth of each lamp is needed")
    return _apart(surface_direction(0.5 * np.pi - stack.elevation[used], stack.azimuth[used]))


def _apart(direction: Vectors) -> int:
    """The number of directions of which none is within `SAME` of one before it."""
    kept: list[Vectors] = []
    for each in direction:
        if all(each @ other < np.cos(SAME) for other in kept):
            kept.append(each)
    return len(kept)


def shows_slopes(stack: ImageStack) -> bool:
    """True where the lamps of a stack stood on sides that tell slopes in both directions."""
    if stack.azimuth is None:
        return False
    directions = surface_direction(0.5 * np.pi - stack.elevation, stack.azimuth)
    return observe_slopes(directions).kind == "both"
