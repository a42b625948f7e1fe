"""Measuring what this machine takes for each part of a bake, of a rotated environment and of a frame.

`quick_profile` takes a second or two, whatever else the machine does: the rates of another machine, which the program
ships, times what three probes take here over what they took there. Probes are timed by the CPU seconds of one thread
or of the process, the least of several runs, so that waiting for a CPU that others have does not count. `calibrate`
measures each rate here, in some ten seconds of an idle machine; it is asked for.

There every part runs on the built-in torus knot of 50,000 vertices, at some of them where it is done vertex by vertex,
through the code that bakes and images run, and at few values of its parameter: between and beyond them a rate is a
power law. The shortest of some runs counts. Frames are measured by `engine.planning.costs.frame_rates`.
"""

from __future__ import annotations

import json
import math
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache, partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from engine.brdf.brdf import brdf_from_text
from engine.brdf.models.diffuse import Lambert
from engine.core.one_thread import one_thread
from engine.core.steps import Step, Steps, drain, part
from engine.core.stopwatch import DISTURBED, background_load, read_clock, shortest
from engine.factor.hemisphere_map import HemisphereMap
from engine.factor.separable_factors import SeparableFactors
from engine.geometry.camera import frame
from engine.geometry.mesh import Mesh
from engine.geometry.ray_caster import caster_of
from engine.geometry.shapes import shape
from engine.light.environment import EnvironmentMap
from engine.planning.costs.cost_model import BUSY, ON_CPU, CostModel, basis_values, machine_name
from engine.planning.costs.frame_rates import drawing_frames, frame_rates, make_lit_scene, round_mesh
from engine.planning.costs.load import Rates, hemisphere, measure_closed_share, measure_coverage, spread, threads
from engine.render.reference import ReferenceImage, reference
from engine.scene.scene import Scene
from engine.transport.baking import visibility_kernel
from engine.transport.baking.file import plan_transport, writing
from engine.transport.baking.held_visibility import hold_visibility
from engine.transport.baking.settings import GaussianSettings
from engine.transport.baking.visibility import Receivers, find_unshaded, portion, receivers, visibility_shares
from engine.transport.gaussian.bake import EDGE
from engine.transport.gaussian.fitting.fit import Fit, FitSettings, TransportSamples, fit_vertices
from engine.transport.gaussian.indirect import indirect_samples
from engine.transport.gaussian.samples import GlossySurface, direct_samples
from engine.transport.sh import kernel as sh_kernel
from engine.transport.sh.bake import BakeSettings, Work, default_edge, prepare
from engine.transport.sh.brdf_table import lambert_table
from engine.transport.sh.interreflection import gather
from engine.transport.sh.lighting import project, turn_about_y
from engine.transport.sh.transfer import (
    diffuse_vectors,
    matrices,
    products,
    round_rows,
    tangent_frames,
    texel_basis,
    visibility_harmonics,
)
from engine.transport.wavelet import bake as wavelet_bake
from engine.transport.wavelet.haar import FACES
from engine.transport.wavelet.lighting import lighting_of
from engine.transport.wavelet.transfer import (
    Vectors16,
    WaveletTransport,
    cube_texels,
    light_maps,
    relight_transport,
    transport_vectors,
    vertex_frames,
)

#: Vertices at which rows are measured, as many as a chunk has, and a bounce.
SAMPLED, BOUNCED = 64, 8

#: Portions of vertices that each thread gets where visibility is measured, and vertices and rays of each otherwise.
PORTIONS, PROBES, RAYS = 4, 256, 64

#: Orders, edges and coefficients that are measured.
ORDERS, EDGES, KEPT = (3, 8, 12), (16, 64), (24, 96, 384)

#: The order whose tables would take seconds: products of three are as many as the eighth power of the order.
HIGHEST = 15

#: Edge of the cube maps that are turned into spherical harmonics: for each texel of finer ones it is as much.
SEEN_EDGE = 16

#: Lobes that are measured, and directions that each view is tabulated at, as in a bake.
LOBES, DIRECTIONS = (1, 2, 3), 128

#: Rows of the large and the small map that is rotated, by how much in rad, and the edges of its cube map.
MAP_ROWS, SMALL_ROWS, TURN, LIGHT_EDGES = 512, 128, 0.1, (16, 64)

#: Most times that a part is measured, and the seconds after which it is not begun again.
ROUNDS, ROUNDS_S = 3, 3.0

#: Values of rows, and bytes of a file.
VALUES, WRITTEN = 10_000_000, 1 << 24

#: Most runs of a measurement that takes milliseconds, and the seconds after which no further run begins.
RUNS, ENOUGH_S = 12, 0.1

#: Side of the image of the reference, whose pixels are a batch, how many times as many samples of a pixel the longer
#: of two has, and the points that its longer paths touch.
SIDE, PATHS, POINTS = 128, 4, 3

#: A BRDF with a diffuse and a glossy part, and the one of bakes whose numbers mean nothing.
GLOSSY, DIFFUSE = "ggx:kd=0.5,alpha=0.3,f0=0.04", Lambert((0.5, 0.5, 0.5))

Tables = dict[str, Rates]


def calibrate() -> Steps[tuple[CostModel, float]]:
    """Measure every rate of this machine, and the share of the CPUs that other programs had meanwhile.

    Some ten seconds, longer where others work too or kernels have to be compiled. Without OpenGL, frames are the
    CPU's. A part beside which others worked is measured again; rates are too long by what others had of the CPUs.
    """
    tables: Tables = {}
    shares, renderer = [], ""
    place, share = yield from part(quietest(partial(_place, shape("torus-knot")), tables), 0.0, 0.1)
    shares.append(share)
    parts = (
        (partial(_spherical_harmonics, place), 0.1, 0.3),
        (partial(_wavelets, place), 0.3, 0.35),
        (partial(_gaussians, place), 0.35, 0.5),
        (partial(_lights, place.mesh), 0.5, 0.6),
        (partial(_reference, place), 0.6, 0.65),
        (frame_rates, 0.65, 1.0),
    )
    for measure, begin, end in parts:
        renderer, share = yield from part(quietest(measure, tables), begin, end)
        shares.append(share)
    yield Step(1.0, "measured")
    load = float(np.average([share.load for share in shares], weights=[share.seconds for share in shares]))
    return CostModel(machine_name(), renderer, tables, load <= BUSY, time.time()), load


#: Rates that one thread works off; all others are shared by all threads.
ALONE = ("ray", "sh-products", "sh-basis", "light-", "file-byte", "wavelet-fixed", "receivers")

#: Vertices of the mesh of the probes, runs of a probe, rows of the matrices, and lights and side of the frame.
PROBE_VERTICES, PROBE_RUNS, PROBE_ROWS, PROBE_LIGHTS, PROBE_SIDE = 6_000, 7, 384, 16, 192


def quick_profile() -> Steps[CostModel]:
    """The shipped rates scaled to this machine: a second or two, also while other programs work.

    Frames of a graphics card are measured, since rates of a CPU say nothing of them.
    """
    yield Step(0.0, "measuring the speed of the CPU")
    shipped = read_shipped()
    own = measure_probes()
    scale = {name: own[name] / shipped.probes[name] for name in own}
    cpu = math.sqrt(scale["rays"] * scale["matrices"])
    crowd = shipped.threads / threads()
    tables: Tables = {
        name: _scale(rates, cpu * (1.0 if name.startswith(ALONE) else crowd)) for name, rates in shipped.tables.items()
    }
    yield Step(0.3, "measuring a frame")
    renderer, frame_s = measure_frame()
    if renderer.startswith(SOFTWARE):
        kind = renderer.split()[0]
        factor = frame_s / shipped.frame_s[kind] * crowd
        tables |= {name: _scale(rates, factor) for name, rates in shipped.frames[kind].items()}
    else:
        renderer = yield from part(frame_rates(tables), 0.3, 1.0)
    yield Step(1.0, "measured")
    return CostModel(machine_name(), renderer, tables, False, time.time())


def _scale(rates: Rates, factor: float) -> Rates:
    return tuple((parameter, rate * factor) for parameter, rate in rates)


#: Beginnings of the names of what draws on the CPU.
SOFTWARE = ("llvmpipe", ON_CPU)

#: The rates that the program ships: `python -m benchmarks.transport.rates` writes them.
SHIPPED = Path(__file__).resolve().parents[3] / "resources" / "rates" / "machine.json"


@dataclass(frozen=True)
class Shipped:
    """Rates of another machine of so many `threads`: `tables` but for frames, which are by what draws them.

    `probes` and `frame_s` are what `measure_probes` and `measure_frame` found there, in CPU seconds.
    """

    threads: int
    tables: Tables
    frames: dict[str, Tables]
    probes: dict[str, float]
    frame_s: dict[str, float]


@cache
def read_shipped() -> Shipped:
    """The shipped rates."""
    record = json.loads(SHIPPED.read_text("utf-8"))
    frames = {kind: _read_tables(tables) for kind, tables in record["frames"].items()}
    return Shipped(record["threads"], _read_tables(record["tables"]), frames, record["probes"], record["frame_s"])


def _read_tables(record: dict[str, Any]) -> Tables:
    return {name: tuple((parameter, rate) for parameter, rate in rates) for name, rates in record.items()}


def measure_probes() -> dict[str, float]:
    """CPU seconds of rays that go their own ways and of a product of matrices, each on one thread."""
    mesh = round_mesh(PROBE_VERTICES)
    caster, count = caster_of(mesh), PROBES * RAYS
    random = np.random.default_rng(0)
    origin, direction = random.normal(size=(2, count, 3))
    matrix = random.random((PROBE_ROWS, PROBE_ROWS), np.float32)
    with one_thread():
        return {
            "rays": _least_cpu_s(lambda: caster.occluded(origin, direction), time.thread_time),
            "matrices": _least_cpu_s(lambda: matrix @ matrix, time.thread_time),
        }


def measure_frame() -> tuple[str, float]:
    """Name of what draws, and CPU seconds of the process for a frame of some lights; 0 for a graphics card."""
    mesh = round_mesh(PROBE_VERTICES)
    scene = replace(make_lit_scene(PROBE_LIGHTS, mesh), camera=frame(mesh.positions))
    with drawing_frames((PROBE_SIDE,)) as (name, draw):
        if not name.startswith(SOFTWARE):
            return name, 0.0
        return name, _least_cpu_s(lambda: draw(scene, scene.camera, PROBE_SIDE), time.process_time)


def _least_cpu_s(work: Callable[[], object], clock: Callable[[], float]) -> float:
    """The least of some runs after one that warms up."""
    work()
    times = []
    for _ in range(PROBE_RUNS):
        started = clock()
        work()
        times.append(clock() - started)
    return max(min(times), 1e-9)


class Share(NamedTuple):
    """The share of the CPUs that other programs had for so many seconds."""

    load: float
    seconds: float


def quietest(measure: Callable[[Tables], Steps[Any]], tables: Tables) -> Steps[tuple[Any, Share]]:
    """Fill `tables` with what `measure` finds; its result, and what others had of the CPUs meanwhile.

    Of at most `ROUNDS` the one counts that others disturbed least, and none follows one that they left alone: a program
    that keeps one of two CPUs busy makes work that threads share 1.7 times as long.
    """
    found: list[tuple[Share, Tables, Any]] = []
    begun = time.perf_counter()
    while True:
        started, before, filled = time.perf_counter(), read_clock(), Tables()
        result = yield from measure(filled)
        share = Share(background_load(before, read_clock()), time.perf_counter() - started)
        found.append((share, filled, result))
        is_late = len(found) == ROUNDS or time.perf_counter() - begun > ROUNDS_S
        if is_late or share.load <= DISTURBED:
            break
    share, filled, result = min(found, key=lambda each: each[0].load)
    tables.update(filled)
    return result, share


@dataclass(frozen=True, eq=False)
class _Place:
    """A mesh with some vertices that are not open, what these see by the edge of the cube map, and rays there."""

    mesh: Mesh
    of: Receivers
    vertices: NDArray[np.int64]
    counts: dict[int, NDArray[np.uint8]]
    ray_s: float
    closed: float

    @property
    def frames(self) -> NDArray[np.float64]:
        return tangent_frames(self.mesh)[self.vertices]


def _place(mesh: Mesh, tables: Tables) -> Steps[_Place]:
    yield Step(0.0, "measuring rays")
    caster_of(mesh)
    of = receivers(mesh)
    tables["receivers"] = _once(shortest(lambda: receivers(mesh), 1) / len(mesh.positions))
    shaded = np.flatnonzero(~of.free)
    tables["visibility"] = tuple((float(edge), _visibility_s(of, shaded, edge)) for edge in EDGES)
    ray_s = _ray_s(of, shaded)
    tables["ray"] = _once(ray_s)
    vertices = shaded[np.linspace(0, len(shaded) - 1, SAMPLED).astype(np.int64)]
    counts = {}
    for edge in EDGES:
        counts[edge] = np.concatenate([some for _, some in visibility_shares(of, edge, 4, vertices)])
    return _Place(mesh, of, vertices, counts, ray_s, measure_closed_share(of))


def _visibility_s(of: Receivers, vertices: NDArray[np.int64], edge: int) -> float:
    some = spread(vertices, PORTIONS * threads() * portion(edge))
    return shortest(lambda: list(visibility_shares(of, edge, 4, some)), 1) / len(some)


def _ray_s(of: Receivers, vertices: NDArray[np.int64]) -> float:
    """Seconds of a ray that goes its own way, on one thread."""
    some = spread(vertices, PROBES)
    origin, direction = visibility_kernel.hemisphere_rays(some, of.origin, of.normal, hemisphere(RAYS))
    return shortest(lambda: of.caster.occluded(origin, direction)) / len(origin)


def _once(seconds: float) -> Rates:
    """A rate that no parameter changes."""
    return ((1.0, seconds),)


def _spherical_harmonics(place: _Place, tables: Tables) -> Steps[None]:
    """Tables that are made once, rows with what is seen known, and bounces at some vertices."""
    names = ("sh-products", "sh-seen", "sh-matrix", "sh-vector", "bounce-matrix", "bounce-vector")
    found: dict[str, list[tuple[float, float]]] = {name: [] for name in names}
    work = drain(prepare(place.mesh, DIFFUSE, BakeSettings(bounces=1)))
    products(ORDERS[0])  # waits for kernels to be made ready
    rays_s = _bounce_rays_s(place)
    tables["bounce-rays"] = _once(rays_s)
    for order in ORDERS:
        yield Step(ORDERS.index(order) / len(ORDERS), f"measuring bakes of spherical harmonics, order {order}")
        products.cache_clear()
        found["sh-products"].append((order, _first_s(partial(products, order))))
        texel_basis.cache_clear()
        basis_s = _first_s(partial(texel_basis, SEEN_EDGE, 2 * order - 1))
        tables["sh-basis"] = _once(basis_s / basis_values(SEEN_EDGE, 2 * order - 1))
        for name, parameter, seconds in _rows_s(place, order):
            found[name].append((parameter, seconds))
        for kind in ("vector", "matrix"):
            seconds = _bounce_s(place, _with_order(work, order, kind == "vector"))
            found[f"bounce-{kind}"].append((order, max(seconds - rays_s, 0.0)))
    last, seconds = found["sh-products"][-1]
    found["sh-products"].append((HIGHEST, seconds * (HIGHEST / last) ** 8))
    tables.update({name: tuple(rates) for name, rates in found.items()})


def _rows_s(place: _Place, order: int) -> list[tuple[str, int, float]]:
    """Seconds of spherical harmonics of what a vertex sees and of a vector, by texel, and of its matrix."""
    edge, higher, count = SEEN_EDGE, 2 * order - 1, len(place.vertices)
    counts, normals, free = place.counts[edge], place.of.normal[place.vertices], place.of.free[place.vertices]
    seen = np.ones((count, higher**2), np.float32)
    with one_thread():
        seen_s = shortest(lambda: visibility_harmonics(counts, 16, edge, higher))
        vector_s = shortest(lambda: diffuse_vectors(counts, 16, edge, order, normals, free))
    frames = place.frames
    matrix_s = shortest(lambda: matrices(seen, frames, free), 3)
    texels = count * FACES * edge**2
    return [
        ("sh-seen", higher, seen_s / texels),
        ("sh-vector", order, vector_s / texels),
        ("sh-matrix", order, matrix_s / count),
    ]


def _first_s(work: Callable[[], object]) -> float:
    """Seconds of a single run: of something that is remembered once it is made, or that takes long."""
    started = time.perf_counter()
    work()
    return time.perf_counter() - started


def _with_order(work: Work, order: int, diffuse: bool) -> Work:
    table = replace(lambert_table(DIFFUSE, order), diffuse=diffuse)
    return replace(work, settings=BakeSettings(order, default_edge(order), bounces=1), table=table)


def _bounce_rays_s(place: _Place) -> float:
    """Seconds of the rays of a bounce at a vertex."""
    some, around = place.vertices[::2], hemisphere(BakeSettings().gather)
    origin, direction = visibility_kernel.hemisphere_rays(some, place.of.origin, place.of.normal, around)
    return shortest(lambda: place.of.caster.intersect(origin, direction)) / len(some)


def _bounce_s(place: _Place, work: Work) -> float:
    """Seconds for a bounce at a vertex."""
    few = place.vertices[:: max(1, len(place.vertices) // BOUNCED)]
    if work.table.diffuse:
        few = place.vertices[::2]
    sent = np.ones((len(place.mesh.positions), 1, work.settings.order**2), np.float32)
    frames = None if work.table.diffuse else np.broadcast_to(np.eye(3), (len(few), 3, 3))
    return shortest(lambda: gather(work.surroundings(place.of), few, sent, frames), 1) / len(few)


def factors_of(terms: int) -> SeparableFactors:
    """Factors of the usual size with numbers of no meaning."""
    hemisphere_map = HemisphereMap("orthographic", wavelet_bake.MAP_SIZE)
    size = (terms, hemisphere_map.size, hemisphere_map.size, 1)
    maps = np.repeat(np.random.default_rng(0).random(size, np.float32), 3, axis=3)
    return SeparableFactors(hemisphere_map, "in-out", maps, maps, True, True, "calibration")


def _wavelets(place: _Place, tables: Tables) -> Steps[None]:
    yield Step(0.0, "measuring bakes of wavelets")
    frames, factors = vertex_frames(place.mesh, True)[place.vertices], factors_of(4)
    maps = light_maps(factors)

    def row_s(edge: int, kept: int) -> float:
        counts, texels = place.counts[edge], cube_texels(edge)
        run = partial(transport_vectors, frames, counts, 16, texels, factors.hemisphere_map, maps, kept)
        return shortest(run) / (4 * len(place.vertices))

    tables["wavelet-fixed"], tables["file-byte"] = _once(_measure_fixed_s()), _once(_measure_write_s())
    rates = [(float(kept), row_s(64, kept)) for kept in KEPT]
    tables["wavelet-row"] = ((16.0, row_s(16, 96)), (64.0, rates[1][1]))
    tables["wavelet-coefficients"] = tuple(rates)


def _measure_fixed_s() -> float:
    """Seconds of a bake of wavelets that do not grow with the mesh: its file, tables of texels, and threads."""
    work = wavelet_bake.prepare(round_mesh(8), factors_of(4), wavelet_bake.BakeSettings(max(EDGES), 96))
    with tempfile.TemporaryDirectory() as folder:
        return shortest(lambda: drain(wavelet_bake.bake(Path(folder) / "least.transport", work)))


def _measure_write_s() -> float:
    """Seconds for a byte of a file: its checksum, packing it and writing it."""
    rows = round_rows(np.random.default_rng(0).random((WRITTEN // 256, 1, 64), np.float32))
    plan = plan_transport("sh", round_mesh(8), {}, {}, {"rows": ("<f4", (1, 64))}, np.array([0, len(rows)]))

    def write(path: Path) -> None:
        with writing(path, plan) as writer:
            writer.put(0, {"rows": rows})

    with tempfile.TemporaryDirectory() as folder:
        return min(_first_s(partial(write, Path(folder) / f"{number}.transport")) for number in range(2)) / WRITTEN


def _gaussians(place: _Place, tables: Tables) -> Steps[None]:
    """Seconds for a vertex: transport tabulated towards all views, and lobes fitted to it."""
    yield Step(0.0, "measuring bakes of Gaussians")
    mesh, count = place.mesh, 4 * threads()
    brdf, frames = brdf_from_text(GLOSSY), tangent_frames(mesh)
    chosen = np.linspace(0, len(mesh.positions) - 1, count).astype(np.int64)
    seen = yield from hold_visibility(place.of, EDGE, GaussianSettings.fine, chosen)
    shaded = GlossySurface(mesh, len(mesh.positions), 0.0, brdf, {}, place.of, frames, seen)
    table_s = shortest(partial(direct_samples, shaded, chosen, DIRECTIONS), 1) / count
    plain = replace(shaded, of=find_unshaded(mesh, place.of.caster), seen=None)
    drawn_s = shortest(partial(direct_samples, plain, chosen, DIRECTIONS), 1) / count
    indirect_samples(shaded, chosen[:1], DIRECTIONS)  # makes what is remembered
    few = chosen[:: max(1, count // (2 * threads()))]
    indirect_s = _first_s(lambda: indirect_samples(shaded, few, DIRECTIONS)) / len(few)
    tables["gaussian-table"] = _once(table_s)
    tables["gaussian-indirect"] = _once(max(indirect_s - drawn_s, 0.0) / _close(place.of, few))
    samples, indirect = direct_samples(shaded, chosen, DIRECTIONS), indirect_samples(shaded, few, DIRECTIONS)
    rates = tuple((float(lobes), _fit_s(samples, lobes)) for lobes in LOBES)
    tables["gaussian-fit"] = rates
    tables["gaussian-indirect-fit"] = _once(_fit_s(indirect, 1) / rates[0][1])


def _fit_s(samples: TransportSamples, lobes: int) -> float:
    """Seconds for a vertex with neighbours that are done, whose lobes it starts from too."""
    count, settings = len(samples), FitSettings(lobes=lobes)
    alone = [np.zeros(0, np.int64)] * count
    known = fit_vertices(samples, alone, Fit.empty(1, lobes).lobes, settings, hurried=True).lobes
    around = [np.delete(np.arange(count), vertex) for vertex in range(count)]
    return _first_s(lambda: fit_vertices(samples, around, known, settings)) / count


def _close(of: Receivers, vertices: NDArray[np.int64]) -> float:
    """The share of the hemispheres of some vertices that is closed, weighted by the cosine."""
    origin, direction = visibility_kernel.hemisphere_rays(vertices, of.origin, of.normal, hemisphere(256))
    return max(float(of.caster.occluded(origin, direction).mean()), 1e-3)


def _lights(mesh: Mesh, tables: Tables) -> Steps[None]:
    """Cost of a rotated environment before, and for each row of, transport; the rows are too many for any cache."""
    yield Step(0.0, "measuring rotated environments")
    random = np.random.default_rng(0)
    large, small = (EnvironmentMap(random.random((rows, 2 * rows, 3), np.float32)) for rows in (MAP_ROWS, SMALL_ROWS))
    _measure_map(tables, "light-sh", ORDERS, lambda order: [partial(_turn, each, order) for each in (small, large)])
    _measure_map(
        tables,
        "light-wavelet",
        LIGHT_EDGES,
        lambda edge: [partial(lighting_of, each, edge, rotation=TURN) for each in (small, large)],
    )
    tables["relight-sh"] = tuple((float(order), _transfer_s(order)) for order in ORDERS)
    lit = lighting_of(large, 64).light
    rates = []
    for kept in KEPT:
        count = 6_000_000 // (6 * kept)
        rates.append(
            (
                float(kept),
                shortest(partial(relight_transport, _wavelet_transport(mesh, count, kept), lit), RUNS, ENOUGH_S)
                / count,
            )
        )
    tables["relight-wavelet"] = tuple(rates)


def _transfer_s(order: int) -> float:
    """Seconds for a value of rows of so many bands, by rows that no cache holds; long rows wait for their own sums."""
    rows = np.ones((VALUES // order**2, 1, order**2), np.float32)
    light, out = np.ones((order**2, 3), np.float32), np.empty((len(rows), 3), np.float32)
    return shortest(lambda: sh_kernel.transfer(rows, light, out), RUNS, ENOUGH_S) / rows.size


def _turn(environment: EnvironmentMap, order: int) -> NDArray[np.float64]:
    return turn_about_y(project(environment, order), TURN)


def _measure_map(
    tables: Tables, name: str, parameters: tuple[int, ...], works: Callable[[int], list[Callable[[], object]]]
) -> None:
    """Base cost of a map, and cost of each of its texels, from a small and a large one."""
    least, more = [], []
    few, many = (2 * rows**2 for rows in (SMALL_ROWS, MAP_ROWS))
    for parameter in parameters:
        small_s, large_s = (shortest(work, RUNS, ENOUGH_S) for work in works(parameter))
        texel_s = max(0.0, large_s - small_s) / (many - few)
        least.append((float(parameter), max(small_s - few * texel_s, 0.0)))
        more.append((float(parameter), texel_s))
    tables[name], tables[f"{name}-texel"] = tuple(least), tuple(more)


def _wavelet_transport(mesh: Mesh, rows: int, kept: int) -> WaveletTransport:
    """Transport of `rows` vertices of one term, with random coefficients."""
    random = np.random.default_rng(0)
    indices = np.sort(random.integers(6, FACES * 64 * 64, (rows, kept), np.uint16), axis=1)
    words = random.integers(0, 1 << 32, (rows, kept), np.uint32)
    vectors = Vectors16(indices, words, np.ones((rows, 3), np.float32), np.full(rows, kept, np.uint16))
    index = np.arange(rows) % len(mesh.positions)
    some = Mesh(mesh.positions[index], mesh.normals[index], mesh.uv[index], np.zeros((1, 3), np.int32), mesh.name)
    return WaveletTransport(some, rows, factors_of(1), 0.0, 64, vectors)


def _reference(place: _Place, tables: Tables) -> Steps[None]:
    """Seconds of an image, of a path that meets nothing, of one of direct light, its rays alone, and a further point.

    Few paths and many tell what an image takes however few they are.
    """
    yield Step(0.0, "measuring the reference")
    mesh, brdf = place.mesh, brdf_from_text(GLOSSY)
    near = frame(mesh.positions)
    far = replace(near, eye=tuple(np.subtract(near.eye, near.target) * 1e3 + near.target))
    light = EnvironmentMap(np.ones((64, 128, 3), np.float32))
    scene = Scene(mesh, near, brdf, environment=light)
    shown, few, many = measure_coverage(place.of.caster, near), SIDE * SIDE * threads(), SIDE * SIDE * threads() * PATHS

    def split(scene: Scene, depth: int) -> tuple[float, float, float]:
        """Seconds of an image and of each path, and rays of a path beside its first."""
        found: list[ReferenceImage] = []

        def draw(paths: int) -> None:
            found.append(drain(reference(scene, (SIDE, SIDE), samples=paths // SIDE**2, max_depth=depth)))

        few_s, many_s = shortest(partial(draw, few)), shortest(partial(draw, many))
        path_s = max(many_s - few_s, 0.0) / (many - few)
        return max(few_s - few * path_s, 0.0), path_s, max(0.0, found[-1].rays / many - 1.0)

    miss_s = split(replace(scene, camera=far), 1)[1]
    image_s, direct_s, rays = split(scene, 1)
    longer_s = split(scene, POINTS)[1]
    whole_s = max(direct_s - miss_s, 0.0) / shown
    rays_s = min(rays / shown * place.ray_s / threads(), whole_s)
    further = shown * sum(place.closed**point for point in range(1, POINTS))
    tables["reference-picture"], tables["reference-miss"] = _once(image_s), _once(miss_s)
    tables["reference-rays"], tables["reference-shading"] = _once(rays_s), _once(whole_s - rays_s)
    tables["reference-point"] = _once(max(longer_s - direct_s, 0.0) / further)
