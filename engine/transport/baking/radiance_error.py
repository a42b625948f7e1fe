"""Error of baked transport in radiance against the sum over all texels of a cube map, whatever its mode.

At some vertices and from some directions far away, the radiance is compared with

    B = Σ f(wi, wo) V(wi) cos θ_i L dω          over the same texels, with the BRDF itself (Wang2004 Eq. 1).

The error is the root mean square of the difference over that of B, channels together, each pair of vertex and view
weighted by n · wo: about what pixels show. Pairs at grazing angles would dominate otherwise. What the texels themselves
leave out is not part of it. `wavelet_error`, `sh_error` and `gaussian_error` are this for their modes.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.brdf.brdf import Brdf
from engine.core.directions import Vectors, normalize
from engine.core.figure_text import count_text, percent
from engine.core.steps import Steps
from engine.light.cube_map import CubeMap, cube_of
from engine.light.environment import EnvironmentMap

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class RadianceError:
    """Error of radiance, relative to the reference.

    Attributes
    ----------
    rmse_rel : root mean square. mean_rel : how much brighter the mean is.
    negative_rel : what was clamped at 0, over what is left.
    pairs : of vertex and view that this is known from.
    """

    rmse_rel: float
    mean_rel: float
    negative_rel: float
    pairs: int


class Deviation:
    """Sums over pairs of vertex and view of how far one radiance is from another."""

    def __init__(self) -> None:
        self.pairs = 0
        self._difference = self._total = self._brighter = self._mean = 0.0

    def add(self, cosine: Floats, value: Floats, exact: Floats) -> None:
        """Count pairs with these n · wo (n,) > 0, where the radiance is `value` (n, 3) and should be `exact`."""
        self.pairs += len(cosine)
        self._difference += float(cosine @ ((value - exact) ** 2).sum(axis=1))
        self._total += float(cosine @ (exact**2).sum(axis=1))
        self._brighter += float(cosine @ (value - exact).sum(axis=1))
        self._mean += float(cosine @ exact.sum(axis=1))

    @property
    def rmse_rel(self) -> float:
        """0 where all is dark."""
        return math.sqrt(self._difference / self._total) if self._total > 0.0 else 0.0

    @property
    def mean_rel(self) -> float:
        """0 where all is dark."""
        return self._brighter / self._mean if self._mean > 0.0 else 0.0

    def error(self, negative_rel: float) -> RadianceError:
        return RadianceError(self.rmse_rel, self.mean_rel, negative_rel, self.pairs)


def choose_tried_pairs(count: int, vertices: int, views: int, seed: int) -> tuple[NDArray[np.int64], Vectors]:
    """Rising indices of up to `vertices` of `count`, and directions (views, 3) from which they are seen."""
    rng = np.random.default_rng(seed)
    chosen = np.sort(rng.choice(count, min(vertices, count), replace=False))
    return chosen, normalize(rng.standard_normal((views, 3)))


def exact_radiance(brdf: Brdf, wi: Vectors, visible: Floats, incident: Floats, views: Vectors) -> Floats:
    """(views, 3) the sums with the BRDF itself over texels in the directions `wi` (T, 3) of a tangent frame.

    `visible` (T,) are the shares of them that are open, `incident` (T, 3) their radiance times solid angle, `views`
    (views, 3) unit vectors in the same frame.
    """
    lit = np.flatnonzero((wi[:, 2] > 0.0) & (visible > 0.0))
    weights = incident[lit] * (wi[lit, 2] * visible[lit])[:, None]
    return np.array([(brdf.f(wi[lit], wo[None]) * weights).sum(axis=0) for wo in views]).reshape(-1, 3)


def error_record(
    environment: EnvironmentMap | None, edge: int, measure: Callable[[CubeMap], Steps[RadianceError]]
) -> Steps[dict[str, Any]]:
    """The record of an error under `environment` as a cube map of `edge`; nothing where there is none."""
    if environment is None:
        return {}
    found = yield from measure(cube_of(environment, edge))
    return {
        "error_env": environment.name,
        "error_rmse_rel": found.rmse_rel,
        "error_mean_rel": found.mean_rel,
        "error_negative_rel": found.negative_rel,
        "error_pairs": found.pairs,
    }


def rounding_lines(result: dict[str, Any]) -> list[str]:
    """The part of the error that comes from the digits of coefficients in the file, in words, where there is one."""
    error = result["rounding_error_rel"]
    return [f"coefficients in the file are rounded, by {percent(error, 2)} RMS"] if error else []


def error_lines(result: dict[str, Any]) -> list[str]:
    """An error record in words, where there is one."""
    if "error_rmse_rel" not in result:
        return []
    mean = result.get("error_mean_rel", 0.0)
    brighter = f"; {percent(abs(mean), 3)} {'brighter' if mean > 0.0 else 'darker'} in the mean"
    return [
        f"error under {result['error_env']}: {percent(result['error_rmse_rel'], 3)} of the radiance "
        f"(RMS, {count_text(result['error_pairs'])} pairs of vertex and view){brighter if abs(mean) >= 1e-3 else ''}"
    ]
