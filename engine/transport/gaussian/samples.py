"""Tabulated transport that lobes are fitted to: T(w) = f_glossy(w, v) V(w) max(0, n·w) at a vertex towards each view.

Green2006 Sec. 4.1, tabulate over the texels of a cube map. A narrow lobe falls between
them, so directions are drawn here where the BRDF sends them, for every view anew, and a coarse set over the
whole sphere is added, which sees to it that lobes stay off where nothing is reflected. All drawn sets count together:

    ∫ g(w) dw ≈ Σ g(w_s) q_s,   q_s = 1 / Σ_k n_k p_k(w_s)         (the balance heuristic, Veach1997 Sec. 9.2)

The sets are lattices and the same for all vertices in their own frames, so neighbours differ by what they see and not
by chance. T is in 1/sr: radiance towards the view for each unit of radiance and of solid angle.

A bake finds the visibility of all vertices first, over a cube map (`HeldVisibility`), and looks it up along each
direction: the share of the texel, which is 1.4° wide at an edge of 64. Isotropic BRDFs that are the same everywhere are
tabulated once, over the angle of the viewer in steps of 0.09°: then some 0.2 ms for a vertex with 128 directions for
each of 46 views on one core, bound by memory, and 2 ms of other BRDFs, bound by these. Without held visibility a ray is
cast for each direction that reflects anything, which takes another 1.5 ms.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.brdf.brdf import MODELS, Brdf
from engine.brdf.models.sampling import sampler_of
from engine.brdf.models.sampling_lobes import CosineLobe, Mixture, Sampler
from engine.core.budget import thread_count
from engine.core.cached import cached_property
from engine.core.directions import Vectors, surface_direction
from engine.core.errors import UsageError
from engine.geometry.ground import Ground, with_ground
from engine.geometry.mesh import Mesh
from engine.geometry.ray_caster import caster_of, in_chunks
from engine.transport.baking.diffuse_specular import DiffusePart, diffuse_part, parts
from engine.transport.baking.held_visibility import HeldVisibility
from engine.transport.baking.parts import MAX_KINDS, Kinds
from engine.transport.baking.spatially_varying import (
    Variation,
    check_variations,
    vertex_values,
    with_parameters,
)
from engine.transport.baking.visibility import Receivers, receivers
from engine.transport.gaussian.fitting.fit import TransportSamples
from engine.transport.gaussian.fitting.views import VIEWS, view_directions
from engine.transport.gaussian.sample_kernel import place_highlights, shares_along
from engine.transport.sh.transfer import tangent_frames

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
Result = TypeVar("Result")

#: Share of the directions of a view that lie evenly over the sphere.
EVEN = 0.25

#: Steps that parameters which vary over a model are rounded to where light comes from.
LEVELS = 16

#: Steps of the angle between the normal and the viewer that an isotropic highlight is tabulated in.
ANGLES = 1024

#: Pairs of directions that a BRDF is asked for at once, so that it takes no threads of its own.
BLOCK = 8192

#: Steps that turn one number of a lattice into two more: the golden ratio, and the plastic constant's square.
_GOLDEN, _PLASTIC = 0.5 * (np.sqrt(5.0) - 1.0), 0.5698402909980532


@dataclass(frozen=True, eq=False)
class Material:
    """A BRDF cut in two, and where its glossy part sends light.

    `whole` is the sum of `diffuse` and `glossy`, which is None where there is nothing glossy. The directions of its
    highlights are drawn from `lobes` in these `shares`, those of the whole from `sampler`.
    """

    whole: Brdf
    sampler: Sampler
    diffuse: DiffusePart
    glossy: Brdf | None
    lobes: tuple[Sampler, ...]
    shares: tuple[float, ...]


def material_of(brdf: Brdf) -> Material:
    """`brdf` in its parts; some 20 µs for analytic models, 0.1 s for measurements."""
    diffuse, glossy = parts(brdf)
    mixture = sampler_of(brdf)
    if glossy is None or not isinstance(mixture, Mixture) or len(mixture.lobes) < 2:
        return Material(brdf, mixture, diffuse, glossy, (CosineLobe(),), (1.0,))
    rest = 1.0 - mixture.shares[0]
    shares = tuple(share / rest for share in mixture.shares[1:])
    return Material(brdf, mixture, diffuse, glossy, mixture.lobes[1:], shares)


@dataclass(frozen=True, eq=False)
class GlossySurface:
    """A model with what transport at its vertices takes; the vertices of a ground after them are diffuse.

    Attributes
    ----------
    mesh : the model and its ground, whose first vertex is `ground_vertex`.
    ground_albedo : of the ground.
    brdf : of the model; `varied` moves some of its parameters from vertex to vertex.
    varied : for each such parameter its values (ground_vertex,).
    kinds : BRDFs of the parts of the model in place of `brdf`; None where it is of one.
    of : the vertices as receivers of light. frames : (V, 3, 3) with columns tangent, bitangent, normal.
    seen : what the vertices see, in place of rays for direct light; None where that has not been found.
    """

    mesh: Mesh
    ground_vertex: int
    ground_albedo: float
    brdf: Brdf
    varied: dict[str, Floats]
    of: Receivers
    frames: Vectors
    seen: HeldVisibility | None = None
    kinds: Kinds | None = None

    @property
    def is_uniform(self) -> bool:
        """True if the model has one BRDF all over."""
        return not self.varied and self.kinds is None

    @cached_property
    def material(self) -> Material:
        """That of `brdf` itself."""
        return material_of(self.brdf)

    @cached_property
    def materials(self) -> list[Material]:
        """Those of the BRDFs of the parts, or the one of `brdf`."""
        return [self.material] if self.kinds is None else [material_of(brdf) for brdf in self.kinds.brdfs]

    def material_at(self, vertex: int) -> Material:
        """That of a vertex of the model."""
        if self.kinds is not None:
            return self.materials[self.kinds.number[vertex]]
        if not self.varied:
            return self.material
        return material_of(
            with_parameters(self.brdf, {name: float(values[vertex]) for name, values in self.varied.items()})
        )

    @cached_property
    def exact(self) -> tuple[Indices, list[DiffusePart]]:
        """For each vertex of the model the number of a diffuse part, and these."""
        if self.kinds is not None:
            return self.kinds.number, [material.diffuse for material in self.materials]
        if not self.varied:
            return np.zeros(self.ground_vertex, np.int64), [self.material.diffuse]
        kind, made = self._kinds(list(self.varied.values()))
        return kind, [diffuse_part(brdf) for brdf in made]

    @cached_property
    def coarse(self) -> tuple[Indices, list[Material]]:
        """For each vertex of the model the number of a material, and these, with parameters rounded to `LEVELS` steps.

        For light that comes by way of the model, where a material for every vertex would cost more than it shows.
        """
        if self.kinds is not None:
            return self.kinds.number, self.materials
        if not self.varied:
            return np.zeros(self.ground_vertex, np.int64), [self.material]
        rounded = []
        for values in self.varied.values():
            low, size = values.min(), max(float(np.ptp(values)), 1e-300)
            rounded.append(low + np.round((values - low) / size * (LEVELS - 1)) / (LEVELS - 1) * size)
        kind, made = self._kinds(rounded)
        return kind, [material_of(brdf) for brdf in made]

    def _kinds(self, values: Sequence[Floats]) -> tuple[Indices, list[Brdf]]:
        """Number of the parameter set of each vertex, and the BRDFs that these sets make."""
        kinds, number = np.unique(np.stack(values, axis=1), axis=0, return_inverse=True)
        made = [with_parameters(self.brdf, dict(zip(self.varied, kind.tolist(), strict=True))) for kind in kinds]
        return number.reshape(-1), made

    @cached_property
    def guard(self) -> AbstractContextManager[Any]:
        """To be held while the BRDF works: measurements use all threads, and not every pool lets two in."""
        brdfs = (self.brdf,) if self.kinds is None else self.kinds.brdfs
        return nullcontext() if all(type(brdf) in MODELS.values() for brdf in brdfs) else threading.Lock()


def glossy_surface(
    mesh: Mesh,
    brdf: Brdf,
    ground: Ground | None = None,
    variations: Sequence[Variation] = (),
    kinds: Kinds | None = None,
) -> GlossySurface:
    """A model, on a ground where there is one; ValueError for `variations` that `brdf` does not have.

    With `kinds`, each part has its BRDF; UsageError where some are cut in two in another way than the others.
    """
    varied = {
        variation.parameter: variation.at(vertex_values(mesh, variation.source))
        for variation in check_variations(brdf, variations)
    }
    surface = mesh if ground is None else with_ground(mesh, ground)[0]
    made = model_on_ground(surface, len(mesh.positions), ground.albedo if ground else 0.0, brdf, varied)
    if kinds is None:
        return made
    made = replace(made, brdf=kinds.brdfs[0], kinds=kinds)
    if len({material.diffuse.grazing for material in made.materials}) > 1:
        raise UsageError(
            "Gaussians cannot bake parts of which only some have an Ashikhmin-Shirley BRDF; choose --mode sh or wavelet"
        )
    return made


def model_on_ground(
    surface: Mesh, first: int, ground_albedo: float, brdf: Brdf, varied: dict[str, Floats]
) -> GlossySurface:
    """As `glossy_surface`, of a model with its ground, whose first vertex is `first`."""
    of = receivers(surface, caster_of(surface))
    return GlossySurface(surface, first, ground_albedo, brdf, varied, of, tangent_frames(surface))


@dataclass(frozen=True, eq=False)
class Drawn:
    """Samples towards some views: world `direction` (M, S, 3), T `value` (M, S, 3), and `weight` (M, S) in sr.

    The sum of value times weight is the integral of T over the sphere.
    """

    direction: Vectors
    value: Floats
    weight: Floats


@lru_cache(maxsize=16)
def lattice(count: int) -> Floats:
    """(count, 3) numbers in [0, 1) that lie evenly in the last two, and in all three."""
    index = np.arange(count)
    return np.column_stack([(index + 0.5) * _PLASTIC % 1.0, (index + 0.5) / count, (index + 0.5) * _GOLDEN % 1.0])


@lru_cache(maxsize=16)
def even_directions(count: int) -> Vectors:
    """(count, 3) unit vectors in a spiral from pole to pole, each for the same solid angle."""
    index = np.arange(count) + 0.5
    z, phi = 1.0 - 2.0 * index / count, 2.0 * np.pi * _GOLDEN * index
    across = np.sqrt(1.0 - z * z)
    return np.column_stack([across * np.cos(phi), across * np.sin(phi), z])


def numbers_of(shares: Sequence[float], count: int) -> tuple[int, list[int]]:
    """Number of the `count` directions that are spread evenly, and number for each lobe: one at least."""
    even = max(1, round(EVEN * count))
    edges = np.round(np.concatenate([[0.0], np.cumsum(shares)]) * (count - even - len(shares))).astype(np.int64)
    return even, (np.diff(edges) + 1).tolist()


def draw_local(material: Material, wo: Vectors, count: int) -> tuple[Vectors, Floats]:
    """Directions (M, S, 3) towards light for viewers `wo` (M, 3), in the surface frame, and weights (M, S) in sr.

    The first ones are spread evenly over the sphere.
    """
    even, numbers = numbers_of(material.shares, count)
    spread = even_directions(even)
    towards = [np.broadcast_to(spread, (len(wo), even, 3))]
    for lobe, number in zip(material.lobes, numbers, strict=True):
        viewer = np.repeat(wo, number, axis=0)
        drawn = lobe.sample(viewer, np.tile(lattice(number), (len(wo), 1)))
        towards.append(drawn.reshape(len(wo), number, 3))
    wi = np.concatenate(towards, axis=1)
    density = density_local(material, wi.reshape(-1, 3), np.repeat(wo, wi.shape[1], axis=0), count)
    return wi, (1.0 / density).reshape(wi.shape[:2])


def density_local(material: Material, wi: Vectors, wo: Vectors, count: int) -> Floats:
    """(N,) how many of the `count` directions that `draw_local` makes for a viewer lie at each `wi` (N, 3), per sr."""
    even, numbers = numbers_of(material.shares, count)
    density = np.full(len(wi), even / (4.0 * np.pi))
    for lobe, number in zip(material.lobes, numbers, strict=True):
        density += number * np.nan_to_num(lobe.pdf(wi, wo), nan=0.0, posinf=1e30)
    return density


def draw(surface: GlossySurface, vertex: int, views: Vectors, count: int) -> Drawn:
    """Unoccluded transport of a vertex towards world `views` (M, 3) above its horizon, `count` directions each."""
    frame, material = surface.frames[vertex], surface.material_at(vertex)
    wo = views @ frame
    with surface.guard:
        wi, weight = draw_local(material, wo, count)
        value = products(material.glossy, wi.reshape(-1, 3), np.repeat(wo, count, axis=0))
    return Drawn(wi @ frame.T, value.reshape(wi.shape), weight)


def products(glossy: Brdf | None, wi: Vectors, wo: Vectors) -> Floats:
    """f cos θ_i (N, 3) of the glossy part."""
    value = np.zeros(wi.shape)
    if glossy is not None:
        for start in range(0, len(wi), BLOCK):
            block = slice(start, start + BLOCK)
            value[block] = glossy.f(wi[block], wo[block]) * np.maximum(wi[block, 2:], 0.0)
    return value


def combine_shadowed(surface: GlossySurface, vertex: int, drawn: Drawn) -> NDArray[np.bool_]:
    """(M, S) whether something stands in the way; False where nothing is reflected anyway."""
    hidden = np.zeros(drawn.weight.shape, np.bool_)
    if surface.of.free[vertex]:
        return hidden
    asked = drawn.value.any(axis=-1)
    direction = drawn.direction[asked]
    origin = np.broadcast_to(surface.of.origin[vertex], direction.shape)
    hidden[asked] = surface.of.caster.occluded(origin, direction)
    return hidden


def direct(surface: GlossySurface, vertex: int, views: Vectors, count: int) -> Drawn:
    """Direct glossy transport (Green2006 Eq. 2) of a vertex towards world `views` (M, 3) above its horizon."""
    drawn = draw(surface, vertex, views, count)
    drawn.value[combine_shadowed(surface, vertex, drawn)] = 0.0
    return drawn


def direct_samples(surface: GlossySurface, vertices: Indices, count: int) -> TransportSamples:
    """Direct glossy transport of `vertices` (B,) of the model towards the 92 views, `count` directions for each."""
    if surface.seen is None:
        return gather(on_threads(lambda vertex: _mask_vertex(surface, vertex, count), vertices))
    counts = surface.seen.counts(vertices)
    is_isotropic = surface.brdf.isotropic if surface.kinds is None else surface.kinds.isotropic
    if is_isotropic and not surface.varied:
        return _place_table(surface, vertices, counts, count)
    rows = dict(zip(vertices.tolist(), counts, strict=True))
    return gather(on_threads(lambda vertex: _look_up_vertex(surface, vertex, rows[vertex], count), vertices))


def _place_table(surface: GlossySurface, vertices: Indices, counts: NDArray[np.uint8], count: int) -> TransportSamples:
    """Samples from the tables of the highlights, where visibility is `counts` (B, 6 edge²)."""
    seen, views = surface.seen, view_directions()
    assert seen is not None
    with surface.guard:
        tables = [highlight_table(material, count) for material in surface.materials]
    kind = np.zeros(surface.ground_vertex, np.int64) if surface.kinds is None else surface.kinds.number
    above = surface.frames[vertices, :, 2] @ views.T > 0.0
    start = np.concatenate([[0], np.cumsum(np.where(above, count, 0))]).astype(np.int64)
    direction, value, area = np.empty((start[-1], 3)), np.empty((start[-1], 3)), np.empty(start[-1])

    def work(rows: slice) -> None:
        for number in range(rows.start, min(rows.stop, len(vertices))):
            vertex, own = vertices[number], slice(start[VIEWS * number], start[VIEWS * (number + 1)])
            free, frame = bool(surface.of.free[vertex]), surface.frames[vertex]
            place_highlights(
                tables[kind[vertex]], views, above[number], frame, free, counts[number], seen.edge, seen.fine,
                direction[own], value[own], area[own],
            )  # fmt: skip

    in_chunks(work, len(vertices), 8)
    return TransportSamples(start, direction, value, area)


@lru_cache(maxsize=MAX_KINDS)
def highlight_table(material: Material, count: int) -> tuple[Vectors, Floats, Floats]:
    """Directions, values and areas of the glossy part of an isotropic BRDF, as `place_highlights` takes them."""
    theta = (np.arange(ANGLES) + 0.5) / ANGLES * (0.5 * np.pi)
    wo = surface_direction(theta, 0.0)
    wi, weight = draw_local(material, wo, count)
    value = np.maximum(products(material.glossy, wi.reshape(-1, 3), np.repeat(wo, count, axis=0)), 0.0)
    return np.ascontiguousarray(wi), value.reshape(wi.shape), weight


def _look_up_vertex(
    surface: GlossySurface, vertex: int, counts: NDArray[np.uint8], count: int
) -> tuple[NDArray[np.bool_], Drawn]:
    """As `_mask_vertex`, where visibility is `counts` (6 edge²,)."""
    views, seen = view_directions(), surface.seen
    assert seen is not None
    above = views @ surface.frames[vertex, :, 2] > 0.0
    drawn = draw(surface, vertex, views[above], count)
    if not surface.of.free[vertex]:
        shares = np.empty(drawn.weight.shape)
        normal = np.ascontiguousarray(surface.frames[vertex, :, 2])
        flat = np.ascontiguousarray(drawn.direction.reshape(-1, 3))
        shares_along(flat, normal, counts, seen.edge, seen.fine, shares.reshape(-1))
        drawn.value[:] *= shares[..., None]
    return above, drawn


def on_threads(work: Callable[[int], Result], vertices: Indices) -> list[Result]:
    """`work` for each of `vertices`, in their order, on as many threads as there are cores."""
    if len(vertices) < 2:
        return [work(int(vertex)) for vertex in vertices]
    with ThreadPoolExecutor(min(len(vertices), thread_count())) as pool:
        return list(pool.map(work, vertices.tolist()))


def _mask_vertex(surface: GlossySurface, vertex: int, count: int) -> tuple[NDArray[np.bool_], Drawn]:
    """Mask of the 92 views that see a vertex, and its transport towards these."""
    views = view_directions()
    above = views @ surface.frames[vertex, :, 2] > 0.0
    return above, direct(surface, vertex, views[above], count)


def gather(found: Sequence[tuple[NDArray[np.bool_], Drawn]]) -> TransportSamples:
    """Samples of one vertex after the other: which views (92,) have any, and what was drawn towards these."""
    counts = [np.where(above, drawn.weight.shape[1], 0) for above, drawn in found]
    start = np.concatenate([[0], np.cumsum(np.concatenate(counts))]) if counts else np.zeros(1, np.int64)
    return TransportSamples(
        start.astype(np.int64),
        np.concatenate([drawn.direction.reshape(-1, 3) for _, drawn in found]),
        np.maximum(np.concatenate([drawn.value.reshape(-1, 3) for _, drawn in found]), 0.0),
        np.concatenate([drawn.weight.reshape(-1) for _, drawn in found]),
    )


def transport_at(surface: GlossySurface, vertex: int, view: ArrayLike, direction: ArrayLike) -> Floats:
    """T (..., 3) of a vertex of the model towards the world `view` (3,) at unit world vectors `direction` (..., 3).

    What `direct` tabulates, wherever it is asked for: for plots, and for sums over the texels of a cube map.
    """
    towards = np.asarray(direction, np.float64)
    flat, frame = towards.reshape(-1, 3), surface.frames[vertex]
    wo = np.asarray(view, np.float64) @ frame
    if wo[2] <= 0.0:
        return np.zeros(towards.shape)
    with surface.guard:
        value = products(surface.material_at(vertex).glossy, flat @ frame, np.broadcast_to(wo, flat.shape))
    drawn = Drawn(flat[None], value[None], np.ones((1, len(flat))))
    value[combine_shadowed(surface, vertex, drawn)[0]] = 0.0
    return value.reshape(towards.shape)
