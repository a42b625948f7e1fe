"""The textures of given projections at one resolution, their error with one projection more, and McCool's fixed set.

`Level` is the inner loop of Cole's search (2002, Sec. 3.2): the samples, projected; the textures that stay, taken from
the target; and those that are solved anew with every projection that is tried. `TermErrors` keeps the factors of every
number of terms with their errors.

Their smoothness is chosen by samples that were held out.

λ of `engine.factor.solvers.least_squares` stands for what samples do not tell. Formulas are sampled as densely as one
likes, and there λ = 1e-4 is what keeps five textures from being better than two; a few hundred measured pairs need it:
with λ = 1e-6 the five textures of Cornell's cayman paint were three times as far from pairs that they had not seen. So
one measurement in five is left out, with all its copies turned about the normal, and λ falls by tens while the others
foretell these better beyond doubt.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from engine.core.errors import UsageError
from engine.core.params import check_values
from engine.core.steps import Step, Steps
from engine.factor.data import FactorData
from engine.factor.errors import Factorisation, HeldOut, Reference, TermError, metrics
from engine.factor.homomorphic import EPSILON, HomomorphicFactors, LogSpace
from engine.factor.projections import (
    KINDS,
    Extent,
    Kind,
    Parametrisation,
    Projection,
    look_ups,
    mccool_projections,
    points_of,
    texture_mask,
)
from engine.factor.settings import SMALLEST_SIZE, FactorSettings
from engine.factor.solvers.least_squares import DENSE_LIMIT, Fit, Term, solve, with_smoothing
from engine.factor.solvers.least_squares import term as made_term
from engine.factor.solvers.least_squares_rows import Rows, count_touched, predict, rows_of

Mask = NDArray[np.bool_]

#: λ falls by this factor, so many times at most, while each fall gains this share of the mean squared error, and that
#: gain is more than so many of its standard errors.
FALL, FALLS, GAIN, CERTAIN = 0.1, 4, 0.01, 2.0


def measure_held_out(measurement: NDArray[np.intp], share: float, seed: int) -> Mask:
    """Mask (N,) of the held-out samples: all of `share` of the measurements, the same for the same seed.

    None where one of the two parts would be empty.
    """
    numbers, of = np.unique(measurement, return_inverse=True)
    few = int(share * len(numbers))
    if not 0 < few < len(numbers):
        return np.zeros(len(measurement), np.bool_)
    left_out = np.zeros(len(numbers), np.bool_)
    left_out[np.random.default_rng(seed).permutation(len(numbers))[:few]] = True
    return np.asarray(left_out[of.reshape(-1)])


def part_of(rows: Rows, samples: Mask) -> Rows:
    """The rows of these samples."""
    return Rows(rows.texel[samples], rows.weight[samples], rows.size)


def smoothing_share(
    terms: Sequence[Term],
    target: Floats,
    held: Sequence[Rows],
    held_target: Floats,
    measurement: NDArray[np.intp],
) -> Steps[float]:
    """Factor in [1e-4, 1] for the λ of `terms`, which were made for `target` (N, 3).

    `held` are the rows of the same textures for other samples, with `held_target` (M, 3), by which it is judged, and
    the number of the `measurement` (M,) that each belongs to.
    """
    _, of = np.unique(measurement, return_inverse=True)
    copies = np.bincount(of.reshape(-1))

    def errors(share: float) -> Floats:
        """The mean squared error of each measurement."""
        residual = held_target.copy()
        fit = solve([with_smoothing(one, share) for one in terms], target)
        for rows, texture in zip(held, fit.textures, strict=True):
            residual -= predict(rows, texture)
        return np.asarray(np.bincount(of.reshape(-1), (residual * residual).mean(axis=1)) / copies)

    best, before = 1.0, errors(1.0)
    for fall in range(1, FALLS + 1):
        yield Step(0.0, "choosing the smoothness")
        after = errors(FALL**fall)
        gained = before - after
        doubt = CERTAIN * float(gained.std()) / np.sqrt(len(gained))
        if not gained.mean() > max(GAIN * before.mean(), doubt):
            break
        best, before = FALL**fall, after
    return best


Floats = NDArray[np.float64]

#: Strength λ of the smoothing while projections are searched: it fills what has no samples.
SMOOTHING = 1e-4

#: Share of the measurements that are left out, to see how much of it the textures need that are kept.
HELD_OUT = 0.2


@dataclass(frozen=True)
class SearchSettings:
    """Settings of the search for projections; see `engine.factor.projection_search`. Defaults that a user can change
    are those of `FactorSettings`.

    Attributes
    ----------
    terms : textures at most. size : texels a side. low_size : the same while restarts run, 0 for `size`.
    low_samples : samples while restarts run. finalists : how many of the starts go on with all.
    parametrisation, reciprocal : of the factors. extent : what textures are filled by.
    restarts : random starts per term. together : textures solved for every projection tried.
    metric : of `engine.factor.errors.METRICS`, which is made small. epsilon : see `LogSpace`.
    smoothing : λ ≥ 0 while projections are searched.
    held_out : share of the measurements by which the λ of the textures that are given away is chosen, not above
        `smoothing` (see `engine.factor.textures`); 0 leaves it. Without `refit` it is left anyway.
    guesses, fixed, mccool, refit : see there. seed : of all random numbers.
    """

    terms: int = FactorSettings.textures
    size: int = FactorSettings.size
    low_size: int = 8
    low_samples: int = 9000
    finalists: int = 2
    parametrisation: Parametrisation = "in-out"
    reciprocal: bool = FactorSettings.reciprocal
    extent: Extent = "disks"
    restarts: int = FactorSettings.restarts
    together: int = FactorSettings.together
    metric: str = FactorSettings.metric
    epsilon: float = FactorSettings.epsilon
    smoothing: float = SMOOTHING
    held_out: float = HELD_OUT
    guesses: bool = True
    fixed: tuple[Kind, ...] = tuple(kind for kind in KINDS if kind not in ("wi", "wo", "elevations-exchanged"))
    mccool: bool = True
    refit: bool = True
    seed: int = FactorSettings.seed

    def __post_init__(self) -> None:
        shared = {name: getattr(self, name) for name in ("size", "restarts", "together", "metric")}
        check_values(FactorSettings, textures=self.terms, **shared)
        for name, low, high in (("finalists", 1, 1000), ("low_samples", 1, 10**9)):
            if not low <= getattr(self, name) <= high:
                raise UsageError(f"{name} must lie in [{low}, {high}], not {getattr(self, name)}")
        if self.low_size and not SMALLEST_SIZE <= self.low_size <= self.size:
            raise UsageError(f"the lower size must be 0 or lie in [{SMALLEST_SIZE}, {self.size}], not {self.low_size}")
        if not self.smoothing >= 0.0:
            raise UsageError(f"the smoothing must not be negative, but is {self.smoothing}")
        if not 0.0 <= self.held_out < 1.0:
            raise UsageError(f"the share that is held out must lie in [0, 1), not {self.held_out}")
        if not (self.restarts or self.guesses or self.fixed):
            raise UsageError("without restarts, guesses and fixed projections there is nothing to try")


#: Ours.
DEFAULT = SearchSettings()

#: The thesis's settings (Sec. 4.1); it measured with textures of 16² and 24².
THESIS = SearchSettings(
    reciprocal=True, extent="cube", guesses=False, fixed=(), mccool=False, refit=False, held_out=0.0
)


class Level:
    """The samples at one resolution, the projections chosen so far and their textures."""

    def __init__(self, data: FactorData, space: LogSpace, settings: SearchSettings, size: int) -> None:
        self.space, self.settings, self.size = space, settings, size
        self.points = points_of(data.wi, data.wo, settings.parametrisation)
        self.target = space.forward(data.value)
        self.value = data.value
        self.measurement = data.measurement
        self.ceiling = data.ceiling
        self.smoothing = settings.smoothing
        self.chosen: list[Projection] = []
        self.textures: list[Floats] = []
        self._rows: dict[int, tuple[Projection, Rows]] = {}
        self._base = self.target
        self._prior: list[Term] = []

    def rows(self, projection: Projection) -> Rows:
        read = look_ups(projection, self.points, self.settings.parametrisation, self.settings.reciprocal)
        return rows_of(read, self.size)

    def keep_rows(self, projection: Projection) -> Rows:
        """Rows of a projection that is used again and again."""
        if id(projection) not in self._rows:
            self._rows[id(projection)] = projection, self.rows(projection)
        return self._rows[id(projection)][1]

    def forget(self) -> None:
        """Let go of the rows of projections that were shown and not chosen: some megabytes each."""
        self._rows = {id(each): self._rows[id(each)] for each in self.chosen if id(each) in self._rows}

    def term(self, projection: Projection, rows: Rows, target: Floats) -> Term:
        parametrisation, reciprocal = self.settings.parametrisation, self.settings.reciprocal
        mask = texture_mask(projection, parametrisation, reciprocal, self.size)
        return made_term(rows, target, mask, self.smoothing)

    def prepare(self) -> None:
        """Take the textures that stay as they are from the target, and set up those that are solved anew."""
        free = len(self.chosen) - min(self.settings.together - 1, len(self.chosen))
        self._base = self.target.copy()
        for projection, texture in zip(self.chosen[:free], self.textures[:free], strict=True):
            self._base -= predict(self.keep_rows(projection), texture)
        self._prior = [self.term(each, self.keep_rows(each), self._base) for each in self.chosen[free:]]

    def error(self, projection: Projection) -> float:
        """The metric with `projection` as one more term."""
        rows = self.rows(projection)
        terms = [*self._prior, self.term(projection, rows, self._base)]
        fit = solve(terms, self._base)
        residual = self._base.copy()
        for one, texture in zip(terms, fit.textures, strict=True):
            residual -= predict(one.rows, texture)
        return self._metric(residual)

    def _metric(self, residual: Floats) -> float:
        """The metric of target − approximation (N, 3)."""
        metric = self.settings.metric
        if not metric.endswith("log"):
            residual = self.space.backward(self.target - residual) - self.value
        if metric.startswith("sq"):
            return float((residual * residual).mean())
        return float(np.abs(residual).mean() if metric.startswith("abs") else np.abs(residual).max())

    def keep(self, projection: Projection) -> Fit:
        """Choose `projection` for the next term and solve its textures to the last digits."""
        if self.settings.refit:
            self.chosen.append(projection)
            return self.solve_all()
        terms = [*self._prior, self.term(projection, self.rows(projection), self._base)]
        fit = solve(terms, self._base, refine=True)
        self.chosen.append(projection)
        self.textures = [*self.textures[: len(self.chosen) - len(terms)], *fit.textures]
        return fit

    def settle(self) -> Steps[tuple[Level, Fit]]:
        """The same projections, with textures as smooth as samples that are left out ask for: those to be given away.

        Of more texels than `DENSE_LIMIT` none are left out: they stay as they are.
        """
        other = self.beside()
        held = measure_held_out(self.measurement, self.settings.held_out, self.settings.seed)
        rows = [self.keep_rows(each) for each in self.chosen]
        if held.any() and self.settings.smoothing > 0.0 and sum(map(count_touched, rows)) <= DENSE_LIMIT:
            target, known = self.target[~held], [part_of(one, held) for one in rows]
            pairs = zip(self.chosen, rows, strict=True)
            terms = [self.term(each, part_of(one, ~held), target) for each, one in pairs]
            steps = smoothing_share(terms, target, known, self.target[held], self.measurement[held])
            other.smoothing *= yield from steps
        yield Step(0.0, "solving for all textures")
        return other, other.solve_all()

    def beside(self) -> Level:
        """A copy that goes on by itself: samples are shared, projections and textures are not."""
        other = copy(self)
        other.chosen, other.textures = list(self.chosen), list(self.textures)
        return other

    def solve_all(self) -> Fit:
        """All textures of the chosen projections together."""
        terms = [self.term(each, self.keep_rows(each), self.target) for each in self.chosen]
        fit = solve(terms, self.target, refine=True)
        self.textures = list(fit.textures)
        return fit

    def get_chosen_error(self) -> float:
        residual = self.target.copy()
        for projection, texture in zip(self.chosen, self.textures, strict=True):
            residual -= predict(self.keep_rows(projection), texture)
        return self._metric(residual)

    def factors(self, shorter: tuple[HomomorphicFactors, ...]) -> HomomorphicFactors:
        return HomomorphicFactors(
            tuple(self.textures),
            tuple(self.chosen),
            self.space,
            self.settings.parametrisation,
            self.settings.reciprocal,
            shorter,
            ceiling=self.ceiling,
        )


class TermErrors:
    """The factors of each number of terms and their errors."""

    def __init__(self, data: FactorData, settings: SearchSettings, reference: Reference | None, started: float) -> None:
        self.data, self.settings, self.started = data, settings, started
        self.reference = reference or Reference(data.wi, data.wo, data.value)
        self.factors: tuple[HomomorphicFactors, ...] = ()
        self.errors: tuple[TermError, ...] = ()

    def term_error(self, factors: HomomorphicFactors, smoothing: float) -> TermError:
        rms, bands = self.reference.rms(factors)
        return TermError(
            terms=factors.terms,
            textures=factors.terms,
            rms_cosine_weighted=rms,
            rms_by_elevation_band=bands,
            metrics=metrics(factors.f(self.data.wi, self.data.wo), self.data, self.settings.epsilon),
            time_s=time.perf_counter() - self.started,
            size_bytes=factors.size_bytes,
            smoothing=smoothing,
        )

    def add(self, level: Level) -> None:
        factors = level.factors(self.factors)
        self.factors, self.errors = (*self.factors, factors), (*self.errors, self.term_error(factors, level.smoothing))

    def judge_last(self, errors: HeldOut) -> None:
        """Say what the held-out errors of the last factors are."""
        term_error = replace(
            self.errors[-1],
            held_out_rms_cosine_weighted=errors.rms_cosine_weighted,
            held_out_sq_log=errors.sq_log,
        )
        self.errors = (*self.errors[:-1], term_error)

    def factorisation(self, method: str, fit: Fit | None, evaluations: int) -> Factorisation:
        factors = self.factors[-1]
        condition = fit.condition_number if fit is not None else 0.0
        return Factorisation(
            factors,
            method,
            self.errors,
            condition_number=condition,
            evaluations=evaluations,
            projections=factors.projections,
        )


def mccool(
    data: FactorData,
    size: int = FactorSettings.size,
    reciprocal: bool = FactorSettings.reciprocal,
    *,
    smoothing: float = SMOOTHING,
    held_out: float = HELD_OUT,
    epsilon: float = EPSILON,
    reference: Reference | None = None,
) -> Steps[Factorisation]:
    """McCool's fixed projections, wi, h and wo, all textures solved together (McCool2001).

    `smoothing`, `held_out` and `epsilon` are as in `SearchSettings`.
    `reference` are random pairs of the BRDF for the cosine-weighted error; without them it is taken over the samples.
    """
    settings = SearchSettings(
        terms=3,
        size=size,
        low_size=0,
        reciprocal=reciprocal,
        epsilon=epsilon,
        smoothing=smoothing,
        held_out=held_out,
        fixed=(),
    )
    started = time.perf_counter()
    level = Level(data, LogSpace.of(data.value, epsilon), settings, size)
    term_errors = TermErrors(data, settings, reference, started)
    fit: Fit | None = None
    for projection in mccool_projections(reciprocal):
        level.chosen.append(projection)
        settled, fit = yield from level.settle()
        term_errors.add(settled)
    return term_errors.factorisation("mccool", fit, 0)
