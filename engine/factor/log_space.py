"""The logarithm in which a product of textures is a sum (McCool, Ang and Ahmad 2001; Cole 2002, Eqs. 1.9 and 1.10).

    L = log((f + εA) / A),        f = A exp(L) − εA,        A the mean of the BRDF in the channel

ε sets how dark a value still counts: L ≥ ln ε, which is −11.5 at ε = 1e-5. Cole leaves out −εA on the way back, so
that f stays positive, and is too large by εA everywhere: by 1 % at f = A/1000. Here it is subtracted, and what falls
below 0 becomes 0. What lies above the largest sample of a channel becomes that: between and beyond the samples textures
are guesses, and the exponential of a guess has no bound. Going there and back costs |L| u of f + εA for the rounding of
L to float64, and about 4 u besides.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]

#: The offset that McCool and Cole use.
EPSILON = 1e-5

#: exp(L) is not asked for beyond this: A is at most 1e30, and what fits there is no reflectance any more.
LARGEST_LOG = 500.0


@dataclass(frozen=True, eq=False)
class LogSpace:
    """The mean A (3,) > 0 per channel in 1/sr, ε > 0, and the largest value (3,) > 0 that comes back.

    A channel that is black everywhere has the mean and the largest value of all.
    """

    mean: Floats
    epsilon: float = EPSILON
    largest: Floats = field(default_factory=lambda: np.full(3, np.inf))

    def __post_init__(self) -> None:
        mean = np.array(self.mean, np.float64)
        if mean.shape != (3,) or not (np.isfinite(mean) & (mean > 0.0)).all():
            raise ValueError(f"the mean must be three positive numbers, not {self.mean}")
        if not 0.0 < self.epsilon < 1.0:
            raise ValueError(f"epsilon must lie between 0 and 1, not {self.epsilon}")
        largest = np.array(self.largest, np.float64)
        if largest.shape != (3,) or not (largest > 0.0).all():
            raise ValueError(f"the largest values must be three positive numbers, not {self.largest}")
        for name, array in (("mean", mean), ("largest", largest)):
            array.flags.writeable = False
            object.__setattr__(self, name, array)

    @property
    def highest(self) -> Floats:
        """The L (3,) of the largest values."""
        return np.minimum(np.log(self.largest / self.mean + self.epsilon), LARGEST_LOG)

    @staticmethod
    def of(value: ArrayLike, epsilon: float = EPSILON) -> LogSpace:
        """The space of samples (N, 3) in 1/sr; ValueError where all are 0, because nothing has a scale then."""
        value = np.asarray(value, np.float64)
        mean = value.mean(axis=0)
        if not mean.max() > 0.0:
            raise ValueError("a BRDF that is 0 everywhere has no logarithm")
        largest = value.max(axis=0)
        lit = mean > 0.0
        return LogSpace(np.where(lit, mean, mean.mean()), epsilon, np.where(lit, largest, largest.max()))

    def forward(self, value: ArrayLike) -> Floats:
        """L (..., 3) of values (..., 3) ≥ 0 in 1/sr."""
        return np.asarray(np.log(np.asarray(value, np.float64) / self.mean + self.epsilon))

    def backward(self, log: ArrayLike) -> Floats:
        """Values (..., 3) in 1/sr, from 0 to the largest, of L (..., 3), which may be of any size."""
        grown = np.exp(np.minimum(np.asarray(log, np.float64), self.highest))
        return np.asarray(self.mean * np.maximum(grown - self.epsilon, 0.0))
