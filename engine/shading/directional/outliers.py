"""Photographs that the others contradict: of a camera or sample that moved, a wrong lamp, or another exposure.

Each photograph is predicted from the others, and its error set against the standard deviation that the process of
`engine.shading.directional.interpolation` leaves there, which is larger at the rim of a dome and where lamps are far
apart. The one of the largest ratio is an outlier where it is far above the usual ratio of the others, by themselves
alone; then it is taken out and the next is looked at, since one bad photograph spoils the predictions of all around it.

Cost: a search for a kernel for each photograph that is found, and one more; no pixel is read.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from engine.core.directions import Vectors
from engine.shading.directional.interpolation import MIN_LEFT, Kernel, best_kernel, list_left_out, precision_of

Array = NDArray[np.float64]

#: The ratio of an outlier over the median one of the others, and over that of the highest tenth:
#: all lamps of a ring may be hard to predict, and none of them is an outlier.
FAR, ABOVE_HIGH = 2.5, 1.9

#: The factor by which an outlier enlarges the mean squared error of predicting the others: without a sound photograph
#: in a gap between lamps they are predicted worse.
HARM = 1.2

#: Photographs that tell what is usual, and the share of all that may be outliers.
FEWEST, MAXIMUM = 15, 0.25


def outliers(lights: Vectors, second: Array, kernel: Kernel) -> dict[int, float]:
    """Places of outliers, the worst first, and how many times the usual ratio theirs is.

    `lights` (N, 3), and `second` (N, N) the second moments of their photographs, about which `kernel` is
    known to predict them well.
    """
    found: dict[int, float] = {}
    rest = np.arange(len(lights))
    while len(rest) > FEWEST and len(found) < int(MAXIMUM * len(lights)):
        place = int(np.argmax(_ratios(*_list_left_out(lights[rest], second[np.ix_(rest, rest)], kernel))))
        suspect, others = rest[place], np.delete(rest, place)
        of_others = lights[others], second[np.ix_(others, others)]
        kernel = best_kernel(*of_others)
        squares, precision = _list_left_out(lights[rest], second[np.ix_(rest, rest)], kernel)
        alone, precision_alone = _list_left_out(*of_others, kernel)
        usual, high = np.quantile(_ratios(alone, precision_alone), (0.5, 0.9))
        own = float(_ratios(squares, precision)[place])
        harm = float(np.delete(squares, place).sum()) > HARM * float(alone.sum())
        if not (harm and own > max(FAR * usual, ABOVE_HIGH * high)):
            break
        found[int(suspect)] = own / float(usual) if usual > 0.0 else np.inf
        rest = others
    return found


def _list_left_out(lights: Vectors, second: Array, kernel: Kernel) -> tuple[Array, Array]:
    """(N,) the mean squared error of predicting each photograph from the others, and one over the variance there."""
    apart = list_left_out(lights, kernel)
    squares = np.maximum(np.einsum("ij,ij->i", apart @ second, apart), 0.0)
    return squares, np.maximum(np.diag(precision_of(lights, kernel)), MIN_LEFT)


def _ratios(squares: Array, precision: Array) -> Array:
    """(N,) errors over the standard deviations that the process leaves."""
    return np.asarray(np.sqrt(squares * precision))
