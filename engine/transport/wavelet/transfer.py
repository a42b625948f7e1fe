"""Wavelet transport with separable BRDFs (Wang2004, "All-frequency relighting of non-diffuse
objects using separable BRDF approximation"), on the CPU.

    T_k(v, wi) = light_k(wi) V(v, wi) cos θ_i dω         the strongest Haar coefficients of each vertex (Wang2004 Eq. 3)
    L_k(v)     = Σ T_k L                                 for each light: the light-modulated K-tuple (Wang2004 Eq. 5)
    B(v, wo)   = Σ_k view_k(wo) L_k(v)                   when the view changes (Wang2004 Eq. 6)

Directions of the light are in the world, those of the maps in the vertex's own tangent frame. A ground under the model
is Lambertian and has one term, of light map 1 and view map albedo/π, whatever the model has. Terms may be those of
several BRDFs that are mixed over the model (`engine.transport.baking.blend`). Sums below 0, which truncation
leaves, are clamped in the radiance only, and how much that was is reported.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.core.cached import cached_property
from engine.core.directions import Vectors, dot, frames_along, normalize, world_from_tangent
from engine.core.errors import UsageError
from engine.factor.hemisphere_map import HemisphereMap
from engine.factor.separable_factors import SeparableFactors
from engine.geometry.camera import Vector
from engine.geometry.mesh import Mesh
from engine.light.cube_map import cube_directions, cube_solid_angles
from engine.transport.baking.blend import Mixture, mixture
from engine.transport.baking.visibility import Receivers, receivers
from engine.transport.wavelet.haar import FACES, candidates, check_edge
from engine.transport.wavelet.kernel import pack_light, relight, transfer
from engine.transport.wavelet.quantise import STEP, WaveletLight

#: Most terms of a BRDF and most coefficients of a vector.
MAX_TERMS, MAX_COEFFICIENTS = 64, 4096

#: Squared length of the mean of unit tangents from which frames count as one (`transported.frag`), and a little more.
ONE_FRAME = 0.935

#: Cosines of the view below this are drawn as if seen at it: normals between vertices can turn away from the viewer.
GRAZING = 0.01


@dataclass(frozen=True, eq=False)
class Vectors16:
    """Packed transport vectors, one row each; see `wavelet_codes`.

    Attributes
    ----------
    indices, words : (R, N) uint16 and uint32, in rising order of the index; 0 beyond `counts`.
    peaks : (R, 3) float32.
    counts : (R,) uint16.
    """

    indices: NDArray[np.uint16]
    words: NDArray[np.uint32]
    peaks: NDArray[np.float32]
    counts: NDArray[np.uint16]

    def select(self, rows: slice) -> Vectors16:
        """The vectors in some `rows`."""
        return Vectors16(self.indices[rows], self.words[rows], self.peaks[rows], self.counts[rows])

    def check(self, edge: int) -> None:
        """ValueError where the arrays do not fit together or name coefficients that faces of `edge` do not have."""
        kinds = (self.indices, np.uint16, 2), (self.words, np.uint32, 2), (self.peaks, np.float32, 2)
        if any(array.dtype != kind or array.ndim != axes for array, kind, axes in kinds):
            raise ValueError("vectors are of other types")
        if self.counts.dtype != np.uint16 or self.counts.shape != (len(self.words),):
            raise ValueError("counts are of another type")
        if self.indices.shape != self.words.shape or self.peaks.shape != (len(self.words), 3):
            raise ValueError("vectors do not fit together")
        if not np.isfinite(self.peaks).all() or (self.peaks < 0.0).any():
            raise ValueError("peaks are not finite, or negative")
        if self.counts.max(initial=0) > self.words.shape[1] or self.indices.max(initial=0) >= FACES * edge * edge:
            raise ValueError("vectors name coefficients that do not exist")


@dataclass(frozen=True, eq=False)
class WaveletTransport:
    """Wavelet transport of every vertex, before there is light.

    Attributes
    ----------
    mesh : model, and after it the ground where there is one.
    ground_vertex : the first vertex of the ground; the number of vertices without one.
    factors : of the model's BRDF, over light and viewer.
    ground_albedo : of the ground.
    edge : of the faces of the cube maps of light.
    vectors : K rows for each vertex of the model, vertex by vertex, then one for each of the ground.
    mixture : how the terms are mixed at the vertices of the model; None where they are of one BRDF.
    bounces : rows as `vectors`, of light that comes by way of other parts of the model; None where that is left out.
    kind : (ground_vertex,) of which of the `kinds` BRDFs each vertex of the model is, with as many terms each, whose
        factors stand one after the other; None where there is one.
    """

    mesh: Mesh
    ground_vertex: int
    factors: SeparableFactors
    ground_albedo: float
    edge: int
    vectors: Vectors16
    mixture: Mixture | None = None
    bounces: Vectors16 | None = None
    kind: NDArray[np.int64] | None = None
    kinds: int = 1

    def __post_init__(self) -> None:
        check_factors(self.factors, self.terms)
        check_edge(self.edge)
        if self.factors.terms % self.kinds or (self.kind is None and self.kinds != 1):
            raise ValueError(f"{self.factors.terms} terms are not those of {self.kinds} BRDFs")
        if self.kind is not None and (self.kind.shape != (self.ground_vertex,) or self.kind.max() >= self.kinds):
            raise ValueError("vertices name BRDFs that do not exist")
        if self.mixture is not None:
            check_mixture(self.mixture, self.factors, self.ground_vertex)
        rows = self.ground_vertex * self.terms + len(self.mesh.positions) - self.ground_vertex
        if not 0 <= self.ground_vertex <= len(self.mesh.positions) or len(self.vectors.words) != rows:
            raise ValueError(f"{len(self.vectors.words)} vectors do not belong to these vertices, which need {rows}")
        if self.bounces is not None and len(self.bounces.words) != rows:
            raise ValueError(f"{len(self.bounces.words)} vectors of bounces do not fit {rows} direct ones")

    @property
    def rows(self) -> int:
        return len(self.vectors.words)

    @property
    def terms(self) -> int:
        """Rows of a vertex of the model."""
        return self.factors.terms // self.kinds

    @cached_property
    def frames(self) -> Vectors:
        """(V, 3, 3) with columns tangent, bitangent, normal."""
        return vertex_frames(self.mesh, self.factors.isotropic)

    @cached_property
    def turning(self) -> NDArray[np.bool_]:
        """(V,) vertices of faces over which the frames turn so far that terms of their corners cannot be mixed.

        Beside all others, the mean of tangents, of whatever weights, has a squared length of at least `ONE_FRAME`.
        """
        tangent = self.frames[:, :, 0][self.mesh.faces]
        least = np.min([dot(tangent[:, a], tangent[:, b]) for a, b in ((0, 1), (1, 2), (2, 0))], axis=0)
        found = np.zeros(len(self.mesh.positions), np.bool_)
        found[self.mesh.faces[1.0 + 2.0 * least < 3.0 * ONE_FRAME]] = True
        return found

    @cached_property
    def receivers(self) -> Receivers:
        """The vertices as places where the light of lamps arrives, shaded by the mesh."""
        return receivers(self.mesh)


def check_factors(factors: SeparableFactors, terms: int | None = None) -> None:
    """UsageError for factors that cannot be baked; of several BRDFs each has so many `terms`."""
    if factors.parametrisation != "in-out":
        raise UsageError("wavelets need factors over light and viewer (in-out), not over half and difference vectors")
    if (terms or factors.terms) > MAX_TERMS:
        raise UsageError(f"{terms or factors.terms} terms are more than the {MAX_TERMS} that can be baked")


def check_mixture(mixture: Mixture, factors: SeparableFactors, vertices: int) -> None:
    """ValueError for a mixture of other terms, or of another number of vertices."""
    if sum(mixture.terms) != factors.terms or len(mixture.weights) != vertices:
        raise ValueError(
            f"a mixture of {mixture.terms} terms at {len(mixture.weights)} vertices does not fit "
            f"{factors.terms} terms at {vertices}"
        )


def remix(
    transport: WaveletTransport, sources: Sequence[str] | None = None, image: str | None = None
) -> WaveletTransport:
    """The same transport with other weights of its BRDFs, and another colour; None keeps what there is.

    `sources` and `image` are as in `engine.transport.baking.blend.mixture`, with the same errors.
    """
    before, first, mesh = transport.mixture, transport.ground_vertex, transport.mesh
    model = replace(
        mesh,
        positions=mesh.positions[:first],
        normals=mesh.normals[:first],
        uv=mesh.uv[:first],
        faces=mesh.faces[(mesh.faces < first).all(axis=1)],
    )
    terms = (transport.factors.terms,) if before is None else before.terms
    if sources is not None or before is None:
        mixed = mixture(model, terms, sources or (), image)
        kept = None if before is None else before.albedo
    else:
        mixed, kept = replace(before, albedo=None), before.albedo
        if image is not None:
            mixed = replace(mixed, albedo=mixture(model, (1,), (), image).albedo)
    return replace(transport, mixture=mixed if mixed.albedo is not None else replace(mixed, albedo=kept))


def vertex_frames(mesh: Mesh, isotropic: bool) -> Vectors:
    """Frames (V, 3, 3) at the vertices; along the brushing direction where the BRDF has one."""
    normals = normalize(mesh.normals)
    return world_from_tangent(normals) if isotropic else frames_along(normals, mesh.tangents)


@dataclass(frozen=True, eq=False)
class Texels:
    """The texels of the faces, row by row: `direction` (6 N², 3) and `area` (6 N²,) in sr."""

    direction: NDArray[np.float64]
    area: NDArray[np.float64]


def cube_texels(edge: int) -> Texels:
    return Texels(cube_directions(edge).reshape(-1, 3), np.tile(cube_solid_angles(edge).reshape(-1), FACES))


def light_maps(factors: SeparableFactors) -> NDArray[np.float32]:
    """(K, P, texels) float32 of the light maps; P is 1 where all colours of all terms are alike, else 3."""
    planes = np.moveaxis(factors.second.reshape(factors.terms, -1, 3), 2, 1)
    grey = bool((planes == planes[:, :1]).all())
    return np.ascontiguousarray(planes[:, :1] if grey else planes)


#: The map of the ground's light map, which is 1 everywhere.
DIFFUSE = HemisphereMap("orthographic", 1)


def transport_vectors(
    frames: Vectors,
    visible: NDArray[np.uint8],
    full: int,
    texels: Texels,
    hemisphere_map: HemisphereMap,
    maps: NDArray[np.float32],
    coefficients: int,
    step: int = STEP,
) -> dict[str, NDArray[Any]]:
    """The arrays of `Vectors16` for vertices with `frames` (B, 3, 3), B · K rows.

    `visible` (B, 6 N²) counts the parts, of `full`, of each texel that light arrives from; `hemisphere_map` is that of
    the light maps `maps` (see `light_maps`). Quantised coefficients are multiples of `step` (`quantise_vectors`).
    """
    shape = (len(frames), len(maps))
    found: dict[str, NDArray[Any]] = {
        "indices": np.empty((*shape, coefficients), np.uint16),
        "words": np.empty((*shape, coefficients), np.uint32),
        "peaks": np.empty((*shape, 3), np.float32),
        "counts": np.empty(shape, np.uint16),
    }
    transfer(
        np.ascontiguousarray(frames),
        visible,
        full,
        texels.direction,
        texels.area,
        hemisphere_map.number,
        hemisphere_map.size,
        maps,
        candidates(coefficients),
        step,
        *found.values(),
    )
    return {name: array.reshape(-1, *array.shape[2:]) for name, array in found.items()}


def relight_transport(transport: WaveletTransport, light: WaveletLight) -> NDArray[np.float64]:
    """The light-modulated K-tuples (Wang2004 Eq. 5) as rows (R, 3), ordered as `transport.vectors`, before mixing.

    They are those of direct light; `reflect_light` has the rest.
    """
    return _relight(transport, transport.vectors, light)


def reflect_light(transport: WaveletTransport, light: WaveletLight) -> NDArray[np.float64] | float:
    """The same of light that comes by way of the model; 0 where it is left out."""
    return 0.0 if transport.bounces is None else _relight(transport, transport.bounces, light)


def _relight(transport: WaveletTransport, vectors: Vectors16, light: WaveletLight) -> NDArray[np.float64]:
    if light.edge != transport.edge:
        raise ValueError(f"light of an edge of {light.edge} does not fit transport of {transport.edge}")
    result = np.empty((transport.rows, 3))
    relight(
        vectors.indices,
        vectors.words,
        vectors.peaks,
        vectors.counts,
        pack_light(light.quantised),
        light.scaling,
        light.quantum,
        result,
    )
    return result


@dataclass(frozen=True, eq=False)
class VertexRadiance:
    """Radiance of vertices: `value` (V, 3) ≥ 0, and `negative_rel`, what was clamped over what is left."""

    value: NDArray[np.float64]
    negative_rel: float


def radiance_from(transport: WaveletTransport, rows: NDArray[np.float64], eye: Vector) -> VertexRadiance:
    """Radiance of all vertices towards the point `eye` (3,); 0 where they are seen from behind."""
    return radiance_towards(transport, rows, normalize(np.asarray(eye, np.float64) - transport.mesh.positions))


def radiance_towards(
    transport: WaveletTransport, rows: NDArray[np.float64], wo: Vectors, vertices: NDArray[np.int64] | None = None
) -> VertexRadiance:
    """Radiance towards world directions `wo` (n, 3) of `vertices` (n,), all of them where none are named."""
    chosen = np.arange(len(transport.mesh.positions)) if vertices is None else vertices
    signed = sum_signed_radiance(transport, rows, np.einsum("nij,ni->nj", transport.frames[chosen], wo), chosen)
    kept, cut = float(np.maximum(signed, 0.0).sum()), float(np.maximum(-signed, 0.0).sum())
    return VertexRadiance(np.maximum(signed, 0.0), cut / kept if kept > 0.0 else 0.0)


def sum_signed_radiance(
    transport: WaveletTransport, rows: NDArray[np.float64], local: Vectors, vertices: NDArray[np.int64]
) -> NDArray[np.float64]:
    """The sums (n, 3; Wang2004 Eq. 4) before clamping, for directions `local` (n, 3) in frames of `vertices` (n,)."""
    terms, first = transport.terms, transport.ground_vertex
    seen = local[:, 2] > 0.0
    value = np.zeros((len(vertices), 3))
    hemisphere_map, model = transport.factors.hemisphere_map, np.flatnonzero(seen & (vertices < first))
    for factors, some in split_by_kind(transport.kind, terms, vertices[model]):
        chosen = model[some]
        tuples = rows[: first * terms].reshape(first, terms, 3)[vertices[chosen]]
        for k, view_map in enumerate(transport.factors.first[factors]):
            value[chosen] += hemisphere_map.look_up(view_map, local[chosen]) * tuples[:, k]
    ground = np.flatnonzero(seen & (vertices >= first))
    value[ground] = rows[first * terms + vertices[ground] - first] * (transport.ground_albedo / math.pi)
    return value


def split_by_kind(
    kind: NDArray[np.int64] | None, terms: int, vertices: NDArray[np.int64]
) -> Iterator[tuple[slice, NDArray[np.int64]]]:
    """The factors of each BRDF, `terms` of them, and which of `vertices` (n,) of the model have it, where any has."""
    if kind is None:
        if len(vertices):
            yield slice(0, terms), np.arange(len(vertices))
        return
    for number in np.unique(kind[vertices]):
        yield slice(number * terms, (number + 1) * terms), np.flatnonzero(kind[vertices] == number)


def vectors_of(arrays: Mapping[str, NDArray[Any]]) -> Vectors16:
    """The vectors in the arrays of a transport file or of `transport_vectors`."""
    return Vectors16(arrays["indices"], arrays["words"], arrays["peaks"], arrays["counts"])
