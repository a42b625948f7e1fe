"""Gaussian transport: a bake from rays to the file that is opened again, and how far lobes are from the real thing."""

from __future__ import annotations

import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.measure import Accuracy, Measure
from engine.brdf.brdf import brdf_from_text
from engine.core.steps import Step, Steps, drain, part
from engine.geometry.mesh import Mesh
from engine.geometry.shapes import grid_mesh, shape
from engine.light.cube_map import cube_of
from engine.light.environment_file import open_environment
from engine.transport.gaussian.bake import BakeSettings, bake, estimate_s, prepare
from engine.transport.gaussian.diffuse import DiffuseTransfer
from engine.transport.gaussian.error import Known, gaussian_error
from engine.transport.gaussian.fitting.fit import Fit, FitSettings, fit_vertices
from engine.transport.gaussian.samples import direct_samples, glossy_surface

#: Points of the built-in torus knot around its tube and along it.
KNOT = 65, 769

#: Every how manieth of them the two bakes take.
FEW, MANY = (4, 12), (2, 2)

#: Vertices that the ten minutes are for.
WHOLE, LIMIT_S = 10_000, 600.0

BRDF = "ggx:kd=0.3,alpha=0.2,f0=0.2"

#: Reflectances whose errors are found, and lobes.
ERRORS = (
    ("ashikhmin-shirley:kd=0.5,ks=0.05,nu=10,nv=10", 1),
    ("ashikhmin-shirley:kd=0.5,ks=0.05,nu=10,nv=10", 2),
    ("ashikhmin-shirley:kd=0.5,ks=0.05,nu=10,nv=100", 1),
    ("ggx:kd=0.5,alpha=0.3,f0=0.04", 1),
    ("ggx:kd=0.5,alpha=0.3,f0=0.04", 2),
    ("ggx:kd=0,alpha=0.1,f0=1", 1),
    ("ggx:kd=0,alpha=0.1,f0=1", 2),
)

#: Vertices, directions and edge of the cube map that errors are found with.
VERTICES, SAMPLES, EDGE = 400, 128, 64

#: Name of each error of radiance in words.
WORDS = {
    "radiance": "radiance with the better weights",
    "glossy": "of the glossy part alone",
    "plain": "radiance with the weights of least squares",
    "preserving": "radiance with all energy",
}


def gaussian_bake() -> Measure:
    """A thousand vertices, one lobe."""
    return _bake("gaussian-bake", FEW)


def gaussian_bake_large() -> Measure:
    """More vertices than the ten minutes are for."""
    return _bake("gaussian-bake-large", MANY)


def _bake(name: str, steps: tuple[int, int]) -> Measure:
    work = drain(prepare(_knot(*steps), brdf_from_text(BRDF), BakeSettings()))
    expected_s = estimate_s(work)
    started, cpu = time.perf_counter(), time.process_time()
    with tempfile.TemporaryDirectory() as folder:
        baked = drain(bake(Path(folder) / "bench.transport", work))
    time_s, processor_s = time.perf_counter() - started, time.process_time() - cpu
    more: dict[str, Any] = {
        "vertices": work.vertices,
        "size_bytes": work.size_bytes,
        "estimated_s": expected_s,
        "processor_s": processor_s,
        "whole_s": time_s * WHOLE / work.vertices,
        "target_s": LIMIT_S * work.vertices / WHOLE,
        "flipped_pairs": baked.figures["direct_flipped_pairs"],
    }
    return Measure(name, time_s, baked.visibility_s, "tabulating transport alone, in the same bake", more)


def _knot(around: int, along: int) -> Mesh:
    """The torus knot with fewer vertices."""
    mesh = shape("torus-knot")
    kept = [
        array.reshape(*KNOT, -1)[::around, ::along].astype(np.float64)
        for array in (mesh.positions, mesh.normals, mesh.uv)
    ]
    return grid_mesh(mesh.name, *kept)


def gaussian_errors(_folder: Path) -> Steps[list[Accuracy]]:
    """The errors of `ERRORS` on the torus knot under the studio; nothing is written."""
    return (yield from errors_of(shape("torus-knot"), open_environment("studio")))


def errors_of(mesh: Mesh, environment: Any, *, vertices: int = VERTICES) -> Steps[list[Accuracy]]:
    """The same for any model and map: distances of the fit, and radiance by the better way to weigh."""
    found, cube = [], cube_of(environment, EDGE)
    chosen = np.sort(np.random.default_rng(1).choice(len(mesh.positions), min(vertices, len(mesh.positions)), False))
    for index, (text, lobes) in enumerate(ERRORS):
        yield Step(index / len(ERRORS), f"fitting {text}")
        surface = glossy_surface(mesh, brdf_from_text(text))
        around = [np.zeros(0, np.int64)] * len(chosen)
        samples = direct_samples(surface, chosen, SAMPLES)
        fitted = fit_vertices(samples, around, Fit.empty(0, lobes).lobes, FitSettings(lobes=lobes))
        diffuse = DiffuseTransfer(surface, 5, 32, 4)
        steps = gaussian_error(surface, diffuse, Known(chosen, fitted, diffuse.rows(chosen)), cube)
        error = yield from part(steps, index / len(ERRORS), (index + 1) / len(ERRORS))
        name, lit = f"gaussian-{text.partition(':')[0]}-{index}", fitted.norm > 0.0
        words = f"{text}, {lobes} {'lobe' if lobes == 1 else 'lobes'}"
        for what, value in (
            ("radiance", error.of(error.better)),
            ("glossy", min(error.glossy_plain_rmse_rel, error.glossy_preserving_rmse_rel)),
            ("plain", error.plain_rmse_rel),
            ("preserving", error.preserving_rmse_rel),
        ):
            found.append(Accuracy(f"{name}-{what}", value, f"{words}, RMS {WORDS[what]}, pairs weighted by n·wo"))
        found.append(Accuracy(f"{name}-fit", float(fitted.error_rel[lit].mean()), f"{words}, mean distance of the fit"))
    return found
