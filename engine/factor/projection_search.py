"""The search for projections whose textures describe a BRDF best (Cole2002 Ch. 2 and 3).

It is greedy: projection after projection, each by Powell's method over rotations of four dimensions from several random
starts, with the last few textures solved together for every projection tried. What is ours, and can be switched off as
in `THESIS`:

    guesses     the two disks, their sum and their difference are tried as starts too
    fixed       projections that are not linear compete with the one that was found
    mccool      so does McCool's whole set, where it has as many textures
    refit       once a projection is chosen, all textures are solved together
    held_out    textures that are kept are as smooth as samples that were left out ask for (`engine.factor.textures`)
    low_size    restarts run with small textures on a part of the samples; the best few go on with all of both
    extent      textures are filled by the two disks and not by the 4-cube around them

All starts descend side by side, one projection of each per round and one thread per projection. Every random number
comes from the seed and the number of the term: a search that is resumed goes on as if it had never stopped, and no sum
depends on the number of threads.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from engine.core.budget import thread_count
from engine.core.errors import UsageError
from engine.core.one_thread import one_thread
from engine.core.steps import Result, Step, Steps
from engine.factor.data import FactorData
from engine.factor.errors import Factorisation, Reference
from engine.factor.homomorphic import HomomorphicFactors, LogSpace
from engine.factor.projections import (
    DIFFERENCE,
    FIRST,
    SECOND,
    SUM,
    FixedProjection,
    LinearProjection,
    Projection,
    linear_of_pair,
    mccool_projections,
)
from engine.factor.solvers.least_squares import Fit
from engine.factor.solvers.powell import Minimum, powell
from engine.factor.solvers.quaternions import Pair, pair_of_rows, random_pair
from engine.factor.textures import DEFAULT, Level, SearchSettings, TermErrors

#: A step is yielded after so many seconds.
PACE_S = 0.05

#: After so many rounds of the restarts the best of them is shown. Rounds, not seconds: results must not depend on time.
SHOWN_ROUNDS = 100


def search(
    data: FactorData,
    settings: SearchSettings = DEFAULT,
    *,
    reference: Reference | None = None,
    resume: Factorisation | None = None,
) -> Steps[Factorisation]:
    """Search projections and textures for `data`; `partial` of each step is the best factorisation so far.

    A step comes every 50 ms or so; the first partial result after the first guess. Not asking for a step pauses,
    closing ends. A factorisation that is given as `resume`, complete or not, goes on to `settings.terms`.
    """
    started = time.perf_counter()
    term_errors = TermErrors(data, settings, reference, started)
    work = _Search(data, settings, term_errors)
    if resume is not None:
        work.resume(resume)
    return (yield from work.run())


class _Search:
    """The state of a search between two steps."""

    def __init__(self, data: FactorData, settings: SearchSettings, term_errors: TermErrors) -> None:
        self.settings, self.term_errors = settings, term_errors
        space = LogSpace.of(data.value, settings.epsilon)
        self.full = Level(data, space, settings, settings.size)
        self.low = self.full
        low_size = settings.low_size or settings.size
        if low_size < settings.size or settings.low_samples < len(data):
            few = np.random.default_rng(settings.seed).permutation(len(data))[: settings.low_samples]
            few.sort()
            self.low = Level(data.part(few), space, settings, low_size)
        self.evaluations = 0
        self.smoothing = settings.smoothing
        self.fit: Fit | None = None
        self.partial: Factorisation | None = None
        self.started_with: Projection | None = None
        self.breath = time.perf_counter()

    def resume(self, before: Factorisation) -> None:
        """Take over finished terms, and the projection of one that is not."""
        factors = before.factors
        assert isinstance(factors, HomomorphicFactors)
        if factors.parametrisation != self.settings.parametrisation or factors.reciprocal != self.settings.reciprocal:
            raise UsageError("a search goes on with the parametrisation and reciprocity that it started with")
        if len(factors.textures[0]) != self.settings.size or factors.space.epsilon != self.settings.epsilon:
            raise UsageError(
                "a search goes on with the size and epsilon that it started with, "
                f"{len(factors.textures[0])} and {factors.space.epsilon:g}"
            )
        finished = factors
        self.partial, self.evaluations = before, before.evaluations
        self.term_errors.started -= before.term_errors[-1].time_s if before.term_errors else 0.0
        errors = before.term_errors
        if before.searching:
            self.started_with = factors.projections[-1]
            if not factors.shorter:
                return
            finished, errors = factors.shorter[-1], errors[:-1]
        self.term_errors.factors, self.term_errors.errors = (*finished.shorter, finished), errors
        self.full.chosen, self.full.textures = list(finished.projections), list(finished.textures)
        if self.settings.refit:
            self.full.solve_all()
        if self.low is not self.full:
            self.low.chosen = list(finished.projections)
            self.low.solve_all()

    def run(self) -> Steps[Factorisation]:
        terms = self.settings.terms
        with one_thread():  # once for all solutions, each of which would look for the libraries anew
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
        if starts and self.partial is None:
            self._show(number, [(0.0, linear_of_pair(starts[0], settings.extent))])
        found = yield from self._descend(self.low, starts, number, 0.0, 0.6)
        finalists = _distinct(found)[: settings.finalists]
        if finalists and self.low is not self.full:
            best = linear_of_pair(finalists[0].pair, settings.extent)
            self._show(number, [*candidates, (self._error(self.full, best), best)])
            again = [one.pair for one in finalists] + starts[: int(settings.guesses)]
            finalists = yield from self._descend(self.full, again, number, 0.6, 0.4)
        candidates.extend((one.error, linear_of_pair(one.pair, settings.extent)) for one in finalists)
        yield from self._keep(number, min(candidates, key=lambda one: one[0])[1])
        yield from self._step(number / settings.terms, f"term {number} of {settings.terms}")

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
        self, level: Level, starts: Sequence[Pair], number: int, begin: float, share: float
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
        rounds, lowest, best = 0, float("inf"), None
        pool = ThreadPoolExecutor(thread_count())
        try:
            while asked:
                tried = [linear_of_pair(pair, self.settings.extent) for pair in asked.values()]
                every = pool.map if len(tried) > 1 else map  # another thread would cost more than it saves
                errors = list(every(level.error, tried))
                self.evaluations += len(tried)
                for index, error, projection in zip(list(asked), errors, tried, strict=True):
                    if error < lowest:
                        lowest, best = error, projection
                    try:
                        asked[index] = searches[index].send(error)
                    except StopIteration as finished:
                        del asked[index]
                        found[index] = finished.value
                rounds += 1
                if scan and best is not None and rounds % SHOWN_ROUNDS == 0:
                    self._show(number, [(lowest, best)])
                yield from self._pause(number, begin + share * rounds / (rounds + 0.3 * expected))
        finally:
            # who cancels does not wait for errors that nobody wants
            pool.shutdown(wait=False, cancel_futures=True)
        return [found[index] for index in range(len(starts))]

    def _error(self, level: Level, projection: Projection) -> float:
        self.evaluations += 1
        return level.error(projection)

    def _pause(self, number: int, done: float) -> Steps[None]:
        """A step, if the last one is long enough ago."""
        if time.perf_counter() - self.breath >= PACE_S:
            terms = self.settings.terms
            yield from self._step((number - 1 + done) / terms, f"term {number} of {terms}, {self.evaluations} tried")

    def _paused(self, steps: Steps[Result], number: int) -> Steps[Result]:
        """The result of `steps`, at each of which a step of the search may be due."""
        while True:
            try:
                next(steps)
            except StopIteration as finished:
                return finished.value
            yield from self._pause(number, 1.0)

    def _step(self, done: float, note: str) -> Steps[None]:
        """A step; the time until the next one is asked for is not the search's."""
        offered = time.perf_counter()
        yield Step(done, note, self.partial)
        self.breath = time.perf_counter()
        self.term_errors.started += self.breath - offered

    def _show(self, number: int, candidates: Sequence[tuple[float, Projection]]) -> None:
        """Make the best candidate the partial result, if it is better than what is shown."""
        if not candidates:
            return
        level = self.full
        _, projection = min(candidates, key=lambda one: one[0])
        if self.partial is not None and self.partial.projections[-1] is projection:
            return
        trial = level.beside()
        trial.smoothing = self.smoothing
        self.fit = trial.keep(projection)
        factors = trial.factors(self.term_errors.factors)
        level.forget()
        term_error = self.term_errors.term_error(factors, trial.smoothing)
        shown, metric = self.partial, self.settings.metric
        if shown is not None and shown.searching and len(shown.term_errors) == number:
            before = shown.term_errors[-1]
            if getattr(before.metrics, metric) <= getattr(term_error.metrics, metric):
                return
        self.partial = Factorisation(
            factors,
            "search",
            (*self.term_errors.errors, term_error),
            condition_number=self.fit.condition_number,
            evaluations=self.evaluations,
            projections=factors.projections,
            searching=True,
        )

    def _keep(self, number: int, projection: Projection) -> Steps[None]:
        """End a term with `projection`, or with McCool's set where that is as large and better."""
        settings, full = self.settings, self.full
        self.fit = full.keep(projection)
        best = full
        if settings.refit:
            best, self.fit = yield from self._paused(full.settle(), number)
        fixed = mccool_projections(settings.reciprocal)
        if settings.mccool and number == len(fixed):
            other = full.beside()
            other.chosen = list(fixed)
            other.solve_all()
            settled, fit = yield from self._paused(other.settle(), number)
            self.evaluations += 1
            if settled.get_chosen_error() < best.get_chosen_error():
                full.chosen, full.textures = other.chosen, other.textures
                best, self.fit = settled, fit
        self.smoothing = best.smoothing
        if self.low is not full:
            if settings.refit or self.low.chosen != full.chosen[:-1]:
                self.low.chosen = list(full.chosen)
                self.low.solve_all()
            else:
                self.low.keep(projection)
        full.forget()
        self.term_errors.add(best)
        self.partial = self.term_errors.factorisation("search", self.fit, self.evaluations)


def _distinct(found: Sequence[Minimum]) -> list[Minimum]:
    """Minima from the lowest error up, those left out that lie at the same height as one before."""
    kept: list[Minimum] = []
    for minimum in sorted(found, key=lambda one: one.error):
        if not any(abs(minimum.error - other.error) <= 1e-3 * other.error for other in kept):
            kept.append(minimum)
    return kept
