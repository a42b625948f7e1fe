"""A photograph as representations that are made of the others show it, for single texels.

Errors of whole captures follow from moments (`engine.shading.directional.moments`); this tells what a user would
see. Linear representations predict the codes of a photograph from those of the others by one matrix for all texels.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.capture.report import bracket
from engine.core.cached import cached_property
from engine.core.colour import srgb_encode
from engine.core.directions import Vectors
from engine.shading.directional.interpolation import Kernel, weights
from engine.shading.directional.moments import Moments
from engine.shading.directional.planes import components

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Texels:
    """Some texels in N photographs: radiance (N, T, 3), where it is usable (N, T), and rows and columns (T,); of pairs
    under polarisers also the diffuse part of the radiance (N, T, 3)."""

    radiance: NDArray[np.float32]
    usable: NDArray[np.bool_]
    rows: NDArray[np.int64]
    columns: NDArray[np.int64]
    diffuse: NDArray[np.float32] | None = None

    def choose(self, photographs: NDArray[np.int64] | slice, every: int = 1) -> Texels:
        """Return `every`-th texel in some of the photographs."""
        return Texels(
            self.radiance[photographs, ::every],
            self.usable[photographs, ::every],
            self.rows[::every],
            self.columns[::every],
            None if self.diffuse is None else self.diffuse[photographs, ::every],
        )

    def take(self, at: NDArray[np.int64]) -> Texels:
        """Return the texels at the positions `at`."""
        return Texels(
            np.ascontiguousarray(self.radiance[:, at]),
            self.usable[:, at],
            self.rows[at],
            self.columns[at],
            None if self.diffuse is None else np.ascontiguousarray(self.diffuse[:, at]),
        )

    @cached_property
    def codes(self) -> NDArray[np.float32]:
        """(N, T, 3) codes of 8-bit sRGB as real numbers, up to the white level."""
        return np.asarray(255.0 * srgb_encode(np.clip(self.radiance, 0.0, 1.0)), np.float32)


#: The codes (T, 3) of the photograph at a place in the list, as the others predict it.
Predict = Callable[[Texels, int], Array]


def by_photographs(shares: Array) -> Predict:
    """Sums of photographs; `shares` (N, N) are as `interpolation.left_out` gives them, −1 at their own place."""

    def predict(texels: Texels, out: int) -> Array:
        of_others = np.where(np.arange(len(shares)) == out, 0.0, shares[out])
        return np.asarray(np.einsum("n,ntc->tc", of_others, texels.codes, optimize=True))

    return predict


def by_planes(lights: Vectors, found: Moments, kernel: Kernel, count: int) -> Predict:
    """`count` planes of the other photographs, which are not rounded to eight bits."""
    total, covariance, mean = len(lights), found.covariance, found.mean.reshape(-1, 3)

    def predict(texels: Texels, out: int) -> Array:
        others = np.flatnonzero(np.arange(total) != out)
        values = (3 * others[:, None] + np.arange(3)).ravel()
        vectors = components(covariance[np.ix_(values, values)], count)
        of_others = weights(lights[others], lights[out][None], kernel)[0]
        functions = np.einsum("n,nck->kc", of_others, vectors.reshape(len(others), 3, -1))
        apart = (texels.codes[others] - mean[others][:, None, :]).transpose(1, 0, 2).reshape(-1, len(values))
        return np.asarray(of_others @ mean[others] + (apart @ vectors) @ functions)

    return predict


def by_brightness(means: Array) -> Predict:
    """The shading map of the others at the mean radiance of the photograph; `means` (N,) are those of all."""
    order = np.argsort(means, kind="stable")

    def predict(texels: Texels, out: int) -> Array:
        others = [int(each) for each in order if each != out]
        shown = bracket(texels.radiance, means, others, float(means[out]))
        return np.asarray(255.0 * srgb_encode(np.clip(shown, 0.0, 1.0)))

    return predict
