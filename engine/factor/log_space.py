"""The logarithm in which a product of textures is a sum (McCool, Ang and Ahmad 2001; Cole 2002, Eqs. 1.9 and 1.10).

    L = log((f + εA) / A),        f = A exp(L) − εA,        A the mean of the BRDF in the channel

ε sets how dark a value still counts: L ≥ ln ε, which is −11.5 at ε = 1e-5. Cole leaves out −εA on the way back, so
that f stays positive, and is too large by εA everywhere: by 1 % at f = A/1000. Here it is subtracted, and what falls
below 0 becomes 0. Going there and back costs |L| u of f + εA for the rounding of L to float64, and about 4 u besides.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]

#: The offset that McCool and Cole use.
EPSILON = 1e-5

#: exp(L) is not asked for beyond this: A is at most 1e30, and what fits there is no reflectance any more.
LARGEST_LOG = 500.0


@dataclass(frozen=True, eq=False)
class LogSpace:
    """The mean A (3,) > 0 per channel in 1/sr, and ε > 0. A channel that is black everywhere has the mean of all."""

    mean: Floats
    epsilon: float = EPSILON

    def __post_init__(self) -> None:
        mean = np.array(self.mean, np.float64)
        if mean.shape != (3,) or not (np.isfinite(mean) & (mean > 0.0)).all():
            raise ValueError(f"the mean must be three positive numbers, not {self.mean}")
        if not 0.0 < self.epsilon < 1.0:
            raise ValueError(f"epsilon must lie between 0 and 1, not {self.epsilon}")
        mean.flags.writeable = False
        object.__setattr__(self, "mean", mean)

    @staticmethod
    def of(value: ArrayLike, epsilon: float = EPSILON) -> LogSpace:
        """The space of samples (N, 3) in 1/sr; ValueError where all are 0, because nothing has a scale then."""
        value = np.asarray(value, np.float64)
        mean = value.mean(axis=0)
        if not mean.max() > 0.0:
            raise ValueError("a BRDF that is 0 everywhere has no logarithm")
        return LogSpace(np.where(mean > 0.0, mean, mean.mean()), epsilon)

    def forward(self, value: ArrayLike) -> Floats:
        """L (..., 3) of values (..., 3) ≥ 0 in 1/sr."""
        return np.asarray(np.log(np.asarray(value, np.float64) / self.mean + self.epsilon))

    def backward(self, log: ArrayLike) -> Floats:
        """Values (..., 3) ≥ 0 in 1/sr of L (..., 3), which may be of any size."""
        grown = np.exp(np.minimum(np.asarray(log, np.float64), LARGEST_LOG))
        return np.asarray(self.mean * np.maximum(grown - self.epsilon, 0.0))
