"""Measuring what frames take: at least, for each vertex, for each pixel, and for each light, term, lobe or harmonic.

Spheres of few and of many vertices are drawn into small and large images at two values of each mode's parameter, and
once from so far away that nothing is covered. The parts of a frame that explain these times best, none below 0, are
found by least squares of relative errors.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls

from engine.brdf.brdf import brdf_from_text
from engine.core.errors import MissingCapability
from engine.core.steps import Step, Steps, drain
from engine.core.stopwatch import shortest
from engine.geometry.camera import Camera, frame
from engine.geometry.mesh import Mesh
from engine.geometry.ray_caster import caster_of
from engine.gl.context import create_context, renderer_name
from engine.light.environment_file import open_environment
from engine.planning.costs.cost_model import ON_CPU, PARTS
from engine.planning.costs.load import Rates, shade
from engine.planning.costs.planned import planning_of
from engine.render.direct import radiance
from engine.render.transported import image_of
from engine.scene.scene import Scene
from engine.transport.method import METHODS
from engine.transport.relight import RelightTransport

#: Vertices of the small and the large mesh, and sides of the small and the large image.
FEW, MANY, SMALL, LARGE = 1_000, 6_000, 128, 320

#: Lights at which frames without a bake are measured.
LIGHTS = (4, 40)

#: Most frames that are timed after one that warms up, and the seconds after which no further one begins.
FRAMES, ENOUGH_S = 16, 0.1

#: A function that draws a scene, or light on a bake, with a camera into an image of so many pixels a side.
Draw = Callable[[Any, Camera, int], None]


def frame_rates(tables: dict[str, Rates]) -> Steps[str]:
    """Fill the tables of frames; the name of what draws, "processor" where there is no OpenGL."""
    meshes = round_mesh(FEW), round_mesh(MANY)
    camera = frame(meshes[0].positions)
    shown = shade(caster_of(meshes[0]), camera)
    with drawing_frames((SMALL, LARGE)) as (name, draw):
        plain = make_lit_scene(LIGHTS[0], meshes[0])
        far = replace(camera, eye=tuple(1e3 * np.array(camera.eye)))
        small_s, large_s = (_frame_s(draw, plain, far, side) for side in (SMALL, LARGE))
        empty_s = max(0.0, large_s - small_s) / (LARGE**2 - SMALL**2)
        tables["frame-pixel"] = ((1.0, empty_s),)
        kinds = _kinds()
        for number, (kind, parameters, drawn) in enumerate(kinds):
            yield Step(number / len(kinds), f"measuring frames, {kind}")
            rows, times = [], []
            for parameter in parameters:
                few, many = (drawn(parameter, mesh) for mesh in meshes)
                for what, side in ((few, SMALL), (few, LARGE), (many, SMALL)):
                    pixels, vertices = side * side, len(what.mesh.positions)
                    rows.append([1.0, vertices, vertices * parameter, shown * pixels, shown * pixels * parameter])
                    times.append(max(_frame_s(draw, what, camera, side) - empty_s * pixels, 1e-7))
            for name_of_part, seconds in zip(PARTS, _parts(np.array(rows), np.array(times)), strict=True):
                tables[f"{kind}-{name_of_part}"] = ((1.0, seconds),)
    return name


def _parts(rows: NDArray[np.float64], times: NDArray[np.float64]) -> list[float]:
    """Share of each column in the `times`, by least squares of relative errors, none below 0."""
    relative = rows / times[:, None]
    size = np.linalg.norm(relative, axis=0)
    found, _ = nnls(relative / size, np.ones(len(times)))
    return [float(value) for value in found / size]


def _frame_s(draw: Draw, what: RelightTransport | Scene, camera: Camera, side: int) -> float:
    return shortest(lambda: draw(what, camera, side), FRAMES, ENOUGH_S)


@contextmanager
def drawing_frames(sides: tuple[int, ...]) -> Iterator[tuple[str, Draw]]:
    """The name of what draws, "processor" without OpenGL, and how, into images with these `sides` in pixels."""
    from engine.gl.direct import DirectRenderer
    from engine.gl.transported import TransportRenderer

    try:
        made = create_context()
    except MissingCapability:
        yield ON_CPU, _on_cpu
        return
    with made as context:
        direct, transported = DirectRenderer(context), TransportRenderer(context)
        targets = {side: context.framebuffer([context.renderbuffer((side, side))]) for side in sides}

        def draw(what: RelightTransport | Scene, camera: Camera, side: int) -> None:
            if isinstance(what, Scene):
                direct.draw(replace(what, camera=camera), targets[side], (side, side), samples=1)
            else:
                transported.draw(what, camera, targets[side], (side, side), samples=1)
            context.finish()

        try:
            yield renderer_name(context), draw
        finally:
            for owner in (direct, transported, *targets.values()):
                owner.release()


def _on_cpu(what: RelightTransport | Scene, camera: Camera, side: int) -> None:
    if isinstance(what, Scene):
        drain(radiance(replace(what, camera=camera), (side, side), samples=1))
    else:
        drain(image_of(what, camera, (side, side), 1))


def round_mesh(vertices: int) -> Mesh:
    """A sphere of about so many vertices."""
    rows = max(2, round(math.sqrt(vertices / 2.0)))
    theta, phi = np.meshgrid(np.linspace(1e-3, np.pi - 1e-3, rows), np.linspace(0, 2 * np.pi, 2 * rows), indexing="ij")
    points = np.stack([np.sin(theta) * np.sin(phi), np.cos(theta), np.sin(theta) * np.cos(phi)], axis=-1)
    index = np.arange(2 * rows * rows).reshape(rows, 2 * rows)
    a, b, c, d = index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]
    faces = np.stack([np.stack([a, b, c], -1), np.stack([a, c, d], -1)], axis=2).reshape(-1, 3).astype(np.int32)
    uv = np.stack([phi / 3.0, theta / 3.0], axis=-1).reshape(-1, 2).astype(np.float32)
    points = points.reshape(-1, 3)
    return Mesh(points, points.astype(np.float32), uv, faces, "sphere")


#: A kind of frame, the parameters at which it is measured, and what is drawn at one on a mesh.
Kind = tuple[str, tuple[int, ...], Callable[[int, Mesh], "RelightTransport | Scene"]]


def _kinds() -> list[Kind]:
    """All kinds of frames."""
    found: list[Kind] = [("direct", LIGHTS, make_lit_scene)]
    for method in METHODS:
        planning = planning_of(method.name)
        found += [(kind, parameters, partial(planning.draw, kind)) for kind, parameters in method.frames.items()]
    return found


def make_lit_scene(lights: int, mesh: Mesh) -> Scene:
    """So many lights, in front of the model or above it, as usual."""
    brdf = brdf_from_text("ggx:kd=0.5,alpha=0.3,f0=0.04")
    return Scene(mesh, frame(mesh.positions), brdf, environment=open_environment("studio"), directions=lights)
