"""Wavelet transport: a bake beside its visibility, relighting beside the memory it reads, and the errors of both."""

from __future__ import annotations

import tempfile
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.measure import Accuracy, Measure, best_of
from engine.brdf.brdf import brdf_from_text
from engine.core.kernels import parallel, prange
from engine.core.steps import Steps, drain, part
from engine.factor.separable import Weighting
from engine.geometry.mesh import Mesh
from engine.geometry.ray_caster import RayCaster
from engine.geometry.shapes import shape
from engine.light.cube_map import cube_of
from engine.light.environment_file import open_environment
from engine.transport.baking.occluder import Occluder
from engine.transport.wavelet.bake import BakeSettings, Work, bake, bake_in_memory, factors_for, prepare
from engine.transport.wavelet.error import wavelet_error
from engine.transport.wavelet.lighting import lighting_of
from engine.transport.wavelet.transfer import Vectors16, WaveletTransport, relight_transport

BRDF = "ashikhmin-shirley:kd=0.5,ks=0.05,nu=10,nv=10"
TERMS = 4

#: Vertices that the relighting is measured with, and of the large bake: those of the bunny of Wang2004.
BUNNY = 36_000

#: Vertices of the small bake.
FEW = 1_000

#: Reflectances, terms and norms whose errors are found; the coefficients are 96.
ERRORS: tuple[tuple[str, int, Weighting], ...] = (
    ("lambert:albedo=0.5", 1, "cosine"),
    (BRDF, 4, "cosine"),
    (BRDF, 8, "cosine"),
    (BRDF, 4, "plain"),
    ("ashikhmin-shirley:kd=0.5,ks=0.05,nu=10,nv=100", 4, "cosine"),
    ("ggx:kd=0.5,alpha=0.3,f0=0.04", 4, "cosine"),
    ("ggx:kd=0,alpha=0.1,f0=1", 4, "cosine"),
)


def _work(vertices: int) -> Work:
    """A bake of vertices spread over the torus knot, shaded by all of it."""
    whole = shape("torus-knot")
    chosen = np.linspace(0, len(whole.positions) - 1, vertices).astype(np.int64)
    faces = np.arange(vertices // 3 * 3, dtype=np.int32).reshape(-1, 3)
    some = Mesh(whole.positions[chosen], whole.normals[chosen], whole.uv[chosen], faces, whole.name)
    work = prepare(some, drain(factors_for(brdf_from_text(BRDF), TERMS)), BakeSettings())
    return replace(work, occluder=Occluder(RayCaster(whole.positions, whole.faces)))


def _bake(name: str, vertices: int) -> Measure:
    work = _work(vertices)
    for _ in bake_in_memory(work, np.arange(20)):
        pass
    started = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        baked = drain(bake(Path(folder) / "bench.transport", work))
    time_s = time.perf_counter() - started
    more = {
        "vertices": vertices,
        "terms": TERMS,
        "size_bytes": work.size_bytes,
        "target_s": 180.0 * vertices / BUNNY,
        "target_ratio": 1.5,
    }
    return Measure(name, time_s, baked.visibility_s, "its visibility alone, in the same bake", more)


def wavelet_bake() -> Measure:
    """A thousand vertices, four terms, 6 × 64² texels, from rays to the file that is opened again."""
    return _bake("wavelet-bake", FEW)


def wavelet_bake_large() -> Measure:
    """The same with as many vertices as the bunny has."""
    return _bake("wavelet-bake-large", BUNNY)


def wavelet_relight() -> Measure:
    """A new light on 36,000 vertices of four terms; the limit is reading the same bytes, by as many threads."""
    transport = _repeat(_work(300), BUNNY)
    light = lighting_of(open_environment("studio"), transport.edge).light
    vectors = transport.vectors
    arrays = [np.ascontiguousarray(array).view(np.uint64).reshape(-1) for array in (vectors.indices, vectors.words)]
    sums = np.zeros(4096, np.uint64)

    def read() -> None:
        for array in arrays:
            _read(array, sums)

    limit_s, time_s = best_of(read, 15), best_of(lambda: relight_transport(transport, light), 15)
    size_bytes = sum(array.nbytes for array in arrays)
    more: dict[str, Any] = {
        "vertices": BUNNY,
        "terms": TERMS,
        "size_bytes": size_bytes,
        "bandwidth_bytes_per_s": size_bytes / limit_s,
        "light_coefficients": light.kept,
        "target_s": 0.008,
        "target_ratio": 3.0,
    }
    return Measure("wavelet-relight", time_s, limit_s, "reading the same bytes from memory", more)


def _repeat(work: Work, vertices: int) -> WaveletTransport:
    """The transport of a few vertices as often as needed, in memory of its own."""
    parts = [arrays for _, arrays in bake_in_memory(work, np.arange(work.vertices))]
    rows = vertices * work.factors.terms
    arrays = {}
    for name in parts[0]:
        once = np.concatenate([each[name] for each in parts])
        arrays[name] = np.resize(once, (rows, *once.shape[1:]))
    index = np.arange(vertices) % work.vertices
    surface = work.surface
    faces = np.arange(vertices // 3 * 3, dtype=np.int32).reshape(-1, 3)
    mesh = Mesh(surface.positions[index], surface.normals[index], surface.uv[index], faces, surface.name)
    vectors = Vectors16(arrays["indices"], arrays["words"], arrays["peaks"], arrays["counts"])
    return WaveletTransport(mesh, vertices, work.factors, 0.0, work.settings.edge, vectors)


@parallel
def _read(array: Any, sums: Any) -> None:
    """Every word of `array` once; bound by the memory."""
    step = (len(array) + len(sums) - 1) // len(sums)
    for number in prange(len(sums)):
        block = array[number * step : (number + 1) * step]
        total = np.uint64(0)
        for n in range(len(block)):
            total += block[n]
        sums[number] = total


def transport_errors(_folder: Path) -> Steps[list[Accuracy]]:
    """The errors of `ERRORS` on the torus knot under the studio: 400 vertices, 20 views; nothing is written."""
    return (yield from errors_of(shape("torus-knot"), open_environment("studio")))


def errors_of(mesh: Mesh, environment: Any, *, vertices: int = 400, views: int = 20) -> Steps[list[Accuracy]]:
    """The same for any model and map."""
    found = []
    radiance = cube_of(environment, BakeSettings().edge).radiance
    for index, (text, terms, weighting) in enumerate(ERRORS):
        brdf = brdf_from_text(text)
        factors = drain(factors_for(brdf, terms, weighting=weighting))
        work = prepare(mesh, factors, BakeSettings())
        steps = wavelet_error(work, brdf, radiance, vertices=vertices, views=views)
        error = yield from part(steps, index / len(ERRORS), (index + 1) / len(ERRORS))
        name = f"wavelet-{text.partition(':')[0]}-{index}"
        what = f"{text}, {terms} terms ({weighting}), RMS radiance over pairs of vertex and view weighted by n·wo"
        found.append(Accuracy(name, error.rmse_rel, what))
    return found
