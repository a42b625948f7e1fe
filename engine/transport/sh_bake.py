"""Baking transport in spherical harmonics: visibility by rays, then matrices or vectors, chunk by chunk into a file.

Visibility is counted over the texels of a cube map as for wavelets (`visibility_shares`). With interreflection, light
from other parts of the model comes on top (`engine.transport.sh_bounces`).

Bound by the rays: some 3,000 for each vertex at an edge of 32, more where shadows end, and `BakeSettings.gather` for
each bounce. A matrix of order 5 takes 2.5 kB, so 50,000 vertices take 125 MB.
"""

from __future__ import annotations

import os
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.brdf.brdf import MODELS, Brdf, brdf_to_text
from engine.errors import InputError
from engine.ground import Ground, with_ground
from engine.mesh import Mesh
from engine.one_thread import one_thread
from engine.ray_caster import RayCaster, caster_of
from engine.steps import Step, Steps, part
from engine.transport.sh_bounces import Surroundings, gathered, reflections
from engine.transport.sh_table import BrdfTable
from engine.transport.sh_transfer import (
    ShTransport,
    diffuse_vectors,
    free_vectors,
    is_diffuse,
    matrices,
    tangent_frames,
    visibility_harmonics,
)
from engine.transport.sh_varied import Table, VariedTable, table_of, tables_of
from engine.transport.transport_file import (
    REMEDY,
    TransportFile,
    TransportPlan,
    TransportWriter,
    open_transport,
    plan_transport,
    writing,
)
from engine.transport.variation import Variation, variation_to_text
from engine.transport.visibility import Receivers, receivers, unshaded, visibility_shares

KIND = "sh"

#: Orders that can be baked: below, not even irradiance is kept; above, a matrix takes more than 200 kB.
LEAST_ORDER, MOST_ORDER = 3, 15

#: Vertices whose bake tells how long all will take.
PROBES = 96

#: Numbers of visibility and of matrices of a chunk of the file, roughly.
CHUNK_VALUES = 1 << 21


@dataclass(frozen=True)
class BakeSettings:
    """What to bake; ValueError where it cannot be.

    Attributes
    ----------
    order : coefficients are order².
    edge : texels along an edge of the cube map that visibility is counted over.
    fine : into fine² parts a texel is cut where visibility changes.
    bounces : between parts of the model, 0 for shadows alone.
    gather : rays from each vertex for a bounce.
    shadows : whether the model shades itself; without, no ray is cast and every vertex sees its whole hemisphere.
    """

    order: int = 5
    edge: int = 32
    fine: int = 4
    bounces: int = 0
    gather: int = 512
    shadows: bool = True

    def __post_init__(self) -> None:
        if not LEAST_ORDER <= self.order <= MOST_ORDER:
            raise ValueError(f"an order of {self.order} is outside {LEAST_ORDER} … {MOST_ORDER}")
        if not 4 <= self.edge <= 256:
            raise ValueError(f"an edge of {self.edge} is outside 4 … 256")
        if not 1 <= self.fine <= 15:
            raise ValueError(f"a texel is cut into 1 to 15 parts along its side, not {self.fine}")
        if not (0 <= self.bounces <= 16 and 16 <= self.gather <= 1 << 16):
            raise ValueError(f"{self.bounces} bounces (0 … 16) of {self.gather} rays (16 … 65536) are not possible")
        if self.bounces and not self.shadows:
            raise ValueError("light between parts of a model that does not shade itself is not possible")


@dataclass(frozen=True, eq=False)
class Work:
    """A bake that is ready to begin: what was asked for, and how large its file will be.

    `surface` is the model with its ground, whose first vertex is `ground_vertex`.
    """

    surface: Mesh
    ground_vertex: int
    table: Table
    ground_albedo: float
    settings: BakeSettings
    caster: RayCaster
    plan: TransportPlan

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
        return Surroundings(self.surface, of, self.settings.order, self.settings.gather)

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
    free_vertices: int


def default_edge(order: int) -> int:
    """The edge of the cube map over which V times harmonics of `order` is summed well."""
    return 32 if order <= 8 else 64


def prepare(
    mesh: Mesh,
    brdf: Brdf,
    settings: BakeSettings,
    ground: Ground | None = None,
    variations: Sequence[Variation] = (),
) -> Steps[Work]:
    """Tabulate the reflectance and lay out the bake of `mesh`, on a ground where there is one; nothing is written.

    `variations`, two at most, move parameters of the reflectance from vertex to vertex of the model. ValueError where
    it does not have them, InputError for a picture that cannot be read.
    """
    table = yield from table_of(brdf, settings.order, variations, mesh)
    name = brdf_to_text(brdf) if type(brdf) in MODELS.values() else str(getattr(brdf, "name", ""))
    first = len(mesh.positions)
    surface = mesh if ground is None else with_ground(mesh, ground)[0]
    albedo = ground.albedo if ground else 0.0
    table, stated, arrays = _stored(table, is_diffuse(brdf))
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
        },
        arrays,
        {"rows": ("<f4", (empty.channels, settings.order**2))},
        row_bounds(empty),
    )
    return replace(empty, plan=plan)


def _stored(table: Table, diffuse: bool) -> tuple[Table, dict[str, Any], dict[str, NDArray[Any]]]:
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
    """Where chunks of vertices begin, and the end; none mixes model and ground."""
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
    """What shades the surface: itself, or nothing."""
    return caster_of(surface) if settings.shadows else RayCaster(np.zeros((0, 3)), np.zeros((0, 3), np.int32))


def receivers_of(work: Work) -> Receivers:
    """The vertices of a bake as places where light arrives."""
    return receivers(work.surface, work.caster) if work.settings.shadows else unshaded(work.surface, work.caster)


def bake(path: str | os.PathLike[str], work: Work, of: Receivers | None = None) -> Steps[Baked]:
    """Bake into the file `path`, going on where an equal bake was interrupted; its `Step.partial` is None.

    `of` are the vertices as places where light arrives, where the caller knows them. OutputError where the file cannot
    be written. Closing the generator keeps the chunks that are done for the next run; bounces are followed anew.
    """
    yield Step(0.0, f"preparing {work.vertices:,} vertices, {work.size_bytes / 1e6:.1f} MB")
    started = time.perf_counter()
    of = receivers_of(work) if of is None else of
    with writing(path, work.plan) as writer:
        missing = list(writer.missing)
        share = 0.4 if work.settings.bounces and missing else 0.0
        sent = None
        if work.settings.bounces and missing:
            sent = yield from part(reflected(work, of), 0.0, share)
        bounce_s = time.perf_counter() - started if sent is not None else 0.0
        visibility_s = yield from part(_fill(writer, work, of, missing, sent), share, 1.0)
        yield Step(1.0, "writing")
    bake_s = time.perf_counter() - started
    file = open_transport(path)
    resumed, free = work.plan.chunks - len(missing), int(np.count_nonzero(of.free))
    return Baked(transport_of(file), file, bake_s, visibility_s, bounce_s, resumed, work.plan.chunks, free)


def _fill(
    writer: TransportWriter, work: Work, of: Receivers, missing: list[int], sent: NDArray[np.float32] | None
) -> Steps[float]:
    """Put all `missing` chunks; the seconds that visibility took."""
    bounds, visibility_s, started, done = work.bounds, 0.0, time.perf_counter(), 0
    chunks = [np.arange(bounds[chunk], bounds[chunk + 1]) for chunk in missing]
    total, baker = sum(map(len, chunks)), Baker(work, of, sent)
    for chunk, vertices in zip(missing, chunks, strict=True):
        before = time.perf_counter()
        counts = None if of.free[vertices].all() else baker.visible(vertices)
        visibility_s += time.perf_counter() - before
        writer.put(chunk, {"rows": baker.rows(vertices, counts)})
        done += len(vertices)
        left = (time.perf_counter() - started) / done * (total - done)
        words = f"{left:.0f} s left" if left < 120.0 else f"{left / 60.0:.0f} min left"
        yield Step(done / total, f"baking vertex {done:,} of {total:,}, {words}")
    return visibility_s


class Baker:
    """Turns vertices into rows of transport, with everything that they share; `sent` is from `reflected`."""

    def __init__(self, work: Work, of: Receivers, sent: NDArray[np.float32] | None = None) -> None:
        self._work, self._of, self._sent = work, of, sent
        self._frames, self._around = tangent_frames(work.surface), work.surroundings(of)

    def visible(self, vertices: NDArray[np.int64]) -> NDArray[np.uint8]:
        """(B, 6 N²) how many parts of each texel are seen."""
        settings = self._work.settings
        shares = visibility_shares(self._of, settings.edge, settings.fine, vertices)
        return np.concatenate([counts for _, counts in shares])

    def rows(self, vertices: NDArray[np.int64], counts: NDArray[np.uint8] | None) -> NDArray[np.float32]:
        """(rows, C, order²) of `vertices`, all of the model or all of the ground; `counts` None where all are free."""
        work, settings, free = self._work, self._work.settings, self._of.free[vertices]
        full, edge, order = settings.fine**2, settings.edge, settings.order
        if work.table.diffuse or vertices[0] >= work.ground_vertex:
            with one_thread():
                own = (
                    free_vectors(order, self._of.normal[vertices])
                    if counts is None
                    else diffuse_vectors(counts, full, edge, order, self._of.normal[vertices], free)
                )
            rows = np.repeat(own[:, None], work.channels, axis=1)
            if self._sent is not None:
                rows += gathered(self._around, vertices, self._sent)
            return rows
        with one_thread():
            seen = _seen(counts, len(vertices), full, edge, 2 * order - 1)
        whole = np.repeat(matrices(seen, self._frames[vertices], free)[:, :, None], work.channels, axis=2)
        if self._sent is not None:
            whole += gathered(self._around, vertices, self._sent, self._frames[vertices])
        return whole.reshape(-1, work.channels, order**2)


def reflected(work: Work, of: Receivers) -> Steps[NDArray[np.float32]]:
    """What each vertex sends to the others, as `reflections`; for `Baker`."""
    return reflections(work.surroundings(of), work.settings.bounces, work.albedo, work.bounds)


def _seen(counts: NDArray[np.uint8] | None, vertices: int, full: int, edge: int, order: int) -> NDArray[np.float32]:
    """Harmonics of visibility; any where all vertices are free, because theirs are known."""
    if counts is None:
        return np.zeros((vertices, order**2), np.float32)
    return visibility_harmonics(counts, full, edge, order)


def estimate_s(work: Work) -> float:
    """Seconds that the bake will take, from some vertices that lie apart; costs about a hundredth of it."""
    of = receivers_of(work)
    sent = np.zeros((work.vertices, work.channels, work.settings.order**2), np.float32)
    baker = Baker(work, of, sent if work.settings.bounces else None)
    vertices = np.unique(np.linspace(0, max(work.ground_vertex - 1, 0), PROBES).astype(np.int64))
    free = bool(of.free.all())
    baker.rows(vertices[:1], None if free else baker.visible(vertices[:1]))
    gathered(work.surroundings(of), vertices[:1], sent)
    started = time.perf_counter()
    baker.rows(vertices, None if free else baker.visible(vertices))
    for _ in range(work.settings.bounces):
        gathered(work.surroundings(of), vertices, sent)
    return (time.perf_counter() - started) / len(vertices) * work.vertices


def open_sh(path: str | os.PathLike[str], mesh: Mesh | None = None) -> ShTransport:
    """The transport in a file; InputError where it holds none, is damaged, or belongs to another mesh than `mesh`."""
    return transport_of(open_transport(path, mesh))


def transport_of(file: TransportFile) -> ShTransport:
    """The transport in an open file; InputError where it holds another kind, or what cannot be."""
    if file.kind != KIND:
        raise InputError(file.path, f"holds transport of the mode {file.kind}", f"Bake with --mode {KIND}")
    settings = file.settings
    try:
        first, albedo = int(settings["ground_vertex"]), float(settings["ground_albedo"])
        if not 0 <= first <= len(file.mesh.positions) or not 0.0 <= albedo <= 1.0:
            raise ValueError("its ground is none")
        rows, table = file.arrays["rows"], _table_of(file)
        if rows.dtype != np.float32:
            raise ValueError("its rows are of another type")
        return ShTransport(file.mesh, first, table.diffuse, albedo, table, bool(settings["bounces"]), rows)
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(file.path, f"holds transport that cannot be ({str(error)[:200]})", REMEDY) from None


def _table_of(file: TransportFile) -> Table:
    """The reflectance in a file; ValueError, KeyError or TypeError where it is none."""
    settings, values = file.settings, file.arrays["table"].astype(np.float64)
    order, error, diffuse = int(settings["order"]), float(settings["table_error_rel"]), bool(settings["diffuse"])
    varied = bool(settings.get("variations"))
    if values.shape[-2:] != (order**2, 3) or values.ndim - varied not in (3, 4) or not np.isfinite(values).all():
        raise ValueError("its table of the reflectance is none")
    if not varied:
        return BrdfTable(order, values, error, diffuse)
    nodes = tuple(np.array(some, np.float64) for some in settings["nodes"])
    tables = tuple(BrdfTable(order, some, error, diffuse) for some in values)
    return VariedTable(tables, nodes, file.arrays["numbers"].astype(np.float64), float(settings["interpolation_rel"]))
