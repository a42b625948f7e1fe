"""Power-law compression of a shading map, f(r) = k_s (r / a_max)^K per texel and channel (Kautz et al. 2004, Eq. 4)."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from engine.health import Health


@dataclass(frozen=True, eq=False)
class PowerLawMap:
    """Six numbers per texel instead of a stack of slices.

    Attributes
    ----------
    scale : (H, W, 3) float32, k_s >= 0, linear radiance at r = r_max.
    exponent : (H, W, 3) float32, K >= 0.
    r_max : a_max of the shading map.
    rms : root mean square of slice minus reconstruction over texels, slices and channels, in units of radiance.
    rms_per_channel : (3,) float64, the same per channel.
    error_map : (H, W) float32, the same per texel.
    """

    scale: NDArray[np.float32]
    exponent: NDArray[np.float32]
    r_max: float
    rms: float
    rms_per_channel: NDArray[np.float64]
    error_map: NDArray[np.float32]
    health: Health = field(default_factory=Health)
