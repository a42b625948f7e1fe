"""The fall-off of the diffuse part of each kind of texels, which need not be Lambert's.

It is the one of three numbers (`engine.texel.kernel`) that leaves least unexplained, found by a pattern search
(Hooke1961) from a few starts. Kinds share one at first, since few lamps tell less of one kind than of all, and have one
of their own where it explains them far better. Lambert's stays where it explains nearly as much: of generated
Lambertian reliefs with shadows others leave 0.98 of it and more, and of surfaces that are not Lambertian 0.87 and less.
It also stays where the fall-off does not predict photographs that were left out of the fit: on twelve photographs of a
sphere whose lamps are a few degrees off, one of numbers at the end of their range explained more and predicted less.
Cost: 16 to 80 fits of a sample, and some 15 of a quarter of it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import product

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Bools = NDArray[np.bool_]

#: Where the search starts, and steps of the three numbers, first of all starts, then of the best two.
STARTS = ((0.0, 0.0, 0.0), (0.4, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 0.4))
STEPS = ((0.4, 1.0, 0.4), (0.2, 1.0, 0.2), (0.1, 0.5, 0.1), (0.05, 0.25, 0.05))

#: Least and largest of each number, rounds of a step, and what a round leaves that is worth another, over what was.
BOUNDS, ROUNDS, WORTH = ((-0.3, 2.0), (-2.0, 1.0), (0.0, 0.9)), 3, 0.998

#: Digits after the point in which fall-offs differ: steps back and forth leave less than these.
DECIMALS = 9

#: Numbers from which on a fall-off is not of a surface alone; none or all of a Fresnel term and no roughness are usual.
EXTREME = (-0.3, -2.0, -1.0), (2.0, 2.0, 0.9)

#: What a fall-off leaves, over Lambert's, where it counts; that of a kind alone over that of all; and what another may
#: leave over the best that the photographs do not tell from it; and steps to such others beside it.
BETTER, OWN_BETTER, ALIKE, NEAR = 0.95, 0.85, 1.08, (0.1, 0.5, 0.1)


def find_falls(
    count: int,
    unexplained: Callable[[Array], Array],
    unpredicted: Callable[[Array], Array],
    roughly: Callable[[Array], Array] | None = None,
) -> tuple[Array | None, list[tuple[Array, Bools]]]:
    """(K, 3) the fall-off of each of `count` kinds, None where all are Lambert's; and others that explain some as well.

    `unexplained` tells (K,) what fall-offs (K, 3) leave, `unpredicted` what they leave of photographs that were not
    part of the fit, and `roughly` what they leave of fewer texels, by which starts are compared. The others come with
    the kinds (K,) that they are of.
    """
    unexplained, roughly = _remember(unexplained), _remember(roughly or unexplained)
    together, lambert = np.zeros(count, np.int64), np.zeros((count, 3))
    starts = [np.tile(start, (count, 1)) for start in STARTS]
    rough = [_search(start, roughly(start), together, roughly, STEPS[:1]) for start in starts]
    rough.sort(key=lambda each: float(each[1].sum()))
    tried = [_search(falls, unexplained(falls), together, unexplained, STEPS[1:]) for falls, _ in rough[:2]]
    tried += [(falls, unexplained(falls)) for falls, _ in rough[2:]]
    tried.append((lambert, unexplained(lambert)))
    falls, least = min(tried, key=lambda each: float(each[1].sum()))
    if least.sum() > BETTER * tried[-1][1].sum():
        falls, least = tried[-1]
    own, left = _search(falls, least, np.arange(count), unexplained, STEPS[1:])
    better = left < OWN_BETTER * least
    falls, least = np.where(better[:, None], own, falls), np.where(better, left, least)
    if not falls.any():
        return None, []
    ours, theirs = unpredicted(falls), unpredicted(lambert)
    predicts = (ours < theirs) & (ours.sum() < theirs.sum())
    refused = falls, falls.any(axis=1) & ~predicts
    falls = np.where(predicts[:, None], falls, 0.0)
    if not falls.any():
        return None, [refused]
    beside = [_step(falls, number, side * NEAR[number]) for number, side in product(range(3), (1.0, -1.0))]
    tried += [(other, unexplained(other)) for other in beside]
    others = [(other, left < ALIKE * least) for other, left in tried]
    # a fall-off at the end of what surfaces have may stand for light that the model lacks, and so may Lambert's
    is_extreme = np.asarray(((falls <= EXTREME[0]) | (falls >= EXTREME[1])).any(axis=1))
    return falls, [*others, refused, (lambert, is_extreme)]


def _search(
    falls: Array,
    least: Array,
    groups: NDArray[np.int64],
    unexplained: Callable[[Array], Array],
    stages: Sequence[tuple[float, ...]],
) -> tuple[Array, Array]:
    """Better fall-offs and what they leave; kinds of one of the `groups` (K,) change together."""
    members = groups == np.unique(groups)[:, None]
    for steps in stages:
        for _ in range(ROUNDS):
            before = least
            for number, side in product(range(3), (1.0, -1.0)):
                tried = _step(falls, number, side * steps[number])
                if (tried == falls).all():
                    continue
                left = unexplained(tried)
                better = members.T @ (members @ left < members @ least)
                falls, least = np.where(better[:, None], tried, falls), np.where(better, left, least)
            if least.sum() > WORTH * before.sum():
                break
    return falls, least


def _remember(unexplained: Callable[[Array], Array]) -> Callable[[Array], Array]:
    """The same function, which is evaluated once for each fall-off of each kind: searches often come back to one."""
    known: dict[tuple[int, tuple[float, ...]], float] = {}

    def look_up(falls: Array) -> Array:
        keys = [(kind, tuple(np.round(fall, DECIMALS).tolist())) for kind, fall in enumerate(falls)]
        if any(key not in known for key in keys):
            known.update(zip(keys, unexplained(falls).tolist(), strict=True))
        return np.array([known[key] for key in keys])

    return look_up


def _step(falls: Array, number: int, step: float) -> Array:
    """The fall-offs with one number changed within its bounds."""
    changed = falls.copy()
    changed[:, number] = np.clip(changed[:, number] + step, *BOUNDS[number])
    return changed
