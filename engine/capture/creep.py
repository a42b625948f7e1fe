"""What of the motions along a light arc is knocks of the camera, and what is creep that shading makes.

Relief seems to creep towards the lamp as the lamp sinks, along a smooth curve from light to light, mostly along the
lamp's azimuth. A motion is therefore taken for the sum of a jump, independent from photograph to photograph (hands,
knocks), a creep, which is a Gaussian process over the distance between lights (zero for equal lights; its size is free
along each axis), and a small error. Sizes are not chosen but averaged over, each weighted by how likely it makes what
was seen. Where the data are not clearly likelier with jumps than without, all is left alone.

Jumps are first drawn from one normal distribution: a camera that moves at each photograph. If one of them is far out
when they are drawn from Student's distribution instead, few photographs were moved, and that is used: it leaves the
others nearly alone.

A camera that moves as smoothly as the shading does cannot be told from it, and the standard deviation of the jumps says
how far.
Cost: some 0.1 s for ten photographs, growing with the cube of their number.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Matrix = NDArray[np.float64]

#: Sizes of creep that are tried (pixels of the compared pictures), the usual one, and by what power of e others differ.
_CREEPS_PX = np.array([0.05, 0.1, 0.2, 0.4, 0.8, 1.6])
_USUAL_CREEP_PX, _CREEP_SPREAD = 0.8, 1.0
#: Over what distance between lights creep changes, and how fast it may where few photographs were moved: what it could
#: explain there is not taken for a knock.
_CREEP_LENGTH, _FASTEST_CREEP = 0.6, 0.4
#: Error of a single motion that is well determined.
_NOISE_PX = 0.03
#: Sizes of jumps that are tried, and by what power of e they must be likelier than none.
_JUMPS_PX = np.array([0.0, *np.geomspace(0.02, 300.0, 30)])
_LEAST_EVIDENCE = 10.0
#: Degrees of freedom of Student's distribution, steps towards it, and a variance that is far out, in usual ones.
_FREEDOM, _STEPS, _FAR_OUT = 1.0, 8, 15.0


class _Jumps(NamedTuple):
    """Expected jumps relative to the reference and their variance, both (N, P); what each (N,) of them is squared, in
    units of the usual jump, added over P; by what power of e jumps are likelier than none."""

    expected: Matrix
    variance: Matrix
    square: Matrix
    evidence: float


def without_creep(moved: Matrix, distance: Matrix, reference: int) -> tuple[Matrix, Matrix]:
    """The part of motions (N, P) in pixels relative to the photograph `reference` that jumps from light to light.

    `distance` (N,) is how far the light has changed up to each photograph. Returned are the expected jumps relative
    to that of the reference and their standard deviation (N,), of each of the P parameters. Both are zero where nothing
    moved; jumps that are smaller than their standard deviation are taken for none.
    """
    count, parameters = moved.shape
    weight = np.ones(count)
    apart = distance[:, None] - distance
    jumps = _expected(moved, apart / _CREEP_LENGTH, reference, weight)
    if jumps.evidence < _LEAST_EVIDENCE:
        return np.zeros_like(moved), np.zeros(count)
    few = jumps
    for _ in range(_STEPS):
        weight = (_FREEDOM + few.square) / (_FREEDOM + parameters)
        few = _expected(moved, apart / _FASTEST_CREEP, reference, weight)
    chosen = few if weight.max() > _FAR_OUT else jumps
    doubt = np.sqrt(chosen.variance.mean(axis=1))
    known = (chosen.expected**2).mean() > (doubt**2).mean()
    return chosen.expected * known, doubt


def _expected(moved: Matrix, apart: Matrix, reference: int, weight: Matrix) -> _Jumps:
    """Jumps of the variances `weight` (N,) times one that is averaged over, as the size of creep is.

    `apart` (N, N) is the distance between lights in lengths over which creep changes.

    Arrays have the axes (sizes of jumps, sizes of creep, photographs, parameters) as far as they need them.
    """
    count = len(moved)
    to_reference = np.delete(np.eye(count), reference, axis=0)
    to_reference[:, reference] -= 1.0
    seen = np.delete(moved, reference, axis=0)
    smooth, noise = (to_reference @ one @ to_reference.T for one in (np.exp(-0.5 * apart**2), np.eye(count)))
    jump = to_reference * weight
    size = (_JUMPS_PX**2)[:, None, None, None]
    covariance = size * (jump @ to_reference.T) + (_CREEPS_PX**2)[:, None, None] * smooth + _NOISE_PX**2 * noise
    both = np.hstack([seen, jump])
    solved = np.linalg.solve(covariance, np.broadcast_to(both, (*covariance.shape[:2], *both.shape)))
    explained, shrunk = np.split(solved, [seen.shape[1]], axis=-1)
    usual = -0.5 * (np.log(_CREEPS_PX / _USUAL_CREEP_PX) / _CREEP_SPREAD) ** 2
    likely = -0.5 * ((explained * seen).sum(axis=2) + np.linalg.slogdet(covariance)[1][..., None]) + usual[:, None]
    by_size = np.logaddexp.reduce(likely, axis=1).sum(axis=1)
    share = (_shares(by_size[1:])[:, None, None] * _shares(likely[1:], axis=1))[:, :, None]
    size, explained, shrunk = size[1:], explained[1:], shrunk[1:]
    mean = size * (jump.T @ explained)
    spread = size * np.diag(weight) - size**2 * (jump.T @ shrunk)
    own = np.diagonal(spread, axis1=2, axis2=3)[..., None]
    relative = mean - mean[:, :, reference, None]
    doubt = own - 2.0 * spread[..., reference, None] + own[:, :, reference, None]
    expected = (share * relative).sum(axis=(0, 1))
    variance = (share * (doubt + relative**2)).sum(axis=(0, 1)) - expected**2
    square = (share * (mean**2 + own) / size).sum(axis=(0, 1, 3))
    return _Jumps(expected, np.maximum(variance, 0.0), square, float(by_size[1:].max() - by_size[0]))


def _shares(likely: Matrix, axis: int = 0) -> Matrix:
    """Probabilities from their logarithms up to a constant along `axis`."""
    raised = np.exp(likely - likely.max(axis=axis, keepdims=True))
    shares: Matrix = raised / raised.sum(axis=axis, keepdims=True)
    return shares
