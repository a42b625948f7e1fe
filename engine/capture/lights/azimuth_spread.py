"""Spread of the lights of a capture about one arc, which the method assumes (Kautz2004 Sec. 3)."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from engine.core.health import Finding, Verdict

#: Lights whose azimuths lie within this angle count as one arc.
ONE_ARC = math.radians(5.0)


def azimuth_spread(azimuth: NDArray[np.float64] | None) -> float:
    """The smallest angle in radians that holds all azimuths; 0 where they are unknown."""
    if azimuth is None:
        return 0.0
    rising = np.sort(np.mod(azimuth, 2 * math.pi))
    return 2 * math.pi - float(np.diff(rising, append=rising[0] + 2 * math.pi).max())


def usual_motion(azimuth: NDArray[np.float64] | None) -> Literal["euclidean", "none"]:
    """Default motion of the alignment for these azimuths: see `ImportSettings.motion`."""
    return "euclidean" if azimuth_spread(azimuth) <= ONE_ARC else "none"


def about_azimuth(azimuth: NDArray[np.float64] | None) -> list[Finding]:
    spread = azimuth_spread(azimuth)
    if spread <= ONE_ARC:
        return []
    text = (
        f"The lights spread over {math.degrees(spread):.0f}° of azimuth, so that a directional material shows them "
        "best; a shading map, which knows their elevations alone, averages relief that is lit from several sides"
    )
    return [Finding(Verdict.NOTE, text)]
