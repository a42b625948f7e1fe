"""Factor a BRDF by any method, with its error for every number of terms, live while it runs.

symmetric, svd, power     sums of products of two textures (`separable`)
nonnegative               such sums without a negative term (`solvers.nonnegative`)
normalised                one such product, positive (`normalised`)
homomorphic               products of textures of McCool's fixed projections (`homomorphic`)
search                    products of textures of the projections that Cole's search finds
auto                      of a formula, symmetric where its matrix is, otherwise svd; of a measurement, these only if in
                          no held-out error worse than a search and than McCool's at equal count, else the search
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace

from engine.brdf.brdf import MODELS, Brdf, brdf_to_text
from engine.brdf.readers.rgl import RglBrdf
from engine.brdf.scattered import ScatteredBrdf
from engine.brdf.table import DirectionTable, HalfDifferenceTable
from engine.core.errors import UsageError
from engine.core.figure_text import number
from engine.core.steps import Step, Steps, part
from engine.factor.data import FactorData, factor_data
from engine.factor.errors import (
    Factorisation,
    HeldOut,
    Reference,
    TermError,
    compute_held_out_errors,
    metrics,
    reference,
)
from engine.factor.held_out import SIZES, choose, sums_foretold, term_errors_judged
from engine.factor.hemisphere_map import KINDS, HemisphereMap, MapKind
from engine.factor.homomorphic import HomomorphicFactors
from engine.factor.normalised import normalise
from engine.factor.projection_search import search
from engine.factor.separable import NAMES, SeparableMethod, Separated, in_norms, norms_of
from engine.factor.separable_factors import PARAMETRISATIONS, Parametrisation, SeparableFactors
from engine.factor.settings import DEFAULT, MAX_TEXTURES, FactorSettings
from engine.factor.solvers.regions import Parts, gaps, parts_of
from engine.factor.textures import THESIS, SearchSettings, mccool

#: Measurements that are factored from their own samples, and all measurements.
SAMPLED = (ScatteredBrdf, HalfDifferenceTable, DirectionTable)
MEASURED = (*SAMPLED, RglBrdf)


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
    if isinstance(brdf, MEASURED):
        data = data.add_ceiling(reciprocal=brdf.reciprocal)
    pairs = reference(brdf, seed=settings.seed)
    parts = parts_of(data.wi, data.wo, data.measurement)
    if settings.method == "auto" and isinstance(brdf, MEASURED) and parts is not None:
        found = yield from _automatic(brdf, settings, data, pairs, parts, resume)
    elif settings.separable:
        found = yield from _separable(brdf, settings, data, pairs, parts)
    elif settings.method == "homomorphic":
        found = yield from _fit_fixed(settings, data, pairs, parts)
    else:
        found = yield from _search(_name(brdf), settings, data, pairs, parts, resume)
    unmeasured = _find_unmeasured(brdf, data, pairs)
    return replace(found, factors=replace(found.factors, name=_name(brdf)), unmeasured=unmeasured)


def _find_unmeasured(brdf: Brdf, data: FactorData, pairs: Reference) -> str:
    """A sentence on pairs of directions that a measurement leaves out; "" for formulas."""
    if not isinstance(brdf, SAMPLED):
        return ""
    found = gaps((data.wi, data.wo, data.measurement), pairs.wi, pairs.wo)
    return found.sentence if found is not None else ""


def _automatic(
    brdf: Brdf, settings: FactorSettings, data: FactorData, pairs: Reference, parts: Parts, resume: Factorisation | None
) -> Steps[Factorisation]:
    """A search of a measurement, or sums of products where they are better; `choice` says why."""
    form = "in-out" if settings.parametrisation == "auto" else settings.parametrisation
    searching = replace(settings, method="search", preset="default", parametrisation=form)
    before = resume if resume is not None and resume.method == "search" else None
    if before is not None:
        return (yield from _search(_name(brdf), searching, data, pairs, parts, before))
    sums = yield from part(_separable(brdf, settings, data, pairs, parts), 0.0, 0.2)
    searched = yield from part(_search(_name(brdf), searching, data, pairs, parts, None), 0.2, 0.95)
    ours, others = searched.term_errors[-1].held_out, sums.term_errors[-1].held_out
    if ours is None or others is None:
        return sums
    if others.no_worse(ours):
        fixed = yield from part(_fit_fixed(replace(searching, textures=MAX_TEXTURES), data, pairs, parts), 0.95, 1.0)
        if _no_worse_than(sums, (*fixed.term_errors, *fixed.left_out)):
            return replace(sums, choice=_choice("Sums of products", others, "a search", ours))
    return replace(searched, choice=_choice("The search", ours, "sums of products", others))


def _no_worse_than(sums: Factorisation, sets: Sequence[TermError]) -> bool:
    """True if no number of terms is in either held-out error worse than the set of as many textures, or than all."""
    fixed = [term_error.held_out for term_error in sets]
    pairs = [(term_error.held_out, fixed[min(term_error.textures, len(fixed)) - 1]) for term_error in sums.term_errors]
    return all(one is not None and other is not None and one.no_worse(other) for one, other in pairs)


def _choice(chosen: str, its: HeldOut, other: str, errors: HeldOut) -> str:
    rms, log = (f"{number(getattr(its, name), 3)}" for name in ("rms_cosine_weighted", "sq_log"))
    other_rms, other_log = (f"{number(getattr(errors, name), 3)}" for name in ("rms_cosine_weighted", "sq_log"))
    return (
        f"{chosen} was taken by its held-out errors: RMS {rms} and squared logarithm {log}, "
        f"where {other} had {other_rms} and {other_log}."
    )


def _fit_fixed(
    settings: FactorSettings, data: FactorData, pairs: Reference, parts: Parts | None
) -> Steps[Factorisation]:
    """McCool's textures, up to the number that is best."""
    steps = mccool(data, settings.size, settings.reciprocal, epsilon=settings.epsilon, reference=pairs)
    found = yield from part(steps, 0.0, 0.5)
    terms = min(settings.textures, len(found.term_errors))
    found = replace(found, factors=found.factors.truncate(terms), term_errors=found.term_errors[:terms])
    if parts is None:
        return found
    found = yield from part(term_errors_judged(data, search_settings(settings), found, parts), 0.5, 1.0)
    return _cut(found)


def _search(
    name: str,
    settings: FactorSettings,
    data: FactorData,
    pairs: Reference,
    parts: Parts | None,
    resume: Factorisation | None,
) -> Steps[Factorisation]:
    """Textures that the search proposes and regions left out choose; those proposed where the thesis is asked for."""
    asked = search_settings(settings)
    if resume is not None:
        if resume.method != "search" or not isinstance(resume.factors, HomomorphicFactors):
            raise UsageError(f"a search cannot go on from factors of the method {resume.method}")
        if resume.factors.name not in ("", "factors", name):
            raise UsageError(f"these factors are of {resume.factors.name}, and cannot go on as factors of {name}")
        size = len(resume.factors.textures[0])
        if resume.best_terms is not None and size in SIZES and size < asked.size:
            asked = replace(asked, size=size, low_size=min(asked.low_size, size))
    by_regions = parts is not None and settings.preset == "default"
    # λ is chosen by regions afterwards
    proposing = replace(asked, held_out=0.0) if by_regions else asked
    steps = search(data, proposing, reference=pairs, resume=resume)
    proposed = yield from part(steps, 0.0, 0.7 if parts is not None else 1.0)
    if parts is None or proposed is resume:
        return proposed
    if not by_regions:
        return (yield from part(term_errors_judged(data, asked, proposed, parts), 0.7, 1.0))
    steps = choose(
        data,
        asked,
        proposed,
        parts,
        sizes=[size for size in SIZES if size < asked.size],
        reference=pairs,
        before=resume if resume is not None and resume.held_out_by else None,
    )
    return (yield from part(steps, 0.7, 1.0))


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


def _separable(
    brdf: Brdf, settings: FactorSettings, data: FactorData, pairs: Reference, parts: Parts | None
) -> Steps[Factorisation]:
    """The best of the maps and parametrisations that are to be tried, up to the number of terms that is best."""
    started = time.perf_counter()
    forms = PARAMETRISATIONS if settings.parametrisation == "auto" else (settings.parametrisation,)
    hemisphere_maps = [(kind, form) for form in forms for kind in _maps(settings, form)]
    tried: list[list[tuple[float, Separated]]] = []
    for index, (kind, form) in enumerate(hemisphere_maps):
        share = 0.5 / len(hemisphere_maps)
        steps = _in_norms(brdf, settings, HemisphereMap(kind, settings.side), form, pairs)
        norms = yield from part(steps, index * share, (index + 1) * share)
        tried.append([(pairs.rms(one.factors)[0], one) for one in norms])
    best = min(tried, key=lambda norms: min(rms for rms, _ in norms))
    best = [(rms, replace(one, factors=replace(one.factors, ceiling=data.ceiling))) for rms, one in best]
    found = min(best, key=lambda one: one[0])[1]
    errors: Sequence[HeldOut | None] | None = None
    if isinstance(brdf, MEASURED):
        found, errors = yield from part(_norm_judged(brdf, settings, [one for _, one in best], data, parts), 0.5, 0.7)
    made = time.perf_counter() - started
    held_out_by = "between texels" if not isinstance(brdf, ScatteredBrdf) else "regions" if errors and errors[0] else ""
    result = Factorisation(
        found.factors,
        found.method,
        (),
        asymmetry=found.asymmetry,
        condition_number=found.condition_number,
        optimum_ratio=found.optimum_ratio,
        weighting=found.weighting,
        converged=found.converged,
        negative_energy=found.factors.negative_energy(pairs.wi, pairs.wo),
        held_out_by=held_out_by,
    )
    for terms in range(1, found.factors.terms + 1):
        term_error = _term_error(found.factors.truncate(terms), data, pairs, made, settings)
        if errors is not None:
            term_error = _with(term_error, errors[terms - 1])
        result = replace(result, term_errors=(*result.term_errors, term_error))
        yield Step(0.7 + 0.3 * terms / found.factors.terms, f"comparing {terms} terms", result)
    result = _cut(result)
    assert isinstance(result.factors, SeparableFactors)
    return replace(result, negative_energy=result.factors.negative_energy(pairs.wi, pairs.wo))


def _norm_judged(
    brdf: Brdf, settings: FactorSettings, norms: Sequence[Separated], data: FactorData, parts: Parts | None
) -> Steps[tuple[Separated, Sequence[HeldOut | None]]]:
    """The one of `norms` whose best number of terms has the least product of both held-out errors, and its errors.

    Of samples these are errors in regions that are left out; tables and adaptive measurements are read between texels.
    """
    if not isinstance(brdf, ScatteredBrdf):
        errors = []
        for one in norms:
            yield Step(0.0, "comparing norms")
            sums = [one.factors.truncate(terms) for terms in range(1, one.factors.terms + 1)]
            errors.append([compute_held_out_errors(each.f(data.wi, data.wo), data, settings.epsilon) for each in sums])
    elif parts is None or norms[0].method == "normalised":
        return norms[0], [None] * norms[0].factors.terms
    else:
        foretold = yield from sums_foretold(brdf, norms, data, parts, settings.seed)
        errors = [[compute_held_out_errors(values, data, settings.epsilon) for values in each] for each in foretold]
    best = [min(each, key=lambda one: one.rms_cosine_weighted).score for each in errors]
    chosen = best.index(min(best))
    return norms[chosen], errors[chosen]


def _with(term_error: TermError, errors: HeldOut | None) -> TermError:
    rms, log = (errors.rms_cosine_weighted, errors.sq_log) if errors is not None else (None, None)
    return replace(term_error, held_out_rms_cosine_weighted=rms, held_out_sq_log=log)


def _cut(found: Factorisation) -> Factorisation:
    """The terms up to the number that is best by held-out errors: further ones make it worse and are not stored.

    That is the one with the least RMS of a sum, whose terms come in the order of that norm, and with the least product
    of both errors of a product, whose textures are fitted to logarithms.
    """
    errors = [term_error.held_out for term_error in found.term_errors]
    if any(each is None for each in errors):
        return found
    of_sum = isinstance(found.factors, SeparableFactors)
    scores = [each.rms_cosine_weighted if of_sum else each.score for each in errors if each is not None]
    best = scores.index(min(scores))
    terms = found.term_errors[best].terms
    factors = found.factors.truncate(terms)
    return replace(
        found,
        factors=factors,
        term_errors=found.term_errors[: best + 1],
        left_out=found.term_errors[best + 1 :],
        projections=getattr(factors, "projections", ()),
        best_terms=terms,
    )


def _maps(settings: FactorSettings, form: Parametrisation) -> tuple[MapKind, ...]:
    """The maps to try; over half and difference vectors the polar one has the highlight at its pole."""
    if settings.map == "auto":
        return KINDS
    return (settings.map or ("polar" if form == "half-diff" else "orthographic"),)


def _in_norms(
    brdf: Brdf, settings: FactorSettings, hemisphere_map: HemisphereMap, form: Parametrisation, pairs: Reference
) -> Steps[list[Separated]]:
    """The sums in each norm that is to be tried."""
    if settings.method == "normalised":
        factors = yield from normalise(brdf, hemisphere_map, form, pairs)
        return [Separated(factors, "normalised", "cosine", 0.0, 1.0, 0.0, 1, True)]
    method: SeparableMethod = "auto"
    if settings.method in NAMES and not (settings.method == "symmetric" and form == "half-diff"):
        method = settings.method  # type: ignore[assignment]
    return (
        yield from in_norms(
            brdf,
            hemisphere_map,
            settings.products,
            norms_of(settings.weighting),
            method=method,
            parametrisation=form,
            seed=settings.seed,
        )
    )


def _name(brdf: Brdf) -> str:
    return brdf_to_text(brdf) if type(brdf) in MODELS.values() else str(getattr(brdf, "name", ""))


def _term_error(
    factors: SeparableFactors, data: FactorData, pairs: Reference, made: float, settings: FactorSettings
) -> TermError:
    """The errors of `factors`; held-out ones are the same, because samples and pairs lie between the texels."""
    rms, bands = pairs.rms(factors)
    errors = metrics(factors.f(data.wi, data.wo), data, settings.epsilon)
    return TermError(
        terms=factors.terms,
        textures=2 * factors.terms,
        rms_cosine_weighted=rms,
        rms_by_elevation_band=bands,
        metrics=errors,
        time_s=made,
        size_bytes=factors.size_bytes,
        held_out_rms_cosine_weighted=rms,
        held_out_sq_log=errors.sq_log,
    )
