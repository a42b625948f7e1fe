"""The direction in which an anisotropic surface is brushed: along its texture, or along a constant vector.

A constant vector is projected into the surface at each point (Kautz2002 Sec. 6); where it stands on the surface, the
frame is that of a surface without a direction.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, isfinite, radians, sin

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.core.directions import frames_along, normalize
from engine.core.errors import UsageError
from engine.core.params import check, param

#: Words for constant vectors.
AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}

#: The word for the first coordinate of the texture.
TEXTURE = "u"


@dataclass(frozen=True)
class Brushing:
    """The tangent of an anisotropic BRDF.

    Attributes
    ----------
    along : a vector in the coordinates of the model, of any length; None for dP/du, along the texture.
    angle_deg : by which the tangent is rotated about the normal, anticlockwise seen from outside.
    """

    along: tuple[float, float, float] | None = None
    angle_deg: float = param(0.0, -360.0, 360.0, slider=(-180.0, 180.0), unit="°", doc="Angle of the brushing.")

    def __post_init__(self) -> None:
        if self.along is not None and not (all(map(isfinite, self.along)) and any(self.along)):
            raise UsageError(f"a brushing direction {self.along} is not a vector of a length; give x, y, z or 1,0,0")
        check(self)

    def __str__(self) -> str:
        """The text that `parse_brushing` reads."""
        words = {axis: word for word, axis in AXES.items()}
        along = TEXTURE if self.along is None else words.get(self.along) or ",".join(f"{x:.9g}" for x in self.along)
        return along if self.angle_deg == 0.0 else f"{along}:{self.angle_deg:.9g}"

    def rotate(self, normals: ArrayLike, textured: ArrayLike) -> NDArray[np.float32]:
        """Tangents (V, 3) at unit `normals` (V, 3) where those along the texture are `textured` (V, 3)."""
        tangent = np.asarray(textured, np.float64)
        if self.along is not None:
            tangent = np.broadcast_to(normalize(np.asarray(self.along)), tangent.shape)
        if self.angle_deg == 0.0:
            return tangent.astype(np.float32)
        frames, angle = frames_along(normals, tangent), radians(self.angle_deg)
        return np.asarray(cos(angle) * frames[..., 0] + sin(angle) * frames[..., 1], np.float32)


def parse_brushing(text: str) -> Brushing:
    """Read `u`, `y`, `1,0,0`, each with `:30` for an angle in degrees; UsageError for anything else.

    >>> parse_brushing("y:30")
    Brushing(along=(0.0, 1.0, 0.0), angle_deg=30.0)
    """
    direction, _, angle = text.strip().partition(":")
    direction = direction.strip().lower()
    try:
        angle_deg = float(angle) if angle else 0.0
        if direction == TEXTURE:
            return Brushing(None, angle_deg)
        x, y, z = AXES.get(direction) or map(float, direction.split(","))
    except ValueError:
        raise UsageError(
            f"{text[:80]!r} is not a brushing direction; give u for the texture's, x, y, z or a vector as 1,0,0, and "
            "an angle behind a colon: y:30"
        ) from None
    return Brushing((x, y, z), angle_deg)
