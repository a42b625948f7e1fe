"""Powell's direction-set search over rotations of four dimensions (Cole2002 Sec. 3.1; Press1992 Sec. 10.5).

A line through R is R(t) = D^t R. The six directions to begin with turn one side of the pair by a quarter, so that
D² = −1, which turns the texture by half and leaves the error as it was: their lines have the period 2 and are searched
in [−1, 1]. (The thesis says 4π, which is for angles, and counts −1 as different.) A direction found on the way turns
both sides at different rates and has no period: it is searched up to ±2π over the faster one's angle.

The first sweep looks at a few points of each line before it descends, because a line can have several minima; later
ones start from where they are. Every new point must be lower than all before it: the error never rises, and NaN counts
as infinite.

A search is a generator that yields rotations and is sent their errors: whoever runs it may stop between two, and run
several at once and evaluate what they ask for side by side.
"""

from __future__ import annotations

from collections.abc import Generator
from typing import NamedTuple, TypeVar

import numpy as np

from engine.factor.solvers.quaternions import BASIS, Pair, canonical, compose, inverse, polar, raise_error, tangent

Result = TypeVar("Result")

#: Places along a line that errors are asked for, and rotations.
Places = Generator[float, float, Result]
Asked = Generator[Pair, float, Result]

#: Half the period of the six first directions, and how many points of a line are looked at first.
HALF_PERIOD = 1.0
SCAN = 8

#: Below this a minimum's place is noise, relative to itself: the root of float64's precision.
FINEST = 1.5e-8

#: A move smaller than this is none, and directions with a smaller determinant no longer span the space.
NO_MOVE = 1e-9
DEPENDENT = 1e-3

_GOLDEN = 0.5 * (3.0 - np.sqrt(5.0))
_CAP = 100


class Minimum(NamedTuple):
    """The rotation found, its error, and how many errors were asked for."""

    pair: Pair
    error: float
    evaluations: int


class Lowest(NamedTuple):
    """A place on a line and its error."""

    t: float
    error: float


def period_limit(direction: Pair) -> float:
    """Length of the search along a direction: 1 for the first six, else a whole turn of its faster side."""
    if any(direction is basis for basis in BASIS):
        return HALF_PERIOD
    angle = max(polar(direction.s).angle, polar(direction.t).angle)
    return 2.0 * np.pi / angle if angle > 0.0 else 0.0


def line_minimum(start: float, limit: float, tolerance: float, step: float | None = None) -> Places[Lowest]:
    """The lowest place in [−limit, limit], where the error `start` at 0 is known; 0 where nothing is lower.

    Without `step`, points over the whole range are looked at first; with it, it descends from 0 in growing steps.
    Places are told apart to `tolerance`, never finer than `FINEST` of their size, with at most 100 further errors.
    """
    if not limit > 0.0:
        return Lowest(0.0, start)
    if step is None:
        known = [Lowest(0.0, start)]
        for t in _scan(limit):
            known.append(Lowest(t, _finite((yield t))))
        known.sort()
        best = min(range(len(known)), key=lambda k: (known[k].error, abs(known[k].t)))
        low, high = known[max(best - 1, 0)].t, known[min(best + 1, len(known) - 1)].t
        middle = known[best]
    else:
        low, middle, high = yield from _bracket(start, min(step, limit), limit)
    return (yield from _golden(low, middle, high, tolerance))


def _scan(limit: float) -> list[float]:
    """Points of a period, evenly; of an endless line, ever closer to 0, for its own scale is not known."""
    if limit == HALF_PERIOD:
        return [limit * (2.0 * k / SCAN - 1.0) for k in range(SCAN) if 2 * k != SCAN] + [limit]
    return [sign * limit / 2.0**k for k in range(SCAN // 2 + 2) for sign in (-1.0, 1.0)]


def _bracket(start: float, step: float, limit: float) -> Places[tuple[float, Lowest, float]]:
    """(low, middle, high) with the middle not above either end, unless an end is the limit."""
    middle = Lowest(0.0, start)
    ends = [-step, step]
    for side in (1, 0):
        sign = 1.0 if side else -1.0
        reach = step
        ahead = Lowest(sign * reach, _finite((yield sign * reach)))
        if ahead.error >= middle.error:
            continue
        while ahead.error < middle.error:
            behind, middle = middle.t, ahead
            if reach >= limit:
                break
            reach = min(reach + 1.6 * step, limit)
            step *= 1.6
            ahead = Lowest(sign * reach, _finite((yield sign * reach)))
        ends = [behind, ahead.t] if side else [ahead.t, behind]
        break
    return min(ends), middle, max(ends)


def _golden(low: float, middle: Lowest, high: float, tolerance: float) -> Places[Lowest]:
    for _ in range(_CAP):
        if high - low <= 2.0 * max(tolerance, FINEST * abs(middle.t), FINEST):
            break
        upper = high - middle.t > middle.t - low
        t = middle.t + _GOLDEN * (high - middle.t) if upper else middle.t - _GOLDEN * (middle.t - low)
        tried = Lowest(t, _finite((yield t)))
        if tried.error < middle.error:
            low, high = (middle.t, high) if upper else (low, middle.t)
            middle = tried
        elif upper:
            high = t
        else:
            low = t
    return middle


def powell(
    start: Pair,
    tolerance: float = 0.02,
    sweeps: int = 4,
    gain: float = 1e-3,
    scan: bool = True,
    step: float = 0.1,
) -> Asked[Minimum]:
    """A minimum near `start` of the error that is sent for each rotation.

    Parameters
    ----------
    tolerance : of t along a line; 1 is a quarter turn. sweeps : at most, through all six directions.
    gain : a sweep that lowers the error by a smaller share ends the search.
    scan : look along whole lines in the first sweep. step : the first step of a descent.
    """
    directions = list(BASIS)
    current, lowest, evaluations = start, _finite((yield start)), 1
    for sweep in range(sweeps):
        origin, before = current, lowest
        drops = np.zeros(len(directions))
        for number, direction in enumerate(directions):
            found, used = yield from _along(direction, current, lowest, tolerance, None if scan and not sweep else step)
            evaluations += used
            if found.error < lowest:
                drops[number] = lowest - found.error
                current, lowest = compose(raise_error(direction, found.t), current), found.error
        if not before - lowest > gain * before:
            break
        moved = canonical(compose(current, inverse(origin)))
        if max(polar(moved.s).angle, polar(moved.t).angle) <= NO_MOVE:
            continue
        found, used = yield from _along(moved, current, lowest, tolerance, 0.5)
        evaluations += used
        if found.error < lowest:
            current, lowest = compose(raise_error(moved, found.t), current), found.error
            directions = replace(directions, int(np.argmax(drops)), moved)
    return Minimum(canonical(current), lowest, evaluations)


def replace(directions: list[Pair], number: int, moved: Pair) -> list[Pair]:
    """The directions with `moved` last and number `number` left out; the first six where these would not span."""
    kept = [direction for k, direction in enumerate(directions) if k != number] + [moved]
    spanned = abs(np.linalg.det(np.stack([tangent(direction) for direction in kept])))
    return kept if spanned > DEPENDENT else list(BASIS)


def _along(
    direction: Pair, current: Pair, lowest: float, tolerance: float, step: float | None
) -> Asked[tuple[Lowest, int]]:
    """The lowest place of D^t R on the line, and how many errors were asked for."""
    line = line_minimum(lowest, period_limit(direction), tolerance, step)
    used = 0
    try:
        t = next(line)
        while True:
            used += 1
            t = line.send((yield compose(raise_error(direction, t), current)))
    except StopIteration as finished:
        return finished.value, used


def _finite(value: float) -> float:
    return value if value == value else float("inf")
