"""An outline that a user draws around the object on a photograph, as the path of a pointer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from engine.core.errors import UsageError

#: Most points of an outline, the farthest place of one, and the least area in pixels of the photograph.
MAX_POINTS, MAX_PLACE, MIN_AREA = 2000, 1e6, 4.0


@dataclass(frozen=True)
class ObjectOutline:
    """An outline that was drawn around the object: x and y in pixels of a photograph (centres at integers).

    UsageError for fewer than three points, more than `MAX_POINTS`, or one that is no place.
    """

    points: tuple[tuple[float, float], ...]

    def __post_init__(self) -> None:
        if not 3 <= len(self.points) <= MAX_POINTS:
            raise UsageError(f"an outline of {len(self.points)} points is not possible (3 … {MAX_POINTS})")
        if not all(len(point) == 2 and max(map(abs, point)) < MAX_PLACE for point in self.points):
            raise UsageError("an outline has a point that is no place in a photograph")


def simplify_outline(points: Sequence[tuple[float, float]]) -> ObjectOutline | None:
    """An outline from the path of a pointer, without points that it runs straight through; None for no area."""
    if len(points) < 3:
        return None
    import cv2  # slow to load, and the window must open at once

    path = np.asarray(points, np.float32)[:, None]
    tolerance = 0.5
    kept = cv2.approxPolyDP(path, tolerance, True)[:, 0]
    while len(kept) > MAX_POINTS:
        tolerance *= 2.0
        kept = cv2.approxPolyDP(path, tolerance, True)[:, 0]
    if len(kept) < 3 or abs(cv2.contourArea(kept)) < MIN_AREA:
        return None
    return ObjectOutline(tuple((round(float(x), 2), round(float(y), 2)) for x, y in kept))
