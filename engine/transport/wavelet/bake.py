"""Baking wavelet transport: visibility by rays, then the vectors of all terms, chunk by chunk into a file.

For each vertex: which parts of the texels of a cube map see the sky (`visibility`, finer where that changes), times
light map, cosine and solid angle, transformed and cut to the strongest coefficients (`wavelet.kernel`). A chunk is
some 85 vertices; what an interrupted bake has done is found again in its unfinished file. Bound by the rays: some
12,000 for each vertex at an edge of 64, and more where shadows end.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.brdf.brdf import MODELS, Brdf
from engine.core.errors import UsageError
from engine.core.figure_text import count_text, size_text
from engine.core.params import check_values
from engine.core.steps import Step, Steps, part
from engine.factor.errors import Reference, reference
from engine.factor.hemisphere_map import HemisphereMap, MapKind
from engine.factor.normalised import normalise
from engine.factor.separable import Weighting, separate
from engine.factor.separable_factors import SeparableFactors
from engine.geometry.ground import Ground, with_ground
from engine.geometry.mesh import Mesh
from engine.geometry.ray_caster import RayCaster, caster_of
from engine.transport.baking.blend import Mixture
from engine.transport.baking.carried_visibility import Carrier, Task, carry
from engine.transport.baking.chunks import Chunk, Recipe, Remote, fill
from engine.transport.baking.chunks import estimate_s as estimate_chunks_s
from engine.transport.baking.file import (
    TransportFile,
    TransportPlan,
    TransportWriter,
    open_transport,
    plan_transport,
    read_as,
    writing,
)
from engine.transport.baking.occluder import Occluder, simplify
from engine.transport.baking.parts import Kinds, parts_in, text_of
from engine.transport.baking.settings import Signs, WaveletSettings
from engine.transport.baking.visibility import Receivers, portion, receivers, visibility_shares
from engine.transport.baking.visibility_record import is_kept, keep_visibility
from engine.transport.wavelet.haar import FACES, check_edge
from engine.transport.wavelet.interreflection import Surroundings, gather_reflections, make_full_bounce
from engine.transport.wavelet.quantise import STEP
from engine.transport.wavelet.transfer import (
    DIFFUSE,
    WaveletTransport,
    check_factors,
    check_mixture,
    cube_texels,
    light_maps,
    split_by_kind,
    transport_vectors,
    vectors_of,
    vertex_frames,
)

KIND = "wavelet"

#: Texels a side of the maps of factors that are made for a bake.
MAP_SIZE = 48

#: Terms that are made at least, of which a bake takes the first.
NESTED = 8

#: Share of the light below zero up to which signed terms are taken as they are, and linear error of non-negative ones,
#: over that of signed ones, up to which these are taken in their place.
MAX_BELOW_ZERO, MORE_ERROR = 1e-4, 1.05

#: Visibility counts of a chunk of the file, roughly.
CHUNK_TEXELS = 1 << 21


@dataclass(frozen=True)
class BakeSettings:
    """Settings of a bake; ValueError for impossible ones.

    Attributes
    ----------
    edge : texels along an edge of the cube maps of light: 16, 32 or 64 (smaller powers of two too).
    coefficients : kept for each vector at most.
    fine : into fine² parts a texel is cut where visibility changes; 1 leaves it whole.
    occluder_cells : cells of the grid in which what casts shadows is simplified (`occluder`); 0 for the model itself.
    bounces : reflections between parts of the model on the way of light, 0 … 16; gather : rays of each.
    """

    edge: int = WaveletSettings.cube
    coefficients: int = WaveletSettings.coefficients
    fine: int = WaveletSettings.fine
    occluder_cells: int = WaveletSettings.occluder_cells
    bounces: int = 0
    gather: int = 256

    def __post_init__(self) -> None:
        check_edge(self.edge)
        if not (0 <= self.bounces <= 16 and 16 <= self.gather <= 1 << 16):
            raise UsageError(f"{self.bounces} bounces (0 … 16) of {self.gather} rays (16 … 65536) are not possible")
        check_values(
            WaveletSettings, coefficients=self.coefficients, fine=self.fine, occluder_cells=self.occluder_cells
        )


@dataclass(frozen=True, eq=False)
class Work:
    """A bake that is ready to begin: what was asked for, and how large its file will be.

    `surface` is the model with its ground, whose first vertex is `ground_vertex`; `occluder` is what shades it; `kept`
    is the folder of records of visibility, if there is one.
    """

    surface: Mesh
    ground_vertex: int
    factors: SeparableFactors
    ground_albedo: float
    settings: BakeSettings
    occluder: Occluder
    plan: TransportPlan
    mixture: Mixture | None = None
    kept: Path | None = None
    kinds: Kinds | None = None

    @property
    def kind(self) -> NDArray[np.int64] | None:
        """(ground_vertex,) the BRDF of each vertex of the model, where its parts have their own."""
        return None if self.kinds is None else self.kinds.number

    @property
    def count(self) -> int:
        """Number of these BRDFs, 1 where there is one."""
        return 1 if self.kinds is None else len(self.kinds.brdfs)

    @property
    def terms(self) -> int:
        """Rows of a vertex of the model."""
        return self.factors.terms // self.count

    @property
    def vertices(self) -> int:
        return len(self.surface.positions)

    @property
    def size_bytes(self) -> int:
        return self.plan.size_bytes


@dataclass(frozen=True, eq=False)
class Baked:
    """An open transport and what it took: seconds in all and for visibility alone, chunks and vertices spared."""

    transport: WaveletTransport
    file: TransportFile
    bake_s: float
    visibility_s: float
    resumed_chunks: int
    chunks: int
    unoccluded_vertices: int


def factors_for(
    brdf: Brdf,
    terms: int,
    *,
    kind: MapKind = "orthographic",
    weighting: Weighting = "auto",
    signs: Signs = "auto",
) -> Steps[SeparableFactors]:
    """The factors of `brdf` that a bake takes: its own where it is one, otherwise up to `terms` new ones.

    ValueError where the factors are over half and difference vectors.
    """
    return (yield from factors_of_each(brdf, (terms,), kind=kind, weighting=weighting, signs=signs))[terms]


def factors_of_each(
    brdf: Brdf,
    counts: Sequence[int],
    *,
    kind: MapKind = "orthographic",
    weighting: Weighting = "auto",
    signs: Signs = "auto",
) -> Steps[dict[int, SeparableFactors]]:
    """The same for several numbers of terms, in one decomposition.

    They are the first terms of the same ones, at least `NESTED` of which choose the norm: a norm for each number may
    let more terms be worse. Of a measurement, whose highlights may lie between the texels of a map, more may be worse
    in images although they meet the matrix better: then these are left out. A single term is the better of the first
    and Kautz and McCool's normalised term, by their errors in most bands of the viewer's elevation.

    All colours have the same light maps, so that a bake takes no more time and bytes than that of a grey BRDF; errors
    of GGX metals and paints are 0.2 % larger than with maps for each.

    These are `signed`: sums that are negative in places, which are drawn black. In their place come `nonnegative` ones
    of as many terms, which are not nested; `auto` takes them where the others are negative, the product of linear and
    logarithmic error at pairs of directions that made neither is smaller, and the linear one at most `MORE_ERROR`
    times as large. They take the norm that the others were best in, which is the better one for them too or within 1 %
    of it, and they take most of the time.
    """
    if isinstance(brdf, SeparableFactors):
        check_factors(brdf)
        return {terms: brdf.truncate(min(terms, brdf.terms)) for terms in counts}
    hemisphere_map, pairs, most = HemisphereMap(kind, MAP_SIZE), reference(brdf), max(NESTED, *counts)
    share = 0.5 if 1 in counts else 1.0
    found = yield from part(
        separate(brdf, hemisphere_map, most, weighting=weighting, reference=pairs, shared=True), 0.0, share
    )
    name = text_of(brdf)
    every = replace(found.factors, name=name)
    first = {terms: every.truncate(min(terms, every.terms)) for terms in counts}
    if type(brdf) not in MODELS.values():
        errors = [pairs.seen(every.truncate(terms)) for terms in range(1, min(max(counts), every.terms) + 1)]
        first = {terms: every.truncate(1 + int(np.argmin(errors[:terms]))) for terms in counts}
    if 1 in counts:
        positive = yield from part(normalise(brdf, hemisphere_map, "in-out", pairs), share, 1.0)
        other = replace(positive, name=name)
        first[1] = min(first[1], other, key=lambda each: pairs.miss(pairs.rms(each)[1]))
    for terms in counts if signs != "signed" else ():
        if first[terms].negative_energy(pairs.wi, pairs.wo) > (0.0 if signs == "nonnegative" else MAX_BELOW_ZERO):
            steps = separate(
                brdf,
                hemisphere_map,
                terms,
                method="nonnegative",
                weighting=found.weighting,
                reference=pairs,
                shared=True,
            )
            positive = replace((yield from part(steps, 1.0, 1.0)).factors, name=name)
            if signs == "nonnegative" or _is_better(positive, first[terms], pairs):
                first[terms] = positive
    return first


def _is_better(positive: SeparableFactors, signed: SeparableFactors, pairs: Reference) -> bool:
    one, other = pairs.measure_held_out(positive), pairs.measure_held_out(signed)
    return one.score < other.score and one.rms_cosine_weighted <= MORE_ERROR * other.rms_cosine_weighted


def prepare(
    mesh: Mesh,
    factors: SeparableFactors,
    settings: BakeSettings,
    ground: Ground | None = None,
    mixture: Mixture | None = None,
    kinds: Kinds | None = None,
) -> Work:
    """Lay out the bake of `mesh`, on a ground where there is one; nothing is written yet.

    With `mixture`, `factors` are of several BRDFs (`engine.transport.baking.blend.together`), and with `kinds` of the
    BRDF of each kind, with as many terms.
    """
    surface = mesh if ground is None else with_ground(mesh, ground)[0]
    return lay_out(surface, len(mesh.positions), factors, settings, ground.albedo if ground else 0.0, mixture, kinds)


def lay_out(
    surface: Mesh,
    first: int,
    factors: SeparableFactors,
    settings: BakeSettings,
    ground_albedo: float,
    mixture: Mixture | None = None,
    kinds: Kinds | None = None,
) -> Work:
    """As `prepare`, of a model with its ground, whose first vertex is `first`."""
    terms = factors.terms // (1 if kinds is None else len(kinds.brdfs))
    check_factors(factors, terms)
    if mixture is not None:
        check_mixture(mixture, factors, first)
    if mixture is not None and settings.bounces:
        raise UsageError("interreflection is baked for one BRDF, not for one that varies or is coloured by an image")
    rows = row_bounds(len(surface.positions), first, terms, settings.edge)
    if settings.bounces:  # the vectors of bounces follow
        rows = np.concatenate([rows, rows[-1] + rows[1:]])
    plan = plan_transport(
        KIND,
        surface,
        {
            **asdict(settings),
            "ground_vertex": first,
            "ground_albedo": ground_albedo,
            "brdf": factors.name[:1000],
            "map": factors.hemisphere_map.kind,
            "map_size": factors.hemisphere_map.size,
            "isotropic": factors.isotropic,
            "reciprocal": factors.reciprocal,
            "step": STEP,
            **({} if mixture is None else {"bases": list(mixture.terms)}),
            **({} if kinds is None else kinds.settings()),
        },
        {
            "view_maps": factors.first,
            "light_maps": factors.second,
            **_mixture_arrays(mixture),
            **({} if kinds is None else kinds.arrays()),
        },
        {
            "indices": ("<u2", (settings.coefficients,)),
            "words": ("<u4", (settings.coefficients,)),
            "peaks": ("<f4", (3,)),
            "counts": ("<u2", ()),
        },
        rows,
    )
    if settings.occluder_cells:
        occluder = simplify(surface, settings.occluder_cells)
    else:
        occluder = Occluder(caster_of(surface))
    return Work(surface, first, factors, ground_albedo, settings, occluder, plan, mixture, kinds=kinds)


def _mixture_arrays(mixture: Mixture | None) -> dict[str, NDArray[np.float32]]:
    if mixture is None:
        return {}
    albedo = {} if mixture.albedo is None else {"albedo": mixture.albedo}
    return {"weights": mixture.weights, **albedo}


def vertex_bounds(vertices: int, first: int, edge: int) -> NDArray[np.int64]:
    """First vertices of the chunks, and the end; no chunk mixes model and ground."""
    step = max(1, CHUNK_TEXELS // (FACES * edge * edge))
    return np.unique(
        np.concatenate([np.arange(0, first, step), np.arange(first, vertices, step), [first, vertices, 0]])
    )


def row_bounds(vertices: int, first: int, terms: int, edge: int) -> NDArray[np.int64]:
    """The same in rows of vectors."""
    bounds = vertex_bounds(vertices, first, edge)
    return np.minimum(bounds, first) * terms + np.maximum(bounds - first, 0)


def bake(path: str | os.PathLike[str], work: Work, cluster: str | None = None) -> Steps[Baked]:
    """Bake into the file `path`, going on where an equal bake was interrupted; its `Step.partial` is None.

    With the address of a `cluster`, its workers make the chunks and follow the bounces
    (`engine.transport.baking.chunks`). OutputError where the file cannot be written. Closing the generator keeps what
    is done for the next run.
    """
    yield Step(0.0, f"preparing {count_text(work.vertices)} vertices, {size_text(work.size_bytes)}")
    started = time.perf_counter()
    of = keep_visibility(work.occluder.receivers(work.surface), work.kept)
    share = 0.7 if work.settings.bounces else 1.0
    with writing(path, work.plan) as writer:
        recipe = recipe_of(work, of)
        carrier = Carrier(of, work.settings.edge, work.settings.fine, recipe["bounds"])
        remote = Remote(cluster, maker, recipe) if cluster else None
        missing = list(writer.missing)
        direct = [chunk for chunk in missing if chunk < len(carrier.sizes)]
        visibility_s = yield from part(fill(writer, Baker(recipe, of), direct, carrier, remote), 0.0, share)
        if len(missing) > len(direct):
            yield from part(_add_bounces(work, writer, cluster), share, 1.0)
        yield Step(1.0, "writing")
    bake_s = time.perf_counter() - started
    file = open_transport(path)
    free = int(np.count_nonzero(of.free))
    return Baked(
        transport_of(file), file, bake_s, visibility_s, work.plan.chunks - len(missing), work.plan.chunks, free
    )


def _add_bounces(work: Work, writer: TransportWriter, cluster: str | None) -> Steps[None]:
    """Put the chunks of bounces, which follow those of direct light."""
    chunks = work.plan.chunks // 2
    found = yield from reflect(work, (writer.get(chunk) for chunk in range(chunks)), cluster)
    rows = row_bounds(work.vertices, work.ground_vertex, work.terms, work.settings.edge)
    for chunk, (start, stop) in enumerate(pairwise(rows)):
        writer.put(chunks + chunk, _widen(found, slice(start, stop), work.settings.coefficients))


def _widen(rows: Mapping[str, NDArray[Any]], some: slice, coefficients: int) -> dict[str, NDArray[Any]]:
    """Some of the vectors, with room for so many coefficients."""
    wide = {name: np.zeros((some.stop - some.start, coefficients), rows[name].dtype) for name in ("indices", "words")}
    for name, array in wide.items():
        array[:, : rows[name].shape[1]] = rows[name][some]
    return {**wide, "peaks": rows["peaks"][some], "counts": rows["counts"][some]}


def reflect(
    work: Work, direct: Iterable[Mapping[str, NDArray[Any]]], cluster: str | None = None
) -> Steps[dict[str, NDArray[Any]]]:
    """The vectors of bounces that belong to the `direct` ones of all vertices of `work`, in parts one after another."""
    bounds = vertex_bounds(work.vertices, work.ground_vertex, work.settings.edge)
    return (yield from gather_reflections(surroundings_of(work), direct, work.settings.bounces, bounds, cluster))


def surroundings_of(work: Work) -> Surroundings:
    """The surroundings of a bounce of `work`."""
    surface, settings = work.surface, work.settings
    return Surroundings(
        of=receivers(surface),
        frames=vertex_frames(surface, work.factors.isotropic),
        factors=work.factors,
        first=work.ground_vertex,
        ground_albedo=work.ground_albedo,
        rays=settings.gather,
        coefficients=settings.coefficients,
        kind=work.kind,
        kinds=work.count,
    )


def recipe_of(work: Work, of: Receivers) -> Recipe:
    """Data that all chunks of `work` share, for `maker`; `of` are its vertices as receivers."""
    hemisphere_map, settings = work.factors.hemisphere_map, work.settings
    return {
        **of.describe(),
        "frames": vertex_frames(work.surface, work.factors.isotropic),
        "bounds": vertex_bounds(work.vertices, work.ground_vertex, settings.edge),
        "ground_vertex": work.ground_vertex,
        "map": (hemisphere_map.kind, hemisphere_map.size),
        "light_maps": light_maps(work.factors),
        "edge": settings.edge,
        "fine": settings.fine,
        "coefficients": settings.coefficients,
        "kinds": work.count,
        **({} if work.kind is None else {"kind": work.kind}),
    }


def maker(recipe: Recipe) -> Callable[[Task], Chunk]:
    """Chunks of the tasks of a bake, from `recipe_of` it."""
    caster = RayCaster(recipe["positions"], recipe["faces"])
    return carry(partial(Baker, recipe), Receivers(caster, recipe["origin"], recipe["normal"], recipe["free"]))


class Baker:
    """Turns vertices into vectors, with everything that all vertices share."""

    def __init__(self, recipe: Recipe, of: Receivers) -> None:
        self._recipe, self._of = recipe, of
        self._texels = cube_texels(recipe["edge"])
        self._hemisphere_map = HemisphereMap(*recipe["map"])

    def __call__(self, number: int) -> Chunk:
        """The chunk of that number."""
        bounds = self._recipe["bounds"]
        rows, visibility_s = self.compute_rows(np.arange(bounds[number], bounds[number + 1]))
        return Chunk(number, rows, visibility_s)

    def compute_rows(self, vertices: NDArray[np.int64]) -> tuple[dict[str, NDArray[Any]], float]:
        """The rows of `vertices`, all of the model or all of the ground, and the seconds for their visibility."""
        started = time.perf_counter()
        shares = visibility_shares(self._of, self._recipe["edge"], self._recipe["fine"], vertices)
        counts = [some for _, some in shares]
        visibility_s = time.perf_counter() - started
        return self.vectors(vertices, counts[0] if len(counts) == 1 else np.concatenate(counts)), visibility_s

    def vectors(self, vertices: NDArray[np.int64], counts: NDArray[np.uint8]) -> dict[str, NDArray[Any]]:
        """The same from how many parts of each texel they see."""
        recipe, ground = self._recipe, np.ones((1, 1, 1), np.float32)
        if vertices[0] >= recipe["ground_vertex"]:
            return self._vectors(vertices, counts, DIFFUSE, ground)
        kind, light_maps, found = recipe.get("kind"), recipe["light_maps"], dict[str, NDArray[Any]]()
        terms = len(light_maps) // recipe["kinds"]
        for factors, some in split_by_kind(kind, terms, vertices):
            own = self._vectors(vertices[some], counts[some], self._hemisphere_map, light_maps[factors])
            rows = (some[:, None] * terms + np.arange(terms)).reshape(-1)
            for name, array in own.items():
                found.setdefault(name, np.empty((len(vertices) * terms, *array.shape[1:]), array.dtype))[rows] = array
        return found

    def _vectors(
        self,
        vertices: NDArray[np.int64],
        counts: NDArray[np.uint8],
        hemisphere_map: HemisphereMap,
        light_maps: NDArray[np.float32],
    ) -> dict[str, NDArray[Any]]:
        return transport_vectors(
            self._recipe["frames"][vertices],
            np.ascontiguousarray(counts),
            self._recipe["fine"] ** 2,
            self._texels,
            hemisphere_map,
            light_maps,
            self._recipe["coefficients"],
        )


def baker_of(work: Work, of: Receivers) -> Baker:
    """Baker of the vectors of `work` in this process; `of` are its vertices as receivers."""
    return Baker(recipe_of(work, of), of)


def bake_in_memory(work: Work, vertices: NDArray[np.int64]) -> Iterator[tuple[NDArray[np.int64], Mapping[str, Any]]]:
    """Vectors of chosen vertices of the model, chunk by chunk, without a file."""
    of = work.occluder.receivers(work.surface)
    baker = baker_of(work, of)
    for chunk, counts in visibility_shares(of, work.settings.edge, work.settings.fine, vertices):
        yield chunk, baker.vectors(chunk, counts)


def casts_rays(work: Work) -> bool:
    """False where the record of visibility holds all that the bake needs, but for the few rays of bounces."""
    of = keep_visibility(work.occluder.receivers(work.surface), work.kept)
    return not is_kept(of, work.settings.edge, work.settings.fine)


def estimate_s(work: Work) -> float:
    """Seconds that the bake will take; costs about a hundredth of it."""
    started, settings = time.perf_counter(), work.settings
    of = keep_visibility(work.occluder.receivers(work.surface), work.kept)
    if not is_kept(of, settings.edge, settings.fine):
        of = replace(of, record=None)  # a block is more than is tried
    baker = baker_of(work, of)
    shared_s = time.perf_counter() - started
    size = portion(settings.edge)
    total_s = shared_s + estimate_chunks_s(baker.compute_rows, work.vertices, work.ground_vertex, size)
    if settings.bounces:
        bounce = make_full_bounce(surroundings_of(work))
        total_s += settings.bounces * estimate_chunks_s(bounce, work.vertices, work.ground_vertex, size)
    return total_s


def transport_of(file: TransportFile) -> WaveletTransport:
    """The wavelet transport in an open file; InputError where it holds another kind, or what cannot be."""
    return read_as(file, KIND, _transport_of)


def _transport_of(file: TransportFile) -> WaveletTransport:
    settings = file.settings
    hemisphere_map = HemisphereMap(settings["map"], settings["map_size"])
    words = (bool(settings["isotropic"]), bool(settings["reciprocal"]), str(settings["brdf"]))
    factors = SeparableFactors(hemisphere_map, "in-out", file.arrays["view_maps"], file.arrays["light_maps"], *words)
    vectors = vectors_of(file.arrays)
    vectors.check(int(settings["edge"]))
    bounces = None
    parts = parts_in(file, int(settings["ground_vertex"]))
    if settings.get("bounces"):
        rows = len(vectors.counts) // 2
        vectors, bounces = vectors.select(slice(0, rows)), vectors.select(slice(rows, None))
    return WaveletTransport(
        file.mesh,
        int(settings["ground_vertex"]),
        factors,
        float(settings["ground_albedo"]),
        int(settings["edge"]),
        vectors,
        _mixture_of(file),
        bounces,
        None if parts is None else parts.kind[parts.part],
        1 if parts is None else int(parts.kind.max()) + 1,
    )


def _mixture_of(file: TransportFile) -> Mixture | None:
    if "weights" not in file.arrays:
        return None
    weights, albedo = file.arrays["weights"], file.arrays.get("albedo")
    if weights.dtype != np.float32 or (albedo is not None and albedo.dtype != np.float32):
        raise ValueError("weights or colours are of another type")
    return Mixture(tuple(int(terms) for terms in file.settings["bases"]), weights, albedo)
