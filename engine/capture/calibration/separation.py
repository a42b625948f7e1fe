"""Pairs of photographs under parallel and crossed polarisers, taken apart into diffuse and specular radiance.

What a pair contains, and how gain and leak are found, is told in `engine.capture.calibration.polarisation`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.core.figure_text import percent

Array = NDArray[np.float64]
Image = NDArray[np.float32]

#: Least gain that a user may state, and its inverse the largest.
MIN_GAIN = 1e-3


@dataclass(frozen=True, eq=False)
class Separation:
    """What turns a pair into its parts.

    Attributes
    ----------
    gain : (3,) brightness of crossed photographs over the diffuse part of parallel ones, for red, green, blue.
    gain_sigma : (3,) standard deviations; zero for a stated gain.
    leak : share of specular radiance that crossed polarisers let through, over that which parallel ones do.
    leak_sigma : its standard deviation, NaN where no highlight tells it.
    stated : whether a user stated the gain.
    """

    gain: Array
    gain_sigma: Array
    leak: float = 0.0
    leak_sigma: float = float("nan")
    stated: bool = False

    def apply(self, parallel: Image, crossed: Image) -> tuple[Image, Image]:
        """Return radiance without polarisers and its diffuse part (…, 3) of photographs P and X (…, 3)."""
        even = crossed * (1.0 / self.gain).astype(np.float32)
        polarised = (parallel - even) * np.float32(1.0 / (1.0 - self.leak))
        diffuse = np.maximum(parallel - polarised, np.float32(0.0))
        return np.float32(0.5) * (parallel + diffuse), diffuse

    def as_json(self) -> dict[str, Any]:
        """Return the numbers for records."""
        return {
            "gain": self.gain.tolist(),
            "gain_sigma": self.gain_sigma.tolist(),
            "leak": self.leak,
            "leak_sigma": self.leak_sigma if np.isfinite(self.leak_sigma) else None,
            "stated": self.stated,
        }


def gain_text(record: Mapping[str, Any]) -> str:
    """Return a sentence for the user about the record of a `Separation`."""
    gains = np.asarray(record["gain"], np.float64)
    gain, sigma = float(gains.mean()), float(np.max(record["gain_sigma"]))
    interval = f"95 % interval {gain - 2.0 * sigma:.4g} to {gain + 2.0 * sigma:.4g}"
    found = "as stated" if record["stated"] else f"as estimated ({interval})"
    tint = f"; red, green, blue {', '.join(f'{each:.4g}' for each in gains)}" if np.ptp(gains) > 0.005 * gain else ""
    leak = f". They show {percent(record['leak'])} of the highlights, which was taken off" if record["leak"] else ""
    return (
        f"Crossed photographs are {gain:.3f} times as bright as the diffuse part of parallel ones, {found}{tint}{leak}"
    )


def gain_sigma_of(provenance: Mapping[str, Any]) -> float:
    """The largest relative standard deviation of a recorded gain, 0 without pairs."""
    recorded = provenance.get("polarisation")
    if not isinstance(recorded, dict):
        return 0.0
    gain, sigma = (np.asarray(recorded.get(name, [0.0]), np.float64) for name in ("gain", "gain_sigma"))
    return float((sigma / np.maximum(gain, MIN_GAIN)).max()) if gain.shape == sigma.shape else 0.0
