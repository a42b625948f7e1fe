"""What several models share: a power of a cosine near 1, a half vector that does not cancel, Schlick's Fresnel term."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from engine.brdf.evaluate import channels
from engine.params import Colour

Floats = NDArray[np.float64]


def diffuse_and_highlight(kd: Colour, ks: Colour, highlight: Floats) -> Floats:
    """kd/π + ks · highlight, (3, n) for (n,)."""
    return channels(kd) / np.pi + channels(ks) * highlight


def reflects_no_more_than_it_receives(kd: Colour, ks: Colour) -> bool:
    """Whether a diffuse part of albedo kd and a highlight of albedo up to ks stay within 1 in every channel."""
    return all(diffuse + specular <= 1.0 for diffuse, specular in zip(kd, ks, strict=True))


def power_of_one_minus(deficit: Floats, exponent: float | Floats) -> Floats:
    """max(0, 1 − deficit)^exponent for deficit >= 0, with 0⁰ = 1; `exponent` is a number or broadcasts.

    The cosine c near 1 is what matters at high exponents, and there 1 − c is known far better than c where it comes
    from differences of components; so the power is exp(n log1p(−(1 − c))), whose relative error stays near
    (2 + n |ln c|) u. Below c = 1/2, where a high power is next to nothing, n u/c is added.
    """
    positive = deficit < 1.0
    power = np.exp(exponent * np.log1p(-np.where(positive, deficit, 0.0)))
    return np.where(positive | (np.asarray(exponent) == 0.0), power, 0.0)


def sum_of_directions(wi: Floats, wo: Floats) -> tuple[Floats, Floats, Floats]:
    """H = wi + wo (3, n), its length, and 1 − n·h, which is across²/(|H| (|H| + H_z)) without cancellation."""
    both = wi + wo
    across = both[0] ** 2 + both[1] ** 2
    length = np.sqrt(across + both[2] ** 2)
    return both, length, across / (length * (length + both[2]))


def schlick(wi: Floats, wo: Floats, length: Floats) -> Floats:
    """(1 − h·wi)⁵ for |wi + wo| = length.

    h·wi is |wi + wo|/2 for unit vectors, which does not change when they are exchanged, and 1 − h·wi is
    |wi − wo|²/(2 (2 + |wi + wo|)), which is exact at both ends.
    """
    difference = wi - wo
    squared = difference[0] ** 2 + difference[1] ** 2 + difference[2] ** 2
    grazing = np.minimum(squared / (2.0 * (2.0 + length)), 1.0)
    return (grazing * grazing) ** 2 * grazing
