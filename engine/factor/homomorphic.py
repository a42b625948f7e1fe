"""BRDFs as products of textures of projections of the two directions: McCool's fixed set, and Cole's search for better.

    log((f + εA)/A) = Σ_j p_j(π_j(wi, wo))          reciprocal: Σ_j p_j(π_j(wi, wo)) + p_j(π_j(wo, wi))

The search (Cole 2002, Ch. 2 and 3) is greedy: projection after projection, each by Powell's method over rotations of
four dimensions from several random starts, with the last few textures solved together for every projection tried.
What is ours, and can be switched off as in `THESIS`:

    guesses     the two disks, their sum and their difference are tried as starts too
    fixed       half, wi-dot-h and elevations compete with the projection that was found
    mccool      so does McCool's whole set, where it has as many textures
    refit       once a projection is chosen, all textures are solved together
    low_size    restarts run with small textures on a part of the samples; the best few go on with all of both
    extent      textures are filled by the two disks and not by the 4-cube around them

Every random number comes from the seed and the number of the term: a search that is resumed goes on as if it had never
stopped, and sums do not depend on the number of threads.
"""

from __future__ import annotations

import os
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.directions import Vectors
from engine.factor.data import FactorData
from engine.factor.errors import METRICS, Factorisation, Reference, TermError, metrics
from engine.factor.least_squares import Fit, Rows, Term, predicted, rows_of, solve, term
from engine.factor.log_space import EPSILON, LogSpace
from engine.factor.powell import Minimum, powell
from engine.factor.projections import (
    DIFFERENCE,
    FIRST,
    SECOND,
    SUM,
    Extent,
    FixedProjection,
    Kind,
    LinearProjection,
    Parametrisation,
    Points,
    Projection,
    linear_of_pair,
    look_ups,
    mccool_projections,
    points_of,
    texture_mask,
)
from engine.factor.quaternions import Pair, pair_of_rows, random_pair
from engine.kernels import parallel, prange
from engine.steps import Step, Steps

Floats = NDArray[np.float64]

#: Strength λ of the smoothing: it costs 1 % of the error on smooth data and fills what has no samples.
SMOOTHING = 1e-4

#: A step is yielded after so many seconds.
PACE_S = 0.05

#: Largest texture and most terms that are searched.
LARGEST_SIZE = 64
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
        return False

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


@dataclass(frozen=True)
class SearchSettings:
    """How projections are searched; see the head of this file.

    Attributes
    ----------
    terms : textures at most. size : texels a side. low_size : the same while restarts run, 0 for `size`.
    low_samples : samples while restarts run. finalists : how many of the starts go on with all.
    parametrisation, reciprocal : of the factors. extent : what textures are filled by.
    restarts : random starts per term. together : textures solved for every projection tried.
    metric : of `METRICS`, which is made small. epsilon : see `LogSpace`. smoothing : λ ≥ 0.
    guesses, fixed, mccool, refit : see above. seed : of all random numbers.
    """

    terms: int = 5
    size: int = 16
    low_size: int = 8
    low_samples: int = 9000
    finalists: int = 2
    parametrisation: Parametrisation = "in-out"
    reciprocal: bool = True
    extent: Extent = "disks"
    restarts: int = 6
    together: int = 2
    metric: str = "sq_log"
    epsilon: float = EPSILON
    smoothing: float = SMOOTHING
    guesses: bool = True
    fixed: tuple[Kind, ...] = ("half", "wi-dot-h", "elevations")
    mccool: bool = True
    refit: bool = True
    seed: int = 1

    def __post_init__(self) -> None:
        for name, low, high in (
            ("terms", 1, MOST_TERMS),
            ("size", 4, LARGEST_SIZE),
            ("restarts", 0, 1000),
            ("together", 1, MOST_TERMS),
            ("finalists", 1, 1000),
            ("low_samples", 1, 10**9),
        ):
            if not low <= getattr(self, name) <= high:
                raise ValueError(f"{name} must lie in [{low}, {high}], not {getattr(self, name)}")
        if self.low_size and not 4 <= self.low_size <= self.size:
            raise ValueError(f"the lower size must be 0 or lie in [4, {self.size}], not {self.low_size}")
        if self.metric not in METRICS:
            raise ValueError(f"{self.metric!r} is no metric; known are {', '.join(METRICS)}")
        if not self.smoothing >= 0.0:
            raise ValueError(f"the smoothing must not be negative, but is {self.smoothing}")
        if not (self.restarts or self.guesses or self.fixed):
            raise ValueError("without restarts, guesses and fixed projections there is nothing to try")


#: The thesis's settings (Sec. 4.1); it measured with textures of 16² and 24².
THESIS = SearchSettings(extent="cube", guesses=False, fixed=(), mccool=False, refit=False)


def mccool(
    data: FactorData,
    size: int = 16,
    reciprocal: bool = True,
    *,
    smoothing: float = SMOOTHING,
    epsilon: float = EPSILON,
    reference: Reference | None = None,
) -> Factorisation:
    """McCool's fixed projections, wi, h and wo, all textures solved together (McCool, Ang and Ahmad 2001).

    `reference` are random pairs of the BRDF for the cosine-weighted error; without them it is taken over the samples.
    """
    settings = SearchSettings(
        size=size, low_size=0, reciprocal=reciprocal, smoothing=smoothing, epsilon=epsilon, terms=3, fixed=()
    )
    started = time.perf_counter()
    level = _Level(data, LogSpace.of(data.value, epsilon), settings, size)
    ladder = _Ladder(data, settings, reference, started)
    fit: Fit | None = None
    for projection in mccool_projections(reciprocal):
        level.chosen.append(projection)
        fit = level.solve_all()
        ladder.add(level)
    return ladder.factorisation("mccool", fit, 0)


def search(
    data: FactorData,
    settings: SearchSettings = SearchSettings(),
    *,
    reference: Reference | None = None,
    resume: Factorisation | None = None,
) -> Steps[Factorisation]:
    """Search projections and textures for `data`; `partial` of each step is the best factorisation so far.

    A step comes every 50 ms or so; the first partial result after the first guess. Not asking for a step pauses,
    closing ends. A factorisation that is given as `resume`, complete or not, goes on to `settings.terms`.
    """
    started = time.perf_counter()
    ladder = _Ladder(data, settings, reference, started)
    work = _Search(data, settings, ladder)
    if resume is not None:
        work.resume(resume)
    return (yield from work.run())


class _Level:
    """The samples at one resolution, the projections chosen so far and their textures."""

    def __init__(self, data: FactorData, space: LogSpace, settings: SearchSettings, size: int) -> None:
        self.space, self.settings, self.size = space, settings, size
        self.points = points_of(data.wi, data.wo, settings.parametrisation)
        self.target = space.forward(data.value)
        self.value = data.value
        self.chosen: list[Projection] = []
        self.textures: list[Floats] = []
        self._rows: dict[int, tuple[Projection, Rows]] = {}
        self._base = self.target
        self._prior: list[Term] = []

    def rows(self, projection: Projection) -> Rows:
        read = look_ups(projection, self.points, self.settings.parametrisation, self.settings.reciprocal)
        return rows_of(read, self.size)

    def _kept_rows(self, projection: Projection) -> Rows:
        """Rows of a projection that is used again and again."""
        if id(projection) not in self._rows:
            self._rows[id(projection)] = projection, self.rows(projection)
        return self._rows[id(projection)][1]

    def _term(self, projection: Projection, rows: Rows, target: Floats) -> Term:
        parametrisation, reciprocal = self.settings.parametrisation, self.settings.reciprocal
        mask = texture_mask(projection, parametrisation, reciprocal, self.size)
        return term(rows, target, mask, self.settings.smoothing)

    def prepare(self) -> None:
        """Take the textures that stay as they are from the target, and set up those that are solved anew."""
        free = len(self.chosen) - min(self.settings.together - 1, len(self.chosen))
        self._base = self.target.copy()
        for projection, texture in zip(self.chosen[:free], self.textures[:free], strict=True):
            self._base -= predicted(self._kept_rows(projection), texture)
        self._prior = [self._term(each, self._kept_rows(each), self._base) for each in self.chosen[free:]]

    def error(self, projection: Projection) -> float:
        """The metric with `projection` as one more term."""
        rows = self.rows(projection)
        terms = [*self._prior, self._term(projection, rows, self._base)]
        fit = solve(terms, self._base)
        residual = self._base.copy()
        for one, texture in zip(terms, fit.textures, strict=True):
            residual -= predicted(one.rows, texture)
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
        terms = [*self._prior, self._term(projection, self.rows(projection), self._base)]
        fit = solve(terms, self._base, refine=True)
        self.chosen.append(projection)
        self.textures = [*self.textures[: len(self.chosen) - len(terms)], *fit.textures]
        return fit

    def solve_all(self) -> Fit:
        """All textures of the chosen projections together."""
        terms = [self._term(each, self._kept_rows(each), self.target) for each in self.chosen]
        fit = solve(terms, self.target, refine=True)
        self.textures = list(fit.textures)
        return fit

    def chosen_error(self) -> float:
        residual = self.target.copy()
        for projection, texture in zip(self.chosen, self.textures, strict=True):
            residual -= predicted(self._kept_rows(projection), texture)
        return self._metric(residual)

    def factors(self, shorter: tuple[HomomorphicFactors, ...]) -> HomomorphicFactors:
        return HomomorphicFactors(
            tuple(self.textures),
            tuple(self.chosen),
            self.space,
            self.settings.parametrisation,
            self.settings.reciprocal,
            shorter,
        )


class _Ladder:
    """The factors of each number of terms and their errors."""

    def __init__(self, data: FactorData, settings: SearchSettings, reference: Reference | None, started: float) -> None:
        self.data, self.settings, self.started = data, settings, started
        self.reference = reference or Reference(data.wi, data.wo, data.value)
        self.factors: tuple[HomomorphicFactors, ...] = ()
        self.errors: tuple[TermError, ...] = ()

    def rung(self, factors: HomomorphicFactors) -> TermError:
        rms, bands = self.reference.rms(factors)
        return TermError(
            terms=factors.terms,
            textures=factors.terms,
            rms_cosine_weighted=rms,
            rms_by_elevation_band=bands,
            metrics=metrics(factors.f(self.data.wi, self.data.wo), self.data, self.settings.epsilon),
            time_s=time.perf_counter() - self.started,
            size_bytes=factors.size_bytes,
        )

    def add(self, level: _Level) -> None:
        factors = level.factors(self.factors)
        self.factors, self.errors = (*self.factors, factors), (*self.errors, self.rung(factors))

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


class _Search:
    """The state of a search between two steps."""

    def __init__(self, data: FactorData, settings: SearchSettings, ladder: _Ladder) -> None:
        self.settings, self.ladder = settings, ladder
        space = LogSpace.of(data.value, settings.epsilon)
        self.full = _Level(data, space, settings, settings.size)
        self.low = self.full
        low_size = settings.low_size or settings.size
        if low_size < settings.size or settings.low_samples < len(data):
            few = np.random.default_rng(settings.seed).permutation(len(data))[: settings.low_samples]
            few.sort()
            part = FactorData(data.wi[few], data.wo[few], data.value[few])
            self.low = _Level(part, space, settings, low_size)
        self.evaluations = 0
        self.fit: Fit | None = None
        self.partial: Factorisation | None = None
        self.started_with: Projection | None = None
        self.breath = time.perf_counter()

    def resume(self, before: Factorisation) -> None:
        """Take over finished terms, and the projection of one that is not."""
        factors: HomomorphicFactors = before.factors
        if factors.parametrisation != self.settings.parametrisation or factors.reciprocal != self.settings.reciprocal:
            raise ValueError("a search goes on with the parametrisation and reciprocity that it started with")
        finished = factors
        self.partial, self.evaluations = before, before.evaluations
        self.ladder.started -= before.ladder[-1].time_s if before.ladder else 0.0
        errors = before.ladder
        if before.searching:
            self.started_with = factors.projections[-1]
            if not factors.shorter:
                return
            finished, errors = factors.shorter[-1], errors[:-1]
        self.ladder.factors, self.ladder.errors = (*finished.shorter, finished), errors
        self.full.chosen, self.full.textures = list(finished.projections), list(finished.textures)
        if self.low is not self.full:
            self.low.chosen = list(finished.projections)
            self.low.solve_all()

    def run(self) -> Steps[Factorisation]:
        terms = self.settings.terms
        while len(self.full.chosen) < terms:
            yield from self._term(len(self.full.chosen) + 1)
        if self.partial is None:
            raise ValueError("nothing was searched")
        return self.partial

    def _term(self, number: int) -> Steps[None]:
        """Find the projection of term `number`, and keep it."""
        settings, levels = self.settings, [self.full] if self.low is self.full else [self.low, self.full]
        for level in levels:
            level.prepare()
        candidates: list[tuple[float, Projection]] = []
        fixed = [FixedProjection(kind) for kind in settings.fixed]
        for each in fixed:
            if each not in self.full.chosen:
                candidates.append((self._error(self.full, each), each))
                yield from self._pause(number, 0.0)
        self._show(number, candidates)
        starts = yield from self._starts(number)
        found = yield from self._descend(self.low, starts, number, 0.0, 0.6)
        finalists = _distinct(found)[: settings.finalists]
        if finalists and self.low is not self.full:
            best = linear_of_pair(finalists[0].pair, settings.extent)
            self._show(number, [*candidates, (self._error(self.full, best), best)])
            again = [one.pair for one in finalists] + starts[: int(settings.guesses)]
            finalists = yield from self._descend(self.full, again, number, 0.6, 0.4)
        candidates.extend((one.error, linear_of_pair(one.pair, settings.extent)) for one in finalists)
        self._keep(number, min(candidates, key=lambda one: one[0])[1])
        yield Step(number / settings.terms, f"term {number} of {settings.terms}", self.partial)

    def _starts(self, number: int) -> Steps[list[Pair]]:
        """The guess that is best with all samples, where guesses are made, and random rotations."""
        settings = self.settings
        rng = np.random.default_rng((settings.seed, number))
        starts = [random_pair(rng) for _ in range(settings.restarts)]
        if self.started_with is not None and isinstance(self.started_with, LinearProjection):
            starts.insert(0, pair_of_rows(self.started_with.rows))
        self.started_with = None
        if settings.guesses:
            tried = []
            for guess in (FIRST, SECOND, SUM, DIFFERENCE):
                projection = LinearProjection(guess.rows, settings.extent)
                tried.append((self._error(self.full, projection), projection))
                yield from self._pause(number, 0.0)
            best = min(tried, key=lambda one: one[0])
            starts.insert(0, pair_of_rows(best[1].rows))
            if self.partial is None:
                self._show(number, [best])
        return starts

    def _descend(
        self, level: _Level, starts: Sequence[Pair], number: int, begin: float, share: float
    ) -> Steps[list[Minimum]]:
        """The minima from all `starts`, which go on side by side: each round, one projection of each is tried.

        On low resolution each line is looked along first; what comes from there is only polished.
        """
        scan = level is self.low
        sweeps, tolerance, step = (4, 0.02, 0.1) if scan else (2, 0.01, 0.04)
        expected = 200 if scan else 80
        searches = [powell(start, tolerance, sweeps, scan=scan, step=step) for start in starts]
        asked = {index: next(each) for index, each in enumerate(searches)}
        found: dict[int, Minimum] = {}
        rounds = 0
        with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
            while asked:
                tried = [linear_of_pair(pair, self.settings.extent) for pair in asked.values()]
                errors = list(pool.map(level.error, tried))
                self.evaluations += len(tried)
                for index, error in zip(list(asked), errors, strict=True):
                    try:
                        asked[index] = searches[index].send(error)
                    except StopIteration as finished:
                        del asked[index]
                        found[index] = finished.value
                rounds += 1
                yield from self._pause(number, begin + share * rounds / (rounds + 0.3 * expected))
        return [found[index] for index in range(len(starts))]

    def _error(self, level: _Level, projection: Projection) -> float:
        self.evaluations += 1
        return level.error(projection)

    def _pause(self, number: int, done: float) -> Steps[None]:
        """A step, if the last one is long enough ago."""
        now = time.perf_counter()
        if now - self.breath >= PACE_S:
            terms = self.settings.terms
            yield Step((number - 1 + done) / terms, f"term {number} of {terms}, {self.evaluations} tried", self.partial)
            self.breath = time.perf_counter()

    def _show(self, number: int, candidates: Sequence[tuple[float, Projection]]) -> None:
        """Make the best candidate the partial result, if it is better than what is shown."""
        if not candidates:
            return
        level = self.full
        _, projection = min(candidates, key=lambda one: one[0])
        if self.partial is not None and self.partial.projections[-1] is projection:
            return
        chosen, textures = list(level.chosen), list(level.textures)
        self.fit = level.keep(projection)
        factors = level.factors(self.ladder.factors)
        level.chosen, level.textures = chosen, textures
        rung = self.ladder.rung(factors)
        shown, metric = self.partial, self.settings.metric
        if shown is not None and shown.searching and len(shown.ladder) == number:
            before = shown.ladder[-1]
            if getattr(before.metrics, metric) <= getattr(rung.metrics, metric):
                return
        self.partial = Factorisation(
            factors,
            "search",
            (*self.ladder.errors, rung),
            condition_number=self.fit.condition_number,
            evaluations=self.evaluations,
            projections=factors.projections,
            searching=True,
        )

    def _keep(self, number: int, projection: Projection) -> None:
        """End a term with `projection`, or with McCool's set where that is as large and better."""
        settings, full = self.settings, self.full
        self.fit = full.keep(projection)
        fixed = mccool_projections(settings.reciprocal)
        if settings.mccool and number == len(fixed):
            other = _Level.__new__(_Level)
            other.__dict__.update(full.__dict__)
            other.chosen, other.textures = list(fixed), []
            fit = other.solve_all()
            self.evaluations += 1
            if other.chosen_error() < full.chosen_error():
                full.chosen, full.textures, self.fit = other.chosen, other.textures, fit
        if self.low is not full:
            if settings.refit or self.low.chosen != full.chosen[:-1]:
                self.low.chosen = list(full.chosen)
                self.low.solve_all()
            else:
                self.low.keep(projection)
        self.ladder.add(full)
        self.partial = self.ladder.factorisation("search", self.fit, self.evaluations)


def _distinct(found: Sequence[Minimum]) -> list[Minimum]:
    """Minima from the lowest error up, those left out that lie at the same height as one before."""
    kept: list[Minimum] = []
    for minimum in sorted(found, key=lambda one: one.error):
        if not any(abs(minimum.error - other.error) <= 1e-3 * other.error for other in kept):
            kept.append(minimum)
    return kept


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
