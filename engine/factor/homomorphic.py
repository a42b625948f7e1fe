"""BRDFs as products of textures of projections of the two directions (Cole2002 Eq. 1.6).

    log((f + εA)/A) = Σ_j p_j(π_j(wi, wo))          reciprocal: Σ_j p_j(π_j(wi, wo)) + p_j(π_j(wo, wi))

The sum is Cole2002 Eq. 1.7, after McCool2001.

`engine.factor.textures` finds the textures for given projections, `engine.factor.projection_search` the projections.

The logarithm in which a product of textures is a sum (McCool2001; Cole2002 Eq. 1.9, Cole2002 Eq. 1.10).

    L = log((f + εA) / A),        f = A exp(L) − εA,        A the mean of the BRDF in the channel

ε sets how dark a value still counts: L ≥ ln ε, which is −11.5 at ε = 1e-5. Cole leaves out −εA on the way back, so
that f stays positive, and is too large by εA everywhere: by 1 % at f = A/1000. Here it is subtracted, and what falls
below 0 becomes 0. What lies above the largest sample of a channel becomes that: between and beyond the samples textures
are guesses, and the exponential of a guess has no bound. Going there and back costs |L| u of f + εA for the rounding of
L to float64, and about 4 u besides.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.brdf.ceiling import Ceiling
from engine.brdf.models.sampling import Reflectance
from engine.core.directions import Vectors
from engine.core.errors import UsageError
from engine.core.kernels import parallel, prange
from engine.core.summary import Summary
from engine.factor.projections import FixedProjection, Parametrisation, Points, Projection, look_ups, points_of
from engine.factor.settings import FactorSettings

#: The offset that McCool and Cole use.
EPSILON = FactorSettings.epsilon

#: exp(L) is not asked for beyond this: A is at most 1e30, and what fits there is no BRDF any more.
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
        """The space of samples (N, 3) in 1/sr; UsageError where all are 0, because nothing has a scale then."""
        value = np.asarray(value, np.float64)
        mean = value.mean(axis=0)
        if not mean.max() > 0.0:
            raise UsageError("a BRDF that is 0 everywhere has no logarithm")
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


Floats = NDArray[np.float64]

_CHUNK = 1 << 16


@dataclass(frozen=True, eq=False, repr=False)
class HomomorphicFactors(Reflectance, Summary):
    """A BRDF as a product of textures; a `Brdf`.

    Attributes
    ----------
    textures : one per term, (n, n, 3), log-space: their sum over all look-ups is log((f + εA)/A). Row v, column u at
        coordinates −1 + 2 (u, v)/(n − 1), linear in between.
    projections : one per term. space : A and ε.
    parametrisation : of the linear projections. reciprocal : whether each texture is read by the conjugate too.
    shorter : the best factors of 1, 2, … fewer terms, as far as known; `truncate` gives them.
    name, kind : for a user.
    ceiling : what `f` is cut at, of a measurement.
    """

    textures: tuple[Floats, ...]
    projections: tuple[Projection, ...]
    space: LogSpace
    parametrisation: Parametrisation = "in-out"
    reciprocal: bool = True
    shorter: tuple[HomomorphicFactors, ...] = field(default=(), repr=False)
    name: str = "factors"
    kind: str = "homomorphic factors"
    ceiling: Ceiling | None = None

    def __post_init__(self) -> None:
        if not self.textures or len(self.textures) != len(self.projections):
            raise ValueError(f"{len(self.textures)} textures for {len(self.projections)} projections")
        textures = []
        for texture in self.textures:
            array = np.array(texture, np.float64)
            if array.ndim != 3 or array.shape[0] != array.shape[1] or array.shape[0] < 2 or array.shape[2] != 3:
                raise ValueError(f"a texture must have the shape (n, n, 3) with n > 1, not {array.shape}")
            if not np.isfinite(array).all():
                raise ValueError("textures must be finite")
            array.flags.writeable = False
            textures.append(array)
        object.__setattr__(self, "textures", tuple(textures))

    @property
    def terms(self) -> int:
        return len(self.textures)

    @property
    def size_bytes(self) -> int:
        """Bytes of the textures as float32."""
        return sum(4 * texture.size for texture in self.textures)

    @property
    def isotropic(self) -> bool:
        """True if all textures are of angles, which rotating both directions about the normal does not change."""
        return all(isinstance(each, FixedProjection) and each.of_angles for each in self.projections)

    @property
    def energy_conserving(self) -> bool:
        return False

    def truncate(self, terms: int) -> HomomorphicFactors:
        """The factors of fewer terms that the search went through; ValueError where they are not known."""
        for factors in (*self.shorter, self):
            if factors.terms == terms:
                return factors
        known = ", ".join(str(factors.terms) for factors in (*self.shorter, self))
        raise ValueError(f"no factors with {terms} terms; choose from {known}")

    def f(self, wi: ArrayLike, wo: ArrayLike) -> Vectors:
        """Values (..., 3) in 1/sr for unit directions (..., 3) that broadcast; 0 at and below the horizon."""
        wi, wo = np.broadcast_arrays(np.asarray(wi, np.float64), np.asarray(wo, np.float64))
        values = np.zeros(wi.shape)
        incident, outgoing, out = wi.reshape(-1, 3), wo.reshape(-1, 3), values.reshape(-1, 3)
        for first in range(0, len(out), _CHUNK):
            part = slice(first, first + _CHUNK)
            above = (incident[part, 2] > 0.0) & (outgoing[part, 2] > 0.0)
            points = points_of(incident[part][above], outgoing[part][above], self.parametrisation)
            out[part][above] = self.space.backward(self.log(points))
        return values if self.ceiling is None else np.minimum(values, self.ceiling.look_up(wi, wo))

    def log(self, points: Points) -> Floats:
        """log((f + εA)/A) (N, 3) at points of this parametrisation."""
        total = np.zeros((len(points.flat), 3))
        for texture, projection in zip(self.textures, self.projections, strict=True):
            read = look_ups(projection, points, self.parametrisation, self.reciprocal)
            _read(texture, np.ascontiguousarray(read[0]), np.ascontiguousarray(read[-1]), len(read), total)
        return total

    def summary(self) -> dict[str, Any]:
        """Return what `repr` says."""
        return {"name": self.name, "textures": len(self.textures)}


@parallel
def _read(texture: np.ndarray, first: np.ndarray, second: np.ndarray, times: int, total: np.ndarray) -> None:
    """Add a texture at coordinates `first`, and at `second` where it is read twice, to the totals (N, 3)."""
    size = len(texture)
    for i in prange(len(first)):
        red, green, blue = 0.0, 0.0, 0.0
        for time_ in range(times):
            at = first if time_ == 0 else second
            u = min(max(0.5 * (at[i, 0] + 1.0) * (size - 1), 0.0), size - 1.0)
            v = min(max(0.5 * (at[i, 1] + 1.0) * (size - 1), 0.0), size - 1.0)
            column, row = min(int(u), size - 2), min(int(v), size - 2)
            a, b = u - column, v - row
            w0, w1, w2, w3 = (1.0 - a) * (1.0 - b), a * (1.0 - b), (1.0 - a) * b, a * b
            p, q = texture[row, column], texture[row, column + 1]
            r, s = texture[row + 1, column], texture[row + 1, column + 1]
            red += ((w0 * p[0] + w1 * q[0]) + w2 * r[0]) + w3 * s[0]
            green += ((w0 * p[1] + w1 * q[1]) + w2 * r[1]) + w3 * s[1]
            blue += ((w0 * p[2] + w1 * q[2]) + w2 * r[2]) + w3 * s[2]
        total[i, 0] += red
        total[i, 1] += green
        total[i, 2] += blue
