"""Shading maps: photographs resampled so that their mean radiance grows linearly (Kautz et al. 2004, section 3.2)."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from engine.health import Health


@dataclass(frozen=True, eq=False)
class ShadingMap:
    """Slices S(r) of a material; slice i has mean luminance r_i = i r_max / (S - 1), slice 0 is black.

    Attributes
    ----------
    slices : (S, H, W, 3) float32, linear sRGB, read as BRDF times cosine.
    r_max : the largest mean luminance of the photographs, a_max in the paper.
    mean_radiance : (S,) float64, measured mean luminance of each slice.
    health : findings of the linearisation.
    """

    slices: NDArray[np.float32]
    r_max: float
    mean_radiance: NDArray[np.float64]
    health: Health = field(default_factory=Health)

    @property
    def target_radiance(self) -> NDArray[np.float64]:
        """(S,) the mean luminance that each slice should have, Eq. 1."""
        count = len(self.slices)
        return np.arange(count, dtype=np.float64) * np.float64(self.r_max / (count - 1))
