"""Savings of a bake: baked light beside the reference renderer at the same error, and when the bake has paid off.

Seconds are those of the CPU over all threads, so that it does not matter what else the machine does. A changed
light is the same map rotated: for the bake, projecting it and working out what reaches every vertex; for the reference,
an image with as many samples as bring its error down to that of the baked image. Both errors are against a third
image of many samples and other random numbers, whose noise is taken off.

The scene is the bunny under Grace Cathedral where the folder of real data lies beside the project, and otherwise the
built-in bust under the built-in studio, as the figures say. Cost: some minutes, nearly all of it for the bake.
"""

from __future__ import annotations

import dataclasses
import functools
import math
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.measure import Measure
from engine.accuracy.compare import ErrorEstimate, error_against
from engine.brdf.brdf import brdf_from_text
from engine.core.steps import drain
from engine.figures.figure import COVERED, coarse_bust
from engine.geometry.camera import frame
from engine.geometry.shapes import open_mesh
from engine.gl.context import create_context
from engine.gl.transported import TransportRenderer
from engine.light.environment_file import open_environment
from engine.render.reference import ReferenceImage, reference
from engine.scene.scene import Scene
from engine.transport.method import Method, Subject, method_of
from engine.transport.relight import RelightTransport, light_of

DATA = Path(__file__).resolve().parents[3] / "shared" / "data"
BUNNY, GRACE = DATA / "mesh/classic/stanford-bunny.obj", DATA / "hdr/debevec/grace_probe_latlong.hdr"

BRDF = "ggx:kd=0.5,alpha=0.3,f0=0.04"

#: The window of Kautz2002, and the samples of the image that both are compared with.
SIZE, SAMPLES = (720, 760), 64

#: Radians between the light of one frame and of the next, and how many are timed.
TURN, FRAMES = 0.3, 5

#: Most samples of a reference that is timed.
MAXIMUM = 256

Image = NDArray[np.float32]


def transport_paid_off() -> Measure:
    """Wavelets of four terms: a changed light, against a reference image of the same error."""
    return measure("transport-paid-off", "wavelet", scene_of(BUNNY, GRACE))


def transport_paid_off_sh() -> Measure:
    """Spherical harmonics of order 5: the same."""
    return measure("transport-paid-off-sh", "sh", scene_of(BUNNY, GRACE))


def scene_of(mesh: Path, environment: Path) -> Scene:
    """The model in that file under the light of the other, or what is built in where either is absent."""
    there = mesh.exists() and environment.exists()
    model = open_mesh(str(mesh)) if there else coarse_bust(97, 145)
    light = open_environment(environment if there else "studio")
    camera = frame(model.positions, SIZE[0] / SIZE[1])
    return Scene(model, camera, brdf_from_text(BRDF), environment=light)


@dataclass(frozen=True, eq=False)
class Spent:
    """CPU seconds of a bake, of a changed light, of a whole frame under one, of one under the same light; an image."""

    bake_s: float
    light_s: float
    frame_s: float
    view_s: float
    image: Image


def measure(name: str, mode: str, scene: Scene, size: tuple[int, int] = SIZE, samples: int = SAMPLES) -> Measure:
    """CPU seconds for each changed light of a bake, against those of the reference at the error of the bake."""
    converged = drain(reference(scene, size, samples=samples, seed=1))
    spent = measure_spent_by(mode, scene, size)
    error = _error(spent.image, converged)
    reference_s, taken = equal_error_s(scene, size, converged, error.rmse_rel)
    saved_s = reference_s - spent.frame_s
    more = {
        "model": scene.mesh.name,
        "environment": scene.environment.name if scene.environment else None,
        "vertices": len(scene.mesh.positions),
        "width_px": size[0],
        "height_px": size[1],
        "error_rmse_rel": error.rmse_rel,
        "error_uncertainty": error.uncertainty,
        "reference_samples": taken,
        "light_speedup": reference_s / spent.light_s,
        "target_light_speedup": 50.0,
        "frame_cpu_s": spent.frame_s,
        "frame_speedup": reference_s / spent.frame_s,
        "target_frame_speedup": 20.0,
        "view_frame_cpu_s": spent.view_s,
        "bake_cpu_s": spent.bake_s,
        "break_even_frames": math.ceil(spent.bake_s / saved_s) if saved_s > 0.0 else None,
    }
    return Measure(name, spent.light_s, reference_s, "a reference image of the same error, CPU time of both", more)


def measure_spent_by(mode: str, scene: Scene, size: tuple[int, int]) -> Spent:
    """CPU time of a bake of `scene` and of its frames through OpenGL."""
    method = method_of(mode)
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder, create_context() as context:
        started = time.process_time()
        transport = _bake(method, Path(folder) / "bench.transport", scene)
        bake_s = time.process_time() - started
        renderer = TransportRenderer(context)
        target = context.framebuffer([context.renderbuffer(size)])

        def draw(relit: RelightTransport) -> None:
            renderer.draw(relit, scene.camera, target, size, samples=1)
            context.finish()

        light = functools.partial(_relight, method, transport)
        times = _cpu_s(scene, light, draw)
        image = renderer.radiance(light(scene), scene.camera, size, samples=2)
        renderer.release()
        target.release()
    return Spent(bake_s, *times, image)


def _bake(method: Method, path: Path, scene: Scene) -> Any:
    work = drain(method.baking.prepare(Subject(scene.mesh, scene.brdf), method.settings()))
    return drain(method.baking.bake(path, work)).transport


def _relight(method: Method, transport: Any, scene: Scene) -> RelightTransport:
    return method.baking.relight_transport(transport, light_of(scene), method.light())


def _cpu_s(
    scene: Scene, light: Callable[[Scene], RelightTransport], draw: Callable[[RelightTransport], None]
) -> tuple[float, float, float]:
    """CPU seconds of a changed light, of a whole frame under one, and of a frame under the light of the last.

    The least of several each; everything is compiled and uploaded before.
    """
    draw(light(scene))
    lights, frames, views = [], [], []
    for number in range(1, FRAMES + 1):
        rotated = dataclasses.replace(scene, environment_rotation=number * TURN)
        started = time.process_time()
        relit = light(rotated)
        changed = time.process_time()
        draw(relit)
        drawn = time.process_time()
        draw(relit)
        views.append(time.process_time() - drawn)
        lights.append(changed - started)
        frames.append(drawn - started)
    return min(lights), min(frames), min(views)


def _error(image: Image, converged: ReferenceImage) -> ErrorEstimate:
    mask = (image[..., 3] >= COVERED) & (converged.image[..., 3] >= COVERED)
    assert converged.variance is not None
    return error_against(image, converged.image, converged.variance, mask)


def equal_error_s(scene: Scene, size: tuple[int, int], converged: ReferenceImage, wanted: float) -> tuple[float, float]:
    """CPU seconds of a reference image whose error is `wanted`, and its samples, which need not be whole.

    Samples double until the error is as low; between the last two, logarithms of time and error are on a line. Where
    one sample is enough, its seconds count; where the most are not, the line through the last two goes on.
    """
    drain(reference(scene, size, samples=1, seed=2))
    last: tuple[float, float, int] | None = None
    samples = 1
    while True:
        started = time.process_time()
        image = drain(reference(scene, size, samples=samples, seed=3)).image
        spent = time.process_time() - started
        error = _error(image, converged).rmse_rel
        if last is not None and (error <= wanted or samples >= MAXIMUM):
            share = math.log(last[1] / wanted) / math.log(last[1] / error)
            taken = last[2] * (samples / last[2]) ** share
            return last[0] * (spent / last[0]) ** share, taken
        if error <= wanted:
            return spent, float(samples)
        last, samples = (spent, error, samples), 2 * samples
