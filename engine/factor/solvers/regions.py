"""Regions of pairs of directions, by which samples are held out, and the pairs that lie far from every sample.

A sample that is left out beside others of the same light and viewer is foretold by them, whatever the factors do in
between. So the samples are left out by regions: cells around seeds of which each is the measurement farthest from all
seeds before it. Regions hold whole measurements, with all that turning about the normal, mirroring and exchange of
light and viewer make of them: distance is the least over all of these,

    |wi − wi'|² + |wo − wo'|² = 4 − 2 (zi zi' + zo zo') − 2 |ā a' + b̄ b'|,      a, b = x + i y of wi and wo,

where the modulus is the maximum over turns. Neighbouring seeds go to different parts, so that each part leaves out
regions all over the sphere, and every sample is left out once.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.core.directions import Vectors
from engine.core.figure_text import percent

Floats = NDArray[np.float64]
Parts = NDArray[np.intp]

#: Regions, and the parts that are left out in turn.
REGIONS, PARTS = 50, 5

#: Fewer measurements than this have no regions.
FEWEST = 20

#: Of pairs and of measurements, at most so many tell which pairs are far from all measurements.
PAIRS_ASKED, MEASUREMENTS_ASKED = 1000, 3000

#: A pair is far from all samples beyond the distance that this share of held-out samples had to those that were kept.
NEAR_SHARE = 0.95

#: Bands of the larger of both angles from the normal, in degrees.
_BANDS = np.arange(0.0, 91.0, 10.0)


def compute_squared_distance(wi: Vectors, wo: Vectors, to_wi: Vectors, to_wo: Vectors) -> Floats:
    """Squared distance (N,) of pairs of unit directions (N, 3) to one pair (3,), as the head of this file says."""
    a, b = wi[:, 0] + 1j * wi[:, 1], wo[:, 0] + 1j * wo[:, 1]
    alike = np.full(len(wi), -np.inf)
    for first, second in ((to_wi, to_wo), (to_wo, to_wi)):
        upright = wi[:, 2] * first[2] + wo[:, 2] * second[2]
        c, d = complex(*first[:2]), complex(*second[:2])
        turned = np.maximum(np.abs(a.conj() * c + b.conj() * d), np.abs(a * c + b * d))
        alike = np.maximum(alike, upright + turned)
    return np.maximum(4.0 - 2.0 * alike, 0.0)


def parts_of(wi: Vectors, wo: Vectors, measurement: Parts) -> Parts | None:
    """The part (N,) in [0, `PARTS`) that each sample is left out with; None for too few measurements.

    `wi` and `wo` (N, 3) are unit directions; samples of the same number of `measurement` (N,) are copies of one.
    """
    number, wi, wo = _measurements(wi, wo, measurement)
    if len(wi) < FEWEST:
        return None
    nearest, region = np.full(len(wi), np.inf), np.zeros(len(wi), np.intp)
    seed, seeds = 0, 0
    while seeds < REGIONS and nearest[seed] > 1e-12:
        distance = compute_squared_distance(wi, wo, wi[seed], wo[seed])
        region[distance < nearest] = seeds
        nearest = np.minimum(nearest, distance)
        seed, seeds = int(nearest.argmax()), seeds + 1
    return (region % PARTS)[number] if seeds >= PARTS else None


@dataclass(frozen=True)
class Gaps:
    """Pairs of directions near which nothing was measured.

    Attributes
    ----------
    share : of all pairs, uniform over both hemispheres. distance_deg : to the nearest sample, from which a pair counts.
    beyond_deg : angle from the normal of light or viewer beyond which most pairs are such; 90 where no band is.
    """

    share: float
    distance_deg: float
    beyond_deg: float

    @property
    def sentence(self) -> str:
        """A sentence for a user; empty where there are none to speak of."""
        if self.share < 0.01:
            return ""
        where = f", most of those with light or viewer beyond {self.beyond_deg:.0f}°" if self.beyond_deg < 90.0 else ""
        return (
            f"Nothing was measured within {self.distance_deg:.0f}° of {percent(self.share)} of all pairs of "
            f"directions{where}: there the factors are a guess, and no error is known."
        )


def gaps(samples: tuple[Vectors, Vectors, Parts], wi: Vectors, wo: Vectors) -> Gaps | None:
    """The gaps of `samples`, as `parts_of` takes them, among pairs (P, 3) that are uniform over both hemispheres.

    None without regions.
    """
    parts = parts_of(*samples)
    if parts is None:
        return None
    number, known_wi, known_wo = _measurements(*samples)
    part = np.empty(len(known_wi), np.intp)
    part[number] = parts
    rng = np.random.default_rng(0)
    few = np.sort(rng.permutation(len(known_wi))[:MEASUREMENTS_ASKED])
    known_wi, known_wo, part = known_wi[few], known_wo[few], part[few]
    left_out = np.sort(rng.permutation(len(few))[:PAIRS_ASKED])
    asked_wi, asked_wo = wi[:PAIRS_ASKED], wo[:PAIRS_ASKED]
    open_, kept = np.full(len(asked_wi), np.inf), np.full(len(left_out), np.inf)
    for index in range(len(few)):
        to = known_wi[index], known_wo[index]
        open_ = np.minimum(open_, compute_squared_distance(asked_wi, asked_wo, *to))
        distance = compute_squared_distance(known_wi[left_out], known_wo[left_out], *to)
        kept = np.where(part[left_out] != part[index], np.minimum(kept, distance), kept)
    limit = float(np.quantile(kept, NEAR_SHARE))
    far = open_ > limit
    lowest = np.degrees(np.arccos(np.clip(np.minimum(asked_wi[:, 2], asked_wo[:, 2]), 0.0, 1.0)))
    band = np.clip(np.digitize(lowest, _BANDS) - 1, 0, len(_BANDS) - 2)
    counts, missing = (np.bincount(band, weights, len(_BANDS) - 1) for weights in (None, far.astype(float)))
    known_bands = np.flatnonzero(missing <= 0.5 * counts)
    beyond = float(_BANDS[known_bands[-1] + 1]) if len(known_bands) else 0.0
    return Gaps(float(far.mean()), float(np.degrees(2.0 * np.arcsin(min(0.5 * np.sqrt(limit), 1.0)))), beyond)


def _measurements(wi: Vectors, wo: Vectors, measurement: Parts) -> tuple[Parts, Vectors, Vectors]:
    """The number of the measurement of each sample (N,), and the directions (M, 3) of one sample of each."""
    _, first, number = np.unique(measurement, return_index=True, return_inverse=True)
    return np.asarray(number.reshape(-1)), wi[first], wo[first]
