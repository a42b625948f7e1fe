"""Error of a factorisation against its BRDF: six errors over the samples, and one over random pairs of directions.

The six of Cole2002 Sec. 4.3: mean absolute, mean squared and largest difference over samples and channels, of
log((f + εA)/A) ("relative error") and of f itself. The seventh is that of Wang2004 Sec. 4.3: the
root mean square of (f − f') cos θ_i over random pairs, over all channels, in 1/sr; random means uniform in solid angle
over both hemispheres. Its bands are those of the viewer's elevation: the light's horizon is already weighed away.

Uses of factors, as sentences for a user.
"""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass, fields, replace
from statistics import median
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.brdf.brdf import Brdf
from engine.core.directions import Vectors, surface_direction
from engine.core.figure_text import number, percent
from engine.core.summary import Summary
from engine.factor.data import FactorData
from engine.factor.homomorphic import EPSILON, HomomorphicFactors, LogSpace
from engine.factor.separable_factors import SeparableFactors

Factors = SeparableFactors | HomomorphicFactors

Floats = NDArray[np.float64]

#: Random pairs that the cosine-weighted error is taken over, and bands of 10° of the viewer's elevation.
PAIRS = 80_000
BANDS = 9


@dataclass(frozen=True)
class Metrics:
    """Means and maxima over samples and channels: `…_log` of log((f + εA)/A), the others in 1/sr (`sq` in 1/sr²)."""

    abs_log: float
    sq_log: float
    max_log: float
    abs: float
    sq: float
    max: float


#: The names of the six, of which one drives a search.
METRICS = tuple(each.name for each in fields(Metrics))


def metrics(approximation: ArrayLike, data: FactorData, epsilon: float = EPSILON) -> Metrics:
    """The six errors of values (N, 3) in 1/sr at the pairs of `data`; negative ones count as 0.

    A is the mean of the data per channel; data that are 0 everywhere are measured with A = 1.
    """
    value = np.maximum(np.asarray(approximation, np.float64), 0.0)
    if value.shape != data.value.shape:
        raise ValueError(f"{value.shape} values for {data.value.shape} samples")
    space = LogSpace.of(data.value, epsilon) if data.value.max() > 0.0 else LogSpace(np.ones(3), epsilon)
    log = np.abs(space.forward(value) - space.forward(data.value))
    plain = np.abs(value - data.value)
    return Metrics(
        abs_log=float(log.mean()),
        sq_log=float((log * log).mean()),
        max_log=float(log.max()),
        abs=float(plain.mean()),
        sq=float((plain * plain).mean()),
        max=float(plain.max()),
    )


@dataclass(frozen=True)
class HeldOut:
    """Two errors at samples, each foretold by factors made without its region (`engine.factor.solvers.regions`).

    Attributes
    ----------
    rms_cosine_weighted : root mean square of (f − f') cos θ_i over samples and channels, in 1/sr.
    sq_log : mean square of the difference in log((f + εA)/A).
    excess : root mean square of what rises above the ceiling of the samples (`engine.brdf.ceiling`), × cos θ_i, at
        random pairs between them. It is cut off when the factors are read, and no error of theirs; but factors that
        need the ceiling are wrong below it too.
    """

    rms_cosine_weighted: float
    sq_log: float
    excess: float = 0.0

    @property
    def score(self) -> float:
        """All at once: half of the linear error, with the excess, is worth as much as half of the logarithmic one."""
        return math.hypot(self.rms_cosine_weighted, self.excess) * self.sq_log

    def no_worse(self, other: HeldOut) -> bool:
        """True if neither error is larger, but for rounding."""
        return self.rms_cosine_weighted <= other.rms_cosine_weighted * ROUNDED and self.sq_log <= other.sq_log * ROUNDED


#: Errors of the same factors may differ by this factor.
ROUNDED = 1.0 + 1e-9


def compute_held_out_errors(foretold: ArrayLike, data: FactorData, epsilon: float = EPSILON) -> HeldOut:
    """The errors of values (N, 3) that were foretold for all samples of `data`, each by factors that never saw it."""
    foretold = np.asarray(foretold, np.float64)
    missed = (foretold - data.value) * data.wi[:, 2:]
    return HeldOut(float(np.sqrt((missed * missed).mean())), metrics(foretold, data, epsilon).sq_log)


@dataclass(frozen=True, eq=False)
class Reference:
    """A BRDF's values at random pairs, evaluated once and compared with many approximations.

    Attributes
    ----------
    wi, wo : (P, 3) unit directions, uniform over both hemispheres.
    value : (P, 3) in 1/sr.
    """

    wi: Vectors
    wo: Vectors
    value: Floats

    def rms(self, approximation: Brdf) -> tuple[float, tuple[float, ...]]:
        """The cosine-weighted RMS in 1/sr over all pairs, and over those in each band from the horizon upwards."""
        difference = (approximation.f(self.wi, self.wo) - self.value) * self.wi[:, 2:]
        square = (difference * difference).mean(axis=1)
        elevation = np.arctan2(self.wo[:, 2], np.hypot(self.wo[:, 0], self.wo[:, 1]))
        band = np.minimum((elevation * (2.0 * BANDS / np.pi)).astype(int), BANDS - 1)
        sums, counts = np.bincount(band, square, BANDS), np.bincount(band, minlength=BANDS)
        bands = np.sqrt(sums / np.maximum(counts, 1))
        return float(np.sqrt(square.mean())), tuple(map(float, bands))

    def seen(self, approximation: Brdf) -> float:
        """The cosine-weighted RMS in 1/sr with pairs weighted by n · wo too: about what pixels show."""
        difference = (approximation.f(self.wi, self.wo) - self.value) * self.wi[:, 2:]
        weight = np.maximum(self.wo[:, 2], 0.0)
        return float(np.sqrt(weight @ (difference * difference).mean(axis=1) / weight.sum()))

    def measure_held_out(self, approximation: Brdf, epsilon: float = EPSILON) -> HeldOut:
        """Both errors at these pairs, which are none of those that a factorisation is made from."""
        value = approximation.f(self.wi, self.wo)
        missed = (value - self.value) * self.wi[:, 2:]
        space = LogSpace.of(self.value, epsilon) if self.value.max() > 0.0 else LogSpace(np.ones(3), epsilon)
        log = space.forward(np.maximum(value, 0.0)) - space.forward(self.value)
        return HeldOut(float(np.sqrt((missed * missed).mean())), float((log * log).mean()))

    def measure_cut(self, factors: Factors) -> float:
        """Share of these pairs at which `factors` are cut at their ceiling; 0 without one."""
        if factors.ceiling is None:
            return 0.0
        cut = replace(factors, ceiling=None).f(self.wi, self.wo) > factors.ceiling.look_up(self.wi, self.wo)
        return float(cut.any(axis=1).mean())

    def miss(self, rms_by_band: tuple[float, ...]) -> float:
        """Errors in bands relative to the BRDF itself: their median.

        Over all pairs together the last degrees before the horizon, where some measurements grow without bound, would
        drown the rest.
        """
        _, sizes = self.rms(_Black())
        shares = [error / size for error, size in zip(rms_by_band, sizes, strict=True) if size > 0.0]
        return median(shares) if shares else 0.0


def reference(brdf: Brdf, pairs: int = PAIRS, seed: int = 1) -> Reference:
    """`brdf` at random pairs of directions; the same pairs for the same seed."""
    if pairs < 1:
        raise ValueError(f"at least one pair is needed, not {pairs}")
    rng = np.random.default_rng(seed)

    def hemisphere() -> Vectors:
        cosine = 1.0 - rng.random(pairs)
        return surface_direction(np.arctan2(np.sqrt(1.0 - cosine * cosine), cosine), 2.0 * np.pi * rng.random(pairs))

    wi, wo = hemisphere(), hemisphere()
    return Reference(wi, wo, brdf.f(wi, wo))


def rms_cosine_weighted(brdf: Brdf, approximation: Brdf, pairs: int = PAIRS, seed: int = 1) -> float:
    """Root mean square of (f − f') cos θ_i over random pairs and all channels, in 1/sr."""
    return reference(brdf, pairs, seed).rms(approximation)[0]


@dataclass(frozen=True)
class TermError:
    """Error of the first `terms` terms of a factorisation, in `textures` textures, with their time and size.

    Attributes
    ----------
    rms_cosine_weighted : in 1/sr, over random pairs.
    rms_by_elevation_band : the same for the viewer's elevation in [0°, 10°), [10°, 20°), … [80°, 90°].
    metrics : over the samples that it was made from.
    time_s : from the start of the factorisation until this term was there. The terms of a sum of products come all at
        once, from one decomposition, and have one time.
    size_bytes : of the textures, as float32.
    held_out_rms_cosine_weighted, held_out_sq_log : as `HeldOut` has them; None where too little was measured.
    smoothing : λ of the textures of projections, else 0.
    """

    terms: int
    textures: int
    rms_cosine_weighted: float
    rms_by_elevation_band: tuple[float, ...]
    metrics: Metrics
    time_s: float
    size_bytes: int
    held_out_rms_cosine_weighted: float | None = None
    held_out_sq_log: float | None = None
    smoothing: float = 0.0

    @property
    def held_out(self) -> HeldOut | None:
        if self.held_out_rms_cosine_weighted is None or self.held_out_sq_log is None:
            return None
        return HeldOut(self.held_out_rms_cosine_weighted, self.held_out_sq_log)

    def error(self, name: str) -> float | None:
        """The error called `name`, here or in `metrics`; None for a held-out one that is not known."""
        found: float | None = getattr(self.metrics, name) if name in METRICS else getattr(self, name)
        return found


@dataclass(frozen=True, eq=False, repr=False)
class Factorisation(Summary):
    """A factorisation with its errors for each number of terms, complete or as far as it got.

    Attributes
    ----------
    factors : SeparableFactors or HomomorphicFactors.
    method : the name of the method that made it.
    sweep : the errors of each number of terms that is stored.
    left_out : the errors of numbers of terms that were tried and are not stored, because fewer terms are better.
    held_out_by : what the held-out errors leave out: "regions" of the measured sphere or, of sums that are made of
        values at texel centres alone, all pairs "between texels"; "" where there are none.
    best_terms : the number of terms that is best by held-out errors; None where they are not known.
    unmeasured : a sentence on pairs of directions near which nothing was measured; else "".
    choice : a sentence on why the method `auto` took this one, of a measurement; else "".
    asymmetry : ‖M − Mᵀ‖/‖M‖ of the BRDF's matrix; 0 where no matrix is formed.
    condition_number : of the last least-squares problem, as far as it is known, else 0.
    optimum_ratio : truncation error over the Eckart–Young optimum; 0 where there is no such optimum.
    evaluations : inner solves of a search, else 0.
    projections : a search's projections, else empty.
    searching : whether the last term is the best so far of a search that has not ended.
    weighting : the norm of separable factors, "plain" or "cosine"; else "".
    converged : False where an iteration gave up before its residual was small.
    negative_energy : what clamping at 0 cuts off, as a fraction of what is left, weighted by cos θ_i over random pairs.
    """

    factors: Factors
    method: str
    term_errors: tuple[TermError, ...]
    asymmetry: float = 0.0
    condition_number: float = 0.0
    optimum_ratio: float = 0.0
    evaluations: int = 0
    projections: tuple[Any, ...] = ()
    searching: bool = False
    weighting: str = ""
    converged: bool = True
    negative_energy: float = 0.0
    left_out: tuple[TermError, ...] = ()
    held_out_by: str = ""
    unmeasured: str = ""
    choice: str = ""
    best_terms: int | None = None

    @property
    def ladder(self) -> tuple[TermError, ...]:
        """Deprecated: `term_errors`."""
        warnings.warn("Factorisation.ladder is called term_errors", DeprecationWarning, stacklevel=2)
        return self.term_errors

    def summary(self) -> dict[str, Any]:
        """Return what `repr` says."""
        return {"method": self.method, "terms": [each.terms for each in self.term_errors], "factors": self.factors}


def stop_reason(found: Factorisation) -> str:
    """Why a factorisation has no more terms than it has: the held-out errors of one more, as words after a colon.

    Empty where held-out errors did not decide.
    """
    last = found.term_errors[-1].held_out if found.term_errors else None
    if last is None or found.best_terms != found.term_errors[-1].terms or found.searching:
        return ""
    after = next(
        (term_error.held_out for term_error in found.left_out if term_error.terms == found.best_terms + 1), None
    )
    if after is None:
        return "no further term lowers the held-out errors"
    rms, log = (
        f"from {number(getattr(last, name), 3)} to {number(getattr(after, name), 3)}"
        for name in ("rms_cosine_weighted", "sq_log")
    )
    if after.rms_cosine_weighted >= last.rms_cosine_weighted:
        return f"one more raises the held-out RMS × cos {rms} sr⁻¹"
    if after.sq_log >= last.sq_log:
        return f"one more raises the held-out squared logarithm {log}"
    return f"further ones raise the held-out errors, although one more lowers the RMS × cos {rms} sr⁻¹"


#: Errors relative to the BRDF itself above which its highlight counts as too narrow for the factors, and above which
#: they are of no use.
TOO_SPECULAR, USELESS = 0.25, 0.5

_GAUSSIAN = "for image-based light take the Gaussian mode, which follows the highlight itself"


def uses(factorisation: Factorisation, brdf: Brdf | None = None) -> tuple[str, ...]:
    """Uses and limits of the factors; with `brdf`, also a warning if it is too specular for them, and no use of theirs
    where they are mostly wrong.

    That is judged by the cosine-weighted error of all terms, relative to the BRDF: singular values of a narrow
    highlight fall slowly, and no few terms describe it.
    """
    factors = factorisation.factors
    sentences = list(_describe_kind(factors))
    if brdf is not None and factorisation.term_errors:
        pairs = reference(brdf)
        share = pairs.miss(factorisation.term_errors[-1].rms_by_elevation_band)
        cut = pairs.measure_cut(factors)
        if cut > 0.0:
            sentences.append(
                f"At {percent(cut)} of all pairs of directions the factors are cut at three times the largest value "
                "measured within 12°."
            )
        if share > USELESS:
            return (
                f"Use these factors for nothing: they are off by {percent(share)} of the reflectance (RMS). Draw the "
                f"reflectance itself, or a model fitted to it; {_GAUSSIAN}.",
                *sentences[2:],
            )
        if share > TOO_SPECULAR:
            sentences.append(
                "The highlight is too narrow for these factors, which are off by "
                f"{percent(share)} of the reflectance (RMS): {_GAUSSIAN}."
            )
    return tuple(sentences)


def _describe_kind(factors: Factors) -> tuple[str, ...]:
    terms = factors.terms
    if isinstance(factors, SeparableFactors):
        these = "this term" if terms == 1 else f"these {terms} terms"
        if factors.parametrisation == "in-out":
            return (
                f"Precomputed transport in wavelets can use {these}: light maps go into the transport, view maps are "
                "sampled while drawing.",
                "Direct light can use them too: two samples a term for each light.",
            )
        return (
            f"Direct light in the viewport can use {these}: textures of the half and the difference vector.",
            "Precomputed transport in wavelets cannot: it needs factors of the incident and the outgoing direction.",
        )
    looks = "two samples a texture" if factors.reciprocal else "one sample a texture"
    these = "this texture" if terms == 1 else f"these {terms} textures"
    return (
        f"Direct light in the viewport can use {these}: {looks} for each light.",
        "Precomputed transport in wavelets cannot: it needs a sum of products, and this is one product.",
    )


class _Black:
    """Reflects nothing: its error is the size of what it is compared with."""

    isotropic = reciprocal = energy_conserving = True

    def f(self, wi: ArrayLike, wo: ArrayLike) -> Vectors:
        return np.zeros(np.broadcast_shapes(np.shape(wi), np.shape(wo)))
