"""Factor a BRDF by any method, with its error for every number of terms, live while it runs.

symmetric, svd, power     sums of products of two textures (`separable`); auto is symmetric where the matrix is
normalised                one such product, positive (`normalised`)
homomorphic               products of textures of McCool's fixed projections (`homomorphic`)
search                    products of textures of the projections that Cole's search finds
"""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from typing import Literal, get_args

from engine.brdf.brdf import MODELS, Brdf, brdf_to_text
from engine.core.errors import UsageError
from engine.core.steps import Step, Steps, part
from engine.factor.data import COUNT, MAX_THETA, SEED, FactorData, factor_data
from engine.factor.errors import Factorisation, Reference, TermError, metrics, reference
from engine.factor.hemisphere_map import KINDS, DirectionMap, MapKind
from engine.factor.homomorphic import EPSILON
from engine.factor.normalised import normalised
from engine.factor.projection_search import search
from engine.factor.separable import METHODS, SeparableMethod, Separated, Weighting, separate
from engine.factor.separable_factors import PARAMETRISATIONS, Parametrisation, SeparableFactors
from engine.factor.textures import THESIS, SearchSettings, mccool

Method = Literal["auto", "symmetric", "svd", "power", "normalised", "homomorphic", "search"]
METHOD_NAMES: tuple[Method, ...] = get_args(Method)

Preset = Literal["default", "thesis"]

#: Texels a side and terms where none are asked for, of separable and of homomorphic factors.
SEPARABLE_SIZE, SEPARABLE_TERMS = 48, 8
HOMOMORPHIC_SIZE, HOMOMORPHIC_TERMS = 16, 5

#: Largest maps and most terms of separable factors: the matrix of a map of 96² takes 1.3 GB where nothing mirrors.
LARGEST_SEPARABLE, MOST_TERMS = 96, 64

#: More samples than this tell no more about textures of these sizes.
MOST_SAMPLES = 2_000_000


@dataclass(frozen=True)
class FactorSettings:
    """Settings of a factorisation; UsageError for impossible ones.

    Attributes
    ----------
    method : of `METHOD_NAMES`.
    parametrisation : "in-out" or "half-diff". "auto" tries both, separable methods only.
    map : of separable factors; "auto" tries all three. weighting : see `separable`.
    size, terms : texels a side and terms at most; 0 for the method's own.
    reciprocal : enforce it in homomorphic factors (separable ones are as reciprocal as the matrix).
    restarts, together, metric, preset : of the search; see `SearchSettings`. "thesis" is its setting without ours.
    samples, max_theta, seed : of the samples; see `factor_data`. epsilon : what is added before the logarithm.
    """

    method: Method = "auto"
    parametrisation: Parametrisation | Literal["auto"] = "in-out"
    map: MapKind | Literal["auto"] = "orthographic"
    weighting: Weighting = "auto"
    size: int = 0
    terms: int = 0
    reciprocal: bool = False
    restarts: int = 6
    together: int = 2
    samples: int = COUNT
    max_theta: float = MAX_THETA
    epsilon: float = EPSILON
    metric: str = "sq_log"
    preset: Preset = "default"
    seed: int = SEED

    def __post_init__(self) -> None:
        for name, known in (
            ("method", METHOD_NAMES),
            ("parametrisation", (*PARAMETRISATIONS, "auto")),
            ("map", (*KINDS, "auto")),
            ("preset", get_args(Preset)),
        ):
            if getattr(self, name) not in known:
                raise UsageError(f"unknown {name} {getattr(self, name)!r}; known are {', '.join(known)}")
        if not 1 <= self.samples <= MOST_SAMPLES:
            raise UsageError(f"the number of samples must lie in [1, {MOST_SAMPLES:,}], not {self.samples:,}")
        if self.separable:
            if not 0 <= self.size <= LARGEST_SEPARABLE:
                raise UsageError(f"the size must lie in [1, {LARGEST_SEPARABLE}], not {self.size}")
            if not 0 <= self.terms <= MOST_TERMS:
                raise UsageError(f"the number of terms must lie in [1, {MOST_TERMS}], not {self.terms}")
            if self.method == "symmetric" and self.parametrisation == "half-diff":
                raise UsageError("over half and difference vectors no matrix is symmetric; take svd or power")
        elif self.parametrisation == "auto":
            raise UsageError("the parametrisation of homomorphic factors is in-out or half-diff")
        else:
            self.search_settings()

    @property
    def separable(self) -> bool:
        return self.method not in ("homomorphic", "search")

    def search_settings(self) -> SearchSettings:
        """The part that the search reads; UsageError where it refuses it."""
        base = THESIS if self.preset == "thesis" else SearchSettings()
        size = self.size or HOMOMORPHIC_SIZE
        assert self.parametrisation != "auto"
        return replace(
            base,
            terms=self.terms or HOMOMORPHIC_TERMS,
            size=size,
            low_size=min(base.low_size, size),
            parametrisation=self.parametrisation,
            reciprocal=self.reciprocal,
            restarts=self.restarts,
            together=self.together,
            metric=self.metric,
            epsilon=self.epsilon,
            seed=self.seed,
        )


def factor(
    brdf: Brdf, settings: FactorSettings = FactorSettings(), resume: Factorisation | None = None
) -> Steps[Factorisation]:
    """Factor `brdf`; each step's `partial` is the factorisation so far, or None before there is one.

    `resume` lets a search go on to more terms; separable factors take a second and are made anew. UsageError where
    the settings do not fit the BRDF (symmetric, but it is not), it is not finite somewhere or, for a logarithm, 0
    everywhere, or `resume` is of another kind.
    """
    yield Step(0.0, "sampling")
    data = factor_data(brdf, settings.samples, settings.max_theta, settings.seed)
    pairs = reference(brdf, seed=settings.seed)
    if settings.separable:
        return (yield from _separable(brdf, settings, data, pairs))
    name = _name(brdf)
    if settings.method == "homomorphic":
        size = settings.size or HOMOMORPHIC_SIZE
        found = mccool(data, size, settings.reciprocal, epsilon=settings.epsilon, reference=pairs)
        terms = min(settings.terms or len(found.ladder), len(found.ladder))
        found = replace(found, factors=found.factors.truncated(terms), ladder=found.ladder[:terms])
    else:
        if resume is not None and resume.method != "search":
            raise UsageError(f"a search cannot go on from factors of the method {resume.method}")
        if resume is not None and resume.factors.name not in ("", "factors", name):
            raise UsageError(f"these factors are of {resume.factors.name}, and cannot go on as factors of {name}")
        found = yield from search(data, settings.search_settings(), reference=pairs, resume=resume)
    found = replace(found, factors=replace(found.factors, name=name))
    yield Step(1.0, "done", found)
    return found


def _separable(brdf: Brdf, settings: FactorSettings, data: FactorData, pairs: Reference) -> Steps[Factorisation]:
    """The best of the maps and parametrisations that are to be tried, and its errors."""
    started = time.perf_counter()
    maps = KINDS if settings.map == "auto" else (settings.map,)
    forms = PARAMETRISATIONS if settings.parametrisation == "auto" else (settings.parametrisation,)
    tried: list[tuple[float, Separated]] = []
    for index, (kind, form) in enumerate((kind, form) for form in forms for kind in maps):
        share = 0.7 / (len(maps) * len(forms))
        steps = _one(brdf, settings, DirectionMap(kind, settings.size or SEPARABLE_SIZE), form, pairs)
        found = yield from part(steps, index * share, (index + 1) * share)
        tried.append((pairs.rms(found.factors)[0], found))
    found = min(tried, key=lambda one: one[0])[1]
    made = time.perf_counter() - started
    result = Factorisation(
        replace(found.factors, name=_name(brdf)),
        found.method,
        (),
        asymmetry=found.asymmetry,
        condition_number=found.condition_number,
        optimum_ratio=found.optimum_ratio,
        weighting=found.weighting,
        converged=found.converged,
        negative_energy=found.factors.negative_energy(pairs.wi, pairs.wo),
    )
    for terms in range(1, found.factors.terms + 1):
        rung = _rung(result.factors.truncated(terms), data, pairs, made, settings)
        result = replace(result, ladder=(*result.ladder, rung))
        yield Step(0.7 + 0.3 * terms / found.factors.terms, f"comparing {terms} terms", result)
    return result


def _one(
    brdf: Brdf, settings: FactorSettings, chart: DirectionMap, form: Parametrisation, pairs: Reference
) -> Steps[Separated]:
    if settings.method == "normalised":
        factors = yield from normalised(brdf, chart, form, pairs)
        return Separated(factors, "normalised", "cosine", 0.0, 1.0, 0.0, 1, True)
    method: SeparableMethod = "auto"
    if settings.method in METHODS and not (settings.method == "symmetric" and form == "half-diff"):
        method = settings.method  # type: ignore[assignment]
    return (
        yield from separate(
            brdf,
            chart,
            settings.terms or SEPARABLE_TERMS,
            method=method,
            parametrisation=form,
            weighting=settings.weighting,
            seed=settings.seed,
            reference=pairs,
        )
    )


def _name(brdf: Brdf) -> str:
    return brdf_to_text(brdf) if type(brdf) in MODELS.values() else str(getattr(brdf, "name", ""))


def _rung(
    factors: SeparableFactors, data: FactorData, pairs: Reference, made: float, settings: FactorSettings
) -> TermError:
    rms, bands = pairs.rms(factors)
    return TermError(
        terms=factors.terms,
        textures=2 * factors.terms,
        rms_cosine_weighted=rms,
        rms_by_elevation_band=bands,
        metrics=metrics(factors.f(data.wi, data.wo), data, settings.epsilon),
        time_s=made,
        size_bytes=factors.size_bytes,
    )
