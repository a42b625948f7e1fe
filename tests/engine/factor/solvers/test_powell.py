"""The direction-set search: lines that are hard, that it never rises, and that it finds what is there."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import numpy as np
import pytest

from engine.factor.homomorphic import LogSpace
from engine.factor.projections import linear, linear_of_pair
from engine.factor.solvers.powell import (
    DEPENDENT,
    HALF_PERIOD,
    Asked,
    Lowest,
    Minimum,
    line_minimum,
    period_limit,
    powell,
    replace,
)
from engine.factor.solvers.quaternions import (
    BASIS,
    IDENTITY,
    Pair,
    canonical,
    compose,
    inverse,
    matrix,
    polar,
    raise_error,
    random_pair,
    tangent,
)
from engine.factor.textures import Level, SearchSettings
from tests.engine.factor.factored import blue_paint

Result = TypeVar("Result")


def minimise(asked: Asked[Result], error: Callable[[Pair], float]) -> Result:
    """Run a search to its end on one function."""
    try:
        pair = next(asked)
        while True:
            pair = asked.send(error(pair))
    except StopIteration as finished:
        result: Result = finished.value
        return result


def along(
    g: Callable[[float], float], limit: float = HALF_PERIOD, tolerance: float = 1e-3, step: float | None = None
) -> tuple[Lowest, list[float]]:
    """The lowest place of g and where g was asked."""
    asked: list[float] = []

    def value(t: float) -> float:
        asked.append(t)
        return g(t)

    return minimise(line_minimum(g(0.0), limit, tolerance, step), value), asked  # type: ignore[arg-type]


def bowl(goal: Pair) -> Callable[[Pair], float]:
    """A smooth function of rotations that does not tell ±R apart, 0 at `goal`."""
    wanted = matrix(goal)[:, :2]

    def error(pair: Pair) -> float:
        return 2.0 - float(np.sum((matrix(pair)[:, :2].T @ wanted) ** 2))

    return error


@pytest.mark.parametrize("step", [None, 0.1])
def test_Q9_a_constant_stays_at_the_start(step: float | None) -> None:
    found, asked = along(lambda t: 3.0, step=step)
    assert found == Lowest(0.0, 3.0)
    assert len(asked) <= 112


@pytest.mark.parametrize("reciprocal", [False, True])
def test_X14_Q10_the_first_six_lines_have_the_period_2(reciprocal: bool) -> None:
    data = blue_paint(600)
    settings = SearchSettings(size=6, low_size=0, reciprocal=reciprocal, smoothing=1e-3)
    level = Level(data, LogSpace.of(data.value), settings, 6)
    start = random_pair(np.random.default_rng(0))
    for direction in BASIS:
        assert period_limit(direction) == HALF_PERIOD
        for t in (0.13, -0.71):
            here, there = (
                level.error(linear_of_pair(compose(raise_error(direction, place), start))) for place in (t, t + 2.0)
            )
            assert abs(here - there) <= 1e-10
    _, asked = along(lambda t: np.cos(3.0 * t))
    assert max(map(abs, asked)) <= HALF_PERIOD


def test_X14_Q10_other_lines_are_searched_over_a_turn_of_the_faster_side() -> None:
    rng = np.random.default_rng(1)
    moved = canonical(compose(raise_error(BASIS[0], 0.1), raise_error(BASIS[4], 0.37)))
    angles = polar(moved.s).angle, polar(moved.t).angle
    assert period_limit(moved) == 2.0 * np.pi / max(angles)
    limit = period_limit(moved)
    _, asked = along(lambda t: float(rng.normal()), limit)
    assert max(map(abs, asked)) <= limit
    turned = matrix(raise_error(moved, limit))
    assert min(np.abs(turned - np.eye(4)).max(), np.abs(turned + np.eye(4)).max()) > 0.1


def test_Q11_a_narrow_valley_beyond_a_hill_is_found() -> None:
    def g(t: float) -> float:
        return 1.0 + 0.3 * t - 2.0 * np.exp(-(((t - 0.62) / 0.12) ** 2))

    found, asked = along(g)
    fine = np.linspace(-1.0, 1.0, 200_001)
    assert abs(found.t - fine[np.argmin([g(t) for t in fine])]) <= 2e-3
    assert len(asked) < 40


def test_Q11_a_descent_goes_on_to_the_limit_of_a_monotone_line() -> None:
    found, asked = along(lambda t: -t, step=0.05)
    assert found.t == pytest.approx(1.0, abs=2e-3)
    assert len(asked) < 40


def test_Q12_what_is_not_a_number_counts_as_infinite() -> None:
    found, _ = along(lambda t: float("nan") if t > 0.2 else (t - 0.15) ** 2)
    assert found.t == pytest.approx(0.15, abs=2e-3)
    found, _ = along(lambda t: 1.0 if t == 0.0 else float("nan"))
    assert found == Lowest(0.0, 1.0)
    goal = random_pair(np.random.default_rng(2))
    rng = np.random.default_rng(3)
    minimum = minimise(powell(IDENTITY), lambda pair: np.nan if rng.random() < 0.2 else bowl(goal)(pair))
    assert np.isfinite(minimum.error)
    assert np.isfinite(minimise(powell(IDENTITY, sweeps=1), lambda pair: float("nan")).pair.s).all()


def test_Q13_a_tolerance_below_the_root_of_the_precision_does_not_loop() -> None:
    found, asked = along(lambda t: 1.0 + (t - 0.3) ** 2, tolerance=1e-12)
    assert len(asked) <= 112
    assert found.t == pytest.approx(0.3, abs=1e-6)


def test_Q14_the_error_never_rises() -> None:
    rng = np.random.default_rng(4)
    for _ in range(5):
        goal, start = random_pair(rng), random_pair(rng)
        rough = bowl(goal)
        seen: list[float] = []

        def error(pair: Pair, rough: Callable[[Pair], float] = rough, seen: list[float] = seen) -> float:
            seen.append(rough(pair) + 0.05 * np.sin(40.0 * pair.s[0]))
            return seen[-1]

        sweeps: list[Minimum] = [minimise(powell(start, sweeps=count), error) for count in (1, 2, 3)]
        errors = [seen[0], *(each.error for each in sweeps)]
        assert errors == sorted(errors, reverse=True)
        assert sweeps[-1].error == min(seen)
        assert sweeps[-1].evaluations == len(seen) - sum(each.evaluations for each in sweeps[:-1])


def test_a_minimum_is_found_from_anywhere() -> None:
    rng = np.random.default_rng(5)
    for _ in range(10):
        goal = random_pair(rng)
        best = min(minimise(powell(random_pair(rng)), bowl(goal)).error for _ in range(3))
        assert best < 2e-3


def test_Q7_directions_that_no_longer_span_are_given_up() -> None:
    assert replace(list(BASIS), 2, BASIS[0]) == list(BASIS)
    nearly = canonical(compose(raise_error(BASIS[2], 1e-5), BASIS[0]))
    assert replace(list(BASIS), 2, nearly) == list(BASIS)
    other = canonical(compose(raise_error(BASIS[2], 0.5), BASIS[0]))
    kept = replace(list(BASIS), 1, other)
    assert kept[-1] is other
    assert abs(np.linalg.det(np.stack([tangent(each) for each in kept]))) > DEPENDENT


def test_Q8_no_move_is_no_direction() -> None:
    """From a minimum a sweep goes nowhere: it ends after one, and R R⁻¹ is the identity, whose line has no length."""
    goal = random_pair(np.random.default_rng(6))
    still = compose(goal, inverse(goal))
    assert max(polar(canonical(still).s).angle, polar(canonical(still).t).angle) < 1e-7
    assert period_limit(IDENTITY) == 0.0
    assert along(lambda t: t, limit=period_limit(IDENTITY)) == (Lowest(0.0, 0.0), [])
    minimum = minimise(powell(goal), bowl(goal))
    np.testing.assert_allclose(np.abs(matrix(minimum.pair)), np.abs(matrix(goal)), atol=1e-7)
    assert minimum.evaluations <= 1 + 6 * 112


@pytest.mark.parametrize("reciprocal", [False, True])
def test_Q15_a_quarter_turn_of_the_rows_turns_the_texture(reciprocal: bool) -> None:
    data = blue_paint(600)
    settings = SearchSettings(size=6, low_size=0, reciprocal=reciprocal)
    level = Level(data, LogSpace.of(data.value), settings, 6)
    rows = matrix(random_pair(np.random.default_rng(7)))[:, :2].T
    first, turned = linear(rows), linear([-rows[1], rows[0]])
    assert abs(level.error(first) - level.error(turned)) <= 1e-10
    textures = []
    for projection in (first, turned):
        level.chosen = [projection]
        textures.append(level.solve_all().textures[0])
    # what was at (u, v) is now at (−v, u)
    np.testing.assert_allclose(textures[1], np.rot90(textures[0], -1), atol=1e-7)
