"""The choice of projections, smoothness, size and number of textures by regions of the sphere that were left out.

A search makes the error over its own samples small, and few measurements leave it room to be wrong everywhere else: two
searched textures of a Cornell paint were six times as far from fresh pairs as McCool's. Here the search only proposes.
Term after term is the projection with the least held-out errors (`HeldOut`) among those that were proposed, the fixed
ones and McCool's; λ is that of the least ones too, and so is the size where none was asked for. What is stored

    is in neither error worse than McCool's set of as many textures, or of all of his where there are more
    is in neither error worse than fewer terms that are stored beside it, and better in their product
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from engine.brdf.scattered import ScatteredBrdf, fit_scattered
from engine.core.one_thread import one_thread
from engine.core.steps import Result, Step, Steps, relay
from engine.factor.data import FactorData, parabolic_directions
from engine.factor.errors import Factorisation, HeldOut, Reference, TermError, compute_held_out_errors
from engine.factor.hemisphere_map import HemisphereMap
from engine.factor.homomorphic import HomomorphicFactors, LogSpace
from engine.factor.projections import FixedProjection, Projection, mccool_projections
from engine.factor.separable import SeparableMethod, Separated, in_norms
from engine.factor.solvers.least_squares import DENSE_LIMIT, Fit, solve
from engine.factor.solvers.least_squares_rows import predict
from engine.factor.solvers.regions import PARTS, Parts
from engine.factor.textures import Level, SearchSettings, TermErrors, part_of

Floats = NDArray[np.float64]

#: λ with which projections are compared, and that λ is changed by while the score falls to this share at least.
FIRST_SMOOTHING, CHANGE, GAIN = 1e-3, 10.0, 0.99

#: Least and largest λ.
MIN_SMOOTHING, MAX_SMOOTHING = 1e-8, 1.0

#: Projections of each term whose λ is chosen too.
FINALISTS = 3

#: Methods of sums that are made again as they are without a region; all others by singular values.
_REPEATED: dict[str, SeparableMethod] = {"power": "power", "nonnegative": "nonnegative"}

#: Texels a side, at most, of the maps of sums that are made to be judged.
LARGEST_JUDGED = 24

#: Random pairs of each part at which textures are held to the ceiling, and their largest angle from the normal.
BETWEEN, LARGEST_ANGLE = 1000, float(np.radians(80.0))

#: Sizes of textures that are tried where none is asked for.
SIZES = (8, 12, 16, 24)


@dataclass(frozen=True, eq=False)
class Judged:
    """Projections with the λ of their textures and their held-out errors; `stored` is what an earlier run made."""

    projections: tuple[Projection, ...]
    smoothing: float
    held_out: HeldOut
    stored: tuple[HomomorphicFactors, TermError] | None = None

    @property
    def score(self) -> float:
        return self.held_out.score


def foretold(
    level: Level, data: FactorData, projections: Sequence[Projection], smoothing: float, parts: Parts
) -> Steps[tuple[Floats, float]]:
    """Values (N, 3) in 1/sr at the samples of `data`, each by textures that were solved without its part.

    With them the excess (`HeldOut`) of these textures, over random pairs of each part.
    """
    values = np.empty_like(data.value)
    judging = level.beside()
    judging.smoothing = smoothing
    rows = [level.keep_rows(each) for each in projections]
    words, above = (level.settings.parametrisation, level.settings.reciprocal), 0.0
    for part in range(PARTS):
        yield Step(0.0, "holding out regions")
        out = parts == part
        target = level.target[~out]
        terms = [judging.term(each, part_of(one, ~out), target) for each, one in zip(projections, rows, strict=True)]
        textures = solve(terms, target).textures
        log = sum(predict(part_of(one, out), texture) for one, texture in zip(rows, textures, strict=True))
        largest = data.value[~out].max(axis=0)
        space = LogSpace(level.space.mean, level.space.epsilon, np.where(largest > 0.0, largest, level.space.largest))
        values[out] = space.backward(log)
        above += _sum_excess(level, HomomorphicFactors(textures, tuple(projections), level.space, *words), part)
    return values, float(np.sqrt(above / PARTS))


def _sum_excess(level: Level, factors: HomomorphicFactors, part: int) -> float:
    """The mean square of what `factors` rise above the ceiling, × cos θ_i; 0 where there is none."""
    if level.ceiling is None:
        return 0.0
    rng = np.random.default_rng(part)
    wi, wo = (parabolic_directions(rng, BETWEEN, LARGEST_ANGLE) for _ in range(2))
    above = np.maximum(factors.f(wi, wo) - level.ceiling.look_up(wi, wo), 0.0) * wi[:, 2:]
    return float((above * above).mean())


def judge(
    level: Level, data: FactorData, projections: Sequence[Projection], smoothing: float, parts: Parts
) -> Steps[Judged]:
    values, excess = yield from foretold(level, data, projections, smoothing, parts)
    errors = compute_held_out_errors(values, data, level.space.epsilon)
    return Judged(tuple(projections), smoothing, replace(errors, excess=excess))


def smooth(level: Level, data: FactorData, first: Judged, parts: Parts) -> Steps[list[Judged]]:
    """`first`, and the same projections with more or less smoothing as long as the score falls; the best is last."""
    if len(first.projections) * level.size**2 > DENSE_LIMIT:
        return [first]
    tried = [first]
    for change in (CHANGE, 1.0 / CHANGE):
        while MIN_SMOOTHING <= tried[-1].smoothing * change <= MAX_SMOOTHING:
            smoothing = tried[-1].smoothing * change
            after = yield from judge(level, data, first.projections, smoothing, parts)
            if not after.score < GAIN * tried[-1].score:
                tried.insert(0, after)
                break
            tried.append(after)
        if tried[-1] is not first:
            break
    return tried


def fit_fixed_sets(level: Level, data: FactorData, parts: Parts) -> Steps[list[Judged]]:
    """McCool's first 1, 2, … textures, each set as smooth as it is by itself."""
    found = []
    fixed = mccool_projections(level.settings.reciprocal)
    for number in range(1, len(fixed) + 1):
        other = level.beside()
        other.chosen = list(fixed[:number])
        settled, _ = yield from other.settle()
        found.append((yield from judge(level, data, fixed[:number], settled.smoothing, parts)))
    return found


def term_errors_judged(
    data: FactorData, settings: SearchSettings, found: Factorisation, parts: Parts
) -> Steps[Factorisation]:
    """`found` with the held-out errors of each number of terms, all textures solved together with the λ they have."""
    factors = found.factors
    assert isinstance(factors, HomomorphicFactors)
    size = len(factors.textures[0])
    level = Level(data, LogSpace.of(data.value, settings.epsilon), settings, size)
    term_errors = []
    for number, term_error in enumerate(found.term_errors):
        projections = factors.truncate(term_error.terms).projections
        steps = judge(level, data, projections, term_error.smoothing, parts)
        share = number / len(found.term_errors)
        errors = (yield from relay(steps, lambda step, share=share: Step(share, step.note, found))).held_out  # type: ignore[misc]
        term_errors.append(
            replace(term_error, held_out_rms_cosine_weighted=errors.rms_cosine_weighted, held_out_sq_log=errors.sq_log)
        )
    best = min(term_errors, key=lambda term_error: term_error.held_out.score)  # type: ignore[union-attr]
    return replace(found, term_errors=tuple(term_errors), held_out_by="regions", best_terms=best.terms)


def choose(
    data: FactorData,
    settings: SearchSettings,
    proposed: Factorisation,
    parts: Parts,
    *,
    sizes: Sequence[int] = (),
    reference: Reference | None = None,
    before: Factorisation | None = None,
) -> Steps[Factorisation]:
    """Factors of projections that `proposed` holds, or of fixed ones, as the head of this file says.

    `sizes` are those that may be taken instead of that of the settings. `before` is a result whose terms are kept.
    """
    taken = proposed.term_errors[-1].time_s if proposed.term_errors else 0.0
    term_errors = TermErrors(data, settings, reference, time.perf_counter() - taken)
    with one_thread():
        return (
            yield from _resume(
                _choose(data, settings, proposed, parts, sizes, term_errors, before), term_errors, proposed
            )
        )


def _choose(
    data: FactorData,
    settings: SearchSettings,
    proposed: Factorisation,
    parts: Parts,
    sizes: Sequence[int],
    term_errors: TermErrors,
    before: Factorisation | None,
) -> Steps[Factorisation]:
    level = Level(data, LogSpace.of(data.value, settings.epsilon), settings, settings.size)
    fixed = yield from fit_fixed_sets(level, data, parts)
    bar = fixed[min(settings.terms, len(fixed)) - 1].held_out
    found, more = yield from _grow(level, data, parts, _pool(settings, proposed), fixed, bar, _keep(before))
    stored = _nest(found)
    if before is None:
        level, stored = yield from _size(level, data, parts, sizes, stored, bar)
    fit: Fit | None = None
    for one in stored:
        yield Step(0.0, "solving for all textures")
        fit = _add(level, one, term_errors)
    beyond = TermErrors(data, settings, term_errors.reference, term_errors.started)
    for one in more:
        yield Step(0.0, "solving for all textures")
        _add(level, one, beyond)
    return replace(
        term_errors.factorisation("search", fit, proposed.evaluations),
        left_out=beyond.errors,
        held_out_by="regions",
        best_terms=term_errors.errors[-1].terms,
    )


def _add(level: Level, one: Judged, term_errors: TermErrors) -> Fit | None:
    """Solve for the textures of `one` with all samples, and put them on the sweep."""
    if one.stored is not None:
        factors, term_error = one.stored
        term_errors.factors, term_errors.errors = (*term_errors.factors, factors), (*term_errors.errors, term_error)
        return None
    solved = level.beside()
    solved.chosen, solved.smoothing = list(one.projections), one.smoothing
    fit = solved.solve_all()
    term_errors.add(solved)
    term_errors.judge_last(one.held_out)
    return fit


def _keep(before: Factorisation | None) -> list[Judged]:
    """The terms of an earlier result, as they are."""
    if before is None:
        return []
    whole = before.factors
    assert isinstance(whole, HomomorphicFactors)
    term_errors = ((whole.truncate(term_error.terms), term_error) for term_error in before.term_errors)
    return [
        Judged(factors.projections, term_error.smoothing, term_error.held_out, (factors, term_error))
        for factors, term_error in term_errors
        if term_error.held_out is not None
    ]


def _pool(settings: SearchSettings, proposed: Factorisation) -> list[Projection]:
    """The projections to choose from: the fixed ones, McCool's, and what the search went through."""
    pool: list[Projection] = [FixedProjection(kind) for kind in settings.fixed]
    factors = proposed.factors
    assert isinstance(factors, HomomorphicFactors)
    for term_error in (*factors.shorter, factors):
        pool.extend(term_error.projections)
    pool.extend(mccool_projections(settings.reciprocal))
    return list(dict.fromkeys(pool))


def _grow(
    level: Level,
    data: FactorData,
    parts: Parts,
    pool: Sequence[Projection],
    fixed: Sequence[Judged],
    bar: HeldOut,
    kept: Sequence[Judged],
) -> Steps[tuple[list[Judged], list[Judged]]]:
    """The best projections of each number of terms, and those of one more term that no longer make them better.

    While fewer terms are worse than McCool's whole set, `bar`, in either error, more need not be better in both.
    """
    found = list(kept)
    number = len(found[-1].projections) if found else 0
    few = np.sort(np.random.default_rng(level.settings.seed).permutation(len(data))[: level.settings.low_samples])
    some, some_parts = data.part(few), parts[few]
    coarse = Level(some, level.space, level.settings, level.size)
    while number < level.settings.terms:
        number += 1
        beside = fixed[min(number, len(fixed)) - 1]
        ranked = yield from _rank(coarse, some, some_parts, pool, found[-1] if found else None)
        candidates = []
        for one in ranked[:FINALISTS]:
            first = yield from judge(level, data, one.projections, one.smoothing, parts)
            candidates.extend((yield from smooth(level, data, first, parts)))
        if number <= len(fixed):
            candidates.append(beside)
        sound = [one for one in candidates if one.held_out.no_worse(beside.held_out)]
        if found and found[-1].held_out.no_worse(bar):
            last = found[-1]
            better = [one for one in sound if one.held_out.no_worse(last.held_out) and one.score < GAIN * last.score]
            if not better:
                return found, [min(candidates, key=_score)]
            sound = better
        if not sound:
            break
        found.append(min(sound, key=_score))
    return found, []


def _rank(
    level: Level, data: FactorData, parts: Parts, pool: Sequence[Projection], base: Judged | None
) -> Steps[list[Judged]]:
    """`base` with each further projection of the pool, from the least score up."""
    known = base.projections if base is not None else ()
    smoothing = base.smoothing if base is not None else FIRST_SMOOTHING
    tried = []
    for projection in pool:
        if projection not in known:
            tried.append((yield from judge(level, data, (*known, projection), smoothing, parts)))
    return sorted(tried, key=_score)


def _nest(found: Sequence[Judged]) -> list[Judged]:
    """The last one, and those before it of which each is in neither error better than the next."""
    nested = [found[-1]]
    for one in reversed(found[:-1]):
        if nested[0].held_out.no_worse(one.held_out):
            nested.insert(0, one)
    return nested


def _size(
    level: Level, data: FactorData, parts: Parts, sizes: Sequence[int], stored: list[Judged], bar: HeldOut
) -> Steps[tuple[Level, list[Judged]]]:
    """The same projections with textures of the size that has the least score, all of one size."""
    best, at = stored[-1], level
    for size in sizes:
        if size == level.size or len(best.projections) * size**2 > DENSE_LIMIT:
            continue
        other = Level(data, level.space, level.settings, size)
        first = yield from judge(other, data, best.projections, best.smoothing, parts)
        last = (yield from smooth(other, data, first, parts))[-1]
        if last.held_out.no_worse(bar) and last.score < GAIN * best.score:
            best, at = last, other
    if at is level:
        return level, stored
    found = []
    for one in stored[:-1]:
        first = yield from judge(at, data, one.projections, one.smoothing, parts)
        found.append((yield from smooth(at, data, first, parts))[-1])
    return at, _nest([*found, best])


def _score(one: Judged) -> float:
    return one.score


def _resume(steps: Steps[Result], term_errors: TermErrors, proposed: Factorisation) -> Steps[Result]:
    """`steps` that show what was proposed; the time until the next one is asked for is not theirs."""
    taken = 0
    try:
        while True:
            try:
                step = next(steps)
            except StopIteration as finished:
                return finished.value
            taken += 1
            offered = time.perf_counter()
            yield Step(taken / (taken + 500.0), step.note, proposed)
            term_errors.started += time.perf_counter() - offered
    finally:
        steps.close()


def sums_foretold(
    brdf: ScatteredBrdf, found: Sequence[Separated], data: FactorData, parts: Parts, seed: int
) -> Steps[list[Floats]]:
    """For each of `found`, values (K, N, 3) at the samples of `data` of its first 1 … K terms, made from other parts.

    The sums differ in their norms alone. The smooth BRDF is made anew from the samples of other parts, in the
    coordinates and with the kernel of all of them. Maps have `LARGEST_JUDGED` texels a side at most: sampling the
    matrix takes the time.
    """
    first = found[0].factors
    hemisphere_map = HemisphereMap(first.hemisphere_map.kind, min(first.hemisphere_map.size, LARGEST_JUDGED))
    most = max(each.factors.terms for each in found)
    values = [np.zeros((each.factors.terms, *data.value.shape)) for each in found]
    measured = np.empty(brdf.measured.value.shape[0], np.intp)
    measured[data.measurement] = parts
    for part in range(PARTS):
        kept = brdf.measured.part(measured != part)
        smooth = yield from relay(fit_scattered(kept, shape=brdf.shape), _still)
        again = yield from relay(
            in_norms(
                smooth,
                hemisphere_map,
                most,
                [each.weighting for each in found],
                method=_REPEATED.get(found[0].method, "svd"),
                parametrisation=first.parametrisation,
                seed=seed,
            ),
            _still,
        )
        out = parts == part
        for value, each in zip(values, again, strict=True):
            for terms in range(1, len(value) + 1):
                factors = each.factors.truncate(min(terms, each.factors.terms))
                value[terms - 1, out] = factors.f(data.wi[out], data.wo[out])
                yield Step(0.0, "holding out regions")
    return values


def _still(step: Step) -> Step:
    return Step(0.0, "holding out regions")
