"""Wavelet transport of several BRDFs, or of several numbers of coefficients, from one set of rays in memory.

Rays are nearly all that a bake costs, so a sweep takes little longer than its finest step.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.core.steps import Step, Steps
from engine.factor.separable_factors import SeparableFactors
from engine.geometry.mesh import Mesh
from engine.geometry.ray_caster import caster_of
from engine.transport.baking.visibility import receivers
from engine.transport.shared_rays import chunks, count, join, wavelet_maker
from engine.transport.wavelet.transfer import Vectors16, WaveletTransport, vectors_of


@dataclass(frozen=True)
class Kept:
    """A bake to be made: of these factors, so many coefficients for each vector."""

    factors: SeparableFactors
    coefficients: int = 96


def bake_together(
    surface: Mesh, ground_vertex: int, ground_albedo: float, edge: int, kept: Sequence[Kept]
) -> Steps[list[WaveletTransport]]:
    """Transport of `surface`, the ground from `ground_vertex` on, for each of `kept`."""
    of = receivers(surface, caster_of(surface))
    makers = [wavelet_maker(surface, ground_vertex, each.factors, edge, each.coefficients) for each in kept]
    parts: list[list[Mapping[str, NDArray[Any]]]] = [[] for _ in kept]
    total, done = len(surface.positions), 0
    for vertices in chunks(np.arange(total), ground_vertex, edge):
        counts = count(of, edge, vertices)
        for own, make in zip(parts, makers, strict=True):
            own.append(make(vertices, counts))
        done += len(vertices)
        yield Step(done / total, f"baking vertex {done:,} of {total:,}")
    return [
        WaveletTransport(surface, ground_vertex, each.factors, ground_albedo, edge, vectors_of(join(own)))
        for each, own in zip(kept, parts, strict=True)
    ]


def without_vectors(mesh: Mesh, factors: SeparableFactors, edge: int = 4) -> WaveletTransport:
    """Transport for lamps alone, which need no wavelets: the rest of the light is black."""
    rows = len(mesh.positions) * factors.terms
    empty = Vectors16(
        np.zeros((rows, 1), np.uint16),
        np.zeros((rows, 1), np.uint32),
        np.zeros((rows, 3), np.float32),
        np.zeros(rows, np.uint16),
    )
    return WaveletTransport(mesh, len(mesh.positions), factors, 0.0, edge, empty)
