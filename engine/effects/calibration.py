"""Measuring what this machine takes for each part of a bake, of a changed light and of a frame, in half a minute.

Every part runs on the built-in torus knot of 50,000 vertices, at `SAMPLED` of them where it is done vertex by vertex,
through the code that bakes and pictures run, and at several values of its knob. The shortest of some runs counts. The
tables of high orders, which take seconds, are not made: what order 10 takes is scaled by the counts of operations.
"""

from __future__ import annotations

import math
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache, partial
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from engine.brdf.brdf import brdf_from_text
from engine.brdf.diffuse import Lambert
from engine.camera import frame
from engine.effects.cost_model import CostModel, Rates, machine_name
from engine.environment import EnvironmentMap
from engine.errors import MissingCapability
from engine.factor.maps import DirectionMap
from engine.factor.separable_factors import SeparableFactors
from engine.mesh import Mesh
from engine.render.reference import reference
from engine.render.transported import picture_of
from engine.scene import Scene
from engine.shapes import shape
from engine.steps import Step, Steps, drain, part
from engine.transport import sh_kernel, wavelet_bake
from engine.transport.gaussian import GaussianTransport
from engine.transport.gaussian_atlas import atlas_of
from engine.transport.gaussian_fit import Fit, FitSettings, fit_vertices
from engine.transport.gaussian_lighting import filtered, levels_between
from engine.transport.gaussian_samples import GlossySurface, direct_samples
from engine.transport.lit import Lit, LitGaussians, LitHarmonics, LitWavelets, lit_gaussians
from engine.transport.sh_bake import BakeSettings, Work, baker_of, default_edge, prepare
from engine.transport.sh_bounces import gathered
from engine.transport.sh_lighting import project
from engine.transport.sh_table import BrdfTable, lambert_table
from engine.transport.sh_transfer import ShTransport, products, tangent_frames, texel_basis
from engine.transport.spherical_gaussian import Lobes
from engine.transport.view_directions import VIEWS
from engine.transport.visibility import Receivers, receivers, visibility_shares
from engine.transport.wavelet import (
    Vectors16,
    WaveletTransport,
    cube_texels,
    light_maps,
    relit,
    transport_vectors,
    vertex_frames,
)
from engine.transport.wavelet_lighting import lighting_of

#: Vertices at which bakes are measured, and vertices of the small and the large mesh of frames.
SAMPLED, FEW, MANY = 64, 2_000, 12_000

#: Vertices by which the cost of rays on a mesh is told.
PROBES = 32

#: Sides of the small and the large picture.
SMALL, LARGE = 64, 256

#: Orders, terms, directions, edges and coefficients that are measured.
ORDERS, TERMS, LIGHTS, EDGES, KEPT = (3, 5, 8, 10), (1, 4, 8), (4, 32, 128), (16, 32, 64), (24, 96, 384)

#: Lobes that are measured, vertices that they are fitted at with so many directions, and widths in rad of the levels
#: that a changed light is filtered to.
LOBES, FITTED, DIRECTIONS, WIDTHS = (1, 2, 3), 8, 128, (0.06, 0.5)

#: The order whose tables and matrices are made for those of all above, by the counts of their operations.
TABLE_ORDER, HIGHEST = 10, 15

#: The reflectance of bakes whose numbers mean nothing.
MATT = Lambert((0.5, 0.5, 0.5))

Result = TypeVar("Result")

#: Of the map that is turned into coefficients: rows.
MAP_ROWS = 512


def calibrate() -> Steps[CostModel]:
    """Measure this machine; half a minute where other programs work too. Without OpenGL, frames are the processor's."""
    mesh = shape("torus-knot")
    tables: dict[str, Rates] = {}
    yield Step(0.0, "measuring rays")
    prepare_s, of = best_of(lambda: receivers(mesh), 1), receivers(mesh)
    tables["receivers"] = ((1.0, prepare_s / len(mesh.positions)),)
    vertices = np.unique(np.linspace(0, len(mesh.positions) - 1, SAMPLED).astype(np.int64))
    some = _Some(mesh, of, vertices[~of.free[vertices]])
    tables["visibility"] = tuple((edge, some.visibility_s(edge)) for edge in EDGES)
    yield from part(_harmonics(some, tables), 0.15, 0.4)
    yield Step(0.4, "measuring bakes of wavelets")
    _wavelets(some, tables)
    yield Step(0.46, "measuring bakes of Gaussians")
    tables["gaussian-fit"] = _gaussian_fits(mesh, of)
    yield Step(0.52, "measuring changed light")
    _lights(mesh, tables)
    yield Step(0.6, "measuring the reference")
    tables["reference"] = ((1.0, _reference_s(mesh)),)
    renderer = yield from part(_frames(tables), 0.65, 1.0)
    yield Step(1.0, "measured")
    return CostModel(machine_name(), renderer, tables)


def best_of(work: Callable[[], object], repeats: int = 3) -> float:
    """The shortest of several runs in seconds, which other programs disturb least; one more run warms up."""
    work()
    return min(_timed(work)[1] for _ in range(repeats))


def _timed(work: Callable[[], Result]) -> tuple[Result, float]:
    started = time.perf_counter()
    result = work()
    return result, time.perf_counter() - started


@lru_cache(maxsize=4)
def ray_s(of: Receivers) -> float:
    """Seconds of visibility at an edge of 32 for a vertex of this mesh that is not open; 0 where all are."""
    vertices = np.flatnonzero(~of.free)
    if not vertices.size:
        return 0.0
    some = vertices[np.linspace(0, len(vertices) - 1, min(PROBES, len(vertices))).astype(np.int64)]
    return best_of(lambda: list(visibility_shares(of, 32, 4, some)), 1) / len(some)


def ray_scale(costs: CostModel, of: Receivers) -> float:
    """How much dearer rays are on this mesh than on that of the calibration; for `Load.ray_scale`."""
    usual = costs.rate("visibility", 32)
    return ray_s(of) / usual if usual > 0.0 else 1.0


class _Some:
    """Some vertices of a mesh and what they see, which is worked out once for each edge."""

    def __init__(self, mesh: Mesh, of: Receivers, vertices: NDArray[np.int64]) -> None:
        self.mesh, self.of, self.vertices = mesh, of, vertices
        self._counts: dict[int, NDArray[np.uint8]] = {}

    def visibility_s(self, edge: int) -> float:
        """Seconds for a vertex, the edges of shadows included."""

        def look() -> None:
            shares = visibility_shares(self.of, edge, 4, self.vertices)
            self._counts[edge] = np.concatenate([counts for _, counts in shares])

        return best_of(look, 2) / len(self.vertices)

    def counts(self, edge: int) -> NDArray[np.uint8]:
        return self._counts[edge]


def _harmonics(some: _Some, tables: dict[str, Rates]) -> Steps[None]:
    products_s = best_of(lambda: products.__wrapped__(TABLE_ORDER), 1)
    basis_s = best_of(lambda: texel_basis.__wrapped__(64, 2 * TABLE_ORDER - 1), 1)
    tables["sh-fixed"] = tuple(
        (n, products_s * (n / TABLE_ORDER) ** 8 + basis_s * _basis_values(n) / _basis_values(TABLE_ORDER))
        for n in (3, 5, 8, 9, 10, 12, HIGHEST)
    )
    matt = drain(prepare(some.mesh, MATT, BakeSettings(bounces=1)))
    for kind in ("vector", "matrix"):
        rows: list[tuple[float, float]] = []
        bounces: list[tuple[float, float]] = []
        for order in ORDERS:
            yield Step(len(rows) / len(ORDERS), f"measuring bakes of harmonics, order {order}")
            work = _with_order(matt, order, kind == "vector")
            rows.append((float(order), _rows_s(some, work)))
            bounces.append((float(order), _bounce_s(some, work)))
        grows = (HIGHEST / TABLE_ORDER) ** (2 if kind == "vector" else 4)
        for name, rates in ((f"sh-{kind}", rows), (f"bounce-{kind}", bounces)):
            tables[name] = (*rates, (float(HIGHEST), rates[-1][1] * grows))


def _with_order(work: Work, order: int, diffuse: bool) -> Work:
    table = replace(lambert_table(MATT, order), diffuse=diffuse)
    return replace(work, settings=BakeSettings(order, default_edge(order), bounces=1), table=table)


def _rows_s(some: _Some, work: Work) -> float:
    """Seconds for what a vertex keeps, its visibility being known."""
    baker = baker_of(replace(work, settings=replace(work.settings, bounces=0)), some.of)
    counts = some.counts(work.settings.edge)
    return best_of(lambda: baker.rows(some.vertices, counts)) / len(some.vertices)


def _bounce_s(some: _Some, work: Work) -> float:
    """Seconds for a bounce at a vertex."""
    few = some.vertices[:: 4 if work.table.diffuse else 8]
    sent = np.ones((len(some.mesh.positions), 1, work.settings.order**2), np.float32)
    frames = None if work.table.diffuse else np.broadcast_to(np.eye(3), (len(few), 3, 3))
    return best_of(lambda: gathered(work.surroundings(some.of), few, sent, frames), 1) / len(few)


def _basis_values(order: int) -> float:
    """Values of the basis that the integrals over texels of a bake of `order` take."""
    edge, higher = default_edge(order), 2 * order - 1
    nodes = max(2, math.ceil(3 * higher / edge) + 1)
    return float(6 * (edge * nodes * higher) ** 2)


def _factors(terms: int) -> SeparableFactors:
    """Factors of the usual size with numbers of no meaning."""
    chart = DirectionMap("orthographic", 48)
    maps = np.repeat(np.random.default_rng(0).random((terms, 48, 48, 1), np.float32), 3, axis=3)
    return SeparableFactors(chart, "in-out", maps, maps, True, True, "calibration")


def _wavelets(some: _Some, tables: dict[str, Rates]) -> None:
    frames, factors = vertex_frames(some.mesh, True)[some.vertices], _factors(4)
    maps = light_maps(factors)

    def row_s(edge: int, kept: int) -> float:
        counts, texels = some.counts(edge), cube_texels(edge)
        run = partial(transport_vectors, frames, counts, 16, texels, factors.chart, maps, kept)
        return best_of(run) / (4 * len(some.vertices))

    tables["wavelet-fixed"] = ((1.0, _fixed_s()),)
    tables["wavelet-row"] = tuple((float(edge), row_s(edge, 96)) for edge in EDGES)
    tables["wavelet-coefficients"] = tuple((float(kept), row_s(64, kept)) for kept in KEPT)


def _fixed_s() -> float:
    """Seconds of a bake of wavelets that do not grow with the mesh: its file, tables of texels, and threads."""
    least = _sphere(8)
    work = wavelet_bake.prepare(least, _factors(4), wavelet_bake.BakeSettings(max(EDGES), 96))
    with tempfile.TemporaryDirectory() as folder:
        return best_of(lambda: drain(wavelet_bake.bake(Path(folder) / "least.transport", work)), 2)


def _gaussian_fits(mesh: Mesh, of: Receivers) -> Rates:
    """Seconds for a vertex, its transport being tabulated and fitted towards all views, by the number of lobes."""
    brdf = brdf_from_text("ggx:kd=0.5,alpha=0.3,f0=0.04")
    surface = GlossySurface(mesh, len(mesh.positions), 0.0, brdf, {}, of, tangent_frames(mesh))
    vertices = np.linspace(0, len(mesh.positions) - 1, FITTED).astype(np.int64)
    around = [np.zeros(0, np.int64)] * FITTED

    def fit_all(lobes: int) -> None:
        samples, alone = direct_samples(surface, vertices, DIRECTIONS), Fit.empty(1, lobes).lobes
        fit_vertices(samples, around, alone, FitSettings(lobes=lobes))

    fit_all(1)  # waits for kernels to be made ready
    return tuple((float(lobes), _timed(partial(fit_all, lobes))[1] / FITTED) for lobes in LOBES)


def _lights(mesh: Mesh, tables: dict[str, Rates]) -> None:
    """What a changed light costs before, and for each row of, transport; the rows are too many for any cache."""
    random = np.random.default_rng(0)
    environment = EnvironmentMap(random.random((MAP_ROWS, 2 * MAP_ROWS, 3), np.float32))
    tables["light-sh"] = tuple((n, best_of(partial(project, environment, n))) for n in (3, 5, 8, 15))
    tables["light-wavelet"] = tuple((edge, best_of(partial(lighting_of, environment, edge))) for edge in EDGES)
    widths = levels_between(*WIDTHS)
    tables["light-gaussian"] = ((1.0, best_of(lambda: atlas_of(filtered(environment, widths)), 1)),)
    rows = random.random((20_000 * 25, 1, 25), np.float32)
    light, out = np.ones((25, 3), np.float32), np.empty((len(rows), 3), np.float32)
    tables["relight-sh"] = ((1.0, best_of(lambda: sh_kernel.transfer(rows, light, out)) / rows.size),)
    lit = lighting_of(environment, 64).light
    rates = []
    for kept in KEPT:
        count = 6_000_000 // (6 * kept)
        transport = _wavelet_transport(mesh, count, kept)
        rates.append((float(kept), best_of(partial(relit, transport, lit)) / count))
    tables["relight-wavelet"] = tuple(rates)


def _wavelet_transport(mesh: Mesh, rows: int, kept: int) -> WaveletTransport:
    """Transport of `rows` vertices of one term, with random coefficients."""
    random = np.random.default_rng(0)
    indices = np.sort(random.integers(6, 6 * 64 * 64, (rows, kept), np.uint16), axis=1)
    words = random.integers(0, 1 << 32, (rows, kept), np.uint32)
    vectors = Vectors16(indices, words, np.ones((rows, 3), np.float32), np.full(rows, kept, np.uint16))
    return WaveletTransport(_some(mesh, rows), rows, _factors(1), 0.0, 64, vectors)


def _some(mesh: Mesh, vertices: int) -> Mesh:
    """A strip of the knot with about so many vertices, over and over where it has too few; what is drawn is whole."""
    index = np.arange(vertices) % len(mesh.positions)
    faces = mesh.faces[(mesh.faces < vertices).all(axis=1)]
    return Mesh(mesh.positions[index], mesh.normals[index], mesh.uv[index], faces, mesh.name)


def _reference_s(mesh: Mesh) -> float:
    """Seconds for a path of direct light."""
    brdf = brdf_from_text("ggx:kd=0.5,alpha=0.3,f0=0.04")
    scene = Scene(mesh, frame(mesh.positions), brdf, environment=EnvironmentMap(np.ones((64, 128, 3), np.float32)))
    return best_of(lambda: drain(reference(scene, (96, 96), samples=4)), 2) / (96 * 96 * 4)


def _sphere(vertices: int) -> Mesh:
    """A sphere of about so many vertices."""
    rows = round(math.sqrt(vertices / 2.0))
    theta, phi = np.meshgrid(np.linspace(1e-3, np.pi - 1e-3, rows), np.linspace(0, 2 * np.pi, 2 * rows), indexing="ij")
    points = np.stack([np.sin(theta) * np.sin(phi), np.cos(theta), np.sin(theta) * np.cos(phi)], axis=-1)
    index = np.arange(2 * rows * rows).reshape(rows, 2 * rows)
    a, b, c, d = index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]
    faces = np.stack([np.stack([a, b, c], -1), np.stack([a, c, d], -1)], axis=2).reshape(-1, 3).astype(np.int32)
    uv = np.stack([phi / 3.0, theta / 3.0], axis=-1).reshape(-1, 2).astype(np.float32)
    points = points.reshape(-1, 3)
    return Mesh(points, points.astype(np.float32), uv, faces, "sphere")


def _drawn(mode: str, knob: int, mesh: Mesh) -> Lit | Scene:
    """Something of a mode that can be drawn; its numbers mean nothing."""
    random, count = np.random.default_rng(0), len(mesh.positions)
    if mode == "direct":
        environment = EnvironmentMap(random.random((64, 128, 3), np.float32))
        brdf = brdf_from_text("ggx:kd=0.5,alpha=0.3,f0=0.04")
        return Scene(mesh, frame(mesh.positions), brdf, environment=environment, directions=knob)
    if mode == "wavelet":
        rows = count * knob
        nothing = Vectors16(
            np.zeros((rows, 1), np.uint16),
            np.zeros((rows, 1), np.uint32),
            np.zeros((rows, 3), np.float32),
            np.zeros(rows, np.uint16),
        )
        return LitWavelets(WaveletTransport(mesh, count, _factors(knob), 0.0, 64, nothing), random.random((rows, 3)))
    if mode == "gaussian":
        return _lit_gaussians(mesh, knob)
    flat = mode == "sh-flat"
    table = lambert_table(MATT, knob)
    if not flat:
        table = BrdfTable(knob, random.random((256, knob**2, 3)))
    rows = count * (1 if flat else knob**2)
    nothing_yet = np.broadcast_to(np.float32(0.0), (rows, 1, knob**2))
    return LitHarmonics(ShTransport(mesh, count, flat, 0.0, table, False, nothing_yet), random.random((rows, 3)))


def _lit_gaussians(mesh: Mesh, lobes: int) -> LitGaussians:
    """Lobes that point up, all alike."""
    count = len(mesh.positions)
    up = np.broadcast_to(np.array([0.0, 1.0, 0.0], np.float32), (count, VIEWS, lobes, 3))
    alike = Lobes(np.ones_like(up), up, np.full(up.shape[:3], 0.2, np.float32))
    environment = EnvironmentMap(np.ones((64, 128, 3), np.float32))
    transport = GaussianTransport(mesh, count, 0.0, (alike,), None)
    return lit_gaussians(transport, environment)


def _frames(tables: dict[str, Rates]) -> Steps[str]:
    """Fill the tables of frames; the name of what draws."""
    from engine.gl.context import create_context, renderer_name

    knobs = {"direct": LIGHTS, "sh": (3, 5, 8, 15), "sh-flat": (5,), "wavelet": TERMS, "gaussian": LOBES}
    whole = sum(map(len, knobs.values()))
    meshes = _sphere(FEW), _sphere(MANY)
    done = 0
    try:
        with create_context() as context:
            for mode, values in knobs.items():
                found = []
                for knob in values:
                    yield Step(done / whole, f"measuring frames, {mode} {knob}")
                    found.append(_split(meshes, partial(_gl_frame_s, context, mode, knob)))
                    done += 1
                _put(tables, mode, values, found)
            return renderer_name(context)
    except MissingCapability:
        for mode, values in knobs.items():
            yield Step(done / whole, f"measuring frames on the processor, {mode}")
            found = [_split(meshes, partial(_cpu_frame_s, mode, knob)) for knob in values]
            done += len(values)
            _put(tables, mode, values, found)
        return "processor"


def _put(tables: dict[str, Rates], mode: str, knobs: Any, found: list[tuple[float, float, float]]) -> None:
    for index, share in enumerate(("base", "vertex", "pixel")):
        tables[f"{mode}-{share}"] = tuple((float(k), each[index]) for k, each in zip(knobs, found, strict=True))


def _split(meshes: tuple[Mesh, Mesh], seconds: Callable[[Mesh, int], float]) -> tuple[float, float, float]:
    """Base, share of a vertex and share of a pixel of a frame, from three frames."""
    few, many = (len(mesh.positions) for mesh in meshes)
    plain, finer, larger = seconds(meshes[0], SMALL), seconds(meshes[1], SMALL), seconds(meshes[0], LARGE)
    vertex = max(0.0, finer - plain) / (many - few)
    pixel = max(0.0, larger - plain) / (LARGE**2 - SMALL**2)
    return max(0.0, plain - vertex * few - pixel * SMALL**2), vertex, pixel


def _gl_frame_s(context: Any, mode: str, knob: int, mesh: Mesh, side: int) -> float:
    from engine.gl.direct import DirectRenderer
    from engine.gl.transported import TransportRenderer

    what, size = _drawn(mode, knob, mesh), (side, side)
    target = context.framebuffer([context.renderbuffer(size)])
    renderer: Any = DirectRenderer(context) if isinstance(what, Scene) else TransportRenderer(context)
    camera = frame(mesh.positions)

    def draw() -> None:
        if isinstance(what, Scene):
            renderer.draw(what, target, size, samples=1)
        else:
            renderer.draw(what, camera, target, size, samples=1)
        context.finish()

    try:
        return best_of(draw)
    finally:
        renderer.release()
        target.release()


def _cpu_frame_s(mode: str, knob: int, mesh: Mesh, side: int) -> float:
    from engine.render.direct import radiance

    what: Any = _drawn(mode, knob, mesh)
    if isinstance(what, Scene):
        return best_of(lambda: drain(radiance(what, (side, side), samples=1)), 1)
    return best_of(lambda: drain(picture_of(what, frame(mesh.positions), (side, side), 1)), 1)
