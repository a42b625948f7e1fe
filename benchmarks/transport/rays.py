"""Rays against a mesh: occlusion beside Mitsuba's on the same rays, and what vertices see beside its rays alone."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.measure import Accuracy, Measure, best_of
from engine.core.errors import MissingCapability
from engine.core.steps import Step, Steps
from engine.geometry.mesh import Mesh
from engine.geometry.ray_caster import offset_origins
from engine.geometry.shapes import shape
from engine.light.cube_map import cube_directions
from engine.transport.baking.visibility import (
    DIRECTIONS,
    Receivers,
    miss_rate,
    occlusion,
    receivers,
    visibility_cube,
)

RAYS = 1 << 20

#: Built-in models that are closed, and how many rays are cast inside each.
CLOSED, MISSING_RAYS = ("sphere", "torus-knot"), 1_000_000


def rays_occluded() -> Measure:
    """A million rays from vertices of the torus knot, 256 from each, anywhere above the horizon.

    The limit is Mitsuba's `ray_test` (llvm_ad_rgb) on the same rays; embree's robust mode, which Mitsuba leaves off,
    takes a fourth longer.
    """
    mesh = shape("torus-knot")
    of = receivers(mesh)
    rng = np.random.default_rng(0)
    vertex = rng.integers(0, len(of), RAYS // 256).repeat(256)
    direction = rng.normal(size=(RAYS, 3)).astype(np.float32)
    direction *= np.sign(np.einsum("ni,ni->n", direction, of.normal[vertex]))[:, None]
    direction /= np.linalg.norm(direction, axis=1)[:, None]
    origin = offset_origins(mesh.positions[vertex], of.normal[vertex], of.caster).astype(np.float32)
    limit_s = best_of(_mitsuba(mesh, origin, direction))
    time_s = best_of(partial(of.caster.occluded, origin, direction))
    more = {"rays": RAYS, "rays_per_s": RAYS / time_s, "share_of_rate": limit_s / time_s}
    return Measure("rays-occluded", time_s, limit_s, "Mitsuba's ray_test on the same rays, not robust", more)


def ray_misses(_folder: Path) -> Steps[list[Accuracy]]:
    """Rays in a million that leave a closed model unnoticed, half of them aimed at its vertices and edges."""
    found: list[Accuracy] = []
    for name in CLOSED:
        yield Step(len(found) / len(CLOSED), f"casting rays inside {name}")
        misses = 1e6 * miss_rate(shape(name), MISSING_RAYS)
        found.append(Accuracy(f"ray-misses-{name}", misses, "rays of a million that leave it unnoticed", 20.0))
    return found


def _mitsuba(mesh: Mesh, origin: Any, direction: Any) -> Any:
    try:
        import drjit
        import mitsuba

        mitsuba.set_variant("llvm_ad_rgb")
    except ImportError as error:
        raise MissingCapability("Mitsuba to compare rays with", f"Install mitsuba and LLVM ({error})") from None
    shape_of_mitsuba = mitsuba.Mesh("mesh", len(mesh.positions), len(mesh.faces))
    parameters = mitsuba.traverse(shape_of_mitsuba)
    parameters["vertex_positions"] = mesh.positions.astype(np.float32).ravel()
    parameters["faces"] = mesh.faces.astype(np.uint32).ravel()
    parameters.update()
    scene = mitsuba.load_dict({"type": "scene", "shape": shape_of_mitsuba})
    ray = mitsuba.Ray3f(mitsuba.Point3f(origin.T.copy()), mitsuba.Vector3f(direction.T.copy()))

    def test() -> None:
        drjit.eval(scene.ray_test(ray))
        drjit.sync_thread()

    return test


def occlusion_50k() -> Measure:
    """The coarse look from all 49,985 vertices of the torus knot, tree and offsets included."""
    mesh = shape("torus-knot")
    of = receivers(mesh)
    rng = np.random.default_rng(0)
    direction = rng.normal(size=(len(of) * DIRECTIONS, 3)).astype(np.float32)
    origin = of.origin.repeat(DIRECTIONS, axis=0)
    direction *= np.sign(np.einsum("ni,ni->n", direction, of.normal.repeat(DIRECTIONS, axis=0)))[:, None]
    limit_s = best_of(partial(of.caster.occluded, origin, direction), 3)
    time_s = best_of(lambda: occlusion(replace(mesh)), 3)  # a copy has no tree yet
    return Measure("occlusion-50k", time_s, limit_s, "as many rays alone", {"vertices": len(of), "rays": len(origin)})


def visibility_cubes() -> Measure:
    """Cube maps of 6 × 64² of every 100th vertex of the torus knot; the limit are the rays of the same directions."""
    of = receivers(shape("torus-knot"))
    vertices = np.arange(0, len(of), 100)
    directions = cube_directions(64).reshape(-1, 3).astype(np.float32)
    rays = [_rays(of, int(vertex), directions) for vertex in vertices]
    origin, direction = (np.concatenate(part) for part in zip(*rays, strict=True))
    limit_s = best_of(partial(of.caster.occluded, origin, direction, coherent=True), 3)
    time_s = best_of(lambda: list(visibility_cube(of, 64, vertices)), 3)
    more = {"vertices": len(vertices), "rays": len(origin), "vertices_per_s": len(vertices) / time_s}
    return Measure("visibility-cube", time_s, limit_s, "the same rays, row by row", more)


def _rays(of: Receivers, vertex: int, directions: Any) -> tuple[Any, Any]:
    above = directions[directions @ of.normal[vertex] > 0.0]
    return np.broadcast_to(of.origin[vertex], above.shape), above
