"""Wavelet transport of several reflectances, or of several numbers of coefficients, from one set of rays in memory.

Rays are nearly all that a bake costs, so a ladder takes little longer than its finest step.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.factor.separable_factors import SeparableFactors
from engine.mesh import Mesh
from engine.ray_caster import caster_of
from engine.steps import Step, Steps
from engine.transport.visibility import receivers, visibility_shares
from engine.transport.wavelet import (
    DIFFUSE,
    Vectors16,
    WaveletTransport,
    cube_texels,
    light_maps,
    transport_vectors,
    vectors_of,
    vertex_frames,
)

#: Parts along a side into which a texel is cut where visibility changes, as `lightarc bake` does.
FINE = 4

#: Visibility counts of a chunk, about 50 ms of rays.
CHUNK = 1 << 20


@dataclass(frozen=True)
class Kept:
    """A bake to be made: of these factors, so many coefficients for each vector."""

    factors: SeparableFactors
    coefficients: int = 96


def baked_together(
    surface: Mesh, ground_vertex: int, ground_albedo: float, edge: int, kept: Sequence[Kept]
) -> Steps[list[WaveletTransport]]:
    """Transport of `surface`, the ground from `ground_vertex` on, for each of `kept`."""
    of, texels = receivers(surface, caster_of(surface)), cube_texels(edge)
    frames = [vertex_frames(surface, each.factors.isotropic) for each in kept]
    maps = [light_maps(each.factors) for each in kept]
    plain = np.ones((1, 1, 1), np.float32)
    parts: list[list[dict[str, NDArray[Any]]]] = [[] for _ in kept]
    total = len(surface.positions)
    for start, stop in pairwise(_bounds(total, ground_vertex, edge)):
        vertices = np.arange(start, stop)
        counts = np.concatenate([counts for _, counts in visibility_shares(of, edge, FINE, vertices)])
        for number, each in enumerate(kept):
            of_model = start < ground_vertex
            chart, shown = (each.factors.chart, maps[number]) if of_model else (DIFFUSE, plain)
            own = frames[number][vertices]
            parts[number].append(transport_vectors(own, counts, FINE**2, texels, chart, shown, each.coefficients))
        yield Step(float(stop / total), f"baking vertex {stop:,} of {total:,}")
    return [
        WaveletTransport(surface, ground_vertex, each.factors, ground_albedo, edge, _joined(parts[number]))
        for number, each in enumerate(kept)
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


def _bounds(vertices: int, first: int, edge: int) -> list[int]:
    """Where chunks begin, and the end; none mixes model and ground."""
    step = max(1, CHUNK // (6 * edge * edge))
    return sorted({*range(0, first, step), *range(first, vertices, step), first, vertices, 0})


def _joined(parts: list[dict[str, NDArray[Any]]]) -> Vectors16:
    return vectors_of({name: np.concatenate([part[name] for part in parts]) for name in parts[0]})
