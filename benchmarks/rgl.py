"""A million values and a million sampled directions of an RGL measurement of the published size, made up here."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from benchmarks.measure import Measure, best_of
from engine.brdf.readers.rgl import RglBrdf, Warp
from engine.core.directions import Vectors, normalize
from engine.core.health import Health

PAIRS = 1_000_000
ELEVATIONS, NODES, COLOURS = 8, 128, 32


def rgl_values() -> Measure:
    """`RglBrdf.f` against a copy of the bytes that it reads and writes."""
    brdf, (wi, wo) = _measurement(), _directions()
    values = np.empty((PAIRS, 3))
    time_s = best_of(lambda: brdf.f(wi, wo))
    limit_s = best_of(lambda: (wi.copy(), wo.copy(), values.copy()))
    return Measure("rgl-values", time_s, limit_s, "copying a million pairs and values", {"pairs": PAIRS})


def rgl_samples() -> Measure:
    """`RglBrdf.sample` against a copy of the bytes that it reads and writes."""
    brdf, (wo, drawn) = _measurement(), _directions()
    uniform = np.random.default_rng(1).random((PAIRS, 2))
    time_s = best_of(lambda: brdf.sample(wo, uniform))
    limit_s = best_of(lambda: (wo.copy(), uniform.copy(), drawn.copy()))
    return Measure("rgl-samples", time_s, limit_s, "copying a million directions twice", {"directions": PAIRS})


def _measurement() -> RglBrdf:
    """An isotropic file of the database by its sizes, with random content."""
    random = np.random.default_rng(0)

    def table(*shape: int) -> NDArray[np.float64]:
        return random.uniform(0.5, 1.0, shape)

    return RglBrdf(
        name="made up",
        kind="RGL measurement",
        phi_i=np.zeros(1),
        theta_i=np.linspace(0.0, 0.5 * np.pi, ELEVATIONS),
        scaled=True,
        ndf=table(2, NODES),
        sigma=table(2, NODES),
        visible=Warp.of(table(1, ELEVATIONS, NODES, NODES)),
        luminance=Warp.of(table(1, ELEVATIONS, COLOURS, COLOURS)),
        colours=table(1, ELEVATIONS, COLOURS, COLOURS, 3),
        spectral=False,
        samples=ELEVATIONS * COLOURS**2,
        invalid_samples=0,
        health=Health(),
    )


def _directions() -> tuple[Vectors, Vectors]:
    """Directions above the horizon."""
    first, second = normalize(np.random.default_rng(2).normal(size=(2, PAIRS, 3)))
    for directions in (first, second):
        directions[:, 2] = np.abs(directions[:, 2])
    return first, second
