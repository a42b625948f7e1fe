"""Plans: how soon one is made, and what it saves where nothing is needed.

Errors of predicted costs against measured ones: seconds, and bytes of files and of memory.
"""

from __future__ import annotations

import math
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.measure import Accuracy, Measure, best_of
from engine.brdf.brdf import Brdf, brdf_from_text
from engine.core.errors import MissingCapability
from engine.core.figure_text import percent
from engine.core.steps import Step, Steps, drain
from engine.core.stopwatch import DISTURBED, background_load, read_clock, time_undisturbed
from engine.geometry.camera import frame
from engine.geometry.mesh import Mesh
from engine.geometry.shapes import grid_mesh, shape
from engine.light.environment import EnvironmentMap, texel_directions
from engine.light.environment_file import open_environment
from engine.planning import bake as bake_plan
from engine.planning.bake_group import Bake, relight_transport, settings_of
from engine.planning.costs.cost_model import CostModel
from engine.planning.costs.machine_profile import calibrate
from engine.planning.costs.setting import Setting
from engine.planning.plan import plan
from engine.render.reference import reference
from engine.scene.scene import Scene
from engine.selftest.light import sphere
from engine.tradeoff.point import FACTOR
from engine.tradeoff.predict import Predictions
from engine.transport import method as transport
from engine.transport.baking.visibility import receivers
from engine.transport.method import Subject
from engine.transport.relight import RelightTransport
from engine.transport.sh.lighting import project
from engine.transport.sh.transfer import products, texel_basis, transfer

BRDF, ANOTHER = "ggx:kd=0.5,alpha=0.3,f0=0.04", "ggx:kd=0.4,alpha=0.35,f0=0.05"


@cache
def costs() -> CostModel:
    return drain(calibrate())[0]


def plan_50k() -> Measure:
    """A plan for 50,000 vertices, once mesh and BRDF are known; against looking at all of them.

    Beside it the same for a BRDF that is new, and for a budget so small that every method has to be weighed.
    """
    mesh, light = shape("torus-knot"), open_environment("studio")
    known, new = brdf_from_text(BRDF), brdf_from_text(ANOTHER)

    def plan_once(brdf: Any, error: float) -> None:
        plan(mesh, brdf, light, cost=costs(), error=error)

    time_s = best_of(lambda: plan_once(known, 0.02), 3)
    limit_s = best_of(lambda: receivers(mesh), 3)
    started = time.perf_counter()
    plan_once(new, 0.02)
    more = {
        "vertices": len(mesh.positions),
        "target_s": 1.0,
        "new_reflectance_s": time.perf_counter() - started,
        "all_methods_s": best_of(lambda: plan_once(known, 0.001), 3),
    }
    return Measure("plan-50k", time_s, limit_s, "finding which vertices see their whole hemisphere", more)


def plan_convex() -> Measure:
    """The planned bake of a diffuse convex model under a smooth sky; against the bake with everything forced."""
    mesh, brdf = sphere(40), brdf_from_text("lambert:albedo=0.5")
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
    drain(drain(bake_plan.prepare(chosen, mesh, brdf)).start(path.with_suffix(".first")))
    ready = drain(bake_plan.prepare(chosen, mesh, brdf))
    started = time.perf_counter()
    baked = drain(ready.start(path))
    bake_s = time.perf_counter() - started
    transport = baked.transport
    rows = transfer(transport, project(sky, transport.order))
    from engine.transport.sh.transfer import sum_signed_radiance

    up = np.broadcast_to((0.0, 0.0, 1.0), (len(mesh.positions), 3))
    return bake_s, sum_signed_radiance(transport, rows, up, np.arange(len(mesh.positions)))


#: Rows of the balls that settings are baked of: some 800 vertices, and 200 of those for Gaussians.
ROWS, FEWER_ROWS = 14, 7

#: Every so many vertices of the cloth along both sides: some 6,600 stay.
EVERY = 3

#: Side of the images, and by how much the light is rotated, in rad.
SIDE, TURN = 256, 0.1

#: Side of the image of the reference, and samples of its pixels.
PATHS_SIDE, PATHS = 128, 16

#: A bake that takes longer is not done a second time.
LONG_S = 3.0

#: Marks a figure that was measured under background load.
MARK = "other programs had"


@dataclass(frozen=True, eq=False)
class _Place:
    """A model and its BRDF, and what is measured of it."""

    name: str
    mesh: Mesh
    brdf: Brdf
    settings: tuple[Setting, ...]
    depths: tuple[int, ...] = ()

    def scene(self, environment: EnvironmentMap) -> Scene:
        return Scene(self.mesh, frame(self.mesh.positions), self.brdf, environment=environment)


def cost_model(_folder: Path) -> Steps[list[Accuracy]]:
    """Deviation of predictions from measurements, as |log| of their ratio: 0.41 is a factor of 1.5.

    The last figure is the share of all that are farther off.
    """
    model, light = costs(), open_environment("studio")
    found: list[Accuracy] = []
    places = list(_places())
    whole = sum(len(place.settings) + len(place.depths) for place in places)
    for place in places:
        scene = place.scene(light)
        for depth, setting in _ask(place):
            yield Step(len({each.what.split(":")[1] for each in found}) / (whole + 1), f"{place.name}, {setting}")
            predictions = Predictions(model, scene, (SIDE, SIDE), 1, depth)
            load = replace(predictions.load, tables_made=False)
            if setting.mode == "reference":
                load = replace(load, pixels=PATHS_SIDE**2)
            expected = model.predict(setting, load.vertices, load.pixels, load=load)
            for name, (value, taken) in _measure(setting, scene, depth).items():
                found.append(_accuracy(place, setting, depth, name, getattr(expected, name), value, taken))
    outside = [each for each in found if each.error > math.log(FACTOR)]
    disturbed = sum(MARK in each.what for each in outside)
    words = f"share of {len(found)} figures that are off by more than a factor of {FACTOR:g}: {len(outside)} of them"
    words += f", {disturbed} while other programs worked" if disturbed else ""
    return [*found, Accuracy("cost-misses", len(outside) / len(found), words)]


def _ask(place: _Place) -> Iterator[tuple[int, Setting]]:
    yield from ((1, setting) for setting in place.settings)
    yield from ((depth, Setting("reference", {"samples": PATHS})) for depth in place.depths)


def _accuracy(
    place: _Place, setting: Setting, depth: int, name: str, expected: float, value: float, taken: float
) -> Accuracy:
    what = f"{setting}" + (f", depth {depth}" if setting.mode == "reference" else "")
    words = f"{place.name}: {what}: {name} predicted {expected:.4g}, measured {value:.4g}"
    words += f" ({MARK} {percent(taken)})" if taken > DISTURBED else ""
    return Accuracy(f"cost-{place.name}-{what}-{name}", abs(math.log(expected / value)), words)


def _places() -> Iterator[_Place]:
    """Convex parts that cut each other, few of them for Gaussians, and a concave cloth of many vertices."""
    glossy, diffuse = brdf_from_text(BRDF), brdf_from_text("lambert:albedo=0.5")
    many = (
        *(Setting("sh", {"order": order}) for order in (3, 5, 8, 12, 15)),
        *(Setting("sh", {"order": order, "interreflection": 1}) for order in (5, 8)),
        *(Setting("wavelet", {"terms": terms}) for terms in (1, 2, 4, 8)),
        *(Setting("wavelet", {"coefficients": kept}) for kept in (24, 384)),
        *(Setting("wavelet", {"cube": cube}) for cube in (16, 32)),
        *(Setting("direct", {"directions": lights}) for lights in (16, 64)),
    )
    lobes = (
        *(Setting("gaussian", {"lobes": lobes}) for lobes in (1, 2, 3)),
        Setting("gaussian", {"interreflection": 1}),
    )
    yield _Place("balls", _spheres(ROWS), glossy, many, (1, 3))
    yield _Place("few balls", _spheres(FEWER_ROWS), glossy, lobes)
    large = (Setting("sh"), Setting("wavelet", {"terms": 2, "cube": 16}), Setting("direct", {"directions": 16}))
    yield _Place("cloth", _cloth(), glossy, large, (1, 3))
    yield _Place("diffuse cloth", _cloth(), diffuse, (Setting("sh", {"order": 8}),))


def _spheres(rows: int) -> Mesh:
    """Two spheres that cut each other."""
    one = sphere(rows)
    points = np.concatenate([one.positions, 0.5 * one.positions + np.array([1.3, 0.4, 0.0])])
    faces = np.concatenate([one.faces, one.faces + np.int32(len(one.positions))])
    return Mesh(points, np.concatenate([one.normals] * 2), np.concatenate([one.uv] * 2), faces, "balls")


def _cloth() -> Mesh:
    """The built-in cloth with fewer vertices."""
    whole = shape("cloth")
    side = math.isqrt(len(whole.positions))
    positions, normals, uv = (
        np.asarray(array, np.float64).reshape(side, side, -1)[::EVERY, ::EVERY]
        for array in (whole.positions, whole.normals, whole.uv)
    )
    return grid_mesh("cloth", positions, normals, uv)


#: A figure, and the share of the CPUs that other programs had while it was measured.
Figure = tuple[float, float]


def _measure(setting: Setting, scene: Scene, depth: int) -> dict[str, Figure]:
    """Figures of `Cost` by name: a frame where there is OpenGL, and of a bake all the others too."""
    if setting.mode == "reference":
        size = (PATHS_SIDE, PATHS_SIDE)
        draw = lambda: drain(reference(scene, size, samples=setting["samples"], max_depth=depth))  # noqa: E731
        return {"frame_s": time_undisturbed(draw)}
    if setting.mode == "direct":
        return _frame_s(replace(scene, directions=setting["directions"]))
    with tempfile.TemporaryDirectory() as folder:
        before = read_clock()
        baked = _bake(setting, scene, Path(folder))
        taken = background_load(before, read_clock())
        own = Bake(setting, baked.transport, baked.bake_s, 0, baked.file.size_bytes)
        rotated = replace(scene, environment_rotation=TURN)
        light = relight_transport(own, rotated)
        return {
            "bake_s": (baked.bake_s, taken),
            "size_bytes": (float(baked.file.size_bytes), 0.0),
            "memory_bytes": (float(_hold(baked, light)), 0.0),
            "relight_s": time_undisturbed(lambda: relight_transport(own, rotated)),
            **_frame_s(replace(scene, relit=light)),
        }


def _bake(setting: Setting, scene: Scene, folder: Path) -> Any:
    """The better of two bakes where they are short; tables of a process are made anew for each."""
    bake = _bake_of(setting, scene)
    best = None
    for number in range(3):
        products.cache_clear()
        texel_basis.cache_clear()
        started = time.perf_counter()
        made = drain(bake(folder / f"{number}.transport"))
        best = made if best is None or made.bake_s < best.bake_s else best
        if time.perf_counter() - started > LONG_S:
            break
    return best


def _bake_of(setting: Setting, scene: Scene) -> Callable[[Path], Steps[Any]]:
    baking = transport.method_of(setting.mode).baking
    work = drain(baking.prepare(Subject(scene.mesh, scene.brdf), settings_of(setting)))
    return lambda path: baking.bake(path, work)


def _hold(baked: Any, light: RelightTransport) -> int:
    """Bytes of the mesh, of the transport with its tables, and of the light in its rows."""
    mesh, arrays = baked.file.mesh, baked.file.arrays
    held = sum(array.nbytes for name, array in arrays.items() if name not in ("table", "chunk_bounds"))
    held += sum(array.nbytes for array in (mesh.positions, mesh.normals, mesh.uv, mesh.faces))
    if "table" in arrays:
        held += 2 * arrays["table"].nbytes
    return held + light.size_bytes


def _frame_s(scene: Scene) -> dict[str, Figure]:
    from engine.gl.context import create_context
    from engine.gl.direct import DirectRenderer
    from engine.gl.transported import TransportRenderer

    size, relit = (SIDE, SIDE), scene.relit
    try:
        with create_context() as context:
            target = context.framebuffer([context.renderbuffer(size)])
            renderer: Any = DirectRenderer(context) if relit is None else TransportRenderer(context)
            views = (scene,) if relit is None else (relit, scene.camera)

            def draw() -> None:
                renderer.draw(*views, target, size, samples=1)
                context.finish()

            figure = time_undisturbed(draw)
            renderer.release()
            target.release()
            return {"frame_s": figure}
    except MissingCapability:
        return {}
