"""How smooth textures should be, by samples that were held out.

λ of `engine.factor.least_squares` stands for what samples do not tell. Formulas are sampled as densely as one likes,
and there λ = 1e-4 is what keeps five textures from being better than two; a few hundred measured pairs need it: with
λ = 1e-6 the five textures of Cornell's cayman paint were three times as far from pairs that they had not seen. So one
measurement in five is left out, with all its copies turned about the normal, and λ falls by tens while the others
foretell these better beyond doubt.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from engine.factor.least_squares import Term, solve, with_smoothing
from engine.factor.texel_rows import Rows, predicted

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

#: λ falls by this factor, so many times at most, while each fall gains this share of the mean squared error, and that
#: gain is more than so many of its standard errors.
FALL, FALLS, GAIN, CERTAIN = 0.1, 4, 0.01, 2.0


def held_out(measurement: NDArray[np.intp], share: float, seed: int) -> Mask:
    """Which samples (N,) are left out: all of `share` of the measurements, the same for the same seed.

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
) -> float:
    """What the λ of `terms`, made for `target` (N, 3), is to be multiplied by, in [1e-4, 1].

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
            residual -= predicted(rows, texture)
        return np.asarray(np.bincount(of.reshape(-1), (residual * residual).mean(axis=1)) / copies)

    best, before = 1.0, errors(1.0)
    for fall in range(1, FALLS + 1):
        after = errors(FALL**fall)
        gained = before - after
        doubt = CERTAIN * float(gained.std()) / np.sqrt(len(gained))
        if not gained.mean() > max(GAIN * before.mean(), doubt):
            break
        best, before = FALL**fall, after
    return best
