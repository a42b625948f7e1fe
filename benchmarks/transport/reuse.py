"""A new BRDF on a model that was baked before: its CPU time over that of the first bake, and the ratio of errors.

The first bake finds the visibility and keeps it; the second, of another BRDF, reads it. Both include laying the bake
out and measuring its error, as a user waits for them. Bakes with kept visibility have the bytes of a fresh bake, which
is checked; errors of Gaussians, whose visibility is a cube map's, are compared with those of samples that cast
their own rays. CPU seconds of all threads, because the ratio must not depend on what else runs.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.measure import Accuracy
from engine.core.steps import Step, Steps, drain
from engine.factor.factor_file import open_reflectance
from engine.figures.figure import coarse_bust
from engine.geometry.mesh import Mesh
from engine.geometry.shapes import grid_mesh, open_mesh, shape
from engine.light.cube_map import cube_of
from engine.light.environment_file import open_environment
from engine.transport.baking.held_visibility import hold_visibility
from engine.transport.gaussian.diffuse import DiffuseTransfer
from engine.transport.gaussian.error import Known, gaussian_error
from engine.transport.gaussian.fitting.fit import Fit, FitSettings, fit_vertices
from engine.transport.gaussian.samples import GlossySurface, direct_samples, glossy_surface
from engine.transport.method import Subject, method_of, names
from engine.transport.preview import preview

#: BRDF of the first bake, and those that are put in its place.
FIRST = "ggx:kd=0.3,alpha=0.2,f0=0.2"
NEXT = (
    "ggx:kd=0.3,alpha=0.1,f0=0.2",
    "ashikhmin-shirley:kd=0.5,ks=0.05,nu=10,nv=100",
    "ggx:kd=0,alpha=0.3,f0=0.9/0.6/0.3",
    "phong:kd=0.2,ks=0.3,exponent=60",
)

#: Paths of the bunny and of a measured BRDF within the folder of measured data.
BUNNY, MEASURED = "mesh/classic/stanford-bunny.obj", "brdf/rgl/paper_white_rgb.bsdf"

#: Share of the bake and ratio of errors that are promised.
SHARE, WORSE = 0.15, 1.2

#: Seconds within which a first image is promised.
FIRST_S = 2.0

#: Vertices whose errors are compared, samples of a view, edge and parts of texels of visibility.
VERTICES, SAMPLES, EDGE, FINE = 100, 128, 64, 4


def thin_out(mesh: Mesh, grid: tuple[int, int], step: tuple[int, int]) -> Mesh:
    """A mesh whose vertices are a `grid` of rows and columns with every so manieth row and column of it."""
    arrays = (mesh.positions, mesh.normals, mesh.uv)
    kept = [array.reshape(*grid, -1)[:: step[0], :: step[1]].astype(np.float64) for array in arrays]
    return grid_mesh(mesh.name, *kept)


#: Some 4,000 vertices: on far fewer what does not depend on them, such as factors of a BRDF, takes most of the time.
#: With a folder of measured data the bunny that lies there is another one.
MODELS: dict[str, Callable[[], Mesh]] = {
    "torus-knot": lambda: thin_out(shape("torus-knot"), (65, 769), (2, 6)),
    "bust": lambda: coarse_bust(73, 109),
}


def reuse(_folder: Path, *, data: Path | None = None, modes: Sequence[str] | None = None) -> Steps[list[Accuracy]]:
    """Ratios of every mode, or of some `modes`, on `MODELS`, of the BRDFs `NEXT` and a measured one after `FIRST`."""
    found = []
    after = NEXT if data is None else (*NEXT, str(data / MEASURED))
    models = {**MODELS, **({} if data is None else {"bunny": lambda: open_mesh(str(data / BUNNY))})}
    for number, (model, make) in enumerate(models.items()):
        mesh = make()
        for mode in modes or names():
            yield Step(number / len(models), f"baking {model} in {mode}")
            found += _shares(model, mesh, mode, after)
        if "gaussian" in (modes or names()):
            yield Step((number + 0.7) / len(models), f"comparing errors on {model}")
            found += [_ratio_of_errors(model, mesh, number, text) for number, text in enumerate(after)]
    return found


def _shares(model: str, mesh: Mesh, mode: str, after: Sequence[str]) -> list[Accuracy]:
    """The CPU time of each BRDF `after` the first over that of `FIRST`."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        _bake_s(mesh.name, _part(mesh), mode, FIRST, folder / "warm")  # compiles the kernels
        whole_s = _bake_s("first", mesh, mode, FIRST, folder)
        found = []
        for number, text in enumerate(after):
            again_s = _bake_s(str(number), mesh, mode, text, folder)
            what = f"{model}, {len(mesh.positions):,} vertices, {mode}: CPU time of {text} over that of the first bake"
            more = {"first_cpu_s": whole_s, "again_cpu_s": again_s}
            found.append(Accuracy(f"reuse-{model}-{mode}-{number}", again_s / whole_s, what, SHARE, more))
        if mode == "wavelet":
            found.append(_first_image(model, mesh, folder / "visibility"))
        if model not in MODELS:
            return found
        _bake_s("fresh", mesh, mode, NEXT[0], folder / "elsewhere")
        if (folder / "elsewhere" / "fresh").read_bytes() != (folder / "0").read_bytes():
            raise AssertionError("a bake with kept visibility differs from a fresh one")
    return found


def _first_image(model: str, mesh: Mesh, kept: Path) -> Accuracy:
    """Seconds until another BRDF can be drawn in spherical harmonics, by a process that has drawn one before."""
    subject = Subject(mesh, open_reflectance(NEXT[0]), kept=kept)
    drain(preview(subject))
    started = time.perf_counter()
    drain(preview(subject))
    what = f"{model}: seconds until a first image of another BRDF, from kept visibility"
    return Accuracy(f"reuse-{model}-first-image", time.perf_counter() - started, what, FIRST_S)


def _bake_s(name: str, mesh: Mesh, mode: str, text: str, folder: Path) -> float:
    folder.mkdir(exist_ok=True)
    method = method_of(mode)
    started = time.process_time()
    subject = Subject(mesh, open_reflectance(text), kept=folder / "visibility")
    work = drain(method.baking.prepare(subject, method.settings()))
    drain(method.baking.bake(folder / name, work))
    return time.process_time() - started


def _part(mesh: Mesh) -> Mesh:
    """A few faces."""
    some: dict[str, Any] = {"faces": np.arange(300, dtype=np.int32).reshape(-1, 3)}
    return replace(mesh, positions=mesh.positions[:300], normals=mesh.normals[:300], uv=mesh.uv[:300], **some)


def _ratio_of_errors(model: str, mesh: Mesh, number: int, text: str) -> Accuracy:
    """The error of Gaussians by held visibility over that by rays, at some vertices under the studio."""
    surface = glossy_surface(mesh, open_reflectance(text))
    count = min(VERTICES, len(mesh.positions))
    chosen = np.sort(np.random.default_rng(1).choice(len(mesh.positions), count, False))
    seen = drain(hold_visibility(surface.of, EDGE, FINE, chosen))
    rays, held = _error(surface, chosen, 32), _error(replace(surface, seen=seen), chosen, EDGE)
    what = f"{model}, {text}: error of Gaussians by kept visibility over that by rays"
    name = f"reuse-error-{model}-{number}"
    return Accuracy(name, held / rays, what, WORSE, {"error_rays": rays, "error_kept": held})


def _error(surface: GlossySurface, chosen: Any, edge: int) -> float:
    alone = [np.zeros(0, np.int64)] * len(chosen)
    fitted = fit_vertices(direct_samples(surface, chosen, SAMPLES), alone, Fit.empty(0, 1).lobes, FitSettings())
    diffuse = DiffuseTransfer(surface, 8, edge, FINE)
    cube = cube_of(open_environment("studio"), EDGE)
    error = drain(gaussian_error(surface, diffuse, Known(chosen, fitted, diffuse.rows(chosen)), cube))
    return error.of(error.better)
