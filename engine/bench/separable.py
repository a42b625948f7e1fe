"""Separable factors of the size that Wang, Tran and Luebke 2004 use, beside sampling the reflectance alone."""

from __future__ import annotations

from engine.bench.measure import Measure, best_of
from engine.brdf.brdf import Brdf, brdf_from_text
from engine.factor.brdf_matrix import brdf_matrix
from engine.factor.errors import reference
from engine.factor.maps import DirectionMap
from engine.factor.separable import SeparableMethod, Weighting, separate
from engine.steps import drain

SIZE, TERMS = 48, 16


def separable() -> Measure:
    """16 terms of three channels on maps of 48² by eigenvectors: Lafortune's blue paint, which has every mirror."""
    return _measure("separable-48", "symmetric", "cosine")


def separable_svd() -> Measure:
    """The same by singular vectors."""
    return _measure("separable-48-svd", "svd", "cosine")


def separable_power() -> Measure:
    """The same by the block power iteration."""
    return _measure("separable-48-power", "power", "cosine")


def separable_auto() -> Measure:
    """The same with both norms, compared over 80,000 pairs."""
    return _measure("separable-48-auto", "auto", "auto")


def _measure(name: str, method: SeparableMethod, weighting: Weighting) -> Measure:
    brdf: Brdf = brdf_from_text("lafortune:preset=blue-paint")
    chart = DirectionMap("orthographic", SIZE)
    pairs = reference(brdf)

    def make() -> object:
        return drain(separate(brdf, chart, TERMS, method=method, weighting=weighting, reference=pairs))

    time_s = best_of(make, repeats=3)
    limit_s = best_of(lambda: drain(brdf_matrix(brdf, chart, "in-out")), repeats=3)
    more = {"texels": len(chart.directions), "terms": TERMS, "target_s": 1.0}
    return Measure(name, time_s, limit_s, "sampling the reflectance for the matrix", more)
