"""Self-shadowed transport in spherical harmonics (Kautz2002 Sec. 5; Sloan2002).

A receiver that shows every view something else has a matrix for each vertex,

    M_ij = ∫ y_i(s) V(s) y_j(R s) ds,          light at the vertex, in its own frame = M L,

with the rotation R from the tangent frame folded in. A Lambertian one has a vector, t_j = ∫ V(s) cos θ y_j(R s) ds / π.
f cos θ is 0 below the horizon, so V means nothing there. We take it as a mirror would show it: V(s) = V(s mirrored at
the tangent plane). An open point then has exactly the rotation, a closed one exactly 0, and no edge at the horizon
rings. In the frame of the vertex, with v the spherical harmonics of V above the horizon, of order 2 n − 1,

    M_ij = Σ_k 2 v_k ∫ y_i y_j y_k          over those k that are even in z; the others cancel.

So a bake sums V over the texels of a cube map into (2 n − 1)² numbers, one matrix product for many vertices, and
expands them by a sparse table of triple products. Light from other parts of the model is added to the same matrices.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any, TypeGuard

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.brdf.models.diffuse import Lambert
from engine.core.cached import cached_property
from engine.core.directions import Vectors, frames_along, normalize
from engine.core.errors import UsageError
from engine.geometry.mesh import Mesh
from engine.light.cube_map import cube_directions, cube_solid_angles, direction_on_face
from engine.transport.sh import kernel as sh_kernel
from engine.transport.sh.basis import bands, check_order, cosine_zonal, evaluate, order_of, turn_zonal
from engine.transport.sh.brdf_table_varying import Table, VariedTable
from engine.transport.sh.rotation import rotate_from_frames, rotate_into_frames

if TYPE_CHECKING:
    pass

Floats = NDArray[np.floating[Any]]
Counts = NDArray[np.unsignedinteger[Any]]

#: Matrices are rounded to multiples of this power of two, which take less than a third of the bytes in a file; the rows
#: of a point that sees the whole sky have length 1.
STEP = 2.0**-12

#: Rows whose squares are summed at once.
ROWS = 1 << 15


@dataclass(frozen=True, eq=False)
class ShTransport:
    """SH transport of every vertex, before there is light.

    Attributes
    ----------
    mesh : model, and after it the ground where there is one; `ground_vertex` is the first vertex of the ground.
    diffuse : whether the vertices of the model have a vector like those of the ground, and not a matrix.
    ground_albedo : of the ground.
    table : of the model's BRDF, which may vary over its vertices.
    interreflection : whether `rows` hold light from other parts of the model, which fixes the BRDF.
    rows : (R, C, order²) float32: order² for each vertex of the model, the rows of its matrix, or 1 where it is
        diffuse; then 1 for each vertex of the ground. C is 3 where bounced light is coloured, else 1.
    """

    mesh: Mesh
    ground_vertex: int
    diffuse: bool
    ground_albedo: float
    table: Table
    interreflection: bool
    rows: NDArray[np.float32]

    def __post_init__(self) -> None:
        count = row_count(len(self.mesh.positions), self.ground_vertex, 1 if self.diffuse else self.table.order**2)
        if self.rows.ndim != 3 or len(self.rows) != count or self.rows.shape[1] not in (1, 3):
            raise ValueError(f"rows of the shape {self.rows.shape} do not belong to these vertices, which need {count}")
        if self.rows.shape[2] != self.table.order**2:
            raise ValueError(f"rows of {self.rows.shape[2]} coefficients do not fit a table of {self.table.order**2}")
        if self.diffuse and not self.table.diffuse:
            raise ValueError("vectors serve Lambertian reflectances only")
        if isinstance(self.table, VariedTable) and len(self.table.numbers) != self.ground_vertex:
            raise ValueError(f"{len(self.table.numbers)} vertices vary, but the model has {self.ground_vertex}")

    @property
    def order(self) -> int:
        return self.table.order

    @cached_property
    def frames(self) -> Vectors:
        """(V, 3, 3) with columns tangent, bitangent, normal."""
        return tangent_frames(self.mesh)

    @property
    def albedo(self) -> NDArray[np.float64]:
        """(3,) of the model where it is diffuse, or (V, 3) where it varies."""
        return self.table.even_albedo


def round_rows(rows: NDArray[np.float32]) -> NDArray[np.float32]:
    """`rows` rounded to multiples of `STEP`; none is −0."""
    return np.rint(rows / np.float32(STEP)) * np.float32(STEP) + np.float32(0.0)


def rounding_error_rel(rows: NDArray[np.float32], step: float) -> float:
    """Root mean square error of `rows` that were rounded to multiples of `step`, over that of the rows themselves.

    Errors are alike within ± half a step (variance step²/12). The rows may lie in a file: few are taken at once.
    """
    parts = (rows[start : start + ROWS] for start in range(0, len(rows), ROWS))
    mean = sum(float(np.sum(np.square(some, dtype=np.float64))) for some in parts) / max(rows.size, 1)
    return step / math.sqrt(12.0 * mean) if mean > 0.0 else 0.0


def tangent_frames(mesh: Mesh) -> Vectors:
    """Frames (V, 3, 3) along the texture, which brushed and isotropic BRDFs can share."""
    return frames_along(normalize(mesh.normals), mesh.tangents)


def row_count(vertices: int, first: int, rows: int) -> int:
    return first * rows + vertices - first


@lru_cache(maxsize=4)  # orders that are baked together
def texel_basis(edge: int, order: int) -> NDArray[np.float32]:
    """(6 N², order²) integrals of the basis over the texels of a cube map, by Gauss's rule in each."""
    nodes = max(2, math.ceil(3 * check_order(order) / edge) + 1)
    at, share = np.polynomial.legendre.leggauss(nodes)
    place = (np.arange(edge)[:, None] + 0.5 + 0.5 * at) / edge
    s = np.broadcast_to(place[None, :, None, :], (edge, edge, nodes, nodes))
    t = np.broadcast_to(place[:, None, :, None], (edge, edge, nodes, nodes))
    front = direction_on_face(np.full(s.shape, 4), s, t)
    weight = np.outer(share, share) * front[..., 2] ** 3
    weight *= (cube_solid_angles(edge) / weight.sum(axis=(2, 3)))[..., None, None]
    basis = np.empty((6, edge, edge, order**2), np.float32)
    for face in range(6):
        for row in range(edge):
            points = direction_on_face(np.full(s.shape[1:], face), s[row], t[row])
            basis[face, row] = np.einsum("cijk,cij->ck", evaluate(order, points), weight[row])
    return basis.reshape(-1, order**2)


@dataclass(frozen=True, eq=False)
class Products:
    """Integrals of y_i y_j y_k that are not 0, for i ≤ j of order n and k of order 2 n − 1 that are even in z.

    Pair p is (`first[p]`, `second[p]`), and its terms are `index[start[p] : start[p + 1]]` with their `weight`.
    """

    first: NDArray[np.int64]
    second: NDArray[np.int64]
    start: NDArray[np.int64]
    index: NDArray[np.int64]
    weight: NDArray[np.float64]


def even_in_z(order: int) -> NDArray[np.bool_]:
    """(order²,) whether y_lm stays what it is where z changes its sign: where l + m is even."""
    band = bands(order)
    return np.asarray((np.arange(order**2) - band * band) % 2 == 0)


@lru_cache(maxsize=4)  # orders that are baked together
def products(order: int) -> Products:
    """The table of `Products`, by quadrature that is exact; 5 s at order 15, once."""
    higher = 2 * check_order(order) - 1
    z, share = np.polynomial.legendre.leggauss(2 * order)
    turns = 4 * order - 2
    phi = 2.0 * np.pi * np.arange(turns) / turns
    across = np.sqrt(1.0 - z * z)[:, None]
    points = np.stack(np.broadcast_arrays(across * np.cos(phi), across * np.sin(phi), z[:, None]), axis=-1)
    basis = evaluate(higher, points.reshape(-1, 3))
    kept = np.flatnonzero(even_in_z(higher))
    right = basis[:, kept] * np.repeat(share * 2.0 * np.pi / turns, turns)[:, None]
    even, pairs = even_in_z(order), []
    lengths: list[NDArray[np.int64]] = []
    index, weight = [], []
    for i in range(order**2):
        partners = np.flatnonzero(even == even[i])
        partners = partners[partners >= i]
        sums = (basis[:, partners] * basis[:, i, None]).T @ right
        where = np.abs(sums) > 1e-12
        pairs.append(np.stack([np.full(len(partners), i), partners]))
        lengths.append(where.sum(axis=1))
        index.append(kept[np.nonzero(where)[1]])
        weight.append(sums[where])
    first, second = np.concatenate(pairs, axis=1)
    start = np.append(0, np.cumsum(np.concatenate(lengths)))
    return Products(first, second, start, np.concatenate(index), np.concatenate(weight))


def visibility_harmonics(counts: Counts, full: int, edge: int, order: int) -> NDArray[np.float32]:
    """(B, order²) world coefficients of V, from how many of the `full` parts of each texel are seen (B, 6 N²)."""
    shares = counts.astype(np.float32) * np.float32(1.0 / full)
    return np.asarray(shares @ texel_basis(edge, order), np.float32)


def matrices(seen: NDArray[np.float32], frames: Vectors, free: NDArray[np.bool_]) -> NDArray[np.float32]:
    """(B, n, n) transfer matrices from the spherical harmonics of visibility above the horizon, (B, (2 order − 1)²).

    `free` vertices (B,) see everything: their matrices are rotations.
    """
    higher = order_of(seen.shape[1])
    order = (higher + 1) // 2
    local = 2.0 * rotate_into_frames(np.asarray(seen, np.float64)[..., None], frames)[..., 0]
    local[free] = 0.0
    local[free, 0] = math.sqrt(4.0 * math.pi)
    table = products(order)
    own = np.zeros((len(seen), order**2, order**2), np.float32)
    sh_kernel.expand(local, table.first, table.second, table.start, table.index, table.weight, own)
    return np.ascontiguousarray(rotate_from_frames(own, frames).swapaxes(1, 2))


def diffuse_vectors(
    counts: Counts,
    full: int,
    edge: int,
    order: int,
    normals: Vectors,
    free: NDArray[np.bool_],
) -> NDArray[np.float32]:
    """(B, n) transfer to irradiance / π of vertices with these `normals` (B, 3); world coefficients."""
    directions = cube_directions(edge).reshape(-1, 3).astype(np.float32)
    shares = counts.astype(np.float32) * np.float32(1.0 / (full * np.pi))
    shares *= np.maximum(normals.astype(np.float32) @ directions.T, 0.0)
    vectors = np.asarray(shares @ texel_basis(edge, order), np.float32)
    vectors[free] = free_vectors(order, normals[free])
    return vectors


def free_vectors(order: int, normals: Vectors) -> NDArray[np.float32]:
    """(B, n) the same of vertices that see their whole hemisphere: the cosine's SH about each normal."""
    return turn_zonal(cosine_zonal(order) / np.pi, normals).astype(np.float32)


def transfer(transport: ShTransport, light: ArrayLike) -> NDArray[np.float32]:
    """(R, 3) what the rows make of `light`: coefficients in the vertices' frames, or irradiance / π.

    `light` is (order², 3) for all vertices, or (V, order², 3) for each where lamps are near. Raises ValueError for
    light of another order (H12). Bound by reading the rows once.
    """
    coefficients = np.ascontiguousarray(light, np.float32)
    own, shape = coefficients.ndim == 3, (transport.order**2, 3)
    if coefficients.shape != ((len(transport.mesh.positions), *shape) if own else shape):
        raise ValueError(f"light of the shape {coefficients.shape} does not fit transport of order {transport.order}")
    result = np.empty((len(transport.rows), 3), np.float32)
    if not own:
        sh_kernel.transfer(transport.rows, coefficients, result)
        return result
    first, count = transport.ground_vertex, 1 if transport.diffuse else transport.order**2
    model, ground = slice(0, first * count), slice(first * count, None)
    sh_kernel.transfer_each(transport.rows[model], coefficients[:first], count, result[model])
    sh_kernel.transfer_each(transport.rows[ground], coefficients[first:], 1, result[ground])
    return result


def compute_unshadowed(mesh: Mesh, light: Floats) -> Floats:
    """(V, order², 3) `light` (order², 3) in the frames of the vertices: what transfer without shadows would give."""
    return rotate_into_frames(light, tangent_frames(mesh))


def sum_signed_radiance(
    transport: ShTransport, rows: Floats, local: Vectors, vertices: NDArray[np.int64]
) -> NDArray[np.float64]:
    """Sums (n, 3), before they are clamped, for directions `local` (n, 3) in the frames of `vertices` (n,).

    `rows` are those of `transfer`; 0 for views from behind.
    """
    first, count = transport.ground_vertex, 1 if transport.diffuse else transport.order**2
    seen = local[:, 2] > 0.0
    value = np.zeros((len(vertices), 3))
    model = np.flatnonzero(seen & (vertices < first))
    if transport.diffuse:
        value[model] = rows[vertices[model]] * np.broadcast_to(transport.albedo, (first, 3))[vertices[model]]
    elif model.size:
        light = rows[: first * count].reshape(first, count, 3)[vertices[model]]
        value[model] = transport.table.radiance(light, local[model], vertices[model])
    ground = np.flatnonzero(seen & (vertices >= first))
    value[ground] = rows[first * count + vertices[ground] - first] * transport.ground_albedo
    return value


def local_views(transport: ShTransport, eye: ArrayLike) -> Vectors:
    """(V, 3) unit directions from the vertices to the point `eye` (3,), in their frames."""
    wo = normalize(np.asarray(eye, np.float64) - transport.mesh.positions)
    return np.asarray(np.einsum("vij,vi->vj", transport.frames, wo))


def view_vectors(transport: ShTransport, local: Vectors) -> NDArray[np.float32]:
    """(V, 3, order²) what each vertex sends towards `local` (V, 3) under light: radiance = their product with it.

    The paper's fixed view: the BRDF is rotated into the world once, and a new light is a product of order²
    numbers for each vertex.
    """
    first, count = transport.ground_vertex, 1 if transport.diffuse else transport.order**2
    vectors = np.zeros((len(local), 3, transport.order**2), np.float32)
    vectors[first:] = transport.rows[first * count :] * np.float32(transport.ground_albedo)
    if transport.diffuse:
        vectors[:first] = transport.rows[:first] * transport.albedo.astype(np.float32)[..., None]
    else:
        own = transport.rows[: first * count].reshape(first, count, *transport.rows.shape[1:])
        sh_kernel.view(own, transport.table.at(local[:first], np.arange(first)), vectors[:first])
    vectors[local[:, 2] <= 0.0] = 0.0
    return vectors


def with_table(transport: ShTransport, table: Table) -> ShTransport:
    """The same transport of another BRDF; UsageError, with the reason, where it has to be baked again."""
    if transport.interreflection:
        raise UsageError("interreflection was baked for one BRDF")
    if transport.diffuse and not table.diffuse:
        raise UsageError("a diffuse model was baked as vectors, which do not depend on the view")
    if table.order < transport.order:
        raise UsageError(f"a table of order {table.order} does not fit transport of order {transport.order}")
    return ShTransport(
        transport.mesh,
        transport.ground_vertex,
        transport.diffuse,
        transport.ground_albedo,
        table.reduce_order(transport.order),
        transport.interreflection,
        transport.rows,
    )


def is_diffuse(brdf: object) -> TypeGuard[Lambert]:
    """True for Lambert's BRDF, which vectors represent; not so for what is derived from it."""
    return type(brdf) is Lambert
