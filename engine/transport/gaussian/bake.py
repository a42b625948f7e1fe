"""Baking Gaussian transport: tabulate, fit in the order of a flood fill, make neighbours agree, and write it down.

Lobes of direct light, and with `BakeSettings.indirect` those of light that comes by way of the model, are fitted block
by block (`fitting.fit.fit`). A working file takes each block as it is done, so an interrupted bake goes on from there
and ends in the same bytes; the rest after the last block (neighbours that are made to agree, the diffuse vectors) is
done anew. Then everything is put into the transport file in the order of the vertices, and the working file vanishes.

A plain least-squares fit loses energy. With `weights` "auto" some vertices are fitted beforehand, and whichever way to
weigh has the lower error of radiance under a test environment is taken; both errors are reported (`gaussian_error`).

Visibility comes first, from its record or by rays, and is held in memory (`HeldVisibility`). Bound by the fit, and
by rays where there is no record; indirect light, which casts its own, takes three times as long again. Memory: the
lobes, their working file's 48 bytes for each vertex, view and lobe, and one block of samples.

Visibility, fits and diffuse rows are tasks for some vertices each (`Baker`), done by this process, or by the workers of
a cluster, which hold the model and one task. A task brings what its vertices see, and the lobes that they start from.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Generator, Mapping, Sequence
from contextlib import AbstractContextManager, closing
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from engine.brdf.brdf import Brdf
from engine.brdf.models.diffuse import Lambert
from engine.core.cached import cached_property
from engine.core.errors import UsageError
from engine.core.figure_text import count_text, size_text
from engine.core.health import Health
from engine.core.params import check_values
from engine.core.steps import Step, Steps, part, relay, time_left
from engine.geometry.ground import Ground
from engine.geometry.mesh import Mesh
from engine.geometry.ray_caster import RayCaster
from engine.light.cube_map import CubeMap, cube_of
from engine.light.environment_file import open_environment
from engine.storage.resumable import resumable_file
from engine.storage.scratch import scratch_array
from engine.transport.baking.chunks import Recipe, Remote, Run, each_of, open_workers
from engine.transport.baking.file import (
    TransportFile,
    TransportPlan,
    TransportWriter,
    open_transport,
    plan_transport,
    read_as,
    write_transport,
)
from engine.transport.baking.held_visibility import HeldVisibility, Seen, gather_visibility, hold_visibility, look_at
from engine.transport.baking.parts import Kinds, parts_in, text_of_bake
from engine.transport.baking.settings import GaussianSettings, WaveletSettings
from engine.transport.baking.spatially_varying import Variation, variation_to_text
from engine.transport.baking.visibility import Receivers
from engine.transport.baking.visibility_record import is_kept, keep_visibility
from engine.transport.gaussian.compress import NAMES, check, restore, size_bytes
from engine.transport.gaussian.compress import compress as compress_lobes
from engine.transport.gaussian.diffuse import CHUNK, DiffuseTransfer, send_light
from engine.transport.gaussian.error import GaussianError, Known, Weighting, change, gaussian_error
from engine.transport.gaussian.fitting.fit import (
    Block,
    Fit,
    FitSettings,
    Piece,
    TransportSamples,
    blocks,
    fit_piece,
    fit_pieces,
    fit_vertices,
)
from engine.transport.gaussian.fitting.flood_fill import Flood, flood
from engine.transport.gaussian.fitting.lobes import Lobes
from engine.transport.gaussian.fitting.views import VIEWS
from engine.transport.gaussian.indirect import indirect_samples
from engine.transport.gaussian.samples import GlossySurface, direct_samples, glossy_surface
from engine.transport.gaussian.transfer import GaussianTransport
from engine.transport.sh.brdf_table import lambert_table
from engine.transport.sh.transfer import ShTransport

Indices = NDArray[np.int64]

KIND, WORKING = "gaussian", "gaussian-fit"

#: Vertices that tell how long a bake takes and which weights are better, directions they are seen from, and the
#: environment and edge of its cube map that this is judged under unless another one is given.
PROBES, PROBE_VIEWS, TEST_ENVIRONMENT, TEST_EDGE = 64, 20, "studio", 64

#: Edge of the cube map that visibility is counted over, that of wavelets, so that one record serves both.
EDGE = WaveletSettings.cube

#: Settings of the fit of one lobe, which is soon near its minimum: in some 55 % of the time, errors of radiance of
#: seven glossy BRDFs under three environments are .95 to 1.02 times those of a fit that goes on until nothing moves.
QUICK = {"sweeps": 1, "steps": (4, 0, 6)}

#: Percentile of the relative distances that is called the worst: single pairs that reflect next to nothing may be far.
WORST = 99.0


@dataclass(frozen=True)
class BakeSettings:
    """Settings of a bake; UsageError for impossible ones.

    Attributes
    ----------
    lobes : for each vertex and view, 1 to 3, and for direct and indirect light each.
    indirect : with light that reaches a vertex by way of the model.
    samples : directions that the transport towards a view is tabulated at.
    order : of the spherical harmonics of the diffuse part.
    edge, fine : of the cube map that visibility is counted over, as for `wavelet.bake.BakeSettings`.
    weights : of least squares ("plain"), scaled to the energy of the transport ("preserving"), or for direct light the
        better ones and for indirect light, which is known too coarsely to judge, those with all energy ("auto").
    relaxations : passes over neighbours that disagree.
    compress : store lobes as `gaussian.compress` does.
    """

    lobes: int = GaussianSettings.lobes
    indirect: bool = False
    samples: int = GaussianSettings.samples
    order: int = GaussianSettings.order
    edge: int = EDGE
    fine: int = GaussianSettings.fine
    weights: Literal["auto", "plain", "preserving"] = GaussianSettings.weights
    relaxations: int = 2
    compress: bool = GaussianSettings.compress

    def __post_init__(self) -> None:
        FitSettings(lobes=self.lobes, relaxations=self.relaxations)
        asked = {"order": self.order, "cube": self.edge, "fine": self.fine, "weights": self.weights}
        check_values(GaussianSettings, lobes=self.lobes, samples=self.samples, compress=self.compress, **asked)

    @property
    def fit(self) -> FitSettings:
        quick: dict[str, Any] = QUICK if self.lobes == 1 else {}
        return FitSettings(lobes=self.lobes, relaxations=self.relaxations, **quick)

    @property
    def components(self) -> tuple[str, ...]:
        return ("direct", "indirect") if self.indirect else ("direct",)


@dataclass(frozen=True, eq=False)
class Work:
    """A bake that is ready to begin.

    Attributes
    ----------
    model : with everything that transport at its vertices takes; `settings`, and the name of its BRDF.
    variations : as texts.
    error : of direct radiance under the test environment `tested`, the map `cube`, by either way to weigh.
    weights : the way that is taken for each component.
    seconds_per_vertex, visibility_s_per_vertex : that the vertices tried took without their visibility, and for it.
    size_bytes : of the file; with compression an estimate from the vertices tried.
    kept : the folder of records of visibility, if there is one.
    """

    model: GlossySurface
    settings: BakeSettings
    brdf: str
    variations: tuple[str, ...]
    tested: str
    cube: CubeMap
    error: GaussianError
    weights: tuple[Weighting, ...]
    seconds_per_vertex: float
    visibility_s_per_vertex: float
    size_bytes: int
    kept: Path | None = None

    @property
    def surface(self) -> Mesh:
        return self.model.mesh

    @property
    def vertices(self) -> int:
        return len(self.model.mesh.positions)

    @cached_property
    def order(self) -> Flood:
        """The vertices of the model in the order in which they are fitted."""
        return flood(self.surface, self.model.ground_vertex)

    @cached_property
    def parts(self) -> tuple[Indices, ...]:
        """The same in blocks."""
        return blocks(self.order)


@dataclass(frozen=True, eq=False)
class Baked:
    """An open transport and what it took.

    `bake_s` are the seconds of all of it, `visibility_s` those in which visibility was found, by rays or in a
    record, and `diffuse_s` those of the diffuse part; `figures` are those of the file (`figures_of`).
    """

    transport: GaussianTransport
    file: TransportFile
    bake_s: float
    visibility_s: float
    diffuse_s: float
    resumed_chunks: int
    chunks: int
    unoccluded_vertices: int
    figures: dict[str, float]


def prepare(
    mesh: Mesh,
    brdf: Brdf,
    settings: BakeSettings,
    ground: Ground | None = None,
    variations: Sequence[Variation] = (),
    environment: tuple[str, CubeMap] | None = None,
    probes: int = PROBES,
    kept: Path | None = None,
    kinds: Kinds | None = None,
) -> Steps[Work]:
    """Lay out the bake of `mesh`, on a ground where there is one, and try `probes` vertices; nothing is written.

    `variations` move parameters from vertex to vertex. `environment` is the name and cube map that errors are
    measured under, the studio by default; `kept` is the folder of records of visibility. UsageError where nothing
    about the BRDF is glossy, or it has no such parameter. With `kinds`, each part of the model has its own BRDF.
    """
    yield Step(0.0, "looking at the BRDF")
    model = glossy_surface(mesh, brdf, ground, variations, kinds)
    texts = tuple(variation_to_text(variation) for variation in variations)
    return (yield from lay_out(model, settings, texts, environment, probes, kept))


def lay_out(
    model: GlossySurface,
    settings: BakeSettings,
    variations: tuple[str, ...] = (),
    environment: tuple[str, CubeMap] | None = None,
    probes: int = PROBES,
    kept: Path | None = None,
) -> Steps[Work]:
    """As `prepare`, of a model that is ready; `variations` as texts."""
    if all(material.glossy is None for material in model.coarse[1]):
        raise UsageError("this BRDF has no glossy part; bake it with --mode sh or wavelet")
    name = text_of_bake(model.brdf, model.kinds)
    tested, cube = environment or (TEST_ENVIRONMENT, cube_of(open_environment(TEST_ENVIRONMENT), TEST_EDGE))
    tried = yield from part(_try(model, settings, cube, probes), 0.05, 1.0)
    chosen = settings.weights
    weights: tuple[Weighting, ...] = ((tried.error.better, "preserving") if chosen == "auto" else (chosen, chosen))[
        : len(settings.components)
    ]
    times = tried.seconds, tried.visibility_s
    return Work(model, settings, name, variations, tested, cube, tried.error, weights, *times, tried.size_bytes, kept)


@dataclass(frozen=True, eq=False)
class _Tried:
    error: GaussianError
    seconds: float
    visibility_s: float
    size_bytes: int


def _try(model: GlossySurface, settings: BakeSettings, cube: CubeMap, probes: int) -> Steps[_Tried]:
    """Trial bake of vertices that lie apart: the error in radiance, seconds for a vertex, and the size of the file."""
    chosen = np.unique(np.linspace(0, model.ground_vertex - 1, probes).astype(np.int64))
    yield from hold_visibility(model.of, settings.edge, settings.fine, chosen[:1])
    started = time.perf_counter()
    seen = yield from part(hold_visibility(model.of, settings.edge, settings.fine, chosen), 0.0, 0.1)
    visibility_s = (time.perf_counter() - started) / len(chosen)
    model = replace(model, seen=seen)
    diffuse = DiffuseTransfer(model, settings.order, settings.edge, settings.fine)
    alone = Fit.empty(1, settings.lobes).lobes
    found, seconds = [], 0.0
    for component in settings.components:
        for vertices in (chosen[:1], chosen):  # the first one waits for kernels to be made ready
            yield Step(0.1, "fitting some vertices to see how long it takes")
            started = time.perf_counter()
            around = [np.zeros(0, np.int64)] * len(vertices)
            tried = fit_vertices(_samples(model, settings, component, vertices), around, alone, settings.fit)
        seconds += (time.perf_counter() - started) / len(chosen)
        found.append(tried)
    diffuse.rows(chosen[:1])
    started = time.perf_counter()
    rows = diffuse.rows(chosen)
    seconds += (time.perf_counter() - started) / len(chosen)
    steps = gaussian_error(model, diffuse, Known(chosen, found[0], rows), cube, views=PROBE_VIEWS)
    error = yield from part(steps, 0.2, 1.0)
    size = _size_bytes(model, settings, [each.lobes for each in found])
    return _Tried(error, seconds, visibility_s, size)


def _samples(model: GlossySurface, settings: BakeSettings, component: str, vertices: Indices) -> TransportSamples:
    of = direct_samples if component == "direct" else indirect_samples
    return of(model, vertices, settings.samples)


def _size_bytes(model: GlossySurface, settings: BakeSettings, tried: Sequence[Lobes]) -> int:
    """Bytes of the file, by one with all arrays at their size; those of compressed lobes scaled from `tried`."""
    count, channels = model.ground_vertex, 1 if model.is_uniform and not settings.indirect else 3
    arrays: dict[str, NDArray[Any]] = {
        "matt": np.zeros((len(model.mesh.positions), channels, settings.order**2), np.float32)
    }
    for component, lobes in zip(settings.components, tried, strict=True):
        for name, array in _store(lobes, settings.compress).items():
            rows = round(len(array) * count / len(lobes))
            arrays[f"{component}_{name}"] = np.zeros((rows, *array.shape[1:]), array.dtype)
    return plan_transport(KIND, model.mesh, {}, arrays, {}, np.zeros(1, np.int64)).size_bytes


def _store(lobes: Lobes, compress: bool) -> dict[str, NDArray[Any]]:
    """The arrays that lobes are stored as, by name."""
    if compress:
        return compress_lobes(lobes)
    return {"weight": lobes.weight, "mean": lobes.mean, "sigma": lobes.sigma}


def casts_rays(work: Work) -> bool:
    """False where the record of visibility holds all that the bake needs, which is of direct light alone."""
    return work.settings.indirect or not _needs_no_rays(work)


def _needs_no_rays(work: Work) -> bool:
    return is_kept(keep_visibility(work.model.of, work.kept), work.settings.edge, work.settings.fine)


def estimate_s(work: Work) -> float:
    """Seconds that the bake will take, from the vertices that were tried."""
    rest = len(work.surface.positions) - work.model.ground_vertex
    visibility_s = 0.0 if _needs_no_rays(work) else work.visibility_s_per_vertex * work.vertices
    return visibility_s + work.seconds_per_vertex * (work.model.ground_vertex + 0.1 * rest)


#: What a task is (a method of `Baker`), and what that takes.
Task = tuple[str, Any]


class Baker:
    """Does the tasks of a bake, each by itself: in this process, or on a worker of a cluster (`maker`).

    `model` needs no visibility: tasks bring that of their vertices. `sent` is light between parts of the model.
    """

    def __init__(self, model: GlossySurface, settings: BakeSettings, sent: NDArray[np.float32] | None = None) -> None:
        self._packed = dict[int, bytes]()
        seen = HeldVisibility(settings.edge, settings.fine, self._packed)
        self._model, self._settings = replace(model, seen=seen), settings
        self._diffuse = DiffuseTransfer(self._model, settings.order, settings.edge, settings.fine, sent)

    def __call__(self, task: Task) -> Any:
        """The result of a task."""
        name, asked = task
        return getattr(self, name)(*asked)

    def look(self, number: int, vertices: Indices, as_block: bool) -> Seen:
        """Visibility of a block by rays."""
        settings = self._settings
        return look_at(self._model.of, settings.edge, settings.fine, (number, vertices, as_block))

    def fit(self, component: str, piece: Piece, packed: list[bytes]) -> tuple[int, NDArray[np.float32]]:
        """The number and the fit, in one array, of some vertices that see what is `packed`."""
        self._see(piece.vertices, packed)
        samples = _samples(self._model, self._settings, component, piece.vertices)
        return piece.number, _flat(fit_piece(piece, samples, self._settings.fit))

    def rows(self, vertices: Indices, packed: list[bytes]) -> tuple[Indices, NDArray[np.float32]]:
        """The diffuse part of some vertices that see what is `packed`."""
        self._see(vertices, packed)
        return vertices, self._diffuse.rows(vertices)

    def _see(self, vertices: Indices, packed: list[bytes]) -> None:
        self._packed.clear()
        if packed:
            self._packed.update(zip(vertices.tolist(), packed, strict=True))


def maker(recipe: Recipe) -> Baker:
    """Baker of the tasks of a bake, from its recipe (`recipe_of`)."""
    health = Health(MappingProxyType({"texture_coordinates_made": recipe["texture_coordinates_made"]}))
    arrays = {name: recipe[name] for name in ("positions", "normals", "uv", "faces", "brushing")}
    mesh = Mesh(**arrays, name="", health=health)
    caster = RayCaster(recipe["shading_positions"], recipe["shading_faces"])
    of = Receivers(caster, recipe["origin"], recipe["normal"], recipe["free"])
    same = {name: recipe[name] for name in ("ground_vertex", "ground_albedo", "brdf", "varied", "frames", "kinds")}
    return Baker(GlossySurface(mesh=mesh, of=of, **same), BakeSettings(**recipe["settings"]), recipe.get("sent"))


def recipe_of(work: Work, sent: NDArray[np.float32] | None = None) -> Recipe:
    """Data that all tasks of `work` share, for `maker`; `sent` by `send_light`."""
    model = work.model
    mesh, of = model.mesh, model.of
    return {
        "positions": mesh.positions,
        "normals": mesh.normals,
        "uv": mesh.uv,
        "faces": mesh.faces,
        "texture_coordinates_made": mesh.health.figures.get("texture_coordinates_made", 0.0),
        "brushing": mesh.brushing,
        "ground_vertex": model.ground_vertex,
        "ground_albedo": model.ground_albedo,
        "brdf": model.brdf,
        "varied": model.varied,
        "kinds": model.kinds,
        "frames": model.frames,
        "shading_positions": of.caster.positions,
        "shading_faces": of.caster.faces,
        "origin": of.origin,
        "normal": of.normal,
        "free": of.free,
        "settings": asdict(work.settings),
        **({} if sent is None else {"sent": sent}),
    }


def _open(work: Work, cluster: str | None, sent: NDArray[np.float32] | None = None) -> AbstractContextManager[Run]:
    """Run the tasks of `work`: in this process, or by the workers of a `cluster`."""
    return open_workers(
        Baker(work.model, work.settings, sent) if cluster is None else Remote(cluster, maker, recipe_of(work, sent))
    )


def bake(path: str | os.PathLike[str], work: Work, cluster: str | None = None) -> Steps[Baked]:
    """Bake into the file `path`, going on where an equal bake was interrupted; its `Step.partial` is None.

    With the address of a `cluster`, its workers do the tasks (`engine.transport.baking.chunks`), to the same bytes.
    OutputError where the file cannot be written. Closing the generator keeps what is done for the next run.
    """
    yield Step(0.0, f"preparing {count_text(work.vertices)} vertices, {size_text(work.size_bytes)}")
    started = time.perf_counter()
    plan = _working_plan(work)
    with resumable_file(path, plan.size_bytes, plan.beginning) as output, _open(work, cluster) as run:
        of, settings = keep_visibility(work.model.of, work.kept), work.settings
        look = lambda asked: each_of(run, (("look", each) for each in asked))  # noqa: E731
        seen = yield from part(gather_visibility(of, settings.edge, settings.fine, look), 0.0, 0.25)
        visibility_s = time.perf_counter() - started
        filling = _Filling(work, TransportWriter(output, plan), seen, run)
        resumed = plan.chunks - len(filling.missing)
        shares = np.linspace(0.25, 0.95, len(work.settings.components) + 1)
        fits = []
        for number, component in enumerate(work.settings.components):
            fits.append((yield from part(filling.fit(component), shares[number], shares[number + 1])))
        before = time.perf_counter()
        rows = yield from part(_diffuse_rows(work, seen, run, cluster), 0.95, 0.99)
        diffuse_s = time.perf_counter() - before
        yield Step(0.99, "writing")
        figures, lobes = figures_of(work, fits), _weigh(work, fits)
        stored = [_store(each, work.settings.compress) for each in lobes]
        if work.settings.compress:
            figures |= _compression(work, lobes, stored)
        write_transport(path, _plan(work, stored, rows, figures))
        output.discard()
    file = open_transport(path)
    took = time.perf_counter() - started
    free = int(np.count_nonzero(work.model.of.free[: work.model.ground_vertex]))
    return Baked(transport_of(file), file, took, visibility_s, diffuse_s, resumed, plan.chunks, free, figures)


class _Filling:
    """Fits the components of a bake, keeping every block in the working file."""

    def __init__(self, work: Work, writer: TransportWriter, seen: HeldVisibility, run: Run) -> None:
        self._work, self._writer, self._seen, self._run = work, writer, seen, run
        self.missing = set(writer.missing)

    def fit(self, component: str) -> Steps[Fit]:
        """Lobes of one component; blocks that are there from before are taken as they are."""
        work, started = self._work, time.perf_counter()
        first = work.settings.components.index(component) * len(work.parts)
        steps = fit_pieces(
            work.order,
            partial(self._run_pieces, component),
            work.settings.fit,
            known=lambda index: None if first + index in self.missing else self._known(first + index),
        )
        fresh = 0

        def keep(step: Step) -> Step:
            nonlocal fresh
            block = step.partial
            if isinstance(block, Block) and first + block.index in self.missing:
                self.missing.remove(first + block.index)
                self._writer.put(first + block.index, {"values": _flat(block.fit)})
                fresh += len(block.vertices)
            return Step(step.done, f"{step.note}, {component}{_estimate_time_left(started, fresh, step.done, work)}")

        return (yield from relay(steps, keep))

    def _run_pieces(self, component: str, ask: Callable[[], Piece | None]) -> Generator[tuple[int, Fit], None, None]:
        """The fits of the pieces that are asked for."""
        vertices = dict[int, int]()

        def next_task() -> Task | None:
            piece = ask()
            if piece is None:
                return None
            vertices[piece.number] = len(piece.vertices)
            packed = self._seen.choose(piece.vertices) if component == "direct" else []
            return "fit", (component, piece, packed)

        with closing(self._run(next_task)) as found:
            for number, values in found:
                yield number, _unflat(values, vertices.pop(number), self._work.settings.lobes)

    def _known(self, chunk: int) -> Fit:
        vertices = self._work.parts[chunk % len(self._work.parts)]
        return _unflat(self._writer.get(chunk)["values"], len(vertices), self._work.settings.lobes)


def _estimate_time_left(started: float, fresh: int, done: float, work: Work) -> str:
    """Time left, from the vertices that were fitted in this run."""
    if not fresh or done >= 0.95:
        return ""
    left = (time.perf_counter() - started) / fresh * (1.0 - done / 0.95) * work.model.ground_vertex
    return f", {time_left(left)}"


def _working_plan(work: Work) -> TransportPlan:
    """The working file: a chunk of numbers for each block of each component, whichever weights are wanted later."""
    each = _flat(Fit.empty(1, work.settings.lobes)).size
    counts = [len(vertices) * each for _ in work.settings.components for vertices in work.parts]
    settings = {name: value for name, value in _settings(work).items() if name not in ("weights", "compress", "taken")}
    bounds = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
    return plan_transport(WORKING, work.surface, settings, {}, {"values": ("<f4", ())}, bounds)


def _settings(work: Work) -> dict[str, Any]:
    """Settings of a bake, as they stand in the file."""
    return {
        **asdict(work.settings),
        "ground_vertex": work.model.ground_vertex,
        "ground_albedo": work.model.ground_albedo,
        "brdf": work.brdf[:1000],
        "variations": [text[:1000] for text in work.variations],
        "grazing": work.model.material.diffuse.grazing,
        "taken": list(work.weights),
        **({} if work.model.kinds is None else work.model.kinds.settings()),
    }


def _flat(fitted: Fit) -> NDArray[np.float32]:
    return np.concatenate([array.reshape(-1) for array in fitted.arrays()])


def _unflat(values: NDArray[np.float32], vertices: int, lobes: int) -> Fit:
    fit, start = Fit.empty(vertices, lobes), 0
    for array in fit.arrays():
        array[...] = values[start : start + array.size].reshape(array.shape)
        start += array.size
    return fit


def _diffuse_rows(work: Work, seen: HeldVisibility, run: Run, cluster: str | None) -> Steps[NDArray[np.float32]]:
    """(V, C, order²) the diffuse part of all vertices, and the ground; `run` does tasks without light between parts."""
    model, settings = replace(work.model, seen=seen), work.settings
    diffuse = DiffuseTransfer(model, settings.order, settings.edge, settings.fine)
    if not settings.indirect:
        return (yield from _gather_rows(diffuse, seen, run))
    sent = yield from part(send_light(diffuse, cluster), 0.0, 0.4)
    with _open(work, cluster, sent) as again:
        return (yield from part(_gather_rows(replace(diffuse, sent=sent), seen, again), 0.4, 1.0))


def _gather_rows(diffuse: DiffuseTransfer, seen: HeldVisibility, run: Run) -> Steps[NDArray[np.float32]]:
    """The same by the tasks of `run`."""
    count, done = len(diffuse.surface.mesh.positions), 0
    rows = scratch_array((count, diffuse.channels, diffuse.order**2), np.float32)
    parts = (np.arange(start, min(start + CHUNK, count)) for start in range(0, count, CHUNK))
    with closing(each_of(run, (("rows", (some, seen.choose(some))) for some in parts))) as found:
        for vertices, values in found:
            rows[vertices], done = values, done + len(vertices)
            yield Step(done / count, "baking the diffuse part")
    return rows


def figures_of(work: Work, fits: Sequence[Fit]) -> dict[str, float]:
    """Figures of the fit: distances relative to the transport, pairs of vertex and view alike, energy and flips."""
    figures: dict[str, float] = {}
    for component, weights, fitted in zip(work.settings.components, work.weights, fits, strict=True):
        error = fitted.choose_lit(fitted.error_rel if weights == "plain" else fitted.preserving_error_rel)
        mean, plain = (
            float(each.mean()) if each.size else 0.0 for each in (error, fitted.choose_lit(fitted.error_rel))
        )
        energy = float(fitted.energy.sum(dtype=np.float64))
        kept = sum(float(each.sum()) for _, each in fitted.energies())
        figures |= {
            f"{component}_error_rel_mean": mean,
            f"{component}_error_rel_worst": float(np.percentile(error, WORST, overwrite_input=True))
            if error.size
            else 0.0,
            f"{component}_plain_error_rel_mean": plain,
            f"{component}_plain_energy_lost_rel": 1.0 - kept / energy if energy > 0.0 else 0.0,
            **{f"{component}_{name}": float(value) for name, value in fitted.health.figures.items()},
        }
    return figures


def _weigh(work: Work, fits: Sequence[Fit]) -> list[Lobes]:
    """The lobes of each component with the weights that are taken."""
    taken = zip(work.weights, fits, strict=True)
    return [fitted.lobes if weights == "plain" else fitted.preserving() for weights, fitted in taken]


def _compression(work: Work, lobes: Sequence[Lobes], stored: Sequence[dict[str, NDArray[Any]]]) -> dict[str, float]:
    """Bytes of the lobes before and after, and by how much the radiance under the test environment changes (RMS)."""
    pairs = zip(lobes, stored, strict=True)
    error = [change(each, restore(arrays, len(each), each.count), work.cube) for each, arrays in pairs]
    return {
        "uncompressed_bytes": float(sum(size_bytes(_store(each, False)) for each in lobes)),
        "compressed_bytes": float(sum(size_bytes(arrays) for arrays in stored)),
        "compression_error_rel": max(error),
    }


def _plan(
    work: Work, stored: Sequence[dict[str, NDArray[Any]]], rows: NDArray[np.float32], figures: dict[str, float]
) -> TransportPlan:
    """The file, all of it known."""
    diffuse = DiffuseTransfer(work.model, work.settings.order, work.settings.edge, work.settings.fine)
    arrays: dict[str, NDArray[Any]] = {"matt": rows, **({} if work.model.kinds is None else work.model.kinds.arrays())}
    for component, some in zip(work.settings.components, stored, strict=True):
        arrays |= {f"{component}_{name}": array for name, array in some.items()}
    albedo = diffuse.albedo if rows.shape[1] == 1 else (1.0, 1.0, 1.0)
    settings = {**_settings(work), "matt_albedo": list(albedo), "tested": work.tested, "figures": figures}
    return plan_transport(KIND, work.surface, settings, arrays, {}, np.zeros(1, np.int64))


def transport_of(file: TransportFile) -> GaussianTransport:
    """The transport in an open file; InputError where it holds another kind, or what cannot be."""
    return read_as(file, KIND, _transport_of)


def _transport_of(file: TransportFile) -> GaussianTransport:
    settings, arrays = file.settings, file.arrays
    asked = BakeSettings(**{name: settings[name] for name in BakeSettings.__dataclass_fields__})
    first, albedo = int(settings["ground_vertex"]), float(settings["ground_albedo"])
    if not 0 <= first <= len(file.mesh.positions) or not 0.0 <= albedo <= 1.0:
        raise ValueError("its ground is none")
    parts_in(file, first)
    components = tuple(_lobes_of(arrays, component, asked, first) for component in asked.components)
    red, green, blue = (float(value) for value in settings["matt_albedo"])
    if arrays["matt"].dtype != np.float32:
        raise ValueError("its rows are of another type")
    table = lambert_table(Lambert((red, green, blue)), asked.order)
    diffuse = ShTransport(file.mesh, first, True, albedo, table, asked.indirect, arrays["matt"])
    words = (str(settings["brdf"]), bool(settings["grazing"]))
    return GaussianTransport(file.mesh, first, albedo, components, diffuse, *words)


def _lobes_of(arrays: Mapping[str, NDArray[Any]], component: str, asked: BakeSettings, vertices: int) -> Lobes:
    """Lobes of one component, checked: finite, not negative, as wide as lobes may be, with means of length 1."""
    if asked.compress:
        names = NAMES
        return restore({name: arrays[f"{component}_{name}"] for name in names}, vertices, asked.lobes)
    lobes = Lobes(*(arrays[f"{component}_{name}"] for name in ("weight", "mean", "sigma")))
    if lobes.sigma.shape != (vertices, VIEWS, asked.lobes) or lobes.weight.dtype != np.float32:
        raise ValueError(f"its lobes of {component} light are those of other vertices")
    check(lobes)
    return lobes
