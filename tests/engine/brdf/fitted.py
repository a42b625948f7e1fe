"""A smooth BRDF at once, for tests that do not look at how long it takes."""

from __future__ import annotations

from engine.brdf.samples import BrdfSamples
from engine.brdf.scattered import ScatteredBrdf, fit_scattered
from engine.core.steps import drain


def fit_scattered_brdf(samples: BrdfSamples, smoothing: float = 0.0) -> ScatteredBrdf:
    """The BRDF of `fit_scattered`."""
    return drain(fit_scattered(samples, smoothing))
