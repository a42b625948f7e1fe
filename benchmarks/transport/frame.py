"""A frame of a material on a model, through the same GL code as the window."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from benchmarks.measure import Measure, best_of
from engine.brdf.brdf import brdf_from_text
from engine.core.steps import drain
from engine.geometry.camera import frame
from engine.geometry.shapes import shape
from engine.gl.context import create_context
from engine.gl.direct import DirectRenderer
from engine.scene.material import Material
from engine.scene.scene import Scene, Source
from engine.shading.power_law import fit
from engine.shading.shading_map import ShadingMap

SIZE = (960, 600)


def gl_frame() -> Measure:
    """A frame from the compressed pair against the same model with the plain Phong model."""
    return _frame("gl-frame", "power-law")


def gl_frame_slices() -> Measure:
    """A frame from the slices against the same model with the plain Phong model."""
    return _frame("gl-frame-slices", "slices")


def _frame(name: str, source: Source) -> Measure:
    mesh = shape("sphere")
    plain = Scene(mesh, frame(mesh.positions, SIZE[0] / SIZE[1]), brdf_from_text("phong:exponent=20"))
    scene = replace(plain, material=woven(), source=source)
    with create_context() as context:
        renderer = DirectRenderer(context)
        target = context.framebuffer([context.renderbuffer(SIZE)])

        def draw(what: Scene) -> None:
            renderer.draw(what, target, SIZE, samples=1)
            context.finish()

        time_s = best_of(lambda: draw(scene))
        limit_s = best_of(lambda: draw(plain))
        renderer.release()
        target.release()
    return Measure(name, time_s, limit_s, "the same frame of the BRDF alone")


def woven(edge: int = 512) -> Material:
    """A material of noise that brightens from slice to slice, as slices (8, edge, edge, 3) and as a power law."""
    slices = np.random.default_rng(0).random((8, edge, edge, 3), np.float32)
    slices *= np.linspace(0.0, 1.0, 8, dtype=np.float32)[:, None, None, None]
    shading_map = ShadingMap(slices, 0.5, np.linspace(0.0, 0.5, 8))
    return Material(shading_map, drain(fit(shading_map)), elevation_deg=(10.0, 45.0, 80.0))
