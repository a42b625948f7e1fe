"""Plans: how soon one is made, and what it saves where nothing is needed."""

from __future__ import annotations

import tempfile
import time
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from engine.bench.measure import Measure, best_of
from engine.brdf.brdf import brdf_from_text
from engine.effects import bake as planned
from engine.effects.calibration import calibrate
from engine.effects.cost_model import CostModel
from engine.effects.plan import plan
from engine.environment import EnvironmentMap, texel_directions
from engine.environment_file import open_environment
from engine.selftest.light import ball
from engine.shapes import shape
from engine.steps import drain
from engine.transport.sh_lighting import project
from engine.transport.sh_transfer import transferred
from engine.transport.visibility import receivers

BRDF, ANOTHER = "ggx:kd=0.5,alpha=0.3,f0=0.04", "ggx:kd=0.4,alpha=0.35,f0=0.05"


@cache
def costs() -> CostModel:
    return drain(calibrate())


def plan_50k() -> Measure:
    """A plan for 50,000 vertices, once mesh and reflectance are known; against looking at all of them.

    Beside it the same for a reflectance that is new, and for a budget so small that every method has to be weighed.
    """
    mesh, light = shape("torus-knot"), open_environment("studio")
    known, new = brdf_from_text(BRDF), brdf_from_text(ANOTHER)

    def planned(brdf: Any, error: float) -> None:
        plan(mesh, brdf, light, cost=costs(), error=error)

    time_s = best_of(lambda: planned(known, 0.02), 3)
    limit_s = best_of(lambda: receivers(mesh), 3)
    started = time.perf_counter()
    planned(new, 0.02)
    more = {
        "vertices": len(mesh.positions),
        "target_s": 1.0,
        "new_reflectance_s": time.perf_counter() - started,
        "all_methods_s": best_of(lambda: planned(known, 0.001), 3),
    }
    return Measure("plan-50k", time_s, limit_s, "finding which vertices see their whole hemisphere", more)


def plan_convex() -> Measure:
    """The planned bake of a matt convex model under a smooth sky; against the bake with everything forced."""
    mesh, brdf = ball(40), brdf_from_text("lambert:albedo=0.5")
    y = texel_directions(64, 128)[..., 1:2]
    sky = EnvironmentMap(np.broadcast_to(1.0 + 0.6 * y, (64, 128, 3)).astype(np.float32), "smooth sky")
    forced = ("self-shadowing", "interreflection", "glossy", "anisotropy")
    lean = plan(mesh, brdf, sky, cost=costs(), error=0.05, modes=("sh",))
    full = plan(mesh, brdf, sky, cost=costs(), error=0.05, modes=("sh",), force=forced)
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


def _radiance(chosen: Any, mesh: Any, brdf: Any, sky: EnvironmentMap, path: Path) -> tuple[float, Any]:
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
