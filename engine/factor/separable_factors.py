"""A BRDF as a short sum of products of two textures, one for each of two directions, looked up without the BRDF.

    in-out      f(wi, wo) ≈ Σ view_k(wo) light_k(wi)                Wang2004 Sec. 3.2
    half-diff   f(wi, wo) ≈ Σ half_k(h) difference_k(d)             Kautz1999

h is the half vector and d the difference vector in the classical frame (`engine.brdf.half_difference`). A sum of
products can fall below 0 where the BRDF does not: `f` is then 0, and `negative_energy` says how much was cut off.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any, ClassVar, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.brdf.ceiling import Ceiling
from engine.brdf.half_difference import OPPOSITE
from engine.brdf.models.sampling import Reflectance
from engine.core.cached import cached_property
from engine.core.directions import Vectors, surface_direction
from engine.core.figure_text import percent
from engine.core.health import Finding, Health, Verdict
from engine.core.kernels import parallel, prange, scalar
from engine.core.summary import Summary
from engine.factor.hemisphere_map import HemisphereMap, taps

#: Pairs at which sums below 0 are looked for, and the share of the energy from which they are spoken of.
PAIRS, DOUBTFUL_SHARE = 20_000, 0.01

Textures = NDArray[np.float32]

Parametrisation = Literal["in-out", "half-diff"]
PARAMETRISATIONS: tuple[Parametrisation, ...] = get_args(Parametrisation)


@dataclass(frozen=True, eq=False, repr=False)
class SeparableFactors(Reflectance, Summary):
    """K terms of two textures each.

    Attributes
    ----------
    hemisphere_map : the map of all textures.
    parametrisation : which two directions they belong to.
    first : (K, rows, columns, 3) float32, view maps (of wo, with the sign) or half-vector maps, in sr^-½.
    second : the same for light maps (of wi) or difference maps.
    isotropic, reciprocal : as the BRDF that they were made of; exactly reciprocal where the maps differ by sign only.
    name : of that BRDF, for a user.
    ceiling : what `f` is cut at, of a measurement; the sum itself is not, and transport is made of the sum.
    """

    hemisphere_map: HemisphereMap
    parametrisation: Parametrisation
    first: Textures
    second: Textures
    isotropic: bool = False
    reciprocal: bool = False
    name: str = ""
    ceiling: Ceiling | None = None

    energy_conserving: ClassVar[bool] = False
    kind: ClassVar[str] = "separable factors"

    #: (rows · columns, K, 3): the textures of all terms beside each other at each texel.
    _first: NDArray[np.float64] = field(init=False, repr=False)
    _second: NDArray[np.float64] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        if self.parametrisation not in PARAMETRISATIONS:
            raise ValueError(
                f"unknown parametrisation {self.parametrisation!r}; choose from {', '.join(PARAMETRISATIONS)}"
            )
        if self.first.ndim != 4 or not len(self.first) or self.first.shape != self.second.shape:
            raise ValueError(f"textures {self.first.shape} and {self.second.shape} do not belong together")
        for name in ("first", "second"):
            textures = np.array(getattr(self, name), np.float32)
            if textures.shape[1:] != (*self.hemisphere_map.shape, 3):
                raise ValueError(
                    f"textures {textures.shape[1:]} do not fit a map of {self.hemisphere_map.shape} texels"
                )
            if not np.isfinite(textures).all():
                raise ValueError("the textures hold numbers that are not finite")
            textures.flags.writeable = False
            object.__setattr__(self, name, textures)
            beside = np.moveaxis(textures.reshape(len(textures), -1, 3), 0, 1)
            object.__setattr__(self, f"_{name}", np.ascontiguousarray(beside, np.float64))

    @property
    def terms(self) -> int:
        return len(self.first)

    @property
    def size_bytes(self) -> int:
        """Bytes of the textures as float32."""
        return self.first.nbytes + self.second.nbytes

    def truncate(self, terms: int) -> SeparableFactors:
        """The first `terms` terms, of which there must be that many."""
        if not 1 <= terms <= self.terms:
            raise ValueError(f"there are {self.terms} terms, not {terms}")
        return replace(self, first=self.first[:terms], second=self.second[:terms])

    def f(self, wi: ArrayLike, wo: ArrayLike) -> Vectors:
        """Values (..., 3) ≥ 0 in 1/sr without the cosine, for unit directions (..., 3) that broadcast."""
        values = np.maximum(self.sum_terms(wi, wo), 0.0)
        return values if self.ceiling is None else np.minimum(values, self.ceiling.look_up(wi, wo))

    def sum_terms(self, wi: ArrayLike, wo: ArrayLike) -> Vectors:
        """The sum itself (Wang2004 Eq. 2), which may be negative; 0 at and below the horizon."""
        wi, wo = np.broadcast_arrays(np.asarray(wi, np.float64), np.asarray(wo, np.float64))
        values = np.empty(wi.shape)
        half = self.parametrisation == "half-diff"
        _sum(
            self.hemisphere_map.number,
            self.hemisphere_map.size,
            half,
            self._first,
            self._second,
            np.ascontiguousarray(wi).reshape(-1, 3),
            np.ascontiguousarray(wo).reshape(-1, 3),
            values.reshape(-1, 3),
        )
        return values

    @cached_property
    def health(self) -> Health:
        """Share of the energy that is drawn black because the sum is negative, at random pairs of directions."""
        rng = np.random.default_rng(1)
        cosine, azimuth = 1.0 - rng.random((2, PAIRS)), 2.0 * np.pi * rng.random((2, PAIRS))
        wi, wo = surface_direction(np.arccos(cosine), azimuth)
        share = self.negative_energy(wi, wo)
        figures = MappingProxyType({"negative_energy_rel": share})
        if share <= DOUBTFUL_SHARE:
            return Health(figures)
        text = (
            f"the sum of {self.terms} terms is below 0 in places, which are drawn black: that adds {percent(share)} to "
            "the energy; no sum of the method nonnegative is"
        )
        return Health(figures, (Finding(Verdict.WARNING, text),))

    def negative_energy(self, wi: Vectors, wo: Vectors) -> float:
        """Energy that `f` clamps at pairs (P, 3), as a fraction of what it keeps, both weighted by cos θ_i."""
        values = self.sum_terms(wi, wo) * wi[:, 2:]
        kept = float(np.maximum(values, 0.0).sum())
        return float(np.maximum(-values, 0.0).sum()) / kept if kept > 0.0 else 0.0

    def summary(self) -> dict[str, Any]:
        """Return what `repr` says."""
        return {"name": self.name, "terms": len(self.first), "texels": f"{self.first.shape[2]} × {self.first.shape[1]}"}


@scalar
def _half_and_difference(
    wi: NDArray[np.floating], wo: NDArray[np.floating], half: NDArray[np.floating], difference: NDArray[np.floating]
) -> None:
    """The unit half vector, and the unit difference vector in its classical frame, of directions above the horizon."""
    ax, ay, az = wi[0] + wo[0], wi[1] + wo[1], wi[2] + wo[2]
    dx, dy, dz = wi[0] - wo[0], wi[1] - wo[1], wi[2] - wo[2]
    length = math.sqrt(ax * ax + ay * ay + az * az)
    half[0], half[1], half[2] = 0.0, 0.0, 1.0
    if length * length > OPPOSITE:
        half[0], half[1], half[2] = ax / length, ay / length, az / length
    across = math.sqrt(half[0] * half[0] + half[1] * half[1])
    cosine, sine = 1.0, 0.0
    if across > 0.0:
        cosine, sine = half[0] / across, half[1] / across
    difference[0] = 0.5 * (half[2] * (cosine * dx + sine * dy) - across * dz)
    difference[1] = 0.5 * (cosine * dy - sine * dx)
    difference[2] = 0.5 * length


@parallel
def _sum(
    kind: int,
    size: int,
    of_half: bool,
    first: NDArray[np.floating],
    second: NDArray[np.floating],
    wi: NDArray[np.floating],
    wo: NDArray[np.floating],
    values: NDArray[np.floating],
) -> None:
    """`values` (P, 3) of the sum; bound by fetching eight texels of K colours for each pair."""
    for p in prange(len(wi)):
        for c in range(3):
            values[p, c] = 0.0
        if wi[p, 2] <= 0.0 or wo[p, 2] <= 0.0:
            continue
        place, weight = np.empty((2, 4), np.int64), np.empty((2, 4))
        if of_half:
            half, difference = np.empty(3), np.empty(3)
            _half_and_difference(wi[p], wo[p], half, difference)
            taps(kind, size, half[0], half[1], half[2], place[0], weight[0])
            taps(kind, size, difference[0], difference[1], difference[2], place[1], weight[1])
        else:
            taps(kind, size, wo[p, 0], wo[p, 1], wo[p, 2], place[0], weight[0])
            taps(kind, size, wi[p, 0], wi[p, 1], wi[p, 2], place[1], weight[1])
        for k in range(first.shape[1]):
            for c in range(3):
                one, other = 0.0, 0.0
                for t in range(4):
                    one += weight[0, t] * first[place[0, t], k, c]
                    other += weight[1, t] * second[place[1, t], k, c]
                values[p, c] += one * other
