"""Baking transport in spherical harmonics: visibility by rays, then matrices or vectors, chunk by chunk into a file.

Visibility is counted over the texels of a cube map as for wavelets (`visibility_shares`). With interreflection, light
from other parts of the model comes on top. For what is reflected on the way every surface counts as matt, with the
albedo that it has under even light: exact for Lambertian models, and said in the file and by the program for others;
the last reflection, the one that is seen, is always the reflectance's own. Each bounce sends rays from every vertex in
directions as dense as the cosine, and reads what arrives at the three corners of the triangle that is met.

Bound by the rays: some 3,000 for each vertex at an edge of 32, more where shadows end, and `BakeSettings.gather` for
each bounce. A matrix of order 5 takes 2.5 kB, so 50,000 vertices take 125 MB.
"""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from engine.brdf.brdf import MODELS, Brdf, brdf_to_text
from engine.directions import Vectors
from engine.errors import InputError
from engine.ground import Ground, with_ground
from engine.mesh import Mesh
from engine.one_thread import one_thread
from engine.ray_caster import RayCaster, caster_of
from engine.steps import Step, Steps, part
from engine.transport import sh_kernel, visibility_kernel
from engine.transport.sh import evaluate
from engine.transport.sh_table import BrdfTable, tabulate
from engine.transport.sh_transfer import (
    ShTransport,
    diffuse_vectors,
    even_in_z,
    is_diffuse,
    matrices,
    tangent_frames,
    visibility_harmonics,
)
from engine.transport.transport_file import (
    REMEDY,
    TransportFile,
    TransportPlan,
    TransportWriter,
    open_transport,
    plan_transport,
    writing,
)
from engine.transport.visibility import Receivers, receivers, visibility_shares

KIND = "sh"

#: Orders that can be baked: below, not even irradiance is kept; above, a matrix takes more than 200 kB.
LEAST_ORDER, MOST_ORDER = 3, 15

#: Vertices whose bake tells how long all will take.
PROBES = 96

#: Numbers of visibility and of matrices of a chunk of the file, roughly.
CHUNK_VALUES = 1 << 21

#: Rays of a bounce that are followed at once, times the harmonics of each.
CHUNK_RAYS = 1 << 22


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
    """

    order: int = 5
    edge: int = 32
    fine: int = 4
    bounces: int = 0
    gather: int = 512

    def __post_init__(self) -> None:
        if not LEAST_ORDER <= self.order <= MOST_ORDER:
            raise ValueError(f"an order of {self.order} is outside {LEAST_ORDER} … {MOST_ORDER}")
        if not 4 <= self.edge <= 256:
            raise ValueError(f"an edge of {self.edge} is outside 4 … 256")
        if not 1 <= self.fine <= 15:
            raise ValueError(f"a texel is cut into 1 to 15 parts along its side, not {self.fine}")
        if not (0 <= self.bounces <= 16 and 16 <= self.gather <= 1 << 16):
            raise ValueError(f"{self.bounces} bounces (0 … 16) of {self.gather} rays (16 … 65536) are not possible")


@dataclass(frozen=True, eq=False)
class Work:
    """A bake that is ready to begin: what was asked for, and how large its file will be.

    `surface` is the model with its ground, whose first vertex is `ground_vertex`.
    """

    surface: Mesh
    ground_vertex: int
    table: BrdfTable
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
        model = np.clip(self.table.mean[0] * np.sqrt(4.0 * np.pi), 0.0, 1.0)
        model = model[:1] if np.ptp(model) < 1e-9 else model
        albedo = np.full((self.vertices, len(model)), self.ground_albedo, np.float32)
        albedo[: self.ground_vertex] = model
        return albedo

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


def prepare(mesh: Mesh, brdf: Brdf, settings: BakeSettings, ground: Ground | None = None) -> Steps[Work]:
    """Tabulate the reflectance and lay out the bake of `mesh`, on a ground where there is one; nothing is written."""
    table = yield from tabulate(brdf, settings.order)
    name = brdf_to_text(brdf) if type(brdf) in MODELS.values() else str(getattr(brdf, "name", ""))
    first = len(mesh.positions)
    surface = mesh if ground is None else with_ground(mesh, ground)[0]
    albedo = ground.albedo if ground else 0.0
    caster = caster_of(surface)
    values = table.values.astype(np.float32)
    table = BrdfTable(table.order, values.astype(np.float64), table.error_rel, is_diffuse(brdf), table.health)
    empty = Work(surface, first, table, albedo, settings, caster, None)  # type: ignore[arg-type]
    plan = plan_transport(
        KIND,
        surface,
        {
            **asdict(settings),
            "ground_vertex": first,
            "ground_albedo": albedo,
            "brdf": name[:1000],
            "diffuse": table.diffuse,
            "table_error_rel": table.error_rel,
            "matt_bounces": bool(settings.bounces),
        },
        {"table": values},
        {"rows": ("<f4", (empty.channels, settings.order**2))},
        row_bounds(empty),
    )
    return Work(surface, first, table, albedo, settings, caster, plan)


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


def bake(path: str | os.PathLike[str], work: Work) -> Steps[Baked]:
    """Bake into the file `path`, going on where an equal bake was interrupted; its `Step.partial` is None.

    OutputError where the file cannot be written. Closing the generator keeps the chunks that are done for the next
    run; bounces are followed anew.
    """
    yield Step(0.0, f"preparing {work.vertices:,} vertices, {work.size_bytes / 1e6:.1f} MB")
    started = time.perf_counter()
    of = receivers(work.surface, work.caster)
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
        counts = baker.visible(vertices)
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
        self._frames = tangent_frames(work.surface)

    def visible(self, vertices: NDArray[np.int64]) -> NDArray[np.uint8]:
        """(B, 6 N²) how many parts of each texel are seen."""
        settings = self._work.settings
        shares = visibility_shares(self._of, settings.edge, settings.fine, vertices)
        return np.concatenate([counts for _, counts in shares])

    def rows(self, vertices: NDArray[np.int64], counts: NDArray[np.uint8]) -> NDArray[np.float32]:
        """(rows, C, order²) of `vertices`, all of the model or all of the ground."""
        work, settings, free = self._work, self._work.settings, self._of.free[vertices]
        full, edge, order = settings.fine**2, settings.edge, settings.order
        if work.table.diffuse or vertices[0] >= work.ground_vertex:
            with one_thread():
                own = diffuse_vectors(counts, full, edge, order, self._of.normal[vertices], free)
            rows = np.repeat(own[:, None], work.channels, axis=1)
            if self._sent is not None:
                rows += gathered(work, self._of, vertices, self._sent)
            return rows
        with one_thread():
            seen = visibility_harmonics(counts, full, edge, 2 * order - 1)
        whole = np.repeat(matrices(seen, self._frames[vertices], free)[:, :, None], work.channels, axis=2)
        if self._sent is not None:
            whole += gathered(work, self._of, vertices, self._sent, self._frames[vertices])
        return whole.reshape(-1, work.channels, order**2)


def reflected(work: Work, of: Receivers) -> Steps[NDArray[np.float32]]:
    """(V, C, order²) radiance that each vertex sends to every side, after up to `bounces` − 1 reflections before.

    What it reflects itself of the distant light, then what it reflects of that, and so on.
    """
    bounds, rounds = work.bounds, work.settings.bounces
    shape = (work.vertices, work.channels, work.settings.order**2)
    latest, total = np.zeros(shape, np.float32), np.zeros(shape, np.float32)
    for bounce in range(rounds):
        arriving = np.empty(shape, np.float32)
        for start, stop in pairwise(bounds):
            some = np.arange(start, stop)
            arriving[some] = _open(work, of, some) if bounce == 0 else gathered(work, of, some, latest)
            yield Step((bounce + stop / work.vertices) / rounds, f"following bounce {bounce + 1} of {rounds}")
        latest = arriving * work.albedo[..., None]
        total += latest
    return total


def _rays(work: Work, of: Receivers, vertices: NDArray[np.int64]) -> tuple[Vectors, NDArray[np.float32]]:
    """Origins and directions (B D, 3), as dense as the cosine and turned for each vertex."""
    rays: tuple[Vectors, NDArray[np.float32]] = visibility_kernel.hemisphere_rays(
        vertices, of.origin, of.normal, _pattern(work.settings.gather)
    )
    return rays


def _pattern(count: int) -> Vectors:
    """(count, 3) directions about +z in a spiral, as dense as the cosine."""
    index = np.arange(count)
    radius, azimuth = np.sqrt((index + 0.5) / count), index * np.pi * (3.0 - np.sqrt(5.0))
    return np.stack([radius * np.cos(azimuth), radius * np.sin(azimuth), np.sqrt(1.0 - radius**2)], axis=-1)


def _blocks(work: Work, vertices: NDArray[np.int64]) -> Iterator[slice]:
    step = max(1, CHUNK_RAYS // (work.settings.gather * work.settings.order**2))
    yield from (slice(start, start + step) for start in range(0, len(vertices), step))


def _open(work: Work, of: Receivers, vertices: NDArray[np.int64]) -> NDArray[np.float32]:
    """(B, 1, order²) transfer to irradiance / π of the distant light, by the rays of a bounce."""
    result = np.empty((len(vertices), 1, work.settings.order**2), np.float32)
    for block in _blocks(work, vertices):
        origin, direction = _rays(work, of, vertices[block])
        seen = (~of.caster.occluded(origin, direction)).reshape(-1, work.settings.gather)
        basis = evaluate(work.settings.order, direction).reshape(*seen.shape, -1)
        result[block, 0] = np.einsum("bd,bdi->bi", seen / work.settings.gather, basis)
    return result


def gathered(
    work: Work,
    of: Receivers,
    vertices: NDArray[np.int64],
    sent: NDArray[np.float32],
    frames: Vectors | None = None,
) -> NDArray[np.float32]:
    """What `vertices` get from other parts of the surface, which send `sent` (V, C, order²) to every side.

    Irradiance / π (B, C, order²); with `frames` (B, 3, 3) instead the rows of matrices (B, order², C, order²), of
    light as a mirror at the tangent plane would show it. Surfaces are black from behind.
    """
    order, count = work.settings.order, work.settings.gather
    shape = (len(vertices), *sent.shape[1:]) if frames is None else (len(vertices), order**2, *sent.shape[1:])
    result = np.zeros(shape, np.float32)
    doubled = np.where(even_in_z(order), 2.0, 0.0)
    for block in _blocks(work, vertices):
        origin, direction = _rays(work, of, vertices[block])
        hits = of.caster.intersect(origin, direction)
        corners = work.surface.faces[hits.face]
        a, b, c = (work.surface.positions[corners[:, corner]] for corner in range(3))
        front = np.einsum("ni,ni->n", np.cross(b - a, c - a), direction) < 0.0
        met = (hits.face >= 0) & front
        if frames is None:
            weight = np.full((len(direction), 1), 1.0 / count)
        else:
            own = np.einsum("bij,bdi->bdj", frames[block], direction.reshape(-1, count, 3)).reshape(-1, 3)
            weight = evaluate(order, own) * doubled * (np.pi / count / np.maximum(own[:, 2:], 1e-3))
        out = result[block].reshape(-1, weight.shape[1], *sent.shape[1:])
        sh_kernel.gather(count, met, corners, hits.barycentric, weight, sent, out)
    return result


def estimate_s(work: Work) -> float:
    """Seconds that the bake will take, from some vertices that lie apart; costs about a hundredth of it."""
    of = receivers(work.surface, work.caster)
    sent = np.zeros((work.vertices, work.channels, work.settings.order**2), np.float32)
    baker = Baker(work, of, sent if work.settings.bounces else None)
    vertices = np.unique(np.linspace(0, max(work.ground_vertex - 1, 0), PROBES).astype(np.int64))
    baker.rows(vertices[:1], baker.visible(vertices[:1]))
    gathered(work, of, vertices[:1], sent)
    started = time.perf_counter()
    baker.rows(vertices, baker.visible(vertices))
    for _ in range(work.settings.bounces):
        gathered(work, of, vertices, sent)
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
        order = int(settings["order"])
        values = file.arrays["table"].astype(np.float64)
        if values.shape[-2:] != (order**2, 3) or values.ndim not in (3, 4) or not np.isfinite(values).all():
            raise ValueError("its table of the reflectance is none")
        table = BrdfTable(order, values, float(settings["table_error_rel"]), bool(settings["diffuse"]))
        first, albedo = int(settings["ground_vertex"]), float(settings["ground_albedo"])
        if not 0 <= first <= len(file.mesh.positions) or not 0.0 <= albedo <= 1.0:
            raise ValueError("its ground is none")
        rows = file.arrays["rows"]
        if rows.dtype != np.float32:
            raise ValueError("its rows are of another type")
        return ShTransport(file.mesh, first, table.diffuse, albedo, table, bool(settings["bounces"]), rows)
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(file.path, f"holds transport that cannot be ({str(error)[:200]})", REMEDY) from None
