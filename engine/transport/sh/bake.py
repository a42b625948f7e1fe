"""Baking transport in spherical harmonics: visibility by rays, then matrices or vectors, chunk by chunk into a file.

Visibility is counted over the texels of a cube map as for wavelets (`visibility_shares`). With interreflection, light
from other parts of the model comes on top (`engine.transport.sh.interreflection`).

Bound by the rays: some 3,000 for each vertex at an edge of 32, more where shadows end, and `BakeSettings.gather` for
each bounce. A matrix of order 5 takes 2.5 kB, so 50,000 vertices take 125 MB.

Rows of transport in spherical harmonics for some vertices, from what all vertices of a bake share.

That is a recipe of arrays and plain values, so that the workers of a cluster can make chunks as well as this process
(`engine.transport.baking.chunks`).
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.brdf.brdf import Brdf
from engine.core.cached import cached_property
from engine.core.errors import UsageError
from engine.core.figure_text import count_text, size_text
from engine.core.one_thread import one_thread
from engine.core.params import check_values
from engine.core.steps import Step, Steps, part
from engine.geometry.ground import Ground, with_ground
from engine.geometry.mesh import Mesh
from engine.geometry.ray_caster import RayCaster, caster_of
from engine.transport.baking.carried_visibility import Carrier, Task, carry
from engine.transport.baking.chunks import Chunk, Recipe, Remote, fill
from engine.transport.baking.chunks import estimate_s as estimate_chunks_s
from engine.transport.baking.file import (
    TransportFile,
    TransportPlan,
    open_transport,
    plan_transport,
    read_as,
    writing,
)
from engine.transport.baking.parts import Kinds, parts_in, text_of_bake
from engine.transport.baking.settings import ShSettings
from engine.transport.baking.spatially_varying import Variation, variation_to_text
from engine.transport.baking.visibility import Receivers, find_unshaded, portion, receivers, visibility_shares
from engine.transport.baking.visibility_record import is_kept, keep_visibility
from engine.transport.sh.brdf_table import BrdfTable
from engine.transport.sh.brdf_table_varying import Table, VariedTable, table_of, tables_of, tabulate_kinds
from engine.transport.sh.interreflection import Surroundings, gather, reflections, transfer_open
from engine.transport.sh.transfer import (
    STEP,
    Counts,
    ShTransport,
    diffuse_vectors,
    free_vectors,
    is_diffuse,
    matrices,
    round_rows,
    tangent_frames,
    visibility_harmonics,
)


def maker(recipe: Recipe) -> Callable[[Task], Chunk]:
    """Chunks of the tasks of a bake, from its recipe (`sh.bake.recipe_of`)."""
    caster = RayCaster(recipe["shading_positions"], recipe["shading_faces"])
    return carry(partial(Baker, recipe), Receivers(caster, recipe["origin"], recipe["normal"], recipe["free"]))


class Baker:
    """Turns vertices into rows of transport, with everything that they share; `of` are all vertices as receivers."""

    def __init__(self, recipe: Recipe, of: Receivers) -> None:
        self._recipe, self._of = recipe, of
        self._sent: NDArray[np.float32] | None = recipe.get("sent")
        self._around = Surroundings(recipe["positions"], recipe["faces"], of, recipe["order"], recipe["gather"])

    def __call__(self, number: int) -> Chunk:
        """The chunk of that number."""
        bounds = self._recipe["bounds"]
        rows, visibility_s = self.compute_rows(np.arange(bounds[number], bounds[number + 1]))
        return Chunk(number, rows, visibility_s)

    def compute_rows(self, vertices: NDArray[np.int64]) -> tuple[dict[str, NDArray[Any]], float]:
        """The rows of `vertices`, all of the model or all of the ground, and the seconds for their visibility."""
        started = time.perf_counter()
        counts = None if self._of.free[vertices].all() else self.visible(vertices)
        visibility_s = time.perf_counter() - started
        return {"rows": self.rows(vertices, counts)}, visibility_s

    def visible(self, vertices: NDArray[np.int64]) -> NDArray[np.uint8]:
        """(B, 6 N²) how many parts of each texel are seen."""
        shares = visibility_shares(self._of, self._recipe["edge"], self._recipe["fine"], vertices)
        return np.concatenate([counts for _, counts in shares])

    def rows(self, vertices: NDArray[np.int64], counts: Counts | None) -> NDArray[np.float32]:
        """(rows, C, order²) of `vertices`, all of the model or all of the ground; `counts` None where all are free."""
        recipe, channels = self._recipe, self._recipe["channels"]
        if recipe["diffuse"] or vertices[0] >= recipe["ground_vertex"]:
            rows = np.repeat(self._vectors(vertices, counts)[:, None], channels, axis=1)
            if self._sent is not None:
                rows += gather(self._around, vertices, self._sent)
            return rows
        frames = recipe["frames"][vertices]
        own = matrices(self._seen(vertices, counts), frames, self._of.free[vertices])
        whole = np.repeat(own[:, :, None], channels, axis=2)
        if self._sent is not None:
            whole += gather(self._around, vertices, self._sent, frames)
        return round_rows(whole.reshape(-1, channels, recipe["order"] ** 2))

    def _vectors(self, vertices: NDArray[np.int64], counts: Counts | None) -> NDArray[np.float32]:
        recipe, normal = self._recipe, self._of.normal[vertices]
        if counts is None:
            return free_vectors(recipe["order"], normal)
        free, full = self._of.free[vertices], recipe["fine"] ** 2
        with one_thread():
            return diffuse_vectors(counts, full, recipe["edge"], recipe["order"], normal, free)

    def _seen(self, vertices: NDArray[np.int64], counts: Counts | None) -> NDArray[np.float32]:
        """Spherical harmonics of visibility; any where all vertices are free, because theirs are known."""
        recipe, order = self._recipe, 2 * self._recipe["order"] - 1
        if counts is None:
            return np.zeros((len(vertices), order**2), np.float32)
        with one_thread():
            return visibility_harmonics(counts, recipe["fine"] ** 2, recipe["edge"], order)


KIND = "sh"

#: Numbers of visibility and of matrices of a chunk of the file, roughly.
CHUNK_VALUES = 1 << 21


@dataclass(frozen=True)
class BakeSettings:
    """Settings of a bake; UsageError for impossible ones.

    Attributes
    ----------
    order : coefficients are order².
    edge : texels along an edge of the cube map that visibility is counted over.
    fine : into fine² parts a texel is cut where visibility changes.
    bounces : between parts of the model, 0 for shadows alone.
    gather : rays from each vertex for a bounce.
    shadows : whether the model shades itself; without, no ray is cast and every vertex sees its whole hemisphere.
    """

    order: int = ShSettings.order
    edge: int = 32
    fine: int = ShSettings.fine
    bounces: int = 0
    gather: int = 512
    shadows: bool = True

    def __post_init__(self) -> None:
        check_values(ShSettings, order=self.order, cube=self.edge, fine=self.fine)
        if not (0 <= self.bounces <= 16 and 16 <= self.gather <= 1 << 16):
            raise UsageError(f"{self.bounces} bounces (0 … 16) of {self.gather} rays (16 … 65536) are not possible")
        if self.bounces and not self.shadows:
            raise UsageError("light between parts of a model that does not shade itself is not possible")


@dataclass(frozen=True, eq=False)
class Work:
    """A bake that is ready to begin: what was asked for, and how large its file will be.

    `surface` is the model with its ground, whose first vertex is `ground_vertex`; `kept` is the folder of records of
    visibility, if there is one.
    """

    surface: Mesh
    ground_vertex: int
    table: Table
    ground_albedo: float
    settings: BakeSettings
    caster: RayCaster
    plan: TransportPlan
    kept: Path | None = None

    @property
    def vertices(self) -> int:
        return len(self.surface.positions)

    @property
    def size_bytes(self) -> int:
        return self.plan.size_bytes

    @property
    def bounds(self) -> NDArray[np.int64]:
        return vertex_bounds(self.vertices, self.ground_vertex, self.settings)

    @cached_property
    def albedo(self) -> NDArray[np.float32]:
        """(V, C) what each vertex reflects of even light; C is 1 where nothing is coloured."""
        model = np.atleast_2d(np.clip(self.table.even_albedo, 0.0, 1.0))
        model = model[:, :1] if np.ptp(model, axis=1).max() < 1e-9 else model
        albedo = np.full((self.vertices, model.shape[1]), self.ground_albedo, np.float32)
        albedo[: self.ground_vertex] = model
        return albedo

    def surroundings(self, of: Receivers) -> Surroundings:
        surface, settings = self.surface, self.settings
        return Surroundings(surface.positions, surface.faces, of, settings.order, settings.gather)

    @property
    def channels(self) -> int:
        return self.albedo.shape[1] if self.settings.bounces else 1


@dataclass(frozen=True, eq=False)
class Baked:
    """An open transport and what it took: seconds in all, for visibility and for bounces; chunks, vertices spared."""

    transport: ShTransport
    file: TransportFile
    bake_s: float
    visibility_s: float
    bounce_s: float
    resumed_chunks: int
    chunks: int
    unoccluded_vertices: int


def default_edge(order: int) -> int:
    """The edge of the cube map over which V times spherical harmonics of `order` is summed well."""
    return 32 if order <= 8 else 64


def prepare(
    mesh: Mesh,
    brdf: Brdf,
    settings: BakeSettings,
    ground: Ground | None = None,
    variations: Sequence[Variation] = (),
    kinds: Kinds | None = None,
) -> Steps[Work]:
    """Tabulate the BRDF and lay out the bake of `mesh`, on a ground where there is one; nothing is written.

    `variations`, two at most, move parameters of the BRDF from vertex to vertex of the model. UsageError where
    it does not have them, InputError for an image that cannot be read. With `kinds`, each part of the model has its
    own BRDF.
    """
    if kinds is None:
        table = yield from table_of(brdf, settings.order, variations, mesh)
    else:
        table = yield from tabulate_kinds(kinds.brdfs, kinds.number, settings.order)
    surface = mesh if ground is None else with_ground(mesh, ground)[0]
    albedo = ground.albedo if ground else 0.0
    return lay_out(surface, len(mesh.positions), albedo, brdf, table, settings, variations, kinds)


def lay_out(
    surface: Mesh,
    first: int,
    albedo: float,
    brdf: Brdf,
    table: Table,
    settings: BakeSettings,
    variations: Sequence[Variation] = (),
    kinds: Kinds | None = None,
) -> Work:
    """As `prepare`, of a model and its ground of an `albedo`, whose first vertex is `first`, and a BRDF in a table."""
    name = text_of_bake(brdf, kinds)
    table, stated, arrays = _store(table, all(map(is_diffuse, (brdf,) if kinds is None else kinds.brdfs)))
    if kinds is not None:
        stated, arrays = {**stated, **kinds.settings()}, {**arrays, **kinds.arrays()}
    empty = Work(surface, first, table, albedo, settings, _caster(surface, settings), None)  # type: ignore[arg-type]
    plan = plan_transport(
        KIND,
        surface,
        {
            **asdict(settings),
            "ground_vertex": first,
            "ground_albedo": albedo,
            "brdf": name[:1000],
            "variations": [variation_to_text(variation)[:1000] for variation in variations],
            **stated,
            "matt_bounces": bool(settings.bounces),
            "step": STEP,
        },
        arrays,
        {"rows": ("<f4", (empty.channels, settings.order**2))},
        row_bounds(empty),
    )
    return replace(empty, plan=plan)


def _store(table: Table, diffuse: bool) -> tuple[Table, dict[str, Any], dict[str, NDArray[Any]]]:
    """`table` in the precision of the file, and what the file says and holds of it."""
    tables = tables_of(table)
    values = [some.values.astype(np.float32) for some in tables]
    rounded = tuple(
        BrdfTable(some.order, value.astype(np.float64), some.error_rel, diffuse, some.health)
        for some, value in zip(tables, values, strict=True)
    )
    stated: dict[str, Any] = {"diffuse": diffuse, "table_error_rel": table.error_rel}
    if not isinstance(table, VariedTable):
        return rounded[0], stated, {"table": values[0]}
    stated |= {"interpolation_rel": table.interpolation_rel, "nodes": [some.tolist() for some in table.nodes]}
    return replace(table, tables=rounded), stated, {"table": np.stack(values), "numbers": table.numbers}


def vertex_bounds(vertices: int, first: int, settings: BakeSettings) -> NDArray[np.int64]:
    """First vertices of the chunks, and the end; no chunk mixes model and ground."""
    step = max(1, CHUNK_VALUES // max(6 * settings.edge**2, settings.order**4))
    return np.unique(
        np.concatenate([np.arange(0, first, step), np.arange(first, vertices, step), [0, first, vertices]])
    )


def row_bounds(work: Work) -> NDArray[np.int64]:
    """The same in rows."""
    bounds, first = work.bounds, work.ground_vertex
    rows = 1 if work.table.diffuse else work.settings.order**2
    return np.minimum(bounds, first) * rows + np.maximum(bounds - first, 0)


def _caster(surface: Mesh, settings: BakeSettings) -> RayCaster:
    """Caster of the occluding surface: the surface itself, or nothing."""
    return caster_of(surface) if settings.shadows else RayCaster(np.zeros((0, 3)), np.zeros((0, 3), np.int32))


def receivers_of(work: Work) -> Receivers:
    """The vertices of a bake as places where light arrives."""
    return receivers(work.surface, work.caster) if work.settings.shadows else find_unshaded(work.surface, work.caster)


def bake(
    path: str | os.PathLike[str], work: Work, of: Receivers | None = None, cluster: str | None = None
) -> Steps[Baked]:
    """Bake into the file `path`, going on where an equal bake was interrupted; its `Step.partial` is None.

    `of` are the vertices as places where light arrives, where the caller knows them. With the address of a `cluster`,
    its workers follow the bounces and make the chunks (`engine.transport.baking.chunks`). OutputError where the file
    cannot be written. Closing the generator keeps the chunks that are done for the next run; bounces are followed anew.
    """
    yield Step(0.0, f"preparing {count_text(work.vertices)} vertices, {size_text(work.size_bytes)}")
    started = time.perf_counter()
    of = receivers_of(work) if of is None else of
    of = keep_visibility(of, work.kept if work.settings.shadows else None)
    with writing(path, work.plan) as writer:
        missing = list(writer.missing)
        share = 0.4 if work.settings.bounces and missing else 0.0
        sent = None
        if work.settings.bounces and missing:
            sent = yield from part(reflect(work, of, cluster), 0.0, share)
        bounce_s = time.perf_counter() - started if sent is not None else 0.0
        recipe = recipe_of(work, of, sent)
        remote = Remote(cluster, maker, recipe) if cluster else None
        carrier = Carrier(of, work.settings.edge, work.settings.fine, work.bounds)
        filling = fill(writer, Baker(recipe, of), missing, carrier, remote)
        visibility_s = yield from part(filling, share, 1.0)
        yield Step(1.0, "writing")
    bake_s = time.perf_counter() - started
    file = open_transport(path)
    resumed, free = work.plan.chunks - len(missing), int(np.count_nonzero(of.free))
    return Baked(transport_of(file), file, bake_s, visibility_s, bounce_s, resumed, work.plan.chunks, free)


def recipe_of(work: Work, of: Receivers, sent: NDArray[np.float32] | None = None) -> Recipe:
    """Data that all chunks of `work` share, for `maker`; `of` are its vertices as receivers, `sent` by `reflected`."""
    return {
        "positions": work.surface.positions,
        "faces": work.surface.faces,
        "shading_positions": of.caster.positions,
        "shading_faces": of.caster.faces,
        "origin": of.origin,
        "normal": of.normal,
        "free": of.free,
        "frames": tangent_frames(work.surface),
        "bounds": work.bounds,
        "ground_vertex": work.ground_vertex,
        "diffuse": work.table.diffuse,
        "channels": work.channels,
        "order": work.settings.order,
        "edge": work.settings.edge,
        "fine": work.settings.fine,
        "gather": work.settings.gather,
        **({} if sent is None else {"sent": sent}),
    }


def baker_of(work: Work, of: Receivers, sent: NDArray[np.float32] | None = None) -> Baker:
    """Baker of the rows of `work` in this process."""
    return Baker(recipe_of(work, of, sent), of)


def reflect(work: Work, of: Receivers, cluster: str | None = None) -> Steps[NDArray[np.float32]]:
    """Light that each vertex sends to the others, as `reflections`; for `Baker`."""
    return reflections(work.surroundings(of), work.settings.bounces, work.albedo, work.bounds, cluster)


def casts_rays(work: Work) -> bool:
    """False where the record of visibility holds all that the bake needs, which is of no bounces."""
    return bool(work.settings.bounces) or not _needs_no_rays(keep_visibility(receivers_of(work), work.kept), work)


def _needs_no_rays(of: Receivers, work: Work) -> bool:
    return not work.settings.shadows or is_kept(of, work.settings.edge, work.settings.fine)


def estimate_s(work: Work) -> float:
    """Seconds that the bake will take; costs about a hundredth of it."""
    started = time.perf_counter()
    of, settings = keep_visibility(receivers_of(work), work.kept if work.settings.shadows else None), work.settings
    if not _needs_no_rays(of, work):
        of = replace(of, record=None)  # a block is more than is tried
    shape = (work.vertices, work.channels, settings.order**2)
    sent = np.zeros(shape, np.float32) if settings.bounces else None
    baker, around = baker_of(work, of, sent), work.surroundings(of)
    shared_s = time.perf_counter() - started

    def all_of(make: Callable[[NDArray[np.int64]], object]) -> float:
        return estimate_chunks_s(make, work.vertices, work.ground_vertex, portion(settings.edge))

    total = shared_s + all_of(baker.compute_rows)
    if sent is not None:
        total += all_of(lambda vertices: transfer_open(around, vertices))
        total += (settings.bounces - 1) * all_of(lambda vertices: gather(around, vertices, sent))
    return total


def transport_of(file: TransportFile) -> ShTransport:
    """The transport in an open file; InputError where it holds another kind, or what cannot be."""
    return read_as(file, KIND, _transport_of)


def _transport_of(file: TransportFile) -> ShTransport:
    settings = file.settings
    first, albedo = int(settings["ground_vertex"]), float(settings["ground_albedo"])
    if not 0 <= first <= len(file.mesh.positions) or not 0.0 <= albedo <= 1.0:
        raise ValueError("its ground is none")
    rows, table = file.arrays["rows"], _table_of(file)
    parts_in(file, first)
    if rows.dtype != np.float32:
        raise ValueError("its rows are of another type")
    return ShTransport(file.mesh, first, table.diffuse, albedo, table, bool(settings["bounces"]), rows)


def _table_of(file: TransportFile) -> Table:
    """The BRDF in a file; ValueError, KeyError or TypeError where it is none."""
    settings, values = file.settings, file.arrays["table"].astype(np.float64)
    order, error, diffuse = int(settings["order"]), float(settings["table_error_rel"]), bool(settings["diffuse"])
    varied = "nodes" in settings
    if values.shape[-2:] != (order**2, 3) or values.ndim - varied not in (3, 4) or not np.isfinite(values).all():
        raise ValueError("its table of the reflectance is none")
    if not varied:
        return BrdfTable(order, values, error, diffuse)
    nodes = tuple(np.array(some, np.float64) for some in settings["nodes"])
    tables = tuple(BrdfTable(order, some, error, diffuse) for some in values)
    return VariedTable(tables, nodes, file.arrays["numbers"].astype(np.float64), float(settings["interpolation_rel"]))
