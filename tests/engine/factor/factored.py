"""Samples of a well-known BRDF, made once."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from engine.brdf.brdf import brdf_from_text
from engine.factor.data import FactorData, factor_data


@lru_cache(maxsize=16)
def blue_paint(count: int, max_theta_deg: float = 70.0) -> FactorData:
    """Lafortune's blue paint, uniformly over the parabolic disks up to an angle."""
    return factor_data(brdf_from_text("lafortune:preset=blue-paint"), count, np.radians(max_theta_deg))
