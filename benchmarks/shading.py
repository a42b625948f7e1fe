"""Linearising and power-law compression, 512 x 512 texels and 8 slices from 10 photographs."""

from __future__ import annotations

import warnings

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import OptimizeWarning, curve_fit

from benchmarks.measure import Measure, best_of
from engine.capture.stack import ImageStack
from engine.core.colour import LUMINANCE
from engine.core.steps import drain
from engine.shading.power_law import fit
from engine.shading.shading_map import ShadingMap, build

SIDE, PHOTOGRAPHS, SLICES = 512, 10, 8
TEXELS_FOR_SCIPY = 1000


def linearise() -> Measure:
    """`build` against a copy of the bytes that it reads and writes."""
    stack = _stack()
    slices = drain(build(stack, SLICES)).slices
    time_s = best_of(lambda: drain(build(stack, SLICES)))
    limit_s = best_of(lambda: (np.array(stack.radiance), slices.copy()))
    return Measure("linearise", time_s, limit_s, "copying the photographs and the slices")


def power_law_fit() -> Measure:
    """`fit` against scipy's `curve_fit` for every texel and channel, extrapolated from a thousand of them."""
    shading_map = drain(build(_stack(), SLICES))
    time_s = best_of(lambda: drain(fit(shading_map)))
    samples = shading_map.slices.reshape(SLICES, -1)
    chosen = samples[:, :: samples.shape[1] // TEXELS_FOR_SCIPY]
    limit_s = best_of(lambda: _fit_with_scipy(chosen), repeats=2) * samples.shape[1] / chosen.shape[1]
    return Measure("power-law-fit", time_s, limit_s, "scipy.optimize.curve_fit per texel")


def power_law_fit_copy() -> Measure:
    """`fit` against a copy of the bytes that it reads and writes, which nothing could beat."""
    shading_map: ShadingMap = drain(build(_stack(), SLICES))
    power_law = drain(fit(shading_map))
    time_s = best_of(lambda: drain(fit(shading_map)))
    arrays = (shading_map.slices, power_law.scale, power_law.exponent, power_law.error_map)
    limit_s = best_of(lambda: [array.copy() for array in arrays])
    return Measure("power-law-fit-copy", time_s, limit_s, "copying the slices and the result")


def _stack() -> ImageStack:
    """Photographs of texels that brighten as powers of the light, with noise."""
    rng = np.random.default_rng(0)
    light = np.linspace(0.05, 1.0, PHOTOGRAPHS)[:, None, None, None]
    exponent = np.exp(rng.normal(0.0, 0.4, (SIDE, SIDE, 3)))
    noise = 1.0 + 0.05 * rng.standard_normal((PHOTOGRAPHS, SIDE, SIDE, 3), np.float32)
    radiance = (rng.uniform(0.1, 1.0, (SIDE, SIDE, 3)) * light**exponent * noise).astype(np.float32)
    return ImageStack(
        radiance=radiance,
        saturated=np.zeros(radiance.shape[:3], np.bool_),
        elevation=np.radians(np.linspace(5.0, 85.0, PHOTOGRAPHS)),
        azimuth=None,
        mean_radiance=radiance.mean(axis=(1, 2), dtype=np.float64) @ LUMINANCE,
        sources=tuple(f"{index}" for index in range(PHOTOGRAPHS)),
        angle_source="user",
    )


def _fit_with_scipy(samples: NDArray[np.float32]) -> None:
    x = np.arange(1, SLICES) / (SLICES - 1)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", OptimizeWarning)
        for texel in samples.T:
            curve_fit(lambda r, k, exponent: k * r**exponent, x, texel[1:], p0=(texel[-1], 1.0))
