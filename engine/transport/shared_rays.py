"""Rays shared by bakes of one surface: rays in chunks, and vectors of wavelets from the counts that rays gave.

Rays are nearly all that a bake costs, so a sweep of BRDFs, terms or coefficients takes little longer than its
finest step. Counts are those of `lightarc bake`, and so are the vectors.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from engine.core.steps import Steps
from engine.factor.separable_factors import SeparableFactors
from engine.geometry.mesh import Mesh
from engine.transport.baking.visibility import Receivers, visibility_shares
from engine.transport.method import Subject
from engine.transport.wavelet.transfer import (
    DIFFUSE,
    cube_texels,
    light_maps,
    transport_vectors,
    vertex_frames,
)

#: Parts along a side into which a texel is cut where visibility changes.
FINE = 4

#: Visibility counts of a chunk, about 50 ms of rays.
CHUNK = 1 << 20

Indices = NDArray[np.int64]

#: Rows of a bake for some vertices, all of the model or all of the ground, and how many parts of each texel they see.
Make = Callable[[Indices, NDArray[np.uint8]], Mapping[str, NDArray[Any]]]


class Sharing(Protocol):
    """Interface of the module of a method whose bakes can share their rays."""

    def edge_of(self, settings: Any) -> int:
        """Texels along an edge of the cube maps over which visibility is summed."""

    def is_apart(self, settings: Any) -> bool:
        """True where a bake takes so long beside its rays that it shares them with no other method's."""

    def prepare_shared(self, subject: Subject, settings: Any, known: dict[Any, Any]) -> Steps[Any]:
        """As `prepare`; what outlives one setting is taken from `known`, and put there."""

    def maker(self, work: Any) -> Steps[Make]:
        """Makes the rows of a bake."""

    def rows_of(self, work: Any) -> int:
        """Rows of a vertex of the model; one of the ground has one."""

    def assemble(self, work: Any, arrays: Mapping[str, NDArray[Any]]) -> Any:
        """The transport of all rows."""


def chunks(vertices: Indices, first: int, edge: int) -> list[Indices]:
    """`vertices`, in rising order, in chunks; none mixes the model and the ground, which begins with vertex `first`."""
    step, of_model = max(1, CHUNK // (6 * edge * edge)), int(np.searchsorted(vertices, first))
    parts = vertices[:of_model], vertices[of_model:]
    return [part[start : start + step] for part in parts for start in range(0, len(part), step)]


def count(of: Receivers, edge: int, vertices: Indices) -> NDArray[np.uint8]:
    """(B, 6 edge²) how many of the `FINE`² parts of each texel `vertices` (B,) see."""
    return np.concatenate([counts for _, counts in visibility_shares(of, edge, FINE, vertices)])


def wavelet_maker(surface: Mesh, first: int, factors: SeparableFactors, edge: int, coefficients: int) -> Make:
    """Makes the arrays of `wavelet.Vectors16`."""
    maps, texels, frames = light_maps(factors), cube_texels(edge), vertex_frames(surface, factors.isotropic)
    ground = np.ones((1, 1, 1), np.float32)

    def make(vertices: Indices, counts: NDArray[np.uint8]) -> Mapping[str, NDArray[Any]]:
        hemisphere_map, shown = (factors.hemisphere_map, maps) if vertices[0] < first else (DIFFUSE, ground)
        return transport_vectors(frames[vertices], counts, FINE**2, texels, hemisphere_map, shown, coefficients)

    return make


def join(parts: Iterable[Mapping[str, NDArray[Any]]]) -> dict[str, NDArray[Any]]:
    """The arrays of chunks, one after the other."""
    some = list(parts)
    return {name: np.concatenate([part[name] for part in some]) for name in some[0]}
