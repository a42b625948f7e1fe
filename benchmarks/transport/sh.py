"""Spherical harmonics: lighting turned into the frames of 50,000 vertices, projected maps, tables, bakes, relight."""

from __future__ import annotations

import time

import numpy as np

from benchmarks.measure import Measure, best_of
from engine.brdf.brdf import brdf_from_text
from engine.core.directions import normalize, world_from_tangent
from engine.core.steps import drain
from engine.geometry.shapes import shape
from engine.light.environment import EnvironmentMap
from engine.transport.baking.visibility import receivers
from engine.transport.sh import kernel as sh_kernel
from engine.transport.sh.bake import BakeSettings, baker_of, prepare
from engine.transport.sh.brdf_table import ROWS, SAMPLES, isotropic_views, tabulate
from engine.transport.sh.lighting import project
from engine.transport.sh.rotation import rotate_into_frames
from engine.transport.sh_relight import shade_fixed_view

FRAMES = 50_000
SIZE = (512, 1024)

#: The BRDFs whose tables and transport are measured, and the vertices that are baked.
BRDF, BRUSHED, BAKED = "ggx:kd=0.5,alpha=0.3,f0=0.04", "ashikhmin-shirley:kd=0.5,ks=0.05,nu=10,nv=100", 2_000


def sh_rotate() -> Measure:
    """RGB lighting of order 5 in float32 turned into each frame, against a copy of what is read and written."""
    random = np.random.default_rng(0)
    coefficients = random.normal(size=(25, 3)).astype(np.float32)
    frames = world_from_tangent(normalize(random.normal(size=(FRAMES, 3)))).astype(np.float32)
    local = rotate_into_frames(coefficients, frames)
    time_s = best_of(lambda: rotate_into_frames(coefficients, frames))
    start = time.process_time()
    rotate_into_frames(coefficients, frames)
    more = {"frames": FRAMES, "order": 5, "processor_s": time.process_time() - start}
    limit_s = best_of(lambda: (frames.copy(), local.copy()))
    return Measure("sh-rotate", time_s, limit_s, "copying the frames and the coefficients", more)


def sh_project() -> Measure:
    """A map of 1024 × 512 projected at order 5, against adding up its texels in float64."""
    return _project("sh-project", 5)


def sh_project_15() -> Measure:
    """The same at order 15."""
    return _project("sh-project-15", 15)


def _project(name: str, order: int) -> Measure:
    environment = EnvironmentMap(np.random.default_rng(0).random((*SIZE, 3), np.float32))
    time_s = best_of(lambda: project(environment, order))
    limit_s = best_of(lambda: environment.radiance.sum(axis=(0, 1), dtype=np.float64))
    return Measure(name, time_s, limit_s, "adding up the texels", {"order": order, "texels": SIZE[0] * SIZE[1]})


def sh_table() -> Measure:
    """The table of an isotropic BRDF at order 5, against one evaluation of it at every direction summed."""
    return _tabulate("sh-table", BRDF, 5)


def sh_table_15() -> Measure:
    """The same at order 15."""
    return _tabulate("sh-table-15", BRDF, 15)


def sh_table_brushed() -> Measure:
    """The map of an anisotropic BRDF at order 5, against evaluating the isotropic one as above."""
    return _tabulate("sh-table-brushed", BRUSHED, 5)


def _tabulate(name: str, text: str, order: int) -> Measure:
    brdf, plain = brdf_from_text(text), brdf_from_text(BRDF)
    time_s = best_of(lambda: drain(tabulate(brdf, order)), 2)
    start = time.process_time()
    table = drain(tabulate(brdf, order))
    views = isotropic_views()[:, None]
    wi = np.random.default_rng(0).normal(size=(1, SAMPLES, 3))
    wi = normalize(np.abs(wi))
    limit_s = best_of(lambda: plain.f(wi, views), 2)
    more = {
        "order": order,
        "processor_s": time.process_time() - start,
        "error_rel": table.error_rel,
        "target_s": 1.0,
    }
    return Measure(name, time_s, limit_s, f"{ROWS * SAMPLES:,} values of a reflectance", more)


def sh_bake() -> Measure:
    """Matrices of order 5 of 2,000 vertices that lie apart, against the rays that they take."""
    mesh = shape("torus-knot")
    work = drain(prepare(mesh, brdf_from_text(BRDF), BakeSettings()))
    of = receivers(work.surface, work.caster)
    baker = baker_of(work, of)
    vertices = np.unique(np.linspace(0, len(mesh.positions) - 1, BAKED).astype(np.int64))
    parts = np.array_split(vertices, 8)
    baker.rows(parts[0], baker.visible(parts[0]))
    rays_s, rows_s = [], []
    for part in parts:
        start = time.perf_counter()
        counts = baker.visible(part)
        between = time.perf_counter()
        baker.rows(part, counts)
        rays_s.append(between - start)
        rows_s.append(time.perf_counter() - between)
    limit_s = sum(rays_s)
    more = {"vertices": len(vertices), "order": 5, "bytes_per_vertex": 25 * 25 * 4, "target_ratio": 1.5}
    return Measure("sh-bake", limit_s + sum(rows_s), limit_s, "its visibility rays alone", more)


def sh_relight() -> Measure:
    """Light through 50,000 matrices of order 5, against reading them once."""
    rows = np.random.default_rng(0).random((FRAMES * 25, 1, 25), np.float32)
    light, out = np.ones((25, 3), np.float32), np.empty((len(rows), 3), np.float32)
    time_s = best_of(lambda: sh_kernel.transfer(rows, light, out))
    limit_s = best_of(lambda: sh_kernel.total(rows.reshape(-1)))
    return Measure("sh-relight", time_s, limit_s, "adding up the matrices", {"size_bytes": rows.nbytes})


def sh_relight_view() -> Measure:
    """A new light for a view that stays: products with 50,000 vectors of each channel, against adding them up."""
    vectors = np.random.default_rng(0).random((FRAMES, 3, 25), np.float32)
    light = np.ones((25, 3), np.float32)
    time_s = best_of(lambda: shade_fixed_view(vectors, light))
    limit_s = best_of(lambda: sh_kernel.total(vectors.reshape(-1)))
    return Measure("sh-relight-view", time_s, limit_s, "adding up the vectors", {"size_bytes": vectors.nbytes})
