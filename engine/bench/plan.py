"""Plans: how soon one is made, what it saves where nothing is needed, and how near predictions come to the truth."""

from __future__ import annotations

import math
import tempfile
import time
from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from engine.bench.capture_truth import Accuracy
from engine.bench.measure import Measure, best_of
from engine.brdf.brdf import brdf_from_text
from engine.camera import frame
from engine.effects import bake as planned
from engine.effects.calibration import MAP_ROWS, calibrate, ray_scale
from engine.effects.cost_model import CostModel, Load
from engine.effects.plan import plan
from engine.effects.setting import Setting
from engine.environment import EnvironmentMap, texel_directions
from engine.environment_file import open_environment
from engine.mesh import Mesh
from engine.selftest.light import ball
from engine.shapes import shape
from engine.steps import Step, Steps, drain
from engine.transport import sh_bake, wavelet_bake
from engine.transport.sh_lighting import project
from engine.transport.sh_transfer import transferred
from engine.transport.visibility import receivers
from engine.transport.wavelet import relit
from engine.transport.wavelet_lighting import lighting_of

BRDF = "ggx:kd=0.5,alpha=0.3,f0=0.04"

#: Rows of the balls that settings are baked of to compare: some 700 vertices.
ROWS = 14


@cache
def _costs() -> CostModel:
    return drain(calibrate())


def plan_50k() -> Measure:
    """A plan for 50,000 vertices, once mesh and reflectance are known; against looking at all of them."""
    mesh, light, brdf, costs = shape("torus-knot"), open_environment("studio"), brdf_from_text(BRDF), _costs()
    time_s = best_of(lambda: plan(mesh, brdf, light, cost=costs, error=0.02), 3)
    limit_s = best_of(lambda: receivers(mesh), 3)
    more = {"vertices": len(mesh.positions), "target_s": 1.0}
    return Measure("plan-50k", time_s, limit_s, "finding which vertices see their whole hemisphere", more)


def plan_convex() -> Measure:
    """The planned bake of a matt convex model under a smooth sky; against the bake with everything forced."""
    mesh, brdf, costs = ball(40), brdf_from_text("lambert:albedo=0.5"), _costs()
    y = texel_directions(64, 128)[..., 1:2]
    sky = EnvironmentMap(np.broadcast_to(1.0 + 0.6 * y, (64, 128, 3)).astype(np.float32), "smooth sky")
    forced = ("self-shadowing", "interreflection", "glossy", "anisotropy")
    lean = plan(mesh, brdf, sky, cost=costs, error=0.05, modes=("sh",))
    full = plan(mesh, brdf, sky, cost=costs, error=0.05, modes=("sh",), force=forced)
    with tempfile.TemporaryDirectory() as folder:
        found = [_radiance(each, mesh, brdf, sky, Path(folder) / name) for name, each in (("a", lean), ("b", full))]
    (time_s, one), (limit_s, other) = found
    exact = 0.5 * (1.0 + 0.6 * 2.0 / 3.0 * np.repeat(mesh.normals[:, 1:2].astype(float), 3, axis=1))
    errors = [float(np.sqrt(((value - exact) ** 2).sum() / (exact**2).sum())) for value in (one, other)]
    more = {
        "vertices": len(mesh.positions),
        "error_difference_rel": abs(errors[0] - errors[1]),
        "error_rmse_rel": errors[0],
        "target_ratio": 0.05,
        "target_error_difference_rel": 1e-6,
    }
    return Measure("plan-convex", time_s, limit_s, "the same with every effect forced on", more)


def _radiance(chosen: Any, mesh: Mesh, brdf: Any, sky: EnvironmentMap, path: Path) -> tuple[float, Any]:
    """Seconds of the bake, the second time, and the radiance of all vertices towards their normals."""
    drain(drain(planned.prepare(chosen, mesh, brdf)).start(path.with_suffix(".first")))
    ready = drain(planned.prepare(chosen, mesh, brdf))
    started = time.perf_counter()
    baked = drain(ready.start(path))
    bake_s = time.perf_counter() - started
    transport = baked.transport
    rows = transferred(transport, project(sky, transport.order))
    from engine.transport.sh_transfer import signed_radiance

    up = np.broadcast_to((0.0, 0.0, 1.0), (len(mesh.positions), 3))
    return bake_s, signed_radiance(transport, rows, up, np.arange(len(mesh.positions)))


def cost_model(_folder: Path) -> Steps[list[Accuracy]]:
    """How far predicted bakes, lights and frames are from what is then measured, as |log| of their ratio, by setting.

    A figure of 0.41 is a factor of 1.5.
    """
    costs = _costs()
    mesh, brdf = _balls(), brdf_from_text(BRDF)
    light = EnvironmentMap(np.random.default_rng(0).random((MAP_ROWS, 2 * MAP_ROWS, 3), np.float32))
    of = receivers(mesh)
    load = Load(len(mesh.positions), 256 * 256, len(mesh.faces), float(1.0 - np.mean(of.free)))
    load = replace(load, ray_scale=ray_scale(costs, of))
    found = []
    settings = list(_settings())
    for number, setting in enumerate(settings):
        yield Step(number / len(settings), f"measuring {setting}")
        predicted = costs.predict(setting, load.vertices, load.pixels, load=load)
        for name, seconds in _measured(setting, mesh, light, brdf).items():
            expected = getattr(predicted, name)
            words = f"{setting}: {name} predicted {expected:.4g}, measured {seconds:.4g}"
            found.append(Accuracy(f"cost-{setting}-{name}", abs(math.log(expected / seconds)), words))
    return found


def _settings() -> Iterator[Setting]:
    yield from (Setting("sh", {"order": order}) for order in (3, 5, 8, 12))
    yield from (Setting("wavelet", {"terms": terms}) for terms in (1, 2, 4, 8))
    yield from (Setting("wavelet", {"coefficients": kept}) for kept in (24, 384))
    yield from (Setting("wavelet", {"cube": cube}) for cube in (16, 32))


def _balls() -> Mesh:
    """Two spheres that cut each other."""
    one = ball(ROWS)
    points = np.concatenate([one.positions, 0.5 * one.positions + np.array([1.3, 0.4, 0.0])])
    faces = np.concatenate([one.faces, one.faces + np.int32(len(one.positions))])
    return Mesh(points, np.concatenate([one.normals] * 2), np.concatenate([one.uv] * 2), faces, "balls")


def _measured(setting: Setting, mesh: Mesh, light: EnvironmentMap, brdf: Any) -> dict[str, float]:
    """Seconds of a bake that is not the first, of a changed light, and of a frame where there is OpenGL."""
    with tempfile.TemporaryDirectory() as folder:
        if setting.mode == "sh":
            settings = sh_bake.BakeSettings(setting["order"], sh_bake.default_edge(setting["order"]))
            sh_work = drain(sh_bake.prepare(mesh, brdf, settings))
            baked: Any = drain(sh_bake.bake(Path(folder) / "a.transport", sh_work))

            def relight() -> Any:
                return transferred(baked.transport, project(light, setting["order"]))
        else:
            factors = drain(wavelet_bake.factors_for(brdf, setting["terms"]))
            wanted = wavelet_bake.BakeSettings(setting["cube"], setting["coefficients"])
            baked = drain(wavelet_bake.bake(Path(folder) / "a.transport", wavelet_bake.prepare(mesh, factors, wanted)))

            def relight() -> Any:
                return relit(baked.transport, lighting_of(light, setting["cube"]).light)

        relight_s = best_of(relight, 3)
        return {"bake_s": baked.bake_s, "relight_s": relight_s, **_frame_s(baked.transport, relight(), mesh)}


def _frame_s(transport: Any, rows: Any, mesh: Mesh) -> dict[str, float]:
    from engine.errors import MissingCapability
    from engine.gl.context import create_context
    from engine.gl.transported import TransportRenderer
    from engine.transport.lit import LitHarmonics, LitWavelets
    from engine.transport.sh_transfer import ShTransport

    lit = LitHarmonics(transport, rows) if isinstance(transport, ShTransport) else LitWavelets(transport, rows)
    camera, size = frame(mesh.positions), (256, 256)
    try:
        with create_context() as context:
            target = context.framebuffer([context.renderbuffer(size)])
            renderer = TransportRenderer(context)

            def draw() -> None:
                renderer.draw(lit, camera, target, size, samples=1)
                context.finish()

            frame_s = best_of(draw, 3)
            renderer.release()
            target.release()
            return {"frame_s": frame_s}
    except MissingCapability:
        return {}
