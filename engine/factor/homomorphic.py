"""BRDFs as products of textures of projections of the two directions (McCool, Ang and Ahmad 2001; Cole 2002).

    log((f + εA)/A) = Σ_j p_j(π_j(wi, wo))          reciprocal: Σ_j p_j(π_j(wi, wo)) + p_j(π_j(wo, wi))

`engine.factor.textures` finds the textures for given projections, `engine.factor.search` the projections.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.directions import Vectors
from engine.factor.log_space import LogSpace
from engine.factor.projections import FixedProjection, Parametrisation, Points, Projection, look_ups, points_of
from engine.kernels import parallel, prange

Floats = NDArray[np.float64]

#: Most textures of one BRDF.
MOST_TERMS = 16

_CHUNK = 1 << 16


@dataclass(frozen=True, eq=False)
class HomomorphicFactors:
    """A BRDF as a product of textures; a `Brdf`.

    Attributes
    ----------
    textures : one per term, (n, n, 3), log-space: their sum over all look-ups is log((f + εA)/A). Row v, column u at
        coordinates −1 + 2 (u, v)/(n − 1), linear in between.
    projections : one per term. space : A and ε.
    parametrisation : of the linear projections. reciprocal : whether each texture is read by the conjugate too.
    shorter : the best factors of 1, 2, … fewer terms, as far as known; `truncated` gives them.
    name, kind : for a person.
    """

    textures: tuple[Floats, ...]
    projections: tuple[Projection, ...]
    space: LogSpace
    parametrisation: Parametrisation = "in-out"
    reciprocal: bool = True
    shorter: tuple[HomomorphicFactors, ...] = field(default=(), repr=False)
    name: str = "factors"
    kind: str = "homomorphic factors"

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
        """Of the textures as float32."""
        return sum(4 * texture.size for texture in self.textures)

    @property
    def isotropic(self) -> bool:
        """Whether all textures are of angles, which turning both directions about the normal does not change."""
        return all(isinstance(each, FixedProjection) and each.of_angles for each in self.projections)

    @property
    def energy_conserving(self) -> bool:
        return False

    def truncated(self, terms: int) -> HomomorphicFactors:
        """The factors of fewer terms that the search went through; ValueError where they are not known."""
        for factors in (*self.shorter, self):
            if factors.terms == terms:
                return factors
        known = ", ".join(str(factors.terms) for factors in (*self.shorter, self))
        raise ValueError(f"factors of {terms} terms are not known; known are {known}")

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
        return values

    def log(self, points: Points) -> Floats:
        """log((f + εA)/A) (N, 3) at points of this parametrisation."""
        total = np.zeros((len(points.flat), 3))
        for texture, projection in zip(self.textures, self.projections, strict=True):
            read = look_ups(projection, points, self.parametrisation, self.reciprocal)
            _read(texture, np.ascontiguousarray(read[0]), np.ascontiguousarray(read[-1]), len(read), total)
        return total


@parallel
def _read(texture, first, second, times, total):  # type: ignore[no-untyped-def]
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
