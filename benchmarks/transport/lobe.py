"""A frame of the lobe view while it is turned: lobes of 64 × 64 points in an image as large as the view can get."""

from __future__ import annotations

from functools import partial

import numpy as np

from benchmarks.measure import Measure, best_of
from engine.brdf.analysis import lobe
from engine.brdf.brdf import brdf_from_text
from engine.geometry.camera import Camera
from engine.gl.context import create_context, renderer_name
from engine.gl.lobe import LobeColours, LobeRenderer, LobeSurface

SIZE = (960, 640)
BRDFS = ("ggx:alpha=0.3", "phong:exponent=20", "lambert")
CAMERA = Camera((2.3, 1.5, 2.7), (0.0, 0.4, 0.0), fov_deg=32.0)
COLOURS = LobeColours((0.1, 0.1, 0.1), (0.4, 0.4, 0.4), (1.0, 0.9, 0.7))
LIGHT = (np.pi / 4.0, np.pi)


def gl_lobe() -> Measure:
    """A frame of one lobe against clearing the image and drawing its lines."""
    with create_context() as context:
        renderer = LobeRenderer(context)
        target = context.simple_framebuffer(SIZE)
        surfaces = [_surface(text) for text in BRDFS]

        def draw(what: list[LobeSurface]) -> None:
            renderer.draw(target, what, LIGHT, CAMERA, COLOURS)
            context.finish()

        one, none = surfaces[:1], surfaces[:0]
        time_s, three_s, limit_s = (best_of(partial(draw, what), 25) for what in (one, surfaces, none))
        more = {
            "frames_per_s": 1.0 / time_s,
            "frames_per_s_of_three": 1.0 / three_s,
            "renderer": renderer_name(context),
        }
        renderer.release()
        target.release()
    return Measure("gl-lobe", time_s, limit_s, "clearing and lines alone", more)


def _surface(text: str) -> LobeSurface:
    wo, value = lobe(brdf_from_text(text), LIGHT[0], LIGHT[1])
    points = wo * (value.max(axis=-1) / value.max())[..., None]
    angles = np.stack(np.meshgrid(np.linspace(0.0, 90.0, 64), np.linspace(0.0, 360.0, 64), indexing="ij"), axis=-1)
    return LobeSurface(points.astype(np.float32), angles.astype(np.float32), (0.3, 0.6, 0.9))
