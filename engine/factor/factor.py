"""Factor a BRDF by any method, with its error for every number of terms, live while it runs.

symmetric, svd, power     sums of products of two textures (`separable`); auto is symmetric where the matrix is
normalised                one such product, positive (`normalised`)
homomorphic               products of textures of McCool's fixed projections (`homomorphic`)
search                    products of textures of the projections that Cole's search finds
"""

from __future__ import annotations

import time
from dataclasses import replace

from engine.brdf.brdf import MODELS, Brdf, brdf_to_text
from engine.core.errors import UsageError
from engine.core.steps import Step, Steps, part
from engine.factor.data import FactorData, factor_data
from engine.factor.errors import Factorisation, Reference, TermError, metrics, reference
from engine.factor.hemisphere_map import KINDS, HemisphereMap, MapKind
from engine.factor.normalised import normalised
from engine.factor.projection_search import search
from engine.factor.separable import METHODS, SeparableMethod, Separated, separate
from engine.factor.separable_factors import PARAMETRISATIONS, Parametrisation, SeparableFactors
from engine.factor.settings import DEFAULT, FactorSettings
from engine.factor.textures import THESIS, SearchSettings, mccool


def factor(brdf: Brdf, settings: FactorSettings = DEFAULT, resume: Factorisation | None = None) -> Steps[Factorisation]:
    """Factor `brdf`; each step's `partial` is the factorisation so far, or None before there is one.

    `resume` lets a search go on to more terms; separable factors take a second and are made anew. UsageError where
    the settings do not fit each other or the BRDF (symmetric, but it is not), it is not finite somewhere or, for a
    logarithm, 0 everywhere, or `resume` is of another kind.
    """
    if settings.why_not:
        raise UsageError(settings.why_not)
    yield Step(0.0, "sampling")
    data = factor_data(brdf, settings.samples, settings.max_theta, settings.seed)
    pairs = reference(brdf, seed=settings.seed)
    if settings.separable:
        return (yield from _separable(brdf, settings, data, pairs))
    name = _name(brdf)
    if settings.method == "homomorphic":
        found = mccool(data, settings.size, settings.reciprocal, epsilon=settings.epsilon, reference=pairs)
        terms = min(settings.textures, len(found.ladder))
        found = replace(found, factors=found.factors.truncated(terms), ladder=found.ladder[:terms])
    else:
        if resume is not None and resume.method != "search":
            raise UsageError(f"a search cannot go on from factors of the method {resume.method}")
        if resume is not None and resume.factors.name not in ("", "factors", name):
            raise UsageError(f"these factors are of {resume.factors.name}, and cannot go on as factors of {name}")
        found = yield from search(data, search_settings(settings), reference=pairs, resume=resume)
    found = replace(found, factors=replace(found.factors, name=name))
    yield Step(1.0, "done", found)
    return found


def search_settings(settings: FactorSettings) -> SearchSettings:
    """The part that the search reads."""
    assert settings.parametrisation != "auto"
    base = THESIS if settings.preset == "thesis" else SearchSettings()
    return replace(
        base,
        terms=settings.textures,
        size=settings.size,
        low_size=min(base.low_size, settings.size),
        parametrisation=settings.parametrisation,
        reciprocal=settings.reciprocal,
        restarts=settings.restarts,
        together=settings.together,
        metric=settings.metric,
        epsilon=settings.epsilon,
        seed=settings.seed,
    )


def _separable(brdf: Brdf, settings: FactorSettings, data: FactorData, pairs: Reference) -> Steps[Factorisation]:
    """The best of the maps and parametrisations that are to be tried, and its errors."""
    started = time.perf_counter()
    forms = PARAMETRISATIONS if settings.parametrisation == "auto" else (settings.parametrisation,)
    hemisphere_maps = [(kind, form) for form in forms for kind in _maps(settings, form)]
    tried: list[tuple[float, Separated]] = []
    for index, (kind, form) in enumerate(hemisphere_maps):
        share = 0.7 / len(hemisphere_maps)
        steps = _one(brdf, settings, HemisphereMap(kind, settings.side), form, pairs)
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


def _maps(settings: FactorSettings, form: Parametrisation) -> tuple[MapKind, ...]:
    """The maps to try; over half and difference vectors the polar one has the highlight at its pole."""
    if settings.map == "auto":
        return KINDS
    return (settings.map or ("polar" if form == "half-diff" else "orthographic"),)


def _one(
    brdf: Brdf, settings: FactorSettings, hemisphere_map: HemisphereMap, form: Parametrisation, pairs: Reference
) -> Steps[Separated]:
    if settings.method == "normalised":
        factors = yield from normalised(brdf, hemisphere_map, form, pairs)
        return Separated(factors, "normalised", "cosine", 0.0, 1.0, 0.0, 1, True)
    method: SeparableMethod = "auto"
    if settings.method in METHODS and not (settings.method == "symmetric" and form == "half-diff"):
        method = settings.method  # type: ignore[assignment]
    return (
        yield from separate(
            brdf,
            hemisphere_map,
            settings.products,
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
